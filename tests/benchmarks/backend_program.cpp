// CogRSim's side of the benchmark: the scenes on one of its backends, found as a plugin.
//
//     cogrsim_bench_backend BACKEND --scene NAME …      see engine_program.h
//     cogrsim_bench_backend BACKEND --allocations SCENE [COUNT]
//     cogrsim_bench_backend BACKEND --spawn COUNT       how long adding a body to so many takes
//     cogrsim_bench_backend --compile COUNT             how long a scene of so many bodies compiles
//     cogrsim_bench_backend --list                      the backends there are
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "allocations.h"
#include "cogrsim/dsl/compiler.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/backend_choice.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/simulation/simulation.h"
#include "engine_program.h"
#include "model_of.h"

namespace {

using namespace cogrsim;
using namespace cogrsim::bench;

void take(const WorldState& state, std::vector<ThingState>& states) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Pose& X = state.poses[i];
    states[i] = {{X.p.x(), X.p.y(), X.p.z()}, {X.q.w(), X.q.x(), X.q.y(), X.q.z()}};
  }
}

/// The backend's world alone, motors at the scene's targets.
class WorldRunner final : public Runner {
 public:
  WorldRunner(const std::shared_ptr<const Backend>& backend, const SceneModelPtr& model)
      : backend_(backend) {
    auto world = backend->create_world(model);
    if (!world) throw std::runtime_error(world.error().text());
    world_ = std::move(*world);
    for (const Motor& motor : model->motors) {
      Drive drive;
      drive.kd = std::numeric_limits<double>::infinity();
      drive.velocity = motor.target.value_or(0.0);
      drive.max_effort = motor.max_effort;
      drives_.push_back(drive);
    }
  }
  void step(double dt) override {
    const StepResult result = world_->step(dt, drives_);
    if (result.status != StepStatus::ok) throw std::runtime_error("diverged: " + result.message);
  }
  void get_states(std::vector<ThingState>& states) override {
    world_->get_state(state_);
    take(state_, states);
  }

  /// What a simulation does in each step, with contacts.
  void step_and_look(double dt) {
    step(dt);
    world_->get_state(state_);
    world_->get_contacts(contacts_);
  }

 private:
  std::shared_ptr<const Backend> backend_;
  std::unique_ptr<World> world_;
  std::vector<Drive> drives_;
  WorldState state_;
  std::vector<Contact> contacts_;
};

/// A whole simulation: sensors, motors, frames.
class SimulationRunner final : public Runner {
 public:
  SimulationRunner(const std::string& backend, const SceneModelPtr& model,
                   const std::shared_ptr<PluginLoader>& loader) {
    SimulationOptions options;
    options.backend = backend;
    auto made = Simulation::create(model, options, loader);
    if (!made) throw std::runtime_error(made.error().front().message);
    simulation_ = std::move(*made);
  }
  void step(double) override {
    if (simulation_->step() != RunStatus::running) throw std::runtime_error("the run ended");
  }
  void get_states(std::vector<ThingState>& states) override {
    take(simulation_->frame()->state, states);
  }
  double seen() override {
    double sum = 0;
    const FramePtr frame = simulation_->frame();
    for (std::size_t i = 0; i < frame->readings.size(); ++i) {
      const double distance = frame->readings[i].values.front();
      const auto& range = frame->model->sensors[i].parameters.at("range");
      sum += std::min(distance, std::get<std::vector<double>>(range).back());
    }
    return sum;
  }
  Simulation& simulation() { return *simulation_; }

 private:
  std::unique_ptr<Simulation> simulation_;
};

class BackendProgram final : public EngineProgram {
 public:
  /// `choice`: a backend, with options in brackets if it shall have any.
  explicit BackendProgram(const std::string& choice) : loader_(std::make_shared<PluginLoader>()) {
    const auto parsed = parse_backend_choice(choice);
    if (!parsed) throw std::runtime_error(parsed.error().text());
    auto backend = loader_->backend(parsed->name);
    if (!backend) throw std::runtime_error(backend.error().text());
    backend_ = *backend;
    auto values = option_values(*parsed, backend_->world_options());
    if (!values) throw std::runtime_error(values.error().text());
    values_ = std::move(*values);
  }
  std::string name() const override { return std::string("cogrsim-") + backend_->name(); }
  std::string version() const override { return backend_->engine_version(); }
  std::string settings() const override {
    return "CogRSim's backend with its defaults; the world alone, the whole simulation where there "
           "are sensors";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    const bool world_anchors = std::strcmp(backend_->name(), "ode") == 0;
    SceneModelPtr model = model_of(scene, world_anchors);
    if (!values_.empty()) {
      auto changed = std::make_shared<SceneModel>(*model);
      changed->physics.engine_options[backend_->name()] = values_;
      model = changed;
    }
    for (const Diagnostic& problem :
         check_capabilities(*model, backend_->name(), backend_->capabilities())) {
      if (problem.severity == Severity::error) throw Unsupported(problem.message);
    }
    if (!scene.eyes.empty()) {
      return std::make_unique<SimulationRunner>(backend_->name(), model, loader_);
    }
    return std::make_unique<WorldRunner>(backend_, model);
  }
  int count_allocations(const Scene& scene);
  int spawn(int count);

 private:
  std::shared_ptr<PluginLoader> loader_;
  std::shared_ptr<const Backend> backend_;
  Parameters values_;  ///< of the backend's options that were given
};

void print(const char* layer, const AllocationReport& report, int steps) {
  const auto per_step = [&](std::uint64_t count) { return static_cast<double>(count) / steps; };
  nlohmann::json sites = nlohmann::json::array();
  for (const AllocationSite& site : report.sites) {
    if (!site.ours) continue;
    sites.push_back({{"per_step", per_step(site.count)},
                     {"bytes", static_cast<double>(site.bytes) / static_cast<double>(site.count)},
                     {"frames", site.frames}});
  }
  const nlohmann::json line = {{"layer", layer},
                               {"ours", per_step(report.ours)},
                               {"engine", per_step(report.engine)},
                               {"lost", report.lost},
                               {"sites", sites}};
  fmt::print("{}\n", line.dump());
}

int BackendProgram::count_allocations(const Scene& scene) {
  // Twice the warm-up, so that buffers have had the largest size they need.
  const int warm_up = 2 * scene.warm_up, steps = 2 * scene.round;
  const SceneModelPtr model = model_of(scene);
  {
    WorldRunner runner(backend_, model);
    for (int i = 0; i < warm_up; ++i) runner.step_and_look(scene.step);
    start_counting_allocations();
    for (int i = 0; i < steps; ++i) runner.step_and_look(scene.step);
    print("world", stop_counting_allocations(), steps);
  }
  SimulationRunner runner(backend_->name(), model, loader_);
  FrameContents contents;
  contents.contacts = true;
  runner.simulation().observe(contents, [](const FramePtr&) {});
  for (int i = 0; i < warm_up; ++i) runner.step(scene.step);
  start_counting_allocations();
  for (int i = 0; i < steps; ++i) runner.step(scene.step);
  print("simulation", stop_counting_allocations(), steps);
  return 0;
}

// Boxes side by side on a plane; a sphere is added above them between two steps, again and again.
int BackendProgram::spawn(int count) {
  constexpr int kRounds = 20;
  ModelBuilder builder("spawn");
  builder.plane("floor");
  const int row = static_cast<int>(std::ceil(std::sqrt(count)));
  const auto place = [&](int i, double height) {
    return Pose(Vec3(0.5 * (i % row), 0.5 * (i / row), height), Quat::Identity());
  };
  for (int i = 0; i < count; ++i)
    builder.box(fmt::format("box_{}", i), Vec3::Constant(0.2), 1.0, place(i, 0.1));
  auto made = backend_->create_world(builder.build());
  if (!made) throw std::runtime_error(made.error().text());
  World& world = **made;
  for (int i = 0; i < 100; ++i) world.step(1e-3, {});
  std::vector<double> times;
  for (int round = 0; round < kRounds; ++round) {
    ModelBuilder next;
    next.model = *world.model();
    next.sphere(fmt::format("guest_{}", round), 0.05, 0.1, place(round % count, 1.0 + round));
    const SceneModelPtr model = next.build();
    const auto start = std::chrono::steady_clock::now();
    const auto added = world.add(model);
    const std::chrono::duration<double, std::micro> passed =
        std::chrono::steady_clock::now() - start;
    if (!added) throw std::runtime_error(added.error().text());
    times.push_back(passed.count());
    world.step(1e-3, {});
  }
  std::sort(times.begin(), times.end());
  fmt::print(
      "{}\n",
      nlohmann::json{
          {"engine", name()}, {"bodies", count}, {"median_us", times[kRounds / 2]}, {"us", times}}
          .dump());
  return 0;
}

int compile(int count) {
  const std::string text = scene_text(count);
  std::vector<double> times;
  for (int round = 0; round < 5; ++round) {
    const auto start = std::chrono::steady_clock::now();
    const dsl::CompileResult result = dsl::compile_text(text, "many.scene.xml");
    const std::chrono::duration<double, std::micro> passed =
        std::chrono::steady_clock::now() - start;
    if (!result.ok()) {
      fmt::print(stderr, "{}\n", dsl::to_text(result.diagnostics));
      return 1;
    }
    times.push_back(passed.count());
  }
  fmt::print("{}\n",
             nlohmann::json{{"bodies", count}, {"bytes", text.size()}, {"us", times}}.dump());
  return 0;
}

int list() {
  PluginLoader loader;
  for (const PluginPtr& plugin : loader.all()) {
    if (plugin->descriptor().kind == PluginKind::backend && !plugin->is_program()) {
      fmt::print("{}\n", plugin->descriptor().name);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "--list") return list();
  if (first == "--compile" && argc == 3 && std::atoi(argv[2]) > 0) {
    return compile(std::atoi(argv[2]));
  }
  if (first.empty() || first.front() == '-') {
    fmt::print(stderr,
               "usage: {} BACKEND[(OPTION=VALUE …)] --scene NAME … | BACKEND --spawn COUNT | "
               "--list | --compile COUNT\n",
               argv[0]);
    return 2;
  }
  BackendProgram program(first);
  if (argc >= 4 && std::strcmp(argv[2], "--allocations") == 0) {
    const Scene scene = make_scene(argv[3], argc > 4 ? std::atoi(argv[4]) : 0);
    if (scene.name.empty())
      throw std::runtime_error(fmt::format("there is no scene '{}'", argv[3]));
    return program.count_allocations(scene);
  }
  if (argc == 4 && std::strcmp(argv[2], "--spawn") == 0 && std::atoi(argv[3]) > 0)
    return program.spawn(std::atoi(argv[3]));
  return engine_main(argc - 1, argv + 1, program);
} catch (const std::exception& error) {
  fmt::print("{}\n", nlohmann::json{{"failed", error.what()}}.dump());
  return 1;
}
