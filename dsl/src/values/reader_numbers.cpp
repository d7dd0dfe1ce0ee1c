// Readers of numbers, lists, ranges, poses and plugins' parameters.
#include <algorithm>
#include <cassert>
#include <cmath>

#include "cogrsim/core/roll_pitch_yaw.h"
#include "report/diagnostics.h"
#include "values/attribute_text.h"
#include "values/reader_detail.h"

namespace cogrsim::dsl {
namespace {

using detail::spec_of;
using detail::text_of;

/// Text of a bound with the unit of its dimension: "0.5 m/s".
std::string bound_text(double value, const Dimension& dimension) {
  const std::string unit = unit_of(dimension);
  return number_text(value) + (unit.empty() || value == 0.0 ? "" : " " + unit);
}

/// An entry as it was written; of an expression, its value.
std::string found_text(const NumberEntry& entry, const Dimension& wanted,
                       const AttributeText& source) {
  return entry.expression ? bound_text(entry.value, wanted)
                          : std::string(source.text().substr(entry.begin, entry.length));
}

/// What a bound forbids, or "".
std::string beyond(double value, const AttributeSpec& spec, const Dimension& dimension) {
  if (spec.above_minimum ? value <= spec.minimum : value < spec.minimum) {
    return std::string(spec.above_minimum ? "must be above " : "must be at least ") +
           bound_text(spec.minimum, dimension);
  }
  if (value > spec.maximum) return "must be at most " + bound_text(spec.maximum, dimension);
  return {};
}

/// The vocabulary's default; it holds no expressions.
std::vector<double> default_numbers(const AttributeSpec& spec, std::size_t count) {
  std::vector<double> out;
  if (!spec.default_text.empty()) {
    std::optional<ExpressionFault> fault;
    const auto none = [](std::string_view, std::size_t, std::optional<ExpressionFault>&) {
      return Value::poison();
    };
    for (const NumberEntry& e : parse_numbers(spec.default_text, {}, none, fault)) {
      out.push_back(e.value);
    }
    assert(!fault && "the vocabulary's defaults can be read");
  }
  out.resize(std::max(out.size(), count), 0.0);
  return out;
}

std::string count_text(int least, int most) {
  if (least == most) return std::to_string(most) + (most == 1 ? " entry" : " entries");
  if (most >= 65536) return "at least " + std::to_string(least) + " entries";
  return std::to_string(least) + " to " + std::to_string(most) + " entries";
}

/// Checks dimensions and bounds of entries; the first fault is reported and ends it.
bool check_entries(AttributeText& source, const AttributeSpec& spec,
                   const std::vector<NumberEntry>& entries,
                   const std::vector<Dimension>& dimensions) {
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const NumberEntry& e = entries[i];
    const Dimension& wanted = dimensions[std::min(i, dimensions.size() - 1)];
    if (e.poison) return false;
    if (e.none) {
      if (spec.none_allowed) continue;
      source.report("CG0501", e.begin, e.length, "\"none\" is not a number here");
      return false;
    }
    if (const auto fault = check_dimension(e, wanted, source.text())) {
      source.report(*fault);
      return false;
    }
    const std::string problem = beyond(e.value, spec, wanted);
    if (!problem.empty()) {
      source.report("CG0507", e.begin, e.length,
                    "\"" + std::string(spec.name) + "\" " + problem + ", found " +
                        found_text(e, wanted, source));
      return false;
    }
  }
  return true;
}

/// Unlimited: below for a lower limit, above for everything else.
double unlimited(const AttributeSpec& spec) {
  const double infinity = std::numeric_limits<double>::infinity();
  return spec.name == "lower" ? -infinity : infinity;
}

Read<std::vector<double>> read_list(CompileContext& context, const Element& element,
                                    const AttributeSpec& spec,
                                    const std::vector<Dimension>& dimensions, int least, int most) {
  Read<std::vector<double>> out;
  const bool optional_count = spec.default_text.empty();
  out.value = default_numbers(spec, optional_count ? static_cast<std::size_t>(least) : 0);
  const Attribute* a = element.find(spec.name);
  if (!a) return out;
  out.state = Read<std::vector<double>>::State::failed;
  AttributeText source = text_of(context, element, *a);
  const bool mixed = std::any_of(dimensions.begin(), dimensions.end(),
                                 [&](const Dimension& d) { return d != dimensions[0]; });
  NumberSyntax syntax;
  syntax.list_unit = !mixed;
  const auto entries = source.numbers(syntax);
  if (!entries) return out;
  const auto count = static_cast<int>(entries->size());
  if (count < least || count > most) {
    std::string help;
    if (count == 1 && least == most && most <= 3 && !(*entries)[0].expression && !mixed) {
      const NumberEntry& e = (*entries)[0];
      const std::string_view whole = source.text().substr(e.begin, e.length);
      const std::string word(whole.substr(0, e.number_length));
      const std::string unit(whole.substr(e.number_length));
      // A size of one figure is a cube; one figure for a vector is meant to be along z.
      if (spec.name == "size") {
        help = "write \"" + word;
        for (int i = 1; i < most; ++i) help += " " + word;
        help += unit + "\" if all are the same";
      } else if (most == 3 && spec.minimum < 0.0) {
        const bool down = spec.name == "gravity" && word[0] != '-';
        help = "write \"0 0 " + std::string(down ? "-" : "") + word + unit + "\" for " +
               (spec.name == "rpy" ? "a turn about z"
                : down             ? "straight down"
                                   : "along z");
      }
    }
    source.report("CG0506", 0, source.text().size(),
                  "\"" + std::string(spec.name) + "\" takes " + count_text(least, most) +
                      ", found " + std::to_string(count),
                  help);
    return out;
  }
  if (!check_entries(source, spec, *entries, dimensions)) return out;
  out.value.clear();
  for (const NumberEntry& e : *entries) out.value.push_back(e.none ? unlimited(spec) : e.value);
  out.state = Read<std::vector<double>>::State::given;
  return out;
}

}  // namespace

Read<double> Reader::number(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::number && spec.dimensions.size() == 1);
  return number(attribute, spec.dimensions[0]);
}

Read<double> Reader::number(std::string_view attribute, const Dimension& dimension) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::number);
  const auto list = read_list(context_, element_, spec, {dimension}, 1, 1);
  Read<double> out;
  out.value = list.value.empty() ? 0.0 : list.value[0];
  out.state = static_cast<Read<double>::State>(list.state);
  return out;
}

Read<std::vector<double>> Reader::numbers(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::numbers);
  return read_list(context_, element_, spec, spec.dimensions, spec.min_count, spec.max_count);
}

Read<std::vector<double>> Reader::numbers(std::string_view attribute,
                                          const std::vector<Dimension>& dimensions) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert((spec.kind == Kind::numbers || spec.kind == Kind::number) && !dimensions.empty());
  const auto count = static_cast<int>(dimensions.size());
  return read_list(context_, element_, spec, dimensions, count, count);
}

Read<Vec3> Reader::vec3(std::string_view attribute) {
  assert(spec_of(element_, attribute).max_count == 3);
  const auto list = numbers(attribute);
  Read<Vec3> out;
  out.value = Vec3::Zero();
  for (int i = 0; i < 3 && i < static_cast<int>(list.value.size()); ++i) {
    out.value[i] = list.value[i];
  }
  out.state = static_cast<Read<Vec3>::State>(list.state);
  return out;
}

Read<Interval> Reader::range(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::range);
  Read<Interval> out;
  const Attribute* a = element_.find(attribute);
  if (!a) return out;
  out.state = Read<Interval>::State::failed;
  AttributeText source = text_of(context_, element_, *a);
  NumberSyntax syntax;
  syntax.dots = true;
  const auto entries = source.numbers(syntax);
  if (!entries || !check_entries(source, spec, *entries, spec.dimensions)) return out;
  out.value = {(*entries)[0].value, (*entries)[1].value};
  if (out.value.low >= out.value.high) {
    source.report("CG0507", 0, source.text().size(),
                  "the first end of the range must be below the second");
    return out;
  }
  out.state = Read<Interval>::State::given;
  return out;
}

Read<std::int64_t> Reader::integer(std::string_view attribute) {
  const AttributeSpec& spec = spec_of(element_, attribute);
  assert(spec.kind == Kind::integer);
  const auto list = read_list(context_, element_, spec, {dim::kNone}, 1, 1);
  Read<std::int64_t> out;
  out.state = static_cast<Read<std::int64_t>::State>(list.state);
  const double value = list.value.empty() ? 0.0 : list.value[0];
  if (list.given() && (value != std::floor(value) || std::abs(value) > 9007199254740992.0)) {
    context_.sink.report(
        "CG0516", element_, attribute,
        "\"" + std::string(attribute) + "\" must be a whole number, found " + number_text(value));
    out.state = Read<std::int64_t>::State::failed;
    return out;
  }
  out.value = static_cast<std::int64_t>(value);
  return out;
}

Read<Pose> Reader::pose() {
  Read<Pose> out;
  using State = Read<Pose>::State;
  const auto xyz = vec3("xyz");
  const auto rpy = vec3("rpy");
  const auto quat = numbers("quat");
  if (xyz.given() || rpy.given() || quat.given()) out.state = State::given;
  if (xyz.failed() || rpy.failed() || quat.failed()) {
    out.state = State::failed;
    return out;
  }
  out.value.p = xyz.value;
  if (has("rpy") && has("quat")) {
    context_.sink.report("CG0602", element_, "quat", "the orientation is given twice")
        .help("keep rpy or quat");
    out.state = State::failed;
    return out;
  }
  if (quat.given()) {
    const Quat q(quat.value[0], quat.value[1], quat.value[2], quat.value[3]);
    if (!std::isfinite(q.norm())) {
      context_.sink
          .report("CG0603", element_, "quat", "the quaternion exceeds the range of numbers")
          .help("only its direction matters: divide it by the largest of the four entries");
      out.state = State::failed;
      return out;
    }
    if (q.norm() < 1e-9) {
      context_.sink.report("CG0603", element_, "quat", "the quaternion has zero length")
          .help("without rotation it is \"1 0 0 0\"");
      out.state = State::failed;
      return out;
    }
    out.value.q = q.normalized();
  } else if (rpy.given()) {
    out.value.q = from_rpy(rpy.value);
  }
  return out;
}

namespace {

/// What a parameter's bounds or choices forbid, or "".
std::string forbidden(double value, const ParameterSpec& spec, const Dimension& dimension) {
  if (value < spec.minimum) return "must be at least " + bound_text(spec.minimum, dimension);
  if (value > spec.maximum) return "must be at most " + bound_text(spec.maximum, dimension);
  return {};
}

}  // namespace

Read<ParameterValue> Reader::parameter(const Attribute& attribute, const ParameterSpec& spec) {
  Read<ParameterValue> out;
  using State = Read<ParameterValue>::State;
  out.value = spec.default_value;
  out.state = State::failed;
  AttributeText source = text_of(context_, element_, attribute);
  const std::size_t whole = source.text().size();
  const auto refuse = [&](const std::string& problem, const std::string& help = {}) {
    source.report("CG0904", 0, whole, "\"" + spec.name + "\" " + problem, help);
    return out;
  };
  switch (spec.type()) {
    case ParameterType::boolean: {
      const Value v = source.any();
      if (v.is_poison()) return out;
      if (!v.as_boolean()) return refuse("is true or false, found " + to_text(v));
      out.value = *v.as_boolean();
      break;
    }
    case ParameterType::text: {
      auto text = source.interpolate();
      if (!text) return out;
      if (!spec.choices.empty() &&
          std::find(spec.choices.begin(), spec.choices.end(), *text) == spec.choices.end()) {
        std::string all;
        for (const std::string& c : spec.choices) all += (all.empty() ? "" : ", ") + c;
        const std::string near = nearest_name(*text, spec.choices);
        return refuse("is one of " + all + ", found \"" + *text + "\"",
                      near.empty() ? "" : "did you mean \"" + near + "\"?");
      }
      out.value = std::move(*text);
      break;
    }
    case ParameterType::integer:
    case ParameterType::number:
    case ParameterType::number_list: {
      Dimension dimension;
      if (const auto unit = parse_unit(spec.unit)) dimension = unit->dimension;
      const bool list = spec.type() == ParameterType::number_list;
      NumberSyntax syntax;
      syntax.commas = list;
      const auto entries = source.numbers(syntax);
      if (!entries) return out;
      if (!list && entries->size() != 1) {
        return refuse("takes one number, found " + std::to_string(entries->size()));
      }
      std::vector<double> values;
      for (const NumberEntry& e : *entries) {
        if (e.poison) return out;
        if (e.none) return refuse("takes numbers, found \"none\"");
        if (const auto fault = check_dimension(e, dimension, source.text())) {
          source.report(*fault);
          return out;
        }
        const std::string problem = forbidden(e.value, spec, dimension);
        if (!problem.empty()) {
          return refuse(problem + ", found " + found_text(e, dimension, source));
        }
        values.push_back(e.value);
      }
      if (list) {
        out.value = std::move(values);
      } else if (spec.type() == ParameterType::number) {
        out.value = values[0];
      } else if (values[0] != std::floor(values[0]) || std::abs(values[0]) > 9007199254740992.0) {
        return refuse("is a whole number, found " + number_text(values[0]));
      } else {
        out.value = static_cast<std::int64_t>(values[0]);
      }
      break;
    }
  }
  out.state = State::given;
  return out;
}

}  // namespace cogrsim::dsl
