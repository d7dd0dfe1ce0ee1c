// Elements that had been added, removed or changed when a snapshot was taken, applied to a scene.
#include <algorithm>
#include <map>
#include <memory>

#include "cogrsim/model/joint_kinematics.h"
#include "model/model_json.h"
#include "simulation/snapshot/data.h"

namespace cogrsim::snapshots {
namespace {

constexpr int kMissing = -2;

template <class Element>
const std::string& name_of(const Element& element) {
  return element.name;
}
template <class Shared>
const std::string& name_of(const std::shared_ptr<Shared>& element) {
  return element->name;
}

/// Maps the indices of the snapshot to current indices, for one kind of element: elements of the
/// scene by name; elements that were added later follow those of the scene.
class Renumbering {
 public:
  template <class Element>
  Renumbering(const std::vector<Element>& then, std::size_t of_scene,
              const std::vector<Element>& now) {
    std::map<std::string, int> by_name;
    for (std::size_t i = 0; i < now.size(); ++i)
      by_name.emplace(name_of(now[i]), static_cast<int>(i));
    for (std::size_t i = 0; i < then.size(); ++i) {
      if (i >= of_scene) {
        to_.push_back(static_cast<int>(now.size() + i - of_scene));
        continue;
      }
      // The same index has priority, because materials and meshes may share names.
      const bool same = i < now.size() && name_of(now[i]) == name_of(then[i]);
      const auto found = by_name.find(name_of(then[i]));
      to_.push_back(same ? static_cast<int>(i) : found == by_name.end() ? kMissing : found->second);
    }
  }
  int operator()(int then) const { return then < 0 ? then : to_.at(then); }

 private:
  std::vector<int> to_;
};

class Rebuilder {
 public:
  Rebuilder(const SceneModel& scene, const SceneModel& original, const SceneModel& then,
            const Json& content, std::vector<std::string>& notes)
      : original_(original),
        then_(then),
        content_(content),
        notes_(notes),
        out_(std::make_shared<SceneModel>(scene)),
        materials_(then.materials, original.materials.size(), scene.materials),
        meshes_(then.meshes, original.meshes.size(), scene.meshes),
        heightmaps_(then.heightmaps, original.heightmaps.size(), scene.heightmaps),
        assemblies_(then.assemblies, original.assemblies.size(), scene.assemblies),
        bodies_(then.bodies, original.bodies.size(), scene.bodies),
        joints_(then.joints, original.joints.size(), scene.joints),
        motors_(then.motors, original.motors.size(), scene.motors) {}

  SceneModelPtr run() {
    append_matter();
    append_bodies();
    append_joints();
    append_devices();
    take_over_flags();
    set_states();
    finish_model(*out_);
    mark_loops(*out_);
    if (!lost_.empty()) {
      notes_.push_back("not transferred, because they belong to elements that the scene lacks: " +
                       listed("", "", lost_).substr(1));
    }
    return out_;
  }

 private:
  /// Appends the elements of one kind that were added during the run.
  template <class Element, class Adapt>
  void append(std::vector<Element> SceneModel::*list, Adapt&& adapt) {
    const std::vector<Element>& from = then_.*list;
    for (std::size_t i = (original_.*list).size(); i < from.size(); ++i) {
      Element element = from[i];
      if (!adapt(element)) {
        lost_.push_back(element.name);
        // Its index stays in use, so that the indices of later elements remain valid.
        mark_removed(element);
      }
      (out_.get()->*list).push_back(std::move(element));
    }
  }
  template <class Element>
  static void mark_removed(Element& element) {
    element.removed = true;
  }
  /// Whether the scene or one of its templates uses this file.
  static bool has_texture(const SceneModel& scene, const std::string& file) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [&](const Material& m) { return m.texture == file; }) ||
           std::any_of(scene.templates.begin(), scene.templates.end(), [&](const TemplateModel& t) {
             return t.fragment != nullptr && has_texture(*t.fragment, file);
           });
  }
  static bool to(const Renumbering& renumbering, int& index) {
    index = renumbering(index);
    return index != kMissing || (index = -1, false);
  }

  void append_matter() {
    for (std::size_t i = original_.materials.size(); i < then_.materials.size(); ++i) {
      Material material = then_.materials[i];
      to(materials_, material.base);
      // Only files of the scene: a snapshot from another source could name any file.
      if (!material.texture.empty() && !has_texture(*out_, material.texture)) {
        notes_.push_back("the texture '" + material.texture + "' is none of the scene's: left out");
        material.texture.clear();
      }
      out_->materials.push_back(std::move(material));
    }
    for (std::size_t i = original_.material_pairs.size(); i < then_.material_pairs.size(); ++i) {
      MaterialPair pair = then_.material_pairs[i];
      if (to(materials_, pair.a) && to(materials_, pair.b)) out_->material_pairs.push_back(pair);
    }
    for (std::size_t i = original_.meshes.size(); i < then_.meshes.size(); ++i) {
      out_->meshes.push_back(then_.meshes[i]);
    }
    for (std::size_t i = original_.heightmaps.size(); i < then_.heightmaps.size(); ++i) {
      out_->heightmaps.push_back(then_.heightmaps[i]);
    }
  }

  void append_bodies() {
    append(&SceneModel::assemblies, [&](AssemblyInfo& a) { return to(assemblies_, a.parent); });
    append(&SceneModel::bodies, [&](Body& body) {
      bool good = to(assemblies_, body.assembly);
      for (Shape& shape : body.shapes) {
        good = to(meshes_, shape.mesh) && to(heightmaps_, shape.heightmap) && good;
        if (!to(materials_, shape.material)) shape.material = 0;
      }
      return good;
    });
    append(&SceneModel::frames, [&](NamedFrame& f) {
      const bool body = to(bodies_, f.body);
      return to(assemblies_, f.assembly) && body;
    });
    for (const BodyPair& pair : then_.no_collide) {
      int a = pair.first, b = pair.second;
      if (static_cast<std::size_t>(std::max(a, b)) < original_.bodies.size()) continue;
      if (to(bodies_, a) && to(bodies_, b)) {
        out_->no_collide.emplace_back(std::min(a, b), std::max(a, b));
      }
    }
  }

  void append_joints() {
    append(&SceneModel::joints, [&](Joint& joint) {
      const bool parent = to(bodies_, joint.parent), child = to(bodies_, joint.child);
      return to(assemblies_, joint.assembly) && parent && child;
    });
    append(&SceneModel::couplings, [&](Coupling& coupling) {
      bool all = to(joints_, coupling.joint);
      for (CouplingTerm& term : coupling.terms) all = to(joints_, term.joint) && all;
      return to(assemblies_, coupling.assembly) && all;
    });
    append(&SceneModel::forces, [&](ForceModel& force) {
      const bool body = to(bodies_, force.body), other = to(bodies_, force.other);
      return to(assemblies_, force.assembly) && body && other;
    });
    append(&SceneModel::motors, [&](Motor& motor) {
      const bool joint = to(joints_, motor.joint);
      return to(assemblies_, motor.assembly) && joint;
    });
  }

  void append_devices() {
    append(&SceneModel::sensors, [&](SensorModel& sensor) {
      const bool body = to(bodies_, sensor.body), joint = to(joints_, sensor.joint);
      return to(assemblies_, sensor.assembly) && body && joint;
    });
    append(&SceneModel::controllers,
           [&](ControllerModel& c) { return to(assemblies_, c.assembly); });
    append(&SceneModel::regions, [&](RegionModel& region) {
      const bool body = to(bodies_, region.body);
      return to(assemblies_, region.assembly) && body;
    });
    append(&SceneModel::doors, [&](DoorModel& door) {
      const bool motor = to(motors_, door.motor);
      return to(assemblies_, door.assembly) && motor;
    });
  }

  /// Applies changes of elements of the scene: removed, made static or dynamic, other limits.
  template <class Element, class Take>
  void each(std::vector<Element> SceneModel::*list, Take&& take) {
    std::map<std::string, Element*> now;
    const std::size_t of_scene =
        (out_.get()->*list).size() - ((then_.*list).size() - (original_.*list).size());
    for (std::size_t i = 0; i < of_scene; ++i) {
      Element& element = (out_.get()->*list)[i];
      now.emplace(element.name, &element);
    }
    for (std::size_t i = 0; i < (original_.*list).size(); ++i) {
      const auto found = now.find((then_.*list)[i].name);
      if (found != now.end()) take((original_.*list)[i], (then_.*list)[i], *found->second);
    }
  }

  void take_over_flags() {
    const auto removed = [](const auto& before, const auto& after, auto& now) {
      if (after.removed && !before.removed) now.removed = true;
    };
    each(&SceneModel::assemblies, removed);
    each(&SceneModel::frames, removed);
    each(&SceneModel::couplings, removed);
    each(&SceneModel::forces, removed);
    each(&SceneModel::motors, removed);
    each(&SceneModel::sensors, removed);
    each(&SceneModel::controllers, removed);
    each(&SceneModel::regions, removed);
    each(&SceneModel::doors, removed);
    each(&SceneModel::bodies, [&](const Body& before, const Body& after, Body& now) {
      removed(before, after, now);
      if (after.kind != before.kind) now.kind = after.kind;
    });
    each(&SceneModel::joints, [&](const Joint& before, const Joint& after, Joint& now) {
      removed(before, after, now);
      for (std::size_t i = 0;
           i < std::min({before.axes.size(), after.axes.size(), now.axes.size()}); ++i) {
        if (after.axes[i].lower != before.axes[i].lower) now.axes[i].lower = after.axes[i].lower;
        if (after.axes[i].upper != before.axes[i].upper) now.axes[i].upper = after.axes[i].upper;
      }
    });
  }

  /// Whether an immobile body had the pose of its scene.
  bool never_moved(const Body& now, const Pose& then) const {
    const int index = find_body(original_, now.name);
    if (now.kind != BodyKind::static_body || index < 0) return false;
    const Body& before = original_.bodies[index];
    constexpr double kRounding = 1e-9;  // [m], [rad]: conversion to engine coordinates and back
    return before.kind == BodyKind::static_body && (before.X_WB.p - then.p).norm() < kRounding &&
           before.X_WB.q.angularDistance(then.q) < kRounding;
  }

  /// Sets the states of bodies and joints at the time of the snapshot, so that attached joints fit.
  /// A body that was made static during the run keeps its pose; a body that never moved has the
  /// pose of the current scene.
  void set_states() {
    const Json& bodies = content_.at("bodies");
    for (Body& body : out_->bodies) {
      if (body.removed || !bodies.contains(body.name)) continue;
      const Json& state = bodies.at(body.name);
      const Pose then = pose_from(state.at("pose"));
      if (never_moved(body, then)) continue;
      body.X_WB = then;
      body.V_WB = body.kind == BodyKind::static_body ? Twist() : twist_from(state.at("twist"));
    }
    const Json& joints = content_.at("joints");
    for (Joint& joint : out_->joints) {
      if (joint.removed || !joints.contains(joint.name)) continue;
      const Json& state = joints.at(joint.name);
      if (state.at("type") != to_string(joint.type)) continue;
      joint.position = numbers_from(state.at("position"));
      joint.velocity = numbers_from(state.at("velocity"));
      if (joint.position.size() != static_cast<std::size_t>(position_count(joint.type)) ||
          joint.velocity.size() != static_cast<std::size_t>(speed_count(joint.type))) {
        throw Damaged("the joint '" + joint.name + "' has not as many coordinates as its type");
      }
    }
  }

  const SceneModel& original_;
  const SceneModel& then_;
  const Json& content_;
  std::vector<std::string>& notes_;
  std::shared_ptr<SceneModel> out_;
  Renumbering materials_, meshes_, heightmaps_, assemblies_, bodies_, joints_, motors_;
  std::vector<std::string> lost_;
};

Json mesh_json(const TriangleMesh& mesh) {
  Json vertices = Json::array(), triangles = Json::array(), uv = Json::array();
  for (const Vec3& v : mesh.vertices) vertices.push_back(vector(v));
  for (const auto& t : mesh.triangles) triangles.push_back({t[0], t[1], t[2]});
  for (const auto& c : mesh.uv) uv.push_back(numbers(c.data(), 2));
  return {{"name", mesh.name}, {"vertices", vertices}, {"triangles", triangles}, {"uv", uv}};
}

MeshPtr mesh_from(const Json& json) {
  TriangleMesh mesh;
  mesh.name = json.at("name").get<std::string>();
  for (const Json& v : json.at("vertices")) mesh.vertices.push_back(vector_from(v));
  for (const Json& t : json.at("triangles")) {
    mesh.triangles.emplace_back(whole_from<int>(t.at(0)), whole_from<int>(t.at(1)),
                                whole_from<int>(t.at(2)));
  }
  for (const Json& c : json.at("uv")) {
    mesh.uv.emplace_back(number_from(c.at(0)), number_from(c.at(1)));
  }
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

}  // namespace

namespace {

template <class Element>
Json names_of(const std::vector<std::shared_ptr<const Element>>& elements) {
  Json out = Json::array();
  for (const auto& element : elements) out.push_back(element->name);
  return out;
}

/// The elements of the scene have only names, because the scene has their contents; the contents of
/// added elements follow. False: there are more contents than names.
template <class Element>
bool put_names(const Json& names, const std::vector<std::shared_ptr<const Element>>& came,
               std::vector<std::shared_ptr<const Element>>& original,
               std::vector<std::shared_ptr<const Element>>& then) {
  if (names.size() < came.size()) return false;
  const std::size_t own = names.size() - came.size();
  for (std::size_t i = 0; i < own; ++i) {
    Element known;
    known.name = names.at(i).get<std::string>();
    original.push_back(std::make_shared<const Element>(std::move(known)));
  }
  then = original;
  then.insert(then.end(), came.begin(), came.end());
  return true;
}

/// Removed elements keep their indices and new ones are appended, so no list may become shorter.
bool goes_on_from(const SceneModel& original, const SceneModel& then) {
  const auto longer = [&](auto list) { return (then.*list).size() >= (original.*list).size(); };
  return longer(&SceneModel::materials) && longer(&SceneModel::material_pairs) &&
         longer(&SceneModel::assemblies) && longer(&SceneModel::bodies) &&
         longer(&SceneModel::frames) && longer(&SceneModel::joints) &&
         longer(&SceneModel::couplings) && longer(&SceneModel::forces) &&
         longer(&SceneModel::motors) && longer(&SceneModel::sensors) &&
         longer(&SceneModel::controllers) && longer(&SceneModel::regions) &&
         longer(&SceneModel::doors);
}

Json grid_json(const HeightGrid& grid) {
  return {{"name", grid.name},
          {"columns", grid.columns},
          {"rows", grid.rows},
          {"size_x", number(grid.size_x)},
          {"size_y", number(grid.size_y)},
          {"heights", numbers(grid.heights)}};
}

HeightGridPtr grid_from(const Json& json) {
  HeightGrid grid;
  grid.name = json.at("name").get<std::string>();
  grid.columns = whole_from<int>(json.at("columns"));
  grid.rows = whole_from<int>(json.at("rows"));
  grid.size_x = number_from(json.at("size_x"));
  grid.size_y = number_from(json.at("size_y"));
  grid.heights = numbers_from(json.at("heights"));
  return std::make_shared<const HeightGrid>(std::move(grid));
}

}  // namespace

Json changes_of(const SceneModel& original, const SceneModel& now) {
  Json meshes = Json::array(), heightmaps = Json::array();
  for (std::size_t i = original.meshes.size(); i < now.meshes.size(); ++i) {
    meshes.push_back(mesh_json(*now.meshes[i]));
  }
  for (std::size_t i = original.heightmaps.size(); i < now.heightmaps.size(); ++i) {
    heightmaps.push_back(grid_json(*now.heightmaps[i]));
  }
  return {{"original", Json::parse(model_to_json(original))},
          {"now", Json::parse(model_to_json(now))},
          {"mesh_names", names_of(now.meshes)},
          {"meshes", meshes},
          {"heightmap_names", names_of(now.heightmaps)},
          {"heightmaps", heightmaps}};
}

SceneModelPtr with_changes(const SceneModel& scene, const Json& content,
                           std::vector<std::string>& notes) {
  const Json& changes = content.at("changes");
  auto original = model_from_json(changes.at("original").dump());
  auto then = model_from_json(changes.at("now").dump());
  if (!original || !then) throw Damaged("its scene cannot be read");
  // The text of the models has no meshes and heightmaps; those of added elements are stored
  // separately.
  SceneModel came;
  for (const Json& mesh : changes.at("meshes")) came.meshes.push_back(mesh_from(mesh));
  for (const Json& grid : changes.at("heightmaps")) came.heightmaps.push_back(grid_from(grid));
  if (auto good = check_model(came); !good) throw Damaged(good.error().message);
  if (!put_names(changes.at("mesh_names"), came.meshes, original->meshes, then->meshes) ||
      !put_names(changes.at("heightmap_names"), came.heightmaps, original->heightmaps,
                 then->heightmaps)) {
    throw Damaged("shapes have no name");
  }
  for (const SceneModel* model : {&*original, &*then}) {
    if (auto good = check_references(*model); !good) throw Damaged(good.error().message);
  }
  if (!goes_on_from(*original, *then)) throw Damaged("elements of the original scene are missing");
  return Rebuilder(scene, *original, *then, content, notes).run();
}

}  // namespace cogrsim::snapshots
