// Pictures in memory and in files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// Eight bits per channel, row 0 at the top, channels interleaved.
struct Image {
  int width = 0, height = 0;       ///< [pixel]
  int channels = 3;                ///< 1: grey, 3: RGB, 4: RGBA
  std::vector<std::uint8_t> data;  ///< (height x width x channels), sRGB

  const std::uint8_t* pixel(int column, int row) const {
    return data.data() + (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                          static_cast<std::size_t>(column)) *
                             static_cast<std::size_t>(channels);
  }
};

/// No picture that is read or made is larger [pixel].
inline constexpr std::int64_t kMaxImagePixels = 64'000'000;

/// Reads a PNG or JPEG file from memory; what it is, is told by its first bytes. Sixteen-bit and
/// palette pictures are converted. Errors: neither of the two, damaged, or above kMaxImagePixels.
COGRSIM_API Result<Image> decode_image(std::string_view bytes);
/// The same from a file. Errors also: cannot be read.
COGRSIM_API Result<Image> load_image(const std::string& path);

COGRSIM_API Result<std::string> encode_png(const Image& image);
/// `quality` 1 to 100; alpha is dropped.
COGRSIM_API Result<std::string> encode_jpeg(const Image& image, int quality = 90);
/// Depth or labels without loss: one channel of 16 bits, `data` (height x width), row 0 at the top.
COGRSIM_API Result<std::string> encode_png16(int width, int height,
                                             const std::vector<std::uint16_t>& data);

}  // namespace cogrsim
