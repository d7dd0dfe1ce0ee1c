#include "values/attribute_text.h"

#include "report/diagnostics.h"
#include "values/reader.h"

namespace cogrsim::dsl {
namespace {

std::string_view trimmed(std::string_view text, std::size_t& begin) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
  begin = 0;
  std::size_t end = text.size();
  while (begin < end && blank(text[begin])) ++begin;
  while (end > begin && blank(text[end - 1])) --end;
  return text.substr(begin, end - begin);
}

}  // namespace

Value value_of(const std::vector<NumberEntry>& entries) {
  ValueList list;
  for (const NumberEntry& e : entries) {
    if (e.poison || e.none) return Value::poison();
    list.push_back(Value::number(e.value, e.dimension));
  }
  if (list.size() == 1) return list.front();
  return Value::list(std::move(list));
}

SourceSpan AttributeText::span(std::size_t begin, std::size_t length) const {
  return context_.files.span_in_value(attribute_, begin, length);
}

void AttributeText::report(const ExpressionFault& fault) {
  report(fault.code.c_str(), fault.begin, fault.length, fault.message, fault.help);
}

void AttributeText::report(const char* code, std::size_t begin, std::size_t length,
                           std::string message, std::string help) {
  context_.sink.report(code, span(begin, length), trail_, std::move(message)).help(std::move(help));
}

Value AttributeText::evaluate(std::size_t begin, std::size_t length,
                              std::optional<ExpressionFault>& fault) {
  if (!spend(200 + 16 * length)) return Value::poison();
  if (!random_) {
    random_.emplace(context_.seed, std::string(path_) + '@' + std::string(attribute_.name));
  }
  const Environment environment{scope_, &*random_, &context_.work};
  Value v = dsl::evaluate(text().substr(begin, length), environment, fault);
  if (fault) {
    fault->begin += begin;
    if (text().empty()) fault->length = 1;
  }
  return v;
}

std::optional<std::string> AttributeText::interpolate() {
  if (context_.work == 0) return std::nullopt;
  const std::string_view all = text();
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t begin = all.find("${", at);
    out += all.substr(at, std::min(begin, all.size()) - at);
    if (begin == std::string_view::npos) {
      if (!spend(16 * out.size())) return std::nullopt;
      return out;
    }
    const std::size_t end = expression_end(all, begin);
    if (end == std::string_view::npos) {
      report("CG0511", begin, 2, "the expression's closing } is missing");
      return std::nullopt;
    }
    std::optional<ExpressionFault> fault;
    const Value v = evaluate(begin + 2, end - begin - 3, fault);
    if (fault) report(*fault);
    if (v.is_poison()) return std::nullopt;
    // A list as text is up to 32 bytes an entry.
    if (size_of(v, kLongestText + 1) <= kLongestText) {
      out += to_text(v);
    } else {
      out.resize(kLongestText + 1);
    }
    if (out.size() > kLongestText) {
      report("CG0511", begin, end - begin, "the text grows too long");
      return std::nullopt;
    }
    at = end;
  }
}

Value AttributeText::expression() {
  if (context_.work == 0) return Value::poison();
  std::size_t begin = 0;
  const std::string_view inside = trimmed(text(), begin);
  std::size_t length = inside.size();
  if (inside.substr(0, 2) == "${" && expression_end(inside, 0) == inside.size()) {
    begin += 2;
    length -= 3;
  }
  std::optional<ExpressionFault> fault;
  Value v = evaluate(begin, length, fault);
  if (fault) report(*fault);
  return v;
}

std::optional<std::vector<NumberEntry>> AttributeText::numbers(const NumberSyntax& syntax) {
  std::optional<ExpressionFault> fault;
  auto entries = parse(syntax, fault);
  if (context_.work == 0) return std::nullopt;
  if (!fault) return entries;
  report(*fault);
  return std::nullopt;
}

std::vector<NumberEntry> AttributeText::parse(const NumberSyntax& syntax,
                                              std::optional<ExpressionFault>& fault) {
  if (!spend(2 * text().size())) return {};
  auto entries = parse_numbers(
      text(), syntax,
      [this](std::string_view inside, std::size_t begin, std::optional<ExpressionFault>& f) {
        return evaluate(begin, inside.size(), f);
      },
      fault);
  if (!spend(64 * entries.size())) return {};
  return entries;
}

Value AttributeText::any() {
  if (context_.work == 0) return Value::poison();
  std::size_t begin = 0;
  const std::string_view inside = trimmed(text(), begin);
  if (inside.empty()) return Value::text({});
  if (inside == "true" || inside == "false") return Value::boolean(inside == "true");
  if (inside.substr(0, 2) == "${" && expression_end(inside, 0) == inside.size()) {
    return expression();
  }
  // Numbers where everything is one; else text. What only looks like a number is an error.
  std::optional<ExpressionFault> fault;
  auto entries = parse({}, fault);
  if (context_.work == 0) return Value::poison();
  const char c = inside[0];
  const bool digit = (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
  if (!fault && !entries.empty()) {
    bool words = false;
    for (const NumberEntry& e : entries) words = words || e.none;
    if (!words) return value_of(entries);
  } else if (fault && digit && (fault->code == "CG0504" || fault->code == "CG0505")) {
    report(*fault);
    return Value::poison();
  }
  std::optional<std::string> spliced = interpolate();
  return spliced ? Value::text(std::move(*spliced)) : Value::poison();
}

Value parse_value_text(std::string_view text, std::string* problem) {
  std::optional<ExpressionFault> fault;
  const ExpressionEvaluator evaluator = [](std::string_view inside, std::size_t begin,
                                           std::optional<ExpressionFault>& f) {
    Value v = evaluate(inside, {}, f);
    if (f) f->begin += begin;
    return v;
  };
  std::size_t begin = 0;
  const std::string_view inside = trimmed(text, begin);
  if (inside == "true" || inside == "false") return Value::boolean(inside == "true");
  if (inside.substr(0, 2) == "${" && expression_end(inside, 0) == inside.size()) {
    Value v = evaluator(inside.substr(2, inside.size() - 3), 2, fault);
    if (fault && problem) *problem = fault->message;
    return v;
  }
  // A list as a value of a study is written; not one that counts is a text.
  if (!inside.empty() && inside.front() == '[' && inside.back() == ']') {
    Value list = evaluator(inside, 0, fault);
    if (!fault) return list;
    fault.reset();
  }
  NumberSyntax syntax;
  syntax.glued = true;
  const auto entries = parse_numbers(inside, syntax, evaluator, fault);
  bool words = entries.empty();
  for (const NumberEntry& e : entries) words = words || e.none;
  if (!fault && !words) return value_of(entries);
  if (fault && (fault->code == "CG0504" || fault->code == "CG0505")) {
    const char c = inside.empty() ? ' ' : inside[0];
    if ((c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.') {
      if (problem) *problem = fault->message + (fault->help.empty() ? "" : "; " + fault->help);
      return Value::poison();
    }
  }
  return Value::text(std::string(inside));
}

std::optional<std::string> interpolate(CompileContext& context, const Node&,
                                       const Attribute& attribute, const Scope* scope,
                                       const Trail* trail, std::string_view path) {
  return AttributeText(context, attribute, scope, trail, path).interpolate();
}

Value evaluate_attribute(CompileContext& context, const Node&, const Attribute& attribute,
                         const Scope* scope, const Trail* trail, std::string_view path) {
  return AttributeText(context, attribute, scope, trail, path).expression();
}

}  // namespace cogrsim::dsl
