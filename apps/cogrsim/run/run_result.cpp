#include "run/run_result.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "cogrsim/core/roll_pitch_yaw.h"
#include "common/provenance_text.h"
#include "common/scene_loading.h"
#include "run/frame_json.h"

namespace cogrsim::cli {
namespace {

constexpr int kRows = 20;
// A penetration of less is rounding [m].
constexpr double kRounding = 1e-12;
constexpr double kDegree = 3.14159265358979323846 / 180.0;

std::string fixed(double value, int digits) {
  // The numbers of a diverged run would fill several lines.
  if (std::abs(value) >= 1e9) return fmt::format("{:.4g}", value);
  const std::string text = fmt::format("{:.{}f}", value, digits);
  // "-0.000" says no more than "0.000".
  if (text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos) return text.substr(1);
  return text;
}

std::string more_text(std::size_t left) {
  return left == 0 ? "" : fmt::format("  and {} more, see --json\n", left);
}

std::string body_table(const Frame& frame, const Style& style) {
  using Align = TextTable::Align;
  TextTable table({Align::left, Align::right, Align::right, Align::right, Align::right,
                   Align::right, Align::right, Align::right});
  table.row({"body", "x [m]", "y [m]", "z [m]", "roll [°]", "pitch [°]", "yaw [°]", "speed [m/s]"});
  std::size_t rows = 0, left = 0;
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
    const Body& body = frame.model->bodies[i];
    if (body.removed || body.kind == BodyKind::static_body) continue;
    if (rows == kRows) {
      ++left;
      continue;
    }
    ++rows;
    const Pose& pose = frame.state.poses[i];
    const Vec3 rpy = roll_pitch_yaw(pose.q) / kDegree;
    table.row({shortened(body.name, 32), fixed(pose.p.x(), 4), fixed(pose.p.y(), 4),
               fixed(pose.p.z(), 4), fixed(rpy.x(), 2), fixed(rpy.y(), 2), fixed(rpy.z(), 2),
               fixed(frame.state.twists[i].linear.norm(), 4)});
  }
  if (rows == 0) return {};
  return "\n" + table.text("  ", style.bold, style.off) + more_text(left);
}

std::string joint_table(const Frame& frame, const Style& style) {
  using Align = TextTable::Align;
  TextTable table({Align::left, Align::left, Align::right, Align::right, Align::right});
  table.row({"joint", "type", "position", "speed", "effort"});
  std::size_t rows = 0, left = 0;
  for (const Joint& joint : frame.model->joints) {
    // A joint of one degree of freedom needs one number; the others are for programs.
    if (joint.removed || speed_count(joint.type) != 1) continue;
    if (rows == kRows) {
      ++left;
      continue;
    }
    ++rows;
    const double q = frame.state.joint_positions[joint.position_offset];
    const double u = frame.state.joint_velocities[joint.speed_offset];
    const double effort = frame.state.joint_efforts[joint.speed_offset];
    const bool linear = joint.type == JointType::slider;
    table.row({shortened(joint.name, 32), to_string(joint.type),
               linear ? fixed(q, 4) + " m" : fixed(q / kDegree, 2) + " °",
               fixed(u, 4) + (linear ? " m/s" : " rad/s"),
               fixed(effort, 4) + (linear ? " N" : " N m")});
  }
  if (rows == 0) return {};
  return "\n" + table.text("  ", style.bold, style.off) + more_text(left);
}

}  // namespace

Json to_json(const RunResult& result) {
  Json out;
  const bool ran = result.frame != nullptr;
  out["scene"] = result.scene.empty() ? Json(nullptr) : Json(result.scene);
  out["file"] = result.file;
  out["backend"] = result.backend.empty() ? Json(nullptr) : Json(result.backend);
  out["engine_version"] =
      result.engine_version.empty() ? Json(nullptr) : Json(result.engine_version);
  out["provenance"] = result.provenance ? to_json(*result.provenance) : Json(nullptr);
  out["seed"] = result.provenance ? Json(result.seed) : Json(nullptr);
  out["set"] = result.set;
  out["step"] = ran ? Json(result.step) : Json(nullptr);
  out["steps"] = result.steps;
  out["time"] = result.time;
  out["status"] = result.status;
  out["wall_time"] = result.wall_time;
  out["realtime_factor"] =
      result.wall_time > 0.0 ? Json(result.time / result.wall_time) : Json(nullptr);
  out["state_hash"] =
      ran ? Json(fmt::format("{:016x}", state_hash(result.frame->state))) : Json(nullptr);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Energy energy =
      ran ? energy_of(*result.frame->model, result.frame->state) : Energy{nan, nan};
  out["energy"] = {{"kinetic", energy.kinetic}, {"potential", energy.potential}};
  out["bodies"] = ran ? bodies_json(*result.frame) : Json::object();
  out["joints"] = ran ? joints_json(*result.frame) : Json::object();
  out["contacts"] = ran ? contacts_json(*result.frame) : Json::array();
  out["drawn"] = Json::object();
  if (ran)
    for (const DrawnValue& drawn : result.frame->model->drawn)
      out["drawn"][drawn.quantity] = drawn.value;
  out["measures"] = Json::object();
  for (const RunMeasures::Value& measure : result.measures)
    out["measures"][measure.name] = measure.value;
  out["events"] = Json::array();
  for (const Event& event : result.events) out["events"].push_back(to_json(event));
  out["events_left_out"] = result.events_left_out;
  out["diagnostics"] = diagnostics_json(result.diagnostics, result.messages);
  return out;
}

std::string summary_text(const RunResult& result, const Style& style) {
  const Frame& frame = *result.frame;
  const bool failed = result.status == "diverged" || result.status == "fault";
  std::string out = fmt::format(
      "{}{}{} on {} {}: {}{}{}, {} in {} steps of {}\n", style.bold, one_line(result.scene),
      style.off, result.backend, result.engine_version, failed ? style.red : style.green,
      result.status, style.off, time_text(result.time), result.steps, step_text(result.step));
  if (result.provenance) out += provenance_lines(*result.provenance);
  out += fmt::format("  wall time {}, {} real time\n", elapsed_text(result.wall_time),
                     factor_text(result.time / result.wall_time));
  const Energy energy = energy_of(*frame.model, frame.state);
  if (!frame.model->drawn.empty())
    out += fmt::format("  drawn     {} values from seed {}, see --json\n",
                       frame.model->drawn.size(), result.seed);
  if (!result.measures.empty()) {
    out += "  measures  ";
    for (const RunMeasures::Value& measure : result.measures) {
      if (&measure != &result.measures.front()) out += ", ";
      out += one_line(measure.name) + " " +
             quantity_text(measure.value, measure.unit == "1" ? "" : measure.unit);
    }
    out += "\n";
  }
  out += fmt::format("  energy    kinetic {}, potential {}\n", quantity_text(energy.kinetic, "J"),
                     quantity_text(energy.potential, "J"));
  double deepest = 0.0;
  for (const Contact& contact : frame.contacts) deepest = std::max(deepest, contact.depth);
  out += fmt::format("  contacts  {}", frame.contacts.size());
  if (deepest >= kRounding) out += fmt::format(", deepest penetration {}", length_text(deepest));
  out += "\n";
  return out + body_table(frame, style) + joint_table(frame, style);
}

}  // namespace cogrsim::cli
