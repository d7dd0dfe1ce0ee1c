// Finds free positions for objects on the floor: seen from above, everything is a convex outline,
// rounded or not, that extends from one height to another.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/random.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::dsl {

/// One shape at its pose, in the frame of the ground.
struct Solid {
  std::vector<Eigen::Vector2d> outline;  ///< convex, counter-clockwise; one point or two at least
  double radius = 0.0;                   ///< the outline is this much wider all around [m]
  double bottom = 0.0, top = 0.0;        ///< [m]
};

/// Appends a shape at X_GS; ground itself (planes, heightmaps) has no outline and is left out. A
/// mesh that is not convex gives its triangles, a cylinder an outline up to 2 % too wide.
void add_solids(const SceneModel& model, const Shape& shape, const Pose& X_GS,
                std::vector<Solid>& out);

/// Least distance between two outlines, 0 when they meet [m].
double distance(const Solid& a, const Eigen::Vector2d& at, const Solid& b);

/// Where objects may be placed: on z = 0 of a frame, in one of several rectangles, or a circle.
struct Ground {
  struct Rectangle {
    double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  };
  Pose X_WG;
  std::vector<Rectangle> rectangles;
  double radius = 0.0;  ///< > 0: a circle about the origin instead
  std::string name;     ///< for messages
};

/// Objects that keep their relative poses, in the frame of their iteration.
struct Bundle {
  std::vector<Solid> solids;
  double lowest() const;
};

class Scatterer {
 public:
  /// `obstacles`: in the frame of the ground. `budget`: number of positions that may still be
  /// tried, by all that share it.
  Scatterer(const Ground& ground, const std::vector<Solid>& obstacles, double clearance,
          std::size_t& budget);

  /// A pose for the bundle, wholly inside and clear of the rest by the clearance, drawn from
  /// `random`; then it is an obstacle itself. A shape that would extend below the ground is raised
  /// to stand on it. Some hundred positions are drawn, then all of a grid are tried; nullopt: none
  /// was free.
  std::optional<Vec3> put(const Bundle& bundle, RandomStream& random);

 private:
  struct Bounds {
    double x0, x1, y0, y1;
  };
  bool fits(const Bundle& bundle, double x, double y, double lift);
  void add(Solid solid);
  template <class Use>
  bool bins(const Bounds& bounds, Use&& use) const;

  const Ground& ground_;
  double clearance_;
  std::vector<Solid> obstacles_;
  std::vector<Bounds> bounds_;
  Bounds whole_{};
  double bin_ = 1.0;
  int columns_ = 1, rows_ = 1;
  std::vector<std::vector<int>> bin_contents_;
  std::size_t& budget_;
};

}  // namespace cogrsim::dsl
