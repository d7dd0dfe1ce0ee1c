#include "cogrsim/core/image.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "image_codecs.h"

namespace cogrsim {
namespace {

/// A compressed picture of the largest size we read stays below this [byte].
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;

std::string reason(int error) { return std::strerror(error); }

/// Writes all of it and closes; 0 or the system's error number.
int write_and_close(int file, std::string_view bytes) {
  int error = 0;
  while (!bytes.empty() && error == 0) {
    const ssize_t n = ::write(file, bytes.data(), bytes.size());
    if (n > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(n));
    } else if (n == 0 || errno != EINTR) {
      error = n == 0 ? ENOSPC : errno;
    }
  }
  // Some file systems tell only here that there was no room.
  if (::close(file) != 0 && error == 0) error = errno;
  return error;
}

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

Result<> write_file(const std::string& path, std::string_view bytes) {
  const auto refuse = [&](int error) { return fail("cannot be written: " + reason(error), path); };
  // A link stays a link: what it points to is replaced.
  std::string target = path;
  if (char* const real = ::realpath(path.c_str(), nullptr)) {
    target = real;
    std::free(real);
  }
  struct stat status {};
  const bool exists = ::stat(target.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return refuse(EISDIR);
  if (exists && !S_ISREG(status.st_mode)) {
    // A pipe or a device cannot be replaced, it is written to.
    const int file = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
    if (file < 0) return refuse(errno);
    const int error = write_and_close(file, bytes);
    if (error != 0) return refuse(error);
    return {};
  }
  static std::atomic<unsigned> count{0};
  const std::string beside =
      target + "." + std::to_string(::getpid()) + "-" + std::to_string(count++) + ".part";
  const int file = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC,
                          exists ? status.st_mode & 0777 : 0666);
  if (file < 0) return refuse(errno);
  int error = write_and_close(file, bytes);
  if (error == 0 && std::rename(beside.c_str(), target.c_str()) != 0) error = errno;
  if (error == 0) return {};
  ::unlink(beside.c_str());
  return refuse(error);
}

}  // namespace cogrsim
