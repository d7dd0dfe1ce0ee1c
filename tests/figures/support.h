// Folders that go away, and what is in files.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "cogrsim/figures/draw.h"

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A new folder, removed with all that is in it at the end.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }
  /// Names of what is in it, sorted.
  std::vector<std::string> files() const;

 private:
  std::filesystem::path path_;
};

std::string content(const std::string& path);

/// Draws and fails the test with gnuplot's words if that does not work.
std::vector<std::string> drawn(const cogrsim::figures::Figure& figure, const std::string& path);
