// Height fields of MJCF: pictures, MuJoCo's own files, and numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "assets/mesh_file.h"
#include "cogrsim/core/image.h"
#include "import/mjcf_reader.h"

namespace cogrsim::dsl::import {

namespace {

constexpr auto kMostHeights = static_cast<std::int64_t>(kMaxHeightSamples);

Result<> check_size(std::int64_t columns, std::int64_t rows) {
  if (columns < 2 || rows < 2 || columns > kMostHeights || rows > kMostHeights / columns)
    return fail(fmt::format("a height field has 2 by 2 to {} heights", kMostHeights));
  return {};
}

Result<HeightField> heights_of_file(Context& context, const std::string& bytes, const Source& at) {
  if (bytes.compare(0, 4, "\x89PNG") == 0) return heights_of_picture(context, bytes, at);
  HeightField field;
  // Two numbers of 32 bits, rows and columns, and floats, the row with the lowest y first.
  std::int32_t size[2] = {0, 0};
  if (bytes.size() >= sizeof size) std::memcpy(size, bytes.data(), sizeof size);
  if (auto good = check_size(size[1], size[0]); !good) return tl::unexpected(good.error());
  field.rows = size[0];
  field.columns = size[1];
  const auto columns = static_cast<std::size_t>(size[1]), rows = static_cast<std::size_t>(size[0]);
  if (bytes.size() != sizeof size + 4 * columns * rows)
    return fail("is neither a PNG nor a file of heights in MuJoCo's format");
  field.samples.resize(columns * rows);
  for (std::size_t i = 0; i < columns * rows; ++i) {
    float value = 0.0F;
    std::memcpy(&value, bytes.data() + sizeof size + 4 * i, sizeof value);
    if (!std::isfinite(value)) return fail("has heights that are not finite");
    field.samples[(rows - 1 - i / columns) * columns + i % columns] = value;
  }
  return field;
}

/// From 0 to 1, as MuJoCo scales them.
void normalize(HeightField& field) {
  const auto [least, most] = std::minmax_element(field.samples.begin(), field.samples.end());
  const double low = *least, range = *most - *least;
  for (double& h : field.samples) h = range > 0.0 ? (h - low) / range : 0.0;
}

}  // namespace

const Result<HeightFieldPtr>& HeightFiles::read(Context& context, const std::string& path,
                                                const Source& at, Reader reader,
                                                void (*scale)(HeightField&)) {
  const auto known = fields_.find(path);
  if (known != fields_.end()) return known->second;
  const auto load = [&]() -> Result<HeightFieldPtr> {
    const auto bytes = read_whole_file(path, context.options.limits.asset_bytes);
    if (!bytes) return tl::unexpected(bytes.error());
    auto field = reader(context, *bytes, at);
    if (!field) return tl::unexpected(field.error());
    scale(*field);
    return std::make_shared<const HeightField>(std::move(*field));
  };
  return fields_.emplace(path, load()).first->second;
}

Result<HeightField> heights_of_picture(Context& context, const std::string& bytes,
                                       const Source& at) {
  constexpr std::size_t kSizeAt = 16, kSizeEnd = 24;  // width and height, in the first chunk
  if (bytes.compare(0, 4, "\x89PNG") != 0 || bytes.size() < kSizeEnd) return fail("is no PNG");
  std::int64_t size[2] = {0, 0};
  for (std::size_t i = kSizeAt; i < kSizeEnd; ++i)
    size[i / 20] = size[i / 20] << 8 | static_cast<unsigned char>(bytes[i]);
  // A picture of a single colour is a thousand times smaller than its pixels.
  if (auto good = check_size(size[0], size[1]); !good) return tl::unexpected(good.error());
  context.spend(16 * static_cast<std::size_t>(size[0] * size[1]), at);
  auto image = decode_image(bytes);
  if (!image) return tl::unexpected(image.error());
  if (auto good = check_size(image->width, image->height); !good)
    return tl::unexpected(good.error());
  HeightField field;
  field.columns = image->width;
  field.rows = image->height;
  for (int r = 0; r < field.rows; ++r)
    for (int c = 0; c < field.columns; ++c) field.samples.push_back(*image->pixel(c, r));
  return field;
}

void MjcfReader::height_field(const XmlElement& source, const XmlElement& e,
                              const std::string& key) {
  const std::string* size = e.find("size");
  const auto extents =
      size == nullptr ? std::nullopt : context_.numbers(source, *size, 4, 4, "'size'");
  if (!extents || !(extents->at(0) > 0.0 && extents->at(1) > 0.0 && extents->at(2) > 0.0)) {
    context_.error(source.at, "CG1404", fmt::format("{} has no size", quoted_name(source)));
    return;
  }
  const HeightFieldPtr field = heights(source, e);
  if (field == nullptr) return;
  Geometry& g = height_fields_[key];
  g.type = Geometry::Type::heightmap;
  g.size = Vec3(2.0 * extents->at(0), 2.0 * extents->at(1), extents->at(2));
  g.heights = field;
  context_.exact(source.at, quoted_name(source), "its surface, without the base below it");
}

HeightFieldPtr MjcfReader::heights(const XmlElement& source, const XmlElement& e) {
  const auto left_out = [&](const std::string& why) {
    context_.left_out(source.at, quoted_name(source), why);
    return nullptr;
  };
  if (const std::string* file = e.find("file")) {
    auto path = context_.locate(mesh_dir_.empty() ? *file : mesh_dir_ + "/" + *file, source.at);
    if (!path) return left_out(path.error().message);
    const auto& field = height_files_.read(context_, *path, source.at, heights_of_file, normalize);
    return field ? *field : left_out(field.error().message);
  }
  const double columns = context_.number(e, "ncol", 0.0), rows = context_.number(e, "nrow", 0.0);
  if (!(columns >= 0.0 && columns < 1e9 && rows >= 0.0 && rows < 1e9))
    return left_out("nrow and ncol are no numbers of rows and columns");
  HeightField field;
  field.columns = static_cast<int>(columns);
  field.rows = static_cast<int>(rows);
  if (const auto good = check_size(field.columns, field.rows); !good)
    return left_out(good.error().message);
  const std::string* text = e.find("elevation");
  if (text == nullptr) {
    // Flat until a program fills it: the corners say as much.
    field.columns = field.rows = 2;
    field.samples.assign(4, 0.0);
    context_.approximate(source.at, quoted_name(source),
                         "has no heights in the file: it is flat here");
    return std::make_shared<const HeightField>(std::move(field));
  }
  const auto count = static_cast<std::size_t>(field.columns) * static_cast<std::size_t>(field.rows);
  auto values = context_.numbers(source, *text, count, count, "'elevation'");
  if (!values) return nullptr;
  field.samples = std::move(*values);
  normalize(field);
  return std::make_shared<const HeightField>(std::move(field));
}

}  // namespace cogrsim::dsl::import
