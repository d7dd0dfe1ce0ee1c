// Forces of commands on any engine.
#include <cmath>
#include <limits>

#include "../support/temporary_folder.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

constexpr double kMass = 2.0, kRadius = 0.1;

/// A ball without gravity, turned by 90 degrees about z: its x is the world's y.
SceneModelPtr ball() {
  ModelBuilder b("ball");
  b.model.physics.gravity.setZero();
  b.sphere("ball", kRadius, kMass,
           Pose(Vec3(0, 0, 1), Quat(Eigen::AngleAxisd(0.5 * kPi, Vec3::UnitZ()))));
  return b.build();
}

const Twist& twist(Simulation& simulation) { return simulation.frame()->state.twists.at(0); }

}  // namespace

TEST_CASE("a force of a command acts for its duration", "[forces]") {
  const std::string backend = GENERATE(engines());
  auto simulation = simulate(ball(), backend);
  ApplyForce command;
  command.body = "ball";
  command.force = Vec3(3.0, 0.0, 0.0);
  command.duration = 0.25;
  simulation->send(command);
  simulation->run_until(0.5);
  // Momentum F t, rounded in each of 250 steps.
  CHECK(twist(*simulation).linear.x() == Approx(3.0 * 0.25 / kMass).epsilon(1e-9));
  command.duration = 0.0;
  simulation->send(command);
  simulation->run_until(1.0);
  CHECK(twist(*simulation).linear.x() == Approx(3.0 * 0.251 / kMass).epsilon(1e-9));
  CHECK(twist(*simulation).angular.norm() < 1e-12);
  CHECK(messages_of(*simulation).empty());
}

TEST_CASE("a force of a command acts at its point, in the axes that it names", "[forces]") {
  const std::string backend = GENERATE(engines());
  auto simulation = simulate(ball(), backend);
  ApplyForce command;
  command.body = "ball";
  command.force = Vec3(1.0, 0.0, 0.0);
  command.point = Vec3(0.0, 0.0, 0.05);
  command.torque = Vec3(0.0, 0.0, 0.004);
  command.in_body = true;
  simulation->send(command);
  simulation->step();
  const double dt = simulation->dt();
  // The ball's x is the world's y: the force turns it about z x y = -x.
  const double inertia = 0.4 * kMass * kRadius * kRadius;
  const Twist& V = twist(*simulation);
  CHECK((V.linear - Vec3(0.0, dt / kMass, 0.0)).norm() < 1e-9 * dt);
  CHECK((V.angular - Vec3(-0.05, 0.0, 0.004) * dt / inertia).norm() < 1e-6 * dt / inertia);
}

TEST_CASE("forces of commands are part of snapshots and end with a restart", "[forces]") {
  SimulationOptions options;
  options.backend = GENERATE(engines());
  const SceneModelPtr scene = ball();
  auto simulation = simulate(scene, options.backend);
  ApplyForce command;
  command.body = "ball";
  command.force = Vec3(3.0, 0.0, 0.0);
  command.duration = 0.4;
  simulation->send(command);
  simulation->run_until(0.2);
  const SimulationSnapshotPtr saved = simulation->save();
  const TemporaryFolder folder;
  REQUIRE(write_snapshot(*simulation, folder / "ball.snap"));
  simulation->run_until(0.6);
  const std::uint64_t hash = state_hash(simulation->frame()->state);
  REQUIRE(simulation->restore(saved));
  simulation->run_until(0.6);
  CHECK(state_hash(simulation->frame()->state) == hash);

  const auto file = SnapshotFile::read(folder / "ball.snap");
  REQUIRE(file);
  auto resumed = resume(*file, scene, options, loader());
  REQUIRE(resumed);
  resumed->simulation->run_until(0.6);
  CHECK(twist(*resumed->simulation).linear.x() == Approx(3.0 * 0.4 / kMass).epsilon(1e-9));

  simulation->send(command);
  simulation->step();
  simulation->send(Restart{});
  simulation->step();
  simulation->run_until(0.1);
  CHECK(twist(*simulation).linear.norm() == 0.0);
}

TEST_CASE("a force that cannot act is refused", "[forces]") {
  auto simulation = simulate(ball(), "cogrsim");
  ApplyForce command;
  command.body = "bal";
  simulation->send(command);
  command.body = "ball";
  command.duration = -1.0;
  simulation->send(command);
  command.duration = 1.0;
  command.torque.x() = std::numeric_limits<double>::quiet_NaN();
  simulation->send(command);
  simulation->step();
  const std::string messages = messages_of(*simulation);
  CHECK(messages.find("there is no body 'bal'") != std::string::npos);
  CHECK(messages.find("the duration of a force") != std::string::npos);
  CHECK(messages.find("is not finite") != std::string::npos);
  CHECK(twist(*simulation).linear.norm() == 0.0);
}

TEST_CASE("winds add up, and a drag follows them", "[forces]") {
  const std::string backend = GENERATE(engines());
  constexpr double kDamping = 4.0;
  ModelBuilder b("leaf");
  b.model.physics.gravity.setZero();
  b.sphere("leaf", kRadius, kMass, Pose(Vec3(0, 0, 1), Quat(1, 0, 0, 0)));
  ForceModel drag;
  drag.name = "drag";
  drag.kind = ForceModel::Kind::drag;
  drag.body = 0;
  drag.linear = kDamping;
  drag.wind = Vec3(0.0, 0.5, 0.0);
  ForceModel gust;
  gust.name = "gust";
  gust.kind = ForceModel::Kind::wind;
  gust.wind = Vec3(1.0, 0.0, 0.0);
  gust.factor = "2 + 0 * time / 1 s";
  gust.until = 0.5;
  // After its drag, and one that has not begun.
  ForceModel later = gust;
  later.name = "later";
  later.factor.clear();
  later.from = 0.6;
  later.until = 1.0;
  b.model.forces = {drag, gust, later};
  auto simulation = simulate(b.build(), backend);
  // Each step takes the speed relative to the wind down by the factor 1 - c h / m, or by one nearer to its exponential:
  // a method of second order is off by 5/12 (c h / m)^2 c t / m of the speed at most, and 1/2 (c h / m)^2 by its first step
  // and by that in which the wind ends.
  const bool second = backend == "cogrsim";
  const double rate = kDamping * simulation->dt() / kMass;
  const double left = second ? std::exp(-rate) : 1.0 - rate;
  const double off = second ? 2.0 * 2.0 * rate * rate : 1e-9;
  simulation->run_until(0.5);
  const double gone = std::pow(left, 500);
  const Vec3 reached = Vec3(2.0, 0.5, 0.0) * (1.0 - gone);
  CHECK((twist(*simulation).linear - reached).norm() < off);
  simulation->run_until(0.6);
  const Vec3 slower = Vec3(0.0, 0.5, 0.0) + (reached - Vec3(0.0, 0.5, 0.0)) * std::pow(left, 100);
  CHECK((twist(*simulation).linear - slower).norm() < off);
}

TEST_CASE("drags of what turns are of second order on cogrsim", "[forces]") {
  // A rod swings on a hinge that a body carries, which falls and spins; drags at the rod's end and on the body.
  const auto run = [](double step) {
    ModelBuilder b("vane");
    b.model.physics.step = step;
    const int body = b.box("body", Vec3(0.3, 0.2, 0.1), 1.0, Pose());
    const int rod = b.box("rod", Vec3(0.4, 0.05, 0.05), 0.3, Pose(Vec3(0.35, 0, 0), Quat(1, 0, 0, 0)));
    b.joint("hinge", JointType::hinge, body, rod, Pose(Vec3(0.15, 0, 0), Quat(1, 0, 0, 0)));
    b.model.bodies[0].V_WB = b.model.bodies[1].V_WB = Twist{Vec3::Zero(), Vec3(0, 0, 6)};
    b.model.bodies[1].V_WB.linear = Vec3(0, 6 * 0.35, 0);
    for (const int of : {body, rod}) {
      ForceModel drag;
      drag.name = of == body ? "body_drag" : "rod_drag";
      drag.kind = ForceModel::Kind::drag;
      drag.body = of;
      drag.linear = 0.3;
      drag.quadratic = 0.4;
      drag.angular = 0.002;
      drag.wind = Vec3(3.0, 0.0, 0.0);
      if (of == rod) drag.X_BE.p = Vec3(0.2, 0, 0);
      b.model.forces.push_back(drag);
    }
    auto simulation = simulate(b.build(), "cogrsim");
    simulation->run_until(0.8);
    const auto& poses = simulation->frame()->state.poses;
    Eigen::Matrix<double, 6, 1> out;
    out << poses.at(0).p, poses.at(1).p;
    return out;
  };
  const auto exact = run(0.25e-3);
  const double error8 = (run(8e-3) - exact).norm(), error4 = (run(4e-3) - exact).norm(),
               error2 = (run(2e-3) - exact).norm();
  // A quarter with each halving, 2 where a method is of first order; the reference has an error of its own, 1/64 of that at 2 ms.
  CHECK(error8 / error4 > 3.3);
  CHECK(error4 / error2 > 3.5);
  CHECK(error2 < 2e-4);
}

TEST_CASE("a floating box oscillates about its draught", "[forces]") {
  const std::string backend = GENERATE(engines());
  constexpr double kWeight = 250.0, kOut = 0.05;
  ModelBuilder b("raft");
  // 1 m^2 of water plane: at rest 0.25 m of the height of 0.5 m are below the level of 2 m.
  b.box("raft", Vec3(1.0, 1.0, 0.5), kWeight, Pose(Vec3(0, 0, 2.0 + kOut), Quat(1, 0, 0, 0)));
  ForceModel buoyancy;
  buoyancy.name = "water";
  buoyancy.kind = ForceModel::Kind::buoyancy;
  buoyancy.body = 0;
  buoyancy.level = 2.0;
  b.model.forces.push_back(buoyancy);
  const double g = b.model.physics.gravity.norm();
  auto simulation = simulate(b.build(), backend);
  simulation->run_until(0.7);
  const double frequency = std::sqrt(1000.0 * 1.0 * g / kWeight);
  const Vec3& p = simulation->frame()->state.poses.at(0).p;
  // Methods of first order are off by half a step: by kOut w dt / 2 at most.
  CHECK(p.z() - 2.0 == Approx(kOut * std::cos(frequency * simulation->time()))
                           .margin(0.6 * kOut * frequency * simulation->dt()));
  CHECK(std::hypot(p.x(), p.y()) < 1e-9);
}

TEST_CASE("a force over time is of the order of the engine", "[forces]") {
  const auto error = [](double step) {
    ModelBuilder b("driven");
    b.model.physics.gravity.setZero();
    b.model.physics.step = step;
    b.sphere("ball", kRadius, kMass, Pose());
    ForceModel force;
    force.name = "sine";
    force.kind = ForceModel::Kind::force;
    force.body = 0;
    force.force = Vec3(kMass, 0, 0);
    force.factor = "sin(20 * time / 1 s)";
    b.model.forces.push_back(force);
    auto simulation = simulate(b.build(), "cogrsim");
    simulation->run_until(0.2);
    const double right = (1.0 - std::cos(20.0 * simulation->time())) / 20.0;
    return std::abs(twist(*simulation).linear.x() - right);
  };
  // Taken in the middle of each step: h^2 / 24 f' is left, a quarter with half the step.
  const double coarse = error(4e-3), fine = error(2e-3);
  CHECK(coarse < 1e-4);
  CHECK(coarse / fine == Approx(4.0).epsilon(0.05));
}
