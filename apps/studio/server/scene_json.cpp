#include "scene_json.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/rendering/looks.h"
#include "cogrsim/rendering/standard_view.h"
#include "cogrsim/sensing/sensor_models.h"

namespace cogrsim::studio {

namespace {

/// A plane has no end: it is drawn so many times as large as the rest of the scene, and at least so
/// large [m]. The page draws one without a texture as far as one sees.
constexpr double kPlaneShare = 8.0, kPlaneLeast = 40.0;

/// Short in text, exact enough to be drawn [m].
double shortened(double v) { return std::round(v * 1e6) / 1e6; }

Json color_json(const Color& c) { return {c.r, c.g, c.b, c.a}; }

const char* kind_of(BodyKind kind) {
  switch (kind) {
    case BodyKind::dynamic:
      return "dynamic";
    case BodyKind::kinematic:
      return "kinematic";
    case BodyKind::static_body:
      break;
  }
  return "fixed";
}

const char* kind_of(ForceModel::Kind kind) {
  switch (kind) {
    case ForceModel::Kind::force:
      return "force";
    case ForceModel::Kind::drag:
      return "drag";
    case ForceModel::Kind::spring:
      return "spring";
    case ForceModel::Kind::buoyancy:
      return "buoyancy";
    case ForceModel::Kind::wind:
      break;
  }
  return "wind";
}

class SceneWriter {
 public:
  SceneWriter(const SceneRecord& record, const std::map<std::string, std::size_t>& assets)
      : record_(record), model_(*record.model), assets_(assets), start_(start_of(record)) {}

  Json write() {
    plane_ = plane_extent();
    const Origins& from = *record_.origins;
    Json out = {{"topic", "scene"},
                {"scene", record_.number},
                {"version", from.version},
                {"name", model_.name},
                {"gravity", to_json(model_.physics.gravity)},
                {"step", model_.physics.step},
                {"duration", nullptr}};
    if (model_.physics.duration) out["duration"] = *model_.physics.duration;
    out["bodies"] = list(model_.bodies, from.bodies, [this](const Body& b) { return body(b); });
    out["assemblies"] = list(model_.assemblies, from.assemblies, [](const AssemblyInfo& a) -> Json {
      return {{"parent", a.parent}, {"rigid", a.rigid}, {"pose", to_json(a.X_WA)}};
    });
    out["joints"] = list(model_.joints, from.joints, [](const Joint& j) -> Json {
      Json limits = Json::array();
      for (const JointAxis& axis : j.axes) {
        Json ends = Json::array();
        for (const double end : {axis.lower, axis.upper})
          ends.push_back(std::isfinite(end) ? Json(end) : Json());
        limits.push_back(std::move(ends));
      }
      return {{"type", to_string(j.type)},
              {"parent", j.parent},
              {"child", j.child},
              {"parent_pose", to_json(j.X_PF)},
              {"child_pose", to_json(j.X_CM)},
              {"limits", std::move(limits)},
              {"start", j.position},
              {"closes_loop", j.closes_loop}};
    });
    out["motors"] =
        list(model_.motors, from.motors, [this](const Motor& m) { return motor(m); });
    out["sensors"] =
        list(model_.sensors, from.sensors, [this](const SensorModel& s) { return sensor(s); });
    out["regions"] = list(model_.regions, from.regions, [](const RegionModel& r) -> Json {
      return {{"type", r.type == RegionModel::Type::box ? "box" : "sphere"},
              {"body", r.body},
              {"pose", to_json(r.X_BR)},
              {"size", to_json(r.size)},
              {"radius", r.radius}};
    });
    out["controllers"] = list(model_.controllers, from.controllers, controller);
    out["supervisors"] = list(model_.supervisors, from.supervisors, controller);
    out["lights"] = list(model_.lights, from.lights, light);
    out["views"] = list(model_.views, from.views, [](const ViewModel& v) -> Json {
      return {{"pose", to_json(v.X_WV)}, {"fov", v.fov}};
    });
    out["plots"] = list(model_.plots, from.plots, [](const PlotModel& p) -> Json {
      return {{"kind", p.kind}, {"title", p.title}};
    });
    out["forces"] = list(model_.forces, from.forces, [](const ForceModel& f) -> Json {
      Json one = {{"kind", kind_of(f.kind)}, {"body", f.body},
                  {"pose", to_json(f.X_BE)}, {"vector", to_json(f.force)},
                  {"in_body", f.in_body},    {"from", f.from},
                  {"until", nullptr},        {"other", f.other},
                  {"cable", f.cable},        {"other_point", to_json(f.other_point)}};
      if (std::isfinite(f.until)) one["until"] = f.until;
      return one;
    });
    out["meshes"] = Json::array();
    for (const MeshPtr& m : model_.meshes) out["meshes"].push_back(mesh(*m));
    out["heightmaps"] = Json::array();
    for (const HeightGridPtr& grid : model_.heightmaps)
      out["heightmaps"].push_back(heightmap(*grid));
    return out;
  }

 private:
  /// Each with its name, the common fields, and its element in the file.
  template <class Elements, class Write>
  static Json list(const Elements& elements, const std::vector<Origins::Origin>& origins,
                   Write write) {
    Json out = Json::array();
    for (std::size_t i = 0; i < elements.size(); ++i) {
      Json one = write(elements[i]);
      one["name"] = elements[i].name;
      const Origins::Origin origin = i < origins.size() ? origins[i] : Origins::Origin();
      one["element"] = origin.element;
      one["own"] = origin.own;
      put_removed(elements[i], one, 0);
      out.push_back(std::move(one));
    }
    return out;
  }
  // Only with that attribute.
  template <class Element>
  static auto put_removed(const Element& element, Json& out, int)
      -> decltype(static_cast<void>(element.removed)) {
    out["removed"] = element.removed;
  }
  template <class Element>
  static void put_removed(const Element&, Json&, long) {}

  Json body(const Body& b) const {
    Json shapes = Json::array();
    const int index = static_cast<int>(&b - model_.bodies.data());
    for (const Shape& s : b.shapes) shapes.push_back(shape(s, index));
    return {{"kind", kind_of(b.kind)}, {"pose", to_json(b.X_WB)}, {"mass", b.mass},
            {"com", to_json(b.com)},   {"assembly", b.assembly},  {"shapes", std::move(shapes)}};
  }

  /// With the range of its target, as far as the scene says it: its own, that of the joint and the drive.
  Json motor(const Motor& m) const {
    const Joint& joint = model_.joints[static_cast<std::size_t>(m.joint)];
    const bool turns = axis_turns(joint.type, m.axis);
    const auto axis = static_cast<std::size_t>(m.axis);
    const JointAxis limits = axis < joint.axes.size() ? joint.axes[axis] : JointAxis();
    const double effort = std::min(m.max_effort, limits.max_effort);
    double low = m.min_target, high = m.max_target;
    const auto within = [&](double least, double most) {
      low = std::max(low, least);
      high = std::min(high, most);
    };
    const char* unit = turns ? "rad/s" : "m/s";
    double target = m.target.value_or(0.0);
    switch (m.mode) {
      case MotorMode::velocity: {
        const double most = std::min(m.max_speed, limits.max_speed);
        within(-most, most);
        break;
      }
      case MotorMode::torque:
        unit = turns ? "N m" : "N";
        within(-effort, effort);
        break;
      case MotorMode::position:
      case MotorMode::servo:
        unit = turns ? "rad" : "m";
        within(limits.lower, limits.upper);
        if (!m.target && axis < joint.position.size()) target = joint.position[axis];
        break;
      case MotorMode::dc:
        unit = "V";
        within(-m.max_voltage, m.max_voltage);
        break;
    }
    const auto end = [](double v) { return std::isfinite(v) ? Json(v) : Json(); };
    return {{"joint", m.joint},     {"axis", m.axis},   {"mode", to_string(m.mode)},
            {"unit", unit},         {"low", end(low)},  {"high", end(high)},
            {"target", target},     {"turns", turns},   {"max_effort", end(effort)}};
  }

  Json shape(const Shape& s, int body) const {
    Json out = {{"name", s.name},
                {"pose", to_json(s.X_BS)},
                {"visual", s.visible},
                {"collides", s.collides}};
    switch (s.type) {
      case ShapeType::box:
        out["type"] = "box";
        out["size"] = to_json(s.size);
        break;
      case ShapeType::sphere:
        out["type"] = "sphere";
        out["size"] = {s.radius};
        break;
      case ShapeType::cylinder:
        out["type"] = "cylinder";
        out["size"] = {s.radius, s.length};
        break;
      case ShapeType::capsule:
        out["type"] = "capsule";
        out["size"] = {s.radius, s.length};
        break;
      case ShapeType::plane:
        out["type"] = "plane";
        out["size"] = {plane_, plane_};
        break;
      case ShapeType::convex_mesh:
      case ShapeType::mesh:
        out["type"] = "mesh";
        out["size"] = Json::array();
        out["mesh"] = s.mesh;
        break;
      case ShapeType::heightmap:
        out["type"] = "heightmap";
        out["size"] = Json::array();
        out["heightmap"] = s.heightmap;
        break;
    }
    const Material& material = model_.materials[s.material];
    out["color"] = color_json(s.type == ShapeType::plane ? floor_color(model_, body, s)
                                                         : shown_color(model_, body, s));
    const auto texture = assets_.find(material.texture);
    out["texture"] =
        material.texture.empty() || texture == assets_.end() ? "" : std::to_string(texture->second);
    const Eigen::Vector2d tile = material.texture_size.value_or(Eigen::Vector2d::Zero());
    out["tile"] = {tile.x(), tile.y()};
    return out;
  }

  Json sensor(const SensorModel& s) const {
    const RangeLimits limits = range_limits(s);
    Json rays = Json::array();
    if (const auto seen = camera_request(model_, s, start_.state); s.type == "camera" && seen) {
      const Camera& c = seen->camera;
      for (const auto& [column, row] :
           {std::pair(0, 0), {c.width, 0}, {c.width, c.height}, {0, c.height}}) {
        const Vec3 d = Vec3(1.0, (c.cx - column) / c.fx, (c.cy - row) / c.fy).normalized();
        rays.push_back({0.0, 0.0, 0.0, d.x(), d.y(), d.z(), 0.0});
      }
    }
    for (const Vec3& d : ray_directions(s)) {
      rays.push_back({0.0, 0.0, 0.0, d.x(), d.y(), d.z(), limits.most});
    }
    return {{"type", s.type},   {"body", s.body}, {"pose", to_json(s.X_BS)},
            {"joint", s.joint}, {"show", s.show}, {"rays", std::move(rays)}};
  }

  static Json controller(const ControllerModel& m) {
    return {{"plugin", m.plugin}, {"assembly", m.assembly}};
  }

  static Json light(const LightModel& l) {
    const char* type = l.type == LightModel::Type::directional ? "directional"
                       : l.type == LightModel::Type::point     ? "point"
                                                               : "spot";
    return {{"type", type},
            {"pose", to_json(l.X_WL)},
            {"color", color_json(l.color)},
            {"intensity", l.intensity},
            {"cone", l.cone},
            {"shadows", l.shadows}};
  }

  static Json mesh(const TriangleMesh& m) {
    Json positions = Json::array(), indices = Json::array(), uv = Json::array();
    for (const Vec3& v : m.vertices) {
      for (int k = 0; k < 3; ++k) positions.push_back(shortened(v[k]));
    }
    for (const Eigen::Vector3i& t : m.triangles) {
      for (int k = 0; k < 3; ++k) indices.push_back(t[k]);
    }
    for (const Eigen::Vector2d& c : m.uv) {
      uv.push_back(shortened(c.x()));
      uv.push_back(shortened(c.y()));
    }
    return {{"positions", std::move(positions)},
            {"indices", std::move(indices)},
            {"uv", std::move(uv)}};
  }

  static Json heightmap(const HeightGrid& grid) {
    Json heights = Json::array();
    double low = 0.0, high = 0.0;
    for (const double h : grid.heights) {
      heights.push_back(shortened(h));
      low = std::min(low, h);
      high = std::max(high, h);
    }
    return {{"rows", grid.rows},
            {"columns", grid.columns},
            {"size", {grid.size_x, grid.size_y, high - low}},
            {"heights", std::move(heights)}};
  }

  static Frame start_of(const SceneRecord& record) {
    Frame start;
    start.model = record.model;
    for (const Body& b : record.model->bodies) start.state.poses.push_back(b.X_WB);
    start.state.twists.resize(record.model->bodies.size());
    return start;
  }
  double plane_extent() const {
    return std::max(kPlaneLeast, kPlaneShare * 2.0 * visible_bounds(start_).half().norm());
  }

  const SceneRecord& record_;
  const SceneModel& model_;
  const std::map<std::string, std::size_t>& assets_;
  const Frame start_;
  double plane_ = kPlaneLeast;
};

}  // namespace

Json to_json(const Pose& pose) {
  return {pose.p.x(), pose.p.y(), pose.p.z(), pose.q.w(), pose.q.x(), pose.q.y(), pose.q.z()};
}

Json to_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

std::string to_text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json scene_json(const SceneRecord& record, const std::map<std::string, std::size_t>& assets) {
  return SceneWriter(record, assets).write();
}

}  // namespace cogrsim::studio
