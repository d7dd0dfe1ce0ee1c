#include "cogrsim/recording/frame_tables.h"

#include <algorithm>

namespace cogrsim {
namespace {

using Use = std::function<void(const std::vector<TableValue>&)>;

void body_rows(const Frame& frame, const Use& use) {
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
    const Body& body = frame.model->bodies[i];
    if (body.removed) continue;
    const Pose& X = frame.state.poses[i];
    const Vec3 &v = frame.state.twists[i].linear, &w = frame.state.twists[i].angular;
    use({frame.time, body.name, X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z(),
         v.x(), v.y(), v.z(), w.x(), w.y(), w.z()});
  }
}

void joint_rows(const Frame& frame, const Use& use) {
  const auto value = [](const std::vector<double>& values, int i, int count, int offset) {
    return i < count ? TableValue(values[offset + i]) : TableValue();
  };
  for (const Joint& joint : frame.model->joints) {
    if (joint.removed) continue;
    const int q = position_count(joint.type), u = speed_count(joint.type);
    for (int i = 0; i < std::max(q, u); ++i) {
      use({frame.time, joint.name, static_cast<double>(i),
           value(frame.state.joint_positions, i, q, joint.position_offset),
           value(frame.state.joint_velocities, i, u, joint.speed_offset),
           value(frame.state.joint_efforts, i, u, joint.speed_offset)});
    }
  }
}

void contact_rows(const Frame& frame, const Use& use) {
  const auto name = [&](int body) -> std::string_view { return frame.model->bodies[body].name; };
  for (const Contact& c : frame.contacts) {
    use({frame.time, name(c.body_a), name(c.body_b), c.point.x(), c.point.y(), c.point.z(),
         c.normal.x(), c.normal.y(), c.normal.z(), c.depth, c.force.x(), c.force.y(), c.force.z()});
  }
}

}  // namespace

const std::vector<TableColumn>& columns_of(FrameTable table) {
  static const std::vector<TableColumn> kFrames = {{"time", "s"}, {"step"}, {"dt", "s"}};
  static const std::vector<TableColumn> kBodies = {{"time", "s"},   {"body", "", true},
                                                   {"x", "m"},      {"y", "m"},
                                                   {"z", "m"},      {"qw"},
                                                   {"qx"},          {"qy"},
                                                   {"qz"},          {"vx", "m/s"},
                                                   {"vy", "m/s"},   {"vz", "m/s"},
                                                   {"wx", "rad/s"}, {"wy", "rad/s"},
                                                   {"wz", "rad/s"}};
  static const std::vector<TableColumn> kJoints = {
      {"time", "s"}, {"joint", "", true}, {"coordinate"}, {"position"}, {"speed"}, {"effort"}};
  static const std::vector<TableColumn> kContacts = {
      {"time", "s"}, {"a", "", true}, {"b", "", true}, {"x", "m"},  {"y", "m"},  {"z", "m"}, {"nx"},
      {"ny"},        {"nz"},          {"depth", "m"},  {"fx", "N"}, {"fy", "N"}, {"fz", "N"}};
  static const std::vector<TableColumn> kEvents = {{"time", "s"},
                                                   {"kind", "", true},
                                                   {"source", "", true},
                                                   {"subject", "", true},
                                                   {"message", "", true}};
  switch (table) {
    case FrameTable::frames:
      return kFrames;
    case FrameTable::bodies:
      return kBodies;
    case FrameTable::joints:
      return kJoints;
    case FrameTable::contacts:
      return kContacts;
    case FrameTable::events:
      break;
  }
  return kEvents;
}

void for_rows(FrameTable table, const Frame& frame, const Use& use) {
  switch (table) {
    case FrameTable::frames:
      return use({frame.time, static_cast<double>(frame.step), frame.dt});
    case FrameTable::bodies:
      return body_rows(frame, use);
    case FrameTable::joints:
      return joint_rows(frame, use);
    case FrameTable::contacts:
      return contact_rows(frame, use);
    case FrameTable::events:
      for (const Event& e : frame.events) use({e.time, e.kind, e.source, e.subject, e.message});
  }
}

}  // namespace cogrsim
