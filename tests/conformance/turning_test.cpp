// What turns while it touches: closed forms, and of what order in the step errors are.
#include <array>
#include <functional>

#include "support.h"

namespace conformance {
namespace {

// The order of an error that falls with the step as dt^order: the slope of its logarithm over four steps.
void measure_order(const std::function<double(double dt)>& error, double least) {
  LineFit line;
  for (const double dt : {2e-3, 1e-3, 5e-4, 2.5e-4}) {
    const double e = error(dt);
    observe("error, step " + std::to_string(dt), e);
    line.add(std::log(dt), std::log(std::max(e, 1e-12)));
  }
  // Terms of third order, which the largest step still has, bend the line by up to a quarter.
  measure("lacks to the order", least - line.slope(), 0.25);
}

// A top on a ball of radius r, which rolls: rho = r z + R d from the contact to the centre of mass, I w' by the
// moments about it,
//   (I - m [rho]^2) w' = -w x I w - m rho x (w x (w x R d) + g z).
struct Top {
  double mass = 1.0, r = 0.005;
  Vec3 d{0, 0, 0.095}, inertia{0.002, 0.002, 0.001};

  struct State {
    Quat q;
    Vec3 w, ball;  // angular velocity, centre of the ball
  };
  State rate(const State& s) const {
    const Mat3 R = s.q.toRotationMatrix();
    const Mat3 I = R * inertia.asDiagonal() * R.transpose();
    const Vec3 arm = R * d, rho = r * Vec3::UnitZ() + arm;
    Mat3 cross;
    cross << 0, -rho.z(), rho.y(), rho.z(), 0, -rho.x(), -rho.y(), rho.x(), 0;
    const Vec3 load = s.w.cross(s.w.cross(arm)) + kGravity * Vec3::UnitZ();
    State out;
    out.w = (I - mass * cross * cross).inverse() * (-s.w.cross(I * s.w) - mass * rho.cross(load));
    out.q = Quat(0, s.w.x(), s.w.y(), s.w.z()) * s.q;
    out.q.coeffs() *= 0.5;
    out.ball = s.w.cross(r * Vec3::UnitZ());
    return out;
  }
  // Classical Runge-Kutta.
  State after(State s, double seconds, int steps) const {
    const double h = seconds / steps;
    const auto ahead = [](State from, const State& k, double by) {
      from.q.coeffs() += by * k.q.coeffs();
      from.w += by * k.w;
      from.ball += by * k.ball;
      return from;
    };
    for (int i = 0; i < steps; ++i) {
      const State a = rate(s), b = rate(ahead(s, a, 0.5 * h)), c = rate(ahead(s, b, 0.5 * h)),
                  e = rate(ahead(s, c, h));
      for (const auto& [k, weight] : {std::pair(a, 1.0), {b, 2.0}, {c, 2.0}, {e, 1.0}})
        s = ahead(s, k, weight * h / 6.0);
      s.q.normalize();
    }
    return s;
  }
};

struct TopRun {
  double off = 0.0;   // the centre of mass, from where it should be [m]
  double gain = 0.0;  // of energy, as a part of it
};
TopRun run_top(double dt, double seconds) {
  const Top top;
  Top::State start;
  start.q = turn(Vec3::UnitX(), 30.0 * kDegree);
  start.w = start.q * Vec3(0, 0, 150.0);
  start.ball = Vec3(0, 0, top.r);
  ModelBuilder builder;
  builder.model.materials[0].friction = 10.0;
  builder.plane("floor");
  // The body's frame is at its centre of mass.
  const int body = builder.body("top", top.mass, top.inertia.asDiagonal(),
                                {start.ball + start.q * top.d, start.q});
  Shape tip;
  tip.type = ShapeType::sphere;
  tip.radius = top.r;
  tip.X_BS.p = -top.d;
  builder.add_shape(body, tip, 0.0);
  Twist& twist = builder.model.bodies[static_cast<std::size_t>(body)].V_WB;
  twist.angular = start.w;
  twist.linear = start.w.cross(Vec3(0, 0, top.r) + start.q * top.d);
  Sim sim(builder);
  const double before = sim.energy();
  sim.run(seconds, dt);
  const Top::State end = top.after(start, seconds, 2000);
  return {(sim.pose(body).p - end.ball - end.q * top.d).norm(),
          std::abs(sim.energy() - before) / before};
}

TEST_CASE("a top that rolls on its tip goes its way", "[contact][turning]") {
  const TopRun run = run_top(kDt, 1.0);
  // It wanders by 0.2 m while it turns by a seventh of a radian in each step.
  measure("off its way [m]", run.off, 2e-3);
  measure("gains or loses, of its energy", run.gain, 1e-3);
}

TEST_CASE("a top that rolls on its tip converges in second order", "[contact][turning][order]") {
  measure_order([](double dt) { return run_top(dt, 0.5).off; }, 2.0);
}

// A disk that rolls while its centre is at rest: the angular velocity is along `low`, from the centre to the point
// of the rim that touches, w = k n. Its axis goes round the vertical at W, k n x axis = W z x axis, and its angular
// momentum, k L, under the moment of the load there, W z x k L = low x m g z.
struct DiskRun {
  double lean = 0.0, gain = 0.0;  // [rad]; as a part of the energy
};
DiskRun run_disk(double dt, double seconds) {
  const double a = 0.1, b = 0.001, mass = 1.0, lean = 8.0 * kDegree;
  const double s = std::sin(lean), c = std::cos(lean);
  const double A = 0.25 * mass * a * a + mass * b * b / 3.0;
  const double C = 0.5 * mass * a * a;
  const Vec3 z = Vec3::UnitZ(), axis(s, 0, c), across(c, 0, -s), low = a * across - b * axis;
  const Vec3 n = low.normalized();
  const Vec3 L = A * n.dot(across) * across + C * n.dot(axis) * axis;
  const double k_per_W = z.cross(axis).y() / n.cross(axis).y();
  const double moment = low.cross(mass * kGravity * z).y();
  const double W = std::sqrt(moment / (k_per_W * z.cross(L).y()));
  ModelBuilder builder;
  builder.model.materials[0].friction = 3.0;
  builder.plane("floor");
  const int disk = builder.cylinder("disk", a, 2.0 * b, mass, {Vec3(0, 0, -low.z()), z_to(axis)});
  builder.model.bodies[static_cast<std::size_t>(disk)].V_WB.angular = k_per_W * W * n;
  Sim sim(builder);
  const double before = sim.energy();
  sim.run(seconds, dt);
  const Vec3 now = sim.pose(disk).q.toRotationMatrix().col(2);
  return {std::abs(std::acos(std::clamp(now.z(), -1.0, 1.0)) - lean),
          std::abs(sim.energy() - before) / before};
}

TEST_CASE("Euler's disk keeps its lean", "[contact][turning]") {
  const DiskRun run = run_disk(kDt, 1.0);
  // Where it touches goes round 8 times a second: by W dt = 0.05 of a radian in each step.
  measure("lean [rad]", run.lean, 2e-3);
  measure("gains or loses, of its energy", run.gain, 5e-3);
}

TEST_CASE("Euler's disk converges in second order", "[contact][turning][order]") {
  measure_order([](double dt) { return run_disk(dt, 0.5).lean; }, 2.0);
}

TEST_CASE("a capsule that spins on ice keeps its energy", "[contact][turning]") {
  ModelBuilder builder;
  builder.model.materials[0].friction = 0.0;
  builder.plane("floor");
  const int capsule =
      builder.capsule("capsule", 0.02, 0.2, 1.0, {Vec3(0, 0, 0.02), turn(Vec3::UnitY(), kPi / 2)});
  builder.model.bodies[static_cast<std::size_t>(capsule)].V_WB.angular = Vec3(50, 0, 10);
  Sim sim(builder);
  const double before = sim.energy();
  sim.run(3.0);
  measure("gains or loses, of its energy", std::abs(sim.energy() - before) / before, 1e-3);
}

// A box that lies on a table which turns, at `radius`, both on their own.
double run_turntable(double dt, double seconds) {
  const double w = 3.0, radius = 0.5;
  ModelBuilder builder;
  builder.model.materials[0].friction = 1.0;
  const int table = builder.cylinder("table", 1.0, 0.1, 10.0, at(0, 0, 0));
  builder.joint("axle", JointType::hinge, -1, table, at(0, 0, 0));
  builder.model.bodies[static_cast<std::size_t>(table)].V_WB.angular = Vec3(0, 0, w);
  const int box = builder.box("box", Vec3(0.1, 0.1, 0.1), 1.0, at(radius, 0, 0.1));
  builder.model.bodies[static_cast<std::size_t>(box)].V_WB = {Vec3(0, w * radius, 0),
                                                              Vec3(0, 0, w)};
  Sim sim(builder);
  sim.run(seconds, dt);
  return std::abs(sim.pose(box).p.head<2>().norm() - radius);
}

TEST_CASE("a box on a turntable stays where it is", "[contact][turning]") {
  // w r dt / 2 in each step would be 14 mm.
  measure("creeps outwards [m]", run_turntable(kDt, 3.0), 1e-4);
}

TEST_CASE("balls hit one after the other, or all at once", "[contact][bounce]") {
  const double gap = GENERATE(0.0, 1e-5, 1e-4, 3e-4, 1e-3);
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  builder.model.materials[0].friction = 0.0;
  builder.model.materials[0].restitution = 1.0;
  const std::array<double, 3> mass = {1.0, 0.5, 0.25};
  std::array<int, 3> ball{};
  for (std::size_t i = 0; i < 3; ++i)
    ball[i] = builder.sphere("ball" + std::to_string(i), 0.05, mass[i],
                             at(i == 0 ? -0.05 : (0.1 + gap) * static_cast<double>(i), 0, 0));
  builder.model.bodies[static_cast<std::size_t>(ball[0])].V_WB.linear = Vec3(1, 0, 0);
  Sim sim(builder);
  sim.run(0.5);
  // v1' = (m1 - m2) / (m1 + m2), v2' = 2 m1 / (m1 + m2), twice; or J v of both contacts reversed at once.
  const std::array<double, 3> one_by_one = {1.0 / 3.0, 4.0 / 9.0, 16.0 / 9.0};
  const std::array<double, 3> at_once = {1.0 / 7.0, 8.0 / 7.0, 8.0 / 7.0};
  double first = 0.0, second = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double v = sim.twist(ball[i]).linear.x();
    first = std::max(first, std::abs(v - one_by_one[i]));
    second = std::max(second, std::abs(v - at_once[i]));
  }
  measure("speeds [m/s], of either law", std::min(first, second), 1e-3);
  measure("energy gained or lost [J]", std::abs(sim.energy() - 0.5), 1e-3);
}

// Newton's law with friction adds energy to a bar that falls on its end at some angles.
TEST_CASE("boxes that bounce with friction gain no energy", "[contact][bounce]") {
  for (int i = 0; i < 24; ++i) {
    ModelBuilder builder;
    builder.model.materials[0].friction = i % 2 == 0 ? 0.3 : 1.0;
    builder.model.materials[0].restitution = 0.9;
    builder.plane("floor");
    const Quat q = turn(Vec3(std::sin(i), std::cos(2.0 * i), 0.3), 0.26 * i);
    const int box = builder.box("box", Vec3(0.05, 0.15, 0.04), 1.0, {Vec3(0, 0, 0.2), q});
    builder.model.bodies[static_cast<std::size_t>(box)].V_WB = {Vec3(0.1, -1.0, 0),
                                                                Vec3(-1.7, 2.8, 3.8)};
    Sim sim(builder);
    double least = sim.energy(), gain = 0.0;
    const double start = least;
    sim.run(1.0, kDt, [&] {
      const double now = sim.energy();
      gain = std::max(gain, now - least);
      least = std::min(least, now);
    });
    measure("gained, of its energy", gain / start, 1e-2);
  }
}

}  // namespace
}  // namespace conformance
