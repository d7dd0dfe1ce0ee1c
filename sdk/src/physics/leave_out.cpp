#include "cogrsim/physics/leave_out.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/geometry/convex_hull.h"
#include "cogrsim/physics/backend_checks.h"
#include "core/index.h"

namespace cogrsim {
namespace {

constexpr const char* kLacking = "lacking";

/// Words for what people leave out most, and what they are short for.
constexpr std::array<std::pair<const char*, const char*>, 4> kWords = {
    {{"couplings", "joint.coupling"},
     {"limits", "joint.limit"},
     {"loops", "loop"},
     {"rotor-inertia", "joint.rotor-inertia"}}};

/// What joints of each type have on their axes.
constexpr std::array<const char*, 5> kAxisParts = {"limit", "damping", "friction", "stiffness",
                                                   "rotor-inertia"};

std::vector<std::string> features_to_leave_out() {
  std::vector<std::string> out = {"joint.coupling",
                                  "joint.coupling-effort",
                                  "body.force",
                                  "body.gravity-scale",
                                  "contact.stiffness",
                                  "contact.rolling-friction",
                                  "contact.spinning-friction",
                                  "contact.surface-velocity"};
  for (const JointType type : kJointTypes) {
    const std::string name = to_string(type);
    out.push_back("loop." + name);
    for (const char* part : kAxisParts) out.push_back(fmt::format("joint.{}.{}", part, name));
  }
  for (const ShapeType a : kShapeTypes) {
    out.push_back(std::string("shape.") + to_string(a));
    for (const ShapeType b : kShapeTypes)
      if (a <= b && !(is_surface(a) && is_surface(b))) out.push_back(pair_feature(a, b));
  }
  return out;
}

const std::vector<std::string>& features() {
  static const std::vector<std::string> all = features_to_leave_out();
  return all;
}

bool covers(const std::string& name, const std::string& feature) {
  if (name == feature) return true;
  for (const auto& [word, stands_for] : kWords)
    if (name == word) return covers(stands_for, feature);
  if (name.find('.') == std::string::npos && name != "loop") return false;
  return feature.compare(0, name.size() + 1, name + ".") == 0;
}

/// What a scene needs and cannot be without.
bool is_essential(const std::string& name) {
  const auto is_one = [&](const char* prefix, const auto& values) {
    return std::any_of(values.begin(), values.end(),
                       [&](auto value) { return name == std::string(prefix) + to_string(value); });
  };
  return name == "body.static" || name == "body.kinematic" || is_one("joint.", kJointTypes) ||
         is_one("motor.", kMotorModes);
}

/// Changes a model, and counts what it changes.
class Omission {
 public:
  Omission(const SceneModel& model, const Capabilities& capabilities,
           const std::vector<std::string>& names)
      : model_(model), capabilities_(capabilities), names_(names) {}

  bool run() {
    leave_out_of_bodies();
    leave_out_of_surfaces();
    leave_out_joints();
    leave_out_couplings();
    hull_meshes();
    part_pairs();
    for (ForceModel& force : model_.forces)
      if (!force.removed && force.kind != ForceModel::Kind::wind && takes("body.force", "force"))
        force.removed = true;
    return !counts_.empty();
  }

  SceneModel model_;
  std::map<std::string, LeftOut> counts_;

 private:
  bool wanted(const std::string& feature) {
    const auto [known, first] = wanted_.emplace(feature, false);
    if (first)
      known->second = std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
        return name == kLacking ? can_leave_out(feature) &&
                                      capabilities_.get(feature).support == Support::unsupported
                                : covers(name, feature);
      });
    return known->second;
  }

  /// Whether the feature of one more element shall be left out, which is counted.
  bool takes(const std::string& feature, const char* of) {
    if (!wanted(feature)) return false;
    LeftOut& entry = counts_[feature];
    entry.feature = feature;
    entry.of = of;
    ++entry.count;
    return true;
  }

  void leave_out_of_bodies() {
    for (Body& body : model_.bodies) {
      if (body.removed) continue;
      if (body.kind == BodyKind::dynamic && body.gravity_scale != 1.0 &&
          takes("body.gravity-scale", "body"))
        body.gravity_scale = 1.0;
      for (Shape& shape : body.shapes) {
        if (!shape.collides) continue;
        if (takes(std::string("shape.") + to_string(shape.type), "shape")) {
          shape.collides = false;
          continue;
        }
        used_materials_.insert(shape.material);
        if (!shape.surface_velocity.isZero(0.0) && takes("contact.surface-velocity", "shape"))
          shape.surface_velocity.setZero();
      }
    }
  }

  void leave_out_of_surfaces() {
    const auto no_friction = [&](auto& one, const char* of) {
      if (one.rolling_friction > 0.0 && takes("contact.rolling-friction", of))
        one.rolling_friction = 0.0;
      if (one.spinning_friction > 0.0 && takes("contact.spinning-friction", of))
        one.spinning_friction = 0.0;
    };
    for (const int i : used_materials_) {
      Material& material = model_.materials[at(i)];
      if (material.stiffness && takes("contact.stiffness", "material")) material.stiffness.reset();
      no_friction(material, "material");
    }
    for (MaterialPair& pair : model_.material_pairs) no_friction(pair, "material");
  }

  void leave_out_joints() {
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      Joint& joint = model_.joints[i];
      if (joint.removed) continue;
      const std::string type = to_string(joint.type);
      if (joint.closes_loop && takes("loop." + type, "joint")) {
        open_loop(static_cast<int>(i));
        continue;
      }
      const auto clear = [&](const char* part, const auto& has, const auto& without) {
        if (std::any_of(joint.axes.begin(), joint.axes.end(), has) &&
            takes(fmt::format("joint.{}.{}", part, type), "joint"))
          for (JointAxis& axis : joint.axes) without(axis);
      };
      clear(
          "limit", [](const JointAxis& a) { return a.has_limit(); },
          [](JointAxis& a) {
            a.lower = -std::numeric_limits<double>::infinity();
            a.upper = std::numeric_limits<double>::infinity();
          });
      const auto zero = [&](const char* part, double JointAxis::*value) {
        clear(
            part, [value](const JointAxis& a) { return a.*value > 0.0; },
            [value](JointAxis& a) { a.*value = 0.0; });
      };
      zero("damping", &JointAxis::damping);
      zero("friction", &JointAxis::friction);
      zero("stiffness", &JointAxis::stiffness);
      zero("rotor-inertia", &JointAxis::rotor_inertia);
    }
  }

  /// Its bodies stay as they were to each other, but for the joint.
  void open_loop(int index) {
    Joint& joint = model_.joints[at(index)];
    joint.removed = true;
    if (!joint.bodies_collide && joint.parent != kWorld) add_pair(joint.parent, joint.child);
    for (Motor& motor : model_.motors) motor.removed |= motor.joint == index;
    for (SensorModel& sensor : model_.sensors) sensor.removed |= sensor.joint == index;
    for (Coupling& coupling : model_.couplings)
      coupling.removed |= coupling.joint == index ||
                          std::any_of(coupling.terms.begin(), coupling.terms.end(),
                                      [&](const CouplingTerm& t) { return t.joint == index; });
  }

  void leave_out_couplings() {
    for (Coupling& coupling : model_.couplings) {
      if (coupling.removed) continue;
      if (takes("joint.coupling", "coupling"))
        coupling.removed = true;
      else if (std::isfinite(coupling.max_effort) && takes("joint.coupling-effort", "coupling"))
        coupling.max_effort = std::numeric_limits<double>::infinity();
    }
  }

  /// A mesh that others of these types meet gets a convex hull that collides in its place.
  void hull_meshes() {
    const CollisionFilter filter(model_);
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      if (model_.bodies[b].removed) continue;
      for (std::size_t s = 0; s < model_.bodies[b].shapes.size(); ++s) {
        Shape hull = model_.bodies[b].shapes[s];
        if (!hull.collides || hull.type != ShapeType::mesh || !meets(filter, static_cast<int>(b)))
          continue;
        model_.bodies[b].shapes[s].collides = false;
        hull.name += "_hull";
        hull.type = ShapeType::convex_mesh;
        hull.visible = false;
        const MeshPtr& mesh = model_.meshes[at(hull.mesh)];
        model_.meshes.push_back(std::make_shared<TriangleMesh>(geometry::convex_hull(*mesh)));
        hull.mesh = static_cast<int>(model_.meshes.size()) - 1;
        model_.bodies[b].shapes.push_back(std::move(hull));
      }
    }
  }

  bool meets(const CollisionFilter& filter, int body_of_mesh) {
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      if (!filter.collide(static_cast<int>(b), body_of_mesh)) continue;
      for (const Shape& shape : model_.bodies[b].shapes)
        if (shape.collides && !is_surface(shape.type) &&
            takes(pair_feature(shape.type, ShapeType::mesh), "shape"))
          return true;
    }
    return false;
  }

  /// Contacts are between bodies: those with shapes that shall not meet do not meet at all.
  void part_pairs() {
    std::array<std::vector<int>, kShapeTypes.size()> bodies;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      if (model_.bodies[b].removed) continue;
      for (const Shape& shape : model_.bodies[b].shapes) {
        std::vector<int>& list = bodies[static_cast<std::size_t>(shape.type)];
        if (shape.collides && (list.empty() || list.back() != static_cast<int>(b)))
          list.push_back(static_cast<int>(b));
      }
    }
    const CollisionFilter filter(model_);
    std::set<BodyPair> parted;
    for (const ShapeType a : kShapeTypes)
      for (const ShapeType b : kShapeTypes) {
        if (b < a || (is_surface(a) && is_surface(b)) || !wanted(pair_feature(a, b))) continue;
        for (const int one : bodies[static_cast<std::size_t>(a)])
          for (const int other : bodies[static_cast<std::size_t>(b)])
            if (filter.collide(one, other) && parted.insert(std::minmax(one, other)).second &&
                takes(pair_feature(a, b), "pair of bodies"))
              add_pair(one, other);
      }
  }

  void add_pair(int a, int b) {
    const BodyPair pair = std::minmax(a, b);
    const auto place = std::lower_bound(model_.no_collide.begin(), model_.no_collide.end(), pair);
    if (place == model_.no_collide.end() || *place != pair) model_.no_collide.insert(place, pair);
  }

  const Capabilities& capabilities_;
  const std::vector<std::string>& names_;
  std::map<std::string, bool> wanted_;
  std::set<int> used_materials_;
};

}  // namespace

bool can_leave_out(const std::string& feature) {
  return std::find(features().begin(), features().end(), feature) != features().end();
}

Result<> check_without(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name == kLacking || std::any_of(features().begin(), features().end(),
                                        [&](const std::string& f) { return covers(name, f); }))
      continue;
    if (is_essential(name))
      return fail("'" + name + "' cannot be left out: without it, it is another scene", "",
                  "run the scene on an engine that has it, see `cogrsim plugins`");
    std::vector<std::string> known = features();
    known.emplace_back(kLacking);
    for (const auto& [word, stands_for] : kWords) known.emplace_back(word);
    for (const char* part : kAxisParts) known.push_back(std::string("joint.") + part);
    const std::string nearest = nearest_name(name, known);
    return fail("there is nothing '" + name + "' to leave out", "",
                (nearest.empty() ? "" : "did you mean '" + nearest + "'? ") +
                    "write 'lacking', or features as `cogrsim plugins` lists them, such as "
                    "joint.limit.ball, or couplings, limits, loops, rotor-inertia");
  }
  return {};
}

SceneModelPtr leave_out(SceneModelPtr model, const Capabilities& capabilities,
                        const std::vector<std::string>& names, std::vector<LeftOut>* found) {
  if (names.empty()) return model;
  Omission omission(*model, capabilities, names);
  if (!omission.run()) return model;
  if (found != nullptr)
    for (auto& [feature, entry] : omission.counts_) found->push_back(std::move(entry));
  return std::make_shared<SceneModel>(std::move(omission.model_));
}

std::string to_text(const std::vector<LeftOut>& left_out) {
  std::string out;
  for (const LeftOut& one : left_out) {
    const bool pairs = one.of == "pair of bodies";
    const std::string many = pairs ? "pairs of bodies" : one.of == "body" ? "bodies" : one.of + "s";
    out += fmt::format("{}{} ({} {})", out.empty() ? "" : ", ", one.feature, one.count,
                       one.count == 1 ? one.of : many);
  }
  return out;
}

}  // namespace cogrsim
