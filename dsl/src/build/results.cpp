// Results of a run: its recording and plots.
#include <algorithm>
#include <filesystem>

#include "build/build_scene.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/figures/plot_sampler.h"
#include "cogrsim/signals/signal.h"
#include "syntax/text.h"

namespace cogrsim::dsl {
namespace {

constexpr std::string_view kSignals[] = {"x", "y", "z"};

std::string& entry(PlotSeries& series, std::size_t axis) {
  return axis == 0 ? series.x : axis == 1 ? series.y : series.z;
}

/// Whether the kind of plot uses the axis.
bool wanted(const figures::PlotAxes& axes, std::size_t axis) {
  return axis == 0 ? axes.x : axis == 1 ? axes.y : axes.z;
}

/// Whether an object with signals has this name. A refused element has a name but is not in the
/// model.
bool in_model(const SceneModel& model, const std::string& name) {
  const auto among = [&](const auto& elements) {
    for (const auto& element : elements)
      if (element.name == name) return true;
    return false;
  };
  return among(model.assemblies) || among(model.bodies) || among(model.joints) ||
         among(model.motors) || among(model.sensors) || among(model.frames) ||
         among(model.controllers) || among(model.supervisors) || among(model.regions) ||
         among(model.doors);
}

/// Whether elements of this kind have signals once they are in the model.
bool has_signals(const Element& element) {
  const std::string_view tag = element.tag();
  return is_shape(tag) || is_joint(tag) || is_sensor(element.node->spec) || tag == "body" ||
         tag == "assembly" || tag == "instance" || tag == "frame" || tag == "motor" ||
         tag == "servo" || tag == "controller" || tag == "supervisor" || tag == "region" ||
         tag == "door";
}

}  // namespace

/// Of the SDK's sensors and, where there is a catalog, of plugins'.
ChannelLookup Builder::channels() {
  return [this, built_in = built_in_channels(model_)](int sensor) -> const std::vector<Channel>* {
    if (const auto* known = built_in(sensor)) return known;
    const SensorModel& given = model_.sensors[sensor];
    PluginCatalog* plugins = context_.options.plugins;
    if (plugins == nullptr || built_in_sensor(given.type) != nullptr) return nullptr;
    const auto [entry, is_new] = plugin_channels_.try_emplace(sensor);
    if (is_new) entry->second = plugins->channels(model_, given);
    return entry->second.empty() ? nullptr : &entry->second;
  };
}

/// The signal with names in full; nullopt: reported, or caused by an earlier failure.
std::optional<std::string> Builder::signal(const Element& element, std::string_view attribute,
                                           const std::string& text) {
  return with_signals("CG1201", element, attribute, text, {}, [&](const SignalScope& scope) {
    return Signal::parse(scope, text).map([](const Signal& signal) { return signal.text(); });
  });
}

/// Names that spawned objects may have.
const std::vector<std::string>& Builder::spawned_names() {
  if (spawned_names_) return *spawned_names_;
  std::vector<std::string>& names = spawned_names_.emplace();
  for_each(scene_, [&](const Element& spawn) {
    if (spawn.tag() != "spawn") return;
    if (spawn.find("name") == nullptr) {  // its name is that of its template and a number
      if (const auto of = reader(spawn).text("of"); of.given()) names.push_back(*of + "_");
      return;
    }
    names.push_back(spawn.path);
    names.push_back(spawn.path.substr(spawn.path.rfind('.') + 1));
  });
  return names;
}

/// The result of `parse` for `text`, with names as written in `element`. Objects with a name in
/// `added`, or the name of something that is spawned, may come during the run.
std::optional<std::string> Builder::with_signals(
    std::string_view code, const Element& element, std::string_view attribute,
    const std::string& text, const std::vector<std::string>& added,
    const std::function<Result<std::string>(const SignalScope&)>& parse) {
  // Each operator keeps its text, and each name is looked up among all names.
  const std::size_t names = static_cast<std::size_t>(context_.element_count) + added.size();
  if (!spend(element, 2 * names + text.size() * (64 + text.size() / 8))) return std::nullopt;
  bool lost = false;
  const Element* without = nullptr;  // found, but there are no signals of it
  SignalScope scope{model_, channels(), {}};
  scope.resolve = [&](const std::string& name) -> std::string {
    const Names::Found found = names_.peek(element, name);
    lost = lost || found.lost;
    if (found.element == nullptr) return in_model(model_, name) ? name : std::string();
    if (!in_model(model_, found.element->path)) without = found.element;
    return found.element->path;
  };
  scope.may_come = [&added, &spawned = spawned_names()](const std::string& name) {
    const auto is_it = [&name](const std::string& one) {
      if (one.empty() || name.compare(0, one.size(), one) != 0) return false;
      // The second of a name gets a number behind it.
      std::size_t end = one.size();
      while (end < name.size() && is_digit(name[end])) ++end;
      return end == name.size() || name[end] == '.';
    };
    return std::any_of(spawned.begin(), spawned.end(), is_it) ||
           std::any_of(added.begin(), added.end(), is_it);
  };
  const auto parsed = parse(scope);
  if (parsed) return *parsed;
  if (lost) return std::nullopt;
  if (without == nullptr) {
    fault(code, element, attribute, parsed.error().message).help(parsed.error().hint);
    return std::nullopt;
  }
  const int body = note(*without).body;
  const bool part = is_shape(without->tag()) && body != kWorld;
  if (!part && has_signals(*without) && sink().has_errors()) return std::nullopt;  // it was refused
  const std::string whole = part ? model_.bodies[body].name : "";
  fault(code, element, attribute,
        part ? "'" + without->path + "' is a part of '" + whole + "' and has no signals of its own"
             : "'" + without->path + "' is " + kind_of(*without) + ", which has no signals")
      .help(part ? "name the whole: '" + whole + "'"
                 : "bodies, assemblies, frames, joints, motors and sensors have some");
  return std::nullopt;
}

void Builder::record(const Element& element) {
  if (model_.record) {
    fault("CG0207", element, "a second <record>");
    return;
  }
  RecordModel record;
  record.origin = element.span();
  Reader r = reader(element);
  const auto file = r.text("file");
  record.file = *file;
  if (file.given() && (*file).empty()) {
    fault("CG0403", element, "file", "the name of the recording is empty")
        .help("leave 'file' out to name it after the scene");
  } else if (file.given()) {
    const auto output = output_in("", *file);
    if (!output) {
      fault("CG0403", element, "file", output.error().message).help(output.error().hint);
    } else if (std::filesystem::path(*file).extension() != ".mcap") {
      fault("CG0403", element, "file", "a recording's name ends in .mcap")
          .help("write file=\"" + std::filesystem::path(*file).stem().string() + ".mcap\"");
    }
  }
  record.every = *r.number("every");
  record.contacts = *r.boolean("contacts");
  record.images = *r.boolean("images");
  record.jpeg = *r.text("format") == "jpeg";
  model_.record = std::move(record);
}

void Builder::plot(const Element& element) {
  PlotModel plot;
  plot.name = element.path;
  plot.origin = element.span();
  Reader r = reader(element);
  plot.title = *r.text("title");
  plot.every = *r.number("every");
  const auto word = r.text("kind");
  if (word.failed()) return;
  plot.kind = *word;
  const figures::PlotAxes axes = figures::plot_axes(*figures::kind_from(plot.kind));
  const std::string what = "a " + plot.kind + (plot.kind == "box" ? " plot" : "");

  std::vector<const Element*> lines;
  for (const Element* child : element.children)
    if (child->tag() == "series") lines.push_back(child);
  const bool alone = lines.empty();
  if (alone) lines.push_back(&element);
  if (plot.kind == "surface" && lines.size() > 1)
    fault("CG1202", *lines[1], "a surface shows one series, this is the second")
        .help("make it a plot of its own");

  for (const Element* line : lines) {
    PlotSeries series;
    series.origin = line->span();
    series.label = *reader(*line).text("label");
    bool misplaced = false;  // a signal is on an unused axis: it is the missing one
    for (std::size_t axis = 0; axis < std::size(kSignals); ++axis)
      misplaced = misplaced || (!wanted(axes, axis) && (line->find(kSignals[axis]) != nullptr ||
                                                        element.find(kSignals[axis]) != nullptr));
    for (std::size_t axis = 0; axis < std::size(kSignals); ++axis) {
      const std::string_view name = kSignals[axis];
      // Signals of the plot itself hold for all its series.
      const Element& from = line->find(name) != nullptr ? *line : element;
      const auto text = reader(from).text(name);
      if (text.failed()) continue;
      if (text.given() && !wanted(axes, axis)) {
        fault("CG1202", from, name, what + " does not use '" + std::string(name) + "'")
            .help(plot.kind == "histogram" ? "a histogram counts the values of 'x'"
                  : plot.kind == "box"     ? "a box plot shows the values of 'y'"
                                           : "a surface has x, y and z");
        continue;
      }
      if (text.given()) {
        if (auto full = signal(from, name, *text)) entry(series, axis) = std::move(*full);
        continue;
      }
      if (!wanted(axes, axis)) continue;
      if (axis == 0 && axes.x_optional)
        series.x = "time";
      else if (!misplaced)
        fault("CG1202", *line, what + " needs a signal for '" + std::string(name) + "'")
            .help("for example " + std::string(name) + "=\"robot." +
                  (axis == 2 || plot.kind == "curve" || plot.kind == "box" ? "speed"
                                                                           : std::string(name)) +
                  "\"");
    }
    plot.series.push_back(std::move(series));
  }
  if (!alone)
    for (const std::string_view name : {"x", "y", "z", "label"}) {
      const bool used = name != "label" && std::any_of(lines.begin(), lines.end(), [&](auto* line) {
                          return line->find(name) == nullptr;
                        });
      if (element.find(name) != nullptr && !used)
        fault("CG1202", element, name, "no series of the plot uses its '" + std::string(name) + "'")
            .help("move it into a <series> of its own");
    }
  model_.plots.push_back(std::move(plot));
}

}  // namespace cogrsim::dsl
