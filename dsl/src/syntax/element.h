// The scene after expansion: prototypes, repeats and conditions are gone, each element knows the
// values in scope and its origin.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "cogrsim/model/shapes.h"
#include "expand/plans.h"
#include "syntax/node.h"
#include "values/value.h"

namespace cogrsim::dsl {

/// One step from the scene to an element: an instance, an iteration of a repeat, an import.
/// Shown innermost first: "in instance 'bot' of prototype 'DiffBot', maze.scene.xml:52:5".
struct Trail {
  const Trail* up = nullptr;
  std::string text;  ///< "in instance 'bot' of prototype 'DiffBot'", "in iteration 3 of a repeat"
  SourceSpan at;
};

/// Names that expressions can use. A child scope sees its parents'; `opaque` ones do not look
/// further (the inside of a prototype).
class Scope {
 public:
  explicit Scope(const Scope* parent = nullptr, bool opaque = false)
      : parent_(parent), opaque_(opaque) {}

  /// A poisoned value is fine: its uses report nothing.
  void set(std::string name, Value value);
  /// nullptr: no such name. Marks it as used.
  const Value* find(std::string_view name) const;
  bool has_own(std::string_view name) const;
  /// Own names never looked up, for the warning about unused parameters.
  std::vector<std::string> unused() const;
  /// All names visible here, for suggestions.
  std::vector<std::string> names() const;

 private:
  struct Entry {
    Value value;
    mutable bool used = false;
  };
  const Scope* parent_;
  bool opaque_;
  std::map<std::string, Entry, std::less<>> entries_;
};

/// An element of the expanded scene. Made by expansion, read by everything after it.
struct Element {
  const Node* node = nullptr;
  const Scope* scope = nullptr;
  const Trail* trail = nullptr;  ///< nullptr: written in the scene file itself
  Element* parent = nullptr;
  std::vector<Element*> children;
  std::string name;  ///< evaluated name=, or generated for one without ("box_3"); without dots
  int index = -1;    ///< position in the tree, parents before children
  std::string path;  ///< dotted, unique; also the key of the element's random numbers
  /// Of an instance: the import its prototype came from, whose materials it sees before those
  /// around it; nullptr for a prototype of the scene file.
  const Element* home = nullptr;
  /// Something in here failed and was reported: missing names are not reported.
  bool incomplete = false;

  std::string_view tag() const { return node->name; }
  const SourceSpan& span() const { return node->span; }
  const Attribute* find(std::string_view attribute) const { return node->find(attribute); }
};

/// A `<param>` and the scope that holds its value, for the warning about unused ones.
struct ParamUse {
  const Scope* scope = nullptr;
  const Node* node = nullptr;
  std::string name;
};

struct OutlineNotes;  // outline_notes.h

/// Everything one compilation shares. Deques keep addresses valid.
struct CompileContext {
  const CompileOptions& options;
  SourceFiles& files;
  DiagnosticSink& sink;
  std::uint64_t seed = 1;  ///< set before the first random draw: options.seed, else physics seed=
  std::size_t& work = files.work;  ///< that may still be done, see spend()
  std::deque<Element> elements = {};
  std::deque<Scope> scopes = {};
  std::deque<Trail> trails = {};
  std::vector<ParamUse> params = {};
  int element_count = 0;  ///< in the tree; one more than the largest Element::index
  /// Names of elements that failed, by their parent element: references to them are not reported.
  std::unordered_map<const Element*, std::set<std::string, std::less<>>> lost_names = {};
  std::deque<Node> made_nodes = {};  ///< of generated elements: walls, doors
  std::deque<std::string> made_texts = {};
  std::deque<MazePlan> mazes = {};
  std::deque<DoorPlan> doors = {};
  std::deque<ScatterPlan> scatters = {};
  std::map<std::string, MeshPtr> meshes = {};  ///< by file, scale and name
  /// Notes for editing; nullptr: none are taken.
  OutlineNotes* outline = nullptr;
  /// World poses that were drawn for objects of a scatter; empty: not drawn yet.
  std::unordered_map<const Element*, Pose> drawn_poses = {};
};

/// Takes work from what may still be done. False: none is left, which is reported once; what needed it
/// has failed.
bool spend(CompileContext& context, std::size_t work, const SourceSpan& at, const Trail* trail);

/// Expansion (expand_*.cpp): imports, parameters, prototypes, repeats, conditions. Returns the root
/// `<scene>`; what failed was reported and left out. nullptr only when nothing remains.
Element* expand(CompileContext& context, const Document& scene);

/// Names, frames, matter, topology, physics checks, and the model (resolve_*, build_*, …).
/// nullptr when an error was reported.
SceneModelPtr build_model(CompileContext& context, const Element& scene);

}  // namespace cogrsim::dsl
