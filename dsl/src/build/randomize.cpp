// Quantities that are drawn for each run.
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "build/build_scene.h"
#include "cogrsim/model/randomize.h"
#include "cogrsim/sensing/sensor_models.h"

namespace cogrsim::dsl {
namespace {

using Form = RandomizeModel::Shape;

struct Distribution {
  std::string_view name;
  Form shape;
  std::string_view usage;
};
constexpr Distribution kDistributions[] = {
    {"uniform", Form::uniform, "uniform(low, high)"},
    {"normal", Form::normal, "normal(mean, sigma)"},
    {"loguniform", Form::loguniform, "loguniform(low, high)"},
    {"choice", Form::choice, "choice(first, second, third)"}};

/// What is wrong with the numbers of a distribution; empty: nothing.
std::string number_problem(const Distribution& distribution, const std::vector<double>& n) {
  if (distribution.shape == Form::choice) return n.empty() ? "takes at least one value" : "";
  if (n.size() != 2) return fmt::format("takes 2 numbers, found {}", n.size());
  if (distribution.shape == Form::normal) return n[1] < 0.0 ? "sigma must not be negative" : "";
  if (n[0] > n[1]) return "low must not exceed high";
  if (distribution.shape == Form::loguniform && !(n[0] > 0.0)) return "low must be above 0";
  return "";
}

bool is_delay(const std::string& quantity) {
  const std::string last = quantity.substr(quantity.rfind('.') + 1);
  return last == "delay" || last == "latency";
}

}  // namespace

void Builder::randomize(const Element& element) {
  RandomizeModel out;
  out.origin = element.span();
  Reader r = reader(element);
  const auto what = r.text("what");
  const auto together = r.boolean("together");
  std::string_view attribute;
  using How = RandomizeModel::How;
  for (const auto& [word, how] :
       {std::pair("by", How::multiply), std::pair("to", How::set), std::pair("add", How::add)}) {
    if (!r.has(word)) continue;
    if (!attribute.empty()) {
      fault("CG0608", element, word,
            fmt::format("'{}' and '{}' exclude each other", attribute, word));
      return;
    }
    attribute = word;
    out.how = how;
  }
  if (attribute.empty()) {
    fault("CG1204", element, "a <randomize> without a distribution")
        .help("write by=\"uniform(0.9, 1.1)\" to multiply, or to=\"…\" or add=\"…\"");
    return;
  }
  const auto calls = r.calls(attribute);
  if (!calls.given() || !what.given() || together.failed()) return;
  out.what = *what;
  out.together = *together;
  if ((*calls).size() != 1) {
    fault("CG1204", element, attribute,
          fmt::format("one distribution is needed, found {}", (*calls).size()));
    return;
  }
  const Call& call = (*calls).front();
  const Distribution* distribution = nullptr;
  std::vector<std::string> known;
  for (const Distribution& it : kDistributions) {
    known.emplace_back(it.name);
    if (it.name == call.function) distribution = &it;
  }
  if (distribution == nullptr) {
    sink()
        .report("CG1204", call.span, element.trail,
                "there is no distribution '" + call.function + "'")
        .help(suggest(call.function, known));
    return;
  }
  out.shape = distribution->shape;
  for (const Quantity& argument : call.arguments) out.numbers.push_back(argument.value);
  if (const auto problem = number_problem(*distribution, out.numbers); !problem.empty()) {
    sink()
        .report("CG1204", call.span, element.trail, call.function + ": " + problem)
        .help("write " + std::string(distribution->usage));
    return;
  }
  if (drawn_quantities(element, call, attribute, out)) model_.randomize.push_back(std::move(out));
}

// Finds the quantities, and checks units and values.
bool Builder::drawn_quantities(const Element& element, const Call& call, std::string_view attribute,
                               RandomizeModel& out) {
  const std::size_t elements = model_.materials.size() + model_.assemblies.size() +
                               model_.bodies.size() + model_.joints.size() + model_.motors.size() +
                               model_.forces.size() + model_.sensors.size();
  if (!spend(element, elements * (16 + out.what.size()))) return false;
  std::vector<std::string> names;
  const auto found = variable_quantities(model_, [&](const std::string& name) {
    names.push_back(name);
    return matches_pattern(name, out.what);
  });
  if (found.empty()) {
    // Whatever failed to be built is missing here.
    if (sink().has_errors()) return false;
    const std::size_t dot = out.what.rfind('.');
    const std::string near = nearest_name(out.what, names);
    fault("CG1203", element, "what", "nothing here is called '" + out.what + "'")
        .help(!near.empty() ? "did you mean '" + near + "'?"
              : dot == std::string::npos
                  ? std::string("write ELEMENT.QUANTITY, for example robot.*.mass")
                  : std::string("the reference lists the quantities; a place needs a body "
                                "without joints, or the whole assembly"));
    return false;
  }
  // The numbers at which a value is smallest or largest, and the one that must be possible.
  std::vector<double> ends = out.numbers;
  if (out.shape == Form::normal) ends.pop_back();
  SceneModel late;  // as late as motors and sensors can become, if it is about that
  std::set<std::string> delays;
  for (const VariableQuantity& quantity : found) {
    const bool factor = out.how == RandomizeModel::How::multiply;
    if (!factor && !quantity.dimension) {
      fault("CG0502", element, attribute,
            "'" + quantity.name + "' has no unit of its own and can only be multiplied")
          .help("write by=\"" + call.function + "(…)\"");
      return false;
    }
    const Dimension wanted = factor ? Dimension{} : *quantity.dimension;
    for (const Quantity& argument : call.arguments) {
      if (argument.dimension.none() || fits(argument.dimension, wanted)) continue;
      sink().report("CG0502", call.span, element.trail,
                    "'" + quantity.name + (factor ? "' is multiplied: " : "': ") + "expected " +
                        describe(wanted) + ", found " + describe(argument.dimension));
      return false;
    }
    double longest = 0.0;
    for (const double value : quantity.values) {
      for (const double end : ends) {
        const double drawn = drawn_value(out, value, end);
        longest = std::max(longest, drawn);
        if (quantity.valid(drawn)) continue;
        sink()
            .report(
                "CG1204", call.span, element.trail,
                fmt::format("'{}' can become {:.4g}, but must be {} {:.4g}", quantity.name, drawn,
                            drawn > quantity.high ? "at most"
                            : quantity.above      ? "above"
                                                  : "at least",
                            drawn > quantity.high ? quantity.high : quantity.low))
            .help("choose narrower bounds");
        return false;
      }
    }
    out.quantities.push_back(quantity.name);
    if (is_delay(quantity.name)) {
      if (delays.empty()) {
        late.motors = model_.motors;
        late.sensors = model_.sensors;
      }
      quantity.set(late, {longest});
      delays.insert(quantity.name);
    }
  }
  if (delays.empty()) return true;
  for (const UnusableDelay& it : unusable_delays(late, model_.physics.step)) {
    const auto at = static_cast<std::size_t>(it.index);
    const std::string name =
        it.motor ? late.motors[at].name + ".delay" : late.sensors[at].name + ".latency";
    if (delays.count(name) == 0) continue;
    sink()
        .report("CG1204", call.span, element.trail,
                fmt::format("'{}' can become too long: {}", name, it.error.message))
        .help("choose narrower bounds");
    return false;
  }
  return true;
}

}  // namespace cogrsim::dsl
