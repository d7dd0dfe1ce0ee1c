// The samples of a run that a bundle keeps.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/figures/plot_sampler.h"
#include "cogrsim/simulation/simulation.h"
#include "paths.h"
#include "run_scenes.h"
#include "talk.h"

namespace cogrsim::studio {

struct SampleOptions {
  double every = 1.0 / 60.0;         ///< between frames [s]; 0: every one
  std::size_t limit = 64u << 20;     ///< of frames, curves and contacts [byte]
  std::size_t pictures = 16u << 20;  ///< of the cameras' pictures [byte]
};

/// Frames of a run at the rate of a display. Where they would take more than allowed, every second
/// one is dropped and the time between them doubles, so a run of any length fits. Figures of the
/// scene and paths take every step.
class RunSamples {
 public:
  using Channels = std::function<const std::vector<Channel>&(int sensor)>;
  RunSamples(SampleOptions options, OriginsPtr origins, Channels channels);

  /// What frames must contain for the curves and figures of this model.
  FrameContents needs(const SceneModelPtr& model);
  /// Every frame of the run, in order. One that is earlier than the one before restarts the run.
  void take(const FramePtr& frame);
  /// The last frame is there whenever it was taken. To be called once, after the last.
  void finish();

  struct Touch {
    std::int32_t a = -1, b = -1;
    float numbers[8] = {};  ///< point, normal, depth, force
  };
  struct Sample {
    double time = 0.0;
    std::uint64_t step = 0;
    std::uint32_t scene = 0;
    std::vector<float> poses;   ///< bodies x 7
    std::vector<float> values;  ///< of the scene's curves
    std::vector<Touch> contacts;
  };
  struct Shot {
    double time = 0.0;
    std::string camera;
    int width = 0, height = 0;
    std::string jpeg;
  };
  struct Curve {
    std::string name, unit, owner;
    Signal signal;
  };
  struct SceneCurves {
    std::vector<Curve> curves;
    /// By sensor: indices into `curves`, in the order of its channels; -1: left out.
    std::vector<std::vector<int>> readings;
  };
  struct Figure {
    std::string name;
    std::unique_ptr<figures::PlotSampler> sampler;
  };

  const std::vector<Sample>& samples() const { return samples_; }
  const std::vector<Shot>& shots() const { return shots_; }
  const std::vector<Event>& events() const { return events_; }
  const SceneCurves& curves(std::uint32_t scene) const { return curves_.at(scene); }
  const std::vector<Figure>& figures() const { return figures_; }
  std::vector<Path> paths() const { return paths_.all(); }
  Scenes& scenes() { return scenes_; }
  double every() const { return every_; }
  /// The frame taken last; nullptr: none was.
  const FramePtr& last() const { return last_; }
  /// What was left out, a sentence each.
  std::vector<std::string> left_out() const;

 private:
  void enter(const SceneModelPtr& model);
  void begin_again();
  void add(const Frame& frame);
  void add_shots(const Frame& frame);
  void thin();

  SampleOptions options_;
  OriginsPtr origins_;
  Channels channels_;
  Scenes scenes_;
  SceneModelPtr model_;  ///< of the frame taken last
  std::uint32_t scene_ = 0;
  std::map<std::uint32_t, SceneCurves> curves_;
  std::vector<Figure> figures_;
  std::vector<std::string> figure_problems_;

  FramePtr last_;
  double every_ = 0.0, next_ = -std::numeric_limits<double>::infinity();
  bool thinned_ = false;
  std::size_t bytes_ = 0;
  std::vector<Sample> samples_;
  Paths paths_;
  std::vector<Event> events_;
  std::size_t events_left_out_ = 0, curves_left_out_ = 0;

  std::vector<Shot> shots_;
  std::size_t shot_bytes_ = 0;
  double shots_every_ = 0.0;
  std::map<std::string, std::pair<std::uint64_t, double>> shot_last_;  ///< sequence, time
  bool shots_thinned_ = false;
};

}  // namespace cogrsim::studio
