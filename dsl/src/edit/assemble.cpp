// Assembles elements into one rigid body, and dissolves it again.
#include <algorithm>

#include "cogrsim/core/units.h"
#include "edit/edit_scene.h"

namespace cogrsim::dsl {
namespace {

const char* const kMotion[] = {"static", "kinematic", "linear-velocity", "angular-velocity"};

bool plain_numbers(const EditElement& element, std::string_view attribute) {
  const EditAttribute* a = element.find(attribute);
  return a == nullptr || a->value().find("${") == std::string::npos;
}

void shapes_in(EditElement& root, std::vector<EditElement*>& out) {
  for (const auto& child : root.children) {
    if (is_shape(child->tag)) out.push_back(child.get());
    shapes_in(*child, out);
  }
}

bool knows(const EditElement& element, std::string_view attribute) {
  const ElementSpec* spec = spec_of(element);
  return spec != nullptr && spec->find(attribute) != nullptr;
}

}  // namespace

bool SceneEditor::is_part(const EditElement& element) const {
  return is_shape(element.tag) || element.tag == "body" || element.tag == "assembly" ||
         element.tag == "instance";
}

// Parts cannot move by themselves: attributes that all of them have go to the whole.
Result<> SceneEditor::share_motion(const std::vector<EditElement*>& parts, EditElement& whole) {
  for (const char* attribute : kMotion) {
    std::optional<std::string> common;
    bool first = true;
    for (EditElement* part : parts) {
      if (!is_part(*part)) continue;
      std::string text = part->value(attribute);
      if (text == "false") text.clear();
      if (!first && text != *common)
        return fail("the parts differ in '" + std::string(attribute) + "': " + called(*part) +
                        (text.empty() ? " has none" : " has " + text),
                    "", "make them the same, or remove it from all of them");
      common = text;
      first = false;
      if (part->tag == "plane" || part->tag == "heightmap")
        return fail(called(*part) + " is ground and cannot be a part of something that moves", "",
                    "leave it out");
    }
    if (!common || common->empty()) continue;
    if (std::string(attribute) == "angular-velocity" && parts.size() > 1)
      return fail("parts that turn by themselves cannot become one body", "",
                  "remove their 'angular-velocity' and write it on the whole");
    for (EditElement* part : parts) EditTree::set(*part, attribute, std::nullopt);
    EditTree::set(whole, attribute, *common);
  }
  return {};
}

// What is to become one body, in document order, or why it cannot.
Result<std::vector<EditElement*>> SceneEditor::assembled_parts(const AssembleElements& op) {
  std::vector<EditElement*> parts;
  for (const int id : op.elements) {
    auto e = one_thing(id, "assemble");
    if (!e) return tl::unexpected(e.error());
    if (std::find(parts.begin(), parts.end(), *e) != parts.end()) continue;
    if (!is_part(**e) && (*e)->tag != "frame")
      return fail(called(**e) + " cannot be a part of a rigid assembly", "",
                  "bodies, shapes, assemblies, instances and frames can");
    parts.push_back(*e);
  }
  if (std::none_of(parts.begin(), parts.end(), [&](auto* part) { return is_part(*part); }))
    return fail("there is nothing to assemble", "", "name at least one body");
  std::sort(parts.begin(), parts.end(), [&](auto* a, auto* b) { return ids_.at(a) < ids_.at(b); });
  EditElement& home = *parts.front()->parent;
  for (EditElement* part : parts)
    if (part->parent != &home)
      return fail(called(*part) + " and " + called(*parts.front()) + " have different parents", "",
                  "move them into one assembly, or to the top, first");
  if (home.tag == "body") return fail("shapes of a body are one rigid body already");
  return parts;
}

Result<> SceneEditor::run(const AssembleElements& op) {
  auto chosen_parts = assembled_parts(op);
  if (!chosen_parts) return tl::unexpected(chosen_parts.error());
  const std::vector<EditElement*>& parts = *chosen_parts;
  EditElement& home = *parts.front()->parent;
  const std::vector<Use> old_uses = uses();
  const auto chosen = [&](const EditElement* e) {
    return e != nullptr &&
           std::any_of(parts.begin(), parts.end(), [&](auto* part) { return e->is_inside(*part); });
  };
  for (EditElement* e : nodes_) {
    if (!is_joint(e->tag)) continue;
    const EditElement *parent = nullptr, *child = nullptr;
    for (const Use& use : old_uses) {
      if (use.from != e) continue;
      if (e->value("parent") == use.text) parent = use.target();
      if (e->value("child") == use.text) child = use.target();
    }
    if (chosen(parent) && chosen(child))
      return fail(called(*e) + " connects two of the parts", "line " + std::to_string(line_of(*e)),
                  "remove the joint first, or leave one of its bodies out");
  }

  auto made = tree_.make("assembly");
  EditElement& scope = *scope_of(*parts.front());
  const std::string name = fresh_name(scope, op.name.empty() ? "assembly" : op.name, false);
  EditTree::set(*made, "name", name);
  EditTree::set(*made, "rigid", "true");

  // The whole has its frame where the first part is, if all their poses are numbers.
  EditElement& first = *parts.front();
  const auto by_parent = [&](const EditElement& e) {
    return e.find("frame") == nullptr && e.find("at") == nullptr;
  };
  const bool shift =
      first.find("xyz") != nullptr && by_parent(first) &&
      std::all_of(parts.begin(), parts.end(), [&](auto* part) {
        return !by_parent(*part) || (plain_numbers(*part, "xyz") && plain_numbers(*part, "rpy") &&
                                     plain_numbers(*part, "quat"));
      });
  Pose X_WN;
  if (scope.parent != nullptr) {
    const auto around = poses_.find(&scope);
    if (around == poses_.end()) return fail(called(scope) + " has no unique pose in the world");
    X_WN = around->second;
  }
  std::map<EditElement*, Pose> kept;
  if (shift) {
    X_WN.p = item(first).X_W.p;
    EditTree::set(*made, "xyz", first.value("xyz"));
    EditTree::set(first, "xyz", std::nullopt);
    for (EditElement* part : parts)
      if (part != &first && by_parent(*part)) kept[part] = item(*part).X_W;
  }
  if (auto good = share_motion(parts, *made); !good) return good;
  EditElement& whole = tree_.put(std::move(made), home, &first);
  poses_[&whole] = X_WN;
  created_.push_back(&whole);
  for (EditElement* part : parts) tree_.put(tree_.take(*part, true), whole, nullptr);
  for (const auto& [part, X_W] : kept)
    if (auto good = write_pose(*part, X_W, kKeepTolerance); !good) return good;
  if (!op.material.empty()) {
    for (EditElement* part : parts) {
      if (!knows(*part, "material")) continue;
      EditTree::set(*part, "material", op.material);
      std::vector<EditElement*> inside;
      shapes_in(*part, inside);
      for (EditElement* shape : inside)
        if (shape->find("material") != nullptr) EditTree::set(*shape, "material", op.material);
    }
  }
  std::vector<Use> other;  // a material that was replaced means nothing any more
  for (const Use& use : old_uses)
    if (op.material.empty() || use.target() == nullptr || use.target()->tag != "material" ||
        !chosen(use.from))
      other.push_back(use);
  if (auto good = follow(other); !good) return good;
  refresh();
  if (auto good = must_compile("assemble", "as one body: "); !good) return good;
  return check_meaning(other);
}

Result<> SceneEditor::run(const GroupElements& op) {
  if (auto good = must_compile("group"); !good) return good;
  std::vector<EditElement*> parts;
  for (const int id : op.elements) {
    auto e = element(id);
    if (!e) return tl::unexpected(e.error());
    if (*e == &tree_.root()) return fail("the scene itself cannot be grouped");
    if (std::find(parts.begin(), parts.end(), *e) == parts.end()) parts.push_back(*e);
  }
  if (parts.empty()) return fail("there is nothing to group", "", "name at least one element");
  std::sort(parts.begin(), parts.end(), [&](auto* a, auto* b) { return ids_.at(a) < ids_.at(b); });
  EditElement& home = *parts.front()->parent;
  for (EditElement* part : parts)
    if (part->parent != &home)
      return fail(called(*part) + " and " + called(*parts.front()) + " have different parents", "",
                  "move them into one assembly, or to the top, first");
  const std::vector<Use> old_uses = uses();
  EditElement& scope = *scope_of(*parts.front());
  auto made = tree_.make("assembly");
  EditTree::set(*made, "name", fresh_name(scope, op.name.empty() ? "group" : op.name, false));
  Pose X_WN;
  if (scope.parent != nullptr) {
    const auto around = poses_.find(&scope);
    if (around == poses_.end()) return fail(called(scope) + " has no unique pose in the world");
    X_WN = around->second;
  }
  EditElement& whole = tree_.put(std::move(made), home, parts.front());
  poses_[&whole] = X_WN;
  created_.push_back(&whole);
  for (EditElement* part : parts) tree_.put(tree_.take(*part, true), whole, nullptr);
  if (auto good = follow(old_uses); !good) return good;
  refresh();
  if (auto good = must_compile("group"); !good) return good;
  return check_meaning(old_uses);
}

// The attributes of the whole go to its parts.
Result<> SceneEditor::hand_out(EditElement& whole, const std::vector<EditElement*>& parts) {
  const bool rigid = whole.value("rigid") == "true";
  if (const EditAttribute* material = whole.find("material"); material != nullptr) {
    for (EditElement* part : parts) {
      if (!knows(*part, "material")) continue;
      if (rigid) {  // that of a rigid whole wins
        std::vector<EditElement*> inside;
        shapes_in(*part, inside);
        for (EditElement* shape : inside)
          if (shape->find("material") != nullptr)
            EditTree::set(*shape, "material", material->value());
        EditTree::set(*part, "material", material->value());
      } else if (part->find("material") == nullptr) {
        EditTree::set(*part, "material", material->value());
      }
    }
  }
  for (const char* attribute : {"static", "kinematic"}) {
    if (whole.find(attribute) == nullptr) continue;
    for (EditElement* part : parts)
      if (knows(*part, attribute) && part->find("static") == nullptr &&
          part->find("kinematic") == nullptr)
        EditTree::set(*part, attribute, whole.value(attribute));
  }
  const bool moves = whole.find("linear-velocity") != nullptr;
  if (whole.find("angular-velocity") != nullptr) {
    for (EditElement* part : parts)
      if (is_part(*part))
        return fail(called(whole) + " turns at the start, its parts would not by themselves", "",
                    "remove its 'angular-velocity' first");
  }
  if (moves)
    for (EditElement* part : parts)
      if (knows(*part, "linear-velocity") && part->find("linear-velocity") == nullptr)
        EditTree::set(*part, "linear-velocity", whole.value("linear-velocity"));
  return {};
}

Result<> SceneEditor::run(const DisassembleElement& op) {
  auto e = one_thing(op.element, "disassemble");
  if (!e) return tl::unexpected(e.error());
  EditElement& whole = **e;
  if (whole.tag != "assembly")
    return fail(called(whole) + " is not an assembly", "", "assemblies can be taken apart");
  EditElement& home = *whole.parent;
  EditElement& scope = *scope_of(whole);
  std::vector<EditElement*> parts;
  for (const auto& child : whole.children) parts.push_back(child.get());
  if (parts.empty()) return fail(called(whole) + " has no parts", "", "remove it");
  EditElement* successor = nullptr;
  for (EditElement* part : parts)
    if (successor == nullptr && is_part(*part)) successor = part;
  const std::vector<Use> old_uses = uses();
  std::map<EditElement*, EditElement*> successors;
  if (successor != nullptr) successors[&whole] = successor;
  for (EditElement* part : parts)
    if (spec_of(*part) == nullptr)
      return fail("<" + part->tag + "> holds for the whole of " + called(whole), "",
                  "remove it first");

  // What must not move: parts that are placed in the assembly, and all that is placed by it.
  std::map<EditElement*, Pose> kept;
  for (EditElement* node : nodes_) {
    const ElementSpec* spec = spec_of(*node);
    if (node == &whole || spec == nullptr || spec->find("xyz") == nullptr || !item(*node).single)
      continue;
    const bool by_whole = item(*node).reference == ids_.at(&whole);
    if (by_whole) kept[node] = item(*node).X_W;
  }
  // A joint whose child was the whole.
  for (const Use& use : old_uses)
    if (use.target() == &whole && is_joint(use.from->tag) && item(*use.from).single &&
        item(*use.from).reference == ids_.at(&whole))
      kept[use.from] = item(*use.from).X_W;
  // Shares of a mass that was given for the whole.
  const std::string mass = whole.value("mass");

  for (EditElement* part : parts)
    if (const EditAttribute* name = part->find("name");
        name != nullptr && name->value().find("${") == std::string::npos && part->tag != "test") {
      const std::string fresh = fresh_name(scope, name->value(), part->tag == "material", &whole);
      EditTree::set(*part, "name", fresh);
    }
  if (auto good = hand_out(whole, parts); !good) return good;
  for (EditElement* part : parts) tree_.put(tree_.take(*part, true), home, &whole);
  retire(tree_.take(whole, false));
  if (successor != nullptr) {
    for (auto& [node, X_W] : kept) {
      // Relative to the successor, where the whole was named.
      if (scope_of(*node) == &scope && node->find("frame") == nullptr &&
          node->find("on") == nullptr && node->find("at") == nullptr)
        continue;
      analysis_.items[ids_.at(node)].X_WR = item(*successor).X_W;
    }
  }
  if (auto good = follow(old_uses, successors); !good) return good;
  for (const auto& [node, X_W] : kept)
    if (auto good = write_pose(*node, X_W, kKeepTolerance); !good) return good;
  refresh();
  if (auto good = must_compile("disassemble", "apart: "); !good) return good;
  if (auto good = check_meaning(old_uses, successors); !good) return good;
  return mass.empty() ? Result<>{} : share_mass(called(whole), mass, parts);
}

// Gives each part its share of a mass that was given for the whole.
Result<> SceneEditor::share_mass(const std::string& whole, const std::string& mass,
                                 const std::vector<EditElement*>& parts) {
  const SceneModel& model = *analysis_.result.model;
  std::map<EditElement*, double> masses;
  double sum = 0.0;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const int id = analysis_.origins.bodies[i].element;
    if (id < 0) continue;
    EditElement* body = nodes_[id];
    if (std::find(parts.begin(), parts.end(), body) == parts.end()) continue;
    masses[body] = model.bodies[i].mass;
    sum += model.bodies[i].mass;
  }
  const std::size_t blank = mass.find(' ');
  const auto number = parse_number(mass.substr(0, blank));
  const auto unit = parse_unit(blank == std::string::npos ? "kg" : mass.substr(blank + 1));
  if (!number || !unit || !(sum > 0.0))
    return fail("the mass of " + whole + " cannot be shared out", "",
                "give its parts masses and remove the mass of the whole");
  for (const auto& [body, own] : masses)
    EditTree::set(*body, "mass", units::number_text(unit->to_si(*number) * own / sum) + " kg");
  return {};
}

}  // namespace cogrsim::dsl
