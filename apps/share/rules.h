// The files that a package may hold, and their names. Packing and unpacking use the same rules, so
// every package that can be pushed can be pulled.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim::share {

/// Bounds against hostile packages.
struct PackageLimits {
  std::uint64_t package_bytes = 512ull << 20;    ///< of the file that is downloaded
  std::uint64_t unpacked_bytes = 2048ull << 20;  ///< of all files together
  std::uint64_t file_bytes = 1024ull << 20;      ///< of one file
  std::uint64_t manifest_bytes = 4ull << 20;     ///< of the manifest and of an entry of a store
  std::size_t files = 4096;
  /// Unpacked over packed size; below `free_bytes` any ratio is good, since an honest small text may
  /// shrink to almost nothing.
  double ratio = 200.0;
  std::uint64_t free_bytes = 16ull << 20;
};

/// The purpose of a file.
enum class Role { scene, import, texture, mesh, heightmap, data, source, recording, document };
const char* role_name(Role role);
std::optional<Role> parse_role(std::string_view name);

/// The path of a file in a package: "textures/tiles.png". Errors say what is wrong: absolute, "..",
/// a character that some file system does not have, a device's name, a hidden file, too long.
Result<> check_path(std::string_view path);

/// Whether a file of this name can have this role; there is a list of endings for each, and none of
/// them is a program's.
Result<> check_role(std::string_view path, Role role);

/// The role of a file that the user adds, by its ending. Errors: no package takes such a file.
Result<Role> role_of(std::string_view path);

/// Refuses a path that is there already, also where a file system does not distinguish capitals
/// from small letters, or that is a folder for another one.
class PathSet {
 public:
  Result<> add(const std::string& path);

 private:
  std::map<std::string, std::string> files_, folders_;  // by the name in small letters
};

/// Checks the contents of a file while it is read: a program does not pass as a picture.
class ContentCheck {
 public:
  explicit ContentCheck(std::string_view path);
  void feed(std::string_view bytes);
  /// After the whole file. Errors: a program, or another format than its ending says.
  Result<> finish() const;

 private:
  std::string path_, ending_, head_;
  bool has_zero_ = false;
};

/// A package's name: small letters, digits, "_" and "-", at most 64, a letter or digit first.
Result<> check_name(std::string_view name);
/// A name made of any text; empty: the text has no usable characters.
std::string to_name(std::string_view text);

/// One to four numbers with points between them: "1.0.2".
Result<> check_version(std::string_view version);
/// By numbers: "1.9" before "1.10", "1.0" before "1.0.0". Both must be versions.
bool version_less(std::string_view a, std::string_view b);
/// "1.0.2" for "1.0.1".
std::string next_version(std::string_view version);

/// Texts for people in the manifest: no control characters, at most `bytes`, UTF-8.
Result<> check_text(std::string_view what, std::string_view text, std::size_t bytes);

/// The name of a package on a store: "arm-1.0.2".
struct PackageName {
  std::string name, version;
  std::string stem() const { return name + "-" + version; }
};
inline constexpr const char* kPackageEnding = ".cogrsim.zip";
inline constexpr const char* kEntryEnding = ".cogrsim.json";
/// Empty: the file is not a package's, `ending` missing or the name not one that we give.
std::optional<PackageName> parse_stem(std::string_view file, std::string_view ending);

}  // namespace cogrsim::share
