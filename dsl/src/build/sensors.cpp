// Sensors: their mounting, noise and parameters.
#include <algorithm>
#include <cmath>

#include "build/build_scene.h"
#include "cogrsim/core/image.h"
#include "cogrsim/sensing/sensor.h"
#include "cogrsim/sensing/sensor_models.h"

namespace cogrsim::dsl {
namespace {

struct NoiseWord {
  std::string_view name;
  NoiseTerm::Kind kind;
  std::size_t arguments;
  std::string_view usage;
};
constexpr NoiseWord kNoiseNames[] = {
    {"normal", NoiseTerm::Kind::normal, 2, "normal(mean, sigma)"},
    {"uniform", NoiseTerm::Kind::uniform, 2, "uniform(low, high)"},
    {"bias", NoiseTerm::Kind::bias, 1, "bias(offset)"},
    {"dropout", NoiseTerm::Kind::dropout, 1, "dropout(probability)"},
    {"quantisation", NoiseTerm::Kind::quantisation, 1, "quantisation(step)"},
    {"bias-walk", NoiseTerm::Kind::bias_walk, 1, "bias-walk(sigma)"}};

/// Attributes that disturb a second quantity of the sensor, NoiseTerm::group 1.
constexpr std::string_view kSecondNoise[] = {"gyro-noise", "torque-noise", "depth-noise"};

}  // namespace

bool Builder::noise(const Element& element, std::string_view attribute, int group,
                    std::vector<NoiseTerm>& terms) {
  const auto calls = reader(element).calls(attribute);
  if (calls.failed()) return false;
  if (!calls.given()) return true;
  for (const Call& call : *calls) {
    const NoiseWord* word = nullptr;
    std::vector<std::string> known;
    for (const NoiseWord& w : kNoiseNames) {
      known.emplace_back(w.name);
      if (w.name == call.function) word = &w;
    }
    if (word == nullptr) {
      sink()
          .report("CG0517", call.span, element.trail, "there is no noise '" + call.function + "'")
          .help(suggest(call.function, known));
      return false;
    }
    if (call.arguments.size() != word->arguments) {
      sink()
          .report("CG0517", call.span, element.trail,
                  "'" + call.function + "' takes " + std::to_string(word->arguments) +
                      (word->arguments == 1 ? " number" : " numbers") + ", found " +
                      std::to_string(call.arguments.size()))
          .help("write " + std::string(word->usage));
      return false;
    }
    NoiseTerm term;
    term.kind = word->kind;
    term.group = group;
    term.a = call.arguments[0].value;
    if (call.arguments.size() > 1) term.b = call.arguments[1].value;
    std::string problem;
    switch (term.kind) {
      case NoiseTerm::Kind::normal:
        if (term.b < 0) problem = "sigma must not be negative";
        break;
      case NoiseTerm::Kind::uniform:
        if (term.a > term.b) problem = "low must not exceed high";
        break;
      case NoiseTerm::Kind::dropout:
        if (term.a < 0 || term.a > 1) problem = "a probability lies between 0 and 1";
        if (!call.arguments[0].dimension.none()) problem = "a probability has no unit";
        break;
      case NoiseTerm::Kind::quantisation:
        if (!(term.a > 0)) problem = "the step must be above 0";
        break;
      case NoiseTerm::Kind::bias_walk:
        if (term.a < 0) problem = "sigma must not be negative";
        break;
      case NoiseTerm::Kind::bias:
        break;
    }
    if (!problem.empty()) {
      sink().report("CG0517", call.span, element.trail, call.function + ": " + problem);
      return false;
    }
    terms.push_back(term);
  }
  return true;
}

// The parameters of a sensor of the SDK: the attributes of the same names.
bool Builder::sensor_parameters(const Element& element, SensorModel& sensor) {
  bool good = true;
  Reader r = reader(element);
  const std::vector<PluginDescriptor> all = built_in_sensors();
  const auto own = std::find_if(all.begin(), all.end(),
                                [&](const PluginDescriptor& d) { return d.name == sensor.type; });
  if (own == all.end()) return true;
  for (const ParameterSpec& parameter : own->parameters) {
    const std::string& name = parameter.name;
    const AttributeSpec* spec = element.node->spec->find(name);
    if (spec == nullptr || (!r.has(name) && spec->default_text.empty())) continue;
    const auto take = [&](const auto& read, auto&& convert) {
      good = good && !read.failed();
      if (!read.failed()) sensor.parameters[name] = convert(*read);
    };
    const auto same = [](const auto& v) { return v; };
    switch (spec->kind) {
      case Kind::number:
        if (spec->dimensions.size() == 1) {
          take(r.number(name), same);
        } else if (sensor.joint >= 0) {  // of an encoder: as its joint moves
          const Joint& joint = model_.joints[sensor.joint];
          const auto axis = r.integer("axis");
          if (axis.failed()) return false;
          const bool turns = *axis > speed_count(joint.type) ||
                             axis_turns(joint.type, static_cast<int>(*axis) - 1);
          take(r.number(name, spec->dimensions[turns ? 0 : 1]), same);
        }
        break;
      case Kind::numbers:
        take(r.numbers(name), same);
        break;
      case Kind::range:
        if (!r.has(name)) break;  // the descriptor's own default
        take(r.range(name), [](const Interval& range) {
          return std::vector<double>{range.low, range.high};
        });
        break;
      case Kind::integer:
        take(r.integer(name), same);
        break;
      case Kind::boolean:
        take(r.boolean(name), same);
        break;
      default:
        take(r.text(name), same);
    }
  }
  return good;
}

// Values that would be refused at the start of the run are reported here, where the column is
// known.
bool Builder::camera_settings(const Element& element, const SensorModel& sensor) {
  Reader r = reader(element);
  const auto resolution = r.numbers("resolution");
  const std::vector<double>& size = *resolution;
  const auto refuse = [&](std::string_view attribute, const std::string& message) {
    fault("CG0710", element, attribute, message);
    return false;
  };
  if (size[0] != std::floor(size[0]) || size[1] != std::floor(size[1]))
    return refuse("resolution", "a picture has a whole number of columns and rows");
  if (size[0] * size[1] > static_cast<double>(kMaxImagePixels))
    return refuse("resolution", "a picture of " + number_text(size[0]) + " x " +
                                    number_text(size[1]) + " pixels exceeds the limit of " +
                                    std::to_string(kMaxImagePixels));
  if (*r.number("near") >= *r.number("far"))
    return refuse(r.has("near") ? "near" : "far", "near must be less than far");
  WorldState state;
  for (const Body& body : model_.bodies) state.poses.push_back(body.X_WB);
  state.twists.resize(model_.bodies.size());
  const auto request = camera_request(model_, sensor, state);
  if (request) return true;
  fault("CG0710", element, request.error().message).help(request.error().hint);
  return false;
}

void Builder::check_cameras() {
  for (const BuriedCamera& buried : buried_cameras(model_)) {
    const Element& element = *sensor_elements_[buried.sensor];
    fault("CG0711", element, buried.error.message).help(buried.error.hint);
  }
}

void Builder::check_delays() {
  for (const UnusableDelay& it : unusable_delays(model_, model_.physics.step)) {
    const auto at = static_cast<std::size_t>(it.index);
    fault("CG0716", *(it.motor ? motor_elements_ : sensor_elements_)[at],
          it.motor ? "delay" : "latency", it.error.message)
        .help(it.error.hint);
  }
}

void Builder::sensor(const Element& element) {
  SensorModel sensor;
  sensor.name = element.path;
  sensor.type = std::string(element.tag());
  sensor.assembly = note(element).assembly;
  sensor.origin = element.span();
  Reader r = reader(element);
  sensor.rate = *r.number("rate");
  rates_.push_back({&element, sensor.rate});
  sensor.latency = *r.number("latency");
  sensor.enabled = *r.boolean("enabled");
  sensor.show = *r.boolean("show");
  bool good = !note(element).faulty && noise(element, "noise", 0, sensor.noise);
  for (const std::string_view attribute : kSecondNoise)
    if (knows(element, attribute)) good = noise(element, attribute, 1, sensor.noise) && good;
  if (sensor.type == "sensor") {
    const auto plugin = r.text("plugin");
    if (plugin.given()) {
      sensor.type = *plugin;
      if (auto parameters = plugin_parameters(element, PluginKind::sensor, *plugin))
        sensor.parameters = std::move(*parameters);
      else
        good = false;
    }
  }
  if (knows(element, "joint") && r.has("joint")) {
    const auto word = r.word("joint");
    const Element* joint = word.given() ? names_.find(element, *word, Wanted::joint) : nullptr;
    good = good && joint != nullptr;
    if (joint != nullptr) sensor.joint = note(*joint).joint;
  }
  if (knows(element, "on") && r.has("on")) {
    const auto word = r.word("on");
    const auto body = word.given() ? body_at(element, *word, true) : std::nullopt;
    good = good && body.has_value();
    if (body) {
      sensor.body = *body;
      const Pose& X_WS = note(element).X_W;
      sensor.X_BS = *body == kWorld ? X_WS : model_.bodies[*body].X_WB.inverse() * X_WS;
    }
  } else if (sensor.joint >= 0) {
    const Joint& joint = model_.joints[sensor.joint];
    sensor.body = joint.child;
    sensor.X_BS = joint.X_CM;
  }
  if (element.tag() != "sensor") good = sensor_parameters(element, sensor) && good;
  if (good && element.tag() == "camera") good = camera_settings(element, sensor);
  if (good && element.tag() == "lidar") {
    constexpr std::int64_t kMost = 1'000'000;  // as the sensor has it
    const std::int64_t rays = *r.integer("rays") * *r.integer("rings");
    if (rays > kMost) {
      fault("CG0710", element, "rings",
            "a lidar with " + std::to_string(rays) + " rays exceeds the limit of " +
                std::to_string(kMost))
          .help("take fewer rays or rings");
      good = false;
    }
  }
  if (!good) return;
  model_.sensors.push_back(std::move(sensor));
  sensor_elements_.push_back(&element);
}

}  // namespace cogrsim::dsl
