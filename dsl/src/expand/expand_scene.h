// Expansion: from the written file to the elements of the scene. Imports, parameters, prototypes,
// repeats and conditions go in, a plain tree of Elements comes out.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "report/diagnostics.h"
#include "syntax/element.h"
#include "values/reader.h"
#include "language/vocabulary.h"

namespace cogrsim::dsl {

/// The prototypes that are visible at a point of a file.
struct Definitions;

struct Prototype {
  const Node* node = nullptr;
  const Definitions* definitions = nullptr;  ///< where it was written: the scope of its content
  const Element* home = nullptr;             ///< the import element it came through
};

struct Definitions {
  const Definitions* up = nullptr;
  std::map<std::string, Prototype, std::less<>> prototypes;
  std::map<std::string, const Definitions*, std::less<>> imports;  ///< by `as`
  bool incomplete = false;  ///< an import failed: unknown names are its fault

  /// "DiffBot", or "parts.DiffBot" through an import; nullptr: unknown here and further up.
  const Prototype* find(std::string_view dotted) const;
  void list(std::string_view prefix, std::vector<std::string>& names) const;
  bool incomplete_anywhere() const;
};

/// What a `<param type=…>` stands for.
struct ParamType {
  std::string_view name;
  enum class Form { any, quantity, integer, boolean, text, list } form = Form::quantity;
  Dimension dimension;
};
/// nullptr: no such type. "" is a plain number.
const ParamType* find_param_type(std::string_view name);

/// How a door moves; see the vocabulary of <door>.
struct DoorDrive {
  const Element* door = nullptr;
  const Element* leaf = nullptr;
  SourceSpan at;
  std::string axis;             ///< in the leaf's frame, "1 0 0"
  double travel = 1.0;          ///< [m] > 0
  std::optional<double> force;  ///< [N]
  double speed = 1.0;           ///< [m/s]
  bool open = false;            ///< at the start
};

class Expander {
 public:
  explicit Expander(CompileContext& context) : context_(context) {}
  Element* run(const Document& scene);

 private:
  friend class MazeMaker;
  /// Where new elements are inserted, and the scope they have.
  struct InsertPoint {
    Element* into = nullptr;
    const Scope* scope = nullptr;
    const Trail* trail = nullptr;
    const Definitions* definitions = nullptr;
    const Element* home = nullptr;
    std::string key;    ///< of random numbers drawn while expanding
    int instances = 0;  ///< instances around
    int depth = 0;      ///< elements, iterations and instances around
    /// Of an imported file: only its definitions are taken, the rest is named here.
    std::vector<std::string_view>* ignored = nullptr;
  };

  // expand_scene.cpp
  Element* make(const Node& node, const InsertPoint& point);
  void children(const Node& node, const InsertPoint& point, Definitions* own = nullptr);
  void define(const Node& node, const InsertPoint& point, Definitions& definitions);
  /// Remembers that `node` failed, so that its absence is not reported.
  void mark_failed(const Node& node, const InsertPoint& point);
  void child(const Node& node, const InsertPoint& point, int ordinal);
  void instance(const Node& node, const InsertPoint& point, const std::string& key);
  const Trail* step(const InsertPoint& point, std::string text, const SourceSpan& at);
  /// False, once and for all, when `cost` more elements would be too many.
  bool within_limits(const Node& node, const InsertPoint& point, std::size_t cost = 1);
  bool spend(const Node& node, const InsertPoint& point, std::size_t work) {
    return dsl::spend(context_, work, node.span, point.trail);
  }

  // expand_flow.cpp
  void repeat(const Node& node, const InsertPoint& point, const std::string& key);
  void for_each(const Node& node, const InsertPoint& point, const std::string& key);
  void condition(const Node& node, const InsertPoint& point, const std::string& key);

  // expand_made.cpp: generated elements, which replace written ones
  Node& made_node(std::string_view tag, const SourceSpan& at);
  void give(Node& node, std::string_view attribute, std::string text);
  /// Copies an attribute as it is written, with its position; nothing when it is not written.
  static void hand_down(Node& node, std::string_view attribute, const Node& from,
                        std::string_view written);
  Element* add_made(const Node& node, const InsertPoint& point, std::string name);
  /// An element that is only read: for its attributes.
  Element& read_only(const Node& node, const InsertPoint& point, const std::string& key);
  /// False: nameless, and reported.
  bool written_name(Element& written, const InsertPoint& point, std::string& name);

  // expand_maze.cpp
  void maze(const Node& node, const InsertPoint& point, const std::string& key);

  // expand_door.cpp
  void door(const Node& node, const InsertPoint& point, const std::string& key);
  /// Slider and motor of a leaf that stands in `inside`.
  int door_drive(const Node& node, const InsertPoint& inside, const DoorDrive& drive);

  // expand_scatter.cpp
  void scatter(const Node& node, const InsertPoint& point, const std::string& key);

  // expand_param.cpp
  void define_params(const Node& container, Scope& scope, const InsertPoint& point,
                     const Element* instance, bool is_scene);
  /// Poison: it has none, or none of its type, which was reported.
  Value param_value(const Element& param, const ParamType* type, const std::string& name,
                    const Node& container, const Element* instance, bool is_scene);
  void check_bounds(const Element& param, const ParamType& type, const Value& value,
                    std::string_view name, const SourceSpan& at, const Trail* trail);
  void check_given_names(const Node& container, const Element* instance, bool is_scene);

  // expand_import.cpp
  void import(const Node& node, const InsertPoint& point, Definitions& into);
  bool is_cycle(const Document& document, const SourceSpan& at, const Trail* trail);
  void merge(const Definitions& from, const std::string& href, const SourceSpan& at,
             const Trail* trail, Definitions& into);

  // expand_names.cpp
  void name_children(Element& parent);

  CompileContext& context_;
  std::deque<Definitions> definitions_;
  std::vector<const Document*> open_documents_;
  std::set<std::pair<const Element*, const Document*>> merged_;
  std::size_t made_ = 0;
  std::size_t path_bytes_ = 0;  ///< of all dotted names: they grow with depth times width
  bool full_ = false;
};

}  // namespace cogrsim::dsl
