// Bodies made static and dynamic again while the world runs.
#include "runtime_rig.h"

namespace conformance {
namespace {

bool same_place(const Pose& a, const Pose& b) { return a.p == b.p && a.q.coeffs() == b.q.coeffs(); }

TEST_CASE("made static in flight it stays, made dynamic it falls from rest", "[runtime]") {
  need("runtime.body_kind");
  ModelBuilder builder;
  const int box = builder.box("box", Vec3(0.2, 0.3, 0.4), 1.0, at(0, 0, 5));
  builder.model.bodies[0].com = Vec3(0.02, -0.01, 0.03);
  builder.model.bodies[0].V_WB = {Vec3(1, 0, 2), Vec3(3, -2, 1)};
  Sim sim(builder);
  sim.run(0.2);
  const Pose before = sim.pose(box);
  set_static(sim, box, true);
  const Pose held = sim.pose(box);
  // Rounding in the conversion from the frame of the centre of mass to the body's.
  measure("change of place by stopping [m, rad]",
          std::max((held.p - before.p).norm(), angle_between(held.q, before.q)), 5e-8);
  CHECK(sim.twist(box).linear.norm() == 0.0);
  CHECK(sim.twist(box).angular.norm() == 0.0);
  sim.run(0.3);
  CHECK(same_place(sim.pose(box), held));
  set_static(sim, box, false);
  const double t = 0.3;
  sim.run(t);
  measure("fall error [m]", (sim.pose(box).p - held.p + Vec3(0, 0, 0.5 * kGravity * t * t)).norm(),
          0.5 * kGravity * kDt * t * 1.001 + 1e-9);
  measure("spin after the fall [rad/s]", sim.twist(box).angular.norm(), 1e-12);
}

TEST_CASE("a stack on a body made static", "[runtime]") {
  need("runtime.body_kind");
  need("runtime.remove");
  ModelBuilder builder;
  builder.plane("floor");
  const int table = builder.box("table", Vec3(1, 1, 0.2), 0.0, at(0, 0, 1.0));
  std::vector<int> stack;
  for (int i = 0; i < 3; ++i) {
    stack.push_back(
        builder.box("box" + std::to_string(i), Vec3(0.2, 0.2, 0.2), 1.0, at(0, 0, 1.2 + 0.2 * i)));
  }
  Sim sim(builder);
  sim.run(0.5);
  for (int round = 0; round < 3; ++round) {
    set_static(sim, stack[0], true);
    sim.run(0.1);
    set_static(sim, stack[0], false);
    sim.run(0.1);
    for (int i = 0; i < 3; ++i) {
      measure("height error in the stack [m]", std::abs(sim.pose(stack[i]).p.z() - 1.2 - 0.2 * i),
              1e-4);
    }
  }
  set_static(sim, stack[0], true);
  const Pose held = sim.pose(stack[0]);
  auto next = std::make_shared<SceneModel>(*sim.world().model());
  next->bodies[table].removed = true;
  remove(sim, next);
  sim.run(0.5);
  CHECK(same_place(sim.pose(stack[0]), held));
  measure("height error of the top [m]", std::abs(sim.pose(stack[2]).p.z() - 1.6), 1e-4);
  Vec3 on_held = Vec3::Zero();
  for (const Contact& c : sim.contacts()) {
    if (c.body_a == stack[0] && c.body_b == stack[1]) on_held += c.force;
  }
  measure_relative("load on the body held", on_held.z(), 2.0 * kGravity, 1e-3);
  set_static(sim, stack[0], false);
  const double t = 0.2;
  sim.run(t);
  // Contacts that carry may be springs of natural frequency 1/dt, pressed in by g dt^2 for each
  // weight they bear: that lets go at g dt per weight at most, here two.
  measure("fall error [m]",
          std::abs(sim.pose(stack[0]).p.z() - held.p.z() + 0.5 * kGravity * t * t),
          0.5 * kGravity * kDt * t * 1.001 + 2.0 * kGravity * kDt * t);
  sim.run(1.5);
  for (const int body : stack) CHECK(sim.pose(body).p.z() > 0.09);
}

TEST_CASE("a pendulum whose support is stopped", "[runtime]") {
  need("runtime.body_kind");
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const double L = 1.0, m = 1.0, v = 1.5;
  const int block = builder.box("block", Vec3(0.2, 0.2, 0.2), 4.0, at(0, 0, 0));
  const int rod = builder.box("rod", Vec3(0.02, 0.02, L), m, at(0, 0, -0.5 * L));
  const int hinge =
      builder.joint("hinge", JointType::hinge, block, rod, {Vec3::Zero(), z_to(Vec3::UnitY())});
  for (Body& body : builder.model.bodies) body.V_WB.linear = Vec3(v, 0, 0);
  Sim sim(builder);
  sim.run(0.2);
  set_static(sim, block, true);
  const Pose held = sim.pose(block);
  // Moment of momentum about the hinge stays: m v L/2 = I w; about y, below it +x is negative.
  const double I = m * (L * L + 0.02 * 0.02) / 12.0 + m * 0.25 * L * L;
  measure_relative("rate after the stop", sim.u(hinge), -m * v * 0.5 * L / I, 1e-11);
  const double rate = sim.u(hinge), q = sim.q(hinge);
  sim.run(1.0);
  CHECK(same_place(sim.pose(block), held));
  measure_relative("turn in 1 s", sim.q(hinge) - q, rate * 1.0, 1e-5);
  measure("gap [m, rad]", gap(sim, hinge), 1e-5);
  const Momentum before = sim.momentum();
  set_static(sim, block, false);
  // It starts at rest; the rod's momentum is all there is, and from now on it stays.
  CHECK(sim.twist(block).linear.norm() < 1e-12);
  measure("momentum lost by letting go [kg m/s]", (sim.momentum().linear - before.linear).norm(),
          1e-11);
  sim.run(0.5);
  measure("momentum lost in 0.5 s [kg m/s]", (sim.momentum().linear - before.linear).norm(), 1e-9);
}

TEST_CASE("a static body made dynamic falls and rests", "[runtime]") {
  need("runtime.body_kind");
  ModelBuilder builder;
  builder.plane("floor");
  const int shelf = builder.box("shelf", Vec3(0.4, 0.4, 0.1), 2.0, at(0, 0, 0.55));
  builder.model.bodies[shelf].kind = BodyKind::static_body;
  const int cup = builder.box("cup", Vec3(0.1, 0.1, 0.1), 0.5, at(0, 0, 0.65));
  Sim sim(builder);
  sim.run(0.3);
  set_static(sim, shelf, false);
  sim.run(1.5);
  measure("height error of the shelf [m]", std::abs(sim.pose(shelf).p.z() - 0.05), 1e-3);
  measure("height error of the cup [m]", std::abs(sim.pose(cup).p.z() - 0.15), 1e-3);
}

}  // namespace
}  // namespace conformance
