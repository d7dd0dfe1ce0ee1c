#include <cmath>

#include "bench.h"
#include "cogrsim/model/builder.h"

namespace cogrsim::bench {

const char* title(Scene scene) {
  switch (scene) {
    case Scene::free_boxes:
      return "200 free boxes";
    case Scene::pyramid:
      return "210-box pyramid";
    case Scene::robots:
      return "100 two-wheel robots";
    case Scene::chain:
      return "30-link chain";
  }
  return "";
}

std::vector<Vec3> pyramid::centres() {
  std::vector<Vec3> out;
  for (int row = 0; row < kBase; ++row) {
    const int count = kBase - row;
    for (int i = 0; i < count; ++i) {
      out.emplace_back((i - 0.5 * (count - 1)) * kPitch, 0.0, (row + 0.5) * kSize);
    }
  }
  return out;
}

namespace {

Pose at(double x, double y, double z) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }

void add_boxes(ModelBuilder& builder) {
  using namespace boxes;
  for (int i = 0; i < kCount; ++i) {
    const int body = builder.box("box" + std::to_string(i), Vec3(kSize, 2 * kSize, 3 * kSize),
                                 kMass, at((i % kPerRow) * kPitch, (i / kPerRow) * kPitch, 1000.0));
    builder.model.bodies[static_cast<std::size_t>(body)].V_WB.angular = Vec3(0.1, kSpin, 0.1);
  }
}

void add_pyramid(ModelBuilder& builder) {
  using namespace pyramid;
  const int wood = builder.material("wood", kFriction);
  builder.box("ground", Vec3(100, 100, 2), 0.0, at(0, 0, -1), wood);
  int count = 0;
  for (const Vec3& centre : centres()) {
    builder.box("box" + std::to_string(count++), Vec3::Constant(kSize), kMass,
                Pose(centre, Quat(1, 0, 0, 0)), wood);
  }
}

void add_robot(ModelBuilder& builder, int index, int rubber, int slick) {
  using namespace robots;
  const std::string name = "robot" + std::to_string(index);
  const double x = (index / kPerSide) * kSpacing, y = (index % kPerSide) * kSpacing;
  const int chassis = builder.box(name + ".chassis", Vec3(kChassisX, kChassisY, kChassisZ),
                                  kChassisMass, at(x, y, kHeight), slick);
  Shape caster;
  caster.name = name + ".caster";
  caster.type = ShapeType::sphere;
  caster.radius = kCasterRadius;
  caster.material = slick;
  caster.X_BS.p = Vec3(kCasterX, 0, kCasterRadius - kHeight);
  builder.add_shape(chassis, caster, 0.0);
  std::vector<int> bodies{chassis}, joints;
  for (const int side : {1, -1}) {
    const std::string which = side > 0 ? "left" : "right";
    const Pose X_WB(Vec3(x + kAxleX, y + side * kHalfTrack, kWheelRadius), z_to(Vec3::UnitY()));
    const int wheel = builder.cylinder(name + ".wheel_" + which, kWheelRadius, kWheelWidth,
                                       kWheelMass, X_WB, rubber);
    const int axle = builder.joint(name + ".axle_" + which, JointType::hinge, chassis, wheel, X_WB);
    const int motor = builder.motor(name + "." + which, axle, MotorMode::velocity);
    Motor& m = builder.model.motors[static_cast<std::size_t>(motor)];
    m.target = side > 0 ? kLeftSpeed : kRightSpeed;
    m.max_effort = kMaxTorque;
    bodies.push_back(wheel);
    joints.push_back(axle);
  }
  builder.assembly(name, bodies, joints);
}

void add_robots(ModelBuilder& builder) {
  using namespace robots;
  const int floor = builder.material("floor", 1.0);
  const int rubber = builder.material("rubber", kFriction * kFriction);  // sqrt(1 * 0.64) = 0.8
  const int slick = builder.material("slick", 0.0);
  builder.plane("ground", Pose{}, floor);
  for (int i = 0; i < kPerSide * kPerSide; ++i) add_robot(builder, i, rubber, slick);
}

void add_chain(ModelBuilder& builder) {
  using namespace chain;
  const Vec3 along(-std::sin(kTilt), 0, -std::cos(kTilt));
  const Quat tilt(Eigen::AngleAxisd(kTilt, Vec3::UnitY()));
  std::vector<int> bodies, joints;
  for (int i = 0; i < kLinks; ++i) {
    const std::string name = "chain.link" + std::to_string(i);
    const int body = builder.box(name, Vec3(kWidth, kWidth, kLength), kMass,
                                 Pose(kLength * (i + 0.5) * along, tilt));
    const Pose X_WJ(kLength * i * along, z_to(Vec3::UnitY()));
    joints.push_back(builder.joint(name + "_hinge", JointType::hinge,
                                   i == 0 ? kWorld : bodies.back(), body, X_WJ));
    bodies.push_back(body);
  }
  builder.assembly("chain", bodies, joints);
  // Links do not collide with each other: the bare programs have no collision at all here.
  for (Body& body : builder.model.bodies) {
    for (Shape& shape : body.shapes) shape.collides = false;
  }
}

}  // namespace

SceneModelPtr model(Scene scene) {
  ModelBuilder builder(title(scene));
  builder.model.physics.step = kStep;
  switch (scene) {
    case Scene::free_boxes:
      add_boxes(builder);
      break;
    case Scene::pyramid:
      add_pyramid(builder);
      break;
    case Scene::robots:
      add_robots(builder);
      break;
    case Scene::chain:
      add_chain(builder);
      break;
  }
  return builder.build();
}

}  // namespace cogrsim::bench
