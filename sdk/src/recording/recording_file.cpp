#include "recording/recording_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

namespace cogrsim {

namespace {

namespace fs = std::filesystem;

std::string system_reason() { return std::strerror(errno); }

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Closes a descriptor and thereby releases its lock.
struct Descriptor {
  int number = -1;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

// Errors: another recorder holds the lock of the file `path`.
Result<> check_not_locked(const std::string& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  // A file that does not exist or cannot be read has no known lock.
  if (file.number < 0 || ::flock(file.number, LOCK_EX | LOCK_NB) == 0) return {};
  if (errno != EWOULDBLOCK) return {};
  return fail(fmt::format("'{}' is being written by another recorder", path), "",
              "wait for its end, or record to another file");
}

}  // namespace

Result<std::unique_ptr<RecordingFile>> RecordingFile::create(const std::string& path,
                                                             const OutputRules& rules) {
  if (auto allowed = check_output(path, OutputKind::recording, rules); !allowed) {
    return tl::unexpected(allowed.error());
  }
  const fs::path target = path;
  const auto cannot = [&](const std::string& why) {
    return fail(fmt::format("cannot record to '{}': {}", path, why));
  };
  if (auto free = check_not_locked(path); !free) return tl::unexpected(free.error());

  std::string temporary =
      (folder_of(target) / ("." + target.filename().string() + ".XXXXXX")).string();
  const int descriptor = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (descriptor < 0) return cannot(system_reason());
  // mkostemp creates files that only the owner can read; a recording has the usual permissions.
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(descriptor, 0666 & ~mask);
  ::flock(descriptor, LOCK_EX | LOCK_NB);
  return std::unique_ptr<RecordingFile>(new RecordingFile(path, rules, temporary, descriptor));
}

RecordingFile::~RecordingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<> RecordingFile::replace_target() {
  // Two recorders that start at the same time are serialised here.
  const Descriptor folder{::open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (folder.number >= 0) ::flock(folder.number, LOCK_EX);
  if (auto free = check_not_locked(path_); !free) return free;
  if (auto allowed = check_output(path_, OutputKind::recording, rules_); !allowed) return allowed;
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) {
    return fail(fmt::format("cannot record to '{}': {}", path_, system_reason()));
  }
  temporary_.clear();
  return {};
}

Result<> RecordingFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return fail(fmt::format("'{}' cannot be written: {}", path_, system_reason()));
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
  return {};
}

Result<> RecordingFile::cut(std::uint64_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0 ||
      ::lseek(descriptor_, static_cast<off_t>(size), SEEK_SET) < 0) {
    return fail(fmt::format("'{}' cannot be cut back: {}", path_, system_reason()));
  }
  return {};
}

Result<> RecordingFile::close() {
  if (descriptor_ < 0) return {};
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) return fail(fmt::format("'{}' cannot be written: {}", path_, system_reason()));
  return {};
}

}  // namespace cogrsim
