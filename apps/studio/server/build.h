// Builds the controllers beside a scene. Runs the code of their CMakeLists.txt: only where allowed.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

class Builder {
 public:
  explicit Builder(std::string folder) : folder_(std::move(folder)) {}

  struct Built {
    bool ok = false;
    std::string log;                ///< what CMake and the compiler wrote, its end if it is long
    Json problems = Json::array();  ///< as the document's; files are relative to the scene's folder
    std::string plugins;            ///< a new folder with the libraries
  };
  /// Configures and builds the project in the scene's folder, or in the one folder below it that has a
  /// CMakeLists.txt, into a folder of the user's cache. The libraries are copied to a new folder,
  /// so that they are loaded beside those that run. Errors: there is no project, or several; no
  /// folder to build in; cmake cannot be started. Errors of the compiler are no error here:
  /// see `ok`.
  /// `debug`: not optimised, with debug information.
  Result<Built> build(bool debug);
  /// Ends a build that is running, from any thread.
  void stop() noexcept { stopped_ = true; }

  /// Part of the path of every folder made by builds of this project.
  std::string mark() const;

 private:
  Result<int> run(const std::vector<std::string>& command, std::string& log);

  std::string folder_;
  std::atomic<bool> stopped_{false};
};

/// The complaints of GCC, Clang and CMake in a log. `folder`: files below it are named relative to it.
Json problems_in(const std::string& log, const std::string& folder);

}  // namespace cogrsim::studio
