#include "local.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "common/terminal.h"

namespace cogrsim::share {

namespace fs = std::filesystem;

Result<TemporaryFolder> TemporaryFolder::make(const std::string& parent) {
  std::error_code error;
  const fs::path above = parent.empty() ? fs::temp_directory_path(error) : fs::path(parent);
  std::string pattern = (above / ".cogrsim-XXXXXX").string();
  if (error || mkdtemp(pattern.data()) == nullptr) {
    return fail(fmt::format("no folder can be made there: {}", std::strerror(errno)),
                above.string(), "is it yours, and is the disk full?");
  }
  return TemporaryFolder(pattern);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})) {}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Result<> move_to_free_name(const std::string& from, const std::string& to) {
  // A plain rename would replace a file, or an empty folder.
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return {};
  int why = errno;
  if (why == EINVAL || why == ENOSYS) {  // not every file system can do it in one go
    std::error_code error;
    if (fs::exists(fs::symlink_status(to, error))) {
      why = EEXIST;
    } else if (std::rename(from.c_str(), to.c_str()) == 0) {
      return {};
    } else {
      why = errno;
    }
  }
  if (why == EEXIST || why == ENOTEMPTY) return fail("is there already, and is not touched", to);
  return fail(fmt::format("cannot be made: {}", std::strerror(why)), to);
}

TransferProgress TransferLine::progress() {
  return [this](std::uint64_t done, std::uint64_t total) { show(done, total); };
}

void TransferLine::show(std::uint64_t done, std::uint64_t total) {
  if (!line_.due() && done != total) return;
  std::string line = title_ + "  " + cli::bytes_text(done);
  if (total > 0) {
    const double part = static_cast<double>(std::min(done, total)) / static_cast<double>(total);
    line = fmt::format("{}  {}  {} of {}", title_, cli::bar_text(part, 20), cli::bytes_text(done),
                       cli::bytes_text(total));
  }
  const auto width = static_cast<std::size_t>(std::max(20, cli::terminal_width(STDERR_FILENO) - 1));
  line_.show(cli::shortened(line, width));
}

}  // namespace cogrsim::share
