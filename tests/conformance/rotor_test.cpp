// Rotors of drives: with them an axis moves as if the body had their inertia, along this axis alone.
#include "axis_rig.h"
#include "cogrsim/physics/warnings.h"

namespace conformance {
namespace {

constexpr double kFits = 2e-3;  // what a method of first order may be off at 1 ms

Joint& joint_of(ModelBuilder& builder, int joint) { return builder.model.joints[joint]; }

TEST_CASE("a double pendulum with rotors", "[joints]") {
  // Two links of 1 kg and 0.5 m, 0.02 kg m^2 about their centres, with rotors of 0.1 kg m^2, from
  // 1 and 0.5 rad: where the equations of motion have them after 3 s, by Runge-Kutta's method of
  // fourth order in steps of 0.1 ms. Without rotors the second one were at 0.37 rad, with n^2 J added
  // to the link at 6.75.
  constexpr double kLength = 0.5, kInertia = 0.02, kRotor = 0.1;
  constexpr double kFirst = -0.530013, kSecond = -1.662843;
  ModelBuilder builder;
  const Pose bearing(Vec3::Zero(), z_to(Vec3::UnitY()));
  int parent = kWorld, joints[2];
  Pose X_WP;
  for (int i = 0; i < 2; ++i) {
    const std::string name = "link_" + std::to_string(i);
    const double angle = i == 0 ? 1.0 : 0.5;
    const Pose X_WB = X_WP * Pose(Vec3(0, 0, i == 0 ? 0.0 : -kLength), turn(Vec3::UnitY(), angle));
    const int body = builder.body(name, 1.0, kInertia * Mat3::Identity(), X_WB);
    builder.model.bodies[body].com = Vec3(0, 0, -0.5 * kLength);
    joints[i] = builder.joint(name, JointType::hinge, parent, body, X_WB * bearing);
    Joint& joint = joint_of(builder, joints[i]);
    joint.X_PF = Pose(Vec3(0, 0, i == 0 ? 0.0 : -kLength), bearing.q);
    joint.position = {angle};
    joint.axes.resize(1);
    joint.axes[0].rotor_inertia = kRotor;
    parent = body;
    X_WP = X_WB;
  }
  Sim sim(builder);
  sim.run(3.0);
  measure("first angle off [rad]", std::abs(sim.q(joints[0]) - kFirst), kFits);
  measure("second angle off [rad]", std::abs(sim.q(joints[1]) - kSecond), kFits);
}

TEST_CASE("a rotor turns a base that floats", "[joints]") {
  // A base of 0.5 kg m^2 and an arm of 0.1 about one axis, a rotor of 0.4 between them. A torque acts
  // on the joint for half a second: the base's share of the relative speed is that of the arm's
  // inertia, whatever the rotor, as the axis alone feels it.
  constexpr double kBase = 0.5, kArm = 0.1, kRotor = 0.4, kTorque = 1.0;
  ModelBuilder builder;
  builder.model.physics.gravity.setZero();
  const int base = builder.body("base", 3.0, kBase * Mat3::Identity(), at(0, 0, 0));
  const int arm = builder.body("arm", 1.0, kArm * Mat3::Identity(), at(0, 0, 0.2));
  const int hinge = builder.joint("hinge", JointType::hinge, base, arm, at(0, 0, 0.2));
  joint_of(builder, hinge).axes.resize(1);
  joint_of(builder, hinge).axes[0].rotor_inertia = kRotor;
  const int motor = builder.motor("motor", hinge, MotorMode::torque);
  Sim sim(builder);
  sim.drive(motor) = constant_effort(kTorque);
  sim.run(0.5);
  const double s = 1.0 / kBase + 1.0 / kArm, relative = 0.5 * kTorque * s / (1.0 + kRotor * s);
  measure("relative speed off [rad/s]", std::abs(sim.u(hinge) - relative), kFits);
  measure("speed of the base off [rad/s]",
          std::abs(sim.twist(base).angular.z() + relative * kArm / (kBase + kArm)), kFits);
}

TEST_CASE("a cart with a rotor is hit", "[joints]") {
  // 1 kg at 1 m/s hits a cart of 1 kg, to which a rotor adds 9 kg along its rail, and loses nothing:
  // 2 / 11 and -9 / 11 m/s.
  ModelBuilder builder;
  builder.model.physics.gravity.setZero();
  builder.model.materials[0].restitution = 1.0;
  builder.model.materials[0].friction = 0.0;
  const int cart = builder.sphere("cart", 0.1, 1.0, at(0, 0, 0));
  const int ball = builder.sphere("ball", 0.1, 1.0, at(-0.5, 0, 0));
  builder.model.bodies[ball].V_WB.linear = Vec3(1, 0, 0);
  const int rail =
      builder.joint("rail", JointType::slider, kWorld, cart, {Vec3::Zero(), z_to(Vec3::UnitX())});
  joint_of(builder, rail).axes.resize(1);
  joint_of(builder, rail).axes[0].rotor_inertia = 9.0;
  Sim sim(builder);
  sim.run(0.6);
  measure("speed of the cart off [m/s]", std::abs(sim.u(rail) - 2.0 / 11.0), kFits);
  measure("speed of the ball off [m/s]", std::abs(sim.twist(ball).linear.x() + 9.0 / 11.0), kFits);
}

/// The same axis twice: its inertia that of the body, and most of it that of a rotor.
void compare(const std::string& what, const std::function<void(AxisRig&)>& arrange,
             const std::function<Drive(double inertia, double time)>& drive) {
  constexpr double kShare = 10.0;  // of the rotor, in the body's inertia
  for (const JointType type : {JointType::hinge, JointType::slider}) {
    const AxisKind kind{to_string(type), type, 0, type == JointType::hinge};
    AxisRig heavy(kind), rotor(kind);
    Body& body = heavy.builder.model.bodies[0];
    body.mass *= 1.0 + kShare;
    body.inertia *= 1.0 + kShare;
    rotor.axis().rotor_inertia = kShare * rotor.inertia;
    const double inertia = (1.0 + kShare) * rotor.inertia;
    for (AxisRig* rig : {&heavy, &rotor}) {
      arrange(*rig);
      rig->motor(MotorMode::torque);
    }
    Sim one(heavy.builder), other(rotor.builder);
    double apart = 0.0, effort = 0.0;
    for (int step = 0; step < 2000; ++step) {
      one.drive(0) = other.drive(0) = drive(inertia, step * kDt);
      one.step();
      other.step();
      apart = std::max(apart, std::abs(heavy.q(one) - rotor.q(other)));
      effort += std::abs(one.motor_effort(0) - other.motor_effort(0)) / inertia * kDt;
    }
    measure(what + ", " + kind.name + ": coordinates apart", apart, kFits);
    // Of 2 s: the speed that the motor's efforts would have made otherwise.
    measure(what + ", " + kind.name + ": efforts apart, over the inertia", effort, 0.05);
  }
}

TEST_CASE("a rotor with a servo, soft and stiff, bounded or not", "[motors]") {
  for (const double frequency : {10.0, 300.0}) {  // [rad/s]; 300: implicit at 1 ms
    for (const double bound : {kInfinity, 4.0}) {
      const auto servo = [&](double inertia, double time) {
        Drive law;
        law.kp = inertia * frequency * frequency;
        law.kd = 2.0 * inertia * frequency * 3.0;
        law.position = std::sin(2.0 * time);
        law.velocity = 2.0 * std::cos(2.0 * time);
        law.max_effort = bound * inertia;
        return law;
      };
      compare(
          "servo of " + std::to_string(int(frequency)) + "/s" +
              (std::isfinite(bound) ? ", bounded" : ""),
          [](AxisRig& rig) { rig.start_speed(2.0); }, servo);
    }
  }
}

TEST_CASE("a rotor with a speed source", "[motors]") {
  for (const double bound : {kInfinity, 2.0}) {
    compare(
        std::isfinite(bound) ? "bounded" : "unbounded", [](AxisRig&) {},
        [&](double inertia, double time) {
          return speed_source(time < 1.0 ? 1.0 : -0.5, bound * inertia);
        });
  }
}

TEST_CASE("a rotor with friction, damping, a spring and stops", "[joints]") {
  const auto idle = [](double inertia, double time) {
    return constant_effort(time < 0.5 ? inertia : 0.0);
  };
  compare(
      "friction", [](AxisRig& rig) { rig.axis().friction = 2.0 * rig.inertia; }, idle);
  compare(
      "damping", [](AxisRig& rig) { rig.axis().damping = 20.0 * rig.inertia; }, idle);
  compare(
      "spring", [](AxisRig& rig) { rig.axis().stiffness = 100.0 * rig.inertia; }, idle);
}

TEST_CASE("a rotor a million times as heavy is held, or warned of", "[joints]") {
  // A chain of two, whose first joint a motor turns at 1 rad/s^2 against rotors of a million times the
  // links' inertia: half a radian in a second.
  constexpr double kInertia = 0.01, kRotor = 1e4;
  ModelBuilder builder;
  builder.model.physics.gravity.setZero();
  int parent = kWorld;
  for (int i = 0; i < 2; ++i) {
    const std::string name = "link_" + std::to_string(i);
    const int link = builder.body(name, 1.0, kInertia * Mat3::Identity(), at(0.5 + i, 0, 0));
    const int hinge =
        builder.joint(name, JointType::hinge, parent, link, at(static_cast<double>(i), 0, 0));
    joint_of(builder, hinge).axes.resize(1);
    joint_of(builder, hinge).axes[0].rotor_inertia = kRotor;
    parent = link;
  }
  const int motor = builder.motor("motor", 0, MotorMode::torque);
  Sim sim(builder);
  auto* const warns = sim.world().extension<WorldWarnings>();
  const bool warned = warns && !warns->warnings().empty();
  sim.drive(motor) = constant_effort(kRotor);
  sim.run(1.0);
  measure("angle off [rad], unless it is warned of", warned ? 0.0 : std::abs(sim.q(0) - 0.5),
          kFits);
}

TEST_CASE("a rotor stops at a limit", "[limits]") {
  for (const JointType type : {JointType::hinge, JointType::slider}) {
    AxisRig rig({to_string(type), type, 0, type == JointType::hinge});
    rig.axis().rotor_inertia = 10.0 * rig.inertia;
    rig.axis().upper = 0.2;
    rig.start_speed(1.0);
    const int motor = rig.motor(MotorMode::torque);
    Sim sim(rig.builder);
    double beyond = 0.0;
    sim.drive(motor) = constant_effort(10.0 * rig.inertia);
    sim.run(1.0, kDt, [&] { beyond = std::max(beyond, rig.q(sim) - 0.2); });
    measure("overshoot", beyond, 2.0 * kDt);
    measure("place against the limit", std::abs(rig.q(sim) - 0.2), 1e-3);
  }
}

}  // namespace
}  // namespace conformance
