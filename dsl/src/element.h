// The scene after expansion: prototypes, repeats and conditions are gone, each element knows the
// values in scope and the way it came.
#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "node.h"
#include "value.h"

namespace cogrsim::dsl {

/// One step of the way from the scene to an element: an instance, a repeat's round, an import.
/// Shown innermost first: "in instance 'bot' of prototype 'DiffBot', maze.scene.xml:52:5".
struct Trail {
  const Trail* up = nullptr;
  std::string text;   ///< "in instance 'bot' of prototype 'DiffBot'", "in round 3 of repeat"
  SourceSpan at;
};

/// Names that expressions can use. A child scope sees its parents'; `opaque` ones do not look
/// further (the inside of a prototype).
class Scope {
 public:
  explicit Scope(const Scope* parent = nullptr, bool opaque = false)
      : parent_(parent), opaque_(opaque) {}

  /// A poisoned value is fine: whoever uses it stays silent.
  void set(std::string name, Value value);
  /// nullptr: no such name. Marks it as used.
  const Value* find(std::string_view name) const;
  bool has_own(std::string_view name) const;
  /// Own names never looked up, for the advice about unused parameters.
  std::vector<std::string> unused() const;
  /// All names visible here, for suggestions.
  std::vector<std::string> names() const;

 private:
  struct Entry {
    std::string name;
    Value value;
    mutable bool used = false;
  };
  const Scope* parent_;
  bool opaque_;
  std::vector<Entry> entries_;
};

/// An element of the expanded scene. Made by expansion, read by everything after it.
struct Element {
  const Node* node = nullptr;
  const Scope* scope = nullptr;
  const Trail* trail = nullptr;   ///< nullptr: stands in the scene file itself
  Element* parent = nullptr;
  std::vector<Element*> children;
  std::string name;  ///< evaluated name=, or made up for one without ("box_3"); without dots
  std::string path;  ///< dotted, unique; also the key of the element's random numbers

  std::string_view tag() const { return node->name; }
  const SourceSpan& span() const { return node->span; }
  const Attribute* find(std::string_view attribute) const { return node->find(attribute); }
};

/// Everything one compilation shares. Deques keep addresses valid.
struct CompileContext {
  const CompileOptions& options;
  SourceFiles& files;
  DiagnosticSink& sink;
  std::uint64_t seed = 1;  ///< set before the first random draw: options.seed, else physics seed=
  std::deque<Element> elements;
  std::deque<Scope> scopes;
  std::deque<Trail> trails;
};

/// Expansion (expand_*.cpp): imports, parameters, prototypes, repeats, conditions. Returns the root
/// `<scene>`; what failed was reported and left out. nullptr only when nothing is left to look at.
Element* expand(CompileContext& context, const Document& scene);

/// Names, frames, matter, topology, physics checks, and the model (resolve_*, build_*, …).
/// nullptr when an error was reported.
SceneModelPtr build_model(CompileContext& context, const Element& scene);

}  // namespace cogrsim::dsl
