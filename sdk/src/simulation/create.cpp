// Construction of a simulation: backend, world, sensors, controllers.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "cogrsim/physics/backend_choice.h"
#include "cogrsim/physics/default_backend.h"
#include "cogrsim/physics/warnings.h"
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
    Diagnostic d = to_diagnostic(completed.error(), "CG0904");
    d.message =
        "options of backend '" + std::string(backend.name()) + "'" + where + ": " + d.message;
    locate(d, scene, origin);
    found.push_back(std::move(d));
  };
  if (auto overruled = option_values(choice, backend.world_options()); overruled) {
    Parameters& world = model->physics.engine_options[backend.name()];
    for (const auto& [name, value] : *overruled) world[name] = value;
  } else {
    return tl::unexpected(std::vector<Diagnostic>{to_diagnostic(overruled.error(), "CG0904")});
  }
  complete(model->physics.engine_options, backend.world_options(), "", model->physics.origin);
  for (AssemblyInfo& info : model->assemblies) {
    complete(info.engine_options, backend.element_options("assembly"),
             " in assembly '" + info.name + "'", info.origin);
  }
  // What these do not say is the world's, so they are checked and stay as they are.
  const auto check = [&](const auto& elements, const char* element) {
    for (const auto& it : elements) {
      std::map<std::string, Parameters> copy = it.engine_options;
      if (copy.count(backend.name()) != 0)
        complete(copy, backend.element_options(element),
                 std::string(" in ") + element + " '" + it.name + "'", it.origin);
    }
  };
  check(model->materials, "material");
  check(model->joints, "joint");
  check(model->couplings, "couple");
  if (!found.empty()) return tl::unexpected(std::move(found));
  name_outputs(*model, loader);
  return SceneModelPtr(std::move(model));
}

}  // namespace

Simulation::Impl::Impl(std::shared_ptr<PluginLoader> plugins,
                       std::shared_ptr<const Backend> backend, Provenance provenance,
                       const SceneModelPtr& scene, const SimulationOptions& options)
    : loader(std::move(plugins)),
      host(std::move(backend), std::move(provenance), scene, options.without),
      devices(*loader, host, clock),
      events(clock, log,
             [this](const Event& event) {
               cached.reset();  // the cached frame does not contain the event
               supervisors.deliver(event);
             }),
      supervisors({*loader, host, clock, log, events, commands}),
      controllers(*loader, host, devices, clock, log, events, options.isolation),
      actions(*loader, clock, host, devices, controllers, events) {
  clock.set_dt(scene->physics.step);
  events.reset(*scene, host.seed());
  pace.speed = options.speed;
}

tl::expected<std::unique_ptr<Simulation>, std::vector<Diagnostic>> Simulation::create(
    SceneModelPtr scene, const SimulationOptions& options, std::shared_ptr<PluginLoader> loader) {
  using Failure = tl::unexpected<std::vector<Diagnostic>>;
  const auto refuse = [](const Error& error, const char* code) {
    return Failure(std::vector<Diagnostic>{to_diagnostic(error, code)});
  };
  const double step = options.step == 0.0 ? scene->physics.step : options.step;
  if (!std::isfinite(step) || !(step >= kShortestStep)) {
    return refuse(Error("the step must be a positive number of seconds, from 1e-9 s"), "CG0905");
  }
  if (!(options.speed > 0.0)) return refuse(Error("the speed must be above 0"), "CG0905");

  std::string name = options.backend;
  if (name.empty()) name = scene->physics.backend;
  if (name.empty()) name = kDefaultBackend;
  auto backend = loader->backend(name);
  if (!backend) {
    Diagnostic d = to_diagnostic(backend.error(), "CG0901");
    if (options.backend.empty()) locate(d, *scene, scene->physics.backend_origin);
    return Failure(std::vector<Diagnostic>{std::move(d)});
  }
  // The loader has already parsed the name, so it is valid.
  const BackendChoice choice = *parse_backend_choice(name);
  if (auto known = check_without(options.without); !known) return refuse(known.error(), "CG0904");
  auto settled = settled_model(*scene, options, choice, **backend, *loader);
  if (!settled) return Failure(settled.error());
  std::vector<LeftOut> left_out_of_it;
  *settled = leave_out(*settled, (*backend)->capabilities(), options.without, &left_out_of_it);
  auto provenance = provenance_of(**backend, **settled);
  if (!provenance) {
    Error error = provenance.error();
    error.message = fmt::format("backend '{}' does not declare what computes its results:\n{}",
                                name, error.message);
    return Failure(std::vector<Diagnostic>{to_diagnostic(error, "CG0901")});
  }
  provenance->left_out = std::move(left_out_of_it);
  auto impl = std::make_unique<Impl>(std::move(loader), *backend, std::move(*provenance), *settled,
                                     options);

  std::vector<Diagnostic> found =
      check_capabilities(impl->model(), choice.name, (*backend)->capabilities());
  const auto is_error = [](const Diagnostic& d) { return d.severity == Severity::error; };
  if (std::none_of(found.begin(), found.end(), is_error)) {
    if (auto created = impl->host.create(); !created) {
      found.push_back(to_diagnostic(created.error(), "CG0802"));
    } else if (auto* const world = impl->host.world().extension<WorldWarnings>()) {
      for (Diagnostic& d : world->warnings()) found.push_back(std::move(d));
    }
  }
  for (Diagnostic& d : stiff_forces(impl->model())) found.push_back(std::move(d));
  for (const BuriedCamera& buried : buried_cameras(impl->model())) {
    const SensorModel& sensor = impl->model().sensors[buried.sensor];
    const Error& error = buried.error;
    found.push_back(diagnose(impl->model(), sensor.origin, error.message, error.code, error.hint));
  }
  for (const UnusableDelay& it : unusable_delays(impl->model(), impl->model().physics.step)) {
    const auto at = static_cast<std::size_t>(it.index);
    const SourceSpan& origin =
        it.motor ? impl->model().motors[at].origin : impl->model().sensors[at].origin;
    found.push_back(
        diagnose(impl->model(), origin, it.error.message, it.error.code, it.error.hint));
  }
  // Controllers are configured even if the world could not be built, to report all errors at once.
  for (Diagnostic& d : impl->build_all()) found.push_back(std::move(d));
  if (std::any_of(found.begin(), found.end(), is_error)) return Failure(std::move(found));
  for (const Diagnostic& d : found) {
    std::string text = d.message;
    for (const auto& note : d.notes) text += ": " + note.message;
    impl->log.report(Severity::warning, "backend", text);
  }
  return std::unique_ptr<Simulation>(new Simulation(std::move(impl)));
}

std::vector<Diagnostic> Simulation::Impl::build_controllers() {
  std::vector<Diagnostic> found = controllers.build(0);
  for (Diagnostic& d : supervisors.build(*this)) found.push_back(std::move(d));
  return found;
}

std::vector<Diagnostic> Simulation::Impl::build_all() {
  std::vector<Diagnostic> found = devices.build({});
  for (Diagnostic& d : build_controllers()) found.push_back(std::move(d));
  return found;
}

}  // namespace cogrsim
