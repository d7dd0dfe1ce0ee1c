// The two picture formats, each in a file of its own.
#pragma once

#include "cogrsim/core/image.h"

namespace cogrsim {

Result<Image> decode_png(std::string_view bytes);
Result<Image> decode_jpeg(std::string_view bytes);

/// Errors: a side that is not positive, or above kMaxImagePixels.
Result<> check_image_size(std::int64_t width, std::int64_t height);
/// Errors also: a number of channels that does not exist, or `data` of another length.
Result<> check_image(const Image& image);

}  // namespace cogrsim
