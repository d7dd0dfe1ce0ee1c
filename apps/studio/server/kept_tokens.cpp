#include "kept_tokens.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string_view>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "descriptor.h"
#include "token.h"
#include "user_folders.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::time_t kDay = 24 * 60 * 60;  // [s]
constexpr std::size_t kToken = 32;          // digits
// "operator\nviewer\n"
constexpr std::size_t kContent = 2 * (kToken + 1);

tl::unexpected<Error> failed(const std::string& what, const std::string& where) {
  return fail(what + ": " + std::strerror(errno), where);
}

/// A folder in another one, made if it is not there, that only this user can read.
Result<Descriptor> private_folder(int parent, const char* name, const std::string& path) {
  if (::mkdirat(parent, name, 0700) != 0 && errno != EEXIST) {
    return failed("the folder cannot be made", path);
  }
  Descriptor folder(::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (folder < 0) return failed("this is not a folder that can be opened", path);
  struct stat about {};
  if (::fstat(folder, &about) != 0) return failed("the folder cannot be read", path);
  if (about.st_uid != ::geteuid()) return fail("the folder is another user's", path);
  if ((about.st_mode & 077) != 0 && ::fchmod(folder, 0700) != 0) {
    return failed("the folder is open to others", path);
  }
  return folder;
}

Result<Descriptor> tokens_folder(const std::string& base) {
  std::error_code error;
  fs::create_directories(base, error);
  if (error) return fail("the folder cannot be made: " + error.message(), base);
  const Descriptor top(::open(base.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (top < 0) return failed("this is not a folder that can be opened", base);
  const auto ours = private_folder(top, "cogrsim", base + "/cogrsim");
  if (!ours) return tl::unexpected(ours.error());
  return private_folder(*ours, "studio", base + "/cogrsim/studio");
}

/// nullopt: there is no file, or none that is trusted.
std::optional<KeptTokens> read_tokens(int folder, const std::string& name, bool of_any_age) {
  const Descriptor file(
      ::openat(folder, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat about {};
  if (file < 0 || ::fstat(file, &about) != 0) return std::nullopt;
  // time() may lag behind the clock that files are stamped by.
  struct timespec now {};
  ::clock_gettime(CLOCK_REALTIME, &now);
  const std::time_t age = now.tv_sec - about.st_mtime;
  if (!S_ISREG(about.st_mode) || about.st_uid != ::geteuid() || (about.st_mode & 077) != 0 ||
      about.st_nlink != 1 || about.st_size != static_cast<off_t>(kContent)) {
    return std::nullopt;
  }
  if (!of_any_age && (age < 0 || age > kDay)) return std::nullopt;
  std::array<char, kContent> bytes{};
  if (::read(file, bytes.data(), bytes.size()) != static_cast<ssize_t>(kContent)) {
    return std::nullopt;
  }
  const std::string_view text(bytes.data(), bytes.size());
  const std::string_view first = text.substr(0, kToken), second = text.substr(kToken + 1, kToken);
  const auto good = [](std::string_view token) {
    return token.find_first_not_of("0123456789abcdef") == std::string_view::npos;
  };
  if (!good(first) || !good(second) || first == second || text[kToken] != '\n' ||
      text.back() != '\n') {
    return std::nullopt;
  }
  return KeptTokens{std::string(first), std::string(second)};
}

}  // namespace

std::string kept_tokens_base() {
  const std::string runtime = user_folder("XDG_RUNTIME_DIR");
  return runtime.empty() ? user_state_folder() : runtime;
}

Result<KeptTokens> kept_tokens(const std::string& base, const std::string& name) {
  const auto folder = tokens_folder(base);
  if (!folder) return tl::unexpected(folder.error());
  if (auto found = read_tokens(*folder, name, false)) {
    keep_tokens(base, name);
    return *found;
  }
  KeptTokens fresh;
  for (std::string* token : {&fresh.operator_token, &fresh.viewer_token}) {
    auto made = new_token();
    if (!made) return tl::unexpected(made.error());
    *token = std::move(*made);
  }
  const std::string path = base + "/cogrsim/studio/" + name;
  if (::unlinkat(*folder, name.c_str(), 0) != 0 && errno != ENOENT) {
    return failed("what is there cannot be removed", path);
  }
  const Descriptor file(
      ::openat(*folder, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (file < 0) return failed("the file cannot be made", path);
  const std::string text = fresh.operator_token + "\n" + fresh.viewer_token + "\n";
  if (::write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    const auto error = failed("the file cannot be written", path);
    ::unlinkat(*folder, name.c_str(), 0);
    return error;
  }
  return fresh;
}

void keep_tokens(const std::string& base, const std::string& name) noexcept {
  try {
    const auto folder = tokens_folder(base);
    // A file that is gone or no longer trusted is not restored by this.
    if (folder && read_tokens(*folder, name, true)) {
      ::utimensat(*folder, name.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
    }
  } catch (const std::exception&) {
    // Without memory nothing is kept: the next start has tokens of its own.
  }
}

Result<> forget_tokens(const std::string& base, const std::string& name) {
  const auto folder = tokens_folder(base);
  if (!folder) return tl::unexpected(folder.error());
  if (::unlinkat(*folder, name.c_str(), 0) != 0 && errno != ENOENT) {
    return failed("the previous tokens cannot be removed", base + "/cogrsim/studio/" + name);
  }
  return {};
}

}  // namespace cogrsim::studio
