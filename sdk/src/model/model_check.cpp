// Consistency check of a model that was read from a file.
#include <algorithm>

#include <fmt/format.h>

#include "model/model_json.h"

namespace cogrsim {

namespace {

class Checker {
 public:
  explicit Checker(const SceneModel& model) : model_(model) {}

  // The first problem; empty: none.
  std::string problem(bool with_matter) {
    if (with_matter) matter();
    materials();
    bodies();
    joints();
    couplings();
    devices();
    regions_and_mazes();
    for (const BodyPair& pair : model_.no_collide) {
      index(pair.first, model_.bodies, 0, "no_collide", "body");
      index(pair.second, model_.bodies, 0, "no_collide", "body");
    }
    return problem_;
  }

 private:
  void note(const std::string& name, const char* what) {
    if (problem_.empty()) problem_ = fmt::format("'{}' has a wrong {}", name, what);
  }
  template <class Elements>
  void index(int i, const Elements& elements, int least, const std::string& name,
             const char* what) {
    if (i < least || i >= static_cast<int>(elements.size())) note(name, what);
  }

  void materials() {
    for (const Material& m : model_.materials) index(m.base, model_.materials, -1, m.name, "base");
    for (const MaterialPair& pair : model_.material_pairs) {
      index(pair.a, model_.materials, 0, "material pair", "material");
      index(pair.b, model_.materials, 0, "material pair", "material");
    }
  }

  void matter() {
    for (const MeshPtr& mesh : model_.meshes) {
      if (mesh == nullptr) return note("scene", "mesh");
      const int count = static_cast<int>(mesh->vertices.size());
      for (const Eigen::Vector3i& t : mesh->triangles) {
        if (t.minCoeff() < 0 || t.maxCoeff() >= count) note(mesh->name, "vertex");
      }
      if (!mesh->uv.empty() && mesh->uv.size() != 3 * mesh->triangles.size())
        note(mesh->name, "uv");
    }
    for (const HeightGridPtr& grid : model_.heightmaps) {
      if (grid == nullptr) return note("scene", "heightmap");
      if (grid->columns < 2 || grid->rows < 2 ||
          static_cast<std::size_t>(grid->columns) * static_cast<std::size_t>(grid->rows) !=
              grid->heights.size()) {
        note(grid->name, "size");
      }
    }
  }

  void bodies() {
    for (std::size_t i = 0; i < model_.assemblies.size(); ++i) {
      const AssemblyInfo& info = model_.assemblies[i];
      // Parents must precede their children, which excludes cycles.
      if (info.parent < -1 || info.parent >= static_cast<int>(i)) note(info.name, "parent");
    }
    for (const Body& body : model_.bodies) {
      index(body.assembly, model_.assemblies, -1, body.name, "assembly");
      for (const Shape& shape : body.shapes) {
        const bool meshed = shape.type == ShapeType::mesh || shape.type == ShapeType::convex_mesh;
        index(shape.mesh, model_.meshes, meshed ? 0 : -1, shape.name, "mesh");
        index(shape.heightmap, model_.heightmaps, shape.type == ShapeType::heightmap ? 0 : -1,
              shape.name, "heightmap");
        index(shape.material, model_.materials, 0, shape.name, "material");
      }
    }
    for (const NamedFrame& frame : model_.frames) {
      index(frame.body, model_.bodies, -1, frame.name, "body");
      index(frame.assembly, model_.assemblies, -1, frame.name, "assembly");
    }
  }

  void joints() {
    if (model_.joint_positions < 0 || model_.joint_speeds < 0) note("scene", "number of axes");
    for (const Joint& joint : model_.joints) {
      index(joint.parent, model_.bodies, -1, joint.name, "parent");
      index(joint.child, model_.bodies, -1, joint.name, "child");
      index(joint.assembly, model_.assemblies, -1, joint.name, "assembly");
      const int q = position_count(joint.type), u = speed_count(joint.type);
      if (joint.position_offset < 0 || joint.position_offset > model_.joint_positions - q ||
          joint.speed_offset < 0 || joint.speed_offset > model_.joint_speeds - u ||
          static_cast<int>(joint.position.size()) != q ||
          static_cast<int>(joint.velocity.size()) != u) {
        note(joint.name, "offset in the state");
      }
      const std::size_t axes = joint.type == JointType::ball   ? 1
                               : joint.type == JointType::free ? 0
                                                               : static_cast<std::size_t>(u);
      if (joint.axes.size() != axes) note(joint.name, "number of axes");
    }
  }

  void couplings() {
    for (const Coupling& coupling : model_.couplings) {
      index(coupling.assembly, model_.assemblies, -1, coupling.name, "assembly");
      const auto check = [&](int joint) {
        index(joint, model_.joints, 0, coupling.name, "joint");
        if (problem_.empty() && model_.joints[joint].axes.size() != 1) note(coupling.name, "joint");
      };
      check(coupling.joint);
      for (const CouplingTerm& term : coupling.terms) check(term.joint);
      if (coupling.terms.empty()) note(coupling.name, "number of terms");
    }
  }

  void devices() {
    for (const Motor& motor : model_.motors) {
      index(motor.joint, model_.joints, 0, motor.name, "joint");
      index(motor.assembly, model_.assemblies, -1, motor.name, "assembly");
      if (!problem_.empty()) return;
      const Joint& joint = model_.joints[motor.joint];
      if (motor.axis < 0 || motor.axis >= static_cast<int>(joint.axes.size())) {
        note(motor.name, "axis");
      }
    }
    for (const ForceModel& force : model_.forces) {
      index(force.body, model_.bodies, -1, force.name, "body");
      index(force.other, model_.bodies, -1, force.name, "body");
      index(force.assembly, model_.assemblies, -1, force.name, "assembly");
    }
    for (const SensorModel& sensor : model_.sensors) {
      index(sensor.body, model_.bodies, -1, sensor.name, "body");
      index(sensor.joint, model_.joints, -1, sensor.name, "joint");
      index(sensor.assembly, model_.assemblies, -1, sensor.name, "assembly");
    }
    for (const ControllerModel& controller : model_.controllers) {
      index(controller.assembly, model_.assemblies, -1, controller.name, "assembly");
    }
    for (const ControllerModel& controller : model_.supervisors) {
      index(controller.assembly, model_.assemblies, -1, controller.name, "assembly");
    }
  }

  void regions_and_mazes() {
    for (const RegionModel& region : model_.regions) {
      index(region.body, model_.bodies, -1, region.name, "body");
      index(region.assembly, model_.assemblies, -1, region.name, "assembly");
    }
    for (const DoorModel& door : model_.doors) {
      index(door.motor, model_.motors, 0, door.name, "motor");
      index(door.assembly, model_.assemblies, -1, door.name, "assembly");
    }
    for (const MazeModel& maze : model_.mazes) {
      const auto rows = static_cast<std::int64_t>(maze.rows);
      const auto columns = static_cast<std::int64_t>(maze.columns);
      if (rows < 1 || columns < 1 ||
          static_cast<std::int64_t>(maze.vertical.size()) != rows * (columns + 1) ||
          static_cast<std::int64_t>(maze.horizontal.size()) != (rows + 1) * columns) {
        note(maze.name, "size");
      }
      for (const std::vector<int>* sides : {&maze.vertical, &maze.horizontal}) {
        for (const int side : *sides)
          index(side, model_.doors, MazeModel::kWall, maze.name, "door");
      }
      for (const MazeModel::NamedCell& cell : maze.named_cells) {
        if (cell.row < 0 || cell.row >= maze.rows || cell.column < 0 ||
            cell.column >= maze.columns) {
          note(maze.name, "named cell");
        }
      }
    }
  }

  const SceneModel& model_;
  std::string problem_;
};

}  // namespace

Result<> check_model(const SceneModel& model) {
  const std::string problem = Checker(model).problem(true);
  return problem.empty() ? Result<>() : fail(problem);
}

Result<> check_references(const SceneModel& model) {
  const std::string problem = Checker(model).problem(false);
  return problem.empty() ? Result<>() : fail(problem);
}

}  // namespace cogrsim
