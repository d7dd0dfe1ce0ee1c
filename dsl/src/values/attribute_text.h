// One attribute's text with the scope that its expressions see. The common ground of the
// readers for expanded elements and for nodes that expansion is still working on.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/types.h"
#include "syntax/element.h"
#include "values/number_list.h"

namespace cogrsim::dsl {

class AttributeText {
 public:
  AttributeText(CompileContext& context, const Attribute& attribute, const Scope* scope,
                const Trail* trail, std::string_view path)
      : context_(context), attribute_(attribute), scope_(scope), trail_(trail), path_(path) {}

  std::string_view text() const { return attribute_.value; }
  SourceSpan span(std::size_t begin, std::size_t length) const;

  /// Reports at `length` bytes from `begin`.
  void report(const ExpressionFault& fault);
  void report(const char* code, std::size_t begin, std::size_t length, std::string message,
              std::string help = {});

  /// Value of an expression that is `length` bytes from `begin`; faults are returned.
  Value evaluate(std::size_t begin, std::size_t length, std::optional<ExpressionFault>& fault);
  /// The text with every ${…} replaced; nullopt: reported, or poison.
  std::optional<std::string> interpolate();
  /// The whole as a bare expression, ${…} around it being optional. Poison when reported.
  Value expression();
  /// Numbers; nullopt: reported.
  std::optional<std::vector<NumberEntry>> numbers(const NumberSyntax& syntax);
  /// A value of any type (see Reader::value); poison when reported.
  Value any();

 private:
  bool spend(std::size_t work) { return dsl::spend(context_, work, attribute_.value_span, trail_); }
  /// As numbers(), but a fault is left to the caller.
  std::vector<NumberEntry> parse(const NumberSyntax& syntax, std::optional<ExpressionFault>& fault);

  CompileContext& context_;
  const Attribute& attribute_;
  const Scope* scope_;
  const Trail* trail_;
  std::string_view path_;
  std::optional<RandomStream> random_;  // one stream per attribute, made when first needed
};

/// Entries as a value: a number, or a list where there are several.
Value value_of(const std::vector<NumberEntry>& entries);

/// #rgb, #rrggbb, #rrggbbaa or a CSS name; sRGB. nullopt: not a color.
std::optional<Color> parse_color(std::string_view text);
/// The CSS name nearest to a misspelt one.
std::string nearest_color(std::string_view text);

}  // namespace cogrsim::dsl
