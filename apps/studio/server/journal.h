// Unsaved changes on disk: whatever ends the studio, the next one has them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "descriptor.h"

namespace cogrsim::studio {

/// A scene's text that its file does not have.
struct UnsavedText {
  std::string text;
  std::string base;  ///< version_of() the file's text when it was edited; "": there was no file
  std::int64_t time = 0;  ///< of the edit [s since 1970]
};

/// The file `.NAME.journal` beside a scene. Where it cannot be written, is something else, or another
/// studio has it, one in `cogrsim/studio/unsaved` below the user's state folder is used instead. One
/// thread at a time.
class Journal {
 public:
  static constexpr std::size_t kMostTexts = 16;
  static constexpr std::size_t kMostBytes = 64u << 20;  ///< of all of them

  /// Takes the journals there are, unless another studio has them. `state_folder`: "" for none;
  /// `most_bytes`: of each text.
  Journal(const std::string& scene_path, const std::string& state_folder, std::size_t most_bytes);
  Journal(Journal&&) = default;
  Journal& operator=(Journal&&) = default;

  /// What the journals held, newest first.
  const std::vector<UnsavedText>& found() const { return found_; }
  /// Journals that are there and cannot be read; they are left as they are. A sentence each.
  const std::vector<std::string>& complaints() const { return complaints_; }

  /// The journal holds the first of these, as many as are allowed, and nothing else: on the disk when
  /// this returns. None: it is removed. Errors: it can be written nowhere; what was kept before may
  /// still be there.
  Result<> keep(const std::vector<UnsavedText>& texts);
  /// The file they are in; "": nothing is kept.
  const std::string& path() const { return path_; }

 private:
  struct Location {
    std::string path;
    Descriptor held;  ///< locked for other studios
  };

  void take(Location& location);
  static bool is_free(const Location& location);
  static Result<> write(Location& location, const std::string& bytes);

  std::size_t most_bytes_;
  std::vector<Location> locations_;
  std::vector<UnsavedText> found_;
  std::vector<std::string> complaints_;
  std::string path_;
};

}  // namespace cogrsim::studio
