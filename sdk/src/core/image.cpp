#include "cogrsim/core/image.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "image_codecs.h"

namespace cogrsim {
namespace {

/// A compressed image of the largest accepted size is smaller than this [byte].
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;

std::string reason(int error) { return std::strerror(error); }

}  // namespace

Result<> check_image_size(std::int64_t width, std::int64_t height) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height) + " pixels";
  if (width <= 0 || height <= 0) return fail("a picture of " + size + " has no content");
  if (width > kMaxImagePixels || height > kMaxImagePixels / width)
    return fail("the picture has " + size + ", at most " +
                    std::to_string(kMaxImagePixels / 1'000'000) + " million are handled",
                "", "scale it down");
  return {};
}

Result<> check_image(const Image& image) {
  if (auto good = check_image_size(image.width, image.height); !good) return good;
  if (image.channels != 1 && image.channels != 3 && image.channels != 4)
    return fail("a picture has 1, 3 or 4 channels, not " + std::to_string(image.channels));
  const std::size_t wanted = static_cast<std::size_t>(image.width) *
                             static_cast<std::size_t>(image.height) *
                             static_cast<std::size_t>(image.channels);
  if (image.data.size() != wanted)
    return fail("a picture of this size has " + std::to_string(wanted) + " bytes, not " +
                std::to_string(image.data.size()));
  return {};
}

Result<Image> decode_image(std::string_view bytes) {
  if (bytes.empty()) return fail("the file is empty");
  if (bytes.substr(0, 4) == "\x89PNG") return decode_png(bytes);
  if (bytes.substr(0, 2) == "\xFF\xD8") return decode_jpeg(bytes);
  return fail("neither a PNG nor a JPEG file", "", "convert it to PNG");
}

Result<Image> load_image(const std::string& path) {
  const auto refuse = [&](const std::string& what) { return fail(what, path); };
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return refuse("cannot be opened: " + reason(errno));
  struct stat status {};
  if (::fstat(::fileno(file), &status) == 0 && S_ISDIR(status.st_mode)) {
    std::fclose(file);
    return refuse("is a folder");
  }
  std::string bytes;
  char buffer[1 << 16];
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, file)) {
    bytes.append(buffer, n);
    if (bytes.size() > kMaxFileBytes) break;
  }
  const int error = std::ferror(file) != 0 ? errno : 0;
  std::fclose(file);
  if (error != 0) return refuse("cannot be read: " + reason(error));
  if (bytes.size() > kMaxFileBytes) return refuse("is larger than 1 GiB");
  auto image = decode_image(bytes);
  if (!image && image.error().where.empty()) image.error().where = path;
  return image;
}

}  // namespace cogrsim
