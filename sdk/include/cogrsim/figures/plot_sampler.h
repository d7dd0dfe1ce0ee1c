// From the frames of a run to the figure that a scene's `<plot>` asks for.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/figures/figure.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/signals/signal.h"

namespace cogrsim::figures {

/// Which signals a kind of plot is made of.
struct PlotAxes {
  bool x = false, y = false, z = false;
  bool x_optional = false;  ///< time, if left out
};
COGRSIM_API PlotAxes plot_axes(Kind kind);

/// Gathers the samples of one plot over one run, from whatever gives frames: an observer of a
/// simulation, a recording.
class COGRSIM_API PlotSampler {
 public:
  /// Errors: unknown kind, a signal that is missing, not needed or not in the model, no series,
  /// `every` negative or not finite.
  static Result<PlotSampler> create(const PlotModel& plot, const SceneModel& model,
                                    const ChannelLookup& channels);

  FrameContents needs() const { return needs_; }

  /// Takes a sample if one is due: the first frame, then every `every` seconds. Boxes and
  /// histograms without `every` take each reading of a sensor once, however many steps it stands.
  void take(const Frame& frame);

  const PlotModel& plot() const { return plot_; }
  std::size_t sample_count() const { return taken_; }

 private:
  friend COGRSIM_API Result<Figure> figure_of(const std::vector<const PlotSampler*>& runs,
                                              const std::vector<std::string>& labels);
  struct Line {
    std::optional<Signal> x, y, z;
    std::vector<double> xs, ys, zs;
    std::uint64_t revision = std::numeric_limits<std::uint64_t>::max();
  };
  PlotModel plot_;
  Kind kind_ = Kind::curve;
  std::vector<Line> lines_;
  FrameContents needs_;
  double next_ = -std::numeric_limits<double>::infinity();
  std::size_t taken_ = 0;
};

/// One figure of the same plot in one or several runs. `labels` tell the runs apart, one each, and
/// may be empty for a single one. Axes are named by the signals. Errors: a surface of several
/// runs, and those of complete().
COGRSIM_API Result<Figure> figure_of(const std::vector<const PlotSampler*>& runs,
                                     const std::vector<std::string>& labels);

}  // namespace cogrsim::figures
