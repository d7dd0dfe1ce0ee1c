// Bodies that touch nothing: projectile and tumbling box.
#include "support.h"

namespace conformance {
namespace {

struct Flight {
  Vec3 position_error = Vec3::Zero();
  Vec3 velocity_error = Vec3::Zero();
  double turn_error = 0.0;
};

// A spinning ball thrown for `seconds`, against p0 + v t + g t^2 / 2.
Flight fly(double seconds, double dt) {
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3(0, 0, -kGravity);
  const Vec3 p0(1, -2, 3), v0(3, -2, 5), w0(1, 2, 3);
  const int ball = builder.sphere("ball", 0.1, 2.0, {p0, Quat(1, 0, 0, 0)});
  builder.model.bodies[0].V_WB = {v0, w0};
  Sim sim(builder);
  sim.run(seconds, dt);
  const Vec3 g(0, 0, -kGravity);
  Flight flight;
  flight.position_error = sim.pose(ball).p - (p0 + v0 * seconds + 0.5 * g * seconds * seconds);
  flight.velocity_error = sim.twist(ball).linear - (v0 + g * seconds);
  flight.turn_error = angle_between(sim.pose(ball).q, turn(w0, w0.norm() * seconds));
  return flight;
}

TEST_CASE("projectile: position exact", "[free]") {
  const double dt = GENERATE(1e-3, 4e-3);
  const Flight flight = fly(1.0, dt);
  measure("position error [m]", flight.position_error.norm(), 1e-9);
}

TEST_CASE("projectile: position within the first-order bias", "[free]") {
  // Semi-implicit Euler falls g dt t / 2 too far, exactly; higher orders less. 1e-9 m for rounding:
  // 1000 additions at 10 m.
  const double dt = GENERATE(1e-3, 4e-3);
  const double t = 1.0;
  const Flight flight = fly(t, dt);
  measure("vertical error / (g dt t / 2)",
          std::abs(flight.position_error.z()) / (0.5 * kGravity * dt * t), 1.0 + 1e-6);
  measure("horizontal error [m]", flight.position_error.head<2>().norm(), 1e-9);
}

TEST_CASE("projectile: velocity and spin", "[free]") {
  const double dt = GENERATE(1e-3, 4e-3);
  const Flight flight = fly(1.0, dt);
  // Constant acceleration is integrated exactly by every method: rounding only.
  measure("velocity error [m/s]", flight.velocity_error.norm(), 1e-9);
  // A sphere's spin is constant; turning by w dt each step is exact when done with the exponential
  // map, and errs by w^3 dt^3 / 12 a step when the quaternion is integrated linearly.
  measure("orientation error [rad]", flight.turn_error,
          std::pow(std::sqrt(14.0), 3) * dt * dt / 12.0 + 1e-9);
}

struct Tumble {
  double energy_error = 0.0;    // largest, relative to the start
  double momentum_error = 0.0;  // of the angular momentum about the centre, largest, relative
  double fall_error = 0.0;      // [m] of the centre at the end
};

// Box of 0.1 x 0.4 x 0.9 m that spins about its middle axis, which is unstable.
Tumble tumble(double dt) {
  const double g = 9.8, seconds = 10.0, mass = 10.0;
  const Vec3 size(0.1, 0.4, 0.9), v0(-2, 2, 8), w0(0.1, 5, 0.1);
  const Vec3 moments =
      mass / 12.0 *
      Vec3(size.y() * size.y() + size.z() * size.z(), size.x() * size.x() + size.z() * size.z(),
           size.x() * size.x() + size.y() * size.y());
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3(0, 0, -g);
  const int box = builder.box("box", size, mass, Pose());
  builder.model.bodies[0].V_WB = {v0, w0};
  Sim sim(builder);
  const auto spin = [&] {
    const Mat3 R = sim.pose(box).q.toRotationMatrix();
    return Vec3(R * moments.cwiseProduct(R.transpose() * sim.twist(box).angular));
  };
  const auto energy = [&] {
    const Twist& V = sim.twist(box);
    return 0.5 * mass * V.linear.squaredNorm() + 0.5 * V.angular.dot(spin()) +
           mass * g * sim.pose(box).p.z();
  };
  const double start = energy();
  const Vec3 spin_start = spin();
  Tumble result;
  sim.run(seconds, dt, [&] {
    result.energy_error =
        std::max(result.energy_error, std::abs(energy() - start) / std::abs(start));
    result.momentum_error =
        std::max(result.momentum_error, (spin() - spin_start).norm() / spin_start.norm());
  });
  const Vec3 centre = v0 * seconds + Vec3(0, 0, -0.5 * g * seconds * seconds);
  result.fall_error = (sim.pose(box).p - centre).norm();
  return result;
}

TEST_CASE("tumbling box: energy to 1e-8", "[free]") {
  measure("relative energy error", tumble(kDt).energy_error, 1e-8);
}

TEST_CASE("tumbling box: energy to 1.4e-2, halving with dt", "[free]") {
  const Tumble coarse = tumble(kDt), fine = tumble(0.5 * kDt);
  measure("relative energy error", coarse.energy_error, 1.4e-2);
  // First order: half the step, half the error. Better integrators are below the floor already.
  if (coarse.energy_error > 1e-8) {
    measure("energy error at dt/2 over that at dt", fine.energy_error / coarse.energy_error, 0.55);
  }
  measure("fall error [m]", coarse.fall_error, 0.5 * 9.8 * kDt * 10.0 * (1.0 + 1e-6));
}

TEST_CASE("tumbling box: angular momentum", "[free]") {
  const Tumble coarse = tumble(kDt), fine = tumble(0.5 * kDt);
  // Turning the body after its momentum was taken errs by at most w^2 dt^2 / 2 of it a step; were
  // all of these to add up, by w^2 dt t / 2 = 0.125. It must also vanish with dt.
  measure("relative angular momentum error", coarse.momentum_error, 0.125);
  if (coarse.momentum_error > 1e-8) {
    measure("momentum error at dt/2 over that at dt", fine.momentum_error / coarse.momentum_error,
            0.55);
  }
}

}  // namespace
}  // namespace conformance
