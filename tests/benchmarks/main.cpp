// Each backend against a program on its bare engine: interleaved rounds, medians, ratios.
//
//     cogrsim_bench [--rounds 9] [--json]
//     cogrsim_bench --allocations      who allocates memory in a step, after warm-up
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "allocations.h"
#include "bench.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/simulation/simulation.h"

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
  void step_and_look(std::vector<Contact>& contacts) {
    step();
    world_->get_state(state_);
    world_->get_contacts(contacts);
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

void print_allocations(const std::string& engine, Scene scene, const char* layer,
                       const AllocationReport& report, int steps) {
  fmt::print("{:<9} {:<22} {:<11} {:>10.2f} {:>10.2f}\n", engine, title(scene), layer,
             static_cast<double>(report.ours) / steps, static_cast<double>(report.engine) / steps);
  int shown = 0;
  for (const AllocationSite& site : report.sites) {
    if (!site.ours || shown++ == 5) continue;
    fmt::print("    {:.2f}/step, {:.0f} B each:\n", static_cast<double>(site.count) / steps,
               static_cast<double>(site.bytes) / static_cast<double>(site.count));
    for (std::size_t i = 0; i < std::min<std::size_t>(site.frames.size(), 8); ++i) {
      fmt::print("        {}\n", site.frames[i]);
    }
  }
}

int allocations() {
  constexpr int kWarmUp = 500, kSteps = 200;
  auto loader = std::make_shared<PluginLoader>();
  fmt::print("{:<9} {:<22} {:<11} {:>10} {:>10}   allocations per step\n", "engine", "scene",
             "layer", "ours", "engine");
  for (const char* engine : {"bullet", "simbody"}) {
    const auto backend = loader->backend(engine);
    if (!backend) {
      fmt::print(stderr, "{}\n", backend.error().text());
      return 1;
    }
    for (const Scene scene : kScenes) {
      {
        BackendRunner runner(*backend, scene);
        std::vector<Contact> contacts;
        for (int i = 0; i < kWarmUp; ++i) runner.step_and_look(contacts);
        start_counting_allocations();
        for (int i = 0; i < kSteps; ++i) runner.step_and_look(contacts);
        print_allocations(engine, scene, "world", stop_counting_allocations(), kSteps);
      }
      SimulationOptions options;
      options.backend = engine;
      auto simulation = Simulation::create(model(scene), options, loader);
      if (!simulation) {
        fmt::print(stderr, "{}\n", simulation.error().front().message);
        return 1;
      }
      FrameContents contents;
      contents.contacts = true;
      (*simulation)->observe(contents, [](const FramePtr&) {});
      for (int i = 0; i < kWarmUp; ++i) (*simulation)->step();
      start_counting_allocations();
      for (int i = 0; i < kSteps; ++i) (*simulation)->step();
      print_allocations(engine, scene, "simulation", stop_counting_allocations(), kSteps);
    }
  }
  return 0;
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
    } else if (std::strcmp(argv[i], "--allocations") == 0) {
      return allocations();
    } else {
      fmt::print(stderr, "usage: {} [--rounds N] [--json] | --allocations\n", argv[0]);
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
