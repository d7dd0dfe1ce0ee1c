// Checks of the finished model: initial states that joints do not allow, and warnings.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include <fmt/format.h>

#include "build/build_scene.h"
#include "build/check_overlap.h"
#include "cogrsim/core/constants.h"

namespace cogrsim::dsl {
namespace {

constexpr double kMassRatio = 1000.0;  // of bodies that a joint holds together
// A body of `ratio` times the mass of the one it stands on presses it in by d: k sweeps of impulses
// pass on k / ratio of the speed that is wanted, and that is erp d / h for the overlap to go away.
// It has to be g h, the speed that gravity gives in a step h: d = ratio g h^2 / (k erp), k erp is 4
// to 13 by default. A cube of 4 cm is lost on engines that sweep from ratio g h^2 of 1 to 3 mm on.
constexpr double kMostPressed = 1e-3;  // ratio g h^2 [m]
constexpr std::size_t kShownOverlaps = 20;

// Four digits are enough to find a mistake.
std::string rounded(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.4g %s", value, unit);
  return text;
}

std::string distance_and_angle(double metres, double radians) {
  std::string out;
  if (metres > 1e-6) out = rounded(metres * 1e3, "mm");
  if (radians > 1e-6) out += (out.empty() ? "" : " and ") + rounded(radians * 180.0 / kPi, "deg");
  return out;
}

bool is_word_char(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

using NameSet = std::set<std::string, std::less<>>;

void add_words(std::string_view text, NameSet& out) {
  for (std::size_t begin = 0; begin < text.size();) {
    std::size_t end = begin;
    while (end < text.size() && is_word_char(text[end])) ++end;
    if (end > begin) out.emplace(text.substr(begin, end - begin));
    begin = end + 1;
  }
}

// The words in expressions of a node and of all nodes below, including branches that were not
// built.
void add_mentioned(const Node& node, NameSet& out) {
  for (const Attribute& attribute : node.attributes) {
    const AttributeSpec* spec = node.spec != nullptr ? node.spec->find(attribute.name) : nullptr;
    if ((attribute.value.find("${") != std::string_view::npos ||
         (spec != nullptr && spec->kind == Kind::expression)))
      add_words(attribute.value, out);
  }
  for (const Node* child : node.children) add_mentioned(*child, out);
}

// Joints that a motor or a coupling moves.
std::set<int> driven_joints(const SceneModel& model) {
  std::set<int> joints;
  for (const Motor& motor : model.motors) joints.insert(motor.joint);
  for (const Coupling& coupling : model.couplings) {
    joints.insert(coupling.joint);
    for (const CouplingTerm& term : coupling.terms) joints.insert(term.joint);
  }
  return joints;
}

}  // namespace

void Builder::start() {
  mark_loops(model_);
  for (const StartProblem& problem : settle_start(model_, hints_)) {
    const auto j = static_cast<std::size_t>(problem.joint);
    const Element& element = *joint_elements_[j];
    const std::string name = "joint '" + model_.joints[j].name + "'";
    const std::string off = distance_and_angle(problem.linear, problem.angular);
    switch (problem.kind) {
      case StartProblem::Kind::gap:
        fault("CG0605", element,
              name + " closes a loop, but its anchors are " + off + " apart at the start")
            .help("the initial positions of the other joints in the loop do not agree with it");
        break;
      case StartProblem::Kind::position:
        fault("CG0605", element, "position",
              name + " closes a loop, and the other joints put it " + off +
                  " away from this position")
            .help("leave 'position' out here: it follows from the others");
        break;
      case StartProblem::Kind::velocity: {
        std::string speeds;
        if (problem.linear > 1e-6) speeds = rounded(problem.linear, "m/s");
        if (problem.angular > 1e-6)
          speeds += (speeds.empty() ? "" : " and ") + rounded(problem.angular, "rad/s");
        fault("CG0610", element,
              name + ": it does not allow the initial relative velocity of its bodies, " + speeds)
            .help("give only one body a velocity; that of the other follows from the joint");
        break;
      }
    }
  }
}

void Builder::check_overlaps() {
  const geometry::Overlaps overlaps = geometry::find_overlaps(model_);
  const JointPaths paths(model_);
  std::size_t shown = 0;
  for (const geometry::Overlap& overlap : overlaps.pairs) {
    if (++shown > kShownOverlaps) {
      fault("CG2001", scene_,
            std::to_string(overlaps.pairs.size() - kShownOverlaps) +
                " or more other pairs of bodies start inside each other");
      break;
    }
    const Body& a = model_.bodies[overlap.body_a];
    const Body& b = model_.bodies[overlap.body_b];
    // The ground is assumed to be right; the moving body is the misplaced one.
    const bool second = b.kind == BodyKind::dynamic;
    const Element& mover = *body_elements_[second ? overlap.body_b : overlap.body_a];
    const Element& other = *body_elements_[second ? overlap.body_a : overlap.body_b];
    Report report = fault("CG2001", mover,
                          "'" + mover.path + "' starts " + rounded(overlap.depth * 1e3, "mm") +
                              " deep inside '" + other.path + "'");
    report.note("'" + other.path + "'", other.span());
    if (const auto pressing = paths.pressing(overlap)) {
      const auto joint = static_cast<std::size_t>(pressing->joints.front());
      const std::string name = "'" + model_.joints[joint].name + "'";
      report.note(pressing->limits
                      ? "they cannot separate: " + name + " is at its limit"
                      : "they cannot separate: " + name + " holds them against the contact",
                  joint_elements_[joint]->span());
    }
    report.help("move them apart, or let them pass through each other with <collide between=\"" +
                a.name + " " + b.name + "\" with=\"false\"/>");
  }
  if (!overlaps.complete && shown <= kShownOverlaps)
    fault("CG2001", scene_, "too many shapes are close to each other to check all pairs")
        .help("shapes that never touch can have collide=\"false\"");
}

void Builder::check_mass_ratios() {
  for (std::size_t j = 0; j < model_.joints.size(); ++j) {
    const Joint& joint = model_.joints[j];
    if (joint.parent == kWorld || joint.type == JointType::free) continue;
    const Body& parent = model_.bodies[joint.parent];
    const Body& child = model_.bodies[joint.child];
    if (parent.kind != BodyKind::dynamic || child.kind != BodyKind::dynamic) continue;
    const double ratio = std::max(parent.mass / child.mass, child.mass / parent.mass);
    if (ratio <= kMassRatio) continue;
    fault("CG2002", *joint_elements_[j],
          "'" + parent.name + "' (" + rounded(parent.mass, "kg") + ") and '" + child.name + "' (" +
              rounded(child.mass, "kg") + ") differ in mass by a factor of " +
              number_text(std::round(ratio)))
        .help("iterative solvers become soft here; smaller steps help");
  }
}

// Where a body stands on a much lighter one: what it overlaps once it is a little lower.
void Builder::check_loads() {
  constexpr double kLower = 1e-4;  // [m]
  const double g = model_.physics.gravity.norm(), h = model_.physics.step;
  const double most = kMostPressed / (g * h * h);  // infinite without gravity
  const auto movable = [](const Body& body) { return body.kind == BodyKind::dynamic; };
  double lightest = HUGE_VAL;
  for (const Body& body : model_.bodies) {
    if (movable(body)) lightest = std::min(lightest, body.mass);
  }
  const auto is_heavy = [&](const Body& b) { return movable(b) && b.mass > most * lightest; };
  if (std::none_of(model_.bodies.begin(), model_.bodies.end(), is_heavy)) return;
  const Vec3 down = model_.physics.gravity / g;
  SceneModel lowered = model_;
  for (Body& body : lowered.bodies) {
    if (is_heavy(body)) body.X_WB.p += kLower * down;
  }
  struct Bearer {
    std::size_t lightest;
    int others;  // that are too light, too
  };
  std::map<std::size_t, Bearer> bearers;  // by what stands on them
  for (const geometry::Overlap& overlap : geometry::find_overlaps(lowered).pairs) {
    auto heavy = static_cast<std::size_t>(overlap.body_a);
    auto light = static_cast<std::size_t>(overlap.body_b);
    double below = overlap.normal.dot(down);  // how far the second one is straight below the first
    if (model_.bodies[heavy].mass < model_.bodies[light].mass) {
      std::swap(heavy, light);
      below = -below;
    }
    const Body &load = model_.bodies[heavy], &bearer = model_.bodies[light];
    if (!movable(load) || !movable(bearer) || load.mass <= most * bearer.mass || below < 0.5)
      continue;
    const auto [found, is_new] = bearers.try_emplace(heavy, Bearer{light, 0});
    if (is_new) continue;
    ++found->second.others;
    if (bearer.mass < model_.bodies[found->second.lightest].mass) found->second.lightest = light;
  }
  for (const auto& [heavy, under] : bearers) {
    const Body &load = model_.bodies[heavy], &bearer = model_.bodies[under.lightest];
    const std::string others =
        under.others == 0 ? "" : fmt::format(", among {} such bodies,", under.others + 1);
    fault("CG2002", *body_elements_[heavy],
          "'" + load.name + "' (" + rounded(load.mass, "kg") + ") stands on '" + bearer.name +
              "' (" + rounded(bearer.mass, "kg") + ")" + others + " and has " +
              number_text(std::round(load.mass / bearer.mass)) + " times its mass")
        .note("'" + bearer.name + "'", body_elements_[under.lightest]->span())
        .help("iterative solvers press the lighter body in; steps below " +
              rounded(1e3 * std::sqrt(kMostPressed * bearer.mass / (load.mass * g)), "ms") +
              " help, and engines that solve exactly");
  }
}

void Builder::check_drives() {
  std::map<std::pair<int, int>, std::size_t> drives;  // by joint and axis
  for (std::size_t i = 0; i < model_.motors.size() && i < motor_elements_.size(); ++i) {
    const Motor& motor = model_.motors[i];
    const Joint& joint = model_.joints[motor.joint];
    const auto [first, is_new] = drives.try_emplace({motor.joint, motor.axis}, i);
    if (!is_new)
      fault("CG2006", *motor_elements_[i],
            "'" + motor.name + "' and '" + model_.motors[first->second].name +
                "' drive the same axis of '" + joint.name + "'")
          .help("keep one drive per axis");
    const JointAxis& limits = joint.axes[motor.axis];
    const bool to_position = motor.mode == MotorMode::servo || motor.mode == MotorMode::position;
    if (to_position && motor.target &&
        (*motor.target < limits.lower || *motor.target > limits.upper))
      fault(
          "CG2006", *motor_elements_[i], "target",
          "the target lies beyond the limits of '" + joint.name + "': the joint stops at the limit")
          .help("choose a target between the limits");
  }
}

// A hinge or ball on the world that holds a body at its centre of mass, where gravity has no lever:
// mostly a pendulum whose joint was not placed.
void Builder::check_pivots() {
  const std::set<int> bearing = driven_joints(model_);
  for (std::size_t j = 0; j < model_.joints.size(); ++j) {
    const Joint& joint = model_.joints[j];
    if (joint.type != JointType::hinge && joint.type != JointType::ball) continue;
    const bool grounded =
        joint.parent == kWorld || model_.bodies[joint.parent].kind != BodyKind::dynamic;
    const Body& body = model_.bodies[joint.child];
    if (!grounded || body.kind != BodyKind::dynamic || bearing.count(static_cast<int>(j))) continue;
    const auto is_zero = [](double value) { return value == 0.0; };
    if (joint.axes[0].stiffness > 0.0 ||
        !std::all_of(joint.velocity.begin(), joint.velocity.end(), is_zero))
      continue;
    if (std::any_of(model_.forces.begin(), model_.forces.end(), [&](const ForceModel& force) {
          return force.body == joint.child || force.other == joint.child;
        }))
      continue;
    const Vec3 down = body.X_WB.q.conjugate() * (body.gravity_scale * model_.physics.gravity);
    const Mat3 R = joint.X_CM.q.toRotationMatrix();  // its z is the axis of a hinge
    Vec3 arm = R.transpose() * (body.com - joint.X_CM.p);
    const Mat3 inertia = R.transpose() * body.inertia * R;
    const bool hinge = joint.type == JointType::hinge;
    if (hinge) arm.z() = 0.0;
    const double lever = hinge ? down.cross(R.col(2)).norm() : down.norm();
    const double size = std::sqrt(inertia.trace() / body.mass);
    if (!(lever > 1e-6 * model_.physics.gravity.norm()) || !(arm.norm() < 1e-6 * size)) continue;
    // What is round about the axis is a wheel, which may well turn about its middle.
    const double unround =
        std::max({std::abs(inertia(0, 0) - inertia(1, 1)),
                  hinge ? 0.0 : std::abs(inertia(0, 0) - inertia(2, 2)), std::abs(inertia(0, 1)),
                  std::abs(inertia(0, 2)), std::abs(inertia(1, 2))});
    if (unround < 1e-6 * inertia.trace()) continue;
    const Node& node = *joint_elements_[j]->node;
    const bool placed = node.find("xyz") || node.find("frame") || node.find("at");
    const bool deflected = hinge && !is_zero(joint.position[0]);
    if (placed && !deflected) continue;
    fault("CG2009", *joint_elements_[j],
          "'" + joint.name + "' holds '" + body.name +
              "' at its centre of mass, so gravity does not swing it")
        .help(placed ? "a pendulum hangs on a joint above its centre: change xyz"
                     : "a joint without xyz and frame is at the origin of its child; a pendulum "
                       "hangs on a joint above its centre, such as frame=\"" +
                           body.name + "\" xyz=\"0 0 30 cm\"");
  }
}

void Builder::check_rates() {
  for (const auto& [element, bound] : idle_bounds_)
    fault("CG2005", *element, bound,
          "\"" + std::string(bound) + "\" has no effect without a separate process")
        .help("add isolation=\"process\", or leave it out");
  const double most = 1.0 / model_.physics.step;
  for (const auto& [element, rate] : rates_) {
    if (rate <= most * (1.0 + 1e-9)) continue;
    fault("CG2007", *element, "rate",
          "a rate of " + rounded(rate, "Hz") +
              " is above the step rate: it is called at each step, " + rounded(most, "Hz"))
        .help("leave 'rate' out to be called at each step, or use a smaller step");
  }
}

void Builder::check_params() {
  std::map<const Node*, bool> used;
  std::map<const Scope*, NameSet> unused;
  std::map<const Node*, NameSet> mentioned;
  for (const ParamUse& use : context_.params) {
    const auto [names, is_new] = unused.try_emplace(use.scope);
    if (is_new) {
      for (std::string& name : use.scope->unused()) names->second.insert(std::move(name));
    }
    used[use.node] |= names->second.count(use.name) == 0;
  }
  for (const ParamUse& use : context_.params) {
    const auto it = used.find(use.node);
    if (it == used.end() || it->second) continue;
    used.erase(it);
    if (use.node->parent != nullptr) {
      const auto [words, is_new] = mentioned.try_emplace(use.node->parent);
      if (is_new) add_mentioned(*use.node->parent, words->second);
      if (words->second.count(use.name) != 0) continue;
    }
    sink()
        .report("CG2003", use.node->find("name")->value_span, nullptr,
                "the parameter '" + use.name + "' is not used")
        .help("delete it, or use it: ${" + use.name + "}");
  }
}

}  // namespace cogrsim::dsl
