#include "watch/watch_files.h"

#include <sys/stat.h>
#include <filesystem>
#include <tuple>

#include "cogrsim/core/random.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

// Polls for which a file that is gone or empty is waited for: two seconds at four a second, longer
// than editors and linkers leave one away, and short enough for a user who removed it.
constexpr int kPatience = 8;

}  // namespace

std::string full_path(const std::string& path) {
  std::error_code fault;
  const fs::path full = fs::absolute(path, fault).lexically_normal();
  return fault ? path : full.string();
}

bool WatchedFiles::Stamp::operator==(const Stamp& other) const {
  const auto tied = [](const Stamp& s) {
    return std::tie(s.there, s.device, s.inode, s.size, s.seconds, s.nanoseconds, s.libraries);
  };
  return tied(*this) == tied(other);
}

WatchedFiles::WatchedFiles(std::vector<std::string> ignored)
    : ignored_(ignored.begin(), ignored.end()) {}

WatchedFiles::Stamp WatchedFiles::stamp_of(const std::string& path) {
  Stamp stamp;
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return stamp;
  stamp.there = true;
  if (S_ISDIR(info.st_mode)) {
    // Other changes in a folder are of no interest. A sum, since the order of entries is arbitrary.
    std::error_code fault;
    for (fs::directory_iterator entry(path, fault), end; !fault && entry != end;
         entry.increment(fault)) {
      const std::string file = entry->path().string();
      if (entry->path().extension() != ".so" || stat(file.c_str(), &info) != 0) continue;
      const std::int64_t numbers[] = {
          static_cast<std::int64_t>(info.st_ino), static_cast<std::int64_t>(info.st_size),
          static_cast<std::int64_t>(info.st_mtim.tv_sec), info.st_mtim.tv_nsec};
      stamp.libraries += hash_bytes(numbers, sizeof numbers, hash_bytes(file.data(), file.size()));
    }
    return stamp;
  }
  stamp.device = info.st_dev;
  stamp.inode = info.st_ino;
  stamp.size = static_cast<std::uint64_t>(info.st_size);
  stamp.seconds = info.st_mtim.tv_sec;
  stamp.nanoseconds = info.st_mtim.tv_nsec;
  return stamp;
}

std::map<std::string, WatchedFiles::Stamp> WatchedFiles::look() const {
  std::map<std::string, Stamp> now;
  for (const auto& entry : known_) now.emplace(entry.first, stamp_of(entry.first));
  return now;
}

void WatchedFiles::add(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    if (ignored_.count(path) || known_.count(path)) continue;
    known_.emplace(path, stamp_of(path));
  }
}

void WatchedFiles::keep_only(const std::vector<std::string>& paths) {
  std::map<std::string, Stamp> kept;
  for (const std::string& path : paths) {
    const auto known = known_.find(path);
    if (known != known_.end()) kept.insert(*known);
  }
  known_.swap(kept);
  add(paths);
}

std::vector<std::string> WatchedFiles::poll() {
  std::map<std::string, Stamp> now = look();
  std::vector<std::string> changed;
  bool incomplete = false;
  for (const auto& [path, stamp] : now) {
    const Stamp& before = known_.at(path);
    if (stamp == before) continue;
    changed.push_back(path);
    const bool was_full = before.there && before.size > 0;
    incomplete = incomplete || (was_full && stamp.libraries == 0 && stamp.size == 0);
  }
  const bool moving = now != last_;
  last_.swap(now);
  if (changed.empty()) {
    waited_ = 0;
    return {};
  }
  if (moving) return {};
  if (incomplete && ++waited_ < kPatience) return {};
  return changed;
}

void WatchedFiles::settle() {
  known_ = look();
  last_ = known_;
  waited_ = 0;
}

}  // namespace cogrsim::cli
