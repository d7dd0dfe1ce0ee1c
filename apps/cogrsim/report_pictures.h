// The pictures of a comparison: what each backend made of the scene, side by side.
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

struct PictureMoment {
  std::string title;
  std::vector<std::pair<std::string, std::string>> pictures;  ///< label and PNG of each run
};

struct ReportPictures {
  std::vector<PictureMoment> moments;  ///< where the runs part, if they do, and the end
  std::string map;                     ///< SVG; empty: none
  std::string problem;                 ///< why pictures are missing; empty: none are
};

/// Renders the frames a comparison kept, all of one moment from the same place.
ReportPictures report_pictures(const LockstepResult& result, PluginLoader& loader);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace cogrsim::cli
