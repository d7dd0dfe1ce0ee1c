// Where bodies touch, in one step: the points, what their rows take from the step before, and what the step
// leaves of them.
#pragma once

#include <vector>

#include "collision/detector.h"
#include "solver/islands.h"

namespace cogrsim::dynamics {

/// Impulse of one contact point over the step. By colliders, see Detector.
struct ContactRecord {
  int collider_a = -1, collider_b = -1;
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();  ///< world
  double gap = 0.0;                                   ///< [m]
  Wrench impulse;                                     ///< on b, at the point, world [N s], [N m s]
};

/// What a contact point takes from the step before.
struct WarmContact {
  int collider_a = -1, collider_b = -1;
  Vec3 point_B = Vec3::Zero();           ///< of the point, in body b's frame
  Wrench wrench;                         ///< on b, at the point, world
  Vec3 position_impulse = Vec3::Zero();  ///< multipliers of the position stage, likewise [N s^2]
};

/// The order of the colliders, of contacts and records.
template <class T>
bool by_pair(const T& a, const T& b) {
  return a.collider_a != b.collider_a ? a.collider_a < b.collider_a : a.collider_b < b.collider_b;
}

/// What a step made of a contact point.
struct ContactOutcome {
  bool has_rows = false;
  bool loaded = false;   ///< its normal impulse is not 0
  bool is_kept = false;  ///< the next step starts from it
  double gap = 0.0;      ///< at the end of the step [m]
  Wrench impulse;        ///< on b, at the point, world [N s], [N m s]
  Vec3 position_impulse = Vec3::Zero();
};

class Contacts {
 public:
  /// `tolerance`: what the sweeps leave of velocities [m/s].
  Contacts(Mechanism& mechanism, Detector& detector, double tolerance, WorkerPool* pool);

  /// How far each body's surface may get in the time h, from speeds at the state.
  void measure_speeds(double h);
  /// Where the bodies are at the middle of the step, of length h; a body that
  /// would have moved by more than its own thickness is tested where it started: it may be beyond a
  /// wall by then. `last`: of the step before, in the order of the colliders.
  void detect(double h, const std::vector<WarmContact>& last);
  void clear();

  const std::vector<ContactPoint>& points() const { return points_; }
  const std::vector<Manifold>& manifolds() const { return manifolds_; }
  const ContactOutcome& outcome_of(const ContactPoint& point) const {
    return outcomes_[std::size_t(&point - points_.data())];
  }

  /// Joints may hold bodies such that they yield at none of the points.
  bool can_yield(const StepContext& context, const Manifold& manifold) const;
  /// Adds the rows of a manifold, with the impulses they start from.
  void add_rows(const StepContext& context, std::size_t manifold,
                const std::vector<WarmContact>& last, RowSet& set);
  /// Takes over what became of the contacts of a solved island.
  void take_outcomes(const RowSet& set);
  /// What the next step, of length h, too, starts from, in the order of the colliders.
  void remember(double h, std::vector<WarmContact>& out) const;
  /// Adds to `records`.
  void report(std::vector<ContactRecord>& records) const;

 private:
  void find_manifolds(const std::vector<WarmContact>& last);
  bool is_line(const Manifold& manifold) const;
  ContactMotion motion_at(const Manifold& manifold, const ContactPoint& point, double h) const;
  // Of a link's point where it is now, while the mechanism's speeds stay.
  Vec3 convective_acceleration(int link, const Vec3& point) const;
  void build_rows(const StepContext& context, const Manifold& manifold, RowSet& set) const;
  void warm_start(double h, std::size_t manifold, const std::vector<WarmContact>& last, RowSet& set,
                  std::size_t first);
  // Distributes the load of a resting pair over its points: each yields a little to its load beyond the
  // mean of the last step. Without it rigid contact leaves the distribution to chance, and a wheel
  // rolls on one of its rims.
  void balance_pair(double h, RowSet& set, std::size_t first) const;

  Mechanism& mechanism_;
  Detector& detector_;
  double tolerance_;
  WorkerPool* pool_;
  bool has_shapes_ = false;
  std::vector<SurfacePair> surfaces_;  ///< (nmaterial x nmaterial)
  std::vector<double> margins_;        ///< (nlink)
  /// (nbody) from where a body is tested for contact to the middle [m]; empty: no body is fast.
  std::vector<Vec3> offsets_;
  std::vector<ContactPoint> points_;
  std::vector<Manifold> manifolds_;
  struct Range {
    std::size_t first = 0, end = 0;
  };
  std::vector<Range> last_of_;            ///< by manifold: those of the last step
  std::vector<char> taken_;               ///< of the last step: a contact starts from it
  std::vector<ContactOutcome> outcomes_;  ///< by point
};

}  // namespace cogrsim::dynamics
