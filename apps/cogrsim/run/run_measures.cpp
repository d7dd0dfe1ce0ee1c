#include "run/run_measures.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/units.h"
#include "cogrsim/signals/condition.h"
#include "cogrsim/signals/signal.h"
#include "common/model_names.h"

namespace cogrsim::cli {
namespace {

struct Parsed {
  Signal signal;
  Condition condition;  // of first_time
};

bool is_own(const SceneModel& model, const MeasureModel& measure) {
  return std::any_of(model.measures.begin(), model.measures.end(), [&](const MeasureModel& own) {
    return own.name == measure.name && own.signal == measure.signal;
  });
}

// "ball", "ball2" and "ball.wheel" for "ball": the second of a name gets a number behind it.
bool goes_by(const std::string& name, const std::string& given) {
  if (given.empty() || name.compare(0, given.size(), given) != 0) return false;
  std::size_t end = given.size();
  while (end < name.size() && name[end] >= '0' && name[end] <= '9') ++end;
  return end == name.size() || name[end] == '.';
}

// Whether an action of the scene brings something of this name.
bool is_brought(const SceneModel& model, const std::string& name) {
  for (const RuleModel& rule : model.rules) {
    for (const Action& action : rule.actions) {
      if (const auto* spawn = std::get_if<Spawn>(&action);
          spawn != nullptr && goes_by(name, spawn->name.empty() ? spawn->of + "_" : spawn->name)) {
        return true;
      }
      if (const auto* attach = std::get_if<Attach>(&action);
          attach != nullptr && name == attach->name) {
        return true;
      }
    }
  }
  return false;
}

Result<Parsed> parse(const SceneModel& model, const ChannelLookup& channels,
                     const MeasureModel& measure) {
  SignalScope scope{model, channels, {}, {}};
  // Names in the scene's own have been checked when it was compiled, with those of its 'added'.
  const bool own = is_own(model, measure);
  scope.may_come = [&model, own](const std::string& name) {
    return !in_scene(model, name) && (own || is_brought(model, name));
  };
  const auto named = [&](Error error) {
    error.message = "measure '" + measure.name + "': " + error.message;
    return tl::unexpected(std::move(error));
  };
  Parsed parsed;
  if (measure.take == MeasureModel::Take::first_time) {
    auto condition = Condition::parse(scope, measure.signal);
    if (!condition) return named(condition.error());
    parsed.condition = std::move(*condition);
  } else {
    auto signal = Signal::parse(scope, measure.signal);
    if (!signal) return named(signal.error());
    parsed.signal = std::move(*signal);
  }
  return parsed;
}

}  // namespace

struct RunMeasures::Sample {
  MeasureModel model;
  Parsed parsed;
  double value = kNaN;  // last, extreme, first time
  // Mean over time and integral: by the trapezoidal rule between frames that have a value.
  double integral = 0.0, covered = 0.0;
  std::optional<double> last_time, last_value;

  void take(const Frame& frame) {
    using Take = MeasureModel::Take;
    if (model.take == Take::first_time) {
      if (std::isnan(value) && parsed.condition.holds(frame)) value = frame.time;
      return;
    }
    const double now = parsed.signal.evaluate(frame);
    if (std::isnan(now)) {
      last_time.reset();
      return;
    }
    if (model.take == Take::last) value = now;
    if (model.take == Take::minimum && !(value <= now)) value = now;
    if (model.take == Take::maximum && !(value >= now)) value = now;
    if (last_time) {
      integral += 0.5 * (now + *last_value) * (frame.time - *last_time);
      covered += frame.time - *last_time;
    }
    last_time = frame.time;
    last_value = now;
  }

  double result() const {
    using Take = MeasureModel::Take;
    if (model.take == Take::integral) return covered > 0.0 ? integral : kNaN;
    if (model.take == Take::mean) {
      if (covered > 0.0) return integral / covered;
      return last_value.value_or(kNaN);  // a run of one frame
    }
    return value;
  }

  std::string unit() const {
    using Take = MeasureModel::Take;
    if (model.take == Take::first_time) return "s";
    const std::string& own = parsed.signal.unit();
    return model.take == Take::integral ? units::combined_unit(own, '*', "s") : own;
  }
};

Result<> check_measure(const SceneModel& model, const MeasureModel& measure) {
  if (const auto parsed = parse(model, built_in_channels(model), measure); !parsed)
    return tl::unexpected(parsed.error());
  return {};
}

Result<RunMeasures> RunMeasures::attach(Simulation& simulation,
                                        std::vector<MeasureModel> measures) {
  RunMeasures out;
  out.samples_ = std::make_shared<std::vector<Sample>>();
  const ChannelLookup channels = [&](int sensor) { return &simulation.channels(sensor); };
  FrameContents needs;
  for (MeasureModel& measure : measures) {
    auto parsed = parse(*simulation.model(), channels, measure);
    if (!parsed) return tl::unexpected(parsed.error());
    needs = needs | parsed->signal.needs() | parsed->condition.needs();
    Sample sample;
    sample.model = std::move(measure);
    sample.parsed = std::move(*parsed);
    out.samples_->push_back(std::move(sample));
  }
  if (!out.samples_->empty()) {
    simulation.observe(needs, [samples = out.samples_](const FramePtr& frame) {
      for (Sample& sample : *samples) sample.take(*frame);
    });
  }
  return out;
}

std::vector<RunMeasures::Value> RunMeasures::values() const {
  std::vector<Value> out;
  for (const Sample& sample : *samples_)
    out.push_back({sample.model.name, sample.unit(), sample.result()});
  return out;
}

}  // namespace cogrsim::cli
