// Readers of words, truth values, colors, expressions; numbers are in reader_numbers.cpp.
#include "values/reader.h"

#include <algorithm>
#include <cassert>

#include "values/attribute_text.h"
#include "report/diagnostics.h"
#include "values/reader_detail.h"
#include "syntax/text.h"

namespace cogrsim::dsl {

namespace detail {

const AttributeSpec& spec_of(const Element& element, std::string_view attribute) {
  assert(element.node->spec && "engine blocks have no vocabulary: use parameter()");
  const AttributeSpec* spec = element.node->spec->find(attribute);
  assert(spec && "every attribute that is read is in the vocabulary");
  return *spec;
}

AttributeText text_of(CompileContext& context, const Element& element, const Attribute& a) {
  return AttributeText(context, a, element.scope, element.trail, element.path);
}

}  // namespace detail

namespace {

using detail::spec_of;
using detail::text_of;

/// Letter or _, then letters, digits, _ and -; with dots only where `dotted`.
bool well_formed(std::string_view name, bool dotted) {
  bool first = true;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool other = (c >= '0' && c <= '9') || c == '-';
    if (first ? !letter : !letter && !other && !(dotted && c == '.')) return false;
    first = c == '.';
  }
  return !first;
}

/// The name that was probably meant: what is not allowed becomes _.
std::string repaired(std::string_view name) {
  std::string out;
  for (const char c : name) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
                      (c >= '0' && c <= '9') || c == '-';
    if (good) {
      out += c;
    } else if (out.empty() || out.back() != '_') {
      out += '_';
    }
  }
  if (out.empty() ||
      !((out[0] >= 'a' && out[0] <= 'z') || (out[0] >= 'A' && out[0] <= 'Z') || out[0] == '_')) {
    out.insert(out.begin(), '_');
  }
  return out;
}

std::string listed(const std::vector<std::string>& words) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i) out += i + 1 == words.size() ? " or " : ", ";
    out += words[i];
  }
  return out;
}

/// Words of a text that was spliced together; positions are exact only where nothing was spliced.
std::vector<Word> split_words(const AttributeText& source, const std::string& text) {
  const bool exact = text == source.text();
  std::vector<Word> out;
  for (std::size_t i = 0; i < text.size();) {
    if (is_blank(text[i])) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < text.size() && !is_blank(text[i])) ++i;
    out.push_back({text.substr(begin, i - begin),
                   exact ? source.span(begin, i - begin) : source.span(0, source.text().size())});
  }
  return out;
}

}  // namespace

Read<bool> Reader::boolean(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::boolean);
  Read<bool> out;
  out.value = spec.default_text == "true";
  const Attribute* a = element_.find(attribute);
  if (!a) return out;
  out.state = Read<bool>::State::failed;
  AttributeText source = text_of(context_, element_, *a);
  const Value v = source.any();
  if (v.is_poison()) return out;
  if (const bool* b = v.as_boolean()) {
    out.value = *b;
    out.state = Read<bool>::State::given;
    return out;
  }
  const std::string word = to_text(v);
  std::string help = braces_help(word);
  if (word == "yes" || word == "on" || word == "1" || word == "True" || word == "TRUE") {
    help = "did you mean \"true\"?";
  } else if (word == "no" || word == "off" || word == "0" || word == "False" || word == "FALSE") {
    help = "did you mean \"false\"?";
  }
  source.report("CG0509", 0, source.text().size(), "expected true or false, found \"" + word + "\"",
                help);
  return out;
}

Read<Color> Reader::color(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::color);
  Read<Color> out;
  if (!spec.default_text.empty()) out.value = *parse_color(spec.default_text);
  const Attribute* a = element_.find(attribute);
  if (!a) return out;
  out.state = Read<Color>::State::failed;
  AttributeText source = text_of(context_, element_, *a);
  const auto text = source.interpolate();
  if (!text) return out;
  if (const auto color = parse_color(*text)) {
    out.value = *color;
    out.state = Read<Color>::State::given;
    return out;
  }
  const std::string near = nearest_color(*text);
  const std::string braces = braces_help(*text);
  source.report("CG0510", 0, source.text().size(), "\"" + *text + "\" is not a color",
                !braces.empty() ? braces
                : near.empty()  ? "write #rgb, #rrggbb, #rrggbbaa or a CSS color name"
                                : "did you mean \"" + near + "\"?");
  return out;
}

Read<std::string> Reader::text(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  Read<std::string> out;
  out.value = std::string(spec.default_text);
  const Attribute* a = element_.find(attribute);
  if (!a) return out;
  out.state = Read<std::string>::State::failed;
  AttributeText source = text_of(context_, element_, *a);
  auto text = source.interpolate();
  if (!text) return out;
  if (spec.kind == Kind::choice &&
      std::find(spec.choices.begin(), spec.choices.end(), *text) == spec.choices.end()) {
    std::vector<std::string> choices(spec.choices.begin(), spec.choices.end());
    const std::string near = nearest_name(*text, choices);
    source.report(
        "CG0508", 0, source.text().size(),
        "\"" + std::string(attribute) + "\" is " + listed(choices) + ", found \"" + *text + "\"",
        near.empty() ? braces_help(*text) : "did you mean \"" + near + "\"?");
    return out;
  }
  out.value = std::move(*text);
  out.state = Read<std::string>::State::given;
  return out;
}

Read<Word> Reader::word(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::name || spec.kind == Kind::reference);
  Read<Word> out;
  const Attribute* a = element_.find(attribute);
  if (!a) {
    out.value.text = std::string(spec.default_text);
    out.value.span = element_.span();
    return out;
  }
  out.state = Read<Word>::State::failed;
  out.value.span = a->value_span;
  AttributeText source = text_of(context_, element_, *a);
  auto text = source.interpolate();
  if (!text) return out;
  const bool dotted = spec.kind == Kind::reference;
  if (!well_formed(*text, dotted)) {
    std::string help = braces_help(*text);
    if (!help.empty() || text->empty()) {
    } else if (!dotted && text->find('.') != std::string::npos) {
      help = "dots only separate scopes, in references; did you mean \"" + repaired(*text) + "\"?";
    } else if (repaired(*text).find_first_not_of('_') == std::string::npos) {
      help = "names are made of the letters a to z and A to Z, digits, _ and -";
    } else if (!dotted) {
      help = "did you mean \"" + repaired(*text) + "\"?";
    }
    source.report("CG0403", 0, source.text().size(),
                  text->empty() ? "an empty name" : "\"" + *text + "\" cannot be a name", help);
    return out;
  }
  out.value.text = std::move(*text);
  out.state = Read<Word>::State::given;
  return out;
}

Read<std::vector<Word>> Reader::words(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::references || spec.kind == Kind::text);
  Read<std::vector<Word>> out;
  const Attribute* a = element_.find(attribute);
  if (!a) return out;
  out.state = Read<std::vector<Word>>::State::failed;
  AttributeText source = text_of(context_, element_, *a);
  const auto text = source.interpolate();
  if (!text) return out;
  out.value = split_words(source, *text);
  const auto count = static_cast<int>(out.value.size());
  if (spec.kind == Kind::references) {
    for (const Word& w : out.value) {
      if (well_formed(w.text, true)) continue;
      context_.sink.report("CG0403", w.span, element_.trail, "\"" + w.text + "\" cannot be a name")
          .help(braces_help(w.text));
      return out;
    }
    if (count < spec.min_count || count > spec.max_count) {
      source.report(
          "CG0506", 0, source.text().size(),
          "expected " + std::to_string(spec.max_count) + " names, found " + std::to_string(count));
      return out;
    }
  }
  out.state = Read<std::vector<Word>>::State::given;
  return out;
}

Read<std::vector<Call>> Reader::calls(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::noise);
  Read<std::vector<Call>> out;
  const Attribute* a = element_.find(attribute);
  if (!a) return out;
  out.state = Read<std::vector<Call>>::State::failed;
  AttributeText source = text_of(context_, element_, *a);
  const std::string_view text = source.text();
  const auto syntax = [&](std::size_t begin, std::size_t length) {
    source.report("CG0517", begin, length, "this is not a noise term",
                  "write for example \"normal(0, 0.01)\"");
  };
  for (std::size_t i = 0; i < text.size();) {
    if (is_blank(text[i]) || text[i] == '+') {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < text.size() && (well_formed(text.substr(begin, i + 1 - begin), false))) ++i;
    std::size_t open = i;
    while (open < text.size() && is_blank(text[open])) ++open;
    if (i == begin || open >= text.size() || text[open] != '(') {
      syntax(begin, std::max<std::size_t>(1, i - begin));
      return out;
    }
    Call call;
    call.function = std::string(text.substr(begin, i - begin));
    // Arguments up to the bracket's end, at commas outside of inner brackets.
    int depth = 1;
    std::size_t argument = open + 1, end = open + 1;
    std::vector<std::pair<std::size_t, std::size_t>> arguments;
    for (; end < text.size() && depth > 0; ++end) {
      const char c = text[end];
      if (c == '(') ++depth;
      if (c == ')') --depth;
      if ((c == ',' && depth == 1) || depth == 0) {
        arguments.push_back({argument, end - argument});
        argument = end + 1;
      }
    }
    if (depth > 0) {
      source.report("CG0517", begin, text.size() - begin, "the bracket is not closed");
      return out;
    }
    call.span = source.span(begin, end - begin);
    for (auto [at, length] : arguments) {
      while (length > 0 && is_blank(text[at])) ++at, --length;
      while (length > 0 && is_blank(text[at + length - 1])) --length;
      if (text.substr(at, 2) == "${" && length > 3 && text[at + length - 1] == '}') {
        at += 2;
        length -= 3;
      }
      std::optional<ExpressionFault> fault;
      const Value v = source.evaluate(at, length, fault);
      if (fault) source.report(*fault);
      if (v.is_poison()) return out;
      const Quantity* q = v.as_number();
      const bool fine =
          q && (q->dimension.none() ||
                std::any_of(spec.dimensions.begin(), spec.dimensions.end(),
                            [&](const Dimension& d) { return fits(q->dimension, d); }));
      if (!fine) {
        const Dimension wanted = spec.dimensions.empty() ? Dimension{} : spec.dimensions[0];
        source.report("CG0502", at, length,
                      "expected " + describe(wanted) + ", found " + describe(v));
        return out;
      }
      call.arguments.push_back(*q);
    }
    out.value.push_back(std::move(call));
    i = end;
  }
  out.state = Read<std::vector<Call>>::State::given;
  return out;
}

Read<Value> Reader::expression(std::string_view attribute) {
  Read<Value> out;
  const Attribute* a = element_.find(attribute);
  if (!a) return out;
  out.value = text_of(context_, element_, *a).expression();
  out.state = out.value.is_poison() ? Read<Value>::State::failed : Read<Value>::State::given;
  return out;
}

Read<Value> Reader::value(std::string_view attribute) {
  const Attribute* a = element_.find(attribute);
  return a ? value(*a) : Read<Value>{};
}

Read<Value> Reader::value(const Attribute& attribute) {
  Read<Value> out;
  out.value = text_of(context_, element_, attribute).any();
  out.state = out.value.is_poison() ? Read<Value>::State::failed : Read<Value>::State::given;
  return out;
}

}  // namespace cogrsim::dsl
