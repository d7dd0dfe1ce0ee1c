#include "model_of.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "cogrsim/model/builder.h"

namespace cogrsim::bench {

namespace {

Vec3 vector(const Triple& v) { return {v[0], v[1], v[2]}; }
Pose pose(const Triple& p, const Turn& q) { return {vector(p), Quat(q[0], q[1], q[2], q[3])}; }

Shape shape_of(const Part& part, int material) {
  Shape shape;
  shape.material = material;
  shape.X_BS.p = vector(part.at);
  switch (part.form) {
    case Form::box:
      shape.type = ShapeType::box;
      shape.size = vector(part.size);
      break;
    case Form::sphere:
      shape.type = ShapeType::sphere;
      shape.radius = part.size[0];
      break;
    case Form::cylinder:
      shape.type = ShapeType::cylinder;
      shape.radius = part.size[0];
      shape.length = part.size[1];
      break;
    case Form::capsule:
      shape.type = ShapeType::capsule;
      shape.radius = part.size[0];
      shape.length = part.size[1];
      break;
    case Form::plane:
      shape.type = ShapeType::plane;
      break;
  }
  return shape;
}

/// Moves `X_BJ.p` by a few last digits of the anchor, so that X_WB puts it exactly there, if any do.
void round_to(const Pose& X_WB, const Vec3& anchor, Pose& X_BJ) {
  constexpr int kMost = 20;
  const Vec3 p = X_BJ.p;
  if (X_WB * p == anchor) return;
  const double digit = 0.1 * std::numeric_limits<double>::epsilon() * anchor.norm();
  for (int x = -kMost; x <= kMost; ++x) {
    for (int y = -kMost; y <= kMost; ++y) {
      for (int z = -kMost; z <= kMost; ++z) {
        const Vec3 tried = p + digit * Vec3(x, y, z);
        if (X_WB * tried != anchor) continue;
        X_BJ.p = tried;
        return;
      }
    }
  }
}

class Translator {
 public:
  Translator(const Scene& scene, bool world_anchors)
      : scene_(scene), world_anchors_(world_anchors), builder_(scene.title) {
    builder_.model.physics.step = scene.step;
    builder_.model.physics.gravity = vector(scene.gravity);
    // As MuJoCo's manual advises for heaps; see raw_mujoco.cpp.
    const auto moving = std::count_if(scene.things.begin(), scene.things.end(),
                                      [](const Thing& thing) { return thing.mass > 0; });
    if (scene.hinges.empty() && moving > 100) {
      for (const char* const engine : {"mujoco", "mujoco3"})
        builder_.model.physics.engine_options[engine]["solver"] = std::string("CG");
    }
  }

  SceneModelPtr translate() {
    for (std::size_t i = 0; i < scene_.things.size(); ++i) add(i);
    for (const Hinge& hinge : scene_.hinges) add(hinge);
    keep_families_apart();
    add_assemblies();
    for (const Eye& eye : scene_.eyes) add(eye);
    return builder_.build();
  }

 private:
  void add(std::size_t index) {
    const Thing& thing = scene_.things[index];
    const std::string name = "t" + std::to_string(index);
    const int material = material_of(thing.friction, thing.restitution);
    const Pose X_WB = pose(thing.place, thing.turn);
    if (thing.mass == 0) {
      const Part& part = thing.parts.front();
      if (part.form == Form::plane) {
        builder_.plane(name, X_WB, material);
      } else {
        builder_.box(name, vector(part.size), 0.0, X_WB, material);
      }
      return;
    }
    const int body =
        builder_.body(name, thing.mass, vector(thing.moments).asDiagonal().toDenseMatrix(), X_WB);
    int count = 0;
    for (const Part& part : thing.parts) {
      Shape shape = shape_of(part, material);
      shape.name = fmt::format("{}.{}", name, count++);
      shape.collides = scene_.contact;
      builder_.add_shape(body, shape, 0.0);
    }
    builder_.model.bodies[body].V_WB = {vector(thing.velocity), vector(thing.spin)};
  }

  void add(const Hinge& hinge) {
    const Pose X_WJ(vector(hinge.anchor), z_to(vector(hinge.axis)));
    const std::string name = "j" + std::to_string(builder_.model.joints.size());
    const int parent = hinge.parent < 0 ? kWorld : hinge.parent;
    const int joint = builder_.joint(name, JointType::hinge, parent, hinge.child, X_WJ);
    Joint& held = builder_.model.joints[joint];
    for (const bool of_parent : {true, false}) {
      const int body = of_parent ? held.parent : held.child;
      Pose& X_BJ = of_parent ? held.X_PF : held.X_CM;
      if (!world_anchors_ || body == kWorld || X_BJ.p.isZero(0.0)) continue;
      round_to(builder_.model.bodies[body].X_WB, X_WJ.p, X_BJ);
    }
    if (!hinge.driven) return;
    const int motor = builder_.motor(name + ".motor", joint, MotorMode::velocity);
    Motor& made = builder_.model.motors[motor];
    made.target = hinge.speed;
    made.max_effort = hinge.max_torque;
  }

  void keep_families_apart() {
    for (std::size_t a = 0; a < scene_.things.size(); ++a) {
      for (std::size_t b = a + 1; b < scene_.things.size(); ++b) {
        const int family = scene_.things[a].family;
        if (family < 0 || scene_.things[b].family != family) continue;
        builder_.model.no_collide.emplace_back(static_cast<int>(a), static_cast<int>(b));
      }
    }
  }

  /// What hangs together is an assembly.
  void add_assemblies() {
    std::vector<int> root(scene_.things.size());
    for (std::size_t i = 0; i < root.size(); ++i) root[i] = static_cast<int>(i);
    std::vector<std::vector<int>> bodies(root.size()), joints(root.size());
    for (std::size_t j = 0; j < scene_.hinges.size(); ++j) {
      const Hinge& hinge = scene_.hinges[j];
      const auto child = static_cast<std::size_t>(hinge.child);
      if (hinge.parent >= 0) root[child] = root[hinge.parent];
      const auto of = static_cast<std::size_t>(root[child]);
      if (bodies[of].empty()) bodies[of].push_back(root[child]);
      if (root[child] != hinge.child) bodies[of].push_back(hinge.child);
      joints[of].push_back(static_cast<int>(j));
    }
    for (std::size_t i = 0; i < root.size(); ++i) {
      if (!joints[i].empty()) builder_.assembly("a" + std::to_string(i), bodies[i], joints[i]);
    }
  }

  void add(const Eye& eye) {
    SensorModel sensor;
    sensor.name = "eye" + std::to_string(builder_.model.sensors.size());
    sensor.type = "infrared";
    sensor.body = eye.thing;
    sensor.X_BS = {vector(eye.at), Quat::FromTwoVectors(Vec3::UnitX(), vector(eye.along))};
    sensor.rate = 1.0 / (scene_.eye_period * scene_.step);
    sensor.parameters = {{"range", std::vector<double>{0.0, scene_.eye_range}}};
    builder_.model.sensors.push_back(sensor);
  }

  int material_of(double friction, double restitution) {
    const auto [entry, is_new] = materials_.try_emplace({friction, restitution}, 0);
    if (is_new) {
      entry->second =
          builder_.material("m" + std::to_string(materials_.size()), friction, restitution);
    }
    return entry->second;
  }

  const Scene& scene_;
  const bool world_anchors_;
  ModelBuilder builder_;
  std::map<std::pair<double, double>, int> materials_;  ///< by friction and restitution
};

}  // namespace

SceneModelPtr model_of(const Scene& scene, bool world_anchors) {
  return Translator(scene, world_anchors).translate();
}

std::string scene_text(int count) {
  std::string out =
      "<scene name=\"many\" version=\"1\">\n<physics step=\"1 ms\"/>\n"
      "<material name=\"wood\" friction=\"0.6\"/>\n<plane name=\"ground\"/>\n";
  for (int i = 0; i < count; ++i) {
    out += fmt::format(
        "<box name=\"b{}\" size=\"20 20 20 cm\" mass=\"1 kg\" material=\"wood\" "
        "xyz=\"{} {} ${{10 cm}}\"/>\n",
        i, (i % 100) * 0.5, (i / 100) * 0.5);
  }
  for (int i = 1; i < count; i += 10) {
    out += fmt::format("<hinge name=\"h{0}\" parent=\"b{1}\" child=\"b{0}\" axis=\"0 0 1\"/>\n", i,
                       i - 1);
  }
  return out + "</scene>\n";
}

}  // namespace cogrsim::bench
