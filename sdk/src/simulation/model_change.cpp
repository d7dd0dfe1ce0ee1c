#include "simulation/model_change.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "cogrsim/model/mass_properties.h"
#include "cogrsim/signals/signal.h"
#include "core/index.h"

namespace cogrsim {

namespace {

int shifted(int index, std::size_t offset) {
  return index < 0 ? index : index + static_cast<int>(offset);
}

int mapped(int index, const std::vector<int>& indices) {
  return index < 0 ? index : indices[at(index)];
}

/// Appends the entries of `from` that `to` does not have; returns the index in `to` of each entry.
template <class Element, class Same>
std::vector<int> shared(std::vector<Element>& to, const std::vector<Element>& from,
                        const Same& same) {
  std::vector<int> indices;
  for (const Element& element : from) {
    const auto known = std::find_if(to.begin(), to.end(),
                                    [&](const Element& other) { return same(other, element); });
    indices.push_back(static_cast<int>(known - to.begin()));
    if (known == to.end()) to.push_back(element);
  }
  return indices;
}

constexpr auto kSameGeometry = [](const auto& a, const auto& b) { return same_geometry(a, b); };

// Compares everything except the source location.
bool same_material(const Material& a, const Material& b) {
  return a.name == b.name && a.base == b.base && a.density == b.density &&
         a.friction == b.friction && a.rolling_friction == b.rolling_friction &&
         a.spinning_friction == b.spinning_friction && a.restitution == b.restitution &&
         a.friction_combine == b.friction_combine &&
         a.restitution_combine == b.restitution_combine && a.stiffness == b.stiffness &&
         a.color.r == b.color.r && a.color.g == b.color.g && a.color.b == b.color.b &&
         a.color.a == b.color.a && a.texture == b.texture && a.texture_size == b.texture_size;
}

/// Appends the elements of a fragment to a model and adapts their indices and names.
class Appender {
 public:
  Appender(SceneModel& model, const SceneModel& fragment, std::string prefix, const Pose& pose)
      : to_(model),
        from_(fragment),
        prefix_(std::move(prefix)),
        pose_(pose),
        files_(shared(model.files, fragment.files, std::equal_to<>())),
        meshes_(shared(model.meshes, fragment.meshes, kSameGeometry)),
        heightmaps_(shared(model.heightmaps, fragment.heightmaps, kSameGeometry)),
        bodies_(model.bodies.size()),
        joints_(model.joints.size()),
        motors_(model.motors.size()) {}

  void append() {
    append_materials();
    append_assemblies();
    append_bodies();
    append_joints();
    append_devices();
    append_regions_and_doors();
    rename_signals(&SceneModel::motors, &Motor::target_signal);
    rename_signals(&SceneModel::forces, &ForceModel::factor);
    for (BodyPair pair : from_.no_collide) {
      to_.no_collide.emplace_back(shifted(pair.first, bodies_), shifted(pair.second, bodies_));
    }
  }

 private:
  // The new top-level assembly replaces the index -1 of the fragment.
  int assembly(int index) const { return index < 0 ? root_ : index + root_ + 1; }

  template <class Element>
  Element renamed(Element element) const {
    element.name = prefix_ + element.name;
    element.origin.file = mapped(element.origin.file, files_);
    return element;
  }

  /// Gives signals of the appended elements the names that the model now has.
  template <class Element>
  void rename_signals(std::vector<Element> SceneModel::*list, std::string Element::*text) {
    const SignalScope scope{to_, built_in_channels(to_),
                            [this](const std::string& name) { return prefix_ + name; }};
    for (std::size_t i = (to_.*list).size() - (from_.*list).size(); i < (to_.*list).size(); ++i) {
      std::string& signal = (to_.*list)[i].*text;
      if (signal.empty()) continue;
      if (const auto parsed = Signal::parse(scope, signal)) signal = parsed->text();
    }
  }

  // Equal entries of the model are reused, however often a template is spawned, so that a material
  // stays the same one with its pairs.
  void append_materials() {
    std::vector<Material> theirs = from_.materials;
    for (Material& material : theirs) material.origin.file = mapped(material.origin.file, files_);
    for (Material& material : theirs) {
      material.base = mapped(material.base, materials_);  // the base precedes the material
      const auto known =
          std::find_if(to_.materials.begin(), to_.materials.end(),
                       [&](const Material& m) { return same_material(m, material); });
      materials_.push_back(static_cast<int>(known - to_.materials.begin()));
      if (known == to_.materials.end()) to_.materials.push_back(std::move(material));
    }
    for (MaterialPair pair : from_.material_pairs) {
      pair.a = mapped(pair.a, materials_);
      pair.b = mapped(pair.b, materials_);
      pair.origin.file = mapped(pair.origin.file, files_);
      const bool known = std::any_of(
          to_.material_pairs.begin(), to_.material_pairs.end(), [&](const MaterialPair& p) {
            return p.a == pair.a && p.b == pair.b && p.friction == pair.friction &&
                   p.rolling_friction == pair.rolling_friction &&
                   p.spinning_friction == pair.spinning_friction &&
                   p.restitution == pair.restitution;
          });
      if (!known) to_.material_pairs.push_back(pair);
    }
  }

  void append_assemblies() {
    root_ = static_cast<int>(to_.assemblies.size());
    AssemblyInfo root;
    root.name = prefix_.substr(0, prefix_.size() - 1);
    root.X_WA = pose_;
    to_.assemblies.push_back(std::move(root));
    for (const AssemblyInfo& original : from_.assemblies) {
      AssemblyInfo info = renamed(original);
      info.parent = assembly(original.parent);
      info.X_WA = pose_ * original.X_WA;
      to_.assemblies.push_back(std::move(info));
    }
  }

  /// Appends renamed copies of a list; `adapt` maps their other indices and poses. An index that is
  /// kWorld stays kWorld.
  template <class Element, class Adapt>
  void append(std::vector<Element> SceneModel::*list, const Adapt& adapt) {
    for (const Element& original : from_.*list) {
      Element element = renamed(original);
      element.assembly = assembly(original.assembly);
      adapt(element);
      (to_.*list).push_back(std::move(element));
    }
  }

  void append_bodies() {
    append(&SceneModel::bodies, [this](Body& body) {
      body.X_WB = pose_ * body.X_WB;
      body.V_WB.linear = pose_.q * body.V_WB.linear;
      body.V_WB.angular = pose_.q * body.V_WB.angular;
      for (Shape& shape : body.shapes) {
        shape.name = prefix_ + shape.name;
        shape.mesh = mapped(shape.mesh, meshes_);
        shape.heightmap = mapped(shape.heightmap, heightmaps_);
        shape.material = mapped(shape.material, materials_);
        shape.origin.file = mapped(shape.origin.file, files_);
      }
    });
    append(&SceneModel::frames, [this](NamedFrame& frame) {
      frame.body = shifted(frame.body, bodies_);
      if (frame.body == kWorld) frame.X_BF = pose_ * frame.X_BF;
    });
  }

  void append_joints() {
    append(&SceneModel::joints, [this](Joint& joint) {
      joint.parent = shifted(joint.parent, bodies_);
      joint.child = shifted(joint.child, bodies_);
      if (joint.parent == kWorld) joint.X_PF = pose_ * joint.X_PF;
      if (joint.child == kWorld) joint.X_CM = pose_ * joint.X_CM;
    });
    append(&SceneModel::couplings, [this](Coupling& coupling) {
      coupling.joint = shifted(coupling.joint, joints_);
      for (CouplingTerm& term : coupling.terms) term.joint = shifted(term.joint, joints_);
    });
  }

  void append_devices() {
    append(&SceneModel::motors,
           [this](Motor& motor) { motor.joint = shifted(motor.joint, joints_); });
    append(&SceneModel::forces, [this](ForceModel& force) {
      force.body = shifted(force.body, bodies_);
      force.other = shifted(force.other, bodies_);
      if (force.body == kWorld) force.X_BE = pose_ * force.X_BE;
      if (force.other == kWorld) force.other_point = pose_ * force.other_point;
    });
    append(&SceneModel::sensors, [this](SensorModel& sensor) {
      sensor.body = shifted(sensor.body, bodies_);
      sensor.joint = shifted(sensor.joint, joints_);
      if (sensor.body == kWorld) sensor.X_BS = pose_ * sensor.X_BS;
    });
    append(&SceneModel::controllers, [](ControllerModel&) {});
  }

  void append_regions_and_doors() {
    append(&SceneModel::regions, [this](RegionModel& region) {
      region.body = shifted(region.body, bodies_);
      if (region.body == kWorld) region.X_BR = pose_ * region.X_BR;
      // Names of the elements of the fragment get its prefix; other names are of existing elements.
      for (std::string& who : region.who) {
        if (has_name(who)) who = prefix_ + who;
      }
    });
    append(&SceneModel::doors,
           [this](DoorModel& door) { door.motor = shifted(door.motor, motors_); });
  }

  bool has_name(const std::string& name) const {
    return find_body(from_, name) >= 0 || find_assembly(from_, name) >= 0 ||
           std::any_of(from_.frames.begin(), from_.frames.end(),
                       [&](const NamedFrame& frame) { return frame.name == name; });
  }

  SceneModel& to_;
  const SceneModel& from_;
  std::string prefix_;
  Pose pose_;
  std::vector<int> files_, meshes_, heightmaps_, materials_;  // fragment index to model index
  std::size_t bodies_, joints_, motors_;
  int root_ = -1;
};

/// The existing names, for a message about an unknown name.
template <class Element>
void collect_names(const std::vector<Element>& elements, std::vector<std::string>& out) {
  for (const Element& element : elements) {
    if (!element.removed) out.push_back(element.name);
  }
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& names) {
  const std::string near = nearest_name(name, names);
  return near.empty() ? "" : "did you mean '" + near + "'?";
}

/// Frees the memory of a removed element, whose index stays in use for the whole run. The shapes
/// remain, because backends number them.
void strip_removed(SceneModel& model) {
  for (SensorModel& sensor : model.sensors) {
    if (!sensor.removed) continue;
    sensor.parameters.clear();
    sensor.noise.clear();
  }
  for (ControllerModel& controller : model.controllers) {
    if (controller.removed) controller.parameters.clear();
  }
}

/// Marks the elements that depend on removed ones: joints of bodies, motors of joints, and so on.
void remove_dependents(SceneModel& model) {
  const auto body_gone = [&model](int body) { return body >= 0 && model.bodies[at(body)].removed; };
  for (Joint& joint : model.joints) {
    joint.removed = joint.removed || body_gone(joint.parent) || body_gone(joint.child);
  }
  for (NamedFrame& frame : model.frames) frame.removed = frame.removed || body_gone(frame.body);
  for (RegionModel& region : model.regions) {
    region.removed = region.removed || body_gone(region.body);
  }
  const auto joint_gone = [&model](int joint) {
    return joint >= 0 && model.joints[at(joint)].removed;
  };
  for (Motor& motor : model.motors) motor.removed = motor.removed || joint_gone(motor.joint);
  for (Coupling& coupling : model.couplings) {
    coupling.removed = coupling.removed || joint_gone(coupling.joint);
    for (const CouplingTerm& term : coupling.terms)
      coupling.removed = coupling.removed || joint_gone(term.joint);
  }
  for (ForceModel& force : model.forces) {
    force.removed = force.removed || body_gone(force.body) || body_gone(force.other);
  }
  for (SensorModel& sensor : model.sensors) {
    sensor.removed = sensor.removed || body_gone(sensor.body) || joint_gone(sensor.joint);
  }
  for (DoorModel& door : model.doors) {
    door.removed = door.removed || (door.motor >= 0 && model.motors[at(door.motor)].removed);
  }
  strip_removed(model);
  mark_loops(model);
}

Result<int> required_joint(const SceneModel& model, const std::string& name, const char* what) {
  const int index = find_joint(model, name);
  if (index >= 0) return index;
  std::vector<std::string> names;
  collect_names(model.joints, names);
  return fail("cannot " + std::string(what) + " joint '" + name + "': there is none of that name",
              "", did_you_mean(name, names));
}

Result<> check_limits(const std::string& joint, JointType type, const JointAxis& axis) {
  if (std::isnan(axis.lower) || std::isnan(axis.upper)) {
    return fail("joint '" + joint + "': a limit is not a number");
  }
  if (type == JointType::ball && axis.lower > -std::numeric_limits<double>::infinity()) {
    return fail("joint '" + joint + "': a ball has no lower limit, its upper one is a cone");
  }
  if (type == JointType::ball && axis.upper < 0.0) {
    return fail("joint '" + joint + "': the cone of a ball cannot be below 0");
  }
  if (axis.lower < axis.upper) return {};
  return fail("joint '" + joint + "': lower limit " + std::to_string(axis.lower) +
              " is not below upper limit " + std::to_string(axis.upper));
}

/// The number of axes of a joint of this type, see Joint::axes.
std::size_t axis_count(JointType type) {
  if (type == JointType::ball) return 1;
  return type == JointType::free ? 0 : static_cast<std::size_t>(speed_count(type));
}

/// Checks a change of the kind of a body. Errors: the kind cannot be changed, or the body cannot be
/// moved by forces.
Result<> check_kind_change(const Body& body, bool on) {
  const std::string what = "cannot make body '" + body.name + "' " + (on ? "static" : "dynamic");
  if (body.kind == BodyKind::kinematic) {
    return fail(what + ": it is kinematic, its motion is commanded", "",
                on ? "give it a twist of zero instead" : "");
  }
  if (on) return {};
  if (const auto massive = check_mass_properties(body.mass, body.inertia); !massive) {
    return fail(what + ": " + massive.error().message, "", "give it a mass or density");
  }
  for (const Shape& shape : body.shapes) {
    if (!shape.collides || (shape.type != ShapeType::plane && shape.type != ShapeType::mesh &&
                            shape.type != ShapeType::heightmap)) {
      continue;
    }
    return fail(what + ": its shape '" + shape.name + "' is a " + to_string(shape.type) +
                ", which only static bodies can have");
  }
  return {};
}

}  // namespace

Result<SceneModelPtr> with_added(const SceneModel& model, const SceneModel& fragment,
                                 const std::string& name, const Pose& pose) {
  if (name.empty()) return fail("an assembly cannot be added without a name");
  if (find_assembly(model, name) >= 0 || find_body(model, name) >= 0) {
    return fail("cannot add assembly '" + name + "': the name is taken", "",
                "choose another name, or remove the one that is there first");
  }
  if (model.bodies.size() + fragment.bodies.size() > kMaxBodies) {
    return fail("cannot add assembly '" + name + "': a run is limited to " +
                std::to_string(kMaxBodies) + " bodies, removed ones counted, and has " +
                std::to_string(model.bodies.size()));
  }
  auto next = std::make_shared<SceneModel>(model);
  Appender(*next, fragment, name + ".", pose).append();
  finish_model(*next);
  return SceneModelPtr(std::move(next));
}

Result<SceneModelPtr> with_removed(const SceneModel& model, const std::string& name) {
  const int target = find_assembly(model, name);
  const int free_body = target < 0 ? find_body(model, name) : -1;
  if (target < 0 && free_body < 0) {
    std::vector<std::string> names;
    collect_names(model.assemblies, names);
    for (const Body& body : model.bodies) {
      if (!body.removed && body.assembly < 0) names.push_back(body.name);
    }
    return fail("cannot remove '" + name + "': there is no assembly or body of that name", "",
                did_you_mean(name, names));
  }
  auto next = std::make_shared<SceneModel>(model);
  if (free_body >= 0) {
    Body& body = next->bodies[at(free_body)];
    if (body.assembly >= 0) {
      const std::string& whole = model.assemblies[at(body.assembly)].name;
      return fail("cannot remove body '" + name + "': it is a part of assembly '" + whole + "'", "",
                  "remove '" + whole + "'");
    }
    body.removed = true;
    remove_dependents(*next);
    return SceneModelPtr(std::move(next));
  }
  std::vector<char> gone(model.assemblies.size(), 0);
  // Parents precede their children, so one pass finds all nested assemblies.
  for (std::size_t i = 0; i < gone.size(); ++i) {
    const int parent = model.assemblies[i].parent;
    gone[i] = static_cast<int>(i) == target || (parent >= 0 && gone[at(parent)]);
    if (gone[i]) next->assemblies[i].removed = true;
  }
  const auto mark = [&gone](auto& elements) {
    for (auto& element : elements) {
      element.removed = element.removed || (element.assembly >= 0 && gone[at(element.assembly)]);
    }
  };
  mark(next->bodies);
  mark(next->frames);
  mark(next->joints);
  mark(next->motors);
  mark(next->sensors);
  mark(next->controllers);
  mark(next->regions);
  mark(next->doors);
  remove_dependents(*next);
  return SceneModelPtr(std::move(next));
}

Result<SceneModelPtr> with_joint(const SceneModel& model, Joint joint) {
  const std::string what = "cannot add joint '" + joint.name + "': ";
  if (joint.name.empty()) return fail("a joint cannot be added without a name");
  if (find_joint(model, joint.name) >= 0) {
    return fail(what + "the name is taken", "",
                "choose another name, or remove the one that is there first");
  }
  if (model.joints.size() >= kMaxBodies) {
    return fail(what + "a run is limited to " + std::to_string(kMaxBodies) +
                " joints, removed ones counted");
  }
  for (const int end : {joint.parent, joint.child}) {
    const bool there = end == kWorld || (end >= 0 && end < static_cast<int>(model.bodies.size()) &&
                                         !model.bodies[at(end)].removed);
    if (!there) return fail(what + "one of its bodies does not exist");
  }
  if (joint.parent == joint.child) return fail(what + "both its ends are the same body");
  if (joint.axes.empty()) joint.axes.resize(axis_count(joint.type));
  if (joint.axes.size() != axis_count(joint.type)) {
    return fail(what + "a " + to_string(joint.type) + " joint has " +
                std::to_string(axis_count(joint.type)) + " axes, " +
                std::to_string(joint.axes.size()) + " are given");
  }
  for (const JointAxis& axis : joint.axes) {
    if (auto fine = check_limits(joint.name, joint.type, axis); !fine) {
      return tl::unexpected(fine.error());
    }
  }
  auto next = std::make_shared<SceneModel>(model);
  next->joints.push_back(std::move(joint));
  finish_model(*next);
  // It is the last joint, so that the other joints do not change.
  SceneModel marked = *next;
  mark_loops(marked);
  next->joints.back().closes_loop = marked.joints.back().closes_loop;
  return SceneModelPtr(std::move(next));
}

Result<SceneModelPtr> with_joint_removed(const SceneModel& model, const std::string& name) {
  const auto index = required_joint(model, name, "remove");
  if (!index) return tl::unexpected(index.error());
  auto next = std::make_shared<SceneModel>(model);
  next->joints[at(*index)].removed = true;
  remove_dependents(*next);
  return SceneModelPtr(std::move(next));
}

Result<SceneModelPtr> with_limits(const SceneModel& model, const std::string& name, int axis,
                                  std::optional<double> lower, std::optional<double> upper) {
  const auto index = required_joint(model, name, "limit");
  if (!index) return tl::unexpected(index.error());
  const Joint& old = model.joints[at(*index)];
  if (axis < 0 || axis >= static_cast<int>(old.axes.size())) {
    return fail("cannot limit axis " + std::to_string(axis) + " of joint '" + name + "': a " +
                to_string(old.type) + " joint has " + std::to_string(old.axes.size()) +
                " axes, counted from 0");
  }
  JointAxis changed = old.axes[at(axis)];
  if (lower) changed.lower = *lower;
  if (upper) changed.upper = *upper;
  if (auto fine = check_limits(name, old.type, changed); !fine) return tl::unexpected(fine.error());
  auto next = std::make_shared<SceneModel>(model);
  next->joints[at(*index)].axes[at(axis)] = changed;
  return SceneModelPtr(std::move(next));
}

Result<SceneModelPtr> with_static(const SceneModel& model, const std::string& name, bool on) {
  std::vector<int> bodies;
  if (const int body = find_body(model, name); body >= 0) {
    bodies.push_back(body);
  } else if (const int assembly = find_assembly(model, name); assembly >= 0) {
    bodies = bodies_of(model, assembly);
  } else {
    std::vector<std::string> names;
    collect_names(model.assemblies, names);
    collect_names(model.bodies, names);
    return fail("cannot make '" + name + "' " + (on ? "static" : "dynamic") +
                    ": there is no body or assembly of that name",
                "", did_you_mean(name, names));
  }
  auto next = std::make_shared<SceneModel>(model);
  for (const int b : bodies) {
    Body& body = next->bodies[at(b)];
    const BodyKind kind = on ? BodyKind::static_body : BodyKind::dynamic;
    if (body.kind == kind) continue;
    if (auto fine = check_kind_change(body, on); !fine) return tl::unexpected(fine.error());
    body.kind = kind;
  }
  mark_loops(*next);
  return SceneModelPtr(std::move(next));
}

}  // namespace cogrsim
