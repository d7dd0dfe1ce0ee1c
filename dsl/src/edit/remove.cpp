// Removes elements, with the elements that have no meaning without them.
#include <algorithm>
#include <set>

#include "edit/edit_scene.h"

namespace cogrsim::dsl {
namespace {

std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> out;
  std::size_t at = 0;
  while ((at = text.find_first_not_of(" \t\r\n", at)) != std::string::npos) {
    const std::size_t end = std::min(text.find_first_of(" \t\r\n", at), text.size());
    out.push_back(text.substr(at, end - at));
    at = end;
  }
  return out;
}

bool names(const EditElement& element, std::string_view attribute, const std::string& text) {
  const EditAttribute* a = element.find(attribute);
  return a != nullptr && a->value() == text;
}

bool inside_any(const EditElement& element, const std::vector<EditElement*>& roots) {
  return std::any_of(roots.begin(), roots.end(),
                     [&](const EditElement* root) { return element.is_inside(*root); });
}

}  // namespace

// Whether an element is removed with an element that it names, or only loses the reference.
Result<> SceneEditor::forget(const Use& use, std::vector<EditElement*>& doomed,
                             std::vector<EditElement*>& replaced) {
  EditElement& from = *use.from;
  if (use.target() != nullptr && use.target()->tag == "material") {
    for (const std::string_view attribute : {"material", "door-material"})
      if (names(from, attribute, use.text)) EditTree::set(from, attribute, std::nullopt);
    if (from.tag == "contact") doomed.push_back(&from);
    return {};
  }
  const ElementSpec* spec = spec_of(from);
  const bool placed = spec != nullptr && spec->find("xyz") != nullptr;
  if (placed && from.tag != "spawn" &&
      (names(from, "frame", use.text) || (from.tag == "instance" && names(from, "at", use.text)))) {
    replaced.push_back(&from);
    return {};
  }
  if (from.tag == "region") {
    // With an empty list it would detect everything.
    std::string left;
    for (const std::string& word : names_in(from.value("who")))
      if (word != use.text) left += (left.empty() ? "" : " ") + word;
    if (left.empty())
      doomed.push_back(&from);
    else
      EditTree::set(from, "who", left);
    return {};
  }
  if (from.tag == "maze") {
    std::string left;
    for (const std::string& word : names_in(from.value("open")))
      if (word != use.text) left += (left.empty() ? "" : " ") + word;
    EditTree::set(from, "open", left.empty() ? std::nullopt : std::optional<std::string>(left));
    return {};
  }
  if (from.tag == "set") {
    for (const EditAttribute& a : from.attributes)
      for (const std::string& word : names_in(a.value()))
        if (word == use.text) {
          const std::string attribute = a.name;
          EditTree::set(from, attribute, std::nullopt);
          if (from.attributes.empty()) doomed.push_back(&from);
          return {};
        }
    return {};
  }
  if (from.tag == "door" && names(from, "parent", use.text)) {
    EditTree::set(from, "parent", std::nullopt);  // it is attached to the world then
    return {};
  }
  if (from.tag == "scene" || from.tag == "assembly" || from.tag == "body" || is_shape(from.tag))
    return fail(called(from) + " needs '" + use.text + "'", "line " + std::to_string(line_of(from)),
                "change that first");
  doomed.push_back(&from);
  return {};
}

Result<> SceneEditor::run(const RemoveElements& op) {
  std::vector<EditElement*> doomed;
  for (const int id : op.elements) {
    auto e = element(id);
    if (!e) return tl::unexpected(e.error());
    if ((*e)->parent == nullptr) return fail("the scene itself cannot be removed");
    doomed.push_back(*e);
  }
  if (doomed.empty()) return fail("there is nothing to remove", "", "name at least one element");
  std::vector<EditElement*> replaced;
  if (analysis_.result.ok()) {
    const std::vector<Use> all = uses();
    std::set<const Use*> done;
    for (std::size_t count = 0; count != doomed.size();) {
      count = doomed.size();
      for (const Use& use : all) {
        if (done.count(&use) != 0 || inside_any(*use.from, doomed)) continue;
        if (std::none_of(use.chain.begin(), use.chain.end(), [&](const EditElement* part) {
              return part != nullptr && inside_any(*part, doomed);
            }))
          continue;
        done.insert(&use);
        if (auto good = forget(use, doomed, replaced); !good) return good;
      }
      // Instances and spawns of what they are made from.
      for (EditElement* e : nodes_) {
        if (e->tag != "instance" || inside_any(*e, doomed)) continue;
        for (const EditElement* gone : doomed)
          if (gone->tag == "prototype" && gone->value("name") == e->value("of") &&
              e->is_inside(*scope_of(*gone))) {
            doomed.push_back(e);
            break;
          }
      }
      // Elements that are left without content are removed, too.
      for (EditElement* e : nodes_) {
        if (e->children.empty() || inside_any(*e, doomed)) continue;
        const bool hollow =
            std::all_of(e->children.begin(), e->children.end(),
                        [&](const auto& child) { return inside_any(*child, doomed); });
        if (hollow &&
            (e->tag == "on" || e->tag == "test" || e->tag == "scatter" || e->tag == "template" ||
             (e->tag == "plot" && e->find("y") == nullptr && e->find("x") == nullptr)))
          doomed.push_back(e);
      }
    }
  }
  for (EditElement* e : replaced) {
    if (inside_any(*e, doomed)) continue;
    const auto pose = poses_.find(e);
    if (pose == poses_.end())
      return fail(called(*e) + " is placed relative to an element that would be removed",
                  "line " + std::to_string(line_of(*e)), "give it another frame first");
    EditTree::set(*e, "frame", std::nullopt);
    if (e->tag == "instance") EditTree::set(*e, "at", std::nullopt);
    if (auto good = write_pose(*e, pose->second, kKeepTolerance); !good) return good;
  }
  for (EditElement* e : doomed)
    if (alive(*e)) retire(tree_.take(*e, false));
  return {};
}

}  // namespace cogrsim::dsl
