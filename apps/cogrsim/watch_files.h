// Notices that files change, by looking at them again and again: works on every file system, the
// network's too, and with editors and linkers that put a new file in the place of the old one.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace cogrsim::cli {

/// As files are told to WatchedFiles: absolute, without "." and ".."; `path` itself where that
/// cannot be found out.
std::string full_path(const std::string& path);

class WatchedFiles {
 public:
  /// Files of these (absolute) paths are never watched: the run's own results.
  explicit WatchedFiles(std::vector<std::string> ignored);

  /// Watches `paths` from now on, beside what is watched already. Of a folder, the libraries
  /// (*.so) in it.
  void add(const std::vector<std::string>& paths);

  /// From now on what add() was told before counts no more, but for `paths`; those watched already
  /// keep the state they are compared with.
  void keep_only(const std::vector<std::string>& paths);

  /// To be called at even intervals. What is different from when it was watched first, or from the
  /// last settle(): but only once nothing has moved since the last call, since editors and linkers
  /// write in pieces. A file that is gone, or empty, is waited for a while.
  std::vector<std::string> poll();

  /// Everything is as it should be now: later changes count from here.
  void settle();

  std::size_t size() const { return known_.size(); }

 private:
  /// What is seen of a file without reading it; equal stamps, equal files.
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
