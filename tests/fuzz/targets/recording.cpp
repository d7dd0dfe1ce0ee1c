#include "cogrsim/recording/recording.h"

#include "cogrsim/map/map.h"
#include "cogrsim/plugin/loader.h"
#include "targets.h"

namespace cogrsim::fuzz {

void recording(std::string_view input) {
  const MemoryFile file(input);
  const auto opened = Recording::open(file.path());
  if (!opened) {
    require(!opened.error().message.empty(), "a refusal has a reason");
    return;
  }
  Recording& run = **opened;
  require(run.info().frames == run.frame_count(), "frames are counted once");
  require(run.info().complete || !run.info().damage.empty(), "what is damaged says so");
  const std::size_t frames = run.frame_count();
  for (std::size_t i = 0; i < frames && i < 8; ++i) {
    require(run.index_at(run.time_of(i)) < frames, "a time has a frame");
    const auto frame = run.frame(i);
    if (!frame) continue;
    const SceneModel& model = *(*frame)->model;
    require((*frame)->state.poses.size() == model.bodies.size(), "every body has a pose");
    require((*frame)->state.twists.size() == model.bodies.size(), "every body has a twist");
    energy_of(model, (*frame)->state);
    if (i == 0) {
      MapOptions small;
      small.width = 64;
      static_cast<void>(map_picture(**frame, small, ".svg"));
    }
    for (std::size_t s = 0; s < model.sensors.size(); ++s) run.channels(static_cast<int>(s));
  }
  PluginLoader none;
  static_cast<void>(run.recompute(none, [](const Frame&) { return true; }));
}

}  // namespace cogrsim::fuzz
