// Poses relative to parents and named frames, in the order of their dependencies.
#include <algorithm>

#include "build/build_scene.h"

namespace cogrsim::dsl {
namespace {

constexpr std::ptrdiff_t kShownOfCycle = 6;

bool has_pose(const Element& element) {
  const std::string_view tag = element.tag();
  return is_shape(tag) || is_joint(tag) || tag == "body" || tag == "assembly" ||
         tag == "instance" || tag == "frame" || tag == "scatter" || tag == "light" ||
         tag == "view" || tag == "region" || tag == "force" || tag == "drag" ||
         (is_sensor(element.node->spec) && tag != "encoder" && tag != "force-torque");
}

}  // namespace

// What the written pose is relative to. Looked up once, so that a wrong name is reported once.
const Element* Builder::reference(const Element& element) {
  Note& n = note(element);
  if (n.reference_known) return n.reference;
  n.reference_known = true;
  Reader r = reader(element);
  const bool is_instance = element.tag() == "instance";
  if (is_instance && r.has("at") && r.has("frame"))
    fault("CG0602", element, "frame", "'at' and 'frame' both set its pose");
  std::string_view attribute;
  if (is_instance && r.has("at"))
    attribute = "at";
  else if (r.has("frame"))
    attribute = "frame";
  else if (is_joint(element.tag()) && !r.has("xyz") && !r.has("rpy") && !r.has("quat"))
    attribute = "child";
  else if (is_sensor(element.node->spec) || (is_force(element.tag()) && knows(element, "on")))
    attribute = "on";
  n.reference = element.parent;
  if (attribute.empty() || !r.has(attribute)) return n.reference;
  const auto word = r.word(attribute);
  if (!word.given()) {
    n.faulty = true;
    return n.reference;
  }
  if ((*word).text == "world") {
    n.reference = &scene_;
    return n.reference;
  }
  const Element* named =
      names_.find(element, *word, attribute == "at" ? Wanted::any : Wanted::posed);
  if (named != nullptr && !has_pose(*named)) {
    fault("CG1001", element, "at",
          "'" + (*word).text + "' is " + kind_of(*named) + ", which has no pose")
        .note("it is defined here", named->span())
        .help("name a frame, a body or an assembly");
    named = nullptr;
  }
  if (named == nullptr) {
    n.faulty = true;
    return n.reference;
  }
  n.reference = named;
  return named;
}

std::optional<Pose> Builder::own_pose(const Element& element) {
  if (!knows(element, "xyz")) return Pose{};
  const auto pose = reader(element).pose();
  if (pose.failed()) return std::nullopt;
  return *pose;
}

// The chain of references is walked with a list instead of recursion: it may be as long as the
// scene.
void Builder::resolve_pose(const Element& element) {
  std::vector<const Element*> open{&element};
  while (!open.empty()) {
    const Element& top = *open.back();
    Note& n = note(top);
    if (n.placing == Note::Placing::done) {
      open.pop_back();
      continue;
    }
    const Element* base = &top == &scene_ ? nullptr : reference(top);
    if (n.placing == Note::Placing::open) {
      n.placing = Note::Placing::at_work;
      if (base != nullptr && note(*base).placing == Note::Placing::at_work) {
        report_cycle(open, *base);
        n.reference = top.parent;
        n.faulty = true;
        n.placing = Note::Placing::done;
        continue;
      }
      if (base != nullptr && note(*base).placing == Note::Placing::open) {
        open.push_back(base);
        continue;
      }
    }
    const auto own = own_pose(top);
    if (!own) n.faulty = true;
    if (base != nullptr) {
      const auto drawn = context_.drawn_poses.find(&top);
      const Pose& X_WP = drawn != context_.drawn_poses.end() ? drawn->second : note(*base).X_W;
      n.X_W = own ? X_WP * *own : X_WP;
      if (note(*base).faulty) n.faulty = true;
    }
    n.placing = Note::Placing::done;
    open.pop_back();
  }
}

void Builder::report_cycle(const std::vector<const Element*>& open, const Element& again) {
  const auto first = std::find(open.begin(), open.end(), &again);
  std::string cycle;
  const auto length = open.end() - first;
  for (auto it = first; it != open.end(); ++it) {
    note(**it).faulty = true;
    // A long cycle is shown by its two ends.
    const auto i = it - first;
    if (i < kShownOfCycle || length - i <= kShownOfCycle)
      cycle += "'" + (*it)->path + "' -> ";
    else if (i == kShownOfCycle)
      cycle += "… -> ";
  }
  cycle += "'" + again.path + "'";
  const Element& last = *open.back();
  // A child is placed by its parent implicitly; the element to correct has `frame` or `at`.
  const Element* written = &last;
  for (auto it = first; it != open.end(); ++it)
    if ((*it)->find("frame") != nullptr || (*it)->find("at") != nullptr) written = *it;
  fault("CG0601", *written, written->find("frame") != nullptr ? "frame" : "at",
        "these poses depend on each other: " + cycle)
      .help("place one of them without 'frame'");
}

// Directions and points to look at, instead of angles.
Pose Builder::facing(const Element& element, Pose X_W) {
  Reader r = reader(element);
  const bool is_light = element.tag() == "light";
  const std::string_view attribute = is_light ? "direction" : "look-at";
  if (!r.has(attribute)) return X_W;
  if (r.has("rpy") || r.has("quat")) {
    fault("CG0602", element, attribute,
          "'" + std::string(attribute) + "' and '" + (r.has("rpy") ? "rpy" : "quat") +
              "' both set its orientation");
    return X_W;
  }
  const auto given = r.vec3(attribute);
  if (!given.given()) return X_W;
  const Element* base = reference(element);
  const Pose X_WB = base != nullptr ? note(*base).X_W : Pose{};
  // Both are given in the frame that xyz is given in.
  const Vec3 x = is_light ? Vec3(X_WB.q * *given) : Vec3(X_WB * *given - X_W.p);
  if (!(x.norm() > 1e-12)) {
    fault("CG0603", element, attribute,
          is_light ? "the direction has zero length" : "it looks at its own position");
    return X_W;
  }
  const Vec3 forward = x.normalized();
  Vec3 left = Vec3::UnitZ().cross(forward);
  if (left.norm() < 1e-9) left = Vec3::UnitY();  // straight up or down
  left.normalize();
  Mat3 axes;
  axes << forward, left, forward.cross(left);
  X_W.q = Quat(axes).normalized();
  return X_W;
}

void Builder::resolve_poses() {
  note(scene_).placing = Note::Placing::done;
  for_each(scene_, [&](const Element& element) {
    Note& n = note(element);
    if (has_pose(element)) {
      resolve_pose(element);
      if (element.tag() == "light" || element.tag() == "view") n.X_W = facing(element, n.X_W);
    } else if (n.placing == Note::Placing::open) {
      n.placing = Note::Placing::done;
      n.X_W = element.parent != nullptr ? note(*element.parent).X_W : Pose{};
    }
  });
}

int Builder::carrier(const Element& element) {
  // A chain of frames ends at a body, in an assembly, or in the world; the result holds for the
  // whole chain, which may be as long as the scene.
  std::vector<Note*> chain;
  int body = kWorld;
  for (const Element* at = &element; at != nullptr && at != &scene_;) {
    Note& n = note(*at);
    if (n.carrier_known) {
      body = n.carrier;
      break;
    }
    n.carrier_known = true;  // a cycle of frames ends here; it is reported elsewhere
    chain.push_back(&n);
    const std::string_view tag = at->tag();
    if (n.owner != nullptr) {
      body = n.body;
      break;
    }
    if ((tag == "assembly" || tag == "instance") && n.body_count > 0) {
      body = n.first_body;
      break;
    }
    const bool placed =
        tag == "frame" || tag == "region" || tag == "view" || is_sensor(at->node->spec);
    at = placed ? reference(*at) : at->parent;
  }
  for (Note* n : chain) n->carrier = body;
  return body;
}

std::optional<int> Builder::body_at(const Element& from, const Word& word, bool world_allowed) {
  if (word.text == "world" && world_allowed) return kWorld;
  const Element* target = names_.find(from, word, Wanted::posed);
  if (target == nullptr) return std::nullopt;
  const Note& n = note(*target);
  if (n.owner != nullptr) return n.body;
  const std::string_view tag = target->tag();
  if (tag == "assembly" || tag == "instance") {
    if (n.body_count == 1) return n.first_body;
    if (target->incomplete) return std::nullopt;
    std::string list;
    int shown = 0;
    for_each(*target, [&](const Element& inner) {
      if (note(inner).owner == &inner && shown++ < 5)
        list += (list.empty() ? "" : ", ") + inner.path;
    });
    sink()
        .report("CG0405", word.span, from.trail,
                "'" + word.text + "' is an assembly of " + std::to_string(n.body_count) +
                    " bodies, expected one body")
        .help(n.body_count == 0 ? "name a body"
                                : "name one of them: " + list + (shown > 5 ? ", …" : ""));
    return std::nullopt;
  }
  const int body = carrier(*target);
  if (body == kWorld && !world_allowed) {
    sink()
        .report("CG0404", word.span, from.trail,
                "frame '" + word.text + "' belongs to no body, expected a body")
        .help("put the frame inside the body, or give it frame=\"…\" with the body's name");
    return std::nullopt;
  }
  return body;
}

}  // namespace cogrsim::dsl
