// Expectations on a run, and its measures.
#include <algorithm>
#include <cmath>

#include "build/build_scene.h"
#include "cogrsim/dsl/study.h"
#include "cogrsim/physics/backend_choice.h"
#include "cogrsim/signals/condition.h"
#include "cogrsim/testing/judge.h"

namespace cogrsim::dsl {
namespace {

constexpr std::uint64_t kMostSeeds = 10000;  // of one test

std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> words;
  std::size_t at = 0;
  while ((at = text.find_first_not_of(" \t\r\n,", at)) != std::string::npos) {
    const auto end = std::min(text.find_first_of(" \t\r\n,", at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

std::optional<ExpectationModel::Kind> kind_of_expectation(std::string_view tag) {
  using Line = ExpectationModel::Kind;
  for (const Line kind : {Line::expect, Line::always, Line::eventually, Line::agree})
    if (tag == cogrsim::to_string(kind)) return kind;
  return std::nullopt;
}

/// Of a signal; a plain number where its unit is not known.
Dimension dimension_of(const std::string& unit) {
  const auto known = parse_unit(unit);
  return known ? known->dimension : dim::kNone;
}

}  // namespace

void Builder::tests() {
  for_each(scene_, [&](const Element& element) {
    if (element.tag() == "test") test(element);
    if (element.tag() == "measure") measure(element);
  });
}

void Builder::test(const Element& element) {
  TestModel test;
  test.origin = element.span();
  Reader r = reader(element);
  const auto name = r.text("name");
  test.name = *name;
  if (name.given() && test.name.empty()) {
    fault("CG1107", element, "name", "the name of the test is empty");
  } else if (name.given() && !test_names_.insert(test.name).second) {
    fault("CG1107", element, "name", "there is a second test '" + test.name + "'");
  }
  const auto duration = r.number("duration");
  if (duration.given()) test.duration = *duration;
  test.backends = split_backend_choices(*r.text("backends"));
  for (std::size_t i = 1; i < test.backends.size(); ++i)
    if (std::find(test.backends.begin(), test.backends.begin() + static_cast<std::ptrdiff_t>(i),
                  test.backends[i]) != test.backends.begin() + static_cast<std::ptrdiff_t>(i))
      fault("CG1105", element, "backends", "'" + test.backends[i] + "' is named twice");
  const auto seeds = r.text("seeds");
  if (seeds.given()) {
    auto list = parse_seeds(*seeds);
    if (list && !spend(element, 32 * list->size())) return;
    if (list && list->size() <= kMostSeeds)
      test.seeds = std::move(*list);
    else
      fault("CG1106", element, "seeds", "'" + *seeds + "' is not a list of seeds")
          .help("write seeds=\"1 .. 5\" or seeds=\"1 3 7\", at most 10000");
  }
  // Duration of a run without an end of its own, see `cogrsim run`.
  constexpr double kUsual = 10.0;
  const double length = test.duration.value_or(model_.physics.duration.value_or(kUsual));
  const std::vector<std::string> added = names_in(*r.text("added"));
  bool any = false;
  for (const Element* child : element.children)
    if (kind_of_expectation(child->tag())) {
      any = true;
      expectation(*child, test, length, added);
    }
  if (!any)
    fault("CG1101", element, "this test has no expectation")
        .help("add one, for example <always that=\"abs(robot.roll) lt 10 deg\"/>");
  model_.tests.push_back(std::move(test));
}

void Builder::expectation(const Element& element, TestModel& test, double length,
                          const std::vector<std::string>& added) {
  using Line = ExpectationModel::Kind;
  ExpectationModel out;
  out.kind = *kind_of_expectation(element.tag());
  out.origin = element.span();
  Reader r = reader(element);
  const auto time = [&](std::string_view attribute, std::optional<double>& to) {
    const auto given = r.number(attribute);
    if (!given.given()) return;
    to = *given;
    if (*given > length * (1.0 + 1e-12))
      fault("CG1104", element, attribute,
            "this time is after the end of the test, " + number_text(length) + " s")
          .help("give the test a longer 'duration'");
  };
  if (out.kind == Line::expect) time("at", out.at);
  if (out.kind == Line::always || out.kind == Line::agree) time("until", out.until);
  if (out.kind == Line::eventually) time("within", out.within);

  const bool agree = out.kind == Line::agree;
  const bool equals = out.kind == Line::expect && r.has("equals");
  if (agree && test.backends.size() == 1)
    fault("CG1105", element,
          "<agree> compares several backends, but the test names only '" + test.backends[0] + "'")
        .help("name two or more in 'backends' of the test, or none to use all backends");
  if (out.kind == Line::expect && !equals && r.has("tolerance"))
    fault("CG1103", element, "tolerance", "'tolerance' needs 'equals'")
        .help(
            "write that=\"SIGNAL\" equals=\"VALUE\" tolerance=\"…\", or compare in the condition");

  const std::string_view attribute = agree ? "on" : "that";
  const auto text = r.text(attribute);
  if (!text.given()) return;
  std::string unit;
  const auto full = with_signals("CG1102", element, attribute, *text, added,
                                 [&](const SignalScope& scope) -> Result<std::string> {
                                   if (agree) {
                                     auto signals = parse_agreement(scope, *text);
                                     if (!signals) return tl::unexpected(signals.error());
                                     unit = signals->front().unit();
                                     if (signals->size() == 1) return signals->front().text();
                                     const std::string& x = signals->front().text();  // NAME.x
                                     return x.substr(0, x.size() - 1) + "position";
                                   }
                                   if (equals) {
                                     auto signal = Signal::parse(scope, *text);
                                     if (!signal) return tl::unexpected(signal.error());
                                     unit = signal->unit();
                                     return signal->text();
                                   }
                                   auto condition = Condition::parse(scope, *text);
                                   if (!condition) return tl::unexpected(condition.error());
                                   return condition->text();
                                 });
  if (!full) return;
  out.that = *full;
  if (equals) {
    const auto value = r.number("equals", dimension_of(unit));
    if (value.given()) out.equals = *value;
  }
  if (equals || agree) {
    const auto tolerance = r.number("tolerance", dimension_of(unit));
    out.tolerance = *tolerance;
    if (!tolerance.given() && !tolerance.failed() && equals)
      fault("CG1103", element, "equals",
            "'equals' needs a 'tolerance': computed numbers are seldom exactly equal")
          .help("add tolerance=\"…\", or tolerance=\"0\" for exact equality");
  }
  test.expectations.push_back(std::move(out));
}

void Builder::measure(const Element& element) {
  MeasureModel out;
  out.name = element.path;
  out.origin = element.span();
  Reader r = reader(element);
  const auto take = r.text("take");
  using Take = MeasureModel::Take;
  constexpr std::pair<const char*, Take> kTakes[] = {
      {"last", Take::last}, {"minimum", Take::minimum},   {"maximum", Take::maximum},
      {"mean", Take::mean}, {"integral", Take::integral}, {"first-time", Take::first_time}};
  for (const auto& [word, value] : kTakes)
    if (*take == word) out.take = value;
  const auto text = r.text("signal");
  if (!text.given() || take.failed()) return;
  const auto full = with_signals(
      "CG1102", element, "signal", *text, names_in(*r.text("added")),
      [&](const SignalScope& scope) -> Result<std::string> {
        if (out.take == Take::first_time)
          return Condition::parse(scope, *text).map([](const Condition& condition) {
            return condition.text();
          });
        return Signal::parse(scope, *text).map([](const Signal& signal) { return signal.text(); });
      });
  if (!full) return;
  out.signal = *full;
  model_.measures.push_back(std::move(out));
}

}  // namespace cogrsim::dsl
