#include "expand/expand_scene.h"

#include <algorithm>

namespace cogrsim::dsl {
namespace {

// Deeper trees than this come from hostile files only; it bounds the recursion of all later stages.
constexpr int kMaxTreeDepth = 800;

bool is_definition(std::string_view tag) {
  return tag == "param" || tag == "import" || tag == "prototype";
}

}  // namespace

const Prototype* Definitions::find(std::string_view dotted) const {
  for (const Definitions* level = this; level != nullptr; level = level->up) {
    if (const auto it = level->prototypes.find(dotted); it != level->prototypes.end())
      return &it->second;
    const std::size_t dot = dotted.find('.');
    if (dot == std::string_view::npos) continue;
    if (const auto it = level->imports.find(dotted.substr(0, dot)); it != level->imports.end())
      return it->second->find(dotted.substr(dot + 1));
  }
  return nullptr;
}

void Definitions::list(std::string_view prefix, std::vector<std::string>& names) const {
  for (const Definitions* level = this; level != nullptr; level = level->up) {
    for (const auto& [name, prototype] : level->prototypes)
      names.push_back(std::string(prefix) + name);
    for (const auto& [name, definitions] : level->imports)
      definitions->list(std::string(prefix) + name + ".", names);
  }
}

bool Definitions::incomplete_anywhere() const {
  for (const Definitions* level = this; level != nullptr; level = level->up)
    if (level->incomplete) return true;
  return false;
}

Element* Expander::run(const Document& scene) {
  if (scene.root == nullptr || scene.root->spec == nullptr) return nullptr;
  const Node& root = *scene.root;
  Element& element = context_.elements.emplace_back();
  element.node = &root;
  Scope& scope = context_.scopes.emplace_back();
  element.scope = &scope;
  open_documents_.push_back(&scene);

  if (context_.options.seed) {
    context_.seed = *context_.options.seed;
  } else {
    for (const Node* child : root.children) {
      if (child->name != "physics" || child->spec == nullptr) continue;
      const Attribute* seed = child->find("seed");
      const auto value = seed != nullptr ? parse_number(seed->value) : std::nullopt;
      // Anything but a plain number is checked, and reported, when the scene is built.
      if (value && *value >= 0 && *value < 9.0e15)
        context_.seed = static_cast<std::uint64_t>(*value);
    }
  }

  InsertPoint point;
  point.into = &element;
  point.scope = &scope;
  define_params(root, scope, point, nullptr, true);
  children(root, point);
  if (full_) return nullptr;  // elements that were left out would only cause further errors
  element.index = context_.element_count++;
  name_children(element);
  return full_ ? nullptr : &element;
}

bool Expander::within_limits(const Node& node, const InsertPoint& point, std::size_t cost) {
  full_ = full_ || context_.work == 0;  // which was reported
  if (full_) return false;
  made_ += cost;
  if (made_ > static_cast<std::size_t>(context_.options.limits.expanded_elements)) {
    full_ = true;
    context_.sink
        .report("CG0306", node.span, point.trail,
                "the scene grows beyond " +
                    std::to_string(context_.options.limits.expanded_elements) +
                    " elements while it is expanded")
        .help("look for a repeat or instance that multiplies others");
    return false;
  }
  if (point.depth > kMaxTreeDepth) {
    full_ = true;
    context_.sink
        .report("CG0305", node.span, point.trail,
                "elements, repeats and instances are nested more than " +
                    std::to_string(kMaxTreeDepth) + " deep")
        .help("look for a prototype that contains itself");
    return false;
  }
  return true;
}

const Trail* Expander::step(const InsertPoint& point, std::string text, const SourceSpan& at) {
  context_.trails.push_back({point.trail, std::move(text), at});
  return &context_.trails.back();
}

Element* Expander::make(const Node& node, const InsertPoint& point) {
  if (!within_limits(node, point)) return nullptr;
  Element& element = context_.elements.emplace_back();
  element.node = &node;
  element.scope = point.scope;
  element.trail = point.trail;
  element.parent = point.into;
  return &element;
}

void Expander::mark_failed(const Node& node, const InsertPoint& point) {
  const Attribute* name = node.find(node.name == "import" ? "as" : "name");
  if (name == nullptr || name->value.find("${") != std::string_view::npos ||
      (node.spec != nullptr && node.spec->flow))
    point.into->incomplete = true;
  else
    context_.lost_names[point.into].emplace(name->value);
}

// Definitions come first, regardless of their order in the file.
void Expander::define(const Node& node, const InsertPoint& point, Definitions& definitions) {
  for (const Node* c : node.children)
    if (c->name == "import" && c->spec != nullptr) import(*c, point, definitions);
  for (const Node* c : node.children) {
    if (c->name != "prototype" || c->spec == nullptr) continue;
    if (!spend(*c, point, 2000)) return;
    Element& element = context_.elements.emplace_back();
    element.node = c;
    element.scope = point.scope;
    element.trail = point.trail;
    const auto name = Reader(context_, element).word("name");
    if (!name.given()) {
      definitions.incomplete = true;
      continue;
    }
    const auto [at, is_new] =
        definitions.prototypes.try_emplace((*name).text, Prototype{c, &definitions, point.home});
    if (!is_new)
      context_.sink
          .report("CG0401", element, "name", "prototype '" + (*name).text + "' exists twice")
          .note("the other one", at->second.node->span);
  }
}

void Expander::children(const Node& node, const InsertPoint& outer, Definitions* own) {
  InsertPoint point = outer;
  ++point.depth;
  if (own == nullptr && std::any_of(node.children.begin(), node.children.end(), [](const Node* c) {
        return c->spec != nullptr && (c->name == "prototype" || c->name == "import");
      })) {
    own = &definitions_.emplace_back();
    own->up = outer.definitions;
  }
  if (own != nullptr) {
    point.definitions = own;
    define(node, point, *own);
  }
  if (!spend(node, point, 16 * node.children.size())) return;
  std::map<std::string_view, int> ordinals;
  for (const Node* c : node.children) {
    if (full_) return;
    if (c->spec == nullptr && !is_engine_block(*c, context_.files)) {
      mark_failed(*c, point);
      continue;
    }
    if (is_definition(c->name)) continue;
    const bool shared = c->name == "material" || (c->name == "contact" && !is_sensor(c->spec));
    if (point.ignored != nullptr && !shared) {
      if (std::find(point.ignored->begin(), point.ignored->end(), c->name) ==
          point.ignored->end())
        point.ignored->push_back(c->name);
      continue;
    }
    child(*c, point, ordinals[c->name]++);
  }
}

void Expander::child(const Node& node, const InsertPoint& point, int ordinal) {
  // The key is only needed where an expression may draw a random number.
  const auto key = [&] {
    return point.key + "/" + std::string(node.name) + std::to_string(ordinal);
  };
  if (node.name == "repeat") return repeat(node, point, key());
  if (node.name == "for") return for_each(node, point, key());
  if (node.name == "if") return condition(node, point, key());
  if (node.name == "instance") return instance(node, point, key());
  if (node.name == "maze") return maze(node, point, key());
  if (node.name == "door") return door(node, point, key());
  if (node.name == "scatter") return scatter(node, point, key());

  Element* element = make(node, point);
  if (element == nullptr) return;
  point.into->children.push_back(element);
  const AttributeSpec* name_spec = node.spec != nullptr ? node.spec->find("name") : nullptr;
  if (const Attribute* name = node.find("name");
      name != nullptr && name_spec != nullptr && name_spec->kind == Kind::name) {
    if (name->value.find("${") != std::string_view::npos) element->path = key();
    const auto word = Reader(context_, *element).word("name");
    if (word.given()) {
      element->name = (*word).text;
    } else {
      point.into->incomplete = true;
    }
  }
  if (node.children.empty()) return;
  InsertPoint inner = point;
  inner.into = element;
  inner.key = key();
  if (std::any_of(node.children.begin(), node.children.end(),
                  [](const Node* c) { return c->name == "param"; })) {
    Scope& scope = context_.scopes.emplace_back(point.scope);
    inner.scope = &scope;
    define_params(node, scope, inner, nullptr, false);
  }
  children(node, inner);
}

void Expander::instance(const Node& node, const InsertPoint& point, const std::string& key) {
  Element* element = make(node, point);
  if (element == nullptr) return;
  point.into->children.push_back(element);
  element->path = key;
  Reader reader(context_, *element);
  if (reader.has("name")) {
    const auto name = reader.word("name");
    if (name.given())
      element->name = (*name).text;
    else
      point.into->incomplete = true;
  }
  const auto of = reader.word("of");
  if (!of.given()) {
    element->incomplete = true;
    return;
  }
  const Prototype* prototype =
      point.definitions != nullptr ? point.definitions->find((*of).text) : nullptr;
  if (prototype == nullptr) {
    element->incomplete = true;
    if (point.definitions != nullptr && point.definitions->incomplete_anywhere()) return;
    std::vector<std::string> known;
    if (point.definitions != nullptr) point.definitions->list("", known);
    auto report = context_.sink.report("CG0304", (*of).span, point.trail,
                                       "there is no prototype '" + (*of).text + "'");
    report.help(known.empty() ? "the scene has no prototypes: write <prototype name=\"" +
                                    (*of).text + "\">, or import a file that has it"
                              : suggest((*of).text, known));
    return;
  }
  if (point.instances >= context_.options.limits.expansion_depth) {
    element->incomplete = true;
    full_ = true;  // one such report is enough: such growth usually has many sources
    context_.sink
        .report("CG0305", (*of).span, point.trail,
                "instances are nested more than " +
                    std::to_string(context_.options.limits.expansion_depth) + " deep")
        .help("prototype '" + (*of).text + "' contains itself; end the recursion with an <if>");
    return;
  }
  element->home = prototype->home;
  Scope& scope = context_.scopes.emplace_back(nullptr, true);
  InsertPoint inner;
  inner.into = element;
  inner.scope = &scope;
  std::string shown = element->name.empty() ? "an instance" : "instance '" + element->name + "'";
  inner.trail = step(point, "in " + shown + " of prototype '" + (*of).text + "'", node.span);
  inner.definitions = prototype->definitions;
  inner.home = prototype->home;
  inner.key = key;
  inner.instances = point.instances + 1;
  inner.depth = point.depth + 1;
  define_params(*prototype->node, scope, inner, element, false);
  children(*prototype->node, inner);
}

Element* expand(CompileContext& context, const Document& scene) {
  return Expander(context).run(scene);
}

}  // namespace cogrsim::dsl
