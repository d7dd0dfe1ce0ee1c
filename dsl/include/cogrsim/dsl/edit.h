// Editing a scene by its elements: the text is changed where it must be and nowhere else.
//
// Elements of a scene file have numbers, their ids: document order from 0, which is `<scene>`. They
// hold for one text. Comments, layout, the order of attributes and line endings stay as they are;
// what is new is indented like its neighbours. Comment lines directly above an element go with it
// when it moves, and stay when it is removed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cogrsim/core/types.h"
#include "cogrsim/dsl/compiler.h"

namespace cogrsim::dsl {

/// An element of the scene file.
struct OutlineElement {
  int id = 0;
  int parent = -1;  ///< -1: none
  std::string tag;
  std::string
      name;  ///< as written, or the one that was generated when the scene compiled; may be empty
  std::string path;  ///< dotted, of the object that the element became; empty: none, or several
  int line = 0, column = 0;  ///< of its '<', from 1; columns in code points
  int end_line = 0;          ///< of its last character
  /// In file order, entities replaced.
  std::vector<std::pair<std::string, std::string>> attributes;
  /// Stands for exactly one object of the scene: not in a prototype, repeat, scatter or template.
  bool single = false;
};

/// Which element of the scene file an item of the model came from.
struct Origin {
  int element = -1;  ///< -1: none, it came from another file or from a program
  bool own = false;  ///< that element is this item and no other of its kind
};

/// By index of SceneModel's vectors of the same names.
struct ModelOrigins {
  std::vector<Origin> bodies, assemblies, joints, motors, sensors, controllers, supervisors, lights,
      views, regions, plots, forces;
};

/// A compiled scene together with the elements it came from.
struct OutlinedScene {
  CompileResult result;
  std::vector<OutlineElement> elements;  ///< empty: the text is not well-formed
  ModelOrigins origins;                  ///< empty unless it compiled
};

/// As compile_text(), with the outline of the text.
COGRSIM_API OutlinedScene compile_outlined(const std::string& text, const std::string& name,
                                           const CompileOptions& options = {});

/// The elements of a text, without compiling it: `single` and `path` are not known. Empty: the text
/// is not well-formed; `diagnostics`, if given, says why.
COGRSIM_API std::vector<OutlineElement> outline_text(const std::string& text,
                                                     const std::string& name,
                                                     std::vector<Diagnostic>* diagnostics = nullptr,
                                                     const Limits& limits = {});

// ---- operations; ids are those of the text before the first of several

/// Writes an attribute, as text in the scene's notation; nullopt takes it out. A new one comes last.
struct SetAttribute {
  int element = 0;
  std::string attribute;
  std::optional<std::string> value;
};

/// Puts an element in; `xml` is one element with all inside it. A name that is taken in its scope
/// gets a number.
struct InsertElement {
  int parent = 0;
  std::string xml;
  std::optional<int> before;  ///< child of `parent`; nullopt: last
};

/// Removes elements with their content, and the elements that refer to them: joints, motors,
/// sensors, actions, series, expectations. Elements that were only placed relative to them keep
/// their poses; references to a removed material are deleted.
struct RemoveElements {
  std::vector<int> elements;
};

/// Moves an element to another parent. References to it, and from it, follow.
struct MoveElement {
  int element = 0;
  int parent = 0;
  std::optional<int> before;
  bool keep_place = true;  ///< the pose in the world stays; else the written one
};

/// Gives a name. What names it in the file follows: references, signals, conditions, events, dotted
/// names through it, and texts in `<set>` that mean it.
struct RenameElement {
  int element = 0;
  std::string name;
};

/// A copy behind the element, with a name of its own; references within the copy refer to the copy.
struct DuplicateElement {
  int element = 0;
  Vec3 offset = Vec3::Zero();  ///< in the world [m]
};

/// Puts the element's frame there, in the world, at the start of the run. Written as xyz and rpy (or
/// quat, direction) in the units the attributes have, else metres and degrees, with the fewest
/// decimals that are within 5e-7 m and 5e-7 rad of it.
struct PlaceElement {
  int element = 0;
  Pose pose;
};

/// One `<assembly rigid="true">` around elements of one parent, at the position of the first of
/// them. Poses in the world stay within 1e-9 m; static and kinematic, if they all have it, go to
/// the whole. Refused when a joint connects two of them, or when they move differently.
struct AssembleElements {
  std::vector<int> elements;
  std::string name;
  std::string material;  ///< of all parts; empty: each keeps its own
};

/// One `<assembly>` around elements of one parent, before the first of them: a scope of names, and
/// what a controller commands. Nothing moves; names that lead into it follow.
struct GroupElements {
  std::vector<int> elements;
  std::string name;  ///< gets a number if it is taken
};

/// Replaces an assembly by its parts, which keep their poses. References to the assembly then refer
/// to its first part. A material, mass, static, kinematic and velocity of the whole go to the
/// parts.
struct DisassembleElement {
  int element = 0;
};

using EditOperation = std::variant<SetAttribute, InsertElement, RemoveElements, MoveElement,
                                   RenameElement, DuplicateElement, PlaceElement, AssembleElements,
                                   DisassembleElement, GroupElements>;

struct EditResult {
  std::string text;
  std::vector<int> created;  ///< ids, in the new text, of elements put in, duplicated or assembled
  OutlinedScene scene;       ///< the new text, compiled
};

/// All of them, or none. `name` and `options` as for compile_text(). Errors: the text is not
/// well-formed; an id, attribute or parent that does not exist; what cannot be done, with what to
/// do instead; a scene that compiled and then would not: the message is the compiler's.
COGRSIM_API Result<EditResult> edit_text(const std::string& text, const std::string& name,
                                         const std::vector<EditOperation>& operations,
                                         const CompileOptions& options = {});

/// Shortest decimal notation within `tolerance` > 0 of a number; "0" for all within it.
COGRSIM_API std::string short_number(double value, double tolerance);

}  // namespace cogrsim::dsl
