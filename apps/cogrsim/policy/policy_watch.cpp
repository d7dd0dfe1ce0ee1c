#include "policy/policy_watch.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/algorithms/steering.h"

namespace cogrsim::cli {
namespace {

// A robot that has gone less than this [m] has no cost of transport.
constexpr double kShortWay = 0.2;

}  // namespace

PolicyWatch::PolicyWatch(const PolicyScene& scene, const Simulation& simulation,
                         std::vector<double> command)
    : scene_(scene),
      command_(std::move(command)),
      has_forces_(simulation.backend().capabilities().get("report.contact_force").support !=
                  Support::unsupported),
      has_efforts_(simulation.backend().capabilities().get("report.joint_effort").support !=
                   Support::unsupported) {
  const SceneModel& model = *scene.model;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    robot_.push_back(is_of_robot(model, scene.robot, static_cast<int>(b)));
    if (robot_.back()) mass_ += model.bodies[b].mass;
  }
}

bool PolicyWatch::see(const Frame& frame) {
  const auto base = static_cast<std::size_t>(scene_.robot.base);
  const Pose& body = frame.state.poses[base];
  const double heading = planar(body).heading, dt = frame.time - time_;
  if (!seen_) {
    result_.start = body.p;
  } else {
    const double turn = wrapped_angle(heading - heading_);
    result_.heading += turn;
    result_.path += Vec3(body.p.x() - last_.x(), body.p.y() - last_.y(), 0.0).norm();
    if (frame.time > kSettled) {
      const Vec3 v = Eigen::AngleAxisd(-heading, Vec3::UnitZ()) * frame.state.twists[base].linear;
      sum_ += dt * Vec3(v.x(), v.y(), 0.0) + Vec3(0.0, 0.0, turn);
      settled_ += dt;
    }
    efforts(frame, dt);
    contacts(frame, dt);
  }
  seen_ = true;
  heading_ = heading;
  last_ = result_.end = body.p;
  time_ = result_.time = frame.time;
  const PolicyCard& card = *scene_.card;
  const Vec3 up = body.q * (scene_.robot.X_BF.q * Vec3::UnitZ());
  const bool low = body.p.z() < card.fallen_height;
  if (result_.fell || !(low || std::acos(std::clamp(up.z(), -1.0, 1.0)) > card.fallen_tilt))
    return false;
  result_.fell = frame.time;
  return true;
}

void PolicyWatch::efforts(const Frame& frame, double dt) {
  for (std::size_t i = 0; i < scene_.robot.motors.size(); ++i) {
    const auto index = static_cast<std::size_t>(scene_.robot.motors[i]);
    const Motor& motor = scene_.model->motors[index];
    const Joint& joint = scene_.model->joints[static_cast<std::size_t>(motor.joint)];
    double limit =
        std::min(motor.max_effort, joint.axes[static_cast<std::size_t>(motor.axis)].max_effort);
    const double effort = frame.state.motor_efforts[index];
    const double speed =
        frame.state.joint_velocities[static_cast<std::size_t>(joint.speed_offset + motor.axis)];
    if (std::isfinite(motor.no_load_speed)) {
      // The motor's own curve, see Motor::stall_effort.
      const double along = std::copysign(speed, effort * speed);
      limit = std::clamp(motor.stall_effort * (1.0 - along / motor.no_load_speed), 0.0, limit);
    }
    limit = std::fabs(scene_.card->actions.limited(i, std::copysign(limit, effort), speed));
    samples_ += 1.0;
    if (std::fabs(effort) >= 0.999 * limit) at_limit_ += 1.0;
    work_ += dt * std::max(0.0, effort * speed);
  }
}

void PolicyWatch::contacts(const Frame& frame, double dt) {
  if (!frame.contents.contacts) has_forces_ = false;
  Vec3 total = Vec3::Zero();
  const auto velocity = [&](int body, const Vec3& point) {
    if (body < 0) return Vec3(Vec3::Zero());
    const Twist& twist = frame.state.twists[static_cast<std::size_t>(body)];
    return Vec3(twist.linear +
                twist.angular.cross(point - frame.state.poses[static_cast<std::size_t>(body)].p));
  };
  const auto is_robot = [&](int body) {
    return body >= 0 && static_cast<std::size_t>(body) < robot_.size() &&
           robot_[static_cast<std::size_t>(body)];
  };
  for (const Contact& contact : frame.contacts) {
    const bool a = is_robot(contact.body_a), b = is_robot(contact.body_b);
    if (a == b) continue;
    total += b ? contact.force : Vec3(-contact.force);
    const Vec3 v =
        velocity(contact.body_b, contact.point) - velocity(contact.body_a, contact.point);
    const double load = std::fabs(contact.force.dot(contact.normal));
    slid_ += dt * load * (v - v.dot(contact.normal) * contact.normal).norm();
    touched_ += dt * load;
  }
  impulse_ += dt * total.norm();
  peak_ = std::max(peak_, total.norm());
}

PolicyResult PolicyWatch::finish() {
  if (settled_ > 0.0) result_.velocity = sum_ / settled_;
  if (has_efforts_ && samples_ > 0.0) result_.limited = at_limit_ / samples_;
  if (settled_ > 0.0 && command_.size() == 3) {
    const Vec3 wanted(command_[0], command_[1], 0.0);
    const Vec3 had(result_.velocity.x(), result_.velocity.y(), 0.0);
    result_.velocity_error = (had - wanted).norm();
    result_.turning_error = std::fabs(result_.velocity.z() - command_[2]);
  }
  if (has_forces_ && time_ > 0.0) {
    result_.mean_force = impulse_ / time_;
    result_.peak_force = peak_;
    if (touched_ > 0.0) result_.slip = slid_ / touched_;
  }
  const double weight = mass_ * scene_.model->physics.gravity.norm();
  if (has_efforts_ && result_.path > kShortWay && weight > 0.0)
    result_.cost = work_ / (weight * result_.path);
  return result_;
}

}  // namespace cogrsim::cli
