#include "values/number_list.h"

#include <algorithm>
#include <cmath>

#include "syntax/text.h"

namespace cogrsim::dsl {
namespace {

ExpressionFault make_fault(const char* code, std::size_t begin, std::size_t length,
                           std::string message, std::string help = {}) {
  return {code, begin, std::max<std::size_t>(1, length), std::move(message), std::move(help)};
}

struct Token {
  std::size_t begin = 0, length = 0;
  bool expression = false;  // ${…}, perhaps with a minus before it
};

/// Splits at blanks, expressions staying whole.
std::vector<Token> split(std::string_view text, std::optional<ExpressionFault>& fault) {
  std::vector<Token> out;
  // Lists may be long, and growing them costs more than reading them.
  out.reserve(1 + static_cast<std::size_t>(std::count_if(text.begin(), text.end(), is_blank)));
  std::size_t i = 0;
  while (true) {
    while (i < text.size() && is_blank(text[i])) ++i;
    if (i >= text.size()) return out;
    Token t;
    t.begin = i;
    while (i < text.size() && !is_blank(text[i])) {
      if (text[i] == '$' && i + 1 < text.size() && text[i + 1] == '{') {
        const std::size_t end = expression_end(text, i);
        if (end == std::string_view::npos) {
          fault = make_fault("CG0511", i, 2, "the expression's closing } is missing");
          return {};
        }
        t.expression = true;
        i = end;
      } else {
        ++i;
      }
    }
    t.length = i - t.begin;
    out.push_back(t);
  }
}

/// The help for a word of `text` that is not a number.
ExpressionFault not_a_number(std::string_view text, std::size_t begin, std::size_t length) {
  const std::string_view word = text.substr(begin, length);
  std::string_view meant = word;  // of "{2 * w}" all of it
  if (word.find('{') != std::string_view::npos && word.find('}') == std::string_view::npos)
    meant = text.substr(begin, std::min(text.find('}', begin), text.size() - 1) + 1 - begin);
  std::string help = nearly_number_help(meant);
  const bool digit = word.find_first_of("+-.0123456789") == 0;
  if (!help.empty()) {
  } else if (!word.empty() && word.find(',') + 1 == word.size()) {
    help = "entries are separated by blanks";
  } else if (digit && word.find_first_not_of("+-.0123456789eE") == std::string_view::npos) {
    // Of a number's own characters, and yet no number.
    help = "numbers look like 12, -0.5 or 1.5e-3, up to about 1.8e308";
  } else if (!digit && !word.empty()) {
    const char c = word[0];
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '(' || c == '$' || c == '{') {
      help = "parameters and expressions are written in ${…}";
      if (word == "nan" || word == "NaN" || word == "inf" || word == "Infinity") {
        help = "values must be finite numbers";
      }
    }
  }
  return make_fault("CG0501", begin, word.size(), "\"" + std::string(word) + "\" is not a number",
                    help);
}

class ListParser {
 public:
  ListParser(std::string_view text, const NumberSyntax& syntax, const ExpressionEvaluator& evaluate,
             std::optional<ExpressionFault>& fault)
      : text_(text), syntax_(syntax), evaluate_(evaluate), fault_(fault) {}

  std::vector<NumberEntry> run() {
    const std::vector<Token> tokens = split(text_, fault_);
    entries_.reserve(tokens.size());
    for (const Token& t : tokens) {
      if (fault_) return {};
      take(t);
    }
    if (!fault_ && syntax_.dots && (dots_ != 1 || entries_.size() != 2)) {
      fault_ = make_fault("CG0501", 0, text_.size(),
                          "\"" + std::string(text_) + "\" is not a range", "write \"2 .. 80 cm\"");
    }
    if (!fault_) share_unit();
    return fault_ ? std::vector<NumberEntry>{} : std::move(entries_);
  }

 private:
  void take(Token t) {
    if (t.expression) {
      take_expression(t);
      return;
    }
    std::string_view word = text_.substr(t.begin, t.length);
    if (syntax_.commas) {
      while (!word.empty() && (word.back() == ',' || word.back() == ';')) word.remove_suffix(1);
      if (word.empty()) return;
    }
    if (syntax_.dots) {
      if (word == "..") {
        if (entries_.size() == 1) ++dots_;
        return;
      }
      // "2..80" without blanks.
      const std::size_t at = word.find("..");
      if (at != std::string_view::npos) {
        take({t.begin, at, false});
        ++dots_;
        if (!fault_ && at + 2 < word.size()) {
          take({t.begin + at + 2, word.size() - at - 2, false});
        }
        return;
      }
    }
    if (const auto number = parse_number(word)) {
      NumberEntry e;
      e.value = *number;
      e.begin = t.begin;
      e.length = e.number_length = word.size();
      entries_.push_back(e);
      unit_possible_ = true;
      return;
    }
    if (word == "none") {
      NumberEntry e;
      e.none = true;
      e.begin = t.begin;
      e.length = e.number_length = word.size();
      entries_.push_back(e);
      unit_possible_ = false;
      return;
    }
    if (const std::size_t digits = syntax_.glued ? number_length(word) : 0;
        digits > 0 && parse_unit(word.substr(digits))) {
      take({t.begin, digits, false});
      take_unit({t.begin + digits, word.size() - digits, false}, word.substr(digits));
      return;
    }
    if (unit_possible_) {
      take_unit(t, word);
    } else {
      fault_ = parse_unit(word)
                   ? make_fault("CG0501", t.begin, word.size(),
                                "the unit \"" + std::string(word) + "\" has no number before it")
                   : not_a_number(text_, t.begin, word.size());
    }
  }

  void take_unit(const Token& t, std::string_view word) {
    const auto unit = parse_unit(word);
    if (!unit) {
      const char c = word.empty() ? '\0' : plain_minus(word)[0];
      if ((c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == '$' || c == '{') {
        fault_ = not_a_number(text_, t.begin, word.size());
        return;
      }
      const std::string near = nearest_unit(word);
      fault_ =
          make_fault("CG0504", t.begin, word.size(), "\"" + std::string(word) + "\" is not a unit",
                     near.empty() ? "" : "did you mean \"" + near + "\"?");
      return;
    }
    unit_possible_ = false;
    NumberEntry& e = entries_.back();
    if (e.expression && !e.bare) {
      fault_ = make_fault("CG0502", e.begin, t.begin + word.size() - e.begin,
                          "the expression is " + describe(e.dimension) + " already",
                          "delete the unit behind it");
      return;
    }
    e.value = unit->to_si(e.value);
    e.dimension = unit->dimension;
    e.bare = false;
    e.length = t.begin + word.size() - e.begin;
    last_unit_ = entries_.size() - 1;
    unit_ = *unit;
    unit_text_ = word;
    ++units_;
  }

  void take_expression(const Token& t) {
    std::string_view word = text_.substr(t.begin, t.length);
    std::size_t begin = t.begin;
    double sign = 1.0;
    if (syntax_.commas) {
      while (!word.empty() && (word.back() == ',' || word.back() == ';')) word.remove_suffix(1);
    }
    if (word[0] == '-' || word[0] == '+') {
      sign = word[0] == '-' ? -1.0 : 1.0;
      word.remove_prefix(1);
      ++begin;
    }
    if (word.substr(0, 2) != "${" || expression_end(text_, begin) != begin + word.size()) {
      fault_ =
          make_fault("CG0501", t.begin, t.length,
                     "\"" + std::string(text_.substr(t.begin, t.length)) + "\" is not a number",
                     "put a blank between entries, and write whole expressions in one ${…}");
      return;
    }
    std::optional<ExpressionFault> inside;
    const Value v = evaluate_(word.substr(2, word.size() - 3), begin + 2, inside);
    if (inside) {
      fault_ = std::move(inside);
      return;
    }
    take_value(v, sign, t, 0);
  }

  void take_value(const Value& v, double sign, const Token& t, int depth) {
    NumberEntry e;
    e.begin = t.begin;
    e.length = e.number_length = t.length;
    e.expression = true;
    if (v.is_poison()) {
      e.poison = true;
      entries_.push_back(e);
    } else if (const Quantity* q = v.as_number()) {
      e.value = sign * q->value;
      e.dimension = q->dimension;
      e.bare = q->dimension.none();
      entries_.push_back(e);
    } else if (v.as_list() && depth < 2) {
      for (const Value& entry : *v.as_list()) take_value(entry, sign, t, depth + 1);
      unit_possible_ = !v.as_list()->empty();
      return;
    } else if (!fault_) {
      fault_ = make_fault("CG0502", t.begin, t.length, "expected a number, found " + describe(v),
                          v.as_text() ? nearly_number_help(*v.as_text()) : "");
    }
    unit_possible_ = true;
  }

  /// One unit at the end applies to all entries; otherwise every entry has a unit, or none.
  void share_unit() {
    if (!syntax_.list_unit || entries_.size() < 2) return;
    if (units_ == 1 && last_unit_ == entries_.size() - 1) {
      for (NumberEntry& e : entries_) {
        if (!e.bare || e.none) continue;
        e.value = unit_.to_si(e.value);
        e.dimension = unit_.dimension;
        e.bare = false;
      }
      return;
    }
    // An expression brings its dimension with it; only units that are written count here.
    const auto first = std::find_if(entries_.begin(), entries_.end(), [](const NumberEntry& e) {
      return e.bare && !e.none && !e.poison && e.value != 0.0;
    });
    if (units_ == 0 || first == entries_.end()) return;
    // Both forms, with the unit that is there.
    const std::string unit(unit_text_);
    std::string shared, each;
    bool own_dimensions = false;
    for (const NumberEntry& e : entries_) {
      const std::string word(text_.substr(e.begin, e.number_length));
      const bool own = e.expression && !e.bare && e.length == e.number_length;
      own_dimensions = own_dimensions || own;
      shared += word + " ";
      each += (each.empty() ? "" : " ") + word + (own || e.none ? "" : " " + unit);
    }
    fault_ = make_fault("CG0505", first->begin, first->length, "units on some entries only",
                        own_dimensions ? "write \"" + each + "\""
                                       : "write \"" + shared + unit + "\" or \"" + each + "\"");
  }

  std::string_view text_;
  const NumberSyntax& syntax_;
  const ExpressionEvaluator& evaluate_;
  std::optional<ExpressionFault>& fault_;
  std::vector<NumberEntry> entries_;
  bool unit_possible_ = false;
  int dots_ = 0;
  int units_ = 0;
  std::size_t last_unit_ = 0;
  Unit unit_;
  std::string_view unit_text_;
};

/// A common unit of a dimension, for suggestions.
std::string everyday_unit(const Dimension& d) {
  if (d == dim::kAngle) return "deg";
  return unit_of(d);
}

std::string_view after_blanks(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return text;
}

}  // namespace

std::size_t number_length(std::string_view text) {
  constexpr std::size_t kLongest = 64;  // each length is tried, and hostile files are long
  if (parse_number(text)) return text.size();
  std::size_t length = std::min(text.find_first_not_of("+-.0123456789eE"), text.size());
  if (length > kLongest) return 0;
  while (length > 0 && !parse_number(text.substr(0, length))) --length;
  return length;
}

std::string nearly_number_help(std::string_view text) {
  const auto suggest = [](const std::string& better) { return "did you mean \"" + better + "\"?"; };
  if (std::string help = braces_help(text, true); !help.empty()) return help;
  if (const std::string minus = plain_minus(text); minus != text)
    return "the minus sign is \"-\": write \"" + minus + "\"";
  if (const std::size_t comma = text.find(','); comma != std::string_view::npos) {
    std::string pointed(text);
    pointed[comma] = '.';
    const std::size_t digits = number_length(pointed);
    if (comma + 1 >= digits) return {};
    const std::string_view unit = after_blanks(std::string_view(pointed).substr(digits));
    if (!unit.empty() && !parse_unit(unit)) return {};
    return suggest(pointed.substr(0, digits) + (unit.empty() ? "" : " " + std::string(unit))) +
           " numbers have a decimal point";
  }
  const std::size_t digits = number_length(text);
  if (digits == 0 || digits == text.size()) return {};
  const std::string number(text.substr(0, digits));
  const std::string_view unit = after_blanks(text.substr(digits));
  // "1e400" begins with a number too, "1..2" as well.
  if (unit.empty() || std::string_view("+-.0123456789").find(unit[0]) != std::string_view::npos)
    return {};
  if (unit == "°") return suggest(number + " deg");
  if (parse_unit(unit)) return suggest(number + " " + std::string(unit));
  const std::string near = nearest_unit(unit);
  return near.empty() ? "" : suggest(number + " " + near);
}

std::string plain_minus(std::string_view text) {
  std::string out(text);
  for (const char* dash : {"\u2212", "\u2013", "\u2014", "\uFF0D"}) {
    for (std::size_t at = 0; (at = out.find(dash, at)) != std::string::npos; ++at)
      out.replace(at, 3, "-");
  }
  return out;
}

std::string braces_help(std::string_view text, bool number) {
  const auto in_name = [](char c) { return is_letter(c) || is_digit(c); };
  std::string out;
  bool changed = false;
  for (std::size_t i = 0; i < text.size();) {
    const bool dollar = text[i] == '$';
    std::size_t begin = i + dollar, end = begin;
    const char open = begin < text.size() ? text[begin] : '\0';
    if (open == '{' || (dollar && open == '(')) {
      end = text.find(open == '{' ? '}' : ')', ++begin);
      if (end == std::string_view::npos) return {};
    } else if (dollar) {
      while (end < text.size() && in_name(text[end])) ++end;
    }
    if (end == begin) {
      out += text[i++];
      continue;
    }
    const std::string_view name = text.substr(begin, end - begin);
    if (name.find_first_of("${(") != std::string_view::npos) return {};
    changed = changed || !dollar || open != '{';
    out += "${" + std::string(name) + "}";
    i = end + (open == '{' || open == '(');
  }
  if (!changed) return {};
  if (number && (out[0] != '$' || expression_end(out, 0) != out.size())) {
    if (out.find("}$") != std::string::npos) return {};
    out.erase(std::remove_if(out.begin(), out.end(),
                             [](char c) { return c == '$' || c == '{' || c == '}'; }),
              out.end());
    out = "${" + out + "}";
  }
  return "write " + out;
}

std::size_t expression_end(std::string_view text, std::size_t begin) {
  char quote = '\0';
  for (std::size_t i = begin + 2; i < text.size(); ++i) {
    const char c = text[i];
    if (quote) {
      if (c == quote) quote = '\0';
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '}') {
      return i + 1;
    }
  }
  return std::string_view::npos;
}

std::vector<NumberEntry> parse_numbers(std::string_view text, const NumberSyntax& syntax,
                                       const ExpressionEvaluator& evaluate,
                                       std::optional<ExpressionFault>& fault) {
  return ListParser(text, syntax, evaluate, fault).run();
}

std::optional<ExpressionFault> check_dimension(const NumberEntry& entry, const Dimension& wanted,
                                               std::string_view text) {
  if (entry.poison || entry.none) return std::nullopt;
  const std::string number(text.substr(entry.begin, entry.number_length));
  if (entry.bare) {
    if (wanted != dim::kAngle || entry.value == 0.0) return std::nullopt;
    return make_fault("CG0503", entry.begin, entry.length, "an angle needs its unit",
                      entry.expression ? "multiply by \"1 deg\" or \"1 rad\" inside of ${…}"
                                       : "write \"" + number + " deg\" or \"" + number + " rad\"");
  }
  if (fits(entry.dimension, wanted)) return std::nullopt;
  std::string help;
  if (entry.expression) {
    Dimension difference = wanted;
    difference.angle = entry.dimension.angle;
    if (difference == entry.dimension) {
      help = wanted.angle > entry.dimension.angle
                 ? "multiply by \"1 rad\" if it is meant per radian"
                 : "divide by \"1 rad\" if radians are meant";
    }
  } else if (wanted.none()) {
    help = "leave the unit out";
  } else {
    help = "did you mean \"" + number + " " + everyday_unit(wanted) + "\"?";
  }
  return make_fault("CG0502", entry.begin, entry.length,
                    "expected " + describe(wanted) + ", found " + describe(entry.dimension), help);
}

}  // namespace cogrsim::dsl
