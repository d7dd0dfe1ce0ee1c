#include "bundle_command.h"

#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "bundle_data.h"
#include "bundle_html.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/recording/recording.h"
#include "document_file.h"
#include "render/frames.h"
#include "common/interrupt.h"
#include "run/run_log.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"

namespace cogrsim::studio {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostText = 16u << 20;  // of a scene, as the compiler's limit [byte]

// "scenes/maze.scene.xml", "maze.mcap" -> "maze.html", in the folder the program was started in.
std::string default_output(const std::string& source) {
  std::string name = fs::path(source).stem().string();
  const std::string ending = ".scene";
  if (name.size() > ending.size() &&
      name.compare(name.size() - ending.size(), ending.size(), ending) == 0) {
    name.resize(name.size() - ending.size());
  }
  return name + ".html";
}

// How the run ended, for the page and for the terminal.
struct Gathered {
  BundleAbout about;
  std::unique_ptr<RunSamples> samples;
  int status = cli::kFailed;
};

SampleOptions sample_options(const BundleOptions& options) {
  SampleOptions out;
  out.every = options.every;
  out.limit = static_cast<std::size_t>(options.size) << 20;
  return out;
}

OriginsPtr shared(const dsl::ModelOrigins& from) {
  auto to = std::make_shared<Origins>();
  to->version = 1;
  const auto take = [](const std::vector<dsl::Origin>& all, std::vector<Origins::Origin>& out) {
    for (const dsl::Origin& origin : all) out.push_back({origin.element, origin.own});
  };
  take(from.bodies, to->bodies);
  take(from.assemblies, to->assemblies);
  take(from.joints, to->joints);
  take(from.motors, to->motors);
  take(from.sensors, to->sensors);
  take(from.controllers, to->controllers);
  take(from.supervisors, to->supervisors);
  take(from.lights, to->lights);
  take(from.views, to->views);
  take(from.regions, to->regions);
  take(from.plots, to->plots);
  take(from.forces, to->forces);
  return to;
}

std::string ending_of(RunStatus status, const std::vector<RunMessage>& said) {
  std::string text = to_string(status);
  if (status != RunStatus::fault && status != RunStatus::diverged) return text;
  const auto error = std::find_if(said.rbegin(), said.rend(), [](const RunMessage& m) {
    return m.severity == Severity::error;
  });
  if (error == said.rend()) return text;
  const bool says_so = error->message.compare(0, text.size(), text) == 0;
  return says_so ? error->message : text + ": " + error->message;
}

Gathered run_scene(const BundleOptions& options, const std::string& output) {
  Gathered out;
  const cli::SceneOptions& source = options.source.source;
  std::error_code missing;
  if (!fs::exists(source.scene, missing)) {
    cli::refuse(Error(fmt::format("there is no file '{}'", source.scene), "",
                      "name a scene, NAME.scene.xml, or a recording, NAME.mcap"));
    return out;
  }
  auto text = read_text_file(source.scene, kMostText);
  if (!text) {
    cli::refuse(text.error());
    return out;
  }
  auto loader = std::make_shared<PluginLoader>(source.plugin_paths);
  dsl::LoaderCatalog catalog(loader);
  dsl::CompileOptions compile;
  compile.set_parameters = source.set;
  compile.seed = source.seed;
  compile.plugins = &catalog;
  dsl::OutlinedScene scene = dsl::compile_outlined(*text, source.scene, compile);
  cli::print_diagnostics(scene.result.diagnostics);
  for (const std::string& read : scene.result.files_read) cli::add_input(read);
  if (!scene.result.ok()) return out;
  if (auto good = cli::check_writable(output, OutputKind::html); !good) {
    cli::refuse(good.error());
    return out;
  }
  const SceneModelPtr model = scene.result.model;
  const double step = options.source.step > 0.0 ? options.source.step : model->physics.step;
  const double duration = cli::duration_of(*model, source);
  if (const std::string problem = cli::step_problem(step, duration); !problem.empty()) {
    cli::print_error(problem);
    if (options.source.step > 0.0 || source.duration) out.status = cli::kWrongUsage;
    return out;
  }
  SimulationOptions settings;
  settings.backend = options.source.backend;
  settings.step = options.source.step;
  settings.seed = source.seed;
  settings.without = source.without;
  auto created = Simulation::create(model, settings, loader);
  if (!created) {
    cli::print_problems(created.error());
    return out;
  }
  Simulation& simulation = **created;
  out.samples =
      std::make_unique<RunSamples>(sample_options(options), shared(scene.origins),
                                   [&simulation](int sensor) -> const std::vector<Channel>& {
                                     return simulation.channels(sensor);
                                   });
  RunSamples& samples = *out.samples;
  simulation.observe(samples.needs(model),
                     [&samples](const FramePtr& frame) { samples.take(frame); });
  RunStatus status = RunStatus::running;
  {
    cli::Progress progress(simulation.backend().name(), duration);
    cli::RunLog run_log(simulation, progress, nullptr, false);
    cli::catch_interrupts();
    const cli::InterruptStops stops(simulation);
    status = run_log.run(duration);
    if (status == RunStatus::running)
      status = simulation.paused() ? RunStatus::stopped : RunStatus::completed;
    progress.finish();
    run_log.finish();
  }
  if (samples.samples().empty()) samples.take(simulation.frame());
  samples.finish();

  BundleAbout& about = out.about;
  about.backend = simulation.backend().name();
  about.engine_version = simulation.backend().engine_version();
  about.provenance = simulation.provenance();
  about.step = simulation.dt();
  about.messages = simulation.messages();
  about.ending = ending_of(status, about.messages);
  about.text = BundleText{fs::path(source.scene).filename().string(), std::move(*text),
                          std::move(scene.elements), std::move(scene.result.diagnostics)};
  const bool good = status == RunStatus::completed || status == RunStatus::stopped;
  if (!good) {
    cli::print_error(fmt::format("the run ended at {} ({}): the bundle holds it as far as it came",
                                 cli::time_text(simulation.time()), to_string(status)));
  }
  out.status = good ? cli::kGood : cli::kFailed;
  return out;
}

// The scene's own text is the first attachment of a recording.
std::optional<BundleText> attached_text(const RecordingInfo& info) {
  if (info.attachments.empty() || !is_utf8(info.attachments.front().data)) return std::nullopt;
  const Attachment& first = info.attachments.front();
  BundleText text;
  text.file = fs::path(first.name).filename().string();
  text.text = first.data;
  text.elements = dsl::outline_text(first.data, first.name);
  return text;
}

Gathered read_recording(const BundleOptions& options) {
  Gathered out;
  const cli::SceneOptions& source = options.source.source;
  auto opened = Recording::open(source.scene);
  if (!opened) {
    cli::refuse(opened.error());
    return out;
  }
  Recording& recording = **opened;
  const RecordingInfo& info = recording.info();
  if (!info.damage.empty()) {
    cli::print_warning(fmt::format("{}: {}; using what is readable, up to {}", source.scene,
                                   info.damage, cli::time_text(info.end)));
  }
  if (recording.frame_count() == 0) {
    cli::refuse(Error(fmt::format("'{}' has no frames", source.scene), "", "record the run again"));
    return out;
  }
  auto first = recording.frame(0);
  if (!first) {
    cli::refuse(first.error());
    return out;
  }
  BundleAbout& about = out.about;
  about.text = attached_text(info);
  auto origins = std::make_shared<Origins>();
  if (about.text) *origins = origins_by_name(about.text->elements, *(*first)->model);
  origins->version = 1;
  out.samples =
      std::make_unique<RunSamples>(sample_options(options), std::move(origins),
                                   [&recording](int sensor) -> const std::vector<Channel>& {
                                     return recording.channels(sensor);
                                   });
  cli::catch_interrupts();
  const double end = source.duration ? std::min(info.end, info.start + *source.duration) : info.end;
  cli::Progress progress(fs::path(source.scene).filename().string(), end);
  for (std::size_t i = 0; i < recording.frame_count() && !cli::interrupted(); ++i) {
    if (recording.time_of(i) > end + 1e-9) break;
    const auto frame = recording.frame(i);
    if (!frame) {
      progress.finish();
      cli::refuse(frame.error());
      out.samples.reset();
      return out;
    }
    out.samples->take(*frame);
    progress.show((*frame)->time);
  }
  progress.finish();
  out.samples->finish();
  about.backend = info.backend;
  about.engine_version = info.engine_version;
  about.provenance = info.provenance;
  about.step = info.step;
  about.ending = info.complete ? info.status : "it breaks off: " + info.damage;
  about.messages = recording.messages();
  out.status = cli::kGood;
  return out;
}

std::string size_text(std::size_t bytes) {
  return bytes < 1'000'000 ? fmt::format("{:.0f} kB", static_cast<double>(bytes) / 1e3)
                           : fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

}  // namespace

int bundle_command(const BundleOptions& options) {
  const std::string& file = options.source.source.scene;
  const std::string output = options.output.empty() ? default_output(file) : options.output;
  cli::add_input(file);
  if (options.force) cli::allow_overwriting();
  if (auto good = cli::check_writable(output, OutputKind::html); !good) {
    return cli::refuse(good.error());
  }
  Gathered run = cli::is_recording(file) ? read_recording(options) : run_scene(options, output);
  if (!run.samples) return run.status;
  RunSamples& samples = *run.samples;
  run.about.file = file;

  std::vector<std::string> left_out = samples.left_out();
  const std::string data = bundle_data(run.about, samples, left_out);
  const SceneRecordPtr scene = samples.scenes().newest();
  const std::string& name = scene->model->name;
  const std::string page =
      bundle_html(name.empty() ? fs::path(file).filename().string() : name, data);
  if (auto written = cli::write_output(output, OutputKind::html, page); !written)
    return cli::refuse(written.error());
  for (const std::string& what : left_out) cli::print_warning("left out: " + what);
  const auto& all = samples.samples();
  const std::string summary =
      fmt::format("{}: {}, {} frames from {} to {}, {} curves, {} figures\n", cli::one_line(output),
                  size_text(page.size()), all.size(), cli::time_text(all.front().time),
                  cli::time_text(all.back().time), samples.curves(all.back().scene).curves.size(),
                  samples.figures().size());
  std::fputs(summary.c_str(), stderr);
  return run.status;
}

}  // namespace cogrsim::studio
