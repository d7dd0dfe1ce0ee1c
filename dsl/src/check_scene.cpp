// What is looked at once the model stands: starts that joints forbid, and advice.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "build_scene.h"
#include "check_overlap.h"

namespace cogrsim::dsl {
namespace {

constexpr double kMassRatio = 1000.0;
constexpr std::size_t kShownOverlaps = 20;

// Four digits are enough to find a mistake by.
std::string rounded(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.4g %s", value, unit);
  return text;
}

std::string distance_and_angle(double metres, double radians) {
  std::string out;
  if (metres > 1e-6) out = rounded(metres * 1e3, "mm");
  if (radians > 1e-6) out += (out.empty() ? "" : " and ") + rounded(radians * 180.0 / M_PI, "deg");
  return out;
}

bool is_word_char(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool mentions(std::string_view text, std::string_view word) {
  for (std::size_t at = text.find(word); at != std::string_view::npos;
       at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_word_char(text[at - 1])) &&
        (end == text.size() || !is_word_char(text[end])))
      return true;
  }
  return false;
}

// Whether an expression somewhere below mentions the name, in a branch that was not built perhaps.
bool mentioned(const Node& node, std::string_view name) {
  for (const Attribute& attribute : node.attributes) {
    const AttributeSpec* spec = node.spec != nullptr ? node.spec->find(attribute.name) : nullptr;
    if ((attribute.value.find("${") != std::string_view::npos ||
         (spec != nullptr && spec->kind == Kind::expression)) &&
        mentions(attribute.value, name))
      return true;
  }
  return std::any_of(node.children.begin(), node.children.end(),
                     [&](const Node* child) { return mentioned(*child, name); });
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
            .help("the start positions of the other joints in the loop do not agree with it");
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
              name + ": its bodies start with " + speeds + " between them that it does not allow")
            .help("give one of them its velocity and let the other follow through the joint");
        break;
      }
    }
  }
}

void Builder::check_overlaps() {
  const std::vector<Overlap> overlaps = find_overlaps(model_);
  std::size_t shown = 0;
  for (const Overlap& overlap : overlaps) {
    if (++shown > kShownOverlaps) {
      fault("CG2001", scene_,
            std::to_string(overlaps.size() - kShownOverlaps) +
                " or more other pairs of bodies start inside each other");
      break;
    }
    const Body& a = model_.bodies[static_cast<std::size_t>(overlap.body_a)];
    const Body& b = model_.bodies[static_cast<std::size_t>(overlap.body_b)];
    // Ground is where it should be; what moves is what was misplaced.
    const bool second = b.kind == BodyKind::dynamic;
    const Element& mover =
        *body_elements_[static_cast<std::size_t>(second ? overlap.body_b : overlap.body_a)];
    const Element& other =
        *body_elements_[static_cast<std::size_t>(second ? overlap.body_a : overlap.body_b)];
    fault("CG2001", mover,
          "'" + mover.path + "' starts " + rounded(overlap.depth * 1e3, "mm") + " deep inside '" +
              other.path + "'")
        .note("'" + other.path + "'", other.span())
        .help("move them apart, or let them pass through each other with <collide between=\"" +
              a.name + " " + b.name + "\" with=\"false\"/>");
  }
}

void Builder::check_mass_ratios() {
  for (std::size_t j = 0; j < model_.joints.size(); ++j) {
    const Joint& joint = model_.joints[j];
    if (joint.parent == kWorld || joint.type == JointType::free) continue;
    const Body& parent = model_.bodies[static_cast<std::size_t>(joint.parent)];
    const Body& child = model_.bodies[static_cast<std::size_t>(joint.child)];
    if (parent.kind != BodyKind::dynamic || child.kind != BodyKind::dynamic) continue;
    const double ratio = std::max(parent.mass / child.mass, child.mass / parent.mass);
    if (ratio <= kMassRatio) continue;
    fault("CG2002", *joint_elements_[j],
          "'" + parent.name + "' (" + rounded(parent.mass, "kg") + ") and '" + child.name + "' (" +
              rounded(child.mass, "kg") + ") differ in mass by a factor of " +
              number_text(std::round(ratio)))
        .help("solvers that iterate become soft here; smaller steps help");
  }
}

void Builder::check_params() {
  std::map<const Node*, bool> used;
  for (const ParamUse& use : context_.params) {
    const std::vector<std::string> unused = use.scope->unused();
    used[use.node] |= std::find(unused.begin(), unused.end(), use.name) == unused.end();
  }
  for (const ParamUse& use : context_.params) {
    const auto it = used.find(use.node);
    if (it == used.end() || it->second) continue;
    used.erase(it);
    if (use.node->parent != nullptr && mentioned(*use.node->parent, use.name)) continue;
    sink()
        .report("CG2003", use.node->find("name")->value_span, nullptr,
                "nobody uses the parameter '" + use.name + "'")
        .help("delete it, or use it: ${" + use.name + "}");
  }
}

}  // namespace cogrsim::dsl
