// Detects changes of files by polling: works on every file system, network file systems too, and
// with editors and linkers that replace the old file by a new one.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace cogrsim::cli {

/// The form of paths in WatchedFiles: absolute, without "." and ".."; `path` itself where that
/// cannot be found out.
std::string full_path(const std::string& path);

class WatchedFiles {
 public:
  /// Files of these (absolute) paths are never watched: the run's own results.
  explicit WatchedFiles(std::vector<std::string> ignored);

  /// Watches `paths` from now on, beside what is watched already. Of a folder, the libraries
  /// (*.so) in it.
  void add(const std::vector<std::string>& paths);

  /// From now on only `paths` are watched; those watched already keep the state they are compared
  /// with.
  void keep_only(const std::vector<std::string>& paths);

  /// To be called at even intervals. Returns the files that differ from when they were watched
  /// first, or from the last settle(), but only once nothing has changed since the last call, since
  /// editors and linkers write in pieces. A file that is gone, or empty, is waited for a while.
  std::vector<std::string> poll();

  /// Takes the present state of the files as the reference.
  void settle();

  std::size_t size() const { return known_.size(); }

 private:
  /// The metadata of a file; equal stamps, equal files.
  struct Stamp {
    bool there = false;
    std::uint64_t device = 0, inode = 0, size = 0;
    std::int64_t seconds = 0, nanoseconds = 0;  // of the last change
    std::uint64_t libraries = 0;                // of a folder: hash of what is in it
    bool operator==(const Stamp& other) const;
  };
  static Stamp stamp_of(const std::string& path);
  std::map<std::string, Stamp> look() const;

  std::set<std::string> ignored_;
  std::map<std::string, Stamp> known_;  // what is compared with
  std::map<std::string, Stamp> last_;   // as of the last poll()
  int waited_ = 0;                      // polls since something is gone
};

}  // namespace cogrsim::cli
