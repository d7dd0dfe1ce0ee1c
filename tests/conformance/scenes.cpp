#include "scenes.h"

namespace conformance {

TwoWheeler add_two_wheeler(ModelBuilder& builder, const std::string& name, const Pose& X_WR) {
  TwoWheeler robot;
  const int rubber = builder.material(name + ".rubber", 0.9);
  const int slick = builder.material(name + ".slick", 0.0);
  const double r = robot.radius, half = 0.5 * robot.track, ball = 0.03;
  robot.chassis =
      builder.box(name + ".chassis", Vec3(0.24, 0.14, 0.04), 1.2, X_WR * at(0.04, 0, r));
  Shape caster;
  caster.name = name + ".chassis.caster";
  caster.type = ShapeType::sphere;
  caster.radius = ball;
  caster.material = slick;
  caster.X_BS = at(0.08, 0, ball - r);
  builder.add_shape(robot.chassis, caster, 0.05);
  const Quat axle = z_to(Vec3::UnitY());  // turning about y drives along x
  const Pose X_RL(Vec3(0, half, r), axle), X_RR(Vec3(0, -half, r), axle);
  robot.left = builder.cylinder(name + ".left", r, 0.02, 0.15, X_WR * X_RL, rubber);
  robot.right = builder.cylinder(name + ".right", r, 0.02, 0.15, X_WR * X_RR, rubber);
  robot.left_axle =
      builder.joint(name + ".left_axle", JointType::hinge, robot.chassis, robot.left, X_WR * X_RL);
  robot.right_axle = builder.joint(name + ".right_axle", JointType::hinge, robot.chassis,
                                   robot.right, X_WR * X_RR);
  builder.motor(name + ".left_motor", robot.left_axle, MotorMode::velocity);
  builder.motor(name + ".right_motor", robot.right_axle, MotorMode::velocity);
  return robot;
}

Playground playground() {
  Playground place;
  ModelBuilder& builder = place.builder;
  builder.plane("floor");
  builder.box("lower", Vec3(0.3, 0.3, 0.2), 2.0, at(2, 0, 0.1));
  builder.box("upper", Vec3(0.2, 0.2, 0.2), 1.0, at(2.03, 0.02, 0.3));
  builder.sphere("ball", 0.1, 1.0, {Vec3(2.05, 0, 0.9), Quat(1, 0, 0, 0)});
  builder.capsule("capsule", 0.05, 0.2, 0.5, {Vec3(2, 1, 0.4), turn(Vec3(1, 1, 0), 0.7)});
  builder.cylinder("drum", 0.1, 0.2, 0.7, {Vec3(2.5, 1, 0.5), turn(Vec3(1, 0.2, 0), 1.1)});
  add_two_wheeler(builder, "robot", at(0, 0, 0));
  const int bob = builder.sphere("bob", 0.08, 1.0, at(-1, 0.5, 1.5));
  builder.joint("string", JointType::ball, kWorld, bob, at(-1, 0, 1.5));
  const int arm = builder.box("arm", Vec3(0.5, 0.05, 0.05), 0.8, at(-2.25, 0, 1));
  const int shoulder = builder.joint("shoulder", JointType::hinge, kWorld, arm,
                                     {Vec3(-2.5, 0, 1), z_to(Vec3::UnitY())});
  JointAxis& axis = builder.model.joints[shoulder].axes[0];
  axis.damping = 0.05;
  axis.friction = 0.02;
  builder.motor("servo", shoulder, MotorMode::servo);
  const int lift = builder.box("lift", Vec3(0.1, 0.1, 0.1), 1.0, at(-3, 1, 1));
  const int rail = builder.joint("rail", JointType::slider, kWorld, lift, at(-3, 1, 1));
  builder.model.joints[rail].axes[0].lower = -0.3;
  Drive servo;
  servo.kp = 20.0;
  servo.kd = 2.0;
  servo.position = -0.6;
  servo.max_effort = 5.0;
  place.drives = {speed_source(6.0, 0.6), speed_source(4.0, 0.6), servo};
  return place;
}

Chain add_chain(ModelBuilder& builder, const Pose& X_WC) {
  Chain chain;
  const double length = 0.5;
  for (int i = 0; i < 3; ++i) {
    chain.bars.push_back(builder.box("bar" + std::to_string(i), Vec3(length, 0.08, 0.08), 1.0,
                                     X_WC * at(length * (i + 0.5), 0, 0)));
  }
  for (int i = 0; i < 2; ++i) {
    // Hinges of different directions make it a spatial chain.
    const Vec3 axis = i == 0 ? Vec3::UnitZ() : Vec3::UnitY();
    chain.hinges.push_back(builder.joint("link" + std::to_string(i), JointType::hinge,
                                         chain.bars[i], chain.bars[static_cast<std::size_t>(i) + 1],
                                         X_WC * Pose(Vec3(length * (i + 1), 0, 0), z_to(axis))));
  }
  return chain;
}

}  // namespace conformance
