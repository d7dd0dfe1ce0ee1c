#include "model/model_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace cogrsim {

namespace {

using Json = nlohmann::ordered_json;

// ---- fields, listed once for both directions
//
// Structured bindings, because they do not compile any more when a member is added.

template <class Io>
void fields(Io& io, Material& x) {
  auto& [name, base, density, friction, rolling_friction, spinning_friction, restitution,
         friction_combine, restitution_combine, stiffness, color, texture, texture_size,
         engine_options, origin] = x;
  io("name", name)("base", base)("density", density)("friction", friction);
  io("rolling_friction", rolling_friction)("spinning_friction", spinning_friction);
  io("restitution", restitution)("friction_combine", friction_combine);
  io("restitution_combine", restitution_combine);
  io("stiffness", stiffness)("color", color)("texture", texture);
  io("texture_size", texture_size)("engine_options", engine_options)("origin", origin);
}

template <class Io>
void fields(Io& io, MaterialPair& x) {
  auto& [a, b, friction, rolling_friction, spinning_friction, restitution, origin] = x;
  io("a", a)("b", b)("friction", friction)("rolling_friction", rolling_friction);
  io("spinning_friction", spinning_friction)("restitution", restitution)("origin", origin);
}

template <class Io>
void fields(Io& io, Shape& x) {
  auto& [name, type, X_BS, size, radius, length, mesh, heightmap, material, surface_velocity,
         collides, visible, origin] = x;
  io("name", name)("type", type)("X_BS", X_BS)("size", size)("radius", radius)("length", length);
  io("mesh", mesh)("heightmap", heightmap)("material", material);
  io("surface_velocity", surface_velocity)("collides", collides)("visible", visible);
  io("origin", origin);
}

template <class Io>
void fields(Io& io, Body& x) {
  auto& [name, kind, X_WB, V_WB, mass, com, inertia, gravity_scale, shapes, assembly, removed,
         origin] = x;
  io("name", name)("kind", kind)("X_WB", X_WB)("V_WB", V_WB)("mass", mass)("com", com);
  io("inertia", inertia)("gravity_scale", gravity_scale)("shapes", shapes);
  io("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, NamedFrame& x) {
  auto& [name, body, X_BF, assembly, removed, origin] = x;
  io("name", name)("body", body)("X_BF", X_BF)("assembly", assembly)("removed", removed);
  io("origin", origin);
}

template <class Io>
void fields(Io& io, JointAxis& x) {
  auto& [lower, upper, damping, friction, stiffness, rest, max_effort, max_speed, rotor_inertia] =
      x;
  io("lower", lower)("upper", upper)("damping", damping)("friction", friction);
  io("stiffness", stiffness)("rest", rest)("max_effort", max_effort)("max_speed", max_speed);
  io("rotor_inertia", rotor_inertia);
}

template <class Io>
void fields(Io& io, Joint& x) {
  auto& [name, type, parent, child, X_PF, X_CM, axes, pitch, position, velocity, closes_loop,
         bodies_collide, engine_options, position_offset, speed_offset, assembly, removed, origin] =
      x;
  io("name", name)("type", type)("parent", parent)("child", child)("X_PF", X_PF)("X_CM", X_CM);
  io("axes", axes)("pitch", pitch)("position", position)("velocity", velocity);
  io("closes_loop", closes_loop)("bodies_collide", bodies_collide);
  io("engine_options", engine_options);
  io("position_offset", position_offset)("speed_offset", speed_offset)("assembly", assembly);
  io("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, CouplingTerm& x) {
  auto& [joint, ratio] = x;
  io("joint", joint)("ratio", ratio);
}

template <class Io>
void fields(Io& io, Coupling& x) {
  auto& [name, joint, terms, offset, max_effort, engine_options, assembly, removed, origin] = x;
  io("name", name)("joint", joint)("terms", terms)("offset", offset)("max_effort", max_effort);
  io("engine_options", engine_options)("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, Motor& x) {
  auto& [name, joint, axis, mode, max_effort, max_speed, response, stall_effort, no_load_speed,
         delay, kp, ki, kd, kt, ke, resistance, gear, max_voltage, max_current, target, min_target,
         max_target, target_signal, assembly, removed, origin] = x;
  io("name", name)("joint", joint)("axis", axis)("mode", mode)("max_effort", max_effort);
  io("max_speed", max_speed)("response", response)("kp", kp)("ki", ki)("kd", kd)("kt", kt);
  io("ke", ke)("resistance", resistance)("gear", gear)("max_voltage", max_voltage);
  io("max_current", max_current)("target", target)("min_target", min_target);
  io("max_target", max_target)("target_signal", target_signal);
  io("stall_effort", stall_effort)("no_load_speed", no_load_speed)("delay", delay);
  io("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, ForceModel& x) {
  auto& [kind, name, body, X_BE, other, other_point, in_body, force, torque, factor, from, until,
         linear, quadratic, angular, wind, stiffness, damping, length, cable, density, level,
         assembly, removed, origin] = x;
  io("kind", kind)("name", name)("body", body)("X_BE", X_BE)("other", other);
  io("other_point", other_point)("in_body", in_body)("force", force)("torque", torque);
  io("factor", factor)("from", from)("until", until)("linear", linear)("quadratic", quadratic);
  io("angular", angular)("wind", wind)("stiffness", stiffness)("damping", damping);
  io("length", length)("cable", cable)("density", density)("level", level);
  io("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, NoiseTerm& x) {
  auto& [kind, a, b, group] = x;
  io("kind", kind)("a", a)("b", b)("group", group);
}

template <class Io>
void fields(Io& io, SensorModel& x) {
  auto& [name, type, body, X_BS, joint, rate, latency, enabled, show, noise, parameters, assembly,
         removed, origin] = x;
  io("name", name)("type", type)("body", body)("X_BS", X_BS)("joint", joint)("rate", rate);
  io("latency", latency)("enabled", enabled)("show", show)("noise", noise)("parameters",
                                                                           parameters);
  io("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, OutputModel& x) {
  auto& [name, unit] = x;
  io("name", name)("unit", unit);
}

template <class Io>
void fields(Io& io, ControllerModel& x) {
  auto& [name, plugin, rate, parameters, on_fault, isolation, deadline, memory, outputs, assembly,
         removed, origin] = x;
  io("name", name)("plugin", plugin)("rate", rate)("parameters", parameters);
  io("on_fault", on_fault)("isolation", isolation)("deadline", deadline)("memory", memory);
  io("outputs", outputs)("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, AssemblyInfo& x) {
  auto& [name, parent, X_WA, rigid, engine_options, removed, origin] = x;
  io("name", name)("parent", parent)("X_WA", X_WA)("rigid", rigid);
  io("engine_options", engine_options)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, LightModel& x) {
  auto& [type, name, X_WL, color, intensity, cone, shadows, origin] = x;
  io("type", type)("name", name)("X_WL", X_WL)("color", color)("intensity", intensity);
  io("cone", cone)("shadows", shadows)("origin", origin);
}

template <class Io>
void fields(Io& io, ViewModel& x) {
  auto& [name, X_WV, fov, origin] = x;
  io("name", name)("X_WV", X_WV)("fov", fov)("origin", origin);
}

template <class Io>
void fields(Io& io, PhysicsSettings& x) {
  auto& [backend, step, gravity, seed, duration, bounce_threshold, engine_options, origin,
         backend_origin] = x;
  io("backend", backend)("step", step)("gravity", gravity)("seed", seed)("duration", duration);
  io("bounce_threshold", bounce_threshold)("engine_options", engine_options)("origin", origin);
  io("backend_origin", backend_origin);
}

template <class Io>
void fields(Io& io, RecordModel& x) {
  auto& [file, every, contacts, images, jpeg, origin] = x;
  io("file", file)("every", every)("contacts", contacts)("images", images)("jpeg", jpeg);
  io("origin", origin);
}

template <class Io>
void fields(Io& io, PlotSeries& x) {
  auto& [px, py, pz, label, origin] = x;
  io("x", px)("y", py)("z", pz)("label", label)("origin", origin);
}

template <class Io>
void fields(Io& io, PlotModel& x) {
  auto& [name, kind, title, every, series, origin] = x;
  io("name", name)("kind", kind)("title", title)("every", every)("series", series);
  io("origin", origin);
}

template <class Io>
void fields(Io& io, RegionModel& x) {
  auto& [name, type, body, X_BR, size, radius, who, assembly, removed, origin] = x;
  io("name", name)("type", type)("body", body)("X_BR", X_BR)("size", size)("radius", radius);
  io("who", who)("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, DoorModel& x) {
  auto& [name, motor, closed, open, starts_open, assembly, removed, origin] = x;
  io("name", name)("motor", motor)("closed", closed)("open", open)("starts_open", starts_open);
  io("assembly", assembly)("removed", removed)("origin", origin);
}

template <class Io>
void fields(Io& io, MazeModel::NamedCell& x) {
  auto& [name, row, column] = x;
  io("name", name)("row", row)("column", column);
}

template <class Io>
void fields(Io& io, MazeModel& x) {
  auto& [name, X_WM, rows, columns, cell, thickness, height, vertical, horizontal, named_cells,
         origin] = x;
  io("name", name)("X_WM", X_WM)("rows", rows)("columns", columns)("cell", cell);
  io("thickness", thickness)("height", height)("vertical", vertical)("horizontal", horizontal);
  io("places", named_cells)("origin", origin);
}

template <class Io>
void fields(Io& io, MeasureModel& x) {
  auto& [name, signal, take, origin] = x;
  io("name", name)("signal", signal)("take", take)("origin", origin);
}

template <class Io>
void fields(Io& io, RandomizeModel& x) {
  auto& [how, shape, what, quantities, numbers, together, origin] = x;
  io("how", how)("shape", shape)("what", what)("quantities", quantities)("numbers", numbers);
  io("together", together)("origin", origin);
}

template <class Io>
void fields(Io& io, DrawnValue& x) {
  auto& [quantity, value] = x;
  io("quantity", quantity)("value", value);
}

template <class Io>
void fields(Io& io, SceneModel& x) {
  auto& [name, files, set_parameters, physics, materials, material_pairs, meshes, heightmaps,
         assemblies, bodies, frames, joints, couplings, motors, forces, sensors, controllers,
         supervisors, lights, views, record, plots, regions, doors, mazes, templates, rules,
         measures, tests, randomize, drawn, no_collide, joint_positions, joint_speeds] = x;
  static_cast<void>(meshes);  // stored as packed numbers, see Model in cogrsim.proto
  static_cast<void>(heightmaps);
  // Elements that are only used during a run are in the attached scene file.
  static_cast<void>(templates);
  static_cast<void>(rules);
  static_cast<void>(tests);
  io("name", name)("files", files)("set_parameters", set_parameters)("physics", physics);
  io("materials", materials);
  io("material_pairs", material_pairs)("assemblies", assemblies)("bodies", bodies);
  io("frames", frames)("joints", joints)("couplings", couplings)("motors", motors);
  io("forces", forces)("sensors", sensors);
  io("controllers", controllers)("supervisors", supervisors)("lights", lights)("views", views);
  io("record", record)("plots", plots)("no_collide", no_collide);
  io("regions", regions)("doors", doors)("mazes", mazes)("measures", measures);
  io("randomize", randomize)("drawn", drawn);
  io("joint_positions", joint_positions)("joint_speeds", joint_speeds);
}

/// Highest valid value of an enumeration in a file.
template <class Enum>
constexpr int last_of() {
  if constexpr (std::is_same_v<Enum, CombineRule>) return static_cast<int>(CombineRule::max);
  if constexpr (std::is_same_v<Enum, BodyKind>) return static_cast<int>(BodyKind::static_body);
  if constexpr (std::is_same_v<Enum, ShapeType>) return static_cast<int>(ShapeType::heightmap);
  if constexpr (std::is_same_v<Enum, JointType>) return static_cast<int>(JointType::gimbal);
  if constexpr (std::is_same_v<Enum, MotorMode>) return static_cast<int>(MotorMode::dc);
  if constexpr (std::is_same_v<Enum, ForceModel::Kind>) {
    return static_cast<int>(ForceModel::Kind::wind);
  }
  if constexpr (std::is_same_v<Enum, RandomizeModel::How>) {
    return static_cast<int>(RandomizeModel::How::add);
  }
  if constexpr (std::is_same_v<Enum, RandomizeModel::Shape>) {
    return static_cast<int>(RandomizeModel::Shape::choice);
  }
  if constexpr (std::is_same_v<Enum, NoiseTerm::Kind>) {
    return static_cast<int>(NoiseTerm::Kind::bias_walk);
  }
  if constexpr (std::is_same_v<Enum, FaultPolicy>) return static_cast<int>(FaultPolicy::end_run);
  if constexpr (std::is_same_v<Enum, Isolation>) return static_cast<int>(Isolation::process);
  if constexpr (std::is_same_v<Enum, LightModel::Type>) {
    return static_cast<int>(LightModel::Type::spot);
  }
  if constexpr (std::is_same_v<Enum, RegionModel::Type>) {
    return static_cast<int>(RegionModel::Type::sphere);
  }
  if constexpr (std::is_same_v<Enum, MeasureModel::Take>) {
    return static_cast<int>(MeasureModel::Take::first_time);
  }
  return -1;
}

// ---- writing

struct Out {
  Json object = Json::object();
  template <class T>
  Out& operator()(const char* key, const T& value) {
    object[key] = json(value);
    return *this;
  }

  static Json json(double value) {
    if (std::isfinite(value)) return value;
    return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
  }
  static Json json(bool value) { return value; }
  static Json json(int value) { return value; }
  static Json json(std::int64_t value) { return value; }
  static Json json(std::uint64_t value) { return value; }
  static Json json(const std::string& value) { return value; }
  static Json json(const SourceSpan& s) {
    return Json::array({s.file, s.line, s.column, s.length});
  }
  static Json json(const Vec3& v) { return numbers(v.data(), 3); }
  static Json json(const Eigen::Vector2d& v) { return numbers(v.data(), 2); }
  static Json json(const Mat3& m) { return numbers(m.data(), 9); }
  static Json json(const Color& c) {
    const double values[] = {c.r, c.g, c.b, c.a};
    return numbers(values, 4);
  }
  static Json json(const Pose& X) {
    const double values[] = {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()};
    return numbers(values, 7);
  }
  static Json json(const Twist& V) {
    const double values[] = {V.linear.x(),  V.linear.y(),  V.linear.z(),
                             V.angular.x(), V.angular.y(), V.angular.z()};
    return numbers(values, 6);
  }
  static Json json(const ParameterValue& value) {
    return Json::array({value.index(), std::visit([](const auto& v) { return json(v); }, value)});
  }
  template <class T>
  static Json json(const std::optional<T>& value) {
    return value ? json(*value) : Json(nullptr);
  }
  template <class T>
  static Json json(const std::vector<T>& values) {
    Json out = Json::array();
    for (const T& value : values) out.push_back(json(value));
    return out;
  }
  static Json json(const BodyPair& pair) { return Json::array({pair.first, pair.second}); }
  template <class T>
  static Json json(const std::map<std::string, T>& values) {
    Json out = Json::object();
    for (const auto& [key, value] : values) out[key] = json(value);
    return out;
  }
  template <class T>
  static Json json(const T& value) {
    if constexpr (std::is_enum_v<T>) {
      return static_cast<int>(value);
    } else {
      Out out;
      // The list of fields is non-const, as needed for reading; here the fields are not changed.
      fields(out, const_cast<T&>(value));
      return std::move(out.object);
    }
  }

 private:
  static Json numbers(const double* values, std::size_t count) {
    Json out = Json::array();
    for (std::size_t i = 0; i < count; ++i) out.push_back(json(values[i]));
    return out;
  }
};

// ---- reading

struct In {
  const Json& object;
  bool good = true;

  template <class T>
  In& operator()(const char* key, T& value) {
    const auto found = object.find(key);
    if (found != object.end() && !read(*found, value)) good = false;
    return *this;
  }

  static bool read(const Json& in, double& value) {
    if (in.is_number()) {
      value = in.get<double>();
      return true;
    }
    if (in == "inf")
      value = std::numeric_limits<double>::infinity();
    else if (in == "-inf")
      value = -std::numeric_limits<double>::infinity();
    else if (in == "nan")
      value = std::numeric_limits<double>::quiet_NaN();
    else
      return false;
    return true;
  }
  static bool read(const Json& in, bool& value) {
    if (!in.is_boolean()) return false;
    value = in.get<bool>();
    return true;
  }
  static bool read(const Json& in, std::int64_t& value) {
    if (!in.is_number_integer()) return false;
    value = in.get<std::int64_t>();
    return true;
  }
  static bool read(const Json& in, std::uint64_t& value) {
    if (!in.is_number_integer()) return false;
    value = in.get<std::uint64_t>();
    return true;
  }
  static bool read(const Json& in, int& value) {
    std::int64_t wide = 0;
    if (!read(in, wide) || wide < std::numeric_limits<int>::min() ||
        wide > std::numeric_limits<int>::max()) {
      return false;
    }
    value = static_cast<int>(wide);
    return true;
  }
  static bool read(const Json& in, std::string& value) {
    if (!in.is_string()) return false;
    value = in.get<std::string>();
    return true;
  }
  static bool read(const Json& in, SourceSpan& s) {
    return in.is_array() && in.size() == 4 && read(in[0], s.file) && read(in[1], s.line) &&
           read(in[2], s.column) && read(in[3], s.length);
  }
  static bool read(const Json& in, Vec3& v) { return numbers(in, v.data(), 3); }
  static bool read(const Json& in, Eigen::Vector2d& v) { return numbers(in, v.data(), 2); }
  static bool read(const Json& in, Mat3& m) { return numbers(in, m.data(), 9); }
  static bool read(const Json& in, Color& c) {
    double v[4];
    if (!numbers(in, v, 4)) return false;
    c = {v[0], v[1], v[2], v[3]};
    return true;
  }
  static bool read(const Json& in, Pose& X) {
    double v[7];
    if (!numbers(in, v, 7)) return false;
    X = Pose({v[0], v[1], v[2]}, Quat(v[3], v[4], v[5], v[6]));
    return true;
  }
  static bool read(const Json& in, Twist& V) {
    double v[6];
    if (!numbers(in, v, 6)) return false;
    V = {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
    return true;
  }
  static bool read(const Json& in, ParameterValue& value) {
    if (!in.is_array() || in.size() != 2 || !in[0].is_number_unsigned()) return false;
    switch (in[0].get<std::uint64_t>()) {
      case 0:
        return read_as<bool>(in[1], value);
      case 1:
        return read_as<std::int64_t>(in[1], value);
      case 2:
        return read_as<double>(in[1], value);
      case 3:
        return read_as<std::string>(in[1], value);
      case 4:
        return read_as<std::vector<double>>(in[1], value);
    }
    return false;
  }
  template <class T>
  static bool read(const Json& in, std::optional<T>& value) {
    value.reset();
    return in.is_null() || read(in, value.emplace());
  }
  template <class T>
  static bool read(const Json& in, std::vector<T>& values) {
    if (!in.is_array()) return false;
    values.clear();
    for (const Json& entry : in) {
      if (!read(entry, values.emplace_back())) return false;
    }
    return true;
  }
  static bool read(const Json& in, BodyPair& pair) {
    return in.is_array() && in.size() == 2 && read(in[0], pair.first) && read(in[1], pair.second);
  }
  template <class T>
  static bool read(const Json& in, std::map<std::string, T>& values) {
    if (!in.is_object()) return false;
    values.clear();
    for (const auto& [key, value] : in.items()) {
      if (!read(value, values[key])) return false;
    }
    return true;
  }
  template <class T>
  static bool read(const Json& in, T& value) {
    if constexpr (std::is_enum_v<T>) {
      int number = 0;
      if (!read(in, number) || number < 0 || number > last_of<T>()) return false;
      value = static_cast<T>(number);
      return true;
    } else {
      if (!in.is_object()) return false;
      In inner{in};
      fields(inner, value);
      return inner.good;
    }
  }

 private:
  template <class T>
  static bool read_as(const Json& in, ParameterValue& value) {
    T typed{};
    if (!read(in, typed)) return false;
    value = std::move(typed);
    return true;
  }
  static bool numbers(const Json& in, double* values, std::size_t count) {
    if (!in.is_array() || in.size() != count) return false;
    for (std::size_t i = 0; i < count; ++i) {
      if (!read(in[i], values[i])) return false;
    }
    return true;
  }
};

}  // namespace

std::string model_to_json(const SceneModel& model) {
  return Out::json(model).dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<SceneModel> model_from_json(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  SceneModel model;
  if (json.is_discarded() || !In::read(json, model)) return fail("the recorded scene is damaged");
  return model;
}

}  // namespace cogrsim
