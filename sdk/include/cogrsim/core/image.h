// Images in memory and in files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// An image with eight bits per channel, row 0 at the top, and interleaved channels.
struct Image {
  int width = 0, height = 0;       ///< [pixel]
  int channels = 3;                ///< 1: grey, 3: RGB, 4: RGBA
  std::vector<std::uint8_t> data;  ///< (height x width x channels), row-major, sRGB

  /// Pointer to the `channels` values of one pixel. The indices are not checked.
  const std::uint8_t* pixel(int column, int row) const {
    return data.data() + (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                          static_cast<std::size_t>(column)) *
                             static_cast<std::size_t>(channels);
  }
};

/// Upper limit on the size of every image that is read or created [pixel].
inline constexpr std::int64_t kMaxImagePixels = 64'000'000;

/// Decodes a PNG or JPEG file in memory; the first bytes determine the format. Sixteen-bit and
/// palette images are converted to eight bits. Errors: another format, damaged data, or more than
/// kMaxImagePixels pixels.
COGRSIM_API Result<Image> decode_image(std::string_view bytes);
/// Reads and decodes a PNG or JPEG file. Errors: as decode_image(), or the file cannot be read.
COGRSIM_API Result<Image> load_image(const std::string& path);

/// Encodes a PNG file. Errors: `channels` is not 1, 3 or 4, or `data` has the wrong length.
COGRSIM_API Result<std::string> encode_png(const Image& image);
/// Encodes a JPEG file with `quality` from 1 to 100; the alpha channel is dropped. Errors: as
/// encode_png(), `quality` is out of range, or a side is too long for the format.
COGRSIM_API Result<std::string> encode_jpeg(const Image& image, int quality = 90);
/// Encodes depth or label images without loss as a PNG file with one 16-bit channel. `data` has the
/// shape (height x width), row 0 at the top. Errors: `data` has the wrong length.
COGRSIM_API Result<std::string> encode_png16(int width, int height,
                                             const std::vector<std::uint16_t>& data);

}  // namespace cogrsim
