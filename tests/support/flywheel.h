// A small robot for testing controllers; without Catch2, so that other programs can use it, too.
#pragma once

#include <string>
#include <utility>

#include "cogrsim/model/builder.h"

namespace cogrsim::test {

/// A flywheel (I = 0.02 kg m^2 about its axle) in a robot "bot", with a motor "left"; no gravity. The
/// builder can still be changed.
struct BareFlywheel {
  static constexpr double kInertia = 0.02;
  ModelBuilder builder{"flywheel"};
  int assembly = -1, wheel = -1, joint = -1, motor = -1;

  explicit BareFlywheel(MotorMode mode = MotorMode::velocity) {
    builder.model.physics.gravity = Vec3::Zero();
    wheel = builder.body("bot.wheel", 1.0, Vec3(kInertia, kInertia, kInertia).asDiagonal(), Pose{});
    joint = builder.joint("bot.axle", JointType::hinge, kWorld, wheel, Pose{});
    assembly = builder.assembly("bot", {wheel}, {joint});
    motor = builder.motor("bot.left", joint, mode);
    builder.model.motors[0].assembly = assembly;
  }

  void add_sensor(const std::string& name, SensorModel sensor) {
    sensor.name = name;
    sensor.assembly = assembly;
    builder.model.sensors.push_back(std::move(sensor));
  }

  /// As "bot.driver".
  void add_controller(ControllerModel controller) {
    controller.name = "bot.driver";
    controller.assembly = assembly;
    builder.model.controllers.push_back(std::move(controller));
  }
};

}  // namespace cogrsim::test
