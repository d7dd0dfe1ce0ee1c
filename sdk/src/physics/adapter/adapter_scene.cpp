#include "physics/adapter/adapter_scene.h"

#include <nlohmann/json.hpp>

#include "cogrsim/physics/backend_checks.h"
#include "model/model_json.h"

namespace cogrsim {

namespace {

using SceneJson = nlohmann::ordered_json;

SceneJson plain_options(const Parameters& options) {
  SceneJson out = SceneJson::object();
  for (const auto& [name, value] : options)
    std::visit([&, &key = name](const auto& held) { out[key] = held; }, value);
  return out;
}

/// The recorded form has numbers for enumerations and options of all engines; an adapter gets names,
/// and its own.
template <class Element, class Name>
void name_and_choose(SceneJson& list, const std::vector<Element>& elements,
                     const std::string& engine, const Name& name) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    SceneJson& item = list[i];
    item.erase("origin");
    item.erase("assembly");
    if (item.contains("engine_options")) {
      item.erase("engine_options");
      if constexpr (requires { elements[i].engine_options; }) {
        const auto own = elements[i].engine_options.find(engine);
        item["options"] = own == elements[i].engine_options.end() ? SceneJson::object()
                                                                  : plain_options(own->second);
      }
    }
    name(item, elements[i]);
  }
}

SceneJson surfaces_of(const SceneModel& model) {
  SceneJson out = SceneJson::array();
  const int count = static_cast<int>(model.materials.size());
  for (int a = 0; a < count; ++a) {
    SceneJson row = SceneJson::array();
    for (int b = 0; b < count; ++b) {
      const SurfacePair pair = surface_pair(model, a, b);
      row.push_back({{"friction", pair.friction},
                     {"rolling_friction", pair.rolling_friction},
                     {"spinning_friction", pair.spinning_friction},
                     {"restitution", pair.restitution},
                     {"stiffness", pair.stiffness ? SceneJson(*pair.stiffness) : SceneJson()}});
    }
    out.push_back(std::move(row));
  }
  return out;
}

/// Pairs of bodies that never touch each other, beside those that do not move.
SceneJson excluded_pairs(const SceneModel& model) {
  SceneJson out = SceneJson::array();
  for (const BodyPair& pair : model.no_collide) out.push_back({pair.first, pair.second});
  for (const Joint& joint : model.joints) {
    if (joint.removed || joint.bodies_collide || joint.parent == kWorld || joint.child == kWorld)
      continue;
    out.push_back({std::min(joint.parent, joint.child), std::max(joint.parent, joint.child)});
  }
  return out;
}

SceneJson meshes_of(const SceneModel& model) {
  SceneJson out = SceneJson::array();
  for (const MeshPtr& mesh : model.meshes) {
    SceneJson vertices = SceneJson::array(), triangles = SceneJson::array();
    for (const Vec3& v : mesh->vertices)
      for (const double x : v) vertices.push_back(x);
    for (const Eigen::Vector3i& t : mesh->triangles)
      for (const int i : t) triangles.push_back(i);
    out.push_back({{"name", mesh->name},
                   {"vertices", std::move(vertices)},
                   {"triangles", std::move(triangles)}});
  }
  return out;
}

SceneJson heightmaps_of(const SceneModel& model) {
  SceneJson out = SceneJson::array();
  for (const HeightGridPtr& grid : model.heightmaps)
    out.push_back({{"name", grid->name},
                   {"columns", grid->columns},
                   {"rows", grid->rows},
                   {"size_x", grid->size_x},
                   {"size_y", grid->size_y},
                   {"heights", grid->heights}});
  return out;
}

}  // namespace

std::string options_for_adapter(const Parameters& options) { return plain_options(options).dump(); }

std::string scene_for_adapter(const SceneModel& model, const std::string& name,
                              const Parameters& options) {
  SceneModel needed;  // without sensors, plots and what else no engine reads
  needed.name = model.name;
  needed.materials = model.materials;
  needed.bodies = model.bodies;
  needed.joints = model.joints;
  needed.couplings = model.couplings;
  needed.motors = model.motors;
  SceneJson whole = SceneJson::parse(model_to_json(needed));
  SceneJson out;
  out["name"] = model.name;
  out["gravity"] = {model.physics.gravity.x(), model.physics.gravity.y(),
                    model.physics.gravity.z()};
  out["step"] = model.physics.step;
  out["seed"] = model.physics.seed;
  out["bounce_threshold"] = model.physics.bounce_threshold;
  out["options"] = plain_options(options);
  const auto no_name = [](SceneJson&, const auto&) {};
  name_and_choose(whole["materials"], model.materials, name, no_name);
  name_and_choose(whole["bodies"], model.bodies, name, [&](SceneJson& item, const Body& body) {
    item["kind"] = body.kind == BodyKind::dynamic     ? "dynamic"
                   : body.kind == BodyKind::kinematic ? "kinematic"
                                                      : "static";
    name_and_choose(item["shapes"], body.shapes, name, [](SceneJson& inner, const Shape& shape) {
      inner["type"] = to_string(shape.type);
    });
  });
  name_and_choose(whole["joints"], model.joints, name, [](SceneJson& item, const Joint& joint) {
    item["type"] = to_string(joint.type);
  });
  name_and_choose(whole["motors"], model.motors, name, [](SceneJson& item, const Motor& motor) {
    item["mode"] = to_string(motor.mode);
  });
  name_and_choose(whole["couplings"], model.couplings, name, no_name);
  for (const char* list : {"materials", "bodies", "joints", "motors", "couplings"})
    out[list] = std::move(whole[list]);
  out["surfaces"] = surfaces_of(model);
  out["no_collide"] = excluded_pairs(model);
  out["meshes"] = meshes_of(model);
  out["heightmaps"] = heightmaps_of(model);
  out["joint_positions"] = model.joint_positions;
  out["joint_speeds"] = model.joint_speeds;
  return out.dump(-1, ' ', false, SceneJson::error_handler_t::replace);
}

}  // namespace cogrsim
