// From requests to pictures: tiles, samples, lenses.
#include <algorithm>
#include <cmath>
#include <limits>

#include "lens.h"
#include "overlay.h"
#include "scene_renderer.h"
#include "srgb.h"

namespace cogrsim::osmesa {

namespace {

// Larger pictures are drawn in parts [pixel]: bounds memory, and the library's own limit is 16384.
constexpr int kTileSize = 2048;

/// How the samples of a pixel are had: the library's own, times several pixels.
struct Sampling {
  int samples = 1, across = 1, down = 1;
};

Sampling sampling_for(int wanted, int available) {
  if (wanted <= 1) return {1, 1, 1};
  if (available >= 4) return wanted <= 4 ? Sampling{4, 1, 1} : Sampling{4, 2, 1};
  return wanted <= 4 ? Sampling{1, 2, 2} : Sampling{1, 4, 2};
}

/// Means of `across` x `down` RGBA pixels, taken in linear light, into a picture from (column,
/// row).
void store_color(const std::vector<std::uint8_t>& rgba, const Sampling& sampling, int width,
                 int height, int column, int row, Image& out) {
  const auto stride = static_cast<std::size_t>(width * sampling.across) * 4;
  const bool direct = sampling.across == 1 && sampling.down == 1;
  const float share = 1.0F / static_cast<float>(sampling.across * sampling.down);
  for (int y = 0; y < height; ++y) {
    std::uint8_t* to = out.data.data() + 3 * (static_cast<std::size_t>(row + y) *
                                                  static_cast<std::size_t>(out.width) +
                                              static_cast<std::size_t>(column));
    const std::uint8_t* from = rgba.data() + static_cast<std::size_t>(y * sampling.down) * stride;
    for (int x = 0; x < width; ++x, to += 3) {
      if (direct) {
        to[0] = from[4 * x];
        to[1] = from[4 * x + 1];
        to[2] = from[4 * x + 2];
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        float sum = 0.0F;
        for (int j = 0; j < sampling.down; ++j) {
          for (int i = 0; i < sampling.across; ++i) {
            sum += decode(from[static_cast<std::size_t>(j) * stride +
                               static_cast<std::size_t>(4 * (x * sampling.across + i) + k)]);
          }
        }
        to[k] = encode(sum * share);
      }
    }
  }
}

}  // namespace

Result<Picture> SceneRenderer::take_picture(const RenderRequest& request) {
  // Labels are written upon the finished picture, and must know what hides them.
  const bool labels = request.color && !request.overlay.labels.empty();
  RenderRequest drawn = request;
  drawn.depth = request.depth || labels;
  Result<Picture> picture = take_bent_picture(drawn);
  if (!picture || !labels) return picture;
  write_labels(request.overlay.labels, request.camera, picture->depth, picture->color);
  if (!request.depth) picture->depth = {};
  return picture;
}

Result<Picture> SceneRenderer::take_bent_picture(const RenderRequest& request) {
  if (!has_distortion(request.camera)) return take_straight_picture(request);
  auto known = std::find_if(bendings_.begin(), bendings_.end(),
                            [&](const auto& bending) { return bending->serves(request.camera); });
  if (known == bendings_.end()) {
    Result<Bending> made = make_bending(request.camera);
    if (!made) return tl::unexpected<Error>(made.error());
    constexpr std::size_t kBendingsKept = 8;
    if (bendings_.size() == kBendingsKept) bendings_.pop_back();
    known = bendings_.insert(bendings_.begin(), std::make_unique<Bending>(std::move(*made)));
  }
  const Bending& bending = **known;
  RenderRequest straight = request;
  straight.camera = bending.straight;
  straight.camera.X_WC = request.camera.X_WC;
  straight.camera.near = request.camera.near;
  straight.camera.far = request.camera.far;
  Picture out;
  out.width = request.camera.width;
  out.height = request.camera.height;
  if (request.color) {
    straight.depth = straight.segmentation = false;
    out.color = bend_color(bending, take_straight_picture(straight).color);
  }
  if (request.depth || request.segmentation) {
    straight.color = false;
    straight.depth = request.depth;
    straight.segmentation = request.segmentation;
    // The nearest pixel is up to half a pixel aside; three for each make that a sixth.
    constexpr int kFiner = 3;
    Camera& camera = straight.camera;
    if (std::int64_t{kFiner * kFiner} * camera.width * camera.height <= kMaxImagePixels) {
      camera.width *= kFiner;
      camera.height *= kFiner;
      for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value *= kFiner;
    }
    bend_data(bending, take_straight_picture(straight), out);
  }
  return out;
}

Picture SceneRenderer::take_straight_picture(const RenderRequest& request) {
  const View whole = make_view(request.camera);
  Picture out;
  out.width = whole.width;
  out.height = whole.height;
  const auto count = static_cast<std::size_t>(whole.width) * static_cast<std::size_t>(whole.height);
  if (request.color) {
    out.color.width = whole.width;
    out.color.height = whole.height;
    out.color.data.resize(3 * count);
  }
  if (request.depth) out.depth.resize(count);
  if (request.segmentation) out.bodies.resize(count);
  const Sampling sampling = sampling_for(request.samples, max_samples_);
  for (int row = 0; row < whole.height; row += kTileSize) {
    for (int column = 0; column < whole.width; column += kTileSize) {
      const int width = std::min(kTileSize, whole.width - column);
      const int height = std::min(kTileSize, whole.height - row);
      if (request.color) {
        const View tile =
            tile_of(whole, column, row, width, height, sampling.across, sampling.down);
        draw_color(tile, request, sampling.samples);
        rgba_.resize(4 * static_cast<std::size_t>(tile.width) *
                     static_cast<std::size_t>(tile.height));
        read_color(tile, sampling.samples, rgba_.data());
        store_color(rgba_, sampling, width, height, column, row, out.color);
      }
      if (!request.depth && !request.segmentation) continue;
      const View tile = tile_of(whole, column, row, width, height, 1, 1);
      data_.resize(2 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
      draw_data(tile, request, data_.data());
      for (int y = 0; y < height; ++y) {
        const float* from =
            data_.data() + 2 * static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        const std::size_t to =
            static_cast<std::size_t>(row + y) * static_cast<std::size_t>(whole.width) +
            static_cast<std::size_t>(column);
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
          if (request.depth) out.depth[to + x] = from[2 * x];
          if (request.segmentation) out.bodies[to + x] = static_cast<std::int32_t>(from[2 * x + 1]);
        }
      }
    }
  }
  return out;
}

}  // namespace cogrsim::osmesa
