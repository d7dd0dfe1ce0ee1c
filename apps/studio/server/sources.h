// Controllers' sources beside a scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

/// *.cpp, *.h and CMakeLists.txt in a folder and three levels below. Only what is in this list is opened
/// or written; links, hidden folders and folders called build* are left out.
class SourceFolder {
 public:
  explicit SourceFolder(std::string folder) : folder_(std::move(folder)) {}

  /// `files` [{name, writable}], sorted; at most 200 of at most 1 MB.
  Answer list() const;
  /// `text`, `version` (of the content).
  Answer open(const std::string& name) const;
  /// Writes it as a scene is written; the old content is kept as `NAME~`. With a `version` only if
  /// the file still is as it was opened (else the code "stale"). Answers the new `version`.
  Answer save(const std::string& name, const std::string& text,
              const std::optional<std::string>& version) const;

  struct File {
    std::string name, path;
  };
  std::vector<File> files() const;

 private:
  Result<std::string> path_of(const std::string& name) const;

  std::string folder_;
};

}  // namespace cogrsim::studio
