// Values of a study: lists and ranges.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "cogrsim/dsl/study.h"
#include "values/number_list.h"
#include "values/value.h"

namespace cogrsim::dsl {
namespace {

constexpr std::size_t kMostValues = 100000;  // of one parameter
constexpr std::size_t kMostSeeds = 1000000;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// At commas outside brackets.
std::vector<std::string_view> entries_of(std::string_view text) {
  std::vector<std::string_view> out;
  std::size_t begin = 0;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '[' || c == '(' || c == '{') ++depth;
    if (c == ']' || c == ')' || c == '}') --depth;
    if (c != ',' || depth > 0) continue;
    out.push_back(trimmed(text.substr(begin, i - begin)));
    begin = i + 1;
  }
  out.push_back(trimmed(text.substr(begin)));
  return out;
}

/// "1 3 7", "1 .. 5, 9" with commas for the blanks that separate entries: "1,3,7", "1..5,9".
std::string with_commas(std::string_view text) {
  const auto joins = [](std::string_view end) {
    return end.front() == ',' || end.substr(0, 2) == "..";
  };
  std::string out;
  std::istringstream words{std::string(text)};
  for (std::string word; words >> word; out += word) {
    const bool joined = out.empty() || joins(word) || out.back() == ',' || out.back() == '.';
    if (!joined) out += ',';
  }
  return out;
}

struct Number {
  double value = 0.0;     // as written
  std::string_view unit;  // as written, may be empty
  Unit to_si;
  bool whole = false;  // written without point and exponent
};

/// "3cm", "3 cm", "-2e-3"; nullopt: no number with a known unit.
std::optional<Number> number_of(std::string_view text) {
  const std::size_t length = number_length(text);
  if (length == 0) return std::nullopt;
  Number number;
  number.value = *parse_number(text.substr(0, length));
  number.whole = text.substr(0, length).find_first_of(".eE") == std::string_view::npos;
  number.unit = trimmed(text.substr(length));
  if (!number.unit.empty()) {
    const auto unit = parse_unit(number.unit);
    if (!unit) return std::nullopt;
    number.to_si = *unit;
  }
  return number;
}

StudyValue value_of(std::string_view text) {
  StudyValue out;
  out.text = std::string(text);
  out.number = std::numeric_limits<double>::quiet_NaN();
  if (const auto number = number_of(text)) {
    out.number = number->to_si.to_si(number->value);
    out.unit = unit_of(number->to_si.dimension);
    // As scenes write it, so that tables show one spelling.
    if (!number->unit.empty()) {
      const auto digits = static_cast<std::size_t>(number->unit.data() - text.data());
      out.text = std::string(trimmed(text.substr(0, digits))) + " " + std::string(number->unit);
    }
  }
  return out;
}

Result<> spread(std::string_view entry, std::size_t dots, std::vector<StudyValue>& out) {
  const std::string shown(entry);
  std::string_view rest = entry.substr(dots + 2);
  std::string_view count_text;
  bool by_ratio = false;
  if (const auto colon = rest.find(':'); colon != std::string_view::npos) {
    count_text = trimmed(rest.substr(colon + 1));
    rest = trimmed(rest.substr(0, colon));
    if (const auto second = count_text.find(':'); second != std::string_view::npos) {
      if (trimmed(count_text.substr(second + 1)) != "log")
        return fail("range '" + shown + "': only 'log' is allowed after the count", "",
                    "write 1..100:3:log");
      by_ratio = true;
      count_text = trimmed(count_text.substr(0, second));
    }
  }
  const auto first = number_of(trimmed(entry.substr(0, dots)));
  const auto last = number_of(trimmed(rest));
  if (!first || !last)
    return fail("range '" + shown + "': '" +
                    std::string(trimmed(first ? rest : entry.substr(0, dots))) +
                    "' is not a number with a known unit",
                "", "a range is written 3cm..5cm:5");
  if (first->to_si.dimension != last->to_si.dimension)
    return fail("range '" + shown + "' goes from " + describe(first->to_si.dimension) + " to " +
                    describe(last->to_si.dimension),
                "", "give both ends the unit: 3cm..5cm:5");
  const bool whole = first->whole && last->whole && first->unit.empty() && last->unit.empty();
  std::size_t count = 0;
  if (count_text.empty()) {
    if (!whole || by_ratio)
      return fail("range '" + shown + "' does not say how many values", "",
                  "write the number behind it: " + shown + ":5");
    if (last->value < first->value)
      return fail("range '" + shown + "' ends before it begins", "", "write the smaller one first");
    if (last->value - first->value >= static_cast<double>(kMostValues))
      return fail("range '" + shown + "' has more than " + std::to_string(kMostValues) + " values");
    for (double v = first->value; v <= last->value; v += 1.0)
      out.push_back(value_of(number_text(v)));
    return {};
  }
  const auto [end, wrong] =
      std::from_chars(count_text.data(), count_text.data() + count_text.size(), count);
  if (wrong != std::errc{} || end != count_text.data() + count_text.size() || count < 2 ||
      count > kMostValues)
    return fail("range '" + shown + "': '" + std::string(count_text) +
                    "' is not a number of values from 2 to " + std::to_string(kMostValues),
                "", "a range is written 3cm..5cm:5");
  // In the unit as written where both ends have the same, so that values are what one expects to
  // read: 3.5 cm, not 0.035 m.
  const bool same_unit = first->unit == last->unit;
  const double low = same_unit ? first->value : first->to_si.to_si(first->value);
  const double high = same_unit ? last->value : last->to_si.to_si(last->value);
  const std::string unit = same_unit ? std::string(first->unit) : unit_of(first->to_si.dimension);
  if (low == high) return fail("range '" + shown + "': both ends are the same");
  if (by_ratio && !(low * high > 0.0))
    return fail("range '" + shown + "' contains 0, which a logarithmic range cannot", "",
                "give both ends the same sign, or leave out ':log'");
  for (std::size_t i = 0; i < count; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    double value = by_ratio ? low * std::pow(high / low, part) : low + part * (high - low);
    if (i == 0) value = low;
    if (i + 1 == count) value = high;
    // Twelve digits: 3.5 and not 3.5000000000000004.
    if (i != 0 && i + 1 != count) {
      char digits[40];
      std::snprintf(digits, sizeof digits, "%.12g", value);
      value = *parse_number(digits);
    }
    out.push_back(value_of(number_text(value) + (unit.empty() ? "" : " " + unit)));
  }
  return {};
}

}  // namespace

Result<std::vector<StudyValue>> parse_study_values(std::string_view text) {
  if (trimmed(text).empty())
    return fail("there are no values", "", "write a list (3cm,4cm) or a range (3cm..5cm:5)");
  std::vector<StudyValue> out;
  for (const std::string_view entry : entries_of(text)) {
    if (entry.empty())
      return fail("there is an empty value in '" + std::string(text) + "'", "",
                  "delete the superfluous comma");
    const auto dots = entry.find("..");
    // "../mesh.obj" is text: a range begins with its first end.
    if (dots != std::string_view::npos && dots > 0) {
      if (auto good = spread(entry, dots, out); !good) return tl::unexpected(good.error());
    } else {
      out.push_back(value_of(entry));
    }
    if (out.size() > kMostValues)
      return fail("there are more than " + std::to_string(kMostValues) + " values");
  }
  std::set<std::pair<std::string, double>> known;
  for (const StudyValue& value : out) {
    // 30 mm and 3 cm are the same value.
    const auto key = std::isnan(value.number) ? std::make_pair(value.text, 0.0)
                                              : std::make_pair("#" + value.unit, value.number);
    if (!known.insert(key).second) return fail("the value '" + value.text + "' is given twice");
  }
  return out;
}

Result<std::vector<std::uint64_t>> parse_seeds(std::string_view text) {
  const auto one = [](std::string_view word) -> std::optional<std::uint64_t> {
    std::uint64_t seed = 0;
    const auto [end, wrong] = std::from_chars(word.data(), word.data() + word.size(), seed);
    if (wrong != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return seed;
  };
  std::vector<std::uint64_t> out;
  std::map<std::uint64_t, std::uint64_t> known;  // ranges so far, from first to last
  const std::string list = with_commas(text);
  for (const std::string_view entry : entries_of(list)) {
    const auto dots = entry.find("..");
    const auto first = one(trimmed(entry.substr(0, dots)));
    const auto last = dots == std::string_view::npos ? first : one(trimmed(entry.substr(dots + 2)));
    if (!first || !last)
      return fail("'" + std::string(entry) + "' is neither a seed nor a range of seeds", "",
                  "write whole numbers from 0 on: 7 or 1..100 or 1..10,20");
    if (*last < *first)
      return fail("the seeds '" + std::string(entry) + "' end before they begin", "",
                  "write the smaller one first");
    if (*last - *first >= kMostSeeds || out.size() + (*last - *first) >= kMostSeeds)
      return fail("there are more than " + std::to_string(kMostSeeds) + " seeds");
    const auto next = known.upper_bound(*first);
    const bool begun = next != known.begin() && std::prev(next)->second >= *first;
    if (begun || (next != known.end() && next->first <= *last)) {
      return fail("the seed " + std::to_string(begun ? *first : next->first) + " is given twice");
    }
    known.emplace(*first, *last);
    for (std::uint64_t seed = *first;; ++seed) {
      out.push_back(seed);
      if (seed == *last) break;
    }
  }
  return out;
}

std::optional<MeasureModel::Take> parse_take(std::string_view text) {
  using Take = MeasureModel::Take;
  if (text == "last") return Take::last;
  if (text == "min" || text == "minimum") return Take::minimum;
  if (text == "max" || text == "maximum") return Take::maximum;
  if (text == "mean") return Take::mean;
  if (text == "integral") return Take::integral;
  if (text == "first" || text == "first-time") return Take::first_time;
  return std::nullopt;
}

const char* to_text(MeasureModel::Take take) {
  using Take = MeasureModel::Take;
  switch (take) {
    case Take::last:
      return "last";
    case Take::minimum:
      return "minimum";
    case Take::maximum:
      return "maximum";
    case Take::mean:
      return "mean";
    case Take::integral:
      return "integral";
    case Take::first_time:
      return "first-time";
  }
  return "last";
}

}  // namespace cogrsim::dsl
