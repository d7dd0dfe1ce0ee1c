#include "render/plots.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/figures/draw.h"
#include "common/interrupt.h"
#include "common/output_file.h"
#include "common/terminal.h"

namespace cogrsim::cli {

std::string file_name_of(const std::string& plot) {
  std::string name = plot;
  for (char& c : name) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '-' || c == '_' || c == '.';
    if (!good) c = '_';
  }
  if (name.empty() || name[0] == '.') name.insert(0, "plot");
  return name;
}

Result<> make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && std::filesystem::is_directory(folder, error)) return {};
  return fail(fmt::format("cannot make the folder '{}': {}", folder,
                          error ? error.message() : "a file is in the way"));
}

bool is_picture(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  return ending == ".png" || ending == ".svg" || ending == ".pdf" || ending == ".json";
}

Result<> draw_and_report(const figures::Figure& figure, const std::string& path) {
  figures::DrawOptions options;
  options.rules = output_rules();
  options.cancelled = later_interrupt();
  const auto files = figures::draw(figure, path, options);
  if (!files) return tl::unexpected(files.error());
  std::fprintf(stderr, "%s\n", one_line(files->front()).c_str());
  return {};
}

Result<RunPlots> RunPlots::attach(Simulation& simulation) {
  RunPlots plots;
  plots.samplers_ = std::make_shared<std::vector<figures::PlotSampler>>();
  const ChannelLookup channels = [&](int sensor) { return &simulation.channels(sensor); };
  FrameContents needs;
  for (const PlotModel& plot : simulation.model()->plots) {
    auto sampler = figures::PlotSampler::create(plot, *simulation.model(), channels);
    if (!sampler) return tl::unexpected(sampler.error());
    needs = needs | sampler->needs();
    plots.samplers_->push_back(std::move(*sampler));
  }
  if (plots.empty()) return plots;
  const auto take = [samplers = plots.samplers_](const FramePtr& frame) {
    for (figures::PlotSampler& sampler : *samplers) sampler.take(*frame);
  };
  simulation.observe(needs, take);
  return plots;
}

Result<> RunPlots::draw(const std::string& folder) const {
  if (const auto made = make_folder(folder); !made) return made;
  for (const figures::PlotSampler& sampler : *samplers_) {
    const auto figure = figures::figure_of({&sampler}, {});
    if (!figure) return tl::unexpected(figure.error());
    const std::filesystem::path path =
        std::filesystem::path(folder) / (file_name_of(sampler.plot().name) + ".png");
    if (const auto drawn = draw_and_report(*figure, path.string()); !drawn) return drawn;
  }
  return {};
}

}  // namespace cogrsim::cli
