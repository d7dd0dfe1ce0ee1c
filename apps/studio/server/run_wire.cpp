#include "run_wire.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "net/little_endian.h"
#include "scene_json.h"

namespace cogrsim::studio {

namespace {

/// Appends numbers as they lie in memory, lowest byte first.
class Bytewriter {
 public:
  explicit Bytewriter(std::string& out) : out_(out) {}

  template <class Number>
  void put(Number value) {
    net::put_number(out_, value);
  }

  void put_poses(const Frame& frame) {
    for (const Pose& X : frame.state.poses) {
      for (const double v : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) {
        put(static_cast<float>(v));
      }
    }
  }

 private:
  std::string& out_;
};

std::string tail_text(const Frame& frame, Tail wanted) {
  if (!wanted.contacts && !wanted.readings && !wanted.joints) return {};
  Json out = Json::object();
  if (wanted.readings) {
    Json& readings = out["readings"] = Json::array();
    for (const Reading& reading : frame.readings) {
      if (reading.sensor < 0 || !reading.valid) continue;
      readings.push_back({{"sensor", reading.sensor}, {"values", reading.values}});
      const std::string& type = frame.model->sensors[std::size_t(reading.sensor)].type;
      if (reading.pose && (type == "infrared" || type == "lidar"))
        readings.back()["pose"] = to_json(*reading.pose);
    }
  }
  if (wanted.joints) {
    const WorldState& state = frame.state;
    const auto part = [](const std::vector<double>& all, int offset, int count) {
      Json some = Json::array();
      for (auto i = static_cast<std::size_t>(offset); count > 0 && i < all.size(); ++i, --count)
        some.push_back(all[i]);
      return some;
    };
    Json& joints = out["joints"] = Json::array();
    for (const Joint& joint : frame.model->joints)
      joints.push_back(
          {{"position",
            part(state.joint_positions, joint.position_offset, position_count(joint.type))},
           {"speed", part(state.joint_velocities, joint.speed_offset, speed_count(joint.type))}});
    out["efforts"] = state.motor_efforts;
  }
  if (wanted.contacts) {
    Json& contacts = out["contacts"] = Json::array();
    for (const Contact& c : frame.contacts) {
      contacts.push_back({{"a", c.body_a},
                          {"b", c.body_b},
                          {"point", to_json(c.point)},
                          {"normal", to_json(c.normal)},
                          {"depth", c.depth},
                          {"force", c.force.norm()}});
    }
  }
  return to_text(out);
}

}  // namespace

std::string encode_frame(const Instant& instant, bool live, Tail tail) {
  const Frame& frame = *instant.frame;
  const std::string text = tail_text(frame, tail);
  const std::size_t bodies = frame.state.poses.size();
  const std::size_t ghosts = instant.ghost ? instant.ghost->state.poses.size() : 0;
  std::string out;
  out.reserve(40 + (bodies + ghosts) * 28 + text.size());
  Bytewriter to(out);
  to.put(std::uint8_t{1});
  to.put(static_cast<std::uint8_t>((live ? 1 : 0) | (instant.ghost ? 2 : 0)));
  to.put(std::uint16_t{0});
  to.put(instant.scene);
  to.put(frame.time);
  to.put(static_cast<double>(frame.step));
  to.put(static_cast<std::uint32_t>(bodies));
  to.put(static_cast<std::uint32_t>(ghosts));
  to.put(static_cast<std::uint32_t>(text.size()));
  to.put(std::uint32_t{0});
  to.put_poses(frame);
  if (instant.ghost) to.put_poses(*instant.ghost);
  out += text;
  return out;
}

std::string encode_picture(int kind, const std::string& name, int width, int height, double time,
                           const std::string& file) {
  std::string out;
  out.reserve(20 + name.size() + file.size());
  Bytewriter to(out);
  to.put(std::uint8_t{2});
  to.put(static_cast<std::uint8_t>(kind));
  to.put(static_cast<std::uint16_t>(name.size()));
  to.put(static_cast<std::uint32_t>(width));
  to.put(static_cast<std::uint32_t>(height));
  to.put(time);
  return out + name + file;
}

Json to_json(const IndexedEvent& event) {
  const Event& e = event.event;
  return {{"index", event.index}, {"time", e.time},       {"kind", e.kind},
          {"source", e.source},   {"subject", e.subject}, {"message", e.message}};
}

Json to_json(const RunMessage& message) {
  return {{"time", message.time},
          {"severity", severity_name(message.severity)},
          {"source", message.source},
          {"message", message.message}};
}

Json to_json(const std::vector<ControllerInputs>& controllers) {
  Json out = Json::array();
  for (const ControllerInputs& each : controllers) {
    Json inputs = Json::array();
    for (const ControllerInput& input : each.inputs)
      inputs.push_back({{"name", input.name},
                        {"unit", input.unit},
                        {"lower", input.lower},
                        {"upper", input.upper},
                        {"value", input.value}});
    out.push_back({{"controller", each.controller}, {"inputs", std::move(inputs)}});
  }
  return out;
}

Json to_json(const Provenance& provenance) { return Json::parse(to_json_text(provenance)); }

Json to_json(const std::vector<LeftOut>& left_out) {
  Json out = Json::array();
  for (const LeftOut& it : left_out)
    out.push_back({{"feature", it.feature}, {"of", it.of}, {"count", it.count}});
  return out;
}

Json status_json(const Situation& s, const Frames::Extent& extent, std::size_t viewers) {
  Json out = {{"topic", "status"},
              {"state", s.state},
              {"ending", s.ending},
              {"time", s.time},
              {"step_count", s.step_count},
              {"dt", s.dt},
              {"scene_dt", s.scene_dt},
              {"speed", nullptr},
              {"factor", s.waiting ? 0.0 : s.factor},
              {"backend", s.backend},
              {"engine_version", s.engine_version},
              {"provenance", s.provenance ? to_json(*s.provenance) : Json(nullptr)},
              {"recording", nullptr},
              {"first", extent.first},
              {"last", extent.last},
              {"frames", extent.count},
              {"scene", s.scene},
              {"inputs", s.inputs},
              {"controllers", to_json(s.controllers)},
              {"state_hash", s.state_hash},
              {"compare", nullptr},
              {"waiting", nullptr},
              {"viewers", viewers}};
  if (s.speed) out["speed"] = *s.speed;
  if (const auto& call = s.waiting) {
    out["waiting"] = {{"kind", call->kind},     {"name", call->name},
                      {"of", call->of},         {"plugin", call->plugin},
                      {"doing", call->doing},   {"time", nullptr},
                      {"seconds", call->lasts}, {"isolated", call->out_of_process},
                      {"limit", nullptr}};
    if (std::isfinite(call->time)) out["waiting"]["time"] = call->time;
    if (call->out_of_process && std::isfinite(call->patience))
      out["waiting"]["limit"] = call->patience;
  }
  if (s.recording) out["recording"] = *s.recording;
  if (s.compare) {
    out["compare"] = {{"labels", s.compare->labels},
                      {"first_over", nullptr},
                      {"left_out", to_json(s.compare->left_out)}};
    if (s.compare->first_over) out["compare"]["first_over"] = *s.compare->first_over;
  }
  return out;
}

}  // namespace cogrsim::studio
