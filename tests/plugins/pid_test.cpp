#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "joint_pid/pid.h"

using joint_pid::Pid;

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}

TEST_CASE("P and D act on error and speed") {
  Pid pid({10, 0, 2, kInfinity});
  CHECK(pid.update(1.0, 0.25, 0.5, 0.01) == Approx(10 * 0.75 - 2 * 0.5));
}

TEST_CASE("a jump of the target does not kick through the derivative") {
  Pid pid({0, 0, 5, kInfinity});
  pid.update(0, 0, 0, 0.01);
  CHECK(pid.update(100, 0, 0, 0.01) == 0.0);
}

TEST_CASE("the integral removes a constant load") {
  // A unit mass under a load of -3 N, closed loop stable for these gains (Routh: kd kp > ki).
  Pid pid({40, 30, 12, kInfinity});
  double x = 0, v = 0;
  const double dt = 1e-3;
  for (int i = 0; i < 20000; ++i) {
    v += (pid.update(0.5, x, v, dt) - 3.0) * dt;
    x += v * dt;
  }
  CHECK(x == Approx(0.5).margin(1e-4));
  CHECK(pid.integral_output() == Approx(3.0).margin(1e-3));
}

TEST_CASE("a clamped output does not wind the integral up") {
  Pid pid({1, 5, 0, 2});
  for (int i = 0; i < 1000; ++i) CHECK(std::abs(pid.update(10, 0, 0, 0.01)) <= 2.0);
  // Held back for 10 s it has integrated nothing beyond the bound: it answers a reversal at once.
  CHECK(pid.integral_output() <= 2.0);
  CHECK(pid.update(-10, 0, 0, 0.01) == Approx(-2.0));
}
