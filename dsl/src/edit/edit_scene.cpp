#include "edit/edit_scene.h"

#include <algorithm>
#include <cctype>

namespace cogrsim::dsl {
namespace {

// The first error of a text that does not compile, with its line in the message.
Error refusal(const std::vector<Diagnostic>& diagnostics, const std::string& lead) {
  const Diagnostic* first = first_error(diagnostics);
  if (first == nullptr) return Error(lead + "it does not compile");
  Error error = to_error(*first);
  if (first->line > 0) error.message = "line " + std::to_string(first->line) + ": " + error.message;
  error.message = lead + error.message;
  return error;
}

bool is_name(std::string_view text) {
  if (text.empty() || !(std::isalpha(static_cast<unsigned char>(text[0])) != 0 || text[0] == '_'))
    return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  });
}

}  // namespace

const ElementSpec* spec_of(const EditElement& element) {
  if (element.tag == "contact" && element.find("on") != nullptr) return &contact_sensor();
  return find_element(element.tag);
}

bool is_flow(const EditElement& element) {
  const ElementSpec* spec = spec_of(element);
  return spec != nullptr && spec->flow;
}

Result<SceneEditor> SceneEditor::open(const std::string& text, const std::string& name,
                                      const CompileOptions& options) {
  std::vector<Diagnostic> faults;
  auto tree = EditTree::read(text, name, options.limits, faults);
  if (!tree) return tl::unexpected(refusal(faults, kCorrectFirst));
  SceneEditor editor(std::move(*tree), name, options);
  editor.refresh();
  editor.by_id_ = editor.nodes_;
  editor.compiled_at_first_ = editor.analysis_.result.ok();
  return editor;
}

void SceneEditor::refresh() {
  analysis_ = analyse(tree_.text(), name_, *options_);
  nodes_ = tree_.all();
  ids_.clear();
  poses_.clear();
  analysis_.items.resize(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    ids_[nodes_[i]] = static_cast<int>(i);
    if (analysis_.items[i].single) poses_[nodes_[i]] = analysis_.items[i].X_W;
  }
}

Result<EditElement*> SceneEditor::element(int id) const {
  if (id < 0 || id >= static_cast<int>(by_id_.size()))
    return fail("there is no element " + std::to_string(id), "", "take the ids of the newest tree");
  EditElement* e = by_id_[id];
  if (!alive(*e)) return fail("element " + std::to_string(id) + " was removed just before");
  return e;
}

Result<EditElement*> SceneEditor::sibling(const std::optional<int>& before,
                                          const EditElement& parent) const {
  if (!before) return nullptr;
  auto found = element(*before);
  if (found && (*found)->parent != &parent)
    return fail(called(**found) + " is not a child of " + called(parent));
  return found;
}

const Analysis::Item& SceneEditor::item(const EditElement& element) const {
  static const Analysis::Item kNone;
  const auto found = ids_.find(&element);
  return found == ids_.end() ? kNone : analysis_.items[found->second];
}

int SceneEditor::line_of(const EditElement& element) const {
  std::vector<OutlineElement> outline =
      outline_text(tree_.text(), name_, nullptr, options_->limits);
  const std::vector<EditElement*> nodes = tree_.all();
  for (std::size_t i = 0; i < nodes.size() && i < outline.size(); ++i)
    if (nodes[i] == &element) return outline[i].line;
  return 0;
}

std::string SceneEditor::called(const EditElement& element) const {
  const std::string name = name_of(element);
  return name.empty() ? "<" + element.tag + ">" : element.tag + " '" + name + "'";
}

Result<> SceneEditor::must_compile(const char* what, const std::string& lead) const {
  if (analysis_.result.ok()) return {};
  Error error = refusal(analysis_.result.diagnostics, lead);
  if (error.hint.empty()) error.hint = "the scene must compile before one can " + std::string(what);
  return tl::unexpected(error);
}

Result<EditElement*> SceneEditor::one_thing(int id, const char* what) const {
  auto e = element(id);
  if (!e) return e;
  if (auto good = must_compile(what); !good) return tl::unexpected(good.error());
  if (*e == &tree_.root()) return fail("cannot " + std::string(what) + " the scene itself");
  if (item(**e).single) return e;
  for (const EditElement* up = *e; up != nullptr; up = up->parent) {
    const std::string& tag = up->tag;
    if (tag == "prototype" || tag == "repeat" || tag == "for" || tag == "scatter" ||
        tag == "template")
      return fail("cannot " + std::string(what) + " " + called(**e) + ": inside <" + tag +
                      "> it stands for several objects",
                  "", "change its attributes in the text: that holds for all of them");
  }
  return fail(
      "cannot " + std::string(what) + " " + called(**e) + ": it is not an object of the scene", "",
      "change the text");
}

Result<> SceneEditor::apply(const EditOperation& operation) {
  return std::visit(
      [&](const auto& op) -> Result<> {
        auto done = run(op);
        if (done) refresh();
        return done;
      },
      operation);
}

Result<EditResult> SceneEditor::finish() {
  EditResult out;
  out.text = tree_.text();
  out.scene = compile_outlined(out.text, name_, *options_);
  if ((compiled_at_first_ && !out.scene.result.ok()) || out.scene.elements.empty()) {
    const Diagnostic* first = first_error(out.scene.result.diagnostics);
    return tl::unexpected(first != nullptr ? to_error(*first) : Error("it does not compile"));
  }
  const std::vector<EditElement*> nodes = tree_.all();
  for (const EditElement* made : created_)
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (nodes[i] == made) out.created.push_back(static_cast<int>(i));
  return out;
}

Result<> SceneEditor::run(const SetAttribute& op) {
  auto e = element(op.element);
  if (!e) return tl::unexpected(e.error());
  const ElementSpec* spec = spec_of(**e);
  const bool open = spec == nullptr || spec->open_attributes;
  if (!open && spec->find(op.attribute) == nullptr && (*e)->find(op.attribute) == nullptr) {
    std::vector<std::string> known;
    for (const AttributeSpec& a : spec->attributes) known.emplace_back(a.name);
    const std::string near = nearest_name(op.attribute, known);
    return fail("<" + (*e)->tag + "> has no attribute '" + op.attribute + "'", "",
                near.empty() ? "" : "did you mean '" + near + "'?");
  }
  if (!is_name(op.attribute)) return fail("'" + op.attribute + "' cannot be an attribute's name");
  EditTree::set(**e, op.attribute, op.value);
  return {};
}

Result<> SceneEditor::run(const InsertElement& op) {
  auto parent = element(op.parent);
  if (!parent) return tl::unexpected(parent.error());
  auto before = sibling(op.before, **parent);
  if (!before) return tl::unexpected(before.error());
  std::string problem;
  auto made = tree_.fragment(op.xml, problem);
  if (made == nullptr) return fail("the new element: " + problem);
  if (const EditAttribute* name = made->find("name");
      name != nullptr && is_name(name->value()) && made->tag != "test" && made->tag != "param") {
    EditElement* scope = *parent;
    while (is_flow(*scope) && scope->parent != nullptr) scope = scope->parent;
    EditTree::set(*made, "name", fresh_name(*scope, name->value(), made->tag == "material"));
  }
  created_.push_back(&tree_.put(std::move(made), **parent, *before));
  return {};
}

Result<> SceneEditor::run(const RenameElement& op) {
  auto e = element(op.element);
  if (!e) return tl::unexpected(e.error());
  if (auto good = must_compile("rename"); !good) return good;
  const ElementSpec* spec = spec_of(**e);
  const AttributeSpec* attribute = spec != nullptr ? spec->find("name") : nullptr;
  if ((*e)->tag == "scene" || (*e)->tag == "test") {  // titles: nothing refers to them
    EditTree::set(**e, "name", op.name);
    return {};
  }
  if (attribute == nullptr || attribute->kind != Kind::name)
    return fail("<" + (*e)->tag + "> has no name");
  if (!is_name(op.name))
    return fail("'" + op.name + "' cannot be a name", "",
                "a letter or _ first, then letters, digits, _ and -");
  if ((*e)->value("name").find("${") != std::string::npos)
    return fail("the name of " + called(**e) + " is made by an expression", "",
                "change it in the text");
  if ((*e)->tag == "param")
    return fail("parameters are renamed in the text: expressions use them", "",
                "replace '" + name_of(**e) + "' wherever ${…} mentions it");
  if (name_of(**e) == op.name && (*e)->find("name") != nullptr) return {};
  EditElement& scope = *scope_of(**e);
  if (fresh_name(scope, op.name, (*e)->tag == "material", *e) != op.name)
    return fail("the name '" + op.name + "' is taken in " + called(scope), "",
                "choose another name");
  const std::vector<Use> before = uses();
  const std::string old = name_of(**e);
  if ((*e)->find("name") == nullptr) {
    EditAttribute made;
    made.lead = " ";
    made.name = "name";
    made.equals = "=";
    made.raw = op.name;
    (*e)->attributes.insert((*e)->attributes.begin(), std::move(made));
  } else {
    EditTree::set(**e, "name", op.name);
  }
  if ((*e)->tag == "prototype") {
    // Instances look up prototypes separately.
    for (EditElement* other : nodes_)
      if (other->tag == "instance" && other->value("of") == old && scope_of(**e) != nullptr &&
          other->is_inside(*scope_of(**e)))
        EditTree::set(*other, "of", op.name);
  }
  if (auto good = follow(before); !good) return good;
  refresh();
  if (auto good = must_compile("rename", "with the name '" + op.name + "': "); !good) return good;
  return check_meaning(before);
}

Result<> SceneEditor::run(const MoveElement& op) {
  auto e = element(op.element);
  auto parent = element(op.parent);
  if (!e) return tl::unexpected(e.error());
  if (!parent) return tl::unexpected(parent.error());
  auto before = sibling(op.before, **parent);
  if (!before) return tl::unexpected(before.error());
  if (auto good = must_compile("move"); !good) return good;
  if ((*e)->parent == nullptr) return fail("the scene itself cannot be moved");
  if ((*parent)->is_inside(**e)) return fail(called(**e) + " cannot be moved into itself");
  if (*before == *e) return {};
  EditElement& moved = **e;
  const bool same_scope = moved.parent == *parent;
  const std::vector<Use> old_uses = uses();
  const auto pose = poses_.find(&moved);
  const ElementSpec* spec = spec_of(moved);
  // Only elements placed relative to their parent change their pose.
  const int reference = item(moved).reference;
  const bool by_parent = spec != nullptr && spec->find("xyz") != nullptr &&
                         (reference < 0 || reference == item(moved).parent) &&
                         moved.find("frame") == nullptr && moved.find("at") == nullptr;
  const bool keep = op.keep_place && !same_scope && by_parent;
  if (keep && pose == poses_.end())
    return fail(called(moved) + " has no unique pose in the world that could be kept", "",
                "move it without keeping its pose");
  const Pose X_W = keep ? pose->second : Pose{};

  EditElement* scope = *parent;
  while (is_flow(*scope) && scope->parent != nullptr) scope = scope->parent;
  if (const EditAttribute* name = moved.find("name");
      name != nullptr && !same_scope && is_name(name->value()) && moved.tag != "test")
    EditTree::set(moved, "name",
                  fresh_name(*scope, name->value(), moved.tag == "material", &moved));
  EditElement& there = tree_.put(tree_.take(moved, true), **parent, *before);
  if (keep)
    if (auto good = write_pose(there, X_W, kKeepTolerance); !good) return good;
  if (auto good = follow(old_uses); !good) return good;
  refresh();
  if (auto good = must_compile("move", "there "); !good) return good;
  return check_meaning(old_uses);
}

Result<> SceneEditor::run(const DuplicateElement& op) {
  auto e = element(op.element);
  if (!e) return tl::unexpected(e.error());
  if (auto good = must_compile("duplicate"); !good) return good;
  if ((*e)->parent == nullptr) return fail("the scene itself cannot be duplicated");
  EditElement& original = **e;
  auto made = tree_.copy(original);
  // Inside the copy, references to the original refer to the copy.
  std::vector<EditElement*> old_inside, new_inside;
  const auto list = [](EditElement& root, std::vector<EditElement*>& out) {
    out.push_back(&root);
    for (std::size_t i = 0; i < out.size(); ++i)
      for (const auto& child : out[i]->children) out.push_back(child.get());
  };
  list(original, old_inside);
  list(*made, new_inside);
  const std::string old_name = name_of(original);
  std::string new_name = old_name;
  if (const EditAttribute* name = original.find("name"); name != nullptr) {
    if (name->value().find("${") != std::string::npos)
      return fail("the name of " + called(original) + " is made by an expression", "",
                  "duplicate what repeats it, or copy it in the text");
    if (original.tag == "test" || original.tag == "param") {
      int number = 2;
      const auto taken = [&] {
        return std::any_of(nodes_.begin(), nodes_.end(), [&](const EditElement* other) {
          return other->tag == original.tag && other->value("name") == new_name;
        });
      };
      while (taken())
        new_name = old_name + (original.tag == "test" ? " " : "_") + std::to_string(number++);
    } else {
      new_name = fresh_name(*scope_of(original), old_name, original.tag == "material");
    }
    EditTree::set(*made, "name", new_name);
  }
  std::map<EditElement*, std::map<std::string, std::string>> texts;
  std::map<EditElement*, std::vector<std::string>> all;
  for (const Use& use : uses()) {
    const auto at = std::find(old_inside.begin(), old_inside.end(), use.from);
    if (at == old_inside.end()) continue;
    EditElement* from = new_inside[at - old_inside.begin()];
    all[from].push_back(use.text);
    std::string text;
    std::size_t begin = 0;
    bool changed = false;
    for (EditElement* part : use.chain) {
      const std::size_t end = std::min(use.text.find('.', begin), use.text.size());
      changed = changed || part == &original;
      text += (text.empty() ? "" : ".") +
              (part == &original ? new_name : use.text.substr(begin, end - begin));
      begin = std::min(use.text.size(), end + 1);
    }
    if (changed && new_name != old_name) texts[from][use.text] = text;
  }
  for (auto& [from, changes] : texts)
    if (auto good = rewrite(*from, changes, all[from]); !good) return good;
  const std::size_t i = original.index();
  EditElement* next =
      i + 1 < original.parent->children.size() ? original.parent->children[i + 1].get() : nullptr;
  EditElement& copy = tree_.put(std::move(made), *original.parent, next);
  created_.push_back(&copy);
  if (op.offset.isZero()) return {};
  if (!item(original).single)
    return fail("a copy of " + called(original) + " has no unique pose in the world", "",
                "duplicate it without an offset");
  if (!op.offset.allFinite()) return fail("the offset is not finite");
  Pose X_W = item(original).X_W;
  X_W.p += op.offset;
  poses_[&copy] = X_W;
  return write_pose(copy, X_W, kHandTolerance);
}

Result<EditResult> edit_text(const std::string& text, const std::string& name,
                             const std::vector<EditOperation>& operations,
                             const CompileOptions& options) {
  auto editor = SceneEditor::open(text, name, options);
  if (!editor) return tl::unexpected(editor.error());
  for (const EditOperation& operation : operations)
    if (auto done = editor->apply(operation); !done) return tl::unexpected(done.error());
  return editor->finish();
}

}  // namespace cogrsim::dsl
