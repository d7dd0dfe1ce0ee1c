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

/// Numbers of a row that concern one component: J and W = M^-1 J^T, in the pool of the set.
struct RowSide {
  int component = -1;
  int size = 0;
  int speeds = 0;       ///< first entry in arrays over all components
  std::uint32_t j = 0;  ///< of J in RowSet::pool; W comes after it
  std::size_t w() const { return std::size_t(j) + std::size_t(size); }
};

/// J v + gamma lambda = target, with low <= lambda <= high; v is the velocity at the end of the
/// step.
struct Row {
  RowSide side[2];
  int sides = 0;
  double now = 0.0;       ///< J u at the middle of the step, motion of kinematic bodies included
  double diagonal = 0.0;  ///< J M^-1 J^T + gamma
  double inverse_diagonal = 0.0;
  double gamma = 0.0;
  double target = 0.0;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  double lambda = 0.0;  ///< impulse [N s] or [N m s]

  // Position stage: the gap at the end of the step is `gap` + J (h/2 dv + p), p a displacement.
  bool has_gap = false;
  bool equality =
      false;  ///< the gap is brought to `gap_target` from either side, within the bounds
  bool bilateral = false;  ///< with l > 0 the gap is brought to `gap_target` from above, too
  bool hits = false;       ///< its impulse is that of an impact
  /// Of a contact with restitution: it bounces, or it is open by the end, unless an impact closes it.
  enum class Impact : std::uint8_t { none, waits, bounces } impact = Impact::none;
  double restitution = 0.0;
  bool stays =
      false;  ///< without the impulses the gap is closed by the end, and it shall not bounce
  bool deep = false;  ///< joints hold the bodies, which overlap
  double gap = 0.0;
  double gap_target = 0.0;
  double position_impulse = 0.0;  ///< multiplier of the displacement [N s^2]; before: warm start
  double gap_change = 0.0;        ///< what the displacement adds to the gap

  // A joint's rows: where efforts and warm starts are stored.
  int effort = -1;  ///< flat speed index
  double effort_sign = 1.0;
  int motor = -1;
  int coupling = -1;
  int slot = -1;  ///< of the warm-start memory
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
  double friction = 0.0;
  double rolling = 0.0, spinning = 0.0;  ///< largest torque per load [m]
  FrictionKind kind = FrictionKind::point;
  int partner = -1;    ///< contact with the other point of the line; patch and twist only
  double lever = 0.0;  ///< twist: torque per load and friction [m]
  ContactPoint point;
  Vec3 tangent1 = Vec3::Zero(), tangent2 = Vec3::Zero();
  int friction_rows() const {
    if (friction <= 0.0) return 0;
    return kind == FrictionKind::twist ? 1 : 2;
  }
  int turning_rows() const { return (rolling > 0.0 ? 2 : 0) + (spinning > 0.0 ? 1 : 0); }
  int first_turning() const { return first + 1 + friction_rows(); }
  /// The axis of row `i` of those against turning.
  const Vec3& turning_axis(int i) const {
    if (rolling <= 0.0 || i == 2) return point.normal;
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

class RowSet {
 public:
  void clear();
  std::vector<Row> rows;     ///< all
  std::vector<int> scalars;  ///< joints' rows, solved one by one
  std::vector<BallFriction> balls;
  std::vector<BallLimit> ball_limits;
  std::vector<ContactRows> contacts;
  std::vector<double> pool;
  bool empty() const { return rows.empty(); }
  /// Number of joints' rows, which come before those of contacts.
  std::size_t joint_rows() const {
    return contacts.empty() ? rows.size() : std::size_t(contacts.front().first);
  }

  /// J v for v over all components.
  double along(const Row& row, const double* v) const {
    double sum = 0.0;
    for (int s = 0; s < row.sides; ++s) {
      const RowSide& side = row.side[s];
      const double* const j = &pool[side.j];
      const double* const x = v + side.speeds;
      for (int k = 0; k < side.size; ++k) sum += j[k] * x[k];
    }
    return sum;
  }
  /// v += W impulse.
  void apply(const Row& row, double impulse, double* v) const {
    for (int s = 0; s < row.sides; ++s) {
      const RowSide& side = row.side[s];
      const double* const w = &pool[side.w()];
      double* const x = v + side.speeds;
      for (int k = 0; k < side.size; ++k) x[k] += w[k] * impulse;
    }
  }
};

/// What the rows of a step are made from. All at the middle of the step.
struct StepContext {
  double h = 0.0;  ///< length of the step [s]
  double bounce_threshold = 0.05;
  const double* u = nullptr;           ///< speeds, over all components
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

/// Where rows, numbers and contacts of a set end.
struct RowEnds {
  std::size_t rows = 0, pool = 0, contacts = 0;
};

class RowBuilder {
 public:
  /// The mechanism's state stays while rows are added. They are added from `begin` on; the set has
  /// entries for them already.
  RowBuilder(Mechanism& mechanism, RowSet& set, const RowEnds& begin)
      : mechanism_(mechanism), set_(set), motions_(mechanism.motions()), end_(begin) {}
  /// At the end of the set, which grows.
  RowBuilder(Mechanism& mechanism, RowSet& set)
      : RowBuilder(mechanism, set, {set.rows.size(), set.pool.size(), set.contacts.size()}) {
    grows_ = true;
  }

  /// Adds the joints' rows: limits about to be reached, friction, implicit laws.
  void add_joint_rows(const StepContext& context, const std::vector<AxisLaw>& laws);

  /// Adds the rows of one contact between two bodies of the model. `line`: the pair touches along a
  /// line; this point is one end and `other` the other, which came before if `second`.
  /// `surface_velocity`: see Detector::surface_velocity.
  struct ContactLine {
    const ContactPoint* other = nullptr;
    bool second = false;
  };
  /// `turning`: see turning_of(); `friction_turning`: likewise where friction acts, the middle of a line.
  void add_contact(const StepContext& context, const ContactPoint& point, int body_a, int body_b,
                   const SurfacePair& surface, const ContactLine& line,
                   const Vec3& surface_velocity, const Vec3& turning, const Vec3& friction_turning);

  /// Index in the warm-start memory; `index`: flat speed index, motor or coupling.
  static int slot_of(const SceneModel& model, SlotKind kind, int index);
  static int slot_count(const SceneModel& model);

  /// What add_contact() adds. Of bodies that no joint holds only: then one contact, always.
  RowEnds measure_contact(int body_a, int body_b, const SurfacePair& surface,
                          const ContactLine& line) const;
  bool jointed(int link) const;

 private:
  Row& next_row();
  /// Index in the pool of so many zeros.
  std::size_t next_numbers(std::size_t count);
  Row& add_axis_row(const StepContext& context, int component, int local, double sign);
  // Two links at a point of both.
  struct Pair {
    struct Side {
      Component* component = nullptr;  // of the link; none: it does not yield
      int link = -1;
      double sign = 1.0;
      Vec3 arm = Vec3::Zero();  // from the component's origin
    } side[2];
    Vec3 velocity = Vec3::Zero();  // of b against a
    bool yields(int i) const { return side[i].component != nullptr; }
  };
  Pair pair_at(int link_a, int link_b, const Vec3& point);
  // Velocity of the pair's point along `direction`, or spin about it.
  Row& add_point_row(const Pair& pair, const Vec3& direction);
  Row& add_twist_row(const Pair& pair, const Vec3& axis);
  void add_sides(Row& row, const Pair& pair, const Spatial* wrenches);
  /// Another side of a row, with memory for its numbers.
  RowSide& next_side(Row& row, int component);
  void share_step_length(int first);
  void add_free_body_side(Row& row, int component, const Spatial& wrench, double sign);
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
  RowEnds end_;
  bool grows_ = false;
};

}  // namespace cogrsim::dynamics
