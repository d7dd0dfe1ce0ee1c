#include "terms.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/roll_pitch_yaw.h"
#include "cogrsim/model/joint_kinematics.h"
#include "core/index.h"
#include "geometry/surface_distance.h"
#include "node.h"

namespace cogrsim {
namespace {

/// Whether the element still exists in the frame.
template <class Element>
bool present(const std::vector<Element>& elements, int index) {
  return index >= 0 && at(index) < elements.size() && !elements[at(index)].removed;
}

/// Whether the frame has the pose; the world frame always exists.
bool present(const SignalPose& pose, const Frame& frame) {
  return pose.body == kWorld ||
         (present(frame.model->bodies, pose.body) && at(pose.body) < frame.state.poses.size());
}

Pose pose_of(const SignalPose& pose, const Frame& frame) {
  return pose.body == kWorld ? pose.X_BF : frame.state.poses[at(pose.body)] * pose.X_BF;
}

Twist twist_of(const SignalPose& pose, const Frame& frame) {
  if (pose.body == kWorld) return {};
  const Twist& body = frame.state.twists[at(pose.body)];
  const Vec3 arm = frame.state.poses[at(pose.body)].q * pose.X_BF.p;
  return {body.at(arm), body.angular};
}

struct TimeTerm final : Signal::Node {
  TimeTerm() {
    text = quantity = "time";
    unit = "s";
  }
  double value(const Frame& frame) const override { return frame.time; }
};

struct PoseTerm final : Signal::Node {
  SignalPose pose;
  int which = 0;

  double value(const Frame& frame) const override {
    if (!present(pose, frame)) return kNaN;
    if (which < 3) return pose_of(pose, frame).p[which];
    if (which < 6) return roll_pitch_yaw(pose_of(pose, frame).q)[which - 3];
    const Twist twist = twist_of(pose, frame);
    if (which < 9) return twist.linear[which - 6];
    if (which == 9) return twist.linear.norm();
    if (which < 13) return twist.angular[which - 10];
    return twist.angular.norm();
  }
};

std::string joint_unit(const Joint& joint, int quantity, int entry) {
  if (quantity == 0) {
    if (joint.type == JointType::ball || (joint.type == JointType::free && entry >= 3)) return "1";
    return axis_turns(joint.type, entry) ? "rad" : "m";
  }
  if (quantity == 1) return axis_turns(joint.type, entry) ? "rad/s" : "m/s";
  return axis_turns(joint.type, entry) ? "N*m" : "N";
}

struct JointTerm final : Signal::Node {
  int index = -1, which = 0, entry = 0;

  double value(const Frame& frame) const override {
    if (!present(frame.model->joints, index)) return kNaN;
    const Joint& joint = frame.model->joints[at(index)];
    const std::vector<double>& all = which == 0   ? frame.state.joint_positions
                                     : which == 1 ? frame.state.joint_velocities
                                                  : frame.state.joint_efforts;
    const std::size_t i = at((which == 0 ? joint.position_offset : joint.speed_offset) + entry);
    return i < all.size() ? all[i] : kNaN;
  }
};

struct MotorTerm final : Signal::Node {
  int index = -1;
  bool target = false;

  double value(const Frame& frame) const override {
    const std::vector<double>& all = target ? frame.motor_targets : frame.state.motor_efforts;
    return present(frame.model->motors, index) && at(index) < all.size() ? all[at(index)] : kNaN;
  }
};

struct SensorTerm final : Signal::Node {
  int index = -1, channel = -1;

  double value(const Frame& frame) const override {
    if (channel < 0 || !present(frame.model->sensors, index) ||
        at(index) >= frame.readings.size()) {
      return kNaN;
    }
    const Reading& reading = frame.readings[at(index)];
    return reading.valid && at(channel) < reading.values.size() ? reading.values[at(channel)]
                                                                : kNaN;
  }
  std::uint64_t revision(const Frame& frame) const override {
    return at(index) < frame.readings.size() ? frame.readings[at(index)].sequence : 0;
  }
};

struct EnergyTerm final : Signal::Node {
  int which = 0;

  double value(const Frame& frame) const override {
    const Energy energy = energy_of(*frame.model, frame.state);
    return which == 0   ? energy.kinetic
           : which == 1 ? energy.potential
                        : energy.kinetic + energy.potential;
  }
};

struct OriginDistanceTerm final : Signal::Node {
  SignalPose a, b;

  double value(const Frame& frame) const override {
    if (!present(a, frame) || !present(b, frame)) return kNaN;
    return (pose_of(a, frame).p - pose_of(b, frame).p).norm();
  }
};

struct SurfaceDistanceTerm final : Signal::Node {
  geometry::SurfaceSet a, b;

  double value(const Frame& frame) const override {
    std::vector<bool> gone(frame.state.poses.size());
    for (std::size_t i = 0; i < gone.size(); ++i)
      gone[i] = !present(frame.model->bodies, static_cast<int>(i));
    return geometry::surface_distance(a, b, frame.state.poses, gone);
  }
};

struct MassTerm final : Signal::Node {
  std::vector<int> bodies;

  double value(const Frame& frame) const override {
    double sum = 0.0;
    bool any = false;
    for (const int body : bodies) {
      if (!present(frame.model->bodies, body)) continue;
      sum += frame.model->bodies[at(body)].mass;
      any = true;
    }
    return any ? sum : kNaN;
  }
};

struct InsideTerm final : Signal::Node {
  SignalPose pose;
  int index = -1;

  double value(const Frame& frame) const override {
    if (!present(pose, frame) || !present(frame.model->regions, index)) return kNaN;
    const RegionModel& region = frame.model->regions[at(index)];
    const SignalPose middle{region.body, region.X_BR};
    if (!present(middle, frame)) return kNaN;
    const Vec3 p = pose_of(middle, frame).inverse() * pose_of(pose, frame).p;
    if (region.type == RegionModel::Type::sphere) return p.norm() <= region.radius;
    return ((2.0 * p.cwiseAbs() - region.size).array() <= 0.0).all();
  }
};

struct EventTerm final : Signal::Node {
  std::string kind, source, subject;

  double value(const Frame& frame) const override {
    return std::any_of(frame.events.begin(), frame.events.end(), [&](const Event& event) {
      return event.kind == kind && (source.empty() || event.source == source) &&
             (subject.empty() || event.subject == subject);
    });
  }
};

struct OpenTerm final : Signal::Node {
  int index = -1;

  double value(const Frame& frame) const override {
    if (!present(frame.model->doors, index)) return kNaN;
    const DoorModel& door = frame.model->doors[at(index)];
    if (!present(frame.model->motors, door.motor)) return kNaN;
    const Motor& motor = frame.model->motors[at(door.motor)];
    if (!present(frame.model->joints, motor.joint)) return kNaN;
    const std::size_t q = at(frame.model->joints[at(motor.joint)].position_offset + motor.axis);
    if (q >= frame.state.joint_positions.size()) return kNaN;
    return std::clamp((frame.state.joint_positions[q] - door.closed) / (door.open - door.closed),
                      0.0, 1.0);
  }
};

struct ControllerTerm final : Signal::Node {
  bool supervisor = false;
  int index = -1;
  std::string output;

  double value(const Frame& frame) const override {
    const auto& controllers = supervisor ? frame.model->supervisors : frame.model->controllers;
    const auto& values = supervisor ? frame.supervisor_outputs : frame.controller_outputs;
    if (!present(controllers, index) || at(index) >= values.size()) return kNaN;
    // The outputs are known in the model of a run, but perhaps not in that of the scene.
    const auto& outputs = controllers[at(index)].outputs;
    for (std::size_t i = 0; i < outputs.size() && i < values[at(index)].size(); ++i)
      if (outputs[i].name == output) return values[at(index)][i];
    return kNaN;
  }
};

bool among(const std::vector<int>& bodies, int body) {
  return std::binary_search(bodies.begin(), bodies.end(), body);
}

struct ContactTerm final : Signal::Node {
  std::vector<int> a, b;
  bool force = false;

  double value(const Frame& frame) const override {
    const auto gone = [&](const std::vector<int>& bodies) {
      return std::none_of(bodies.begin(), bodies.end(),
                          [&](int body) { return present(frame.model->bodies, body); });
    };
    if (gone(a) || (!b.empty() && gone(b))) return kNaN;
    int points = 0;
    Vec3 sum = Vec3::Zero();
    for (const Contact& contact : frame.contacts) {
      // Contacts among the bodies themselves do not count as contacts with the rest of the world.
      const bool first = among(a, contact.body_a) &&
                         (b.empty() ? !among(a, contact.body_b) : among(b, contact.body_b));
      const bool second = among(a, contact.body_b) &&
                          (b.empty() ? !among(a, contact.body_a) : among(b, contact.body_a));
      if (!first && !second) continue;
      ++points;
      sum += first ? Vec3(-contact.force) : contact.force;
    }
    return force ? sum.norm() : points;
  }
};

}  // namespace

const char* pose_unit(int quantity) {
  return quantity < 3 ? "m" : quantity < 6 ? "rad" : quantity < 10 ? "m/s" : "rad/s";
}

SignalNode time_term() { return std::make_shared<TimeTerm>(); }

SignalNode pose_term(std::string text, const SignalPose& pose, int quantity) {
  auto term = std::make_shared<PoseTerm>();
  term->text = std::move(text);
  term->unit = pose_unit(quantity);
  term->quantity = kPoseQuantities[at(quantity)];
  term->pose = pose;
  term->which = quantity;
  return term;
}

SignalNode joint_term(std::string text, const Joint& joint, int index, int quantity, int entry) {
  auto term = std::make_shared<JointTerm>();
  term->text = std::move(text);
  term->unit = joint_unit(joint, quantity, entry);
  term->quantity = kJointQuantities[at(quantity)];
  term->index = index;
  term->which = quantity;
  term->entry = entry;
  return term;
}

SignalNode motor_term(std::string text, const SceneModel& model, int index, bool target) {
  const Motor& motor = model.motors[at(index)];
  const bool turns = axis_turns(model.joints[at(motor.joint)].type, motor.axis);
  const auto unit = [&] {
    if (target && motor.mode == MotorMode::dc) return "V";
    if (target && motor.mode == MotorMode::velocity) return turns ? "rad/s" : "m/s";
    if (target && motor.mode != MotorMode::torque) return turns ? "rad" : "m";
    return turns ? "N*m" : "N";
  };
  auto term = std::make_shared<MotorTerm>();
  term->text = std::move(text);
  term->unit = unit();
  term->quantity = target ? "target" : "effort";
  term->index = index;
  term->target = target;
  return term;
}

SignalNode sensor_term(std::string text, int index, int channel, std::string name,
                       std::string unit) {
  auto term = std::make_shared<SensorTerm>();
  term->text = std::move(text);
  term->unit = std::move(unit);
  term->quantity = std::move(name);
  term->index = index;
  term->channel = channel;
  return term;
}

SignalNode energy_term(int quantity) {
  auto term = std::make_shared<EnergyTerm>();
  term->text = std::string("energy.") + kEnergyQuantities[at(quantity)];
  term->unit = "J";
  term->quantity = "energy";
  term->which = quantity;
  return term;
}

SignalNode origin_distance_term(std::string text, const SignalPose& a, const SignalPose& b) {
  auto term = std::make_shared<OriginDistanceTerm>();
  term->text = std::move(text);
  term->unit = "m";
  term->quantity = "distance";
  term->a = a;
  term->b = b;
  return term;
}

SignalNode surface_distance_term(std::string text, geometry::SurfaceSet a, geometry::SurfaceSet b) {
  auto term = std::make_shared<SurfaceDistanceTerm>();
  term->text = std::move(text);
  term->unit = "m";
  term->quantity = "distance";
  term->a = std::move(a);
  term->b = std::move(b);
  return term;
}

SignalNode mass_term(std::string text, std::vector<int> bodies) {
  auto term = std::make_shared<MassTerm>();
  term->text = std::move(text);
  term->unit = "kg";
  term->quantity = "mass";
  term->bodies = std::move(bodies);
  return term;
}

SignalNode inside_term(std::string text, const SignalPose& pose, int region) {
  auto term = std::make_shared<InsideTerm>();
  term->text = std::move(text);
  term->unit = "1";
  term->quantity = "inside";
  term->pose = pose;
  term->index = region;
  return term;
}

SignalNode event_term(std::string text, std::string kind, std::string source, std::string subject) {
  auto term = std::make_shared<EventTerm>();
  term->text = std::move(text);
  term->unit = "1";
  term->quantity = "event";
  term->kind = std::move(kind);
  term->source = std::move(source);
  term->subject = std::move(subject);
  return term;
}

SignalNode open_term(std::string text, int door) {
  auto term = std::make_shared<OpenTerm>();
  term->text = std::move(text);
  term->unit = "1";
  term->quantity = "open";
  term->index = door;
  return term;
}

SignalNode controller_term(std::string text, bool supervisor, int controller, std::string output,
                           std::string unit) {
  auto term = std::make_shared<ControllerTerm>();
  term->text = std::move(text);
  term->unit = std::move(unit);
  term->quantity = output;
  term->supervisor = supervisor;
  term->index = controller;
  term->output = std::move(output);
  return term;
}

SignalNode contact_term(std::string text, std::vector<int> a, std::vector<int> b, bool force) {
  auto term = std::make_shared<ContactTerm>();
  term->text = std::move(text);
  term->unit = force ? "N" : "1";
  term->quantity = force ? "contact force" : "contacts";
  term->needs.contacts = true;
  term->a = std::move(a);
  term->b = std::move(b);
  term->force = force;
  return term;
}

int joint_entries(const Joint& joint, int quantity) {
  return quantity == 0 ? position_count(joint.type) : speed_count(joint.type);
}

}  // namespace cogrsim
