#include "tables.h"

#include <cmath>
#include <map>

namespace cogrsim::python {

namespace {

class Frames final : public Tabulator {
 public:
  Frames() { column("time"), column("step"), column("dt"); }
  void add(const Frame& frame) override {
    column("time").push_back(frame.time);
    column("step").push_back(static_cast<double>(frame.step));
    column("dt").push_back(frame.dt);
  }
};

class Bodies final : public Tabulator {
 public:
  void add(const Frame& frame) override {
    for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
      const Body& body = frame.model->bodies[i];
      if (body.removed) continue;
      const Pose& X = frame.state.poses[i];
      const Twist& V = frame.state.twists[i];
      column("time").push_back(frame.time);
      put_name("body", body.name);
      const double row[] = {X.p.x(),       X.p.y(),       X.p.z(),      X.q.w(),      X.q.x(),
                            X.q.y(),       X.q.z(),       V.linear.x(), V.linear.y(), V.linear.z(),
                            V.angular.x(), V.angular.y(), V.angular.z()};
      const char* const names[] = {"x",  "y",  "z",  "qw", "qx", "qy", "qz",
                                   "vx", "vy", "vz", "wx", "wy", "wz"};
      for (std::size_t k = 0; k < std::size(row); ++k) column(names[k]).push_back(row[k]);
    }
  }
};

class Joints final : public Tabulator {
 public:
  void add(const Frame& frame) override {
    for (const Joint& joint : frame.model->joints) {
      if (joint.removed) continue;
      const int q = position_count(joint.type), u = speed_count(joint.type);
      const auto value = [](const std::vector<double>& values, int i, int count, int offset) {
        return i < count ? values[static_cast<std::size_t>(offset + i)] : std::nan("");
      };
      for (int i = 0; i < std::max(q, u); ++i) {
        column("time").push_back(frame.time);
        put_name("joint", joint.name);
        column("coordinate").push_back(i);
        column("position")
            .push_back(value(frame.state.joint_positions, i, q, joint.position_offset));
        column("speed").push_back(value(frame.state.joint_velocities, i, u, joint.speed_offset));
        column("effort").push_back(value(frame.state.joint_efforts, i, u, joint.speed_offset));
      }
    }
  }
};

class Contacts final : public Tabulator {
 public:
  void add(const Frame& frame) override {
    const auto name = [&](int body) {
      return frame.model->bodies[static_cast<std::size_t>(body)].name;
    };
    for (const Contact& c : frame.contacts) {
      column("time").push_back(frame.time);
      put_name("a", name(c.body_a));
      put_name("b", name(c.body_b));
      const double row[] = {c.point.x(),  c.point.y(), c.point.z(), c.normal.x(), c.normal.y(),
                            c.normal.z(), c.depth,     c.force.x(), c.force.y(),  c.force.z()};
      const char* const names[] = {"x", "y", "z", "nx", "ny", "nz", "depth", "fx", "fy", "fz"};
      for (std::size_t k = 0; k < std::size(row); ++k) column(names[k]).push_back(row[k]);
    }
  }
};

class Events final : public Tabulator {
 public:
  void add(const Frame& frame) override {
    for (const Event& event : frame.events) {
      column("time").push_back(event.time);
      put_name("kind", event.kind);
      put_name("source", event.source);
      put_name("subject", event.subject);
      put_name("message", event.message);
    }
  }
};

/// The readings of one sensor, each once.
class Readings final : public Tabulator {
 public:
  Readings(int sensor, const std::vector<Channel>& channels) : sensor_(sensor) {
    for (const Channel& channel : channels) names_.push_back(channel.name);
  }
  void add(const Frame& frame) override {
    for (const Reading& reading : frame.readings) {
      if (reading.sensor != sensor_ || reading.sequence == 0 || reading.sequence == sequence_)
        continue;
      sequence_ = reading.sequence;
      column("time").push_back(reading.time);
      column("sequence").push_back(static_cast<double>(reading.sequence));
      column("valid").push_back(reading.valid ? 1.0 : 0.0);
      for (std::size_t i = 0; i < names_.size(); ++i) {
        column(names_[i]).push_back(i < reading.values.size() ? reading.values[i] : std::nan(""));
      }
    }
  }

 private:
  int sensor_;
  std::vector<std::string> names_;
  std::uint64_t sequence_ = 0;
};

}  // namespace

std::vector<double>& Tabulator::column(const std::string& name) {
  for (auto& [known, values] : columns_) {
    if (known == name) return values;
  }
  return columns_.emplace_back(name, std::vector<double>()).second;
}

void Tabulator::put_name(const std::string& name, const std::string& value) {
  Names& names = names_[name];
  const auto [at, is_new] = names.index.emplace(value, static_cast<double>(names.all.size()));
  if (is_new) names.all.push_back(value);
  column(name).push_back(at->second);
}

py::tuple Tabulator::finish() {
  py::dict columns, names;
  for (auto& [name, values] : columns_) {
    const auto count = static_cast<py::ssize_t>(values.size());
    columns[py::str(name)] = owned(std::move(values), {count});
  }
  for (const auto& [name, all] : names_) names[py::str(name)] = all.all;
  return py::make_tuple(columns, names);
}

std::unique_ptr<Tabulator> make_tabulator(const std::string& table, int sensor,
                                          const std::vector<Channel>& channels) {
  if (table == "frames") return std::make_unique<Frames>();
  if (table == "bodies") return std::make_unique<Bodies>();
  if (table == "joints") return std::make_unique<Joints>();
  if (table == "contacts") return std::make_unique<Contacts>();
  if (table == "events") return std::make_unique<Events>();
  if (sensor >= 0) return std::make_unique<Readings>(sensor, channels);
  return nullptr;
}

}  // namespace cogrsim::python
