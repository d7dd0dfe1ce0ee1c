// Curves and figures of the frames there are, computed as they are asked for.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/figures/plot_sampler.h"
#include "compare/compare.h"
#include "history.h"
#include "run_scenes.h"
#include "talk.h"

namespace cogrsim::studio {

/// Used by one thread. Results are kept, so that only new frames are computed.
class SeriesRequests {
 public:
  SeriesRequests(Frames& frames, Scenes& scenes) : frames_(frames), scenes_(scenes) {}

  Answer signals();
  Answer series(const Json& fields);
  Answer plots();
  Answer figure(const Json& fields);
  /// `labels` of the two runs.
  Answer divergence(const std::array<std::string, 2>& labels, const Json& first);

 private:
  /// One signal of one run, at every frame that was ever read.
  struct Curve {
    std::string text;
    bool ghost = false;
    std::uint64_t epoch = 0, used = 0;
    SceneModelPtr model;  ///< `signal` is of this one
    Signal signal;
    std::string unit;
    std::vector<double> times, values;
  };
  struct Figure {
    std::uint64_t epoch = 0;
    std::uint32_t lineage = 0;
    double until = 0.0;
    std::unique_ptr<figures::PlotSampler> sampler;
  };

  void forget_old();
  Result<Curve*> curve(const std::string& text, bool ghost);
  void extend(Curve& curve);
  void look_up(Curve& curve, const SceneModelPtr& model, std::uint32_t scene);

  Frames& frames_;
  Scenes& scenes_;
  std::uint64_t uses_ = 0;
  std::map<std::pair<std::string, bool>, Curve> curves_;
  std::map<std::string, Figure> figures_;
  struct Divergence {
    std::uint64_t epoch = 0;
    double until = 0.0;
    std::unique_ptr<cli::Comparison> comparison;
  } divergence_;
};

}  // namespace cogrsim::studio
