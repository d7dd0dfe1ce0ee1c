// The paths of bodies during a run: made from every step, with as few points as the tolerance
// allows.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "talk.h"

namespace cogrsim::studio {

/// The path of one body through its origin, as a line of points of the run. At every time that was
/// taken in, each coordinate of the line is within `tolerance` of where the body was; what was
/// thinned is within twice of it.
struct Path {
  std::string label;  ///< assembly or body
  std::string body;
  double tolerance = 1e-5;    ///< [m]
  std::vector<double> times;  ///< [s]; never falls
  std::vector<Vec3> points;   ///< [m]

  /// A later point. One of the same time is a thing put elsewhere, and stays beside the one before.
  void add(double time, const Vec3& point);
  /// As few points as four times the tolerance takes.
  void thin();
  void keep_newest(std::size_t most);

  // The point taken in last; behind the line until the line can do without it no longer.
  double last_time = 0.0;
  Vec3 last = Vec3::Zero();
  // Speeds from the line's end at which a straight line passes by all points since then. [m/s]
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();

 private:
  void end_at(double time, const Vec3& point);
};

/// The paths of a run: of each top-level assembly the first body that moves, and of those outside of
/// any all that move; those with a controller come first. At most 64. From any thread.
class Paths {
 public:
  /// The next frame of the run. A frame with an earlier time than the last clears the paths first.
  void take(const Frame& frame);
  void clear();

  /// What is new since an answer: `revision`, `until` [s] (up to there all is known, empty: nothing
  /// is), `paths` [{`label`, `body`, `from` (index of the first point here), `times`, `points` (x y z
  /// of each), `last` (x y z at `until`)}]. `counts`: points known of each; of another revision
  /// nothing is known.
  Json since(std::uint64_t revision, const std::vector<std::size_t>& counts) const;
  /// Whole, up to the last frame.
  std::vector<Path> all() const;

 private:
  void follow(const SceneModel& model);

  mutable std::mutex mutex_;
  std::uint64_t revision_ = 1;
  SceneModelPtr model_;  ///< for which indices_ hold
  std::vector<Path> paths_;
  std::vector<int> indices_;  ///< of the bodies; -1: not there
  bool any_ = false;
  double until_ = 0.0;
};

}  // namespace cogrsim::studio
