// Joints that are added, removed and changed while the world runs.
#include "runtime_rig.h"
#include "scenes.h"

namespace conformance {
namespace {

struct Pair {
  ModelBuilder builder;
  int one = -1, two = -1;
};

// Two boxes in free flight, without gravity, that spin and drift differently.
Pair flying_pair() {
  Pair pair;
  ModelBuilder& builder = pair.builder;
  builder.model.physics.gravity = Vec3::Zero();
  pair.one = builder.box("one", Vec3(0.4, 0.3, 0.2), 2.0, at(0, 0, 0));
  pair.two = builder.box("two", Vec3(0.2, 0.5, 0.3), 3.0,
                         {Vec3(1.0, 0.2, -0.3), turn(Vec3(1, 2, 3), 0.7)});
  builder.model.bodies[0].V_WB = {Vec3(0.5, -0.2, 0.1), Vec3(1.0, 0.4, -0.6)};
  builder.model.bodies[1].V_WB = {Vec3(-0.7, 0.3, 0.4), Vec3(-0.5, 0.9, 0.3)};
  return pair;
}

struct Rigid {
  double mass = 0.0;
  Vec3 com = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();  // about com
};

// All dynamic bodies as one.
Rigid as_one(Sim& sim) {
  Rigid all;
  const SceneModel& model = sim.model();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const double m = model.bodies[b].mass;
    all.mass += m;
    all.com += m * (sim.pose(static_cast<int>(b)) * model.bodies[b].com);
  }
  all.com /= all.mass;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Pose& X = sim.pose(static_cast<int>(b));
    const Mat3 R = X.q.toRotationMatrix();
    const Vec3 r = X * model.bodies[b].com - all.com;
    all.inertia += R * model.bodies[b].inertia * R.transpose() +
                   model.bodies[b].mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  return all;
}

double difference(const Momentum& a, const Momentum& b) {
  return std::max((a.linear - b.linear).norm(), (a.angular - b.angular).norm());
}

TEST_CASE("attach: two bodies in free flight become one", "[runtime]") {
  Pair pair = flying_pair();
  Sim sim(pair.builder);
  sim.run(0.1);
  const Momentum before = sim.momentum();
  const int weld = attach(sim, "weld", JointType::fixed, pair.one, pair.two, at(0.5, 0.1, -0.1));
  // Perfectly plastic: P and L about the common centre of mass are conserved and determine the
  // twist. Sums of a dozen terms of order 1, and the solution of six equations: a few thousand
  // roundings.
  const Rigid one = as_one(sim);
  const Vec3 v = before.linear / one.mass;
  const Vec3 w = one.inertia.inverse() * (before.angular - one.com.cross(before.linear));
  measure("momentum lost by joining [kg m/s, kg m^2/s]", difference(sim.momentum(), before), 1e-12);
  for (const int body : {pair.one, pair.two}) {
    const Twist V = sim.twist(body);
    measure("angular velocity off the common one [rad/s]", (V.angular - w).norm(), 1e-11);
    measure("velocity off the common one [m/s]",
            (V.linear - v - w.cross(sim.pose(body).p - one.com)).norm(), 1e-11);
  }
  sim.run(1.0);
  // Both methods keep what floats: to rounding over 1000 steps, the free body's rotation included.
  measure("momentum lost in 1 s of flight [kg m/s, kg m^2/s]", difference(sim.momentum(), before),
          1e-9);
  // A joint of this kind gapes by what one step of 1 rad/s turns in the second order: (w dt)^2.
  measure("gap after 1 s [m, rad]", gap(sim, weld), 5e-6);
}

TEST_CASE("attach: every joint takes what it forbids and leaves the rest", "[runtime]") {
  for (const JointType type :
       {JointType::fixed, JointType::hinge, JointType::slider, JointType::cylindrical,
        JointType::universal, JointType::planar, JointType::ball}) {
    INFO(to_string(type));
    Pair pair = flying_pair();
    Sim sim(pair.builder);
    sim.run(0.05);
    const Momentum before = sim.momentum();
    const double energy = sim.energy();
    const int joint =
        attach(sim, "joint", type, pair.one, pair.two, {Vec3(0.5, 0.1, -0.1), z_to(Vec3(1, 1, 2))});
    measure("momentum lost [kg m/s, kg m^2/s]", difference(sim.momentum(), before), 1e-12);
    measure("speed left along what is forbidden [m/s, rad/s]", forbidden_speed(sim, joint), 1e-11);
    CHECK(sim.energy() < energy);  // a plastic impact loses some, always
    sim.run(0.5);
    measure("momentum lost in 0.5 s [kg m/s, kg m^2/s]", difference(sim.momentum(), before), 1e-9);
    measure("gap after 0.5 s [m, rad]", gap(sim, joint), 5e-6);
  }
}

TEST_CASE("attach: two floating chains become one", "[runtime]") {
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const Chain left = add_chain(builder, at(0, 0, 0));
  const std::size_t first = builder.model.bodies.size();
  const Chain right = [&] {
    ModelBuilder other;
    Chain chain = add_chain(other, at(1.7, 0, 0.1));
    for (Body& body : other.model.bodies) {
      body.name = "right_" + body.name;
      builder.model.bodies.push_back(body);
    }
    for (Joint& joint : other.model.joints) {
      joint.name = "right_" + joint.name;
      joint.parent += static_cast<int>(first);
      joint.child += static_cast<int>(first);
      builder.model.joints.push_back(joint);
    }
    for (int& bar : chain.bars) bar += static_cast<int>(first);
    return chain;
  }();
  for (std::size_t b = 0; b < builder.model.bodies.size(); ++b)
    builder.model.bodies[b].V_WB.linear = Vec3(b < first ? 0.6 : -0.4, 0, 0.3);
  Sim sim(builder);
  sim.run(0.05);
  const Momentum before = sim.momentum();
  const Pose end = sim.pose(left.bars.back());
  const int joint =
      attach(sim, "coupling", JointType::ball, left.bars.back(), right.bars.front(), end);
  measure("momentum lost [kg m/s, kg m^2/s]", difference(sim.momentum(), before), 1e-11);
  measure("speed left along what is forbidden [m/s]", forbidden_speed(sim, joint), 1e-11);
  sim.run(0.5);
  measure("momentum lost in 0.5 s [kg m/s, kg m^2/s]", difference(sim.momentum(), before), 1e-8);
  measure("gap after 0.5 s [m]", gap(sim, joint), 1e-5);
}

TEST_CASE("attach: a flying rod caught by a hinge", "[runtime]") {
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const double L = 1.0, m = 1.0;
  const Vec3 size(L, 0.05, 0.05);
  const int rod = builder.box("rod", size, m, at(0, 0, 0));
  builder.model.bodies[0].V_WB.linear = Vec3(0, 0, 2.0);
  Sim sim(builder);
  sim.run(0.1);
  const Vec3 end = sim.pose(rod) * Vec3(-0.5 * L, 0, 0);
  const int hinge = attach(sim, "hinge", JointType::hinge, kWorld, rod, {end, z_to(Vec3::UnitY())});
  // Its moment of momentum about the hinge is all that stays: m v L/2 = I w, of a bar of this
  // thickness about its end. About y, up is negative.
  const double I = m * (L * L + 0.05 * 0.05) / 12.0 + m * 0.25 * L * L;
  measure_relative("rate about the hinge", sim.u(hinge), -m * 2.0 * 0.5 * L / I, 1e-11);
  const double rate = sim.u(hinge);
  sim.run(0.5);
  measure_relative("turn in 0.5 s", sim.q(hinge), rate * 0.5, 1e-5);
}

TEST_CASE("attach: a loop is closed while it swings", "[runtime]") {
  ModelBuilder builder;
  const double L = 1.0;
  const auto rod = [&](const std::string& name, double x) {
    const double angle = 0.5;  // from hanging, towards +x
    const Vec3 down(std::sin(angle), 0, -std::cos(angle));
    const int body = builder.box(name, Vec3(0.04, 0.04, L), 1.0,
                                 {Vec3(x, 0, 2) + 0.5 * L * down, turn(Vec3::UnitY(), -angle)});
    builder.joint(name + "_hinge", JointType::hinge, kWorld, body,
                  {Vec3(x, 0, 2), z_to(Vec3::UnitY())});
    return body;
  };
  const int a = rod("a", 0.0), b = rod("b", 1.0);
  const Vec3 end_a = Vec3(0, 0, 2) + L * Vec3(std::sin(0.5), 0, -std::cos(0.5));
  const int bar =
      builder.box("bar", Vec3(1.0, 0.04, 0.04), 1.0, {end_a + Vec3(0.5, 0, 0), {1, 0, 0, 0}});
  const int pin = builder.joint("pin", JointType::hinge, a, bar, {end_a, z_to(Vec3::UnitY())});
  for (Body& body : builder.model.bodies) body.shapes.clear();
  Sim sim(builder);
  sim.run(0.02);
  const Vec3 meeting = sim.pose(b) * Vec3(0, 0, -0.5 * L);
  const double energy_before = sim.energy();
  const int closing =
      attach(sim, "closing", JointType::hinge, bar, b, {meeting, z_to(Vec3::UnitY())});
  CHECK(sim.model().joints[closing].closes_loop);
  measure("speed left along what is forbidden [m/s]", forbidden_speed(sim, closing), 1e-9);
  const double energy = sim.energy();
  CHECK(energy <= energy_before + 1e-12);
  double largest = 0.0, drift = 0.0, lowest = 1e9;
  sim.run(2.0, kDt, [&] {
    largest = std::max({largest, gap(sim, closing), gap(sim, pin)});
    drift = std::max(drift, std::abs(sim.energy() - energy));
    lowest = std::min(lowest, sim.pose(bar).p.z());
  });
  // As of the linkages that were closed from the start.
  measure("largest gap in 2 s [m, rad]", largest, 1e-4);
  // It falls by about 0.12 m with 2 kg of effective mass: 2.4 J go back and forth. First-order
  // methods swing about the true energy by w dt / 2 of it, w = 4 1/s.
  measure("energy drift [J]", drift, 2.4 * 4.0 * kDt);
  CHECK(lowest < 1.02);  // it swings
}

TEST_CASE("detach: both fly on with their twists", "[runtime]") {
  Pair pair = flying_pair();
  const int weld =
      pair.builder.joint("weld", JointType::fixed, pair.one, pair.two, at(0.5, 0.1, -0.1));
  // As one body they need one twist.
  const Twist common{Vec3(0.3, -0.2, 0.1), Vec3(1.0, 2.0, -0.5)};
  for (Body& body : pair.builder.model.bodies) {
    body.V_WB.angular = common.angular;
    body.V_WB.linear = common.linear + common.angular.cross(body.X_WB.p);
  }
  Sim sim(pair.builder);
  sim.run(0.5);
  const WorldState before = sim.state();
  detach(sim, weld);
  for (const int body : {pair.one, pair.two}) {
    const auto b = static_cast<std::size_t>(body);
    // Only rounding in the conversion from joint coordinates to those of a free body.
    measure("change of places by letting go [m, rad]",
            std::max((sim.pose(body).p - before.poses[b].p).norm(),
                     angle_between(sim.pose(body).q, before.poses[b].q)),
            5e-8);
    measure("change of twists by letting go [m/s, rad/s]",
            std::max((sim.twist(body).linear - before.twists[b].linear).norm(),
                     (sim.twist(body).angular - before.twists[b].angular).norm()),
            1e-12);
  }
  const double t = 1.0;
  sim.run(t);
  for (const int body : {pair.one, pair.two}) {
    const auto b = static_cast<std::size_t>(body);
    // Boxes: the body's origin is its centre of mass, and goes straight on.
    measure("off the straight line after 1 s [m]",
            (sim.pose(body).p - before.poses[b].p - before.twists[b].linear * t).norm(), 1e-9);
  }
}

TEST_CASE("a limit is moved while a pendulum swings", "[runtime]") {
  need("runtime.joint_axes");
  ModelBuilder builder;
  const double L = 1.0;
  const int rod = builder.box("rod", Vec3(L, 0.05, 0.05), 1.0, at(0.5 * L, 0, 2));
  const int hinge =
      builder.joint("hinge", JointType::hinge, kWorld, rod, {Vec3(0, 0, 2), z_to(Vec3::UnitY())});
  Sim sim(builder);
  while (sim.q(hinge) < 0.3) sim.step();
  set_axis(sim, hinge, [](JointAxis& axis) { axis.upper = 0.6; });
  sim.run(1.0);
  // Stops are rigid, and it lies on them by then.
  measure("place on the first stop [rad]", std::abs(sim.q(hinge) - 0.6), 1e-4);
  measure_relative("effort of the first stop", sim.effort(hinge),
                   -kGravity * 0.5 * L * std::cos(0.6), 1e-4);
  set_axis(sim, hinge, [](JointAxis& axis) { axis.upper = 1.0; });
  sim.run(1.0);
  measure("place on the second stop [rad]", std::abs(sim.q(hinge) - 1.0), 1e-4);
  // A stop that is moved to behind it pushes it back.
  set_axis(sim, hinge, [](JointAxis& axis) { axis.upper = 0.9; });
  sim.run(1.0);
  measure("place after being pushed back [rad]", std::abs(sim.q(hinge) - 0.9), 1e-3);
  set_axis(sim, hinge, [](JointAxis& axis) { axis.upper = kInfinity; });
  double farthest = 0.0;
  sim.run(1.5, kDt, [&] { farthest = std::max(farthest, sim.q(hinge)); });
  // From rest at 0.9 rad it swings as far to the other side of hanging (pi/2); at its turn it stays
  // within (u dt) of it for a step.
  measure("turn on the other side [rad]", std::abs(farthest - (kPi - 0.9)), 5e-3);
}

struct Wheel {
  ModelBuilder builder;
  int axle = -1;
  double inertia = 0.0;
};

Wheel flywheel(double rate) {
  Wheel wheel;
  wheel.builder.model.physics.gravity = Vec3::Zero();
  const int body = wheel.builder.cylinder("wheel", 0.2, 0.1, 5.0, at(0, 0, 0));
  wheel.builder.model.bodies[0].V_WB.angular = Vec3(0, 0, rate);
  wheel.axle = wheel.builder.joint("axle", JointType::hinge, kWorld, body, at(0, 0, 0));
  wheel.inertia = 0.5 * 5.0 * 0.2 * 0.2;
  return wheel;
}

TEST_CASE("damping is changed: the decay follows", "[runtime]") {
  need("runtime.joint_axes");
  Wheel wheel = flywheel(10.0);
  wheel.builder.model.joints[0].axes[0].damping = 0.5 * wheel.inertia;
  Sim sim(wheel.builder);
  sim.run(1.0);
  // exp(-b t / I); integrators of the first order in b dt / I = 5e-4 and 2e-3, of second order or
  // better here: half of their squares a step, times the steps.
  measure_relative("rate after 1 s", sim.u(wheel.axle), 10.0 * std::exp(-0.5), 1e-6);
  const double then = sim.u(wheel.axle);
  set_axis(sim, wheel.axle, [&](JointAxis& axis) { axis.damping = 2.0 * wheel.inertia; });
  sim.run(1.0);
  measure_relative("rate 1 s after the change", sim.u(wheel.axle), then * std::exp(-2.0), 1e-5);
}

TEST_CASE("friction and stiffness are changed: so is the motion", "[runtime]") {
  need("runtime.joint_axes");
  Wheel wheel = flywheel(10.0);
  Sim sim(wheel.builder);
  sim.run(0.1);
  set_axis(sim, wheel.axle, [&](JointAxis& axis) { axis.friction = 4.0 * wheel.inertia; });
  sim.run(1.0);
  measure_relative("rate after 1 s of dry friction", sim.u(wheel.axle), 10.0 - 4.0, 1e-9);
  const double q = sim.q(wheel.axle);
  const double omega = 5.0;  // of the spring [rad/s]
  set_axis(sim, wheel.axle, [&](JointAxis& axis) {
    axis.friction = 0.0;
    axis.stiffness = omega * omega * wheel.inertia;
    axis.rest = q;
  });
  Crossings crossings(q);
  double t = 0.0;
  sim.run(4.0, kDt, [&] { crossings.add(t += kDt, sim.q(wheel.axle)); });
  // A step method of at least first order with a fixed step: period off by (w dt)^2 / 24.
  measure_relative("period on the spring", crossings.period(), 2.0 * kPi / omega, 1e-5);
}

TEST_CASE("a trailer is hitched to a cart that drives", "[runtime]") {
  ModelBuilder builder;
  const int rough = builder.material("rough", 0.3);
  builder.plane("floor", {}, rough);
  const int cart = builder.box("cart", Vec3(0.4, 0.3, 0.2), 5.0, at(0, 0, 0.3));
  const int rail = builder.joint("rail", JointType::slider, kWorld, cart,
                                 {Vec3(0, 0, 0.3), z_to(Vec3::UnitX())});
  const int motor = builder.motor("drive", rail, MotorMode::velocity);
  const double m = 2.0, mu = 0.3, speed = 0.5;
  const int trailer = builder.box("trailer", Vec3(0.4, 0.3, 0.1), m, at(-0.2, 0, 0.05), rough);
  Sim sim(builder);
  sim.drive(motor) = speed_source(speed);
  sim.run(0.6);
  const Vec3 eye = sim.pose(trailer).p + Vec3(0.25, 0, 0);
  // Level and across: the trailer may pitch, so that the floor bears what the hitch does not.
  const int hitch =
      attach(sim, "hitch", JointType::hinge, cart, trailer, {eye, z_to(Vec3::UnitY())});
  measure("speed left along what is forbidden [m/s]", forbidden_speed(sim, hitch), 1e-11);
  sim.run(0.5);
  const double x = sim.pose(trailer).p.x();
  sim.run(1.0);
  measure_relative("way of the trailer", sim.pose(trailer).p.x() - x, speed * 1.0, 1e-4);
  // It slides: Coulomb's friction is all that holds it back.
  const double load = sim.contact_force(trailer).z();
  measure_relative("pull of the hitch", sim.reaction(hitch).force.x(), mu * load, 1e-3);
  measure_relative("load and lift", load + sim.reaction(hitch).force.z(), m * kGravity, 1e-3);
  measure("pitch of the trailer [rad]", std::abs(sim.q(hitch)), 1e-3);
  detach(sim, hitch);
  sim.run(1.0);
  // v^2 / (2 mu g), then it stays.
  const double stop = sim.pose(trailer).p.x();
  measure("speed after letting go [m/s]", sim.twist(trailer).linear.norm(), 1e-3);
  measure_relative("cart continues", sim.u(rail), speed, 1e-6);
  measure_relative("slides on", stop - x - speed * 1.0, speed * speed / (2 * mu * kGravity), 0.02);
}

TEST_CASE("a gripper lifts a box and lets it fall", "[runtime]") {
  ModelBuilder builder;
  builder.plane("floor");
  const int hand = builder.box("hand", Vec3(0.2, 0.2, 0.1), 1.0, at(0, 0, 0.36));
  const int lift = builder.joint("lift", JointType::slider, kWorld, hand, at(0, 0, 0.36));
  const int motor = builder.motor("winch", lift, MotorMode::velocity);
  const int box = builder.box("box", Vec3(0.3, 0.3, 0.3), 2.0, at(0, 0, 0.15));
  Sim sim(builder);
  sim.drive(motor) = speed_source(0.0);
  sim.run(0.3);
  measure_relative("load of the hand alone", sim.motor_effort(motor), 1.0 * kGravity, 1e-6);
  const int grip = attach(sim, "grip", JointType::fixed, hand, box, at(0, 0, 0.3));
  sim.drive(motor) = speed_source(0.2);
  sim.run(1.0);
  // At constant speed, off the floor, the slider carries both; nothing else acts.
  measure_relative("load with the box", sim.motor_effort(motor), 3.0 * kGravity, 1e-6);
  measure_relative("load on the grip", sim.reaction(grip).force.z(), 2.0 * kGravity, 1e-6);
  measure("height error of the box [m]", std::abs(sim.pose(box).p.z() - 0.15 - 0.2 * 1.0),
          0.2 * kDt + 1e-4);
  for (const Contact& contact : sim.contacts()) {
    CHECK_FALSE((contact.body_a == hand && contact.body_b == box));
  }
  const double height = sim.pose(box).p.z();
  detach(sim, grip);
  const double t = 0.15;
  sim.run(t);
  measure("fall error [m]",
          std::abs(sim.pose(box).p.z() - height - 0.2 * t + 0.5 * kGravity * t * t),
          0.5 * kGravity * kDt * t * 1.001 + 1e-9);
  measure_relative("load without the box", sim.motor_effort(motor), 1.0 * kGravity, 1e-6);
}

TEST_CASE("attached bodies pass through each other and let go collide again", "[runtime]") {
  ModelBuilder builder;
  builder.plane("floor");
  const int low = builder.box("low", Vec3(0.4, 0.4, 0.2), 2.0, at(0, 0, 0.1));
  const int high = builder.box("high", Vec3(0.2, 0.2, 0.2), 1.0, at(0, 0, 0.3));
  Sim sim(builder);
  sim.run(0.3);
  const auto touch = [&] {
    for (const Contact& c : sim.contacts())
      if (c.body_a == low && c.body_b == high) return true;
    return false;
  };
  CHECK(touch());
  for (int round = 0; round < 3; ++round) {
    const int joint =
        attach(sim, "hold" + std::to_string(round), JointType::fixed, low, high, sim.pose(high));
    sim.run(0.1);
    CHECK_FALSE(touch());
    measure_relative("load of the joint", sim.reaction(joint).force.z(), 1.0 * kGravity, 1e-3);
    detach(sim, joint);
    sim.run(0.2);
    CHECK(touch());
    measure("height error on top [m]", std::abs(sim.pose(high).p.z() - 0.3), 1e-4);
  }
}

TEST_CASE("what cannot be changed is refused and nothing happens", "[runtime]") {
  need("runtime.attach");
  ModelBuilder builder;
  builder.plane("floor");
  const int box = builder.box("box", Vec3(0.2, 0.2, 0.2), 1.0, at(0, 0, 0.1));
  const int other = builder.box("other", Vec3(0.2, 0.2, 0.2), 1.0, at(1, 0, 0.1));
  builder.joint("hinge", JointType::hinge, kWorld, other, {Vec3(1, 0, 0.1), z_to(Vec3::UnitY())});
  Sim sim(builder);
  sim.run(0.1);
  const std::uint64_t before = sim.hash();
  const auto copy = [&] { return std::make_shared<SceneModel>(*sim.world().model()); };
  auto kinematic = copy();
  kinematic->bodies[box].kind = BodyKind::kinematic;
  CHECK_FALSE(sim.world().change(kinematic));
  auto plane = copy();
  plane->bodies[0].kind = BodyKind::dynamic;
  CHECK_FALSE(sim.world().change(plane));
  auto retyped = copy();
  retyped->joints[0].type = JointType::slider;
  CHECK_FALSE(sim.world().change(retyped));
  auto crossed = copy();
  crossed->joints[0].axes[0].lower = 2.0;
  crossed->joints[0].axes[0].upper = 1.0;
  CHECK_FALSE(sim.world().change(crossed));
  auto nan = copy();
  nan->joints[0].axes[0].damping = std::nan("");
  CHECK_FALSE(sim.world().change(nan));
  auto removed = copy();
  removed->joints[0].removed = true;
  CHECK_FALSE(sim.world().change(removed));
  CHECK_FALSE(sim.world().add(removed));
  // Frames a metre apart.
  ModelBuilder far = next_of(sim);
  const int joint = far.joint("far", JointType::fixed, box, other, at(0, 0, 0));
  far.model.joints[joint].X_CM = Pose();
  CHECK_FALSE(sim.world().add(far.build()));
  sim.forget_state();
  CHECK(sim.hash() == before);
  sim.run(0.1);
}

}  // namespace
}  // namespace conformance
