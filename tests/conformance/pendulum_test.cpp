// Pendulums on hinges and balls.
#include "support.h"

namespace conformance {
namespace {

constexpr double kLength = 1.0;
constexpr double kMass = 1.0;

// Complete elliptic integral of the first kind by the arithmetic-geometric mean
// (Abramowitz and Stegun 17.6.3): K(k) = pi / (2 agm(1, sqrt(1 - k^2))).
double elliptic_k(double k) {
  double a = 1.0, b = std::sqrt(1.0 - k * k);
  while (std::abs(a - b) > 1e-15) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return kPi / (2.0 * a);
}

// Thin rod along its own z, hanging by its upper end from `pivot`, turned by `angle` about y.
// Positive angles swing it towards -x.
int add_rod(ModelBuilder& builder, const std::string& name, const Vec3& pivot, double angle) {
  const double transverse = kMass * kLength * kLength / 12.0;
  const Vec3 moments(transverse, transverse, 0.01 * transverse);
  const Quat q = turn(Vec3::UnitY(), angle);
  const Vec3 centre = pivot + q * Vec3(0, 0, -0.5 * kLength);
  return builder.body(name, kMass, Mat3(moments.asDiagonal()), {centre, q});
}

Pose hinge_at(const Vec3& pivot) { return {pivot, z_to(Vec3::UnitY())}; }

TEST_CASE("rod pendulum: period from 60 degrees", "[pendulum]") {
  const double start = 60.0 * kDegree;
  ModelBuilder builder;
  const Vec3 pivot(0.3, -0.2, 2.0);
  const int rod = add_rod(builder, "rod", pivot, start);
  const int hinge = builder.joint("hinge", JointType::hinge, kWorld, rod, hinge_at(pivot));
  Sim sim(builder);
  Crossings crossings(-start);  // q = 0 at the start, so the lowest point is at -60 degrees
  double t = 0.0, lowest = 0.0;
  sim.run(20.0, kDt, [&] {
    t += kDt;
    crossings.add(t, sim.q(hinge));
    lowest = std::min(lowest, sim.q(hinge));
  });
  // T = 4 sqrt(I / (m g d)) K(sin(start / 2)), I = m L^2 / 3, d = L / 2. A symplectic first-order
  // method's period errs by (w dt)^2 / 24 = 6e-7.
  const double expected =
      4.0 * std::sqrt(2.0 * kLength / (3.0 * kGravity)) * elliptic_k(std::sin(0.5 * start));
  REQUIRE(crossings.times().size() >= 10);
  measure_relative("period", crossings.period(), expected, 1e-5);
  // The far turning point is sampled within dt, which costs w^2 A dt^2 / 8 < 1e-5 rad, and a
  // first-order method swings w dt A / 2 = 2e-3 rad off at most.
  measure("far turning point [rad]", std::abs(lowest + 2.0 * start), 2e-3);
}

TEST_CASE("rod pendulum: small swing about a tilted axis", "[pendulum]") {
  // An axis tilted by 30 degrees from the horizontal leaves cos 30 of gravity.
  const double start = 1.0 * kDegree, tilt = 30.0 * kDegree;
  ModelBuilder builder;
  builder.model.physics.gravity = kGravity * (turn(Vec3::UnitX(), tilt) * Vec3(0, 0, -1));
  const int rod = add_rod(builder, "rod", Vec3::Zero(), start);
  const int hinge = builder.joint("hinge", JointType::hinge, kWorld, rod, hinge_at(Vec3::Zero()));
  Sim sim(builder);
  Crossings crossings(-start);
  double t = 0.0;
  sim.run(20.0, kDt, [&] { crossings.add(t += kDt, sim.q(hinge)); });
  const double expected = 4.0 * std::sqrt(2.0 * kLength / (3.0 * kGravity * std::cos(tilt))) *
                          elliptic_k(std::sin(0.5 * start));
  measure_relative("period", crossings.period(), expected, 1e-5);
}

struct EnergyError {
  double largest = 0.0;  // over the run
  double drift = 0.0;    // of the mean over two seconds, from the first to the last
};

// Two rods, straight, 60 degrees from hanging; errors over the energy they can lose.
EnergyError double_pendulum(double dt) {
  const double start = 60.0 * kDegree, seconds = 10.0, window = 2.0;
  ModelBuilder builder;
  const Vec3 tip = turn(Vec3::UnitY(), start) * Vec3(0, 0, -kLength);
  const int upper = add_rod(builder, "upper", Vec3::Zero(), start);
  const int lower = add_rod(builder, "lower", tip, start);
  builder.joint("shoulder", JointType::hinge, kWorld, upper, hinge_at(Vec3::Zero()));
  builder.joint("elbow", JointType::hinge, upper, lower, hinge_at(tip));
  Sim sim(builder);
  // Centres 0.5 L and 1.5 L below the pivot, each raised by 1 - cos(start) of that.
  const double scale = kMass * kGravity * 2.0 * kLength * (1.0 - std::cos(start));
  const double transverse = kMass * kLength * kLength / 12.0;
  const auto energy = [&] {
    double sum = 0.0;
    for (const int body : {upper, lower}) {
      const Twist& V = sim.twist(body);  // in the plane: only the transverse moment turns
      sum += 0.5 * kMass * V.linear.squaredNorm() + 0.5 * transverse * V.angular.squaredNorm() +
             kMass * kGravity * sim.pose(body).p.z();
    }
    return sum;
  };
  const double at_start = energy();
  EnergyError error;
  double t = 0.0, first = 0.0, last = 0.0;
  sim.run(seconds, dt, [&] {
    t += dt;
    const double now = (energy() - at_start) / scale;
    error.largest = std::max(error.largest, std::abs(now));
    if (t <= window) first += now * dt / window;
    if (t > seconds - window) last += now * dt / window;
  });
  error.drift = std::abs(last - first);
  return error;
}

TEST_CASE("double pendulum: energy drift over 10 s", "[pendulum]") {
  const EnergyError error = double_pendulum(kDt);
  measure("drift of the mean energy", error.drift, 1e-3);
}

TEST_CASE("double pendulum: energy error at any time in 10 s", "[pendulum]") {
  const EnergyError error = double_pendulum(kDt);
  measure("largest energy error", error.largest, 1e-3);
}

TEST_CASE("double pendulum: energy error vanishes with dt", "[pendulum]") {
  const EnergyError coarse = double_pendulum(kDt), fine = double_pendulum(0.5 * kDt);
  if (coarse.largest > 1e-8) {
    measure("energy error at dt/2 over that at dt", fine.largest / coarse.largest, 0.6);
  }
}

TEST_CASE("conical pendulum on a ball joint", "[pendulum]") {
  // A rod that turns rigidly about the vertical through its upper end stays at the angle a when
  // (I - J) w^2 cos a = m g d, I = m L^2 / 3 across, J along the rod.
  const double angle = 40.0 * kDegree;
  ModelBuilder builder;
  const int rod = add_rod(builder, "rod", Vec3::Zero(), angle);
  const double across = kMass * kLength * kLength / 3.0;
  const double along = 0.01 * kMass * kLength * kLength / 12.0;
  const double rate =
      std::sqrt(kMass * kGravity * 0.5 * kLength / ((across - along) * std::cos(angle)));
  const Vec3 spin(0, 0, rate);
  const int ball = builder.joint("ball", JointType::ball, kWorld, rod, Pose());
  Body& body = builder.model.bodies[rod];
  body.V_WB = {spin.cross(body.X_WB.p), spin};
  builder.model.joints[ball].velocity = {0, 0, rate};
  const Vec3 start = body.X_WB.p;
  Sim sim(builder);
  double worst = 0.0;
  sim.run(5.0, kDt, [&] {
    const double now = std::acos(-sim.pose(rod).p.normalized().z());
    worst = std::max(worst, std::abs(now - angle));
  });
  // A first-order method errs in the state by about w dt at any time: 5e-3; the angle then swings
  // by as much around its own steady value.
  measure("angle error [rad]", worst, rate * kDt);
  const Vec3 expected = turn(Vec3::UnitZ(), rate * 5.0) * start;
  measure("direction error after 5 s [rad]",
          std::acos(std::min(1.0, expected.normalized().dot(sim.pose(rod).p.normalized()))),
          rate * kDt * rate * 5.0);
}

}  // namespace
}  // namespace conformance
