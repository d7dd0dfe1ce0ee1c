#include "cogrsim/model/builder.h"

#include <cassert>
#include <utility>

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim {
namespace {

int index_of_last(std::size_t count) { return static_cast<int>(count) - 1; }

MassProperties mass_of(const Body& body) { return {body.mass, body.com, body.inertia}; }

void set_mass(Body& body, const MassProperties& properties) {
  body.mass = properties.mass;
  body.com = properties.com;
  body.inertia = properties.inertia;
}

/// An error that the scene compiler would report is a bug here, because a program caused it.
MassProperties mass_or_assert(const Shape& shape, const SceneModel& model, double mass) {
  const Result<MassProperties> properties = shape_mass(shape, model.meshes, mass);
  assert(properties && "this shape cannot have a mass");
  return *properties;
}

}  // namespace

ModelBuilder::ModelBuilder(std::string name) {
  model.name = std::move(name);
  Material standard;
  standard.name = "default";
  model.materials.push_back(standard);
}

int ModelBuilder::material(const std::string& name, double friction, double restitution) {
  Material made;
  made.name = name;
  made.friction = friction;
  made.restitution = restitution;
  model.materials.push_back(made);
  return index_of_last(model.materials.size());
}

int ModelBuilder::add_body(const std::string& name, Shape shape, double mass, const Pose& X_WB) {
  assert(mass >= 0.0);
  Body body;
  body.name = name;
  body.X_WB = X_WB;
  shape.name = name + ".shape";
  if (mass > 0.0) {
    set_mass(body, mass_or_assert(shape, model, mass));
  } else {
    body.kind = BodyKind::static_body;
  }
  body.shapes.push_back(std::move(shape));
  model.bodies.push_back(std::move(body));
  return index_of_last(model.bodies.size());
}

int ModelBuilder::box(const std::string& name, const Vec3& size, double mass, const Pose& X_WB,
                      int material) {
  Shape shape;
  shape.type = ShapeType::box;
  shape.size = size;
  shape.material = material;
  return add_body(name, shape, mass, X_WB);
}

int ModelBuilder::sphere(const std::string& name, double radius, double mass, const Pose& X_WB,
                         int material) {
  Shape shape;
  shape.type = ShapeType::sphere;
  shape.radius = radius;
  shape.material = material;
  return add_body(name, shape, mass, X_WB);
}

int ModelBuilder::cylinder(const std::string& name, double radius, double length, double mass,
                           const Pose& X_WB, int material) {
  Shape shape;
  shape.type = ShapeType::cylinder;
  shape.radius = radius;
  shape.length = length;
  shape.material = material;
  return add_body(name, shape, mass, X_WB);
}

int ModelBuilder::capsule(const std::string& name, double radius, double length, double mass,
                          const Pose& X_WB, int material) {
  Shape shape;
  shape.type = ShapeType::capsule;
  shape.radius = radius;
  shape.length = length;
  shape.material = material;
  return add_body(name, shape, mass, X_WB);
}

int ModelBuilder::plane(const std::string& name, const Pose& X_WB, int material) {
  Shape shape;
  shape.type = ShapeType::plane;
  shape.material = material;
  return add_body(name, shape, 0.0, X_WB);
}

int ModelBuilder::mesh(const std::string& name, TriangleMesh mesh, bool convex, double mass,
                       const Pose& X_WB, int material) {
  assert((convex || mass == 0.0) && "a body that collides as triangles must be static");
  model.meshes.push_back(std::make_shared<const TriangleMesh>(std::move(mesh)));
  Shape shape;
  shape.type = convex ? ShapeType::convex_mesh : ShapeType::mesh;
  shape.mesh = index_of_last(model.meshes.size());
  shape.material = material;
  return add_body(name, shape, mass, X_WB);
}

int ModelBuilder::heightmap(const std::string& name, HeightGrid grid, const Pose& X_WB,
                            int material) {
  assert(grid.columns >= 2 && grid.rows >= 2);
  assert(grid.heights.size() ==
         static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
  model.heightmaps.push_back(std::make_shared<const HeightGrid>(std::move(grid)));
  Shape shape;
  shape.type = ShapeType::heightmap;
  shape.heightmap = index_of_last(model.heightmaps.size());
  shape.material = material;
  return add_body(name, shape, 0.0, X_WB);
}

int ModelBuilder::body(const std::string& name, double mass, const Mat3& inertia,
                       const Pose& X_WB) {
  assert(mass == 0.0 || check_mass_properties(mass, inertia));
  Body made;
  made.name = name;
  made.X_WB = X_WB;
  made.kind = mass > 0.0 ? BodyKind::dynamic : BodyKind::static_body;
  if (mass > 0.0) set_mass(made, {mass, Vec3::Zero(), inertia});
  model.bodies.push_back(std::move(made));
  return index_of_last(model.bodies.size());
}

void ModelBuilder::add_shape(int body, Shape shape, double mass) {
  Body& owner = model.bodies.at(body);
  assert(mass == 0.0 || owner.kind == BodyKind::dynamic);
  if (shape.name.empty()) {
    shape.name = owner.name + ".shape_" + std::to_string(owner.shapes.size() + 1);
  }
  if (mass > 0.0) set_mass(owner, combine({mass_of(owner), mass_or_assert(shape, model, mass)}));
  owner.shapes.push_back(std::move(shape));
}

int ModelBuilder::joint(const std::string& name, JointType type, int parent, int child,
                        const Pose& X_WJ) {
  assert(parent != child);
  const auto in_body = [&](int body) {
    if (body == kWorld) return X_WJ;
    return model.bodies.at(body).X_WB.inverse() * X_WJ;
  };
  Joint made;
  made.name = name;
  made.type = type;
  made.parent = parent;
  made.child = child;
  made.X_PF = in_body(parent);
  made.X_CM = in_body(child);
  const int axes = type == JointType::ball ? 1 : type == JointType::free ? 0 : speed_count(type);
  made.axes.resize(axes);
  model.joints.push_back(std::move(made));
  return index_of_last(model.joints.size());
}

int ModelBuilder::motor(const std::string& name, int joint, MotorMode mode, int axis) {
  const Joint& driven = model.joints.at(joint);
  assert(axis >= 0 && static_cast<std::size_t>(axis) < driven.axes.size());
  Motor made;
  made.name = name;
  made.joint = joint;
  made.axis = axis;
  made.mode = mode;
  made.assembly = driven.assembly;
  model.motors.push_back(std::move(made));
  return index_of_last(model.motors.size());
}

int ModelBuilder::assembly(const std::string& name, const std::vector<int>& bodies,
                           const std::vector<int>& joints) {
  AssemblyInfo made;
  made.name = name;
  if (!bodies.empty()) made.X_WA = model.bodies.at(bodies[0]).X_WB;
  model.assemblies.push_back(std::move(made));
  const int index = index_of_last(model.assemblies.size());
  for (int body : bodies) model.bodies.at(body).assembly = index;
  for (int joint : joints) {
    model.joints.at(joint).assembly = index;
    for (Motor& motor : model.motors) {
      if (motor.joint == joint) motor.assembly = index;
    }
  }
  return index;
}

SceneModelPtr ModelBuilder::build() {
  // Coordinates that were not set follow from the poses of the bodies, which may have changed
  // since.
  const auto pose = [this](int body) {
    return body == kWorld ? Pose{} : model.bodies.at(body).X_WB;
  };
  const auto twist = [this](int body) {
    return body == kWorld ? Twist{} : model.bodies.at(body).V_WB;
  };
  for (Joint& joint : model.joints) {
    const Pose X_WP = pose(joint.parent), X_WC = pose(joint.child);
    const Pose X_FM = relative_pose(joint, X_WP, X_WC);
    if (joint.position.empty()) {
      joint.position.resize(position_count(joint.type));
      joint_position(joint, X_FM, nullptr, joint.position.data());
    }
    if (joint.velocity.empty()) {
      joint.velocity.resize(speed_count(joint.type));
      const Twist V_FM = relative_twist(joint, X_WP, twist(joint.parent), X_WC, twist(joint.child));
      joint_velocity(joint, X_FM, V_FM, joint.position.data(), joint.velocity.data());
    }
  }
  mark_loops(model);
  finish_model(model);
  return std::make_shared<const SceneModel>(std::move(model));
}

Quat z_to(const Vec3& axis) {
  const double length = axis.norm();
  assert(length > 0.0);
  const Vec3 a = axis / length;
  // Half-way quaternion (1 + z.a, z x a), normalised; it vanishes when the axis points down.
  const Quat q(1 + a.z(), -a.y(), a.x(), 0);
  return q.norm() > 1e-9 ? Quat(q.normalized()) : Quat(0, 1, 0, 0);
}

}  // namespace cogrsim
