// How far several runs of one scene part: statistics over frames that were taken side by side.
//
// The first run is the reference; every other is measured against it. Bodies and joints are paired
// by name, so that runs in which elements were added or removed can be compared too. All statistics
// are over the frames given, equally weighted.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"

namespace cogrsim::cli {

struct CompareOptions {
  double position_threshold = 0.01;                         ///< [m]
  double angle_threshold = 3.14159265358979323846 / 180.0;  ///< [rad]
  /// Curves have this many intervals, or up to twice as many; each keeps the largest difference in
  /// it, so that no peak is lost.
  int curve_points = 400;
  /// So many of the last runs are no engines of their own: CompareResult::first_over leaves them out.
  std::size_t twins = 0;
};

/// A difference over time: never negative.
struct Spread {
  double max = 0.0;
  double max_time = 0.0;  ///< [s], of the first time the maximum was reached
  double rms = 0.0;
  double end = 0.0;
  std::vector<double> curve;  ///< against CompareResult::times

  void add(double time, double value, std::size_t interval);
  void halve();  ///< joins the intervals of the curve two by two
  void finish();

 private:
  double sum_of_squares_ = 0.0;
  std::size_t count_ = 0;
};

/// One body or joint of one run against the reference. A quantity that a joint type does not have
/// (a hinge has no distance) is empty.
struct Difference {
  std::string name;
  std::size_t run = 1;             ///< CompareResult::runs
  std::string type;                ///< of a joint
  std::optional<Spread> distance;  ///< [m]
  std::optional<Spread> angle;     ///< [rad]
  /// First time either exceeds its threshold [s].
  std::optional<double> first_over;
  /// Worst of both maxima, each in thresholds: the tables are sorted by it.
  double severity = 0.0;
};

/// One quantity of a run from start to end.
struct Drift {
  double start = 0.0;
  double end = 0.0;
  double largest = 0.0;  ///< largest distance from the start at any time
};

struct Extreme {
  double value = 0.0;
  double time = 0.0;  ///< [s]
  std::string where;  ///< names; empty: there was none
};

/// Figures of one run by itself.
struct RunFigures {
  Drift energy;            ///< kinetic and potential [J]
  Drift linear_momentum;   ///< start, end: magnitudes; largest: |p - p(0)| [kg m/s]
  Drift angular_momentum;  ///< about the world's origin [kg m^2/s]
  double mean_contacts = 0.0;
  std::size_t most_contacts = 0;
  std::size_t end_contacts = 0;
  Extreme penetration;               ///< [m]
  Extreme joint_distance;            ///< see joint_error() [m]
  Extreme joint_angle;               ///< [rad]
  std::vector<double> energy_curve;  ///< against CompareResult::times
};

struct CompareResult {
  CompareOptions options;
  std::vector<std::string> runs;
  std::size_t samples = 0;
  double end_time = 0.0;             ///< of the last sample [s]
  std::vector<double> times;         ///< ends of the curves' intervals [s]
  std::vector<RunFigures> figures;   ///< one per run
  std::vector<Difference> bodies;    ///< that can move; worst first
  std::vector<Difference> joints;    ///< worst first
  std::optional<double> first_over;  ///< earliest of all [s]
  std::string first_over_name;
  std::vector<std::string> only_in_some;  ///< bodies that some run lacks at the end
};

/// Takes the frames one instant at a time.
class Comparison {
 public:
  /// `runs`: at least two names.
  Comparison(std::vector<std::string> runs, CompareOptions options);

  /// One frame per run, all of the same time [s], with contacts.
  void add(double time, const std::vector<FramePtr>& frames);

  /// Whether a threshold was passed so far.
  bool diverged() const { return result_.first_over.has_value(); }

  /// Call once.
  CompareResult finish();

 private:
  struct Pair {  // one element in the reference and in another run
    int first = -1, second = -1;
    std::size_t difference = 0;
  };
  void halve_curves();
  void pair_up(const std::vector<FramePtr>& frames);
  void add_bodies(double time, const Frame& first, const Frame& second, std::size_t run);
  void add_joints(double time, const Frame& first, const Frame& second, std::size_t run);
  void add_figures(double time, const Frame& frame, std::size_t run);
  void note_over(Difference& difference, double time, double distance, double angle);

  struct Start {
    double energy = 0.0;
    Momentum momentum;
  };

  CompareResult result_;
  std::vector<SceneModelPtr> models_;                        // for which pairs_ hold
  std::vector<std::vector<Pair>> body_pairs_, joint_pairs_;  // per run beyond the reference
  std::vector<std::map<std::string, std::size_t>> body_index_, joint_index_;
  std::vector<Start> starts_;
  std::vector<double> contact_sums_;
  std::size_t per_interval_ = 1;  // samples
};

/// Angle of the turn between two orientations, 0 to pi [rad].
double angle_between(const Quat& a, const Quat& b);

}  // namespace cogrsim::cli
