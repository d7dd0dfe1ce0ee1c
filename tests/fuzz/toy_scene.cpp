#include "toy_scene.h"

#include <cstdio>

#include "cogrsim/dsl/compiler.h"
#include "targets.h"

namespace cogrsim::fuzz {

const char* const kToyScene = R"xml(<scene name="toy" version="1">
  <physics step="10 ms" backend="toy"/>
  <material name="rubber" friction="0.9"/>
  <plane name="floor"/>
  <assembly name="bot" xyz="0 0 1 m">
    <box name="chassis" size="0.2 0.1 0.05 m" mass="1 kg" material="rubber"/>
    <pose name="where" on="chassis" rate="50 Hz"/>
    <imu name="imu" on="chassis" noise="normal(0, 0.01 m/s^2)"/>
  </assembly>
  <sphere name="ball" radius="5 cm" mass="0.2 kg" xyz="1 0 2 m" linear-velocity="0.5 0 1 m/s"/>
  <region name="goal" size="1 1 1 m" xyz="1 0 0 m"/>
  <plot name="height" y="ball.z"/>
</scene>)xml";

SceneModelPtr toy_scene() {
  static const SceneModelPtr model = [] {
    const dsl::CompileResult compiled = dsl::compile_text(kToyScene, "toy.scene.xml");
    if (!compiled.ok()) std::fputs(dsl::to_text(compiled.diagnostics).c_str(), stderr);
    require(compiled.ok(), "the toy scene compiles");
    return compiled.model;
  }();
  return model;
}

std::shared_ptr<PluginLoader> toy_loader() {
  static const auto loader =
      std::make_shared<PluginLoader>(std::vector<std::string>{COGRSIM_FUZZ_TOYS});
  return loader;
}

}  // namespace cogrsim::fuzz
