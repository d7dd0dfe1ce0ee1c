// Sensors that controllers switch, in the simulation's process and in their own.
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("a late sensor that is switched off and on in one call loses what was on its way",
          "[containment][delay]") {
  // The second time there is no valid reading, and one is on its way.
  const int at = GENERATE(1, 8);
  std::vector<std::vector<double>> seen[2];
  for (const bool own : {false, true}) {
    ControllerModel controller;
    controller.plugin = "blinker";
    controller.rate = 100.0;
    controller.isolation = own ? Isolation::process : Isolation::none;
    controller.parameters["at"] = at;
    SensorModel encoder;
    encoder.type = "encoder";
    encoder.rate = 200.0;
    encoder.latency = 0.05;
    BareFlywheel robot;
    encoder.joint = robot.joint;
    robot.add_sensor("bot.encoder", encoder);
    robot.add_controller(controller);
    auto simulation = simulate(robot.builder.build(), "bullet");
    double latest = -1.0;
    bool back = false;
    for (int i = 0; i < 200; ++i) {
      simulation->step();
      const Reading& reading = simulation->reading(0);
      seen[own].push_back(
          {reading.valid ? reading.time : -1.0, static_cast<double>(reading.sequence)});
      back = back || (latest >= 0.0 && !reading.valid);
      if (reading.valid) latest = reading.time;
    }
    INFO(messages_of(*simulation));
    CHECK(messages_of(*simulation).empty());
    CHECK(latest > 0.1);
    CHECK(back);
  }
  CHECK(seen[0] == seen[1]);
}
