// Coupled joints, rotors of drives, and bodies whose weight is scaled: closed forms.
#include "support.h"

namespace conformance {
namespace {

constexpr double kMass = 1.0, kLength = 1.0;
constexpr double kRodInertia = kMass * kLength * kLength / 3.0;  // about its end [kg m^2]

Mat3 diagonal(double x, double y, double z) { return Vec3(x, y, z).asDiagonal(); }

// A thin rod that hangs from `pivot` on a hinge along y; returns the hinge.
int hang_rod(ModelBuilder& builder, const std::string& name, const Vec3& pivot) {
  const double transverse = kMass * kLength * kLength / 12.0;
  const int rod = builder.body(name, kMass, diagonal(transverse, transverse, 0.01 * transverse),
                               at(pivot.x(), pivot.y(), pivot.z() - 0.5 * kLength));
  return builder.joint(name + "_hinge", JointType::hinge, kWorld, rod,
                       {pivot, z_to(Vec3::UnitY())});
}

// A body on a hinge along y through its centre, which gravity does not turn; returns the hinge.
int add_wheel(ModelBuilder& builder, const std::string& name, double inertia, const Vec3& centre) {
  const int wheel =
      builder.body(name, kMass, inertia * Mat3::Identity(), at(centre.x(), centre.y(), centre.z()));
  return builder.joint(name + "_hinge", JointType::hinge, kWorld, wheel,
                       {centre, z_to(Vec3::UnitY())});
}

void couple(ModelBuilder& builder, int joint, std::vector<CouplingTerm> terms,
            double max_effort = kInfinity) {
  Coupling coupling;
  coupling.name = "coupling_" + std::to_string(builder.model.couplings.size());
  coupling.joint = joint;
  coupling.terms = std::move(terms);
  coupling.max_effort = max_effort;
  builder.model.couplings.push_back(std::move(coupling));
}

Joint& joint_of(ModelBuilder& builder, int joint) { return builder.model.joints[joint]; }

// Period of the small swing of a rod about its end, with an inertia added to its own [s].
double swing_period(double added) {
  return 2.0 * kPi * std::sqrt((kRodInertia + added) / (kMass * kGravity * 0.5 * kLength));
}

constexpr double kSwing = 1.0 * kDegree;
// The period of a pendulum grows by its amplitude squared over 16 (2e-5), and that of a symplectic
// method of first order errs by (w dt)^2 / 24 (6e-7).
constexpr double kPeriodLimit = 3e-5;

double measured_period(Sim& sim, int hinge) {
  Crossings crossings;
  double t = 0.0;
  sim.run(20.0, kDt, [&] { crossings.add(t += kDt, sim.q(hinge)); });
  REQUIRE(crossings.times().size() >= 5);
  return crossings.period();
}

void start_at(ModelBuilder& builder, int hinge, double angle) {
  Joint& joint = joint_of(builder, hinge);
  joint.position = {angle};
  Body& body = builder.model.bodies[joint.child];
  const Pose X_FC = joint.X_CM.inverse();
  body.X_WB = joint.X_PF * Pose(Vec3::Zero(), turn(Vec3::UnitZ(), angle)) * X_FC;
}

TEST_CASE("a rotor adds its inertia to a pendulum", "[joints]") {
  ModelBuilder builder;
  const int hinge = hang_rod(builder, "rod", Vec3(0, 0, 2));
  constexpr double kRotor = 0.25;  // [kg m^2]
  joint_of(builder, hinge).axes[0].rotor_inertia = kRotor;
  start_at(builder, hinge, kSwing);
  Sim sim(builder);
  const double start = sim.energy();
  measure_relative("period", measured_period(sim, hinge), swing_period(kRotor), kPeriodLimit);
  // Of what it can lose, m g d (1 - cos): a method of first order makes it vary by w dt / 2.
  const double most = kMass * kGravity * 0.5 * kLength * (1.0 - std::cos(kSwing));
  measure("energy off, share of the swing's", std::abs(sim.energy() - start) / most, 5e-3);
}

TEST_CASE("a rotor between two bodies in space", "[joints]") {
  // T = (I1 w1^2 + I2 w2^2 + Ir (w2 - w1)^2) / 2: with s = 1 / I1 + 1 / I2 a torque M on the joint
  // gives the relative acceleration M s / (1 + Ir s), and no momentum.
  constexpr double kFirst = 0.2, kSecond = 0.05, kRotor = 0.3, kTorque = 0.1;
  ModelBuilder builder;
  builder.model.physics.gravity.setZero();
  const int first = builder.body("first", 1.0, kFirst * Mat3::Identity(), at(0, 0, 0));
  const int second = builder.body("second", 1.0, kSecond * Mat3::Identity(), at(0, 0, 0));
  const int hinge = builder.joint("hinge", JointType::hinge, first, second, at(0, 0, 0));
  joint_of(builder, hinge).axes[0].rotor_inertia = kRotor;
  const int motor = builder.motor("motor", hinge, MotorMode::torque);
  Sim sim(builder);
  sim.drive(motor) = constant_effort(kTorque);
  sim.run(1.0);
  const double s = 1.0 / kFirst + 1.0 / kSecond;
  measure_relative("relative speed", sim.u(hinge), kTorque * s / (1.0 + kRotor * s), 1e-9);
  measure("angular momentum [kg m^2/s]", sim.momentum().angular.norm(), 1e-12);
}

TEST_CASE("a geared flywheel adds to a pendulum's inertia", "[joints]") {
  constexpr double kRatio = -3.0, kWheel = 0.02;
  ModelBuilder builder;
  const int hinge = hang_rod(builder, "rod", Vec3(0, 0, 2));
  const int wheel = add_wheel(builder, "wheel", kWheel, Vec3(2, 0, 2));
  couple(builder, wheel, {{hinge, kRatio}});
  start_at(builder, hinge, kSwing);
  start_at(builder, wheel, kRatio * kSwing);
  Sim sim(builder);
  double gap = 0.0;
  Crossings crossings;
  double t = 0.0;
  sim.run(20.0, kDt, [&] {
    crossings.add(t += kDt, sim.q(hinge));
    gap = std::max(gap, std::abs(sim.q(wheel) - kRatio * sim.q(hinge)));
  });
  REQUIRE(crossings.times().size() >= 5);
  measure_relative("period", crossings.period(), swing_period(kRatio * kRatio * kWheel),
                   kPeriodLimit);
  measure("coordinates apart [rad]", gap, 1e-9);
}

TEST_CASE("a differential shares a torque", "[joints]") {
  // q_c = (q_a + q_b) / 2, so a torque M on c is M / 2 on a and on b:
  // (I_a + I_c / 4) a'' + I_c / 4 b'' = M / 2, and the same for b.
  constexpr double kA = 0.1, kB = 0.3, kC = 0.2, kTorque = 0.5;
  ModelBuilder builder;
  const int a = add_wheel(builder, "a", kA, Vec3(0, 0, 0));
  const int b = add_wheel(builder, "b", kB, Vec3(1, 0, 0));
  const int c = add_wheel(builder, "c", kC, Vec3(2, 0, 0));
  couple(builder, c, {{a, 0.5}, {b, 0.5}});
  const int motor = builder.motor("motor", c, MotorMode::torque);
  Sim sim(builder);
  sim.drive(motor) = constant_effort(kTorque);
  sim.run(1.0);
  Eigen::Matrix2d inertia;
  inertia << kA + 0.25 * kC, 0.25 * kC, 0.25 * kC, kB + 0.25 * kC;
  const Eigen::Vector2d speed = inertia.inverse() * Eigen::Vector2d::Constant(0.5 * kTorque);
  measure_relative("speed of a", sim.u(a), speed[0], 1e-7);
  measure_relative("speed of b", sim.u(b), speed[1], 1e-7);
  measure("c off the mean [rad]", std::abs(sim.q(c) - 0.5 * (sim.q(a) + sim.q(b))), 1e-9);
}

// Two masses on vertical sliders, coupled as by a rope over a pulley.
struct Atwood {
  static constexpr double kHeavy = 3.0, kLight = 2.0;
  ModelBuilder builder;
  int heavy = 0, light = 0;
  explicit Atwood(double max_effort) {
    const auto add = [&](const std::string& name, double mass, double x) {
      const int body = builder.body(name, mass, Mat3::Identity(), at(x, 0, 0));
      return builder.joint(name + "_slider", JointType::slider, kWorld, body, at(x, 0, 0));
    };
    heavy = add("heavy", kHeavy, 0.0);
    light = add("light", kLight, 1.0);
    couple(builder, light, {{heavy, -1.0}}, max_effort);
  }
};

TEST_CASE("Atwood's machine", "[joints]") {
  Atwood machine(kInfinity);
  Sim sim(machine.builder);
  sim.run(0.5);
  const double expected =
      kGravity * (Atwood::kHeavy - Atwood::kLight) / (Atwood::kHeavy + Atwood::kLight);
  measure_relative("speed", -sim.u(machine.heavy), 0.5 * expected, 1e-7);
  // The rope's tension, on the follower.
  need("report.joint_effort");
  measure_relative("effort", sim.effort(machine.light), Atwood::kLight * (kGravity + expected),
                   1e-6);
}

TEST_CASE("a coupling slips at its largest effort", "[joints]") {
  constexpr double kMost = 10.0;  // [N], less than the 23.5 N that hold
  Atwood machine(kMost);
  Sim sim(machine.builder);
  sim.run(0.5);
  measure_relative("speed of the heavy one", -sim.u(machine.heavy),
                   0.5 * (kGravity - kMost / Atwood::kHeavy), 1e-7);
  measure_relative("speed of the light one", -sim.u(machine.light),
                   0.5 * (kGravity - kMost / Atwood::kLight), 1e-7);
}

constexpr double kRatioLimit = 1e-3;  // [rad], [m]
constexpr double kWorkLimit = 0.02;   // of the work that was done

double relation(Sim& sim, const Coupling& coupling) {
  double gap = sim.q(coupling.joint) - coupling.offset;
  for (const CouplingTerm& term : coupling.terms) gap -= term.ratio * sim.q(term.joint);
  return std::abs(gap);
}

/// Runs, and measures how far couplings were off and whether what motors put in is there or was lost in
/// the damping of joints.
void run_coupled(Sim& sim, double seconds, const std::function<void(double time)>& drive) {
  const double start = sim.energy();
  double gap = 0.0, put_in = 0.0, lost = 0.0, turned_over = 0.0;
  for (double t = 0.0; t < seconds; t += kDt) {
    drive(t);
    std::vector<double> before;
    for (const Joint& joint : sim.model().joints)
      before.push_back(sim.state().joint_positions[joint.position_offset]);
    sim.step();
    for (const Coupling& coupling : sim.model().couplings)
      gap = std::max(gap, relation(sim, coupling));
    for (std::size_t m = 0; m < sim.model().motors.size(); ++m) {
      const int j = sim.model().motors[m].joint;
      const double work = sim.motor_effort(int(m)) * (sim.q(j) - before[j]);
      put_in += work;
      turned_over += std::abs(work);
    }
    for (std::size_t j = 0; j < before.size(); ++j) {
      const int joint = static_cast<int>(j);
      lost += sim.model().joints[j].axes[0].damping * sim.u(joint) * (sim.q(joint) - before[j]);
    }
  }
  measure("relation off [rad], [m]", gap, kRatioLimit);
  measure("work lost or gained, share of what motors did",
          std::abs(put_in - lost - (sim.energy() - start)) / turned_over, kWorkLimit);
}

Drive servo(double kp, double kd, double position, double velocity, double bound = kInfinity) {
  Drive law;
  law.kp = kp;
  law.kd = kd;
  law.position = position;
  law.velocity = velocity;
  law.max_effort = bound;
  return law;
}

TEST_CASE("a gear pair drives a load", "[joints]") {
  // A small wheel that a servo sways by 1 rad turns one of 60 times its reflected inertia, which brakes
  // and carries a weight.
  constexpr double kSmall = 2e-3, kLarge = 0.03;
  ModelBuilder builder;
  const int small = add_wheel(builder, "small", kSmall, Vec3(0, 0, 0));
  const int large = add_wheel(builder, "large", kLarge, Vec3(1, 0, 0));
  builder.model.bodies[1].com = Vec3(0, 0, -0.05);
  joint_of(builder, large).axes.resize(1);
  joint_of(builder, large).axes[0].damping = 0.1;
  couple(builder, large, {{small, -2.0}});
  const int motor = builder.motor("motor", small, MotorMode::servo);
  Sim sim(builder);
  run_coupled(sim, 4.0, [&](double t) {
    const double w = 3.0;
    sim.drive(motor) = servo(20.0, 2.0, 1.0 - std::cos(w * t), w * std::sin(w * t));
  });
}

TEST_CASE("a leader with a speed source feels its follower", "[joints]") {
  // A wheel of a hundredth of its follower's inertia is turned at 2 rad/s by a motor with a bound.
  constexpr double kLight = 1e-3, kHeavy = 0.1, kBound = 0.05;
  ModelBuilder builder;
  const int light = add_wheel(builder, "light", kLight, Vec3(0, 0, 0));
  const int heavy = add_wheel(builder, "heavy", kHeavy, Vec3(1, 0, 0));
  couple(builder, heavy, {{light, 1.0}});
  const int motor = builder.motor("motor", light, MotorMode::velocity);
  Sim sim(builder);
  sim.drive(motor) = speed_source(2.0, kBound);
  double gap = 0.0;
  const auto see = [&] { gap = std::max(gap, relation(sim, sim.model().couplings[0])); };
  sim.run(2.0, kDt, see);
  measure_relative("speed under the bound", sim.u(light), 2.0 * kBound / (kLight + kHeavy), 5e-3);
  sim.run(4.0, kDt, see);
  measure_relative("speed at last", sim.u(heavy), 2.0, 1e-3);
  measure("relation off [rad]", gap, kRatioLimit);
}

/// A hand on a wrist that turns about x; its two fingers slide along y, one as far as the other.
struct Gripper {
  ModelBuilder builder;
  int wrist = 0, left = 0, right = 0, turn_motor = 0, grip = 0;
  Gripper() {
    const int hand = builder.body("hand", 0.7, diagonal(2e-3, 2e-3, 2e-3), at(0, 0, 0));
    wrist =
        builder.joint("wrist", JointType::hinge, kWorld, hand, {Vec3::Zero(), z_to(Vec3::UnitX())});
    const auto finger = [&](const std::string& name, double side) {
      const int body =
          builder.body(name, 0.02, diagonal(2e-5, 2e-5, 2e-5), at(0.1, side * 0.02, 0));
      return builder.joint(name, JointType::slider, hand, body,
                           {Vec3(0.1, side * 0.02, 0), z_to(side * Vec3::UnitY())});
    };
    left = finger("left", 1.0);
    right = finger("right", -1.0);
    for (Joint& joint : builder.model.joints) joint.axes.resize(1);
    couple(builder, right, {{left, 1.0}});
    turn_motor = builder.motor("turn", wrist, MotorMode::servo);
    grip = builder.motor("grip", left, MotorMode::servo);
  }
};

TEST_CASE("fingers that slide follow each other on a turning wrist", "[joints]") {
  Gripper gripper;
  for (const int finger : {gripper.left, gripper.right})
    joint_of(gripper.builder, finger).axes[0].damping = 2.0;
  Sim sim(gripper.builder);
  run_coupled(sim, 3.0, [&](double t) {
    sim.drive(gripper.turn_motor) =
        servo(50.0, 1.0, 2.0 * (1.0 - std::cos(2.0 * t)), 4.0 * std::sin(2.0 * t));
    sim.drive(gripper.grip) =
        servo(500.0, 20.0, 0.01 * std::sin(10.0 * t), 0.1 * std::cos(10.0 * t));
  });
}

TEST_CASE("one finger feels what the other presses on", "[joints]") {
  // A spring of 200 N/m holds the other finger back: at 1 cm the servo carries its 2 N.
  Gripper gripper;
  joint_of(gripper.builder, gripper.right).axes[0].stiffness = 200.0;
  gripper.builder.model.physics.gravity.setZero();
  Sim sim(gripper.builder);
  sim.drive(gripper.turn_motor) = servo(50.0, 1.0, 0.0, 0.0);
  sim.drive(gripper.grip) = servo(2000.0, 40.0, 0.011, 0.0);
  sim.run(2.0);
  measure_relative("place", sim.q(gripper.right), 0.01, 1e-3);
  measure_relative("effort of the servo", sim.motor_effort(gripper.grip), 2.0, 1e-3);
}

TEST_CASE("three joints of a finger follow the first", "[joints]") {
  // Links of 30 g and 4 cm one after the other; each joint follows the one before it, the last with an
  // offset.
  ModelBuilder builder;
  int parent = kWorld;
  std::vector<int> joints;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "link_" + std::to_string(i);
    const int link =
        builder.body(name, 0.03, diagonal(4e-6, 4e-6, 1e-6), at(0, 0, -0.02 - 0.04 * i));
    joints.push_back(builder.joint(name, JointType::hinge, parent, link,
                                   {Vec3(0, 0, -0.04 * i), z_to(Vec3::UnitY())}));
    joint_of(builder, joints.back()).axes.resize(1);
    joint_of(builder, joints.back()).axes[0].damping = 1e-3;
    parent = link;
  }
  for (int i = 1; i < 4; ++i) couple(builder, joints[i], {{joints[i - 1], i == 2 ? 0.8 : 1.0}});
  const int motor = builder.motor("motor", joints[0], MotorMode::servo);
  Sim sim(builder);
  run_coupled(sim, 3.0, [&](double t) {
    sim.drive(motor) = servo(2.0, 0.05, 0.4 * (1.0 - std::cos(4.0 * t)), 1.6 * std::sin(4.0 * t));
  });
}

TEST_CASE("a coupling with an offset, saved and restored", "[joints]") {
  ModelBuilder builder;
  const int a = hang_rod(builder, "a", Vec3(0, 0, 2));
  const int b = hang_rod(builder, "b", Vec3(2, 0, 2));
  couple(builder, b, {{a, 0.5}});
  builder.model.couplings[0].offset = 0.3;
  start_at(builder, a, 0.6);
  start_at(builder, b, 0.6);
  Sim sim(builder);
  sim.run(1.0);
  measure("relation off [rad]", relation(sim, sim.model().couplings[0]), kRatioLimit);
  need("runtime.save");
  const SnapshotPtr saved = sim.world().save();
  sim.run(0.5);
  const double first = sim.q(a);
  REQUIRE(sim.world().restore(saved));
  sim.forget_state();
  sim.run(0.5);
  measure("second run off [rad]", std::abs(sim.q(a) - first), 0.0);
}

TEST_CASE("bodies fall by their share of gravity", "[free]") {
  ModelBuilder builder;
  const double scales[] = {-1.0, 0.0, 0.5, 1.0, 2.0};
  std::vector<int> bodies;
  for (const double scale : scales) {
    bodies.push_back(builder.body("body_" + std::to_string(bodies.size()), 2.0, Mat3::Identity(),
                                  at(static_cast<double>(bodies.size()), 0, 0)));
    builder.model.bodies.back().gravity_scale = scale;
  }
  Sim sim(builder);
  const double start = sim.energy();
  sim.run(1.0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    measure("speed off [m/s]", std::abs(sim.twist(bodies[i]).linear.z() + scales[i] * kGravity),
            1e-9);
  }
  // A method of first order is half a step's fall off: m g^2 t dt / 2 for each, 0.6 J together.
  measure("energy off [J]", std::abs(sim.energy() - start), 0.7);
}

}  // namespace
}  // namespace conformance
