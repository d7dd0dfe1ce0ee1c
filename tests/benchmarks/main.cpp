// Each backend against a program on its bare engine: interleaved rounds, medians, ratios.
//
//     cogrsim_bench [--rounds 9] [--json]
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "bench.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/loader.h"

namespace {

using namespace cogrsim;
using namespace cogrsim::bench;

/// A backend's world with the motors at the scene's targets.
class BackendRunner final : public Runner {
 public:
  BackendRunner(const std::shared_ptr<const Backend>& backend, Scene scene)
      : backend_(backend), model_(model(scene)) {
    auto world = backend->create_world(model_);
    if (!world) {
      fmt::print(stderr, "{}\n", world.error().text());
      std::exit(1);
    }
    world_ = std::move(*world);
    for (const Motor& motor : model_->motors) {
      Drive drive;
      drive.kd = std::numeric_limits<double>::infinity();
      drive.velocity = motor.target.value_or(0.0);
      drive.max_effort = motor.max_effort;
      drives_.push_back(drive);
    }
  }
  void step() override {
    if (world_->step(kStep, drives_).status != StepStatus::ok) {
      fmt::print(stderr, "{}: {} diverged\n", backend_->name(), model_->name);
      std::exit(1);
    }
  }
  double last_height() override {
    world_->get_state(state_);
    return state_.poses.back().p.z();
  }

 private:
  std::shared_ptr<const Backend> backend_;
  SceneModelPtr model_;
  std::unique_ptr<World> world_;
  std::vector<Drive> drives_;
  WorldState state_;
};

double microseconds_per_step(Runner& runner, int steps) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  for (int i = 0; i < steps; ++i) runner.step();
  const std::chrono::duration<double, std::micro> passed = Clock::now() - start;
  return passed.count() / steps;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

int main(int argc, char** argv) {
  int rounds = 9;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0) {
      json = true;
    } else if (std::strcmp(argv[i], "--rounds") == 0 && i + 1 < argc &&
               std::atoi(argv[i + 1]) > 0) {
      rounds = std::atoi(argv[++i]);
    } else {
      fmt::print(stderr, "usage: {} [--rounds N] [--json]\n", argv[0]);
      return 2;
    }
  }
  constexpr int kWarmUp = 300, kSteps = 100;
  PluginLoader loader;
  nlohmann::json rows = nlohmann::json::array();
  if (!json) {
    fmt::print("{:<9} {:<22} {:>11} {:>11} {:>7}   {}\n", "engine", "scene", "raw us/step",
               "backend", "ratio", "height of the last body, raw and backend [m]");
  }
  for (const char* engine : {"bullet", "simbody"}) {
    const auto backend = loader.backend(engine);
    if (!backend) {
      fmt::print(stderr, "{}\n", backend.error().text());
      return 1;
    }
    for (const Scene scene : kScenes) {
      const std::unique_ptr<Runner> raw =
          std::strcmp(engine, "bullet") == 0 ? make_raw_bullet(scene) : make_raw_simbody(scene);
      BackendRunner ours(*backend, scene);
      microseconds_per_step(*raw, kWarmUp);
      microseconds_per_step(ours, kWarmUp);
      // Ratios of neighbouring rounds: whatever else the machine does hits both sides.
      std::vector<double> raw_times, our_times, ratios;
      for (int round = 0; round < rounds; ++round) {
        raw_times.push_back(microseconds_per_step(*raw, kSteps));
        our_times.push_back(microseconds_per_step(ours, kSteps));
        ratios.push_back(our_times.back() / raw_times.back());
      }
      const double heights[] = {raw->last_height(), ours.last_height()};
      if (json) {
        rows.push_back({{"engine", engine},
                        {"scene", title(scene)},
                        {"raw_us_per_step", median(raw_times)},
                        {"backend_us_per_step", median(our_times)},
                        {"ratio", median(ratios)},
                        {"heights", {heights[0], heights[1]}}});
      } else {
        fmt::print("{:<9} {:<22} {:>11.1f} {:>11.1f} {:>7.2f}   {:.4f}  {:.4f}\n", engine,
                   title(scene), median(raw_times), median(our_times), median(ratios), heights[0],
                   heights[1]);
      }
    }
  }
  if (json) fmt::print("{}\n", rows.dump(2));
  return 0;
}
