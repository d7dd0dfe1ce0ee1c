// The scene's plots: gathered from runs and recordings, drawn into a folder.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/figures/plot_sampler.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::cli {

/// Samples all plots of a scene while it runs.
class RunPlots {
 public:
  /// Before the first step. Errors: a plot has an unknown signal.
  static Result<RunPlots> attach(Simulation& simulation);

  /// Draws the samples as DIR/NAME.png and names the files on stderr; creates the folder.
  Result<> draw(const std::string& folder) const;

  bool empty() const { return samplers_->empty(); }

 private:
  // The simulation's observer holds on to it, too.
  std::shared_ptr<std::vector<figures::PlotSampler>> samplers_;
};

/// Whether a figure can be written to a file of this name: .png, .svg, .pdf, .json.
bool is_picture(const std::string& path);

/// Draws a figure and says so on stderr.
Result<> draw_and_report(const figures::Figure& figure, const std::string& path);

/// Makes sure that the folder is there. Errors: it cannot be made.
Result<> make_folder(const std::string& folder);

/// A plot's name as that of a file: "bot.path" stays, anything that could lead elsewhere does not.
std::string file_name_of(const std::string& plot);

}  // namespace cogrsim::cli
