// Swings up the pole of a cart and balances it. With the cart's position x, the pole's angle a from
// upright (positive towards +x), masses M and m, half the pole's length l and its inertia about its
// end J = 4/3 m l^2, the equations of motion are
//
//     (M + m) x'' + m l cos(a) a'' - m l sin(a) a'^2 = F
//     m l cos(a) x'' + J a'' = m g l sin(a)
//
// Near upright, F = -K (x - goal, a, x', a') minimises the sum of q_i state_i^2 + r F^2 of the
// linearised equations, sampled with the controller's period (linear quadratic regulator; B.
// Anderson, J. Moore, Optimal Control, 1990). Elsewhere the pole's energy E, 0 when it stands
// upright, is pumped by the cart's acceleration k E sign(a' cos a) (K. Åström, K. Furuta, Swinging up
// a pendulum by energy control, 2000), which the force F of the first equation gives the cart.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Dense>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/control/controller.h"

namespace cart_pole_lqr {
namespace {

using Mat4 = Eigen::Matrix4d;
using Vec4 = Eigen::Vector4d;

/// The gain of the discrete linear quadratic regulator of x' = A x + b u, sampled with the period h.
Vec4 regulator(const Mat4& a, const Vec4& b, const Vec4& q, double r, double h) {
  // exp([A b; 0 0] h), by its series: A h is small.
  Eigen::Matrix<double, 5, 5> both = Eigen::Matrix<double, 5, 5>::Zero();
  both.block<4, 4>(0, 0) = a * h;
  both.block<4, 1>(0, 4) = b * h;
  Eigen::Matrix<double, 5, 5> term = Eigen::Matrix<double, 5, 5>::Identity(), sum = term;
  for (int i = 1; i < 12; ++i) {
    term = (term * both).eval() / i;
    sum += term;
  }
  const Mat4 f = sum.block<4, 4>(0, 0);
  const Vec4 g = sum.block<4, 1>(0, 4);
  // The cost of the best future, from the last sample backwards until it no longer changes.
  const Mat4 weights = q.asDiagonal();
  Mat4 p = weights;
  Vec4 k = Vec4::Zero();
  for (int i = 0; i < 100000; ++i) {
    const Vec4 now = f.transpose() * p * g / (r + g.dot(p * g));
    // In this form p stays symmetric: errors of rounding do not grow.
    const Mat4 closed = f - g * now.transpose();
    const Mat4 future = closed.transpose() * p * closed + r * now * now.transpose();
    p = weights + future;
    const bool settled = (now - k).norm() <= 1e-12 * now.norm();
    k = now;
    if (settled) break;
  }
  return k;
}

class CartPoleLqr final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    drive_ = robot.motor(robot.parameter<std::string>("motor"), cogrsim::MotorMode::torque);
    pole_ = robot.sensor<cogrsim::Encoder>(robot.parameter<std::string>("encoder"));
    cart_mass_ = robot.parameter<double>("cart_mass");
    mass_ = robot.parameter<double>("pole_mass");
    half_ = robot.parameter<double>("pole_length") / 2.0;
    gravity_ = robot.parameter<double>("gravity");
    goal_ = robot.parameter<double>("goal");
    pump_ = robot.parameter<double>("pump");
    pull_ = robot.parameter<double>("acceleration");
    const auto q = robot.parameter<std::vector<double>>("weights");
    if (q.size() == 4)
      weights_ = Vec4(q[0], q[1], q[2], q[3]);
    else
      robot.fail("parameter 'weights': expected 4 numbers, of position, angle and their rates");
    cost_ = robot.parameter<double>("force_weight");
  }

  void update(const cogrsim::Tick& tick) override {
    if (!pole_.valid()) return;
    const double inertia = 4.0 / 3.0 * mass_ * half_ * half_, moment = mass_ * half_;
    if (gain_.isZero()) gain_ = gain(inertia, moment, tick.period);
    const double x = robot_->joint_position(drive_), v = robot_->joint_velocity(drive_);
    const double angle = cogrsim::wrapped_angle(pole_.position()), rate = pole_.velocity();
    const double energy = 0.5 * inertia * rate * rate + moment * gravity_ * (std::cos(angle) - 1.0);
    // What the regulator can catch: near upright, with about the energy of standing there.
    const double reach = balancing_ ? 0.6 : 0.35;  // [rad]
    balancing_ =
        std::abs(angle) < reach && (balancing_ || std::abs(energy) < 0.3 * moment * gravity_);
    double force = 0.0;
    if (balancing_) {
      force = -gain_.dot(Vec4(std::clamp(x - goal_, -0.5, 0.5), angle, v, rate));
    } else {
      const double c = std::cos(angle), s = std::sin(angle);
      const double direction = rate * c < 0.0 ? -1.0 : 1.0;
      double pull = std::clamp(pump_ * energy / (moment * gravity_) * direction, -1.0, 1.0) * pull_;
      pull -= 6.0 * (x - goal_) + 2.0 * v;  // back to the middle of the rail
      const double turn = moment * (gravity_ * s - c * pull) / inertia;
      force = (cart_mass_ + mass_) * pull + moment * (c * turn - s * rate * rate);
    }
    drive_.set(force);
    robot_->publish("balancing", balancing_ ? 1.0 : 0.0);
    robot_->publish("energy", energy);
  }

 private:
  Vec4 gain(double inertia, double moment, double period) const {
    // Mass matrix times accelerations = (F, m g l a).
    Eigen::Matrix2d mass;
    mass << cart_mass_ + mass_, moment, moment, inertia;
    const Eigen::Matrix2d inverse = mass.inverse();
    Mat4 a = Mat4::Zero();
    a.block<2, 2>(0, 2).setIdentity();
    a.block<2, 1>(2, 1) = inverse.col(1) * moment * gravity_;
    Vec4 b = Vec4::Zero();
    b.tail<2>() = inverse.col(0);
    return regulator(a, b, weights_, cost_, period);
  }

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::MotorHandle drive_;
  cogrsim::Encoder pole_;
  double cart_mass_ = 0.0, mass_ = 0.0, half_ = 0.0, gravity_ = 0.0, goal_ = 0.0;
  double pump_ = 0.0, pull_ = 0.0, cost_ = 0.0;
  Vec4 weights_ = Vec4::Zero(), gain_ = Vec4::Zero();
  bool balancing_ = false;
};

}  // namespace
}  // namespace cart_pole_lqr

COGRSIM_CONTROLLER(
    cart_pole_lqr::CartPoleLqr, "cart_pole_lqr", version("1.0.0"), author("CogRSim"),
    summary("swings up the pole of a cart and balances it"),
    parameter("motor", "drive", "name of the cart's motor, mode torque"),
    parameter("encoder", "angle", "name of the pole's encoder, 0 upright"),
    parameter("cart_mass", 1.0, "kg", "mass of the cart").range(1e-3, 1e4).must_be_set(),
    parameter("pole_mass", 0.1, "kg", "mass of the pole").range(1e-4, 1e4).must_be_set(),
    parameter("pole_length", 1.0, "m", "length of the pole").range(1e-3, 100.0).must_be_set(),
    parameter("gravity", 9.81, "m/s^2", "acceleration of free fall").range(0.0, 100.0),
    parameter("goal", 0.0, "m", "position at which the cart balances").range(-1e3, 1e3),
    parameter("weights", std::vector<double>{5.0, 10.0, 1.0, 1.0}, "",
              "cost of position, angle and their rates, SI")
        .range(0.0, 1e9),
    parameter("force_weight", 0.05, "cost of the force, SI").range(1e-9, 1e9),
    parameter("pump", 3.0, "acceleration per energy, relative").range(0.0, 100.0),
    parameter("acceleration", 5.0, "m/s^2", "largest of the swing-up").range(0.1, 1000.0),
    output("balancing", "1", "1 while the regulator balances, 0 while the pole swings up"),
    output("energy", "N*m", "energy of the pole, 0 standing upright"))
