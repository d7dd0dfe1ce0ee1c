// The two image formats, each implemented in a file of its own.
#pragma once

#include "cogrsim/core/image.h"

namespace cogrsim {

Result<Image> decode_png(std::string_view bytes);
Result<Image> decode_jpeg(std::string_view bytes);

/// Checks the size of an image. Errors: a side is not positive, or more than kMaxImagePixels
/// pixels.
Result<> check_image_size(std::int64_t width, std::int64_t height);
/// Checks a whole image. Errors: as above, or an invalid number of channels or length of `data`.
Result<> check_image(const Image& image);

}  // namespace cogrsim
