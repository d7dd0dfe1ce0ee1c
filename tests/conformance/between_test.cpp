// Two backends on the same smooth scenes: the difference between them comes from the size of the
// steps and goes with it.
#include "scenes.h"

namespace conformance {
namespace {

using Make = std::function<void(ModelBuilder&)>;
using Steer = std::function<void(Sim&)>;

// Largest distance [m] of any body between the two backends at the end.
double difference(const Make& make, const Steer& steer, double seconds, double dt) {
  std::vector<Pose> poses[2];
  const Backend* engines[2] = {&backend(), &other_backend()};
  for (int i = 0; i < 2; ++i) {
    ModelBuilder builder;
    make(builder);
    Sim sim(builder, *engines[i]);
    if (steer) steer(sim);
    sim.run(seconds, dt);
    poses[i] = sim.state().poses;
  }
  REQUIRE(poses[0].size() == poses[1].size());
  double largest = 0.0;
  for (std::size_t i = 0; i < poses[0].size(); ++i) {
    largest = std::max(largest, (poses[0][i].p - poses[1][i].p).norm());
    largest = std::max(largest, angle_between(poses[0][i].q, poses[1][i].q));
  }
  return largest;
}

// First order: D(dt) = a dt + b dt^2, so halving leaves half and what dt = 0 is extrapolated to,
// 2 D(dt/2) - D(dt), is small against D. Differences below 1e-8 are nothing to shrink.
void converges(const Make& make, const Steer& steer, double seconds) {
  double last = difference(make, steer, seconds, 4e-3);
  observe("difference at 4 ms", last);
  for (const double dt : {2e-3, 1e-3, 0.5e-3}) {
    const double now = difference(make, steer, seconds, dt);
    if (last > 1e-8) {
      measure("difference at dt/2 over that at dt", now / last, 0.6);
      measure("what is left at dt = 0 over the difference at dt", std::abs(2.0 * now - last) / last,
              0.2);
    }
    last = now;
  }
  observe("difference at 0.5 ms", last);
}

TEST_CASE("between backends: projectile", "[.][between]") {
  converges(
      [](ModelBuilder& b) {
        b.sphere("ball", 0.1, 1.0, at(0, 0, 1));
        b.model.bodies[0].V_WB = {Vec3(2, 1, 5), Vec3(1, 2, 3)};
      },
      {}, 1.0);
}

TEST_CASE("between backends: tumbling box", "[.][between]") {
  converges(
      [](ModelBuilder& b) {
        b.box("box", Vec3(0.1, 0.4, 0.9), 10.0, Pose());
        b.model.bodies[0].V_WB = {Vec3(-2, 2, 8), Vec3(0.1, 5, 0.1)};
      },
      {}, 1.0);
}

TEST_CASE("between backends: rod pendulum", "[.][between]") {
  converges(
      [](ModelBuilder& b) {
        const int rod = b.box("rod", Vec3(1.0, 0.05, 0.05), 1.0, at(0.5, 0, 0));
        b.joint("hinge", JointType::hinge, kWorld, rod, {Vec3::Zero(), z_to(Vec3::UnitY())});
      },
      {}, 1.0);
}

TEST_CASE("between backends: chain of three hinges in two directions", "[.][between]") {
  converges(
      [](ModelBuilder& b) {
        const Chain chain = add_chain(b, Pose());
        b.joint("root", JointType::hinge, kWorld, chain.bars[0],
                {Vec3::Zero(), z_to(Vec3::UnitY())});
      },
      {}, 1.0);
}

TEST_CASE("between backends: servo that lifts an arm", "[.][between]") {
  converges(
      [](ModelBuilder& b) {
        const int arm = b.box("arm", Vec3(0.5, 0.05, 0.05), 0.8, at(0.25, 0, 0));
        const int hinge =
            b.joint("hinge", JointType::hinge, kWorld, arm, {Vec3::Zero(), z_to(-Vec3::UnitY())});
        b.model.joints[0].axes[0].damping = 0.05;
        b.motor("servo", hinge, MotorMode::servo);
      },
      [](Sim& sim) {
        sim.drives[0].kp = 30.0;
        sim.drives[0].kd = 2.0;
        sim.drives[0].position = 0.5;
      },
      0.12);  // still moving: at the target there is no difference left
}

TEST_CASE("between backends: spring on a slider, screw, ball pendulum", "[.][between]") {
  converges(
      [](ModelBuilder& b) {
        const int weight = b.sphere("weight", 0.1, 1.0, at(0, 0, 0));
        const int rail = b.joint("rail", JointType::slider, kWorld, weight, at(0, 0, 0));
        b.model.joints[rail].axes[0].stiffness = 40.0;
        const int nut = b.cylinder("nut", 0.1, 0.1, 1.0, at(1, 0, 0));
        const int screw = b.joint("screw", JointType::screw, kWorld, nut, at(1, 0, 0));
        b.model.joints[screw].pitch = 0.2;
        const int bob = b.sphere("bob", 0.1, 1.0, at(2.5, 0, 0));
        b.joint("string", JointType::ball, kWorld, bob, at(2, 0, 0));
        b.model.bodies[bob].V_WB.linear = Vec3(0, 1, 0);
        b.model.bodies[bob].V_WB.angular = Vec3(0, 0, 2);
        b.model.joints.back().velocity = {0, 0, 2};
      },
      {}, 1.0);
}

TEST_CASE("between backends: swinging four-bar linkage", "[.][between]") {
  // Lengths 1, 2, 2.5, 2 (ground) at crank angle 90 degrees about -y; C by the triangle B C D.
  converges(
      [](ModelBuilder& b) {
        const Vec3 B(0, 0, 1), D(2, 0, 0);
        const Vec3 along = (D - B).normalized();
        const double gap = (D - B).norm(), r1 = 2.0, r2 = 2.5;
        const double x = (gap * gap + r1 * r1 - r2 * r2) / (2.0 * gap);
        const Vec3 up(-along.z(), 0, along.x());
        const Vec3 C = B + along * x + up * std::sqrt(r1 * r1 - x * x);
        const auto bar = [&](const char* name, const Vec3& from, const Vec3& to) {
          return b.box(name, Vec3((to - from).norm(), 0.05, 0.05), 1.0,
                       {0.5 * (from + to),
                        Quat(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitX(), to - from))});
        };
        const int crank = bar("crank", Vec3::Zero(), B);
        const int coupler = bar("coupler", B, C);
        const int rocker = bar("rocker", D, C);
        const Quat axis = z_to(-Vec3::UnitY());
        b.joint("drive", JointType::hinge, kWorld, crank, {Vec3::Zero(), axis});
        b.joint("pin1", JointType::hinge, crank, coupler, {B, axis});
        b.joint("pin2", JointType::hinge, kWorld, rocker, {D, axis});
        const int loop = b.joint("loop", JointType::hinge, coupler, rocker, {C, axis});
        b.model.joints[loop].closes_loop = true;
      },
      {}, 0.5);
}

}  // namespace
}  // namespace conformance
