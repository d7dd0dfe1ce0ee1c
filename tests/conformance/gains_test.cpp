// Gains are what the scene says, whatever the step, the number of motors and the place of the
// start.
#include "axis_rig.h"

#include "cogrsim/physics/warnings.h"

namespace conformance {
namespace {

constexpr double kMotors = 5e-3;  // relative

Mat3 ball_inertia(double moment) { return Mat3(Vec3::Constant(moment).asDiagonal()); }

// A motor of 2 N m/A and 2 V s/rad at its gear's output and 1 ohm, at 12 V, on a rotor of 1e-3 kg
// m^2: its speed without load is 12 V / (2 V s/rad) = 6 rad/s, half of that under half of its stall
// torque of 24 N m. The time constant I R / k^2 of 0.25 ms is below or about all steps, and long
// past after half a second: what is left is the law itself, which no step changes. The bound is
// that of the other motors' tests.
TEST_CASE("a DC motor's speed does not depend on the step", "[motors]") {
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  constexpr double kStall = 24.0, kDamping = 4.0;
  for (const char* name : {"free", "loaded", "bounded"}) {
    const double y = static_cast<double>(builder.model.bodies.size());
    const int rotor = builder.body(name, 0.1, ball_inertia(1e-3), at(0, y, 0));
    builder.motor(name, builder.joint(name, JointType::hinge, kWorld, rotor, at(0, y, 0)),
                  MotorMode::dc);
  }
  builder.motor("load", 1, MotorMode::torque);
  builder.motor("brake", 2, MotorMode::torque);
  const SceneModelPtr model = builder.build();
  for (const double dt : {0.25e-3, 0.5e-3, 1e-3, 2e-3, 4e-3}) {
    Sim sim(model);
    for (const int motor : {0, 1, 2}) {
      sim.drive(motor) = constant_effort(kStall);
      sim.drive(motor).kd = kDamping;
    }
    sim.drive(3) = constant_effort(-12.0);
    // Its current's bound is 3/4 of the stall torque, against which it turns at 1/4 of its speed: a
    // load of 2/3 of that it takes at 1/2.
    sim.drive(2).max_effort = 18.0;
    sim.drive(4) = constant_effort(-12.0);
    sim.run(0.5, dt);
    measure_relative("speed without load", sim.u(0), 6.0, kMotors);
    measure_relative("speed under half the stall torque", sim.u(1), 3.0, kMotors);
    measure_relative("effort under half the stall torque", sim.motor_effort(1), 12.0, kMotors);
    measure_relative("speed below the bound of the current", sim.u(2), 3.0, kMotors);
    // A load beyond the bound drives it backwards, and it gives its bound.
    sim.drive(4) = constant_effort(-18.5);
    const double before = sim.u(2);
    sim.run(0.008, dt);
    measure_relative("effort at the bound of the current", sim.motor_effort(2), 18.0, kMotors);
    CHECK(sim.u(2) < before);
  }
}

// Twelve equal limbs on a heavy trunk in space, each with a servo and a load that alternates, so
// that the trunk stays at rest: at rest a limb is off its target by load / kp, whatever the others
// do. The slowest of the poles, kd / kp = 50 ms, has decayed by exp(-60) after 3 s; the loads'
// error is rounding.
TEST_CASE("twelve motors of one tree hold their gains", "[motors]") {
  // In steps of 2 ms damping stops a limb of 0.01 kg m^2 in 2.5 of them, or in a twentieth of one.
  const double stiffness = GENERATE(1.0, 50.0);
  const double kp = 40.0 * stiffness, kd = 2.0 * stiffness, load = 4.0 * stiffness, dt = 2e-3;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int trunk = builder.body("trunk", 30.0, ball_inertia(1.0), at(0, 0, 0));
  for (int i = 0; i < 12; ++i) {
    const Pose X(Vec3(0.1 * i - 0.55, 0, 0), turn(Vec3::UnitX(), 0.3 * (i / 2)));
    const int limb = builder.body("limb" + std::to_string(i), 0.5, ball_inertia(0.01), X);
    const int joint = builder.joint("joint" + std::to_string(i), JointType::hinge, trunk, limb, X);
    builder.motor("servo" + std::to_string(i), joint, MotorMode::servo);
    builder.motor("load" + std::to_string(i), joint, MotorMode::torque);
  }
  Sim sim(builder);
  const auto sign = [](int i) { return i % 2 == 0 ? 1.0 : -1.0; };
  for (int i = 0; i < 12; ++i) {
    Drive& servo = sim.drive(2 * i);
    servo.kp = kp;
    servo.kd = kd;
    servo.position = 0.2 * sign(i);
    sim.drive(2 * i + 1) = constant_effort(-load * sign(i));
  }
  sim.run(3.0, dt);
  for (int i = 0; i < 12; ++i) {
    measure_relative("sag under load", 0.2 - sim.q(i) * sign(i), load / kp, 1e-3);
    measure_relative("effort", sim.motor_effort(2 * i) * sign(i), load, 1e-3);
  }
}

// A servo whose gains would stop its axis in a ten-thousandth of a step, and a bound that turns it
// by 0.02 rad in one: it goes at its bound to where kp and kd balance, and from there in with kd /
// kp = 20 ms, of which half a second leaves exp(-25) of 0.3 rad.
TEST_CASE("a stiff servo with a bound arrives", "[motors]") {
  for (const double target : {0.3, -0.31, 1e-3}) {
    ModelBuilder builder;
    builder.model.physics.gravity = Vec3::Zero();
    const int arm = builder.body("arm", 0.1, ball_inertia(1e-3), at(0, 0, 0));
    const int joint = builder.joint("elbow", JointType::hinge, kWorld, arm, at(0, 0, 0));
    builder.motor("servo", joint, MotorMode::servo);
    Sim sim(builder);
    Drive& servo = sim.drive(0);
    servo.kp = 1e6;
    servo.kd = 2e4;
    servo.position = target;
    servo.max_effort = 5.0;
    double largest = 0.0;
    sim.run(0.5, 2e-3, [&] { largest = std::max(largest, std::abs(sim.motor_effort(0))); });
    measure("effort over its bound, less 1", largest / servo.max_effort - 1.0, 1e-9);
    measure("off its target [rad]", std::abs(sim.q(joint) - target), 1e-6);
    measure("effort left [N m]", std::abs(sim.motor_effort(0)), 1e-3);
  }
}

// A gain without end is either held or said not to be.
TEST_CASE("gains that cannot be held are said", "[motors]") {
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int arm = builder.body("arm", 1.0, ball_inertia(0.01), at(0, 0, 0));
  const int joint = builder.joint("elbow", JointType::hinge, kWorld, arm, at(0, 0, 0));
  const int motor = builder.motor("stiff", joint, MotorMode::servo);
  builder.motor("load", joint, MotorMode::torque);
  const double kp = 1e15;
  builder.model.motors[static_cast<std::size_t>(motor)].kp = kp;
  Sim sim(builder);
  sim.drive(0).kp = kp;
  sim.drive(1) = constant_effort(1.0);
  sim.run(0.5);
  auto* const said = sim.world().extension<WorldWarnings>();
  if (said == nullptr || said->warnings().empty()) {
    // A double has no place for the sag: the effort tells.
    measure_relative("effort", sim.motor_effort(0), -1.0, 1e-3);
    return;
  }
  const Diagnostic warning = said->warnings().front();
  CHECK(warning.code == "CG2008");
  CHECK(warning.message.find("'stiff'") != std::string::npos);
  CHECK(warning.message.find("'elbow'") != std::string::npos);
}

// A double pendulum that swings into its stops, drawn straight and set to where it starts, or drawn
// there: one motion. Both start from the same numbers but for the rounding of poses, which the
// stops magnify at most a thousandfold in a second; stops that are hit a step apart would differ by
// 1e-3.
TEST_CASE("where a joint starts does not change its dynamics", "[joints]") {
  const double q[2] = {0.9, -0.7};
  const auto make = [&](bool drawn_at_start) {
    ModelBuilder builder;
    const int upper = builder.box("upper", Vec3(0.1, 0.05, 0.5), 2.0, at(0, 0, -0.25));
    const int lower = builder.box("lower", Vec3(0.08, 0.05, 0.4), 0.3, at(0, 0, -0.7));
    const auto hinge_at = [](double z) { return Pose(Vec3(0, 0, z), z_to(Vec3::UnitY())); };
    const int shoulder = builder.joint("shoulder", JointType::hinge, kWorld, upper, hinge_at(0.0));
    const int elbow = builder.joint("elbow", JointType::hinge, upper, lower, hinge_at(-0.5));
    auto& joints = builder.model.joints;
    for (const int j : {shoulder, elbow}) {
      joints[static_cast<std::size_t>(j)].axes[0].lower = -0.4 - 0.5 * j;
      joints[static_cast<std::size_t>(j)].axes[0].upper = 1.2;
      joints[static_cast<std::size_t>(j)].axes[0].damping = 0.05;
      joints[static_cast<std::size_t>(j)].axes[0].friction = 0.1;
    }
    if (drawn_at_start) {
      auto& bodies = builder.model.bodies;
      const auto place = [&](int j, int parent, int child) {
        const Joint& joint = joints[static_cast<std::size_t>(j)];
        const Pose X_WP = parent == kWorld ? Pose() : bodies[static_cast<std::size_t>(parent)].X_WB;
        bodies[static_cast<std::size_t>(child)].X_WB =
            X_WP * joint.X_PF * joint_pose(joint, &q[j]) * joint.X_CM.inverse();
      };
      place(shoulder, kWorld, upper);
      place(elbow, upper, lower);
    }
    return builder.build();
  };
  Sim there(make(true)), drawn(make(false));
  WorldState start = there.state();
  REQUIRE(drawn.world().set_state(start));
  drawn.forget_state();
  Worst apart;
  there.run(1.0, kDt, [&] {
    drawn.step();
    for (const int j : {0, 1}) apart.see(there.q(j), drawn.q(j));
  });
  measure("apart [rad]", apart.error, 1e-9);
}

// Friction goes on while a box bounces: mu times the mean load, which is the weight. It stops after
// v^2 / (2 mu g); 3 % are for what it hops, as it may not touch the floor for half of a hop's time.
TEST_CASE("a box that bounces is stopped by friction", "[friction]") {
  const double e = GENERATE(0.0, 0.5, 0.9, 0.99, 1.0);
  const double mu = 0.5, speed = 2.0;
  ModelBuilder builder;
  const int elastic = builder.material("elastic", mu, e);
  builder.plane("floor", Pose(), elastic);
  const int box = builder.box("box", Vec3(0.2, 0.2, 0.1), 1.0, at(0, 0, 0.05), elastic);
  builder.model.bodies[static_cast<std::size_t>(box)].V_WB.linear = Vec3(speed, 0, 0);
  Sim sim(builder);
  sim.run(2.0);
  measure_relative("way", sim.pose(box).p.x(), speed * speed / (2.0 * mu * kGravity), 0.03);
}

}  // namespace
}  // namespace conformance
