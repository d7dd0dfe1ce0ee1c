#include "simulation/model_change.h"

#include <algorithm>

namespace cogrsim {

namespace {

int shifted(int index, std::size_t offset) {
  return index < 0 ? index : index + static_cast<int>(offset);
}

/// Puts the elements of a fragment behind those of a model, indices and names adapted.
class Appender {
 public:
  Appender(SceneModel& model, const SceneModel& fragment, std::string prefix, const Pose& pose)
      : to_(model),
        from_(fragment),
        prefix_(std::move(prefix)),
        pose_(pose),
        files_(model.files.size()),
        materials_(model.materials.size()),
        meshes_(model.meshes.size()),
        heightmaps_(model.heightmaps.size()),
        bodies_(model.bodies.size()),
        joints_(model.joints.size()) {}

  void append() {
    to_.files.insert(to_.files.end(), from_.files.begin(), from_.files.end());
    to_.meshes.insert(to_.meshes.end(), from_.meshes.begin(), from_.meshes.end());
    to_.heightmaps.insert(to_.heightmaps.end(), from_.heightmaps.begin(), from_.heightmaps.end());
    append_materials();
    append_assemblies();
    append_bodies();
    append_joints();
    append_devices();
    for (BodyPair pair : from_.no_collide) {
      to_.no_collide.emplace_back(shifted(pair.first, bodies_), shifted(pair.second, bodies_));
    }
  }

 private:
  // The new top-level assembly stands where the fragment's own index would be -1.
  int assembly(int index) const { return index < 0 ? root_ : index + root_ + 1; }

  template <class Element>
  Element renamed(Element element) const {
    element.name = prefix_ + element.name;
    element.origin.file = shifted(element.origin.file, files_);
    return element;
  }

  void append_materials() {
    for (Material material : from_.materials) {
      material.base = shifted(material.base, materials_);
      material.origin.file = shifted(material.origin.file, files_);
      to_.materials.push_back(std::move(material));
    }
    for (MaterialPair pair : from_.material_pairs) {
      pair.a = shifted(pair.a, materials_);
      pair.b = shifted(pair.b, materials_);
      to_.material_pairs.push_back(pair);
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

  void append_bodies() {
    for (const Body& original : from_.bodies) {
      Body body = renamed(original);
      body.X_WB = pose_ * original.X_WB;
      body.V_WB.linear = pose_.q * original.V_WB.linear;
      body.V_WB.angular = pose_.q * original.V_WB.angular;
      body.assembly = assembly(original.assembly);
      for (Shape& shape : body.shapes) {
        shape.name = prefix_ + shape.name;
        shape.mesh = shifted(shape.mesh, meshes_);
        shape.heightmap = shifted(shape.heightmap, heightmaps_);
        shape.material = shifted(shape.material, materials_);
        shape.origin.file = shifted(shape.origin.file, files_);
      }
      to_.bodies.push_back(std::move(body));
    }
    for (const NamedFrame& original : from_.frames) {
      NamedFrame frame = renamed(original);
      frame.body = shifted(original.body, bodies_);
      if (original.body == kWorld) frame.X_BF = pose_ * original.X_BF;
      frame.assembly = assembly(original.assembly);
      to_.frames.push_back(std::move(frame));
    }
  }

  void append_joints() {
    for (const Joint& original : from_.joints) {
      Joint joint = renamed(original);
      joint.parent = shifted(original.parent, bodies_);
      joint.child = shifted(original.child, bodies_);
      if (original.parent == kWorld) joint.X_PF = pose_ * original.X_PF;
      if (original.child == kWorld) joint.X_CM = pose_ * original.X_CM;
      joint.assembly = assembly(original.assembly);
      to_.joints.push_back(std::move(joint));
    }
  }

  void append_devices() {
    for (const Motor& original : from_.motors) {
      Motor motor = renamed(original);
      motor.joint = shifted(original.joint, joints_);
      motor.assembly = assembly(original.assembly);
      to_.motors.push_back(std::move(motor));
    }
    for (const SensorModel& original : from_.sensors) {
      SensorModel sensor = renamed(original);
      sensor.body = shifted(original.body, bodies_);
      sensor.joint = shifted(original.joint, joints_);
      if (original.body == kWorld) sensor.X_BS = pose_ * original.X_BS;
      sensor.assembly = assembly(original.assembly);
      to_.sensors.push_back(std::move(sensor));
    }
    for (const ControllerModel& original : from_.controllers) {
      ControllerModel controller = renamed(original);
      controller.assembly = assembly(original.assembly);
      to_.controllers.push_back(std::move(controller));
    }
  }

  SceneModel& to_;
  const SceneModel& from_;
  std::string prefix_;
  Pose pose_;
  std::size_t files_, materials_, meshes_, heightmaps_, bodies_, joints_;
  int root_ = -1;
};

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
  if (target < 0) {
    std::vector<std::string> names;
    for (const AssemblyInfo& info : model.assemblies) {
      if (!info.removed) names.push_back(info.name);
    }
    const std::string near = nearest_name(name, names);
    return fail("cannot remove assembly '" + name + "': there is none of that name", "",
                near.empty() ? "" : "did you mean '" + near + "'?");
  }
  auto next = std::make_shared<SceneModel>(model);
  std::vector<char> gone(model.assemblies.size(), 0);
  // Parents come before their children, so one pass finds all that lies inside.
  for (std::size_t i = 0; i < gone.size(); ++i) {
    const int parent = model.assemblies[i].parent;
    gone[i] =
        static_cast<int>(i) == target || (parent >= 0 && gone[static_cast<std::size_t>(parent)]);
    if (gone[i]) next->assemblies[i].removed = true;
  }
  const auto inside = [&gone](int assembly) {
    return assembly >= 0 && gone[static_cast<std::size_t>(assembly)];
  };
  const auto mark = [&inside](auto& elements) {
    for (auto& element : elements) element.removed = element.removed || inside(element.assembly);
  };
  mark(next->bodies);
  mark(next->frames);
  mark(next->joints);
  mark(next->motors);
  mark(next->sensors);
  mark(next->controllers);
  const auto body_gone = [&next](int body) {
    return body >= 0 && next->bodies[static_cast<std::size_t>(body)].removed;
  };
  for (Joint& joint : next->joints) {
    joint.removed = joint.removed || body_gone(joint.parent) || body_gone(joint.child);
  }
  const auto joint_gone = [&next](int joint) {
    return joint >= 0 && next->joints[static_cast<std::size_t>(joint)].removed;
  };
  for (Motor& motor : next->motors) motor.removed = motor.removed || joint_gone(motor.joint);
  for (SensorModel& sensor : next->sensors) {
    sensor.removed = sensor.removed || body_gone(sensor.body) || joint_gone(sensor.joint);
  }
  return SceneModelPtr(std::move(next));
}

}  // namespace cogrsim
