// Plugins and engines that exist only in tests.
#pragma once

#include "cogrsim/dsl/compiler.h"

namespace dsl_test {

/// Controller "walker" (speed in m/s 0 to 2, side left or right, steps, label must be set),
/// supervisor "referee", sensor "sonar"; engine "tiny" with world option iterations and assembly
/// option formulation; a library "broken" that is refused.
class FakeCatalog final : public cogrsim::dsl::PluginCatalog {
 public:
  cogrsim::Result<cogrsim::ParameterTable> parameters(cogrsim::PluginKind kind,
                                                      const std::string& name) override {
    using namespace cogrsim;
    if (kind == PluginKind::controller && name == "walker") {
      return ParameterTable{parameter("speed", 0.2, "m/s", "cruising speed").range(0.0, 2.0),
                            parameter("side", "left", "wall to follow").one_of({"left", "right"}),
                            parameter("steps", 3, "how many"),
                            parameter("angle", 0.0, "rad", "heading"),
                            parameter("path", std::vector<double>{}, "m", "waypoints"),
                            parameter("loop", false, "again and again")};
    }
    if (kind == PluginKind::supervisor && name == "referee") return ParameterTable{};
    if (kind == PluginKind::sensor && name == "sonar") {
      return ParameterTable{parameter("reach", 1.0, "m", "how far").must_be_set()};
    }
    if (name == "walker" || name == "referee" || name == "sonar") {
      return fail("\"" + name + "\" is no " + to_string(kind), "", "", "CG0903");
    }
    if (name == "broken") {
      return fail("broken.so was refused: not a plugin", "", "", "CG0902");
    }
    return fail("there is no " + std::string(to_string(kind)) + " \"" + name + "\"", "",
                "available: walker, referee and sonar", "CG0901");
  }

  /// A sonar reads its "distance", up to its range.
  std::vector<cogrsim::Channel> channels(const cogrsim::SceneModel&,
                                         const cogrsim::SensorModel& sensor) override {
    if (sensor.type != "sonar") return {};
    return {{"distance", "m"}};
  }

  std::vector<std::string> names(cogrsim::PluginKind kind) override {
    switch (kind) {
      case cogrsim::PluginKind::backend:
        return {"tiny"};
      case cogrsim::PluginKind::controller:
        return {"walker"};
      case cogrsim::PluginKind::supervisor:
        return {"referee"};
      case cogrsim::PluginKind::sensor:
        return {"sonar"};
      case cogrsim::PluginKind::renderer:
        return {"softraster"};
      case cogrsim::PluginKind::algorithm:
        return {"a_star"};
    }
    return {};
  }

  cogrsim::Result<cogrsim::ParameterTable> world_options(const std::string&) override {
    return cogrsim::ParameterTable{cogrsim::parameter("iterations", 10, "of the solver")};
  }
  cogrsim::Result<cogrsim::ParameterTable> element_options(const std::string&,
                                                           std::string_view) override {
    return cogrsim::ParameterTable{
        cogrsim::parameter("formulation", "reduced", "how").one_of({"reduced", "maximal"})};
  }
};

}  // namespace dsl_test
