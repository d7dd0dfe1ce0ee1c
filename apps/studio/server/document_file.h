// The scene's file: read once, written completely or not at all, never over the changes of another
// program.
#pragma once

#include <optional>
#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim::studio {

/// Reads a whole file of at most `most` bytes. Errors: it cannot be read, is no ordinary file, is
/// larger, or is no UTF-8.
Result<std::string> read_text_file(const std::string& path, std::size_t most);

/// Replaces a file's content through a new file beside it, which then takes its name: after a crash
/// there is the old one or the new one. Permissions stay; a symbolic link is followed. Errors: the
/// folder or file cannot be written.
Result<> write_text_file(const std::string& path, const std::string& text);

/// Whether it is UTF-8 throughout.
bool is_utf8(const std::string& text);

/// A hash that distinguishes contents, without secrecy: 16 hexadecimal digits.
std::string version_of(const std::string& text);

/// A bare name ending in `ending`: no folders, no leading dot, no control characters.
Result<> check_bare_name(const std::string& name, const std::string& ending);

class SceneFile {
 public:
  /// A file that is not there yet has no text.
  static Result<SceneFile> open(const std::string& path, std::size_t most_bytes);

  const std::string& path() const { return path_; }
  std::string name() const;    ///< without the folder
  std::string folder() const;  ///< "." for a bare path
  /// As it was when it was last read or written; nullopt: it did not exist.
  const std::optional<std::string>& text() const { return text_; }

  /// Writes it. What was there until now is kept as `FILE~`, replacing an older one: answers its
  /// name, "" when there was nothing. Errors: another program changed the file since;
  /// write_text_file's.
  Result<std::string> save(const std::string& text);
  /// Continues under another name in the same folder. Errors: the name is no bare `….scene.xml`, or
  /// taken by another file.
  Result<> save_as(const std::string& name, const std::string& text);
  /// Reads what is on disk now. Errors: as for open(); it is gone.
  Result<> reread();

 private:
  std::string path_;
  std::size_t most_bytes_ = 0;
  std::optional<std::string> text_;
};

}  // namespace cogrsim::studio
