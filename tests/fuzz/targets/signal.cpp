#include <cmath>

#include "cogrsim/model/builder.h"
#include "cogrsim/signals/condition.h"
#include "targets.h"

namespace cogrsim::fuzz {
namespace {

struct World {
  SceneModelPtr model;
  Frame frame;

  World() {
    ModelBuilder builder("signals");
    const int chassis = builder.box("bot.chassis", Vec3(1, 1, 1), 2.0, {});
    const int wheel = builder.sphere("bot.wheel", 0.5, 1.0, {Vec3(3, 0, 2), Quat(1, 0, 0, 0)});
    builder.plane("floor");
    builder.capsule("peg", 0.1, 0.4, 1.0, {Vec3(0, 2, 1), Quat(1, 0, 0, 0)});
    const int axle = builder.joint("bot.axle", JointType::hinge, chassis, wheel, {});
    builder.motor("bot.motor", axle, MotorMode::velocity);
    builder.assembly("bot", {chassis, wheel}, {axle});
    SensorModel sensor;
    sensor.name = "bot.eye";
    sensor.type = "pose";
    sensor.body = chassis;
    builder.model.sensors.push_back(sensor);
    RegionModel region;
    region.name = "goal";
    builder.model.regions.push_back(region);
    model = builder.build();
    frame.model = model;
    for (const Body& body : model->bodies) frame.state.poses.push_back(body.X_WB);
    frame.state.twists.resize(model->bodies.size());
    frame.state.joint_positions.assign(static_cast<std::size_t>(model->joint_positions), 0.5);
    frame.state.joint_velocities.assign(static_cast<std::size_t>(model->joint_speeds), 0.25);
    frame.state.joint_efforts.assign(static_cast<std::size_t>(model->joint_speeds), 0.125);
    frame.state.motor_efforts.assign(model->motors.size(), 1.5);
    frame.time = 2.0;
  }
};

}  // namespace

void signal(std::string_view input) {
  static const World world;
  const std::string text(input);
  const SignalScope scope{*world.model, built_in_channels(*world.model), {}};
  if (const auto condition = Condition::parse(scope, text)) {
    const Truth truth = condition->evaluate(world.frame);
    const auto again = Condition::parse(scope, condition->text());
    // Full names are longer than short ones, so a text near the limit may not come back.
    require(again || condition->text().size() > 4096, "a condition's text is a condition");
    require(!again || again->text() == condition->text(), "a condition's text stays as it is");
    require(!again || again->evaluate(world.frame) == truth, "it means the same");
  }
  if (const auto signal = Signal::parse(scope, text)) {
    const double value = signal->evaluate(world.frame);
    const auto again = Signal::parse(scope, signal->text());
    require(again || signal->text().size() > 4096, "a signal's text is a signal");
    if (!again) return;
    const double same = again->evaluate(world.frame);
    require(value == same || (std::isnan(value) && std::isnan(same)), "it means the same");
    require(again->unit() == signal->unit(), "it has the same unit");
  }
}

}  // namespace cogrsim::fuzz
