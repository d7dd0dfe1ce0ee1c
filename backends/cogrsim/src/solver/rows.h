// The unilateral and bounded conditions on velocities in one step, each with its impulse.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "cogrsim/geometry/manifold.h"
#include "drives.h"
#include "mechanism/mechanism.h"

namespace cogrsim::dynamics {

using geometry::ContactPoint;

/// Memory for the numbers of rows; what it gave stays where it is until clear().
class NumberPool {
 public:
  double* take(int count) {
    const std::size_t size = std::size_t(count);
    if (block_ == blocks_.size() || used_ + size > blocks_[block_].size()) open_block(size);
    double* const out = &blocks_[block_][used_];
    used_ += size;
    return out;
  }
  void clear() { block_ = used_ = 0; }

 private:
  void open_block(std::size_t least);

  std::vector<std::vector<double>> blocks_;
  std::size_t block_ = 0, used_ = 0;
};

/// J v + gamma lambda = target, with low <= lambda <= high; v is the velocity at the end of the
/// step. It concerns one component or two, its sides.
struct Row {
  /// J and W = M^-1 J^T of the first side, then those of the second. Of free bodies, scaled, W is J, which is there once.
  double* numbers = nullptr;
  int component[2] = {-1, -1};    ///< of each side
  int size[2] = {0, 0};           ///< its speeds; 0: no such side
  int at[2] = {0, 0};             ///< the first of them among the speeds of the island
  bool free_bodies = true;        ///< each side is one free body

  // Position stage: the gap at the end of the step is `gap` + J (h/2 dv + p), p a displacement.
  bool has_gap = false;
  bool equality =
      false;  ///< the gap is brought to `gap_target` from either side, within the bounds
  bool bilateral = false;  ///< with l > 0 the gap is brought to `gap_target` from above, too
  bool hits = false;       ///< its impulse is that of an impact
  /// Of a contact with restitution: it bounces, or it is open by the end, unless an impact closes it.
  enum class Impact : std::uint8_t { none, waits, bounces } impact = Impact::none;
  bool stays =
      false;  ///< without the impulses the gap is closed by the end, and it shall not bounce
  bool deep = false;  ///< joints hold the bodies, which overlap

  double now = 0.0;       ///< J u at the middle of the step, motion of kinematic bodies included
  double target = 0.0;
  double bias = 0.0;      ///< now - target
  double gamma = 0.0;
  double diagonal = 0.0;  ///< J M^-1 J^T
  double inverse = 0.0;   ///< 1 / (diagonal + gamma)
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  double lambda = 0.0;  ///< impulse [N s] or [N m s]
  double restitution = 0.0;
  double gap = 0.0;
  double gap_target = 0.0;
  double position_impulse = 0.0;  ///< multiplier of the displacement [N s^2]; before: warm start
  double gap_change = 0.0;        ///< what the displacement adds to the gap

  // A joint's rows: where efforts and warm starts are stored.
  int effort = -1;  ///< flat speed index
  int motor = -1;
  int coupling = -1;
  int slot = -1;  ///< of the warm-start memory
  double effort_sign = 1.0;

  double* j(int side) const { return numbers + (free_bodies ? 1 : 2) * side * size[0]; }
  double* w(int side) const { return free_bodies ? j(side) : j(side) + size[side]; }
};

/// How the friction of a contact point is made up.
enum class FrictionKind {
  point,  ///< two tangents at the point, |lambda_t| <= friction lambda_n
  patch,  ///< first of the two points of a line: two tangents in the middle, bounded by both loads
  twist   ///< second of the two: one row against turning about the normal
};

/// Rows of one point: the normal, then those of friction, then those against turning, if any: two
/// against rolling, about the tangents, and one against spinning, about the normal.
struct ContactRows {
  int first = 0;
  FrictionKind kind = FrictionKind::point;
  double friction = 0.0;
  double rolling = 0.0, spinning = 0.0;  ///< largest torque per load [m]
  double lever = 0.0;  ///< twist: torque per load and friction [m]
  int partner = -1;    ///< contact with the other point of the line; patch and twist only
  int in_pair = 0;     ///< its place among those of its pair of shapes
  int normal_block = -1;         ///< solved before this contact's friction; -1: none
  bool in_normal_block = false;  ///< the normal has been solved with those of an earlier contact
  const ContactPoint* point = nullptr;
  Vec3 tangent1 = Vec3::Zero(), tangent2 = Vec3::Zero();
  int friction_rows() const {
    if (friction <= 0.0) return 0;
    return kind == FrictionKind::twist ? 1 : 2;
  }
  int turning_rows() const { return (rolling > 0.0 ? 2 : 0) + (spinning > 0.0 ? 1 : 0); }
  int first_turning() const { return first + 1 + friction_rows(); }
  int end() const { return first_turning() + turning_rows(); }
  /// The axis of row `i` of those against turning.
  const Vec3& turning_axis(int i) const {
    if (rolling <= 0.0 || i == 2) return point->normal;
    return i == 0 ? tangent1 : tangent2;
  }
};

/// Friction of a ball joint: three rows with |lambda| <= bound.
struct BallFriction {
  int first = 0;
  double bound = 0.0;
};

/// Limit of a ball joint: its effort has three components.
struct BallLimit {
  int row = 0;
  int effort = 0;  ///< the first of three
  Vec3 direction = Vec3::Zero();
};

/// Slots of the warm-start memory of joints' rows.
enum class SlotKind { lower_limit, upper_limit, friction, passive, motor, coupling };

struct RowSet {
  std::vector<Row> rows;     ///< all
  std::vector<int> scalars;  ///< joints' rows, solved one by one
  std::vector<BallFriction> balls;
  std::vector<BallLimit> ball_limits;
  std::vector<ContactRows> contacts;
  NumberPool pool;
  void clear();
  /// What presses where the friction of a contact acts.
  double load_of(const ContactRows& contact) const {
    const double load = rows[std::size_t(contact.first)].lambda;
    if (contact.partner < 0) return load;
    return load + rows[std::size_t(contacts[std::size_t(contact.partner)].first)].lambda;
  }
};

/// One beyond the last contact of the pair of shapes that has the first.
inline std::size_t end_of_pair(const std::vector<ContactRows>& contacts, std::size_t first) {
  std::size_t end = first + 1;
  while (end < contacts.size() && contacts[end].in_pair > 0) ++end;
  return end;
}

/// What the rows of a step are made from. All at the middle of the step.
struct StepContext {
  double h = 0.0;  ///< length of the step [s]
  double bounce_threshold = 0.05;
  const double* u = nullptr;           ///< speeds
  const double* start_udot = nullptr;  ///< estimate that led to the middle, likewise
  const double* udot = nullptr;        ///< smooth, at the middle, likewise
  const Values* start_q = nullptr;
  const Values* start_u = nullptr;
};

/// Speed at which bodies that overlap at the start of a run are separated [m/s].
inline constexpr double kRecoverySpeed = 1.0;

/// Gap and speed along a unilateral row, and what the step shall make of them.
struct Approach {
  double gap = 0.0;           ///< at the start [m]
  double speed = 0.0;         ///< its rate at the start [m/s]; positive: it opens
  double acceleration = 0.0;  ///< of the smooth motion [m/s^2]
  double turning = 0.0;       ///< its part that the speeds make: J' u [m/s^2]
  double restitution = 0.0;
};

/// Fills target and position goal of a unilateral row; see README, "Unilateral conditions".
void aim_unilateral(const StepContext& context, const Approach& approach, Row& row);

/// The points of one pair of shapes that touch, and how.
struct Manifold {
  const ContactPoint *first = nullptr, *end = nullptr;
  int link[2] = {-1, -1};
  int component[2] = {-1, -1};  ///< that yields; -1: none
  const SurfacePair* surface = nullptr;
  bool is_line = false;  ///< its two points are the ends of a line
};

/// How b moves against a at a contact point.
struct ContactMotion {
  Vec3 velocity = Vec3::Zero();  ///< [m/s]
  Vec3 surface = Vec3::Zero();   ///< see Detector::surface_velocity
  Vec3 turning = Vec3::Zero();   ///< rate of the velocity that the speeds make: J' u [m/s^2]
};

class RowBuilder {
 public:
  /// The mechanism's state stays while rows are added.
  RowBuilder(Mechanism& mechanism, RowSet& set)
      : mechanism_(mechanism), set_(set), motions_(mechanism.motions()) {}

  /// Adds the joints' rows: limits about to be reached, friction, implicit laws.
  void add_joint_rows(const StepContext& context, const std::vector<AxisLaw>& laws);

  /// Adds the rows of a pair's points that its bodies can yield at; `motions`: of each.
  void add_contacts(const StepContext& context, const Manifold& manifold,
                    const ContactMotion* motions);

  /// Index in the warm-start memory; `index`: flat speed index, motor or coupling.
  static int slot_of(const SceneModel& model, SlotKind kind, int index);
  static int slot_count(const SceneModel& model);

 private:
  Row& next_row() { return set_.rows.emplace_back(); }
  double along(const Row& row, const double* v) const;  // what free bodies add is left out
  Row& add_axis_row(const StepContext& context, int component, int local, double sign);
  // Two links that touch.
  struct Pair {
    struct Side {
      Component* component = nullptr;  // of the link; none: it does not yield
      int position = 0;                // in its links
      double sign = 1.0;
      const LinkMotion* motion = nullptr;  // none: the world
    } side[2];
    double inverse_mass = 0.0;  // of those that yield, together
    Row row;                    // with the sides that each of its rows has
    int numbers = 0;            // of a row
    bool yields(int i) const { return side[i].component != nullptr; }
    Vec3 velocity_at(const Vec3& point) const;  // of b against a
  };
  Pair pair_of(const Manifold& manifold);
  // Of the row along `axis` at the point.
  double along(const Pair& pair, const Row& row, const Vec3& point, const Vec3& axis,
               const double* v) const;
  bool add_contact(const StepContext& context, const Manifold& manifold, const Pair& pair,
                   const ContactPoint& point, const ContactMotion* motions);
  // Of a point's velocity along the axis; without a point of the spin about it.
  Row& add_pair_row(const Pair& pair, const Vec3& axis, const Vec3* point);
  // Velocity of the pair's point along `direction`, or spin about it.
  Row& add_point_row(const Pair& pair, const Vec3& point, const Vec3& velocity,
                     const Vec3& direction);
  Row& add_twist_row(const Pair& pair, const Vec3& axis);
  void share_step_length(int first);
  void finish_row(Row& row);
  void add_limits(const StepContext& context, int joint);
  void add_ball_limit(const StepContext& context, int joint);
  void add_friction(const StepContext& context, int joint);
  void add_law(const StepContext& context, const AxisLaw& law);
  void add_coupling(const StepContext& context, int coupling);
  int local_of(int component, int speed) const;

  Mechanism& mechanism_;
  RowSet& set_;
  const std::vector<LinkMotion>& motions_;
};

}  // namespace cogrsim::dynamics
