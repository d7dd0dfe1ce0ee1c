#include "cogrsim/physics/tree_dynamics.h"

#include <catch2/catch.hpp>

#include "cogrsim/core/random.h"
#include "cogrsim/model/builder.h"

using namespace cogrsim;

// Without weights and efforts of other kinds, u . c = d/dt (u M u / 2) at constant speeds u: what the
// Coriolis and gyroscopic terms do is the change of the kinetic energy by that of the mass matrix.
TEST_CASE("Coriolis terms agree with the change of the mass matrix", "[dynamics]") {
  const JointType type =
      GENERATE(JointType::hinge, JointType::slider, JointType::screw, JointType::cylindrical,
               JointType::universal, JointType::planar, JointType::gimbal);
  CAPTURE(to_string(type));
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  Mat3 inertia = Vec3(0.2, 0.5, 0.4).asDiagonal();
  const int first =
      builder.body("first", 2.0, inertia, Pose(Vec3(0.1, 0.2, 0.3), Quat(1, 0, 0, 0)));
  const int second =
      builder.body("second", 1.0, inertia, Pose(Vec3(0.4, -0.2, 1), Quat(1, 0, 0, 0)));
  builder.joint("base", type, kWorld, first, Pose());
  const int joint =
      builder.joint("tip", type, first, second, Pose(Vec3(0.2, 0, 0.8), Quat(1, 0, 0, 0)));
  builder.model.joints[joint].pitch = 0.1;
  const SceneModelPtr model = builder.build();
  WorldState state;
  state.poses.resize(2);
  state.twists.resize(2);
  RandomStream random(3, to_string(type));
  for (int i = 0; i < model->joint_speeds; ++i) {
    // These types have as many coordinates as speeds, and speeds are their rates.
    state.joint_positions.push_back(random.uniform(-1.0, 1.0));
    state.joint_velocities.push_back(random.uniform(-2.0, 2.0));
  }
  const Eigen::VectorXd u = Eigen::Map<const Eigen::VectorXd>(
      state.joint_velocities.data(), static_cast<Eigen::Index>(state.joint_velocities.size()));
  const auto energy_after = [&](double time) {
    WorldState later = state;
    for (std::size_t i = 0; i < later.joint_positions.size(); ++i)
      later.joint_positions[i] += time * later.joint_velocities[i];
    return 0.5 * u.dot(mass_matrix(*model, later) * u);
  };
  const double h = 1e-5;
  const double change = (energy_after(h) - energy_after(-h)) / (2 * h);
  const double power = u.dot(inverse_dynamics(*model, state, Eigen::VectorXd::Zero(u.size())));
  // Cut off at h^2 of terms below 1e3, rounding of 1e-15 J / h.
  CHECK(power == Approx(change).margin(1e-7));
}
