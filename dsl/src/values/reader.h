// Reads attributes of expanded elements. What kind, dimension, default and bounds an attribute has
// is looked up in the vocabulary by element and attribute name; faults are reported with the exact
// column, and the value is then absent or poisoned.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/types.h"
#include "syntax/element.h"
#include "language/vocabulary.h"

namespace cogrsim::dsl {

/// What came of reading. `state`: given (written and good), absent (not written; `value` holds the
/// vocabulary's default if it has one, else a zero), failed (reported; `value` is a default that is
/// safe to compute with, but nothing that depends on it may be reported).
template <class T>
struct Read {
  enum class State { absent, given, failed } state = State::absent;
  T value{};
  bool given() const { return state == State::given; }
  bool failed() const { return state == State::failed; }
  const T& operator*() const { return value; }
};

/// A name used in an attribute, with its position.
struct Word {
  std::string text;
  SourceSpan span;
};

/// `normal(0, 3 mm)`.
struct Call {
  std::string function;
  std::vector<Quantity> arguments;
  SourceSpan span;
};

struct Interval {
  double low = 0.0, high = 0.0;
};

/// Attributes of one element. Cheap to make; every accessor asserts that the vocabulary knows
/// the attribute with that kind.
class Reader {
 public:
  Reader(CompileContext& context, const Element& element) : context_(context), element_(element) {}

  bool has(std::string_view attribute) const { return element_.find(attribute) != nullptr; }

  Read<double> number(std::string_view attribute);
  /// For attributes with alternatives: which of the dimensions holds here.
  Read<double> number(std::string_view attribute, const Dimension& dimension);
  Read<std::int64_t> integer(std::string_view attribute);
  Read<bool> boolean(std::string_view attribute);
  Read<std::vector<double>> numbers(std::string_view attribute);
  /// Alternatives, or fewer entries than the vocabulary allows: `dimensions` entry by entry.
  Read<std::vector<double>> numbers(std::string_view attribute,
                                    const std::vector<Dimension>& dimensions);
  Read<Vec3> vec3(std::string_view attribute);
  Read<Interval> range(std::string_view attribute);
  Read<Color> color(std::string_view attribute);
  /// text, name, choice and file attributes, with ${…} spliced in.
  Read<std::string> text(std::string_view attribute);
  /// name and reference attributes: non-empty and well-formed, else reported.
  Read<Word> word(std::string_view attribute);
  Read<std::vector<Word>> words(std::string_view attribute);
  /// noise attributes; arguments with `dimension` or plain, the caller checks names and numbers.
  Read<std::vector<Call>> calls(std::string_view attribute);
  /// expression attributes, `${…}` around the whole being optional.
  Read<Value> expression(std::string_view attribute);
  /// value attributes: a number with unit or list of them, true/false, an expression's value,
  /// else the text itself.
  Read<Value> value(std::string_view attribute);

  /// One attribute of `<set>` or an engine block as a plugin's parameter: type, unit, range and
  /// choices are the spec's.
  Read<ParameterValue> parameter(const Attribute& attribute, const ParameterSpec& spec);
  /// One attribute of `<instance>` for a `<param>`: as value(), for a name that is not in the
  /// vocabulary.
  Read<Value> value(const Attribute& attribute);

  /// X_PE from xyz with rpy or quat; absent ones are zero. Both rpy and quat is an error.
  Read<Pose> pose();

 private:
  CompileContext& context_;
  const Element& element_;
};

/// The same values from text that stands in no element, `--set name=value`: here "3cm" is "3 cm",
/// and [1, 2] a list. Faults come back as a message, not in the sink.
Value parse_value_text(std::string_view text, std::string* problem);

/// Splices ${…} into text outside of an element's attribute reader, for names during expansion.
/// nullopt: reported.
std::optional<std::string> interpolate(CompileContext& context, const Node& node,
                                       const Attribute& attribute, const Scope* scope,
                                       const Trail* trail, std::string_view path);
/// The same for an expression attribute of a node that is not an element yet (repeat, for, if).
Value evaluate_attribute(CompileContext& context, const Node& node, const Attribute& attribute,
                         const Scope* scope, const Trail* trail, std::string_view path);

}  // namespace cogrsim::dsl
