// The pictures of a comparison: the scene on each backend, side by side.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cogrsim {
class PluginLoader;
}

namespace cogrsim::cli {

struct LockstepResult;

struct PictureInstant {
  std::string title;
  std::vector<std::pair<std::string, std::string>> pictures;  ///< label and PNG of each run
};

struct ReportPictures {
  std::vector<PictureInstant> instants;  ///< where the runs diverge, if they do, and the end
  std::string map;                     ///< SVG; empty: none
  std::string problem;                 ///< why pictures are missing; empty: none are
};

/// Renders the frames a comparison kept, all of one instant from the same viewpoint.
ReportPictures report_pictures(const LockstepResult& result, PluginLoader& loader);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace cogrsim::cli
