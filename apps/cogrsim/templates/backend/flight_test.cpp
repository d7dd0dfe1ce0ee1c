// Tests of the engine against closed-form solutions. Catch2 2.13 or 3.
#define CATCH_CONFIG_MAIN
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif
#include <cmath>

#include "flight.h"

using flight::Body;
using flight::Vec3;

TEST_CASE("a thrown body follows its parabola") {
  Body body;
  body.velocity = Vec3(3, -2, 5);
  const Vec3 g(0, 0, -9.81);
  for (int i = 0; i < 1000; ++i) flight::advance(body, g, 1e-3);
  // The method is exact except for the rounding of 1000 additions of numbers below 10.
  CHECK((body.position - (Vec3(3, -2, 5) + 0.5 * g)).norm() < 1e-11);
  CHECK((body.velocity - (Vec3(3, -2, 5) + g)).norm() < 1e-11);
}

TEST_CASE("a symmetric top precesses") {
  // Moments A, A, C: the axis goes around the angular momentum L at |L| / A (Goldstein, Classical
  // Mechanics, section 5.6).
  const double A = 2.0, C = 1.0;
  Body body;
  body.inertia = Vec3(A, A, C).asDiagonal();
  flight::set_spin(body, Vec3(1.0, 0.0, 4.0));
  const Vec3 L = body.angular_momentum;
  const double rate = L.norm() / A;
  const double dt = 1e-3;
  const int steps = 3000;
  for (int i = 0; i < steps; ++i) flight::advance(body, Vec3::Zero(), dt);
  const Vec3 axis = body.orientation * Vec3::UnitZ();
  const Vec3 expected = Eigen::AngleAxisd(rate * dt * steps, L.normalized()) * Vec3::UnitZ();
  // Fourth order: an error per step of the order of (w dt)^5 / 120 with w below 5 rad/s, summed up
  // over 3000 steps, is 8e-11.
  CHECK((axis - expected).norm() < 1e-10);
  CHECK((body.angular_momentum - L).norm() == 0.0);
}

TEST_CASE("a still body does not move, a carried body keeps its velocity") {
  Body body;
  body.motion = flight::Motion::still;
  body.velocity = Vec3(1, 0, 0);
  flight::advance(body, Vec3(0, 0, -9.81), 0.1);
  CHECK(body.position.norm() == 0.0);
  body.motion = flight::Motion::carried;
  flight::advance(body, Vec3(0, 0, -9.81), 0.1);
  CHECK((body.position - Vec3(0.1, 0, 0)).norm() < 1e-15);
}
