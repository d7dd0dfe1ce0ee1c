#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "../support/temporary_folder.h"
#include "targets.h"

namespace cogrsim::fuzz {

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "what must hold does not: %s\n", what);
  std::abort();
}

MemoryFile::MemoryFile(std::string_view bytes)
    : descriptor_(::memfd_create("cogrsim-fuzz", MFD_CLOEXEC)) {
  require(descriptor_ >= 0, "a file in memory can be made");
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    require(written > 0, "a file in memory can be written");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

MemoryFile::~MemoryFile() { ::close(descriptor_); }

std::string MemoryFile::path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

const std::string& scratch_folder() {
  static const test::TemporaryFolder folder;
  static const std::string path = folder.path.string();
  return path;
}

}  // namespace cogrsim::fuzz
