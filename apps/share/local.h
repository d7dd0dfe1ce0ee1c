// Folders, texts and progress on this machine.
#pragma once

#include <cstdint>
#include <string>

#include "cogrsim/core/result.h"
#include "common/progress.h"
#include "http.h"

namespace cogrsim::share {

/// A new empty folder of our own, removed with all in it at the end.
class TemporaryFolder {
 public:
  /// Below `parent`, which must be there; empty: where the system keeps such things.
  static Result<TemporaryFolder> make(const std::string& parent = {});
  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;

  const std::string& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

/// Moves a file or folder to a name that must be free. Errors: it is not, or cannot be made.
Result<> move_to_free_name(const std::string& from, const std::string& to);

/// A line on stderr that shows how far a transfer is.
class TransferLine {
 public:
  explicit TransferLine(std::string title) : title_(std::move(title)) {}
  TransferProgress progress();

 private:
  void show(std::uint64_t done, std::uint64_t total);
  std::string title_;
  cli::StatusLine line_;
};

}  // namespace cogrsim::share
