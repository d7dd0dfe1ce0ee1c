// Reported contacts: bodies, points, directions, forces.
#include "support.h"

namespace conformance {
namespace {

TEST_CASE("contacts of a box at rest", "[reports]") {
  need("report.contact_force");
  const bool floor_first = GENERATE(true, false);
  const double mass = 3.0;
  ModelBuilder builder;
  if (floor_first) builder.plane("floor");
  const int box = builder.box("box", Vec3(0.4, 0.2, 0.1), mass, at(1, 2, 0.05));
  if (!floor_first) builder.plane("floor");
  Sim sim(builder);
  sim.run(1.0);
  const std::vector<Contact>& contacts = sim.contacts();
  REQUIRE(contacts.size() >= 3);
  Vec3 torque = Vec3::Zero();
  for (const Contact& contact : contacts) {
    CHECK(contact.body_a == 0);
    CHECK(contact.body_b == 1);
    CHECK(contact.shape_a == 0);
    CHECK(contact.shape_b == 0);
    const double up = contact.body_b == box ? 1.0 : -1.0;  // from a to b
    measure("normal's error [rad]", std::acos(std::min(1.0, up * contact.normal.z())), 1e-3);
    measure("point over the floor [m]", std::abs(contact.point.z()), 1e-3);
    measure("depth [m]", std::abs(contact.depth), 1e-3);
    measure("pull [N]", std::max(0.0, -up * contact.force.z()), 1e-9);
    const Vec3 r = contact.point - Vec3(1, 2, 0.05);
    torque += up * r.cross(contact.force);
  }
  const Vec3 weight(0, 0, mass * kGravity);
  measure("force error over the weight", (sim.contact_force(box) - weight).norm() / weight.norm(),
          0.01);
  // They carry it without turning it over.
  measure("torque over m g width", torque.norm() / (mass * kGravity * 0.4), 0.01);
}

TEST_CASE("contacts of a block held by friction on a slope", "[reports]") {
  need("report.contact_force");
  const double mass = 2.0, angle = 15.0 * kDegree;
  const Pose X_WS(Vec3(0.3, 0.2, 0.1), turn(Vec3::UnitY(), angle));
  ModelBuilder builder;
  builder.plane("slope", X_WS);
  const int block = builder.box("block", Vec3(0.3, 0.3, 0.1), mass, X_WS * at(0, 0, 0.05));
  Sim sim(builder);
  sim.run(1.0);
  // Normal and friction together carry the weight, straight up.
  const Vec3 weight(0, 0, mass * kGravity), force = sim.contact_force(block);
  measure("force error over the weight", (force - weight).norm() / weight.norm(), 0.01);
  const Vec3 along = X_WS.q.conjugate() * force;
  measure_relative("friction force", -along.x(), mass * kGravity * std::sin(angle), 0.02);
}

TEST_CASE("no point of a face presses against another", "[reports]") {
  need("report.contact_force");
  // On the flat every point's force is vertical; on a slope that holds, each has its share of the
  // pull downhill. 1 % of the weight is what the suite grants to forces.
  const double mass = 3.0, angle = GENERATE(0.0, 15.0) * kDegree;
  const Pose X_WS(Vec3(0.3, 0.2, 0.1), turn(Vec3::UnitY(), angle));
  ModelBuilder builder;
  builder.plane("slope", X_WS);
  builder.box("box", Vec3(0.4, 0.3, 0.1), mass, X_WS * at(0, 0, 0.05));
  Sim sim(builder);
  sim.run(1.0);
  const std::vector<Contact>& contacts = sim.contacts();
  REQUIRE(contacts.size() >= 3);
  for (const Contact& contact : contacts) {
    const double load = contact.force.dot(contact.normal);
    const Vec3 uphill = X_WS.q * Vec3(-1, 0, 0);
    const Vec3 wanted = load * (contact.normal + std::tan(angle) * uphill);
    measure("force off its direction over the weight",
            (contact.force - wanted).norm() / (mass * kGravity), 0.01);
  }
}

TEST_CASE("contacts of a block that slides", "[reports]") {
  need("report.contact_force");
  const double mass = 2.0, mu = 0.3;
  ModelBuilder builder;
  const int surface = builder.material("surface", mu);
  builder.plane("floor", Pose(), surface);
  const int block = builder.box("block", Vec3(0.3, 0.3, 0.1), mass, at(0, 0, 0.05), surface);
  builder.model.bodies[1].V_WB.linear = Vec3(1.2, 1.6, 0);
  Sim sim(builder);
  sim.run(0.3);
  const Vec3 force = sim.contact_force(block);
  const Vec3 friction = -mu * mass * kGravity * Vec3(0.6, 0.8, 0);
  measure("friction error, relative",
          (Vec3(force.x(), force.y(), 0) - friction).norm() / friction.norm(), 0.01);
  measure_relative("normal force", force.z(), mass * kGravity, 0.01);
}

TEST_CASE("impact: force times dt is the change of momentum", "[reports]") {
  need("report.contact_force");
  const double mass = 1.0, v = 2.0;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  builder.box("wall", Vec3(0.2, 2, 2), 0.0, at(1, 0, 0));
  const int ball = builder.sphere("ball", 0.1, mass, at(0.4, 0, 0));
  builder.model.bodies[1].V_WB.linear = Vec3(v, 0, 0);
  Sim sim(builder);
  double impulse = 0.0;
  sim.run(0.5, kDt, [&] { impulse += sim.contact_force(ball).x() * kDt; });
  const double change = mass * (sim.twist(ball).linear.x() - v);
  REQUIRE(change < -1.0);
  measure_relative("impulse", impulse, change, 1e-3);
}

TEST_CASE("contacts are ordered and only of what touches", "[reports]") {
  ModelBuilder builder;
  builder.plane("floor");
  for (int i = 0; i < 6; ++i) {
    builder.box("box" + std::to_string(i), Vec3(0.2, 0.2, 0.2), 1.0, at(0.5 * i, 0, 0.1));
  }
  builder.sphere("far", 0.1, 1.0, at(0, 3, 50));
  Sim sim(builder);
  sim.run(0.2);
  const std::vector<Contact>& contacts = sim.contacts();
  REQUIRE(contacts.size() >= 18);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    CHECK(contacts[i].body_a == 0);
    CHECK(contacts[i].body_b < 7);
    if (i > 0) CHECK(contacts[i - 1].body_b <= contacts[i].body_b);
  }
}

}  // namespace
}  // namespace conformance
