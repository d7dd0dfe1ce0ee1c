// Joints: ends, frames and axes; couplings of joints; pairs of bodies that do not collide.
#include <algorithm>
#include <cmath>
#include <set>

#include "build/build_scene.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/model/builder.h"

namespace cogrsim::dsl {
namespace {

constexpr double kRightAngle = 1e-6;          // cosine that still counts as a right angle
constexpr std::size_t kMaxPairs = 4'000'000;  // of bodies named by all <collide> together

JointType type_of(std::string_view tag) {
  if (tag == "hinge") return JointType::hinge;
  if (tag == "slider") return JointType::slider;
  if (tag == "ball") return JointType::ball;
  if (tag == "universal") return JointType::universal;
  if (tag == "gimbal") return JointType::gimbal;
  if (tag == "cylindrical") return JointType::cylindrical;
  if (tag == "planar") return JointType::planar;
  if (tag == "screw") return JointType::screw;
  if (tag == "free") return JointType::free;
  return JointType::fixed;
}

std::string shown(double value, bool turns) {
  return turns ? number_text(std::round(value * 180.0 / kPi * 1e9) / 1e9) + " deg"
               : number_text(value) + " m";
}

std::size_t axis_count(JointType type) {
  if (type == JointType::ball) return 1;
  if (type == JointType::free) return 0;
  return static_cast<std::size_t>(speed_count(type));
}

}  // namespace

void Builder::joint(const Element& element) {
  Joint joint;
  joint.name = element.path;
  joint.type = type_of(element.tag());
  joint.assembly = note(element).assembly;
  joint.origin = element.span();
  engine_blocks(element, joint.engine_options);
  Reader r = reader(element);
  Note& here = note(element);
  here.joint = static_cast<int>(model_.joints.size());
  if (here.owner != nullptr) {
    here.faulty = true;
    fault("CG0609", element,
          "a joint inside the rigid '" + here.owner->path +
              "': its parts cannot move relative to each other")
        .help("move the joint out, or delete rigid=\"true\"");
  } else {
    std::optional<int> parent = kWorld, child;
    if (r.has("parent")) {
      const auto word = r.word("parent");
      parent = word.given() ? body_at(element, *word, true) : std::nullopt;
    }
    if (r.has("child")) {
      const auto word = r.word("child");
      child = word.given() ? body_at(element, *word, false) : std::nullopt;
    }
    if (!parent || !child) {
      here.faulty = true;
    } else {
      joint.parent = *parent;
      joint.child = *child;
      const auto mobile = [&](int body) {
        return body != kWorld && model_.bodies[body].kind == BodyKind::dynamic;
      };
      const std::string child_name = model_.bodies[joint.child].name;
      if (joint.parent == joint.child) {
        here.faulty = true;
        fault("CG0604", element, "child",
              "parent and child are both part of the body '" + child_name + "'");
      } else if (!mobile(joint.parent) && !mobile(joint.child)) {
        here.faulty = true;
        fault("CG0707", element,
              "the joint has no effect: '" + child_name + "' and " +
                  (joint.parent == kWorld ? std::string("the world")
                                          : "'" + model_.bodies[joint.parent].name + "'") +
                  " are static or kinematic");
      } else if (joint.type == JointType::free && joint.parent != kWorld) {
        here.faulty = true;
        fault("CG0608", element, "parent",
              "a free joint constrains nothing; its parent can only be the world")
            .help("delete 'parent', or choose a joint that constrains the motion");
      }
    }
  }
  bool good = !here.faulty;
  good = joint_frames(element, joint) && good;
  good = joint_axes(element, joint) && good;
  joint_start(element, joint);
  if (!good) here.faulty = true;
  joint.bodies_collide = r.boolean("collide").value;
  hints_.joint_position.push_back(!joint.position.empty());
  hints_.joint_velocity.push_back(!joint.velocity.empty());
  joint_elements_.push_back(&element);
  model_.joints.push_back(std::move(joint));
}

bool Builder::joint_frames(const Element& element, Joint& joint) {
  Reader r = reader(element);
  Pose X_WJ = note(element).X_W;
  bool good = true;
  Vec3 axis = Vec3::UnitZ();
  if (knows(element, "axis")) {
    const auto given = r.vec3("axis");
    axis = *given;
    good = !given.failed();
    if (good && !(axis.norm() > 1e-9)) {
      good = false;
      fault("CG0603", element, "axis", "the axis has zero length");
    }
  }
  if (!good) return false;
  axis.normalize();
  if (joint.type == JointType::universal || joint.type == JointType::gimbal) {
    const auto given = r.vec3("axis2");
    if (given.failed()) return false;
    if (!((*given).norm() > 1e-9)) {
      fault("CG0603", element, "axis2", "the axis has zero length");
      return false;
    }
    const Vec3 second = (*given).normalized();
    const double cosine = std::clamp(axis.dot(second), -1.0, 1.0);
    if (std::abs(cosine) > kRightAngle) {
      fault("CG0606", element, element.find("axis2") != nullptr ? "axis2" : "axis",
            std::string("the two axes of a ") + to_string(joint.type) +
                " joint must be at a right angle, these are at " + shown(std::acos(cosine), true));
      return false;
    }
    Mat3 axes;
    axes << axis, second, axis.cross(second);
    X_WJ.q = (X_WJ.q * Quat(axes)).normalized();
  } else if (axis != Vec3::UnitZ()) {
    X_WJ.q = (X_WJ.q * z_to(axis)).normalized();
  }
  if (note(element).faulty) return false;
  const auto in_body = [&](int body) {
    return body == kWorld ? X_WJ : model_.bodies[body].X_WB.inverse() * X_WJ;
  };
  joint.X_PF = in_body(joint.parent);
  joint.X_CM = in_body(joint.child);
  if (joint.type == JointType::screw) {
    const auto pitch = r.number("pitch");
    if (!pitch.given()) return false;
    joint.pitch = *pitch;
    if (joint.pitch == 0.0) {
      fault("CG0507", element, "pitch", "a screw without pitch does not travel")
          .help("use a hinge");
      return false;
    }
  }
  return true;
}

bool Builder::joint_axes(const Element& element, Joint& joint) {
  const std::size_t n = axis_count(joint.type);
  joint.axes.assign(n, JointAxis{});
  if (n == 0) return true;
  Reader r = reader(element);
  bool good = true;
  const auto take = [&](std::string_view attribute, double JointAxis::*field, double sign = 1.0) {
    if (!knows(element, attribute) || !r.has(attribute)) return;
    std::vector<double> values;
    if (n == 1) {
      const auto given = r.number(attribute);
      if (given.given()) values = {*given};
    } else {
      const auto given = r.numbers(attribute);
      if (given.given()) values = *given;
    }
    if (values.size() != n) {
      good = false;
      return;
    }
    // "none" reads as infinite; which infinity depends on the side it bounds.
    for (std::size_t i = 0; i < n; ++i)
      joint.axes[i].*field = std::isfinite(values[i]) ? values[i] : sign * kInfinity;
  };
  take("lower", &JointAxis::lower, -1.0);
  take("upper", &JointAxis::upper);
  take("damping", &JointAxis::damping);
  take("friction", &JointAxis::friction);
  take("stiffness", &JointAxis::stiffness);
  take("rest", &JointAxis::rest);
  take("max-effort", &JointAxis::max_effort);
  take("max-speed", &JointAxis::max_speed);
  take("rotor-inertia", &JointAxis::rotor_inertia);
  if (joint.type == JointType::ball) joint.axes[0].lower = 0.0;
  if (!good) return false;
  for (std::size_t i = 0; i < n; ++i) {
    const JointAxis& axis = joint.axes[i];
    if (axis.lower < axis.upper) continue;
    const bool turns = axis_turns(joint.type, static_cast<int>(i));
    fault("CG0703", element, element.find("upper") != nullptr ? "upper" : "lower",
          "lower limit " + shown(axis.lower, turns) + " is not below upper limit " +
              shown(axis.upper, turns))
        .help(axis.lower == axis.upper ? "a joint that cannot move is a <fixed>"
                                       : "did you mean lower=\"" + shown(axis.upper, turns) +
                                             "\" upper=\"" + shown(axis.lower, turns) + "\"?");
    good = false;
  }
  if (joint.type == JointType::ball && !std::isfinite(joint.axes[0].upper))
    joint.axes[0].lower = -kInfinity;  // no cone, no limit
  return good;
}

// Initial coordinates and speeds as written; empty where they are not.
void Builder::joint_start(const Element& element, Joint& joint) {
  if (joint.type == JointType::fixed) return;
  Reader r = reader(element);
  const auto take = [&](std::string_view attribute, int count, std::vector<double>& out) {
    if (!r.has(attribute)) return;
    if (count == 1) {
      const auto given = r.number(attribute);
      if (given.given()) out = {*given};
    } else {
      const auto given = r.numbers(attribute);
      if (given.given()) out = *given;
    }
    if (out.size() != static_cast<std::size_t>(count)) {
      out.clear();
      note(element).faulty = true;
    }
  };
  take("position", position_count(joint.type), joint.position);
  take("velocity", speed_count(joint.type), joint.velocity);
  if (!joint.position.empty() && (joint.type == JointType::ball || joint.type == JointType::free)) {
    const std::size_t first = joint.type == JointType::ball ? 0 : 3;
    double* q = &joint.position[first];
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6)) {
      fault("CG0603", element, "position", "a quaternion of zero length is not a rotation")
          .help("no rotation is \"1 0 0 0\"");
      note(element).faulty = true;
      joint.position.clear();
    } else {
      for (int i = 0; i < 4; ++i) q[i] /= length;
    }
  }
  if (note(element).faulty) return;
  // A joint without an initial position starts at 0.
  for (std::size_t i = 0; i < joint.axes.size(); ++i) {
    const JointAxis& axis = joint.axes[i];
    const bool is_ball = joint.type == JointType::ball;
    const double q = joint.position.empty() ? 0.0
                     : is_ball ? 2.0 * std::acos(std::min(1.0, std::abs(joint.position[0])))
                               : joint.position[i];
    if (q >= axis.lower && q <= axis.upper) continue;
    if (!(axis.lower < axis.upper)) continue;  // reported already
    const bool turns = axis_turns(joint.type, static_cast<int>(i));
    const bool low = q < axis.lower;
    fault("CG0607", element,
          element.find("position") != nullptr ? "position"
          : low                               ? "lower"
                                              : "upper",
          "the joint starts at " + shown(q, turns) + ", " + (low ? "below" : "above") +
              " its limit " + shown(low ? axis.lower : axis.upper, turns))
        .help("give 'position' a value between the limits");
    note(element).faulty = true;
  }
}

void Builder::coupling(const Element& element) {
  Coupling coupling;
  coupling.name = element.path;
  coupling.assembly = note(element).assembly;
  coupling.origin = element.span();
  engine_blocks(element, coupling.engine_options);
  Reader r = reader(element);
  const auto find = [&](const Word& word, std::string_view attribute) {
    const Element* found = names_.find(element, word, Wanted::joint);
    if (found == nullptr || note(*found).joint < 0) return -1;
    const Joint& joint = model_.joints[note(*found).joint];
    if (joint.axes.size() == 1 && joint.type != JointType::ball) return note(*found).joint;
    fault("CG0714", element, attribute,
          "'" + joint.name + "' is " + kind_of(*found) +
              " joint: only joints with one axis can be "
              "coupled")
        .help("couple hinges, sliders and screws");
    return -1;
  };
  const auto follower = r.word("joint");
  if (follower.given()) coupling.joint = find(*follower, "joint");
  const auto words = r.words("to");
  const auto ratios = r.numbers("ratio");
  if (coupling.joint < 0 || !words.given() || ratios.failed()) return;
  const std::vector<double>& values = *ratios;
  if (values.size() != (*words).size()) {
    fault("CG0714", element, r.has("ratio") ? "ratio" : "to",
          std::to_string((*words).size()) + " joints in 'to' and " + std::to_string(values.size()) +
              (values.size() == 1 ? " ratio" : " ratios"))
        .help("give one ratio for each joint");
    return;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int joint = find((*words)[i], "to");
    if (joint < 0) return;
    const bool twice = joint == coupling.joint ||
                       std::any_of(coupling.terms.begin(), coupling.terms.end(),
                                   [&](const CouplingTerm& t) { return t.joint == joint; });
    if (twice) {
      fault("CG0714", element, "to",
            "'" + model_.joints[joint].name +
                (joint == coupling.joint ? "' cannot follow itself" : "' is named twice"));
      return;
    }
    coupling.terms.push_back({joint, values[i]});
  }
  const auto same =
      std::find_if(model_.couplings.begin(), model_.couplings.end(),
                   [&](const Coupling& other) { return other.joint == coupling.joint; });
  if (same != model_.couplings.end()) {
    fault("CG0714", element, "joint",
          "'" + model_.joints[coupling.joint].name + "' already follows other joints")
        .note("here", same->origin);
    return;
  }
  const Joint& joint = model_.joints[coupling.joint];
  const bool turns = axis_turns(joint.type, 0);
  const auto offset = r.number("offset", turns ? dim::kAngle : dim::kLength);
  if (offset.given()) coupling.offset = *offset;
  effort_limit("CG0714", element, "'" + joint.name + "'", turns, coupling.max_effort);
  couple_start(element, coupling);
  coupling_elements_.push_back(&element);
  model_.couplings.push_back(std::move(coupling));
}

// Joints that follow each other in a cycle contradict each other, or say the same twice: h = 2 k and
// k = 2 h leave h = k = 0 only.
void Builder::coupling_cycles() {
  std::vector<int> of_joint(model_.joints.size(), -1);
  for (std::size_t i = 0; i < model_.couplings.size(); ++i)
    of_joint[static_cast<std::size_t>(model_.couplings[i].joint)] = static_cast<int>(i);
  enum class Seen : char { no, open, done };
  std::vector<Seen> seen(model_.couplings.size(), Seen::no);
  struct Step {
    std::size_t coupling, term;
  };
  for (std::size_t start = 0; start < seen.size(); ++start) {
    std::vector<Step> path;
    if (seen[start] == Seen::no) path.push_back({start, 0});
    while (!path.empty()) {
      const auto [at, term] = path.back();
      const Coupling& here = model_.couplings[at];
      seen[at] = Seen::open;
      if (term == here.terms.size()) {
        seen[at] = Seen::done;
        path.pop_back();
        continue;
      }
      ++path.back().term;
      const int next = of_joint[static_cast<std::size_t>(here.terms[term].joint)];
      if (next < 0) continue;
      const auto to = static_cast<std::size_t>(next);
      if (seen[to] == Seen::no) path.push_back({to, 0});
      if (seen[to] != Seen::open) continue;
      // From the one that closes the cycle back to where it leads.
      const auto name = [&](std::size_t i) {
        return "'" + model_.joints[static_cast<std::size_t>(model_.couplings[i].joint)].name + "'";
      };
      auto report = fault("CG0714", *coupling_elements_[at], "to",
                          name(at) + " follows " + name(to) + ", which follows it: the couplings " +
                              "form a cycle");
      for (auto step = path.rbegin() + 1; step != path.rend(); ++step) {
        report.note(name(step->coupling) + " follows here",
                    coupling_elements_[step->coupling]->span());
        if (step->coupling == to) break;
      }
      report.help("leave one of them out");
    }
  }
}

// The joint starts where the coupling puts it, or has to be given there.
void Builder::couple_start(const Element& element, const Coupling& coupling) {
  constexpr double kOff = 1e-6;  // [rad], [m] and per second
  Joint& joint = model_.joints[coupling.joint];
  double q = coupling.offset, u = 0.0;
  const auto value = [](const std::vector<double>& values) {
    return values.empty() ? 0.0 : values[0];
  };
  for (const CouplingTerm& term : coupling.terms) {
    const Joint& other = model_.joints[term.joint];
    q += term.ratio * value(other.position);
    u += term.ratio * value(other.velocity);
  }
  const bool turns = axis_turns(joint.type, 0);
  const auto index = static_cast<std::size_t>(coupling.joint);
  if (joint.position.empty()) joint.position = {q};
  hints_.joint_position[index] = true;
  if (joint.velocity.empty() && u != 0.0) {
    joint.velocity = {u};
    hints_.joint_velocity[index] = true;
  }
  if (std::abs(joint.position[0] - q) > kOff) {
    fault("CG0714", element, "joint",
          "'" + joint.name + "' starts at " + shown(joint.position[0], turns) +
              ", but the coupling needs " + shown(q, turns))
        .help("leave its position out, or correct ratio and offset");
  } else if (std::abs(value(joint.velocity) - u) > kOff) {
    fault("CG0714", element, "joint",
          "'" + joint.name + "' does not start with the velocity that the coupling needs")
        .help("leave its velocity out");
  } else if (q < joint.axes[0].lower - kOff || q > joint.axes[0].upper + kOff) {
    fault("CG0714", element, "joint",
          "the coupling puts '" + joint.name + "' at " + shown(q, turns) +
              " at the start, beyond its limits");
  }
}

// <collide> in file order: later ones overrule earlier ones.
void Builder::collision_pairs() {
  std::set<BodyPair> separated;
  std::map<BodyPair, std::vector<std::size_t>> joined;
  for (std::size_t j = 0; j < model_.joints.size(); ++j) {
    const Joint& joint = model_.joints[j];
    if (joint.parent != kWorld) joined[std::minmax(joint.parent, joint.child)].push_back(j);
  }
  std::size_t pairs = 0;
  for_each(scene_, [&](const Element& element) {
    if (element.tag() != "collide") return;
    Reader r = reader(element);
    const auto words = r.words("between");
    const auto with = r.boolean("with");
    if (!words.given() || (*words).size() != 2) return;
    std::vector<int> sides[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const Element* named = names_.find(element, (*words)[k], Wanted::matter);
      if (named == nullptr) return;
      const Note& n = note(*named);
      if (n.owner != nullptr)
        sides[k].push_back(n.body);
      else
        for_each(*named, [&](const Element& inner) {
          if (note(inner).owner == &inner) sides[k].push_back(note(inner).body);
        });
    }
    pairs += sides[0].size() * sides[1].size();
    if (pairs > kMaxPairs) {
      fault("CG0306", element, "between",
            "the scene names more than " + std::to_string(kMaxPairs) + " pairs of bodies");
      return;
    }
    if (sides[0].size() == 1 && sides[0] == sides[1]) {
      fault("CG0604", element, "between", "a body does not collide with itself anyway");
      return;
    }
    for (const int a : sides[0])
      for (const int b : sides[1]) {
        if (a == b) continue;
        const BodyPair pair = std::minmax(a, b);
        if (*with)
          separated.erase(pair);
        else
          separated.insert(pair);
        if (const auto it = joined.find(pair); it != joined.end())
          for (const std::size_t j : it->second) model_.joints[j].bodies_collide = *with;
      }
  });
  model_.no_collide.assign(separated.begin(), separated.end());
}

}  // namespace cogrsim::dsl
