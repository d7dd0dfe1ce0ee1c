// Kinematic bodies move as commanded, static ones stay, both push dynamic bodies.
#include "support.h"

namespace conformance {
namespace {

Body& body_of(ModelBuilder& builder, int body) { return builder.model.bodies[body]; }

int kinematic_box(ModelBuilder& builder, const Vec3& size, const Vec3& p, const Twist& V) {
  const int body = builder.box("pusher", size, 1.0, {p, Quat(1, 0, 0, 0)});
  body_of(builder, body).kind = BodyKind::kinematic;
  body_of(builder, body).V_WB = V;
  return body;
}

TEST_CASE("kinematic body moves with its twist", "[kinematic]") {
  // Gravity does not act on it; r(t) turns about its own origin.
  const Twist V = {Vec3(0.3, -0.1, 0.2), Vec3(0.5, 0.2, 1.0)};
  ModelBuilder builder;
  const int body = kinematic_box(builder, Vec3(0.2, 0.2, 0.2), Vec3(1, 2, 3), V);
  Sim sim(builder);
  const double t = 2.0;
  sim.run(t);
  measure("place error [m]", (sim.pose(body).p - Vec3(1, 2, 3) - V.linear * t).norm(), 1e-9);
  // Linear integration of a quaternion errs by w^3 dt^2 t / 12.
  measure("orientation error [rad]",
          angle_between(sim.pose(body).q, turn(V.angular, V.angular.norm() * t)),
          std::pow(V.angular.norm(), 3) * kDt * kDt * t / 12.0 + 1e-9);
  measure("reported twist [m/s]", (sim.twist(body).linear - V.linear).norm(), 1e-9);
}

TEST_CASE("kinematic body pushes a box and is not held up", "[kinematic]") {
  // The pushing face is slick: with friction it could lift the box and push it with less.
  const double v = 0.2, t = 3.0;
  ModelBuilder builder;
  builder.plane("floor");
  const int pusher = kinematic_box(builder, Vec3(0.1, 0.6, 0.3), Vec3(-0.3, 0, 0.2),
                                   {Vec3(v, 0, 0), Vec3::Zero()});
  const int slick = builder.material("slick", 0.0);
  body_of(builder, pusher).shapes[0].material = slick;
  const int box = builder.box("box", Vec3(0.3, 0.3, 0.2), 50.0, at(0, 0, 0.1));
  Sim sim(builder);
  Vec3 pushed = Vec3::Zero();  // mean over the last second
  double now = 0.0;
  sim.run(t, kDt, [&] {
    now += kDt;
    if (now <= t - 1.0) return;
    for (const Contact& contact : sim.contacts()) {
      if (contact.body_a == pusher && contact.body_b == box) pushed += contact.force * kDt;
    }
  });
  measure("pusher's place error [m]", std::abs(sim.pose(pusher).p.x() + 0.3 - v * t), 1e-9);
  measure_relative("box's speed", sim.twist(box).linear.x(), v, 0.01);
  measure("gap between their faces [m]",
          std::abs(sim.pose(box).p.x() - 0.15 - (sim.pose(pusher).p.x() + 0.05)), 1e-3);
  // mu m g with mu = 0.5, 490 N, must come from the pusher.
  measure_relative("pushing force", pushed.x(), 0.5 * 50.0 * 9.81, 0.02);
}

TEST_CASE("kinematic lift carries a box", "[kinematic]") {
  const double v = 0.25, t = 2.0;
  ModelBuilder builder;
  const int lift =
      kinematic_box(builder, Vec3(1, 1, 0.1), Vec3(0, 0, 0.05), {Vec3(0, 0, v), Vec3::Zero()});
  const int box = builder.box("box", Vec3(0.3, 0.3, 0.2), 2.0, at(0, 0, 0.2));
  body_of(builder, box).V_WB.linear = Vec3(0, 0, v);
  Sim sim(builder);
  sim.run(t);
  measure("height over the lift [m]", std::abs(sim.pose(box).p.z() - sim.pose(lift).p.z() - 0.15),
          1e-3);
  measure("sideways [m]", sim.pose(box).p.head<2>().norm(), 1e-3);
}

TEST_CASE("kinematic turntable takes a box along", "[kinematic]") {
  // mu g = 4.9 m/s^2 holds w^2 r = 0.3 m/s^2.
  const double w = 1.0, r = 0.3, t = 2.0;
  ModelBuilder builder;
  kinematic_box(builder, Vec3(1.5, 1.5, 0.1), Vec3(0, 0, -0.05), {Vec3::Zero(), Vec3(0, 0, w)});
  const int box = builder.box("box", Vec3(0.1, 0.1, 0.1), 1.0, at(r, 0, 0.05));
  body_of(builder, box).V_WB = {Vec3(0, w * r, 0), Vec3(0, 0, w)};
  Sim sim(builder);
  sim.run(t);
  const Vec3 expected(r * std::cos(w * t), r * std::sin(w * t), 0.05);
  // A box that creeps 1 mm in 5 s on a slope may do so here.
  measure("place error [m]", (sim.pose(box).p - expected).norm(), 1.5e-3);
  measure("turn error [rad]", angle_between(sim.pose(box).q, turn(Vec3::UnitZ(), w * t)), 5e-3);
}

TEST_CASE("kinematic body is given another twist while running", "[kinematic]") {
  ModelBuilder builder;
  const int body =
      kinematic_box(builder, Vec3(0.2, 0.2, 0.2), Vec3::Zero(), {Vec3(1, 0, 0), Vec3::Zero()});
  const int ball = builder.sphere("ball", 0.1, 1.0, at(0, 0, 5));
  Sim sim(builder);
  auto* drive = sim.world().extension<KinematicDrive>();
  if (!drive) leave_unsupported("extension cogrsim.kinematic_drive/1");
  sim.run(0.5);
  REQUIRE(drive->set_kinematic_twist(body, {Vec3(0, 2, 0), Vec3(0, 0, 1)}));
  sim.run(0.5);
  measure("place error [m]", (sim.pose(body).p - Vec3(0.5, 1, 0)).norm(), 1e-9);
  measure("turn error [rad]", angle_between(sim.pose(body).q, turn(Vec3::UnitZ(), 0.5)), 1e-7);
  const auto refused = drive->set_kinematic_twist(ball, {});
  REQUIRE_FALSE(refused);
  CHECK_FALSE(refused.error().message.empty());
}

TEST_CASE("kinematic body with a joint carries a pendulum", "[kinematic]") {
  // The pivot moves with constant velocity: the pendulum hangs straight as if at rest.
  ModelBuilder builder;
  const int cart =
      kinematic_box(builder, Vec3(0.2, 0.2, 0.2), Vec3(0, 0, 2), {Vec3(0.5, 0, 0), Vec3::Zero()});
  const int bob = builder.sphere("bob", 0.1, 1.0, at(0, 0, 1.2));
  body_of(builder, bob).V_WB.linear = Vec3(0.5, 0, 0);
  builder.joint("hinge", JointType::hinge, cart, bob, {Vec3(0, 0, 2), z_to(Vec3::UnitY())});
  Sim sim(builder);
  sim.run(2.0);
  measure("bob's place error [m]", (sim.pose(bob).p - Vec3(1.0, 0, 1.2)).norm(), 1e-4);
}

TEST_CASE("static body stays where it is", "[kinematic]") {
  ModelBuilder builder;
  const int wall = builder.box("wall", Vec3(0.2, 2, 2), 0.0, at(1, 0, 1));
  builder.sphere("ball", 0.1, 100.0, at(0, 0, 1));
  body_of(builder, 1).V_WB.linear = Vec3(5, 0, 0);
  Sim sim(builder);
  sim.run(0.5);
  CHECK(sim.pose(wall).p == Vec3(1, 0, 1));
  CHECK(sim.twist(wall).linear == Vec3::Zero());
  measure("ball beyond the wall's face [m]", std::max(0.0, sim.pose(1).p.x() - 0.8), 1e-3);
}

}  // namespace
}  // namespace conformance
