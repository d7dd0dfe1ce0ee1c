// Small angles, large ratios, thin walls: limits of time-stepping schemes.
#include <algorithm>

#include "support.h"

namespace conformance {
namespace {

// A coin that leans inwards by `lean` and rolls on a circle. With e3 the coin's axis (up by the lean,
// outwards), d the direction from its lowest rim to its middle, a its radius, b half its thickness,
// R the circle of the rim that touches, A and C the inertia about a diameter and the axis: steady
// precession W (Euler's equations in the frame that turns with it) needs
//     m g (a sin - b cos) = W^2 [m p_z r_c + cos (C R / a - (C - A) sin)],
//     p = a d + b e3,  r_c = R - a sin + b cos,  spin about e3 = -W R / a + W sin.
TEST_CASE("a coin that rolls on a circle keeps its lean", "[friction]") {
  const double a = 0.1, b = 0.002, R = 2.0, mass = 0.2, lean = 5.0 * kDegree;
  const double s = std::sin(lean), c = std::cos(lean);
  const double C = 0.5 * mass * a * a, A = 0.5 * C + mass * b * b / 3.0;
  const double p_z = a * c + b * s, r_c = R - a * s + b * c;
  const double W = std::sqrt(mass * kGravity * (a * s - b * c) /
                             (mass * p_z * r_c + c * (C * R / a - (C - A) * s)));
  for (const double dt : {4e-3, 1e-3, 2.5e-4}) {
    ModelBuilder builder;
    builder.model.materials[0].friction = 0.8;
    builder.plane("floor");
    const Vec3 axis(c, 0, s);
    const int coin = builder.cylinder("coin", a, 2.0 * b, mass, {Vec3(r_c, 0, p_z), z_to(axis)});
    Twist& twist = builder.model.bodies[coin].V_WB;
    twist.linear = Vec3(0, W * r_c, 0);
    twist.angular = Vec3(0, 0, W) - W * R / a * axis;
    Sim sim(builder);
    double worst = 0.0;
    sim.run(3.0, dt, [&] {
      const Vec3 now = sim.pose(coin).q.toRotationMatrix().col(2);
      worst = std::max(worst, std::abs(std::asin(std::clamp(now.z(), -1.0, 1.0)) - lean));
    });
    // A scheme of first order leaves the steady lean by the angle of one step, W dt, and swings about it.
    measure("lean [rad], step " + std::to_string(dt), worst, 0.01 + 2.0 * W * dt);
    const Vec3 at_end = sim.pose(coin).p;
    measure("radius of the circle [m], step " + std::to_string(dt),
            std::abs(at_end.head<2>().norm() - r_c), 0.1);
  }
}

TEST_CASE("links that hinges hold inside each other gain no energy", "[faults]") {
  // Boxes of which every second touches the next but one; the hinges turn, and cannot part them.
  struct Link {
    Vec3 size, offset, axis;
    double mass, lower, upper;
  };
  const Link links[] = {
      {Vec3(0.07, 0.12, 0.16), Vec3(0.0, 0.0, 0.15), Vec3::UnitZ(), 1.8, 0.0, 0.0},
      {Vec3(0.15, 0.14, 0.12), Vec3(0.04, -0.03, 0.11), Vec3::UnitZ(), 0.7, -0.9, 2.4},
      {Vec3(0.10, 0.07, 0.23), Vec3(0.01, 0.0, 0.07), Vec3::UnitX(), 0.4, -0.5, 1.8},
      {Vec3(0.08, 0.06, 0.28), Vec3(0.04, 0.02, 0.01), Vec3::UnitY(), 0.9, -2.0, 1.3}};
  ModelBuilder builder;
  builder.plane("floor");
  Vec3 place = Vec3::Zero();
  int last = -1;
  for (const Link& link : links) {
    place += link.offset;
    const int body = builder.box("link" + std::to_string(last + 1), link.size, link.mass,
                                 at(place.x(), place.y(), place.z()));
    if (last >= 0) {
      const int joint = builder.joint("hinge" + std::to_string(last), JointType::hinge, last, body,
                                      {Vec3::Zero(), z_to(link.axis)});
      builder.model.joints[joint].axes[0].lower = link.lower;
      builder.model.joints[joint].axes[0].upper = link.upper;
    }
    last = body;
  }
  Sim sim(builder);
  const double start = sim.energy();
  double most = start;
  sim.run(0.6, kDt, [&] { most = std::max(most, sim.energy()); });
  // Pushing the deepest pair, 65 mm, out of each other lifts no more than all links by as much.
  measure("energy gained [J]", most - start, 3.8 * 9.81 * 0.065);
}

TEST_CASE("a chain that falls on a floor gains no energy", "[faults]") {
  ModelBuilder builder;
  builder.plane("floor");
  const int count = 20;
  const double length = 0.1, mass = 0.05;
  const Quat tilt = turn(Vec3::UnitY(), -0.1);
  const auto along = [&](double x) { return Pose(Vec3(0, 0, 0.5) + tilt * Vec3(x, 0, 0), tilt); };
  int last = -1;
  for (int i = 0; i < count; ++i) {
    const int link = builder.capsule("link" + std::to_string(i), 0.015, 0.07, mass,
                                     {along((i + 0.5) * length).p, tilt * z_to(Vec3::UnitX())});
    if (last >= 0)
      builder.joint("pin" + std::to_string(i), JointType::hinge, last, link,
                    {along(i * length).p, tilt * z_to(Vec3::UnitY())});
    last = link;
  }
  Sim sim(builder);
  const double start = sim.energy();
  double most = start, speed = 0.0;
  sim.run(3.0, kDt, [&] {
    most = std::max(most, sim.energy());
    for (int i = 1; i <= count; ++i) speed = std::max(speed, sim.twist(i).linear.norm());
  });
  measure("energy gained over what there was", (most - start) / start, 1e-3);
  // A body that falls from the highest point, 1.7 m, has 5.8 m/s; a whip is faster.
  measure("fastest [m/s]", speed, 15.0);
}

TEST_CASE("links that overlap at the start are pushed apart gently", "[faults]") {
  const double bound = GENERATE(2.0, kInfinity);
  ModelBuilder builder;
  // Two arms side by side, turned towards each other until their tips are inside each other.
  const double lean = 0.2;
  const auto arm = [&](double y, double angle) {
    const Quat q = turn(Vec3::UnitZ(), angle);
    return Pose(Vec3(0, y, 0) + q * Vec3(0.2, 0, 0), q);
  };
  const int one = builder.box("one", Vec3(0.4, 0.1, 0.1), 1.0, arm(0, lean));
  const int two = builder.box("two", Vec3(0.4, 0.1, 0.1), 1.0, arm(0.2, -lean));
  const int left = builder.joint("left", JointType::hinge, kWorld, one, at(0, 0, 0));
  const int right = builder.joint("right", JointType::hinge, kWorld, two, at(0, 0.2, 0));
  builder.motor("left_servo", left, MotorMode::servo);
  builder.motor("right_servo", right, MotorMode::servo);
  Sim sim(builder);
  for (Drive& drive : sim.drives) {
    drive.position = 0.0;
    drive.kp = 100.0;
    drive.kd = 5.0;
    drive.max_effort = bound;
  }
  double fastest = 0.0, effort = 0.0;
  sim.run(2.0, kDt, [&] {
    for (const int joint : {left, right}) fastest = std::max(fastest, std::abs(sim.u(joint)));
    for (const int motor : {0, 1}) effort = std::max(effort, std::abs(sim.motor_effort(motor)));
  });
  // 1 m/s at most at the tip, 0.4 m from the axis, and each may take all of it.
  measure("fastest [rad/s]", fastest, 2.5);
  // kp times the angle that undoes the overlap, below 0.2 rad, and kd times that speed.
  measure("servo's effort [N m]", effort, std::min(bound, 32.5) * (1.0 + 1e-9));
}

TEST_CASE("links that cannot come apart stay calm", "[faults]") {
  // Two arms inside each other, side by side (0), or one above the other about axes that lean by a
  // little, such that to come apart they would have to turn by very much (1); or the first and the
  // third link of a chain (2).
  give_up_after(12.0);
  const int kind = GENERATE(0, 1, 2);
  const double lean = GENERATE(0.0, 0.01, 0.1), bound = GENERATE(0.0, 2.0, kInfinity);
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const Vec3 size(0.5, 0.1, 0.1);
  const auto arm = [&](const Vec3& root, double angle) {
    const Quat q = turn(Vec3::UnitZ(), angle);
    return Pose(root + q * Vec3(0.2, 0, 0), q);
  };
  const int one = builder.box("one", size, 1.0, arm(Vec3::Zero(), lean));
  int two = -1;
  std::vector<int> joints{builder.joint("first", JointType::hinge, kWorld, one, at(0, 0, 0))};
  if (kind < 2) {
    const Vec3 root = kind == 0 ? Vec3(0, 0.03, 0) : Vec3(0, 0, 0.08);
    two = builder.box("two", size, 1.0, arm(root, -0.5 * lean));
    joints.push_back(builder.joint("second", JointType::hinge, kWorld, two,
                                   {root, turn(Vec3::UnitX(), 0.02 * kind)}));
  } else {
    const int link = builder.box("link", Vec3(0.02, 0.02, 0.02), 0.1, at(0.42, 0, 0));
    two = builder.box("two", Vec3(0.4, 0.1, 0.1), 1.0,
                      {Vec3(0.24, 0.03 + lean, 0), turn(Vec3::UnitZ(), kPi - lean)});
    joints.push_back(builder.joint("second", JointType::hinge, one, link, at(0.4, 0, 0)));
    joints.push_back(builder.joint("third", JointType::hinge, link, two, at(0.44, 0.03, 0)));
  }
  for (const int joint : joints)
    builder.motor("servo" + std::to_string(joint), joint, MotorMode::servo);
  Sim sim(builder);
  const double kp = 100.0;
  for (Drive& drive : sim.drives) {
    drive.position = 0.0;
    drive.kp = kp;
    drive.kd = 5.0;
    drive.max_effort = bound;
  }
  double fastest = 0.0, effort = 0.0, moved = 0.0;
  const auto tip = [&](int body) -> Vec3 { return sim.pose(body) * Vec3(0.2, 0, 0); };
  Vec3 before[2] = {tip(one), tip(two)};
  sim.run(2.0, kDt, [&] {
    for (const int i : {0, 1}) {
      const int body = i == 0 ? one : two;
      fastest = std::max(fastest, sim.twist(body).linear.norm());
      moved = std::max(moved, (tip(body) - before[i]).norm() / kDt);
      before[i] = tip(body);
    }
    for (int motor = 0; motor < int(joints.size()); ++motor)
      effort = std::max(effort, std::abs(sim.motor_effort(motor)));
  });
  // What is pushed apart moves by 1 m/s, in the mean over the link, and has no speed of it. But it
  // may wind the servos of the chain by half a turn until there is room, whose energy is let go then.
  const double energy = kind < 2 ? 0.0 : std::min(bound, 0.5 * kp * kPi) * kPi;
  const std::string what = kind < 2 ? "" : bound > 2.0 ? ", wound chain" : ", chain";
  const double most = 1.0 + std::sqrt(2.0 * energy / 1.0);
  measure("fastest [m/s]" + what, fastest, most);
  measure("tip moved [m/s]" + what, moved, 2.0 * most);
  measure("servo's effort [N m]", effort, std::min(bound * (1.0 + 1e-9), kp * 220.0 * kDegree));
}

TEST_CASE("a thousand kilograms on a gram shoot nothing out", "[faults]") {
  const bool round = GENERATE(false, true);
  ModelBuilder builder;
  builder.plane("floor");
  const int light = round ? builder.sphere("light", 0.02, 1e-3, at(0, 0, 0.02))
                          : builder.box("light", Vec3(0.04, 0.04, 0.04), 1e-3, at(0, 0, 0.02));
  const int heavy = builder.box("heavy", Vec3(0.5, 0.5, 0.5), 1000.0, at(0, 0, 0.29));
  Sim sim(builder);
  double fastest = 0.0;
  sim.run(0.3, kDt, [&] {
    for (const int body : {light, heavy})
      fastest = std::max(fastest, sim.twist(body).linear.norm());
  });
  // The heavy one may crush the light one and fall by 0.04 m, sqrt(2 g h) = 0.9 m/s.
  measure("fastest [m/s]", fastest, 2.0);
}

TEST_CASE("a thousand kilograms stand on a gram", "[faults]") {
  give_up_after(12.0);
  const double ratio = GENERATE(1e3, 1e6);
  ModelBuilder builder;
  builder.plane("floor");
  const int light = builder.box("light", Vec3(0.04, 0.04, 0.04), 1000.0 / ratio, at(0, 0, 0.02));
  const int heavy = builder.box("heavy", Vec3(0.5, 0.5, 0.5), 1000.0, at(0, 0, 0.29));
  Sim sim(builder);
  double fastest = 0.0;
  sim.run(5.0, kDt, [&] {
    for (const int body : {light, heavy})
      fastest = std::max(fastest, sim.twist(body).linear.norm());
  });
  measure("fastest [m/s]", fastest, 0.01);
  measure("sinks [m]", std::abs(sim.pose(heavy).p.z() - 0.29), 1e-4);
  measure("walks [m]", sim.pose(heavy).p.head<2>().norm(), 1e-3);
  measure_relative("load of the heavy one [N]", sim.contact_force(heavy).z(), 1000.0 * kGravity,
                   1e-3);
}

TEST_CASE("a grain of a tenth of a millimetre comes to rest", "[faults]") {
  const double side = 1e-4;
  ModelBuilder builder;
  builder.plane("floor");
  const int grain = builder.box("grain", Vec3(side, side, side), 1e-9, at(0, 0, 0.001));
  Sim sim(builder);
  sim.run(1.0);
  double fastest = 0.0;
  sim.run(0.2, kDt, [&] { fastest = std::max(fastest, sim.twist(grain).linear.norm()); });
  measure("fastest [m/s]", fastest, 1e-5);
  measure("off its face [m]", std::abs(sim.pose(grain).p.z() - 0.5 * side), 0.1 * side);
}

TEST_CASE("a thin wall stops what is fast", "[faults]") {
  const double phase = GENERATE(0.0, 0.27, 0.61, 0.93);  // of a step
  const double speed = 100.0, radius = 0.01;
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  builder.box("wall", Vec3(0.001, 2, 2), 0.0, at(0, 0, 0));
  const int ball =
      builder.sphere("ball", radius, 0.1, at(-(3.0 + phase) * speed * kDt - 0.0005 - radius, 0, 0));
  builder.model.bodies[ball].V_WB.linear = Vec3(speed, 0, 0);
  Sim sim(builder);
  double farthest = -1.0;
  sim.run(0.02, kDt, [&] { farthest = std::max(farthest, sim.pose(ball).p.x()); });
  measure("beyond the wall [m]", std::max(0.0, farthest), 0.0);
}

TEST_CASE("an oblique bounce has the friction of its impulse", "[bounce]") {
  // Slides during the whole impact: m dv_t = mu m (1 + e) v_n, and spins up by 5/2 dv_t / r.
  const double phase = GENERATE(0.1, 0.35, 0.6, 0.85);
  const double mu = 0.2, e = 0.6, v_n = 3.0, v_t = 4.0, radius = 0.1;
  ModelBuilder builder;
  const int material = builder.material("rubber", mu, e);
  builder.model.physics.gravity = Vec3::Zero();
  builder.plane("floor", Pose(), material);
  const int ball =
      builder.sphere("ball", radius, 1.0, at(0, 0, radius + v_n * (3.0 + phase) * kDt), material);
  builder.model.bodies[ball].V_WB.linear = Vec3(v_t, 0, -v_n);
  Sim sim(builder);
  sim.run(0.02);
  const double lost = mu * (1.0 + e) * v_n;
  measure_relative("speed along the floor [m/s]", v_t - sim.twist(ball).linear.x(), lost, 1e-3);
  measure_relative("spin [rad/s]", sim.twist(ball).angular.y(), 2.5 * lost / radius, 1e-3);
}

}  // namespace
}  // namespace conformance
