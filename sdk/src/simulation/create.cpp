// Construction of a simulation: backend, world, sensors, controllers.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "cogrsim/physics/backend_choice.h"
#include "cogrsim/sensing/sensor_models.h"
#include "model/diagnose.h"
#include "simulation/impl.h"

namespace cogrsim {

const char* to_string(RunStatus status) {
  switch (status) {
    case RunStatus::running:
      return "running";
    case RunStatus::completed:
      return "completed";
    case RunStatus::stopped:
      return "stopped";
    case RunStatus::fault:
      return "fault";
    case RunStatus::diverged:
      return "diverged";
  }
  return "running";
}

namespace {

constexpr const char* kDefaultBackend = "cogrsim";

Diagnostic from_error(const Error& error, const std::string& default_code) {
  Diagnostic d;
  d.code = error.code.empty() ? default_code : error.code;
  d.message = error.where.empty() ? error.message : error.where + ": " + error.message;
  d.help = error.hint;
  return d;
}

// Applies the options that the run overrides, and completes the engine-specific options.
tl::expected<SceneModelPtr, std::vector<Diagnostic>> settled_model(const SceneModel& scene,
                                                                   const SimulationOptions& options,
                                                                   const BackendChoice& choice,
                                                                   const Backend& backend,
                                                                   PluginLoader& loader) {
  auto model = std::make_shared<SceneModel>(scene);
  if (options.step > 0.0) model->physics.step = options.step;
  if (options.seed) model->physics.seed = *options.seed;
  model->physics.backend = backend.name();

  std::vector<Diagnostic> found;
  const auto complete = [&](std::map<std::string, Parameters>& blocks, const ParameterTable& table,
                            const std::string& where, const SourceSpan& origin) {
    const auto given = blocks.find(backend.name());
    auto completed =
        complete_parameters(table, given == blocks.end() ? Parameters{} : given->second);
    if (completed) {
      blocks[backend.name()] = std::move(*completed);
      return;
    }
    Diagnostic d = from_error(completed.error(), "CG0904");
    d.message =
        "options of backend '" + std::string(backend.name()) + "'" + where + ": " + d.message;
    locate(d, scene, origin);
    found.push_back(std::move(d));
  };
  if (auto overruled = option_values(choice, backend.world_options()); overruled) {
    Parameters& world = model->physics.engine_options[backend.name()];
    for (const auto& [name, value] : *overruled) world[name] = value;
  } else {
    return tl::unexpected(std::vector<Diagnostic>{from_error(overruled.error(), "CG0904")});
  }
  complete(model->physics.engine_options, backend.world_options(), "", model->physics.origin);
  for (AssemblyInfo& info : model->assemblies) {
    complete(info.engine_options, backend.assembly_options(), " in assembly '" + info.name + "'",
             info.origin);
  }
  if (!found.empty()) return tl::unexpected(std::move(found));
  name_outputs(*model, loader);
  return SceneModelPtr(std::move(model));
}

}  // namespace

void name_outputs(SceneModel& model, PluginLoader& loader) {
  const auto name = [&](std::vector<ControllerModel>& controllers, PluginKind kind) {
    for (ControllerModel& controller : controllers) {
      const auto plugin = loader.load(kind, controller.plugin);
      if (!plugin) continue;  // reported when the controller is built
      controller.outputs.clear();
      for (const PluginOutput& output : (*plugin)->descriptor().outputs) {
        controller.outputs.push_back({output.name, output.unit});
      }
    }
  };
  name(model.controllers, PluginKind::controller);
  name(model.supervisors, PluginKind::supervisor);
}

tl::expected<std::unique_ptr<Simulation>, std::vector<Diagnostic>> Simulation::create(
    SceneModelPtr scene, const SimulationOptions& options, std::shared_ptr<PluginLoader> loader) {
  using Failure = tl::unexpected<std::vector<Diagnostic>>;
  const auto refuse = [](const Error& error, const char* code) {
    return Failure(std::vector<Diagnostic>{from_error(error, code)});
  };
  if (!std::isfinite(options.step) || options.step < 0.0) {
    return refuse(Error("the step must be a positive number of seconds"), "CG0905");
  }
  if (!(options.speed > 0.0)) return refuse(Error("the speed must be above 0"), "CG0905");

  auto impl = std::make_unique<Impl>(std::move(loader));
  std::string name = options.backend;
  if (name.empty()) name = scene->physics.backend;
  if (name.empty()) name = kDefaultBackend;
  auto backend = impl->loader->backend(name);
  if (!backend) {
    Diagnostic d = from_error(backend.error(), "CG0901");
    if (options.backend.empty()) locate(d, *scene, scene->physics.backend_origin);
    return Failure(std::vector<Diagnostic>{std::move(d)});
  }
  impl->backend = *backend;

  // The loader has already parsed the name, so it is valid.
  const BackendChoice choice = *parse_backend_choice(name);
  auto settled = settled_model(*scene, options, choice, *impl->backend, *impl->loader);
  if (!settled) return Failure(settled.error());
  impl->original = impl->model = *settled;
  auto provenance = provenance_of(*impl->backend, *impl->model);
  if (!provenance) {
    Error error = provenance.error();
    error.message =
        fmt::format("backend '{}' does not declare what computes its results:\n{}", name, error.message);
    return Failure(std::vector<Diagnostic>{from_error(error, "CG0901")});
  }
  impl->provenance = std::move(*provenance);
  impl->clock.set_dt(impl->model->physics.step);
  impl->event_system.reset(*impl->model, impl->model->physics.seed);
  impl->pace.speed = options.speed;
  impl->isolation = options.isolation;

  std::vector<Diagnostic> found =
      check_capabilities(*impl->model, choice.name, impl->backend->capabilities());
  const auto is_error = [](const Diagnostic& d) { return d.severity == Severity::error; };
  if (std::none_of(found.begin(), found.end(), is_error)) {
    const PluginCall call("backend", impl->backend->name(), "", "", "while the world was created");
    auto world = impl->backend->create_world(impl->model);
    if (world) {
      impl->world = std::move(*world);
    } else {
      found.push_back(from_error(world.error(), "CG0801"));
    }
  }
  for (const BuriedCamera& buried : buried_cameras(*impl->model)) {
    const SensorModel& sensor = impl->model->sensors[static_cast<std::size_t>(buried.sensor)];
    const Error& error = buried.error;
    found.push_back(impl->problem(error.message, sensor.origin, error.code, error.hint));
  }
  // Controllers are configured even if the world could not be built, to report all errors at once.
  for (Diagnostic& d : impl->build_all()) found.push_back(std::move(d));
  if (std::any_of(found.begin(), found.end(), is_error)) return Failure(std::move(found));
  for (const Diagnostic& d : found) impl->log.report(Severity::warning, "backend", d.message);
  return std::unique_ptr<Simulation>(new Simulation(std::move(impl)));
}

Diagnostic Simulation::Impl::problem(const std::string& message, const SourceSpan& origin,
                                     const std::string& code, const std::string& help) const {
  return diagnose(*model, origin, message, code, help);
}

void Simulation::Impl::build_motors(std::size_t first) {
  motors.resize(first);
  for (std::size_t i = first; i < model->motors.size(); ++i) {
    motors.push_back(initial_motor_state(*model, model->motors[i]));
  }
}

std::vector<Diagnostic> Simulation::Impl::build_sensors(std::size_t first) {
  return sensors.build(model, original->physics.seed, *loader, first);
}

std::vector<Diagnostic> Simulation::Impl::build_controllers(std::size_t first_controller,
                                                      bool with_supervisors) {
  std::vector<Diagnostic> found;
  const auto collect = [&found](std::vector<Diagnostic> more) {
    for (Diagnostic& d : more) found.push_back(std::move(d));
  };
  controllers.erase(controllers.begin() + static_cast<std::ptrdiff_t>(first_controller),
                    controllers.end());
  for (std::size_t i = first_controller; i < model->controllers.size(); ++i) {
    collect(build_controller(i));
  }
  if (!with_supervisors) return found;
  supervisors.clear();
  if (!world) return found;  // supervisors need frames, which do not exist without a world
  for (const ControllerModel& description : model->supervisors) {
    collect(build_supervisor(description));
  }
  return found;
}

std::vector<Diagnostic> Simulation::Impl::build_all() {
  build_motors(0);
  std::vector<Diagnostic> found = build_sensors(0);
  for (Diagnostic& d : build_controllers(0, true)) found.push_back(std::move(d));
  return found;
}

}  // namespace cogrsim
