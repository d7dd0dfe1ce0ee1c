#include "series.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "run_fields.h"
#include "scene_json.h"

namespace cogrsim::studio {

namespace {

constexpr std::size_t kPiece = 1000;      // frames taken at a time
constexpr std::size_t kCurvesKept = 200;  // signals remembered
constexpr double kNever = -std::numeric_limits<double>::infinity();

/// Channels of a run's sensors by name: a second run may number them otherwise.
ChannelLookup channels_for(const SceneRecord& record, const SceneModel& model) {
  if (&model == record.model.get()) return record.lookup();
  return [&record, &model](int sensor) -> const std::vector<Channel>* {
    if (sensor < 0 || static_cast<std::size_t>(sensor) >= model.sensors.size()) return nullptr;
    const std::string& name = model.sensors[sensor].name;
    for (std::size_t i = 0; i < record.model->sensors.size(); ++i) {
      if (record.model->sensors[i].name == name) return &record.channels[i];
    }
    return nullptr;
  };
}

Result<Signal> parse(const SceneRecord& record, const SceneModel& model, const std::string& text) {
  SignalScope scope{model, channels_for(record, model), {}, {}};
  return Signal::parse(scope, text);
}

Json axis_json(const figures::Axis& axis) {
  return {{"label", axis.label}, {"unit", axis.unit}, {"log", axis.log}};
}

/// Lowest and highest of each of at most `points` intervals with frames in them.
struct Thinned {
  std::vector<double> time, low, high;
};

}  // namespace

void SeriesRequests::forget_old() {
  const std::uint64_t epoch = frames_.epoch();
  for (auto entry = curves_.begin(); entry != curves_.end();) {
    entry = entry->second.epoch != epoch ? curves_.erase(entry) : std::next(entry);
  }
  for (auto entry = figures_.begin(); entry != figures_.end();) {
    entry = entry->second.epoch != epoch ? figures_.erase(entry) : std::next(entry);
  }
  if (divergence_.epoch != epoch) divergence_ = {};
  while (curves_.size() > kCurvesKept) {
    curves_.erase(std::min_element(
        curves_.begin(), curves_.end(),
        [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
}

Answer SeriesRequests::signals() {
  const SceneRecordPtr record = scenes_.newest();
  Json list = Json::array();
  if (!record) return Json{{"signals", list}};
  const SceneModel& model = *record->model;
  std::set<std::string> seen;
  const auto add = [&](const std::string& text, const std::string& owner) {
    const auto signal = parse(*record, model, text);
    if (!signal || !seen.insert(text).second) return;
    list.push_back({{"name", text}, {"unit", signal->unit()}, {"owner", owner}});
  };
  add("time", "");
  for (const char* energy : {"kinetic", "potential", "total"}) {
    add(std::string("energy.") + energy, "energy");
  }
  const auto add_poses = [&](const auto& elements) {
    for (const auto& element : elements) {
      if (element.removed) continue;
      for (const char* quantity : {"x", "y", "z", "speed", "roll", "pitch", "yaw"}) {
        add(element.name + "." + quantity, element.name);
      }
    }
  };
  std::vector<Body> moving;
  for (const Body& body : model.bodies) {
    if (body.removed || body.kind == BodyKind::static_body) continue;
    Body plain;
    plain.name = body.name;
    moving.push_back(std::move(plain));
  }
  add_poses(moving);
  add_poses(model.assemblies);
  for (const Joint& joint : model.joints) {
    if (joint.removed) continue;
    for (const char* quantity : {"position", "velocity", "effort"}) {
      const int count = quantity[0] == 'p' ? position_count(joint.type) : speed_count(joint.type);
      for (int i = 0; i < count; ++i) {
        add(joint.name + "." + quantity + (count > 1 ? "[" + std::to_string(i) + "]" : ""),
            joint.name);
      }
    }
  }
  for (const Motor& motor : model.motors) {
    if (!motor.removed) add(motor.name + ".effort", motor.name);
  }
  for (std::size_t i = 0; i < model.sensors.size(); ++i) {
    if (model.sensors[i].removed) continue;
    for (const Channel& channel : record->channels[i]) {
      add(model.sensors[i].name + "." + channel.name, model.sensors[i].name);
    }
  }
  for (const auto* controllers : {&model.controllers, &model.supervisors}) {
    for (const ControllerModel& controller : *controllers) {
      if (controller.removed) continue;
      for (const OutputModel& output : controller.outputs)
        add(controller.name + "." + output.name, controller.name);
    }
  }
  return Json{{"signals", std::move(list)}};
}

void SeriesRequests::look_up(Curve& curve, const SceneModelPtr& model, std::uint32_t scene) {
  curve.model = model;
  curve.signal = Signal();
  const SceneRecordPtr record = scenes_.get(scene);
  if (!record) return;
  if (auto signal = parse(*record, *model, curve.text)) curve.signal = std::move(*signal);
}

void SeriesRequests::extend(Curve& curve) {
  double until = curve.times.empty() ? kNever : curve.times.back();
  for (;;) {
    const std::vector<Instant> more = frames_.after(until, kPiece);
    if (more.empty() || frames_.epoch() != curve.epoch) return;
    for (const Instant& instant : more) {
      until = instant.time();
      const FramePtr& frame = curve.ghost ? instant.ghost : instant.frame;
      double value = std::numeric_limits<double>::quiet_NaN();
      if (frame) {
        if (frame->model != curve.model) look_up(curve, frame->model, instant.scene);
        value = curve.signal.evaluate(*frame);
      }
      curve.times.push_back(until);
      curve.values.push_back(value);
    }
  }
}

Result<SeriesRequests::Curve*> SeriesRequests::curve(const std::string& text, bool ghost) {
  Curve& curve = curves_[{text, ghost}];
  if (curve.epoch == 0) {
    const SceneRecordPtr record = scenes_.newest();
    auto signal = record ? parse(*record, *record->model, text)
                         : Result<Signal>(fail("there is no scene yet"));
    if (!signal) {
      curves_.erase({text, ghost});
      return tl::unexpected(signal.error());
    }
    curve.text = text;
    curve.ghost = ghost;
    curve.unit = signal->unit();
    curve.epoch = frames_.epoch();
  }
  curve.used = ++uses_;
  extend(curve);
  return &curve;
}

Answer SeriesRequests::series(const Json& f) {
  const auto from = fields::maybe<double>(f, "from"), to = fields::maybe<double>(f, "to");
  const auto points = f.at("points").get<std::size_t>();
  forget_old();
  std::vector<Curve*> curves;
  for (const Json& name : f.at("signals")) {
    auto found = curve(name.get<std::string>(), f.contains("run"));
    if (!found) return tl::unexpected(found.error());
    curves.push_back(*found);
  }
  Json list = Json::array(), time = Json::array();
  // All were read up to the same frame, except for frames that have come in between.
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();
  const Curve* shortest = nullptr;
  for (const Curve* one : curves) {
    if (!shortest || one->times.size() < shortest->times.size()) shortest = one;
  }
  std::vector<double> times = shortest ? shortest->times : std::vector<double>();
  if (from) {
    first = static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), *from) -
                                     times.begin());
  }
  last = to ? static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), *to) -
                                       times.begin())
            : times.size();
  const std::size_t count = last > first ? last - first : 0;
  const std::size_t intervals = std::min(count, points);
  const auto begin = [&](std::size_t i) { return first + i * count / intervals; };
  for (std::size_t i = 0; i < intervals; ++i) time.push_back(times[begin(i)]);
  for (const Curve* one : curves) {
    Json low = Json::array(), high = Json::array();
    // A signal first asked for later may have been read from frames that were dropped since.
    std::size_t at = 0;
    for (std::size_t i = 0; i < intervals; ++i) {
      const std::size_t end = i + 1 < intervals ? begin(i + 1) : last;
      const double until = end < times.size() ? times[end] : times.back() + 1.0;
      while (at < one->times.size() && one->times[at] < times[begin(i)]) ++at;
      double least = std::numeric_limits<double>::quiet_NaN(), most = least;
      for (; at < one->times.size() && one->times[at] < until; ++at) {
        least = std::fmin(least, one->values[at]);
        most = std::fmax(most, one->values[at]);
      }
      low.push_back(least);
      high.push_back(most);
    }
    list.push_back({{"signal", one->text},
                    {"unit", one->unit},
                    {"low", std::move(low)},
                    {"high", std::move(high)}});
  }
  return Json{{"time", std::move(time)}, {"series", std::move(list)}};
}

Answer SeriesRequests::plots() {
  Json list = Json::array();
  if (const SceneRecordPtr record = scenes_.newest()) {
    for (const PlotModel& plot : record->model->plots) {
      Json series = Json::array();
      for (const PlotSeries& s : plot.series) {
        series.push_back({{"x", s.x}, {"y", s.y}, {"z", s.z}, {"label", s.label}});
      }
      list.push_back({{"name", plot.name},
                      {"kind", plot.kind},
                      {"title", plot.title},
                      {"series", std::move(series)}});
    }
  }
  return Json{{"plots", std::move(list)}};
}

Answer SeriesRequests::figure(const Json& f) {
  const auto name = f.at("plot").get<std::string>();
  forget_old();
  const SceneRecordPtr record = scenes_.newest();
  const PlotModel* plot = nullptr;
  if (record) {
    for (const PlotModel& one : record->model->plots) {
      if (one.name == name) plot = &one;
    }
  }
  if (!plot) return fail("there is no plot '" + name + "'");
  Figure& figure = figures_[name];
  if (!figure.sampler || figure.lineage != record->lineage) {
    auto made = figures::PlotSampler::create(*plot, *record->model, record->lookup());
    if (!made) {
      figures_.erase(name);
      return tl::unexpected(made.error());
    }
    figure = {frames_.epoch(), record->lineage, kNever,
              std::make_unique<figures::PlotSampler>(std::move(*made))};
  }
  for (;;) {
    const std::vector<Instant> more = frames_.after(figure.until, kPiece);
    if (more.empty()) break;
    for (const Instant& instant : more) {
      figure.until = instant.time();
      // The plot may not fit the scene before an edit.
      const SceneRecordPtr of = scenes_.get(instant.scene);
      if (of && of->lineage == figure.lineage) figure.sampler->take(*instant.frame);
    }
  }
  auto drawn = figures::figure_of({figure.sampler.get()}, {});
  if (!drawn) return tl::unexpected(drawn.error());
  Json series = Json::array();
  for (const figures::Series& s : drawn->series) {
    series.push_back({{"label", s.label}, {"x", s.x}, {"y", s.y}, {"z", s.z}});
  }
  return Json{{"name", name},
              {"kind", figures::to_string(drawn->kind)},
              {"title", drawn->title},
              {"x", axis_json(drawn->x)},
              {"y", axis_json(drawn->y)},
              {"z", axis_json(drawn->z)},
              {"series", std::move(series)}};
}

Answer SeriesRequests::divergence(const std::array<std::string, 2>& labels, const Json& first) {
  forget_old();
  if (!divergence_.comparison) {
    divergence_.epoch = frames_.epoch();
    divergence_.until = kNever;
    divergence_.comparison = std::make_unique<cli::Comparison>(
        std::vector<std::string>{labels[0], labels[1]}, cli::CompareOptions());
  }
  for (;;) {
    const std::vector<Instant> more = frames_.after(divergence_.until, kPiece);
    if (more.empty()) break;
    for (const Instant& instant : more) {
      divergence_.until = instant.time();
      if (!instant.ghost) continue;
      divergence_.comparison->add(instant.time(), {instant.frame, instant.ghost});
    }
  }
  cli::Comparison copy = *divergence_.comparison;
  const cli::CompareResult result = copy.finish();
  std::vector<double> worst(result.times.size(), 0.0), worst_angle(result.times.size(), 0.0);
  const auto raise = [](std::vector<double>& most, const std::vector<double>& by) {
    for (std::size_t i = 0; i < most.size() && i < by.size(); ++i) {
      most[i] = std::fmax(most[i], by[i]);
    }
  };
  Json bodies = Json::array();
  for (const cli::Difference& body : result.bodies) {
    if (body.distance) raise(worst, body.distance->curve);
    if (body.angle) raise(worst_angle, body.angle->curve);
    if (body.distance && bodies.size() < 10) {
      bodies.push_back({{"name", body.name}, {"distance", body.distance->curve}});
    }
  }
  return Json{{"time", result.times},        {"worst", worst}, {"worst_angle", worst_angle},
              {"bodies", std::move(bodies)}, {"first", first}, {"labels", labels}};
}

}  // namespace cogrsim::studio
