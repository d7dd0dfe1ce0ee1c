#include "cogrsim/figures/plot_sampler.h"

#include <cassert>
#include <cmath>

#include <fmt/format.h>

namespace cogrsim::figures {
namespace {

/// Label and unit of an axis from its signals: the text of a single signal, or else the common
/// part.
Axis axis_of(const std::vector<const Signal*>& signals) {
  Axis axis;
  if (signals.empty()) return axis;
  const Signal& first = *signals.front();
  bool same_text = true, same_quantity = true, same_unit = true;
  for (const Signal* signal : signals) {
    same_text = same_text && signal->text() == first.text();
    same_quantity = same_quantity && signal->quantity() == first.quantity();
    same_unit = same_unit && signal->unit() == first.unit();
  }
  if (same_text)
    axis.label = first.text();
  else if (same_quantity)
    axis.label = first.quantity();
  if (same_unit) axis.unit = first.unit();
  return axis;
}

/// The signal that distinguishes the series of a plot, for their labels.
const Signal& main_signal(Kind kind, const std::optional<Signal>& x, const std::optional<Signal>& y,
                          const std::optional<Signal>& z) {
  return kind == Kind::histogram ? *x : kind == Kind::surface ? *z : *y;
}

}  // namespace

PlotAxes plot_axes(Kind kind) {
  switch (kind) {
    case Kind::curve:
      return {true, true, false, true};
    case Kind::box:
      return {false, true, false, false};
    case Kind::histogram:
      return {true, false, false, false};
    case Kind::surface:
      return {true, true, true, false};
    case Kind::map:
      return {true, true, false, false};
  }
  return {};
}

Result<PlotSampler> PlotSampler::create(const PlotModel& plot, const SceneModel& model,
                                        const ChannelLookup& channels) {
  PlotSampler sampler;
  sampler.plot_ = plot;
  const std::string name = fmt::format("plot '{}'", plot.name);
  const SourcePosition where = source_position(model, plot.origin);
  const auto kind = kind_from(plot.kind);
  if (!kind) return fail(name + ": " + kind.error().message, where, kind.error().hint);
  sampler.kind_ = *kind;
  if (!(plot.every >= 0.0) || !std::isfinite(plot.every))
    return fail(name + ": the time between samples must not be negative", where);
  if (plot.series.empty()) return fail(name + " shows no signal", where);
  const PlotAxes axes = plot_axes(*kind);
  const SignalScope scope{model, channels, {}};
  for (const PlotSeries& series : plot.series) {
    Line line;
    const SourcePosition location = source_position(model, series.origin);
    const auto take = [&](const std::string& text, bool wanted, const char* optional,
                          const char* axis, std::optional<Signal>& signal) -> Result<> {
      const std::string given = text.empty() && wanted ? optional : text;
      if (given.empty() && wanted)
        return fail(fmt::format("{}: a {} needs a signal for {}", name, plot.kind, axis), location);
      if (!given.empty() && !wanted)
        return fail(
            fmt::format("{}: a {} has no use for {}, found '{}'", name, plot.kind, axis, given),
            location);
      if (given.empty()) return {};
      auto parsed = Signal::parse(scope, given);
      if (!parsed)
        return fail(fmt::format("{}: {}", name, parsed.error().message), location,
                    parsed.error().hint);
      sampler.needs_ = sampler.needs_ | parsed->needs();
      signal = std::move(*parsed);
      return {};
    };
    if (const auto good = take(series.x, axes.x, axes.x_optional ? "time" : "", "x", line.x); !good)
      return tl::unexpected(good.error());
    if (const auto good = take(series.y, axes.y, "", "y", line.y); !good)
      return tl::unexpected(good.error());
    if (const auto good = take(series.z, axes.z, "", "z", line.z); !good)
      return tl::unexpected(good.error());
    sampler.lines_.push_back(std::move(line));
  }
  return sampler;
}

void PlotSampler::take(const Frame& frame) {
  const double every = plot_.every;
  // Times are sums of steps, so a sample is due up to a millionth of the interval early.
  if (every > 0.0) {
    if (frame.time < next_ - 1e-6 * every) return;
    next_ = (std::floor(frame.time / every + 1e-6) + 1.0) * every;
  }
  const bool readings_once = every == 0.0 && (kind_ == Kind::box || kind_ == Kind::histogram);
  for (Line& line : lines_) {
    if (readings_once) {
      const std::uint64_t now = main_signal(kind_, line.x, line.y, line.z).revision(frame);
      if (now == line.revision) continue;
      line.revision = now;
    }
    if (line.x) line.xs.push_back(line.x->evaluate(frame));
    if (line.y) line.ys.push_back(line.y->evaluate(frame));
    if (line.z) line.zs.push_back(line.z->evaluate(frame));
  }
  ++taken_;
}

Result<Figure> figure_of(const std::vector<const PlotSampler*>& runs,
                         const std::vector<std::string>& labels) {
  assert(!runs.empty() && (labels.size() == runs.size() || (labels.empty() && runs.size() == 1)));
  const PlotSampler& first = *runs.front();
  Figure figure;
  figure.kind = first.kind_;
  figure.name = first.plot_.name;
  figure.title = first.plot_.title;
  std::vector<const Signal*> x, y, z, all;
  for (const PlotSampler* run : runs) {
    for (const PlotSampler::Line& line : run->lines_) {
      if (line.x) x.push_back(&*line.x);
      if (line.y) y.push_back(&*line.y);
      if (line.z) z.push_back(&*line.z);
      all.push_back(&main_signal(first.kind_, line.x, line.y, line.z));
    }
  }
  figure.x = axis_of(x);
  figure.y = axis_of(y);
  figure.z = axis_of(z);
  if (figure.kind == Kind::histogram) figure.y.label = "count";
  // If the units differ, the axis has none, and each series has its own.
  bool same_unit = true;
  for (const Signal* signal : all) same_unit = same_unit && signal->unit() == all.front()->unit();
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (std::size_t i = 0; i < runs[r]->lines_.size(); ++i) {
      const PlotSampler::Line& line = runs[r]->lines_[i];
      const Signal& signal = main_signal(first.kind_, line.x, line.y, line.z);
      const std::string& given = runs[r]->plot_.series[i].label;
      std::string label = given.empty() ? signal.text() : given;
      // The label of a path is the object and not its y coordinate.
      const std::string coordinate = "." + signal.quantity();
      if (given.empty() && first.kind_ == Kind::map && label.size() > coordinate.size() &&
          label.compare(label.size() - coordinate.size(), coordinate.size(), coordinate) == 0)
        label.erase(label.size() - coordinate.size());
      if (!same_unit && !signal.unit().empty() && signal.unit() != "1")
        label += " [" + signal.unit() + "]";
      const std::string run = labels.empty() ? "" : labels[r];
      if (!run.empty()) label = runs[r]->lines_.size() == 1 ? run : label + ", " + run;
      Series& series = add_series(figure, line.xs, line.ys, std::move(label));
      series.z = line.zs;
    }
  }
  if (auto good = complete(figure); !good) return tl::unexpected(good.error());
  return figure;
}

}  // namespace cogrsim::figures
