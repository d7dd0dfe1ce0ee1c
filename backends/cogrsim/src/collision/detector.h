// Which shapes are near each other, and where.
#pragma once

#include <vector>

#include "cogrsim/core/worker_pool.h"
#include "collision/narrowphase.h"

namespace cogrsim::dynamics {

/// Collision detection without memory that matters: the contact points are a function of poses and velocities.
class Detector {
 public:
  explicit Detector(const SceneModel& model);

  /// Shapes as prepared; `body` -1 where a shape does not collide.
  const std::vector<Collider>& colliders() const { return colliders_; }

  /// Moves a body's shapes. `margin`: speculative, how far its surface may move in the step [m].
  /// `shift` of its origin [m] and `turn` [rad]: what the rest of the step will about add.
  void set_pose(int body, const Placement& X_WB, double margin, const Vec3& shift = Vec3::Zero(),
                const Vec3& turn = Vec3::Zero());
  /// Shapes of bodies of which neither moves are not tested.
  void set_moves(int body, bool moves);
  /// Radius around the body's origin that holds all its shapes [m]; 0 without shapes.
  double bounding_radius(int body) const { return bounding_radii_[std::size_t(body)]; }

  /// Half of the least extent of its shapes [m]; a body that moves farther in a step may tunnel.
  double thinness(int body) const { return thinness_[std::size_t(body)]; }

  /// All contact points with a gap below the sum of both margins, ordered by bodies and shapes. With
  /// a `pool`, pairs are tested on its threads.
  void detect(std::vector<ContactPoint>& out, WorkerPool* pool = nullptr);

  /// Of the surface of a point's second shape against that of its first, beside what their bodies'
  /// motion makes of it: world, along the surface [m/s].
  Vec3 surface_velocity(const ContactPoint& point) const;

 private:
  void find_pairs();
  void sort_bounds(int axis);
  int widest_axis() const;
  void test_pairs(std::vector<ContactPoint>& out, WorkerPool* pool);
  void test_pair(std::size_t pair, std::vector<ContactPoint>& out);

  CollisionFilter filter_;
  std::vector<Collider> colliders_;
  std::vector<int> first_;  ///< first collider of each body (nbody + 1)
  std::vector<double> bounding_radii_, thinness_;
  /// Bounds of a collider, apart from the rest of it so that those of neighbours lie in the cache together.
  struct Bounds {
    Vec3 low, high;
    int collider;
    bool moves;
  };
  std::vector<Bounds> sorted_;  ///< of bounded colliders, by their lower end along an axis
  std::vector<int> unbounded_;  ///< planes
  std::vector<std::pair<int, int>> pairs_, last_pairs_;  ///< of colliders
  std::vector<Apart> apart_, last_apart_;                ///< of each pair
  int axis_ = -1;  ///< that of sorted_
  /// Strips across an axis. What is beyond the ends is in the first or the last.
  struct Strips {
    double low = 0.0, per_length = 0.0;  ///< [m], [1/m]
    int last = 0;
    int of(double x) const {
      const double at = (x - low) * per_length;
      return at > 0.0 ? (at < last ? int(at) : last) : 0;
    }
  };
  Strips cut_strips(int axis);
  std::vector<std::vector<int>> open_;  ///< by strip: places in sorted_
  std::vector<std::vector<ContactPoint>> parts_;  ///< found by each part of the pairs
};

}  // namespace cogrsim::dynamics
