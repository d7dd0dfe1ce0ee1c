// Sampling of the frames of a run for a `<plot>` of a scene.
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

/// The signals that a kind of plot uses.
struct PlotAxes {
  bool x = false, y = false, z = false;
  bool x_optional = false;  ///< time, if left out
};
COGRSIM_API PlotAxes plot_axes(Kind kind);

/// Collects the samples of one plot over one run from the frames of a simulation or a recording.
/// Not thread-safe.
class COGRSIM_API PlotSampler {
 public:
  /// Creates a sampler. Errors: the kind is unknown; a signal is missing, unused or not in the
  /// model; there is no series; `every` is negative or not finite.
  static Result<PlotSampler> create(const PlotModel& plot, const SceneModel& model,
                                    const ChannelLookup& channels);

  /// The frame contents that take() needs.
  FrameContents needs() const { return needs_; }

  /// Takes a sample if one is due: at the first frame, and then every `every` seconds. Box plots
  /// and histograms without `every` count each reading of a sensor only once.
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

/// Creates one figure from the same plot of one or several runs. `labels` has one label per run and
/// may be empty for a single run. The axes are labelled with the signals. Errors: a surface of
/// several runs, or those of complete().
COGRSIM_API Result<Figure> figure_of(const std::vector<const PlotSampler*>& runs,
                                     const std::vector<std::string>& labels);

}  // namespace cogrsim::figures
