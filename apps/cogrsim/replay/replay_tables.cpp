#include "replay/replay_tables.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "common/output_file.h"

namespace cogrsim::cli {
namespace {

// RFC 4180.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

std::string numbers(std::initializer_list<double> values) {
  std::string out;
  for (const double value : values) out += fmt::format(",{:.17g}", value);
  return out;
}

std::string number_at(const std::vector<double>& values, int index, int count, int offset) {
  return index < count ? fmt::format("{:.17g}", values[static_cast<std::size_t>(offset + index)])
                       : std::string();
}

}  // namespace

Result<std::unique_ptr<ReplayTables>> ReplayTables::create(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    return fail(fmt::format("cannot write tables into '{}': {}", folder,
                            error ? error.message() : "it is no folder"));
  }
  return std::unique_ptr<ReplayTables>(new ReplayTables(folder));
}

ReplayTables::File* ReplayTables::table(const std::string& name, const std::string& head) {
  std::unique_ptr<File>& slot = files_[name];
  if (!slot) {
    slot = std::make_unique<File>();
    std::string file = name;
    std::replace(file.begin(), file.end(), '/', '_');
    const std::string path = folder_ + "/" + file + ".csv";
    auto created = OutputFile::create(path, OutputKind::csv, output_rules());
    if (created) {
      slot->file.emplace(std::move(*created));
      note(slot->file->append(head + "\n"));
    } else {
      note(tl::unexpected(created.error()));
    }
  }
  return slot.get();
}

void ReplayTables::add(const Frame& frame, const ChannelsOf& channels) {
  const SceneModel& model = *frame.model;
  const WorldState& state = frame.state;
  const std::string when = fmt::format("{:.17g},", frame.time);
  const auto row = [this](File* to, const std::string& text) {
    if (to->file && problem_) note(to->file->append(text + "\n"));
  };
  File* const bodies = table("bodies",
                             "time [s],body,x [m],y [m],z [m],qw,qx,qy,qz,vx [m/s],vy [m/s],"
                             "vz [m/s],wx [rad/s],wy [rad/s],wz [rad/s]");
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    const Pose& X = state.poses[i];
    const Vec3 &v = state.twists[i].linear, &w = state.twists[i].angular;
    row(bodies, when + cell(model.bodies[i].name) +
                    numbers({X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z(), v.x(),
                             v.y(), v.z(), w.x(), w.y(), w.z()}));
  }
  File* const joints = table("joints", "time [s],joint,coordinate,position,speed,effort");
  for (const Joint& joint : model.joints) {
    if (joint.removed) continue;
    const int q = position_count(joint.type), u = speed_count(joint.type);
    for (int i = 0; i < std::max(q, u); ++i) {
      row(joints, when + fmt::format("{},{},{},{},{}", cell(joint.name), i,
                                     number_at(state.joint_positions, i, q, joint.position_offset),
                                     number_at(state.joint_velocities, i, u, joint.speed_offset),
                                     number_at(state.joint_efforts, i, u, joint.speed_offset)));
    }
  }
  File* const contacts = table("contacts",
                               "time [s],a,b,x [m],y [m],z [m],nx,ny,nz,depth [m],fx [N],fy [N],"
                               "fz [N]");
  for (const Contact& c : frame.contacts) {
    row(contacts, when + cell(model.bodies[static_cast<std::size_t>(c.body_a)].name) + "," +
                      cell(model.bodies[static_cast<std::size_t>(c.body_b)].name) +
                      numbers({c.point.x(), c.point.y(), c.point.z(), c.normal.x(), c.normal.y(),
                               c.normal.z(), c.depth, c.force.x(), c.force.y(), c.force.z()}));
  }
  for (const Reading& reading : frame.readings) {
    const SensorModel& sensor = model.sensors[static_cast<std::size_t>(reading.sensor)];
    if (reading.sequence == 0 || sensor.removed) continue;
    std::string head = "time [s],sequence,valid";
    for (const Channel& channel : channels(reading.sensor)) {
      head += "," + cell(channel.unit == "1" || channel.unit.empty()
                             ? channel.name
                             : fmt::format("{} [{}]", channel.name, channel.unit));
    }
    File* const to = table("sensors_" + sensor.name, head);
    if (to->sequence == reading.sequence) continue;
    to->sequence = reading.sequence;
    std::string text = fmt::format("{:.17g},{},{}", reading.time, reading.sequence,
                                   reading.valid ? "true" : "false");
    for (const double value : reading.values) text += fmt::format(",{:.17g}", value);
    row(to, text);
  }
}

void ReplayTables::note(const Result<>& done) {
  if (problem_ && !done) problem_ = done;
}

Result<> ReplayTables::finish() {
  for (auto& [name, slot] : files_) {
    if (problem_ && slot->file) note(slot->file->commit());
  }
  return problem_;
}

}  // namespace cogrsim::cli
