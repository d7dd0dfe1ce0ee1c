// Common parts of the conformance tests: the backend under test, a world to run, figures to record.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/frame.h"
#include "record.h"

namespace conformance {

using namespace cogrsim;

inline constexpr double kDegree = kPi / 180.0;
inline constexpr double kDt = 1e-3;       ///< the suite's step unless a test says otherwise [s]
inline constexpr double kGravity = 9.81;  ///< [m/s^2]

/// The backend named by --backend, mutated by --mutate.
const Backend& backend();
/// The backend named by --against; fails the test case when none was given.
const Backend& other_backend();
void set_backends(std::shared_ptr<const Backend> under_test, std::shared_ptr<const Backend> other);

/// Leaves the test case as unsupported when the backend lacks the feature.
void need(const std::string& feature);

/// Records the figure; the test case fails when it exceeds the limit.
void measure(const std::string& label, double value, double limit);
/// Records |value - expected| / |expected|.
void measure_relative(const std::string& label, double value, double expected, double limit);
/// Records a figure that nothing is asserted about.
void observe(const std::string& label, double value);

/// Fails the test case, without any figure, when its steps have taken so much processor time: for
/// engines that take minutes over what others do in a second. The limit is ample, so that the outcome
/// does not depend on the machine.
void give_up_after(double seconds);

/// A world with the state it is in, and one (idle) drive per motor.
class Sim {
 public:
  /// Checks the capabilities (leaves the test case as unsupported when one is missing) and creates
  /// the world; any other error fails the test case.
  explicit Sim(SceneModelPtr model, const Backend& engine = backend());
  explicit Sim(ModelBuilder& builder, const Backend& engine = backend())
      : Sim(builder.build(), engine) {}

  /// One step; a step that diverges fails the test case.
  void step(double dt = kDt);
  /// llround(seconds / dt) steps; `after_each` sees the state after every one.
  void run(double seconds, double dt = kDt, const std::function<void()>& after_each = {});

  World& world() { return *world_; }
  /// The scene as the test described it (not as a mutation changed it).
  const SceneModel& model() const { return *model_; }
  const SceneModelPtr& model_ptr() const { return model_; }

  const WorldState& state();
  const Pose& pose(int body) { return state().poses[body]; }
  const Twist& twist(int body) { return state().twists[body]; }
  /// Coordinate and speed of a joint.
  double q(int joint, int i = 0);
  double u(int joint, int i = 0);
  double effort(int joint, int i = 0);
  double motor_effort(int motor) { return state().motor_efforts[motor]; }
  const std::vector<Contact>& contacts();
  /// Sum of the contact forces on `body` in the last step [N].
  Vec3 contact_force(int body);
  Wrench reaction(int joint);
  /// Energy and momentum by the SDK's definition, with the test's own model.
  double energy();
  Momentum momentum() { return momentum_of(*model_, state()); }
  std::uint64_t hash() { return state_hash(state()); }
  /// Continues the world with the model `next` after add() or remove().
  void adopt_model() { model_ = world_->model(); }
  void forget_state() { fresh_ = false; }

  Drive& drive(int motor) { return drives[motor]; }
  std::vector<Drive> drives;

 private:
  SceneModelPtr model_;
  std::unique_ptr<World> world_;
  WorldState state_;
  std::vector<Contact> contacts_;
  bool fresh_ = false;
};

/// Pose without rotation.
inline Pose at(double x, double y, double z) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }
/// Turn by `angle` [rad] about `axis`.
inline Quat turn(const Vec3& axis, double angle) {
  return Quat(Eigen::AngleAxisd(angle, axis.normalized()));
}
/// Angle between two orientations [rad], 0 to pi.
double angle_between(const Quat& a, const Quat& b);

/// A drive that is an ideal speed source bounded by `max_effort`.
Drive speed_source(double velocity, double max_effort = kInfinity);
/// A drive with the constant effort `effort`.
Drive constant_effort(double effort);

/// Least-squares line y = a + b t: its slope, without the disturbance of a start transient when the
/// samples begin after it.
class LineFit {
 public:
  void add(double t, double y);
  double slope() const;

 private:
  double n_ = 0, t_ = 0, y_ = 0, tt_ = 0, ty_ = 0;
};

/// Times at which a sampled signal passes `level` upwards, by linear interpolation.
class Crossings {
 public:
  explicit Crossings(double level = 0.0) : level_(level) {}
  void add(double t, double y);
  const std::vector<double>& times() const { return times_; }
  /// Mean distance of the crossings; 0 with fewer than two.
  double period() const;

 private:
  double level_, last_t_ = 0, last_y_ = 0;
  bool started_ = false;
  std::vector<double> times_;
};

}  // namespace conformance
