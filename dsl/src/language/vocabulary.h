// THE table of the scene language: every element, every attribute. The vocabulary checks, the
// attribute readers, the XSD and the reference page all read it; nothing is said twice.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "syntax/node.h"
#include "values/value.h"

namespace cogrsim::dsl {

/// How an attribute's text is read.
enum class Kind {
  name,        ///< a new name: letter or _, then letters, digits, _ and -; no dots
  reference,   ///< a dotted name of something else
  references,  ///< several, separated by blanks
  text,        ///< free text
  boolean,     ///< true, false
  choice,      ///< one of `choices`
  integer,     ///< a whole number
  number,      ///< with a dimension
  numbers,     ///< a list, see min_count and max_count
  range,       ///< "2 .. 80 cm"
  color,       ///< #rgb, #rrggbb, #rrggbbaa, CSS name
  file,        ///< a path below the scene's folder
  noise,       ///< "normal(0, 3 mm) dropout(0.01)"
  expression,  ///< a bare expression, no ${} needed
  value        ///< any value; its type is decided elsewhere (param, set)
};

struct AttributeSpec {
  std::string_view name;
  Kind kind = Kind::text;
  std::string_view doc;                ///< one sentence, with the meaning of leaving it out
  std::string_view default_text = {};  ///< in the language's notation; empty: none
  bool required = false;
  /// Dimensions of number, numbers, range, noise. One: of every entry. Several: entry by entry when
  /// `per_entry`, else alternatives, and the reader is given the one that holds (for a motor, by
  /// its joint).
  std::vector<Dimension> dimensions = {};
  bool per_entry = false;
  int min_count = 1, max_count = 1;  ///< of numbers
  bool none_allowed = false;         ///< entries may be the word "none": unlimited
  double minimum = -std::numeric_limits<double>::infinity();  ///< SI
  double maximum = std::numeric_limits<double>::infinity();
  bool above_minimum = false;  ///< minimum itself is not allowed
  std::vector<std::string_view> choices = {};
};

struct ElementSpec {
  std::string_view name;
  std::string_view group;  ///< heading on the reference page
  std::string_view doc;
  std::vector<AttributeSpec> attributes;
  std::vector<std::string_view> children;  ///< allowed content; flow elements are implied
                                           ///< wherever anything may
  std::string_view example = {};
  bool flow = false;             ///< repeat, for, if: takes what its parent takes
  bool open_attributes = false;  ///< set, instance: any further attribute
  bool engine_blocks = false;    ///< physics, assembly: may hold `<ENGINE …/>`
  bool text = false;             ///< takes character data

  const AttributeSpec* find(std::string_view attribute) const;
};

/// All elements, in the order of the reference page.
const std::vector<ElementSpec>& vocabulary();
const ElementSpec* find_element(std::string_view name);
/// `<contact>` has two meanings: a rule for a pair of materials, which find_element() gives, and,
/// with `on`, a sensor, which this is.
const ElementSpec& contact_sensor();

/// Joint elements: hinge slider ball universal gimbal fixed cylindrical planar screw free.
bool is_joint(std::string_view element);
/// Elements that act on bodies: force drag spring buoyancy wind.
bool is_force(std::string_view element);
/// Shape elements: box sphere cylinder capsule ellipsoid cone prism plane mesh
/// heightmap.
bool is_shape(std::string_view element);
/// Sensor elements; false for nullptr.
bool is_sensor(const ElementSpec* element);

/// Checks a parsed tree: unknown or misplaced elements, unknown and missing attributes, text
/// where none belongs. Fills Node::spec. Faulty elements stay in the tree with a null spec and
/// must be skipped silently afterwards (engine blocks too have a null spec: see is_engine_block).
void check_vocabulary(Document& document, SourceFiles& files, DiagnosticSink& sink);

/// An `<ENGINE …/>` inside physics or assembly.
bool is_engine_block(const Node& node, const SourceFiles& files);

}  // namespace cogrsim::dsl
