// cogrsim plot: figures of recordings, and figures drawn again.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "cogrsim/figures/draw.h"
#include "cogrsim/figures/plot_sampler.h"
#include "cogrsim/recording/recording.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "render/plots.h"
#include "sweep/result_table.h"
#include "sweep/sweep_table.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

int redraw(const PlotCommandOptions& options) {
  const std::string& path = options.files.front();
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return refuse(Error(fmt::format("cannot read '{}'", path)));
  auto figure = figures::figure_from_json(text.str());
  if (!figure) return refuse(Error(figure.error().message, path, figure.error().hint));
  if (!options.title.empty()) figure->title = options.title;
  const std::string output =
      is_picture(options.output)
          ? options.output
          : (fs::path(options.output) / (fs::path(path).stem().string() + "." + options.format))
                .string();
  if (!is_picture(options.output))
    if (const auto made = make_folder(options.output); !made) return refuse(made.error());
  if (const auto drawn = draw_and_report(*figure, output); !drawn) return refuse(drawn.error());
  return kGood;
}

struct Run {
  std::string path;
  std::unique_ptr<Recording> recording;
  std::vector<figures::PlotSampler> samplers;  // by plot
};

/// What distinguishes the runs: their backends if those differ, else their files.
std::vector<std::string> labels_of(const std::vector<Run>& runs) {
  if (runs.size() == 1) return {};
  const auto distinct = [&](const auto& text) {
    std::vector<std::string> all;
    for (const Run& run : runs) {
      std::string run_text = text(run);
      if (std::find(all.begin(), all.end(), run_text) != all.end()) {
        return std::vector<std::string>{};
      }
      all.push_back(std::move(run_text));
    }
    return all;
  };
  auto labels = distinct([](const Run& run) { return run.recording->info().backend; });
  if (labels.empty())
    labels = distinct([](const Run& run) { return fs::path(run.path).stem().string(); });
  if (labels.empty()) labels = distinct([](const Run& run) { return run.path; });
  for (std::size_t i = labels.size(); i < runs.size(); ++i)
    labels.push_back(fmt::format("{} ({})", runs[i].path, i + 1));
  return labels;
}

/// The plot that the command line describes, in series that share the signals given once.
PlotModel plot_from(const PlotCommandOptions& options) {
  PlotModel plot;
  plot.name = "plot";
  plot.kind = options.kind.empty() ? "curve" : options.kind;
  const std::size_t count =
      std::max({options.x.size(), options.y.size(), options.z.size(), std::size_t{1}});
  const auto pick = [&](const std::vector<std::string>& signals, std::size_t i) {
    return signals.empty() ? std::string() : signals.size() == 1 ? signals[0] : signals.at(i);
  };
  for (std::size_t i = 0; i < count; ++i) {
    PlotSeries series;
    series.x = pick(options.x, i);
    series.y = pick(options.y, i);
    series.z = pick(options.z, i);
    plot.series.push_back(std::move(series));
  }
  return plot;
}

Result<std::vector<PlotModel>> plots_of(const PlotCommandOptions& options,
                                        const SceneModel& model) {
  if (!options.x.empty() || !options.y.empty() || !options.z.empty() || !options.kind.empty())
    return std::vector<PlotModel>{plot_from(options)};
  if (model.plots.empty())
    return fail(fmt::format("the scene '{}' has no plots", model.name), "",
                "say what to draw: --y robot.speed");
  if (options.plots.empty()) return model.plots;
  std::vector<PlotModel> chosen;
  std::vector<std::string> names;
  for (const PlotModel& plot : model.plots) names.push_back(plot.name);
  for (const std::string& name : options.plots) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) {
      const std::string near = nearest_name(name, names);
      return fail(fmt::format("the scene '{}' has no plot '{}'", model.name, name), "",
                  near.empty() ? fmt::format("it has {}", fmt::join(names, ", "))
                               : fmt::format("did you mean '{}'?", near));
    }
    chosen.push_back(model.plots[at - names.begin()]);
  }
  return chosen;
}

Result<> gather(const PlotCommandOptions& options, const std::vector<PlotModel>& plots, Run& run) {
  Recording& recording = *run.recording;
  const auto first = recording.frame(0);
  if (!first) return tl::unexpected(first.error());
  const auto last = recording.frame(recording.frame_count() - 1);
  if (!last) return tl::unexpected(last.error());
  const ChannelLookup channels = [&](int sensor) { return &recording.channels(sensor); };
  for (PlotModel plot : plots) {
    if (!options.title.empty()) plot.title = options.title;
    if (options.every) plot.every = *options.every;
    auto sampler = figures::PlotSampler::create(plot, *(*first)->model, channels);
    // Elements added during the run are in the last model only.
    if (!sampler)
      if (auto later = figures::PlotSampler::create(plot, *(*last)->model, channels))
        sampler = std::move(later);
    if (!sampler) return tl::unexpected(sampler.error());
    const auto& record = (*first)->model->record;
    if (sampler->needs().contacts && record && !record->contacts)
      return fail(fmt::format("plot '{}' needs contacts, which '{}' was recorded without",
                              plot.name, run.path),
                  "", "record with contacts=\"true\"");
    run.samplers.push_back(std::move(*sampler));
  }
  for (std::size_t i = 0; i < recording.frame_count(); ++i) {
    if (interrupted()) return fail("interrupted: nothing was drawn");
    const double time = recording.time_of(i);
    if ((options.from && time < *options.from - 1e-9) || (options.to && time > *options.to + 1e-9))
      continue;
    const auto frame = recording.frame(i);
    if (!frame) return tl::unexpected(frame.error());
    for (figures::PlotSampler& sampler : run.samplers) sampler.take(**frame);
  }
  if (run.samplers.front().sample_count() == 0)
    return fail(fmt::format("'{}' has no frame in the time asked for", run.path), "",
                fmt::format("it goes from {} to {}", time_text(recording.info().start),
                            time_text(recording.info().end)));
  return {};
}

int draw_all(const PlotCommandOptions& options, const std::vector<Run>& runs) {
  const std::vector<std::string> labels = labels_of(runs);
  const std::size_t count = runs.front().samplers.size();
  const bool one = is_picture(options.output);
  if (one && count > 1) {
    std::string names;
    for (const figures::PlotSampler& sampler : runs.front().samplers)
      names += (names.empty() ? "" : ", ") + sampler.plot().name;
    return refuse(Error(fmt::format("there are {} plots for one file: {}", count, names), "",
                        "choose one with --plot NAME, or give a folder: -o plots"),
                  kWrongUsage);
  }
  if (!one)
    if (const auto made = make_folder(options.output); !made) return refuse(made.error());
  for (std::size_t i = 0; i < count; ++i) {
    if (interrupted()) return refuse(Error("interrupted: the rest was not drawn"));
    std::vector<const figures::PlotSampler*> samplers;
    for (const Run& run : runs) samplers.push_back(&run.samplers[i]);
    const auto figure = figures::figure_of(samplers, labels);
    if (!figure) return refuse(figure.error());
    const std::string path = one ? options.output
                                 : (fs::path(options.output) /
                                    (file_name_of(samplers[0]->plot().name) + "." + options.format))
                                       .string();
    if (const auto drawn = draw_and_report(*figure, path); !drawn) return refuse(drawn.error());
  }
  return kGood;
}

}  // namespace

int plot_command(const PlotCommandOptions& options) {
  catch_interrupts();
  for (const std::string& file : options.files) {
    add_input(file);
    add_input((fs::path(file) / kTableName).string());  // of a folder
  }
  if (std::any_of(options.files.begin(), options.files.end(), is_result_table))
    return plot_table(options);
  if (!options.by.empty())
    return refuse(Error("--by is for the tables of studies", "", "recordings are series already"),
                  kWrongUsage);
  const auto json = std::count_if(options.files.begin(), options.files.end(),
                                  [](const std::string& file) { return file.ends_with(".json"); });
  if (json > 0) {
    if (options.files.size() > 1)
      return refuse(Error("a figure is drawn alone", "", "give one .json file, or recordings"),
                    kWrongUsage);
    return redraw(options);
  }
  const std::size_t most = std::max({options.x.size(), options.y.size(), options.z.size()});
  for (const auto* signals : {&options.x, &options.y, &options.z})
    if (signals->size() > 1 && signals->size() < most)
      return refuse(Error(fmt::format("--x, --y and --z give {}, {} and {} signals",
                                      options.x.size(), options.y.size(), options.z.size()),
                          "", "each holds for all series when given once, else one per series"),
                    kWrongUsage);
  std::vector<Run> runs;
  for (const std::string& path : options.files) {
    auto opened = Recording::open(path);
    if (!opened) return refuse(opened.error());
    if (!(*opened)->info().damage.empty())
      print_warning(
          fmt::format("{}: {}; what is readable is drawn", path, (*opened)->info().damage));
    runs.push_back({path, std::move(*opened), {}});
  }
  for (Run& run : runs) {
    if (run.recording->frame_count() == 0)
      return refuse(Error(fmt::format("'{}' has no frames", run.path)));
    const auto frame = run.recording->frame(0);
    if (!frame) return refuse(frame.error());
    const auto plots = plots_of(options, *(*frame)->model);
    if (!plots) return refuse(plots.error());
    if (const auto good = gather(options, *plots, run); !good) return refuse(good.error());
    if (run.samplers.size() != runs.front().samplers.size())
      return refuse(
          Error(fmt::format("'{}' and '{}' have different plots", runs.front().path, run.path), "",
                "say what to draw: --plot NAME, or --y SIGNAL"));
    for (std::size_t i = 0; i < run.samplers.size(); ++i)
      if (run.samplers[i].plot().name != runs.front().samplers[i].plot().name ||
          run.samplers[i].plot().kind != runs.front().samplers[i].plot().kind)
        return refuse(
            Error(fmt::format("'{}' and '{}' have different plots", runs.front().path, run.path),
                  "", "say what to draw: --plot NAME, or --y SIGNAL"));
  }
  return draw_all(options, runs);
}

}  // namespace cogrsim::cli
