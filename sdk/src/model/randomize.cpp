#include "cogrsim/model/randomize.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "cogrsim/core/random.h"
#include "cogrsim/model/joint_kinematics.h"
#include "core/index.h"
#include "model/motor_limits.h"

namespace cogrsim {
namespace {

using units::Dimension;
namespace dim = units::dim;

struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool above = false;
};
constexpr Bounds kDelay{0.0, kLongestDelay, false};
constexpr Bounds kPositive{0.0, std::numeric_limits<double>::infinity(), true};
constexpr Bounds kNotNegative{0.0};

/// Moves an assembly, or a body alone, with all that is fixed in the world there.
class Moved {
 public:
  /// `assembly` or `body` is -1.
  Moved(const SceneModel& model, int assembly, int body) : body_(body) {
    if (assembly < 0) return;
    assemblies_.assign(model.assemblies.size(), false);
    for (std::size_t i = 0; i < assemblies_.size(); ++i) {
      // A parent precedes its children.
      const int parent = model.assemblies[i].parent;
      assemblies_[i] = static_cast<int>(i) == assembly || (parent >= 0 && assemblies_[at(parent)]);
    }
  }

  bool has_assembly(int index) const {
    return index >= 0 && at(index) < assemblies_.size() && assemblies_[at(index)];
  }
  bool has_body(const SceneModel& model, int index) const {
    return index != kWorld && (index == body_ || has_assembly(model.bodies[at(index)].assembly));
  }

  /// Whether no joint connects it to other bodies.
  bool is_free(const SceneModel& model) const {
    return std::all_of(model.joints.begin(), model.joints.end(), [&](const Joint& joint) {
      // A joint to the world that is part of it moves with it.
      const auto inside = [&](int index) {
        return index == kWorld ? has_assembly(joint.assembly) : has_body(model, index);
      };
      const bool touches = has_body(model, joint.parent) || has_body(model, joint.child);
      return joint.removed || !touches || (inside(joint.parent) && inside(joint.child));
    });
  }

  void move(SceneModel& model, const Vec3& by) const {
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      if (has_body(model, static_cast<int>(i))) model.bodies[i].X_WB.p += by;
    }
    for (std::size_t i = 0; i < model.assemblies.size(); ++i) {
      if (has_assembly(static_cast<int>(i))) model.assemblies[i].X_WA.p += by;
    }
    const auto in_world = [&](int assembly, int body, Vec3& place) {
      if (body == kWorld && has_assembly(assembly)) place += by;
    };
    for (NamedFrame& x : model.frames) in_world(x.assembly, x.body, x.X_BF.p);
    for (Joint& x : model.joints) {
      in_world(x.assembly, x.parent, x.X_PF.p);
      in_world(x.assembly, x.child, x.X_CM.p);
    }
    for (ForceModel& x : model.forces) {
      in_world(x.assembly, x.body, x.X_BE.p);
      in_world(x.assembly, x.other, x.other_point);
    }
    for (SensorModel& x : model.sensors) in_world(x.assembly, x.body, x.X_BS.p);
    for (RegionModel& x : model.regions) in_world(x.assembly, x.body, x.X_BR.p);
  }

 private:
  int body_;
  std::vector<bool> assemblies_;
};

class Collector {
 public:
  Collector(const SceneModel& model, const std::function<bool(const std::string&)>& wanted)
      : model_(model), wanted_(wanted) {}

  std::vector<VariableQuantity> run() {
    for (std::size_t i = 0; i < model_.materials.size(); ++i) material(i);
    for (std::size_t i = 0; i < model_.assemblies.size(); ++i) {
      if (!model_.assemblies[i].removed)
        place(model_.assemblies[i].name, static_cast<int>(i), -1, model_.assemblies[i].X_WA.p);
    }
    for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
      if (!model_.bodies[i].removed) body(i);
    }
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      if (!model_.joints[i].removed) joint(i);
    }
    for (std::size_t i = 0; i < model_.motors.size(); ++i) {
      if (!model_.motors[i].removed) motor(i);
    }
    for (std::size_t i = 0; i < model_.forces.size(); ++i) {
      if (!model_.forces[i].removed) force(i);
    }
    for (std::size_t i = 0; i < model_.sensors.size(); ++i) {
      if (!model_.sensors[i].removed) sensor(i);
    }
    return std::move(out_);
  }

 private:
  bool has(const std::string& owner, const char* quantity) {
    return wanted_(owner + "." + quantity);
  }

  void add(const std::string& owner, const char* quantity, std::optional<Dimension> dimension,
           const Bounds& bounds, std::vector<double> values,
           std::function<void(SceneModel&, const std::vector<double>&)> set) {
    VariableQuantity out;
    out.name = owner + "." + quantity;
    out.dimension = dimension;
    out.low = bounds.low;
    out.high = bounds.high;
    out.above = bounds.above;
    out.values = std::move(values);
    out.set = std::move(set);
    out_.push_back(std::move(out));
  }

  /// A number of an element of a list.
  template <class Element>
  void member(const char* quantity, const Dimension& dimension, const Bounds& bounds,
              std::vector<Element> SceneModel::*list, std::size_t i, double Element::*number) {
    const Element& element = (model_.*list)[i];
    if (!has(element.name, quantity)) return;
    add(element.name, quantity, dimension, bounds, {element.*number},
        [list, i, number](SceneModel& model, const std::vector<double>& v) {
          (model.*list)[i].*number = v[0];
        });
  }

  struct Surface {
    const char* name;
    double Material::*number;
    Dimension dimension;
    Bounds bounds;
  };
  static const std::vector<Surface>& surfaces() {
    static const std::vector<Surface> all = {
        {"friction", &Material::friction, dim::kNone, kNotNegative},
        {"rolling-friction", &Material::rolling_friction, dim::kLength, kNotNegative},
        {"spinning-friction", &Material::spinning_friction, dim::kLength, kNotNegative},
        {"restitution", &Material::restitution, dim::kNone, {0.0, 1.0}}};
    return all;
  }

  void material(std::size_t i) {
    const Material& material = model_.materials[i];
    if (material.name.empty()) return;
    for (const Surface& it : surfaces()) {
      if (!has(material.name, it.name)) continue;
      const double before = material.*it.number;
      const auto number = it.number;
      add(material.name, it.name, it.dimension, it.bounds, {before},
          [i, number, before](SceneModel& model, const std::vector<double>& v) {
            model.materials[i].*number = v[0];
            // Materials of shapes that override another property.
            for (Material& other : model.materials) {
              if (other.base == static_cast<int>(i) && other.*number == before)
                other.*number = v[0];
            }
          });
    }
  }

  void place(const std::string& name, int assembly, int body, const Vec3& p) {
    static constexpr const char* kAxes[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
      if (!has(name, kAxes[axis])) continue;
      const Moved moved(model_, assembly, body);
      if (!moved.is_free(model_)) return;
      const double before = p[axis];
      add(name, kAxes[axis], dim::kLength, {}, {before},
          [moved, axis, before](SceneModel& model, const std::vector<double>& v) {
            moved.move(model, (v[0] - before) * Vec3::Unit(axis));
          });
    }
  }

  void body(std::size_t i) {
    const Body& body = model_.bodies[i];
    if (body.kind == BodyKind::dynamic) {
      if (has(body.name, "mass")) {
        add(body.name, "mass", dim::kMass, kPositive, {body.mass},
            [i](SceneModel& model, const std::vector<double>& v) {
              Body& changed = model.bodies[i];
              changed.inertia *= v[0] / changed.mass;
              changed.mass = v[0];
            });
      }
      static constexpr const char* kCom[] = {"com.x", "com.y", "com.z"};
      for (int axis = 0; axis < 3; ++axis) {
        if (!has(body.name, kCom[axis])) continue;
        add(body.name, kCom[axis], dim::kLength, {}, {body.com[axis]},
            [i, axis](SceneModel& model, const std::vector<double>& v) {
              model.bodies[i].com[axis] = v[0];
            });
      }
    }
    place(body.name, -1, static_cast<int>(i), body.X_WB.p);
    for (const Surface& it : surfaces()) {
      if (body.shapes.empty() || !has(body.name, it.name)) continue;
      const auto number = it.number;
      std::vector<double> values;
      for (const Shape& shape : body.shapes)
        values.push_back(model_.materials[at(shape.material)].*number);
      add(body.name, it.name, it.dimension, it.bounds, std::move(values),
          [i, number](SceneModel& model, const std::vector<double>& v) {
            for (std::size_t k = 0; k < v.size(); ++k) {
              Shape& shape = model.bodies[i].shapes[k];
              Material own = model.materials[at(shape.material)];
              if (!own.name.empty()) own.base = shape.material;
              own.name.clear();
              own.*number = v[k];
              shape.material = static_cast<int>(model.materials.size());
              model.materials.push_back(std::move(own));
            }
          });
    }
  }

  void joint(std::size_t i) {
    const Joint& joint = model_.joints[i];
    struct AxisNumber {
      const char* name;
      double JointAxis::*number;
      Dimension turning, sliding;
      Bounds bounds;
    };
    static const std::vector<AxisNumber> kNumbers = {
        {"damping", &JointAxis::damping, dim::kAngularDamping, dim::kDamping, kNotNegative},
        {"friction", &JointAxis::friction, dim::kTorque, dim::kForce, kNotNegative},
        {"stiffness", &JointAxis::stiffness, dim::kAngularStiffness, dim::kStiffness, kNotNegative},
        {"rotor-inertia", &JointAxis::rotor_inertia, dim::kInertia, dim::kMass, kNotNegative},
        {"max-effort", &JointAxis::max_effort, dim::kTorque, dim::kForce, kPositive}};
    for (const AxisNumber& it : kNumbers) {
      if (joint.axes.empty() || !has(joint.name, it.name)) continue;
      // A joint with both kinds of axes has no common unit.
      const bool turns = joint.type == JointType::ball || axis_turns(joint.type, 0);
      bool one_kind = true;
      for (std::size_t k = 1; k < joint.axes.size(); ++k)
        one_kind = one_kind && axis_turns(joint.type, static_cast<int>(k)) == turns;
      std::optional<Dimension> dimension;
      if (one_kind) dimension = turns ? it.turning : it.sliding;
      const auto number = it.number;
      std::vector<double> values;
      for (const JointAxis& axis : joint.axes) values.push_back(axis.*number);
      add(joint.name, it.name, dimension, it.bounds, std::move(values),
          [i, number](SceneModel& model, const std::vector<double>& v) {
            for (std::size_t k = 0; k < v.size(); ++k) model.joints[i].axes[k].*number = v[k];
          });
    }
  }

  void motor(std::size_t i) {
    const Motor& motor = model_.motors[i];
    const bool turns = axis_turns(model_.joints[at(motor.joint)].type, motor.axis);
    const auto number = [&](const char* name, double Motor::*which, const Dimension& turning,
                            const Dimension& sliding, const Bounds& bounds) {
      member(name, turns ? turning : sliding, bounds, &SceneModel::motors, i, which);
    };
    number("max-effort", &Motor::max_effort, dim::kTorque, dim::kForce, kPositive);
    number("max-speed", &Motor::max_speed, dim::kAngularSpeed, dim::kSpeed, kPositive);
    if (has_curve(motor)) {
      number("stall-effort", &Motor::stall_effort, dim::kTorque, dim::kForce, kPositive);
      number("no-load-speed", &Motor::no_load_speed, dim::kAngularSpeed, dim::kSpeed, kPositive);
    }
    number("delay", &Motor::delay, dim::kTime, dim::kTime, kDelay);
    if (motor.mode != MotorMode::servo) return;
    number("kp", &Motor::kp, dim::kAngularStiffness, dim::kStiffness, kNotNegative);
    number("ki", &Motor::ki, dim::kAngularIntegralGain, dim::kIntegralGain, kNotNegative);
    number("kd", &Motor::kd, dim::kAngularDamping, dim::kDamping, kNotNegative);
  }

  void force(std::size_t i) {
    const auto number = [&](const char* name, double ForceModel::*which, const Dimension& unit) {
      member(name, unit, kNotNegative, &SceneModel::forces, i, which);
    };
    if (model_.forces[i].kind == ForceModel::Kind::spring) {
      number("stiffness", &ForceModel::stiffness, dim::kStiffness);
      number("damping", &ForceModel::damping, dim::kDamping);
    } else if (model_.forces[i].kind == ForceModel::Kind::drag) {
      number("linear", &ForceModel::linear, dim::kDamping);
      number("quadratic", &ForceModel::quadratic, dim::kLinearDensity);
      number("angular", &ForceModel::angular, {2, 1, -1, 0, -1});
    } else if (model_.forces[i].kind == ForceModel::Kind::wind) {
      static constexpr const char* kAxes[] = {"x", "y", "z"};
      for (int axis = 0; axis < 3; ++axis) {
        if (!has(model_.forces[i].name, kAxes[axis])) continue;
        add(model_.forces[i].name, kAxes[axis], dim::kSpeed, {}, {model_.forces[i].wind[axis]},
            [i, axis](SceneModel& model, const std::vector<double>& v) {
              model.forces[i].wind[axis] = v[0];
            });
      }
    } else if (model_.forces[i].kind == ForceModel::Kind::buoyancy) {
      member("density", dim::kDensity, kPositive, &SceneModel::forces, i, &ForceModel::density);
      member("level", dim::kLength, {}, &SceneModel::forces, i, &ForceModel::level);
    }
  }

  void sensor(std::size_t i) {
    const SensorModel& sensor = model_.sensors[i];
    member("latency", dim::kTime, kDelay, &SceneModel::sensors, i, &SensorModel::latency);
    if (!has(sensor.name, "noise-sigma")) return;
    std::vector<double> values;
    for (const NoiseTerm& term : sensor.noise) {
      if (term.kind == NoiseTerm::Kind::normal) values.push_back(term.b);
    }
    if (values.empty()) return;
    add(sensor.name, "noise-sigma", std::nullopt, kNotNegative, std::move(values),
        [i](SceneModel& model, const std::vector<double>& v) {
          auto next = v.begin();
          for (NoiseTerm& term : model.sensors[i].noise) {
            if (term.kind == NoiseTerm::Kind::normal) term.b = *next++;
          }
        });
  }

  const SceneModel& model_;
  const std::function<bool(const std::string&)>& wanted_;
  std::vector<VariableQuantity> out_;
};

bool complete(const RandomizeModel& randomize) {
  return randomize.shape == RandomizeModel::Shape::choice ? !randomize.numbers.empty()
                                                          : randomize.numbers.size() == 2;
}

double draw(const RandomizeModel& randomize, RandomStream& random) {
  const std::vector<double>& n = randomize.numbers;
  switch (randomize.shape) {
    case RandomizeModel::Shape::uniform:
      return random.uniform(n[0], n[1]);
    case RandomizeModel::Shape::normal:
      return random.normal(n[0], n[1]);
    case RandomizeModel::Shape::loguniform:
      return std::exp(random.uniform(std::log(n[0]), std::log(n[1])));
    case RandomizeModel::Shape::choice:
      break;
  }
  const double place = random.uniform() * static_cast<double>(n.size());
  return n[std::min(static_cast<std::size_t>(place), n.size() - 1)];
}

}  // namespace

bool VariableQuantity::valid(double value) const {
  return !std::isnan(value) && value <= high && (above ? value > low : value >= low);
}

bool matches_pattern(std::string_view name, std::string_view pattern) {
  std::size_t i = 0, k = 0, star = std::string_view::npos, from = 0;
  while (i < name.size()) {
    if (k < pattern.size() && pattern[k] == '*') {
      star = k++;
      from = i;
    } else if (k < pattern.size() && pattern[k] == name[i]) {
      ++i;
      ++k;
    } else if (star != std::string_view::npos) {
      k = star + 1;
      i = ++from;
    } else {
      return false;
    }
  }
  while (k < pattern.size() && pattern[k] == '*') ++k;
  return k == pattern.size();
}

std::vector<VariableQuantity> variable_quantities(
    const SceneModel& model, const std::function<bool(const std::string&)>& wanted) {
  return Collector(model, wanted).run();
}

double drawn_value(const RandomizeModel& randomize, double value, double number) {
  switch (randomize.how) {
    case RandomizeModel::How::multiply:
      return value * number;
    case RandomizeModel::How::add:
      return value + number;
    case RandomizeModel::How::set:
      break;
  }
  return number;
}

SceneModelPtr with_drawn_values(SceneModelPtr scene) {
  if (scene->randomize.empty() || !scene->drawn.empty()) return scene;
  auto model = std::make_shared<SceneModel>(*scene);
  for (const RandomizeModel& randomize : model->randomize) {
    if (!complete(randomize)) continue;
    const std::set<std::string> names(randomize.quantities.begin(), randomize.quantities.end());
    std::vector<VariableQuantity> found = variable_quantities(
        *model, [&](const std::string& name) { return names.count(name) != 0; });
    const std::string path =
        "randomize " + std::to_string(static_cast<int>(randomize.how)) + " " + randomize.what;
    RandomStream common(model->physics.seed, path);
    for (const VariableQuantity& quantity : found) {
      RandomStream own(model->physics.seed, path + " " + quantity.name);
      // All of `together` get the first number of one stream that is valid for them.
      RandomStream random = randomize.together ? common : own;
      constexpr int kMostTries = 1000;
      std::vector<double> values;
      for (int tries = 0; tries < kMostTries; ++tries) {
        const double number = draw(randomize, random);
        values.clear();
        for (const double value : quantity.values)
          values.push_back(drawn_value(randomize, value, number));
        const bool good = std::all_of(values.begin(), values.end(),
                                      [&](double value) { return quantity.valid(value); });
        if (good) break;
        values = quantity.values;
      }
      quantity.set(*model, values);
      model->drawn.push_back({quantity.name, values.front()});
    }
  }
  return model;
}

}  // namespace cogrsim
