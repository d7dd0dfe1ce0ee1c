#include "output_file.h"

#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>

namespace cogrsim::cli {
namespace {

tl::unexpected<Error> cannot_write(const std::string& path, const std::string& reason) {
  return fail(fmt::format("cannot write '{}': {}", path, reason), "",
              "choose another file, or give it and its folder write permission");
}

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

// A device or a pipe cannot be replaced by a renamed file.
bool is_special(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

// A symbolic link stays one: what it points to is replaced.
std::string real_target(const std::string& path) {
  char* resolved = realpath(path.c_str(), nullptr);
  if (resolved == nullptr) return path;
  std::string target = resolved;
  std::free(resolved);
  return target;
}

Result<> write_all(const std::string& path, const char* mode, const std::string& text) {
  std::FILE* file = std::fopen(path.c_str(), mode);
  if (file == nullptr) return fail(std::strerror(errno));
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool flushed = std::fflush(file) == 0;
  const int reason = errno;
  if (std::fclose(file) != 0 || !written || !flushed) return fail(std::strerror(reason));
  return {};
}

}  // namespace

Result<> check_writable(const std::string& path) {
  if (path == "-") return {};
  if (path.empty()) return cannot_write(path, "the file name is empty");
  struct stat info {};
  if (stat(path.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode)) return cannot_write(path, "it is a folder");
    if (access(path.c_str(), W_OK) != 0) return cannot_write(path, std::strerror(errno));
    if (!S_ISREG(info.st_mode)) return {};
  }
  const std::string folder = folder_of(path);
  if (stat(folder.c_str(), &info) != 0) {
    return cannot_write(path, fmt::format("folder '{}': {}", folder, std::strerror(errno)));
  }
  if (!S_ISDIR(info.st_mode)) return cannot_write(path, fmt::format("'{}' is no folder", folder));
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    return cannot_write(path, fmt::format("folder '{}': {}", folder, std::strerror(errno)));
  }
  return {};
}

Result<> write_output(const std::string& path, const std::string& text) {
  if (path == "-") return print_output(text);
  if (const auto allowed = check_writable(path); !allowed) return allowed;
  if (is_special(path)) {
    if (const auto done = write_all(path, "w", text); !done) {
      return cannot_write(path, done.error().message);
    }
    return {};
  }
  const std::string target = real_target(path);
  const std::string temporary = fmt::format("{}.part-{}", target, getpid());
  // "x": never writes through something another program put there.
  if (const auto done = write_all(temporary, "wx", text); !done) {
    std::remove(temporary.c_str());
    return cannot_write(path, done.error().message);
  }
  if (std::rename(temporary.c_str(), target.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove(temporary.c_str());
    return cannot_write(path, reason);
  }
  return {};
}

Result<> print_output(const std::string& text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    return fail(fmt::format("cannot write to the standard output: {}", std::strerror(errno)));
  }
  return {};
}

}  // namespace cogrsim::cli
