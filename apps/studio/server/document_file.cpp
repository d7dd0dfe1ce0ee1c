#include "document_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "cogrsim/core/random.h"
#include "descriptor.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

std::string reason() { return std::strerror(errno); }

}  // namespace

bool is_utf8(const std::string& text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size();) {
    const unsigned char c = at(i);
    if (c < 0x80) {
      ++i;
      continue;
    }
    const std::size_t length = c >= 0xC2 && c <= 0xDF   ? 2
                               : c >= 0xE0 && c <= 0xEF ? 3
                               : c >= 0xF0 && c <= 0xF4 ? 4
                                                        : 0;
    if (length == 0 || i + length > text.size()) return false;
    for (std::size_t k = 1; k < length; ++k)
      if ((at(i + k) & 0xC0) != 0x80) return false;
    // Longer than need be, a surrogate, or beyond the last code point.
    if ((c == 0xE0 && at(i + 1) < 0xA0) || (c == 0xED && at(i + 1) > 0x9F) ||
        (c == 0xF0 && at(i + 1) < 0x90) || (c == 0xF4 && at(i + 1) > 0x8F))
      return false;
    i += length;
  }
  return true;
}

Result<std::string> read_text_file(const std::string& path, std::size_t most) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return fail("it is not an ordinary file", path);
  Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file < 0) return fail("it cannot be read: " + reason(), path);
  std::string text;
  std::vector<char> buffer(1 << 16);
  while (true) {
    const ssize_t count = ::read(file, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail("it cannot be read: " + reason(), path);
    if (count == 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(count));
    if (text.size() > most)
      return fail("it is larger than " + std::to_string(most >> 20) + " MB", path);
  }
  if (!is_utf8(text)) return fail("it is no UTF-8", path, "save it as UTF-8 in your editor");
  return text;
}

Result<> write_text_file(const std::string& path, const std::string& text) {
  // The new file replaces the target of a link, not the link.
  std::error_code error;
  fs::path target = path;
  if (fs::is_symlink(fs::symlink_status(target, error))) {
    target = fs::canonical(target, error);
    if (error) return fail("the link leads nowhere", path);
  }
  std::string pattern = (target.parent_path().empty() ? fs::path(".") : target.parent_path()) /
                        ("." + target.filename().string() + ".XXXXXX");
  Descriptor file{::mkostemp(pattern.data(), O_CLOEXEC)};
  if (file < 0)
    return fail("nothing can be written beside it: " + reason(), path,
                "look at the permissions of its folder");
  const auto give_up = [&](const std::string& what) -> Result<> {
    const std::string why = reason();
    ::unlink(pattern.c_str());
    return fail(what + ": " + why, path);
  };
  struct stat old {};
  if (::stat(target.c_str(), &old) == 0) {
    if (::fchmod(file, old.st_mode & 07777) != 0) return give_up("permissions");
    // Best effort: only root may give files away.
    if (::fchown(file, old.st_uid, old.st_gid) != 0) errno = 0;
  } else {
    const mode_t mask = ::umask(0);
    ::umask(mask);
    if (::fchmod(file, 0666 & ~mask) != 0) return give_up("permissions");
  }
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = ::write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return give_up("it cannot be written");
    done += static_cast<std::size_t>(count);
  }
  if (::fsync(file) != 0) return give_up("it cannot be written");
  if (::rename(pattern.c_str(), target.c_str()) != 0) return give_up("it cannot be replaced");
  const std::string folder =
      target.parent_path().empty() ? std::string(".") : target.parent_path().string();
  const Descriptor opened{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (opened >= 0) ::fsync(opened);
  return {};
}

std::string version_of(const std::string& text) {
  return fmt::format("{:016x}", hash_bytes(text.data(), text.size()));
}

Result<> check_bare_name(const std::string& name, const std::string& ending) {
  const bool plain =
      !name.empty() && name.size() <= 200 && name[0] != '.' && is_utf8(name) &&
      std::none_of(name.begin(), name.end(), [](char c) {
        return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
      });
  const bool ends = name.size() > ending.size() &&
                    name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
  if (plain && ends) return {};
  return fail("'" + name + "' is not a name for this file", "",
              "a name without folders that ends in " + ending);
}

Result<SceneFile> SceneFile::open(const std::string& path, std::size_t most_bytes) {
  SceneFile file;
  file.path_ = path;
  file.most_bytes_ = most_bytes;
  std::error_code error;
  if (!fs::exists(fs::symlink_status(path, error))) {
    if (!fs::is_directory(file.folder(), error))
      return fail("there is no folder '" + file.folder() + "'", path);
    return file;
  }
  auto text = read_text_file(path, most_bytes);
  if (!text) return tl::unexpected(text.error());
  file.text_ = std::move(*text);
  return file;
}

std::string SceneFile::name() const { return fs::path(path_).filename().string(); }

std::string SceneFile::folder() const {
  const fs::path folder = fs::path(path_).parent_path();
  return folder.empty() ? "." : folder.string();
}

Result<std::string> SceneFile::save(const std::string& text) {
  std::error_code error;
  const bool there = fs::exists(path_, error);
  if (there) {
    const auto now = read_text_file(path_, most_bytes_);
    if (!now || !text_ || *now != *text_)
      return fail("another program changed '" + name() + "' since it was read", path_,
                  "revert to load the file, or save under another name", "changed");
  }
  std::string backup;
  if (there && text_) {
    const std::string path = path_ + "~";
    // Never through a link that another user put there.
    if (fs::is_symlink(fs::symlink_status(path, error))) fs::remove(path, error);
    if (auto kept = write_text_file(path, *text_); !kept)
      return fail("no backup could be written: " + kept.error().message, path, kept.error().hint);
    backup = name() + "~";
  }
  if (auto written = write_text_file(path_, text); !written) return tl::unexpected(written.error());
  text_ = text;
  return backup;
}

Result<> SceneFile::save_as(const std::string& name, const std::string& text) {
  if (auto good = check_bare_name(name, ".scene.xml"); !good) return good;
  const std::string path = (fs::path(path_).parent_path() / name).string();
  std::error_code error;
  if (fs::exists(fs::symlink_status(path, error)))
    return fail("there is a file '" + name + "' already", path, "choose another name");
  if (auto written = write_text_file(path, text); !written) return written;
  path_ = path;
  text_ = text;
  return {};
}

Result<> SceneFile::reread() {
  std::error_code error;
  if (!fs::exists(path_, error))
    return fail("'" + name() + "' is not there", path_, "save it, or save under another name");
  auto text = read_text_file(path_, most_bytes_);
  if (!text) return tl::unexpected(text.error());
  text_ = std::move(*text);
  return {};
}

}  // namespace cogrsim::studio
