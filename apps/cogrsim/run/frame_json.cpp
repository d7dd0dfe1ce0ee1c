#include "run/frame_json.h"

#include "cogrsim/rendering/renderer.h"

namespace cogrsim::cli {
namespace {

Json slice(const std::vector<double>& values, int offset, int count) {
  Json out = Json::array();
  for (int i = 0; i < count; ++i) out.push_back(values[offset + i]);
  return out;
}

}  // namespace

Json bodies_json(const Frame& frame) {
  Json out = Json::object();
  const SceneModel& model = *frame.model;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    const Pose& pose = frame.state.poses[i];
    const Twist& twist = frame.state.twists[i];
    out[model.bodies[i].name] = {{"position", to_json(pose.p)},
                                 {"orientation", to_json(pose.q)},
                                 {"linear_velocity", to_json(twist.linear)},
                                 {"angular_velocity", to_json(twist.angular)}};
  }
  return out;
}

Json joints_json(const Frame& frame) {
  Json out = Json::object();
  const WorldState& state = frame.state;
  for (const Joint& joint : frame.model->joints) {
    if (joint.removed) continue;
    const int speeds = speed_count(joint.type);
    out[joint.name] = {{"position", slice(state.joint_positions, joint.position_offset,
                                          position_count(joint.type))},
                       {"velocity", slice(state.joint_velocities, joint.speed_offset, speeds)},
                       {"effort", slice(state.joint_efforts, joint.speed_offset, speeds)}};
  }
  return out;
}

Json contacts_json(const Frame& frame) {
  Json out = Json::array();
  for (const Contact& contact : frame.contacts) {
    const auto name = [&](int body) { return frame.model->bodies[body].name; };
    out.push_back({{"a", name(contact.body_a)},
                   {"b", name(contact.body_b)},
                   {"point", to_json(contact.point)},
                   {"normal", to_json(contact.normal)},
                   {"depth", contact.depth},
                   {"force", to_json(contact.force)}});
  }
  return out;
}

Json to_json(const Event& event) {
  return {{"time", event.time},
          {"kind", event.kind},
          {"source", event.source},
          {"subject", event.subject},
          {"message", event.message}};
}

Json readings_json(const Frame& frame, const ChannelsOf& channels) {
  Json out = Json::object();
  for (const Reading& reading : frame.readings) {
    const auto index = static_cast<std::size_t>(reading.sensor);
    if (index >= frame.model->sensors.size() || frame.model->sensors[index].removed) continue;
    Json& entry = out[frame.model->sensors[index].name];
    entry = {{"time", reading.time},
             {"sequence", reading.sequence},
             {"valid", reading.valid},
             {"enabled", reading.enabled},
             {"values", Json::object()}};
    const std::vector<Channel>& names = channels(reading.sensor);
    for (std::size_t i = 0; i < reading.values.size(); ++i) {
      const std::string name = i < names.size() ? names[i].name : std::to_string(i);
      entry["values"][name] = reading.values[i];
    }
    if (!reading.contacts.empty()) {
      Frame touched;
      touched.model = frame.model;
      touched.contacts = reading.contacts;
      entry["contacts"] = contacts_json(touched);
    }
    if (reading.picture) {
      entry["picture"] = {{"width", reading.picture->width}, {"height", reading.picture->height}};
    }
  }
  return out;
}

Json frame_json(const Frame& frame, const ChannelsOf& channels) {
  Json out;
  out["step"] = frame.step;
  out["time"] = frame.time;
  out["bodies"] = bodies_json(frame);
  out["joints"] = joints_json(frame);
  out["contacts"] = contacts_json(frame);
  out["sensors"] = readings_json(frame, channels);
  out["events"] = Json::array();
  for (const Event& event : frame.events) out["events"].push_back(to_json(event));
  return out;
}

}  // namespace cogrsim::cli
