// Conditions on velocities, put to ODE as joints that live for one step.
//
// ODE solves, at the start of a step, rows J v1 + cfm f = c with bounds on the force f. Its own
// hinges and motors decide c and J for themselves; the rows here are given both, so that coordinates,
// limits and laws are those of the SDK. No joint outlives its step: what ODE remembers of the past is
// nothing, and its order of rows is the order in which they were asked for.
#pragma once

#include <deque>
#include <limits>
#include <vector>

#include "body_state.h"
#include "engine.h"

namespace cogrsim::ode {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// A body as rows see it: with a dBodyID when forces move it, else a given motion.
struct RowBody {
  dBodyID id = nullptr;                     ///< null: immovable
  Vec3 c = Vec3::Zero();                    ///< point that `v` belongs to [m]
  Vec3 v = Vec3::Zero(), w = Vec3::Zero();  ///< what ODE starts from; of immovable ones: for good
  double inverse_mass = 0.0;
  Mat3 inverse_inertia = Mat3::Zero();  ///< world

  Vec3 at(const Vec3& point) const { return v + w.cross(point - c); }
};

/// Force and torque (about the given point) of one row group on the second body.
class Rows {
 public:
  explicit Rows(Engine& engine) : engine_(engine) {}

  /// Length of the step the rows are for [s].
  void set_step(double h) { h_ = h; }

  /// Forgets all rows.
  void clear();
  std::size_t size() const { return used_; }  ///< row groups asked for
  int count() const { return count_; }        ///< single rows asked for

  // All speeds are of b relative to a; each returns a handle for wrench().

  /// v_b(at_b) - v_a(at_a) = target, three rows; adds its handles to `handles`. `softness` is the part
  /// of the speed that a force gives in one step by which the rows yield to it.
  void point(const RowBody& a, const RowBody& b, const Vec3& at_a, const Vec3& at_b,
             const Vec3& target, double softness, std::vector<int>& handles);
  /// d_i . (v_b - v_a)(at) = target_i for one or two perpendicular directions, with force bounds and
  /// softness [m/s per N].
  int along(const RowBody& a, const RowBody& b, const Vec3& at, int directions, const Vec3* d,
            const double* target, double bound = kNoBound, double cfm = 0.0);
  /// d_i . (w_b - w_a) = target_i, up to three rows.
  int turn(const RowBody& a, const RowBody& b, int directions, const Vec3* d, const double* target,
           double bound = kNoBound, double cfm = 0.0);
  /// d . (v_b - v_a)(at) >= target.
  int stop_along(const RowBody& a, const RowBody& b, const Vec3& at, const Vec3& d, double target);
  /// d . (w_b - w_a) >= target.
  int stop_turn(const RowBody& a, const RowBody& b, const Vec3& d, double target);

  /// One contact point: n from a to b, friction along s and n x s.
  struct Touch {
    Vec3 at = Vec3::Zero(), n = Vec3::UnitZ(), s = Vec3::UnitX();
    double target = 0.0;  ///< n . (v_b - v_a) >= target
    double cfm = 0.0, slip = 0.0;
    double friction = 0.0;   ///< coefficient
    bool fixed_cap = false;  ///< `cap` bounds the friction along s, `cap_t` along n x s [N]
    double cap = 0.0, cap_t = 0.0;
  };
  int touch(const RowBody& a, const RowBody& b, const Touch& touch);

  /// On b, torque about `about`, world axes. After the step.
  Wrench wrench(int handle, const RowBody& a, const RowBody& b, const Vec3& about) const;

 private:
  struct Made {
    dJointFeedback feedback;
    bool swapped;
  };
  int contact(const RowBody& a, const RowBody& b, dContact& c, int rows);
  int attach(dJointID joint, const RowBody& first, const RowBody& second, bool swapped, int rows);

  Engine& engine_;
  std::deque<Made> made_;  // ODE keeps pointers to the feedbacks
  std::size_t used_ = 0;
  int count_ = 0;
  double h_ = 1e-3;
};

}  // namespace cogrsim::ode
