#include "cogrsim/testing/judge.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace cogrsim {
namespace {

using Kind = ExpectationModel::Kind;

constexpr std::size_t kBefore = 3, kAfter = 2;  // samples shown around a failure
constexpr int kSamples = 100;                   // samples per run, which determines their spacing

std::string seconds(double time) { return fmt::format("{:.6g} s", time); }

std::string value_text(double value, const std::string& unit) {
  if (std::isnan(value)) return "no value";
  return unit.empty() || unit == "1" ? fmt::format("{:.6g}", value)
                                     : fmt::format("{:.6g} {}", value, unit);
}

std::string head(const std::string& text, const std::string& unit) {
  return unit.empty() || unit == "1" ? text : fmt::format("{} [{}]", text, unit);
}

std::string expectation_text(const ExpectationModel& e) {
  std::string text = fmt::format("{} {}", to_string(e.kind), e.that);
  if (e.equals) text += fmt::format(" equals {:.6g} within {:.6g}", *e.equals, e.tolerance);
  if (e.kind == Kind::agree) text += fmt::format(" within {:.6g}", e.tolerance);
  if (e.at) text += " at " + seconds(*e.at);
  if (e.until) text += " until " + seconds(*e.until);
  if (e.within) text += " within " + seconds(*e.within);
  return text;
}

/// Evaluation of one expectation.
struct Watch {
  ExpectationModel model;
  Condition condition;          // unused if there are `signals`
  std::vector<Signal> signals;  // compared with `equals`, or between runs
  std::vector<Signal> shown;    // signals in the table of the verdict
  Verdict verdict;
  bool decided = false;
  double spacing = 0.0;            // time between samples
  double next = 0.0, last = -1.0;  // time of the next sample; of the last frame
  std::deque<Verdict::Sample> before;
  std::size_t after = 0;  // number of samples still to be taken
  bool ever = false;      // the condition was known at least once

  bool complete() const { return decided && after == 0; }

  Verdict::Sample sample(const std::vector<FramePtr>& frames, bool decisive) const {
    Verdict::Sample out;
    out.time = frames.front()->time;
    out.decisive = decisive;
    for (const Signal& signal : shown)
      for (const FramePtr& frame : frames) out.values.push_back(signal.evaluate(*frame));
    return out;
  }

  void decide(bool passed, double time, std::string message) {
    decided = true;
    verdict.passed = passed;
    verdict.time = time;
    verdict.message = std::move(message);
  }

  void fail_here(const std::vector<FramePtr>& frames, std::string message) {
    decide(false, frames.front()->time, std::move(message));
    verdict.samples.assign(before.begin(), before.end());
    verdict.samples.push_back(sample(frames, true));
    after = kAfter;
    next = frames.front()->time + spacing;
  }

  void keep(const std::vector<FramePtr>& frames) {
    const double time = frames.front()->time;
    if (time < next - 0.5 * frames.front()->dt) return;
    next = time + spacing;
    if (decided) {
      if (after == 0) return;
      --after;
      verdict.samples.push_back(sample(frames, false));
    } else {
      before.push_back(sample(frames, false));
      if (before.size() > kBefore) before.pop_front();
    }
  }

  /// Value of the condition, or whether the signal is close enough to `equals`.
  Truth truth(const Frame& frame) const {
    if (!model.equals) return condition.evaluate(frame);
    const double value = signals[0].evaluate(frame);
    if (std::isnan(value)) return Truth::unknown;
    return std::abs(value - *model.equals) <= model.tolerance ? Truth::yes : Truth::no;
  }

  std::string why(const Frame& frame, const std::string& when) const {
    if (model.equals) {
      const double value = signals[0].evaluate(frame);
      if (std::isnan(value)) return fmt::format("{} has no value {}", signals[0].text(), when);
      const std::string& unit = signals[0].unit();
      return fmt::format("{} is {} {}, {} off", signals[0].text(), value_text(value, unit), when,
                         value_text(std::abs(value - *model.equals), unit));
    }
    if (truth(frame) == Truth::unknown)
      return fmt::format("is not known {}", when) + missing(frame);
    return fmt::format("does not hold {}", when);
  }

  std::string missing(const Frame& frame) const {
    for (const Signal& signal : shown)
      if (std::isnan(signal.evaluate(frame)))
        return fmt::format(": {} has no value", signal.text());
    return {};
  }
};

double norm_between(const std::vector<Signal>& signals, const Frame& a, const Frame& b) {
  double sum = 0.0;
  for (const Signal& signal : signals) {
    const double x = signal.evaluate(a), y = signal.evaluate(b);
    if (std::isnan(x) && std::isnan(y)) continue;  // missing in both
    if (std::isnan(x) || std::isnan(y)) return std::numeric_limits<double>::quiet_NaN();
    sum += (x - y) * (x - y);
  }
  return std::sqrt(sum);
}

}  // namespace

const char* to_string(ExpectationModel::Kind kind) {
  switch (kind) {
    case Kind::expect:
      return "expect";
    case Kind::always:
      return "always";
    case Kind::eventually:
      return "eventually";
    default:
      return "agree";
  }
}

Result<std::vector<Signal>> parse_agreement(const SignalScope& scope, const std::string& text) {
  auto one = Signal::parse(scope, text);
  if (one) return std::vector<Signal>{*one};
  const std::string ending = ".position";
  const auto last = text.find_last_not_of(" \t\r\n");
  const std::string base = last == std::string::npos ? text : text.substr(0, last + 1);
  if (base.size() > ending.size() &&
      base.compare(base.size() - ending.size(), ending.size(), ending) == 0) {
    const std::string pose = base.substr(0, base.size() - ending.size());
    std::vector<Signal> all;
    for (const char* axis : {".x", ".y", ".z"})
      if (auto signal = Signal::parse(scope, pose + axis)) all.push_back(std::move(*signal));
    if (all.size() == 3) return all;
  }
  return tl::unexpected(one.error());
}

struct TestJudge::Impl {
  std::vector<Watch> watches;
  std::vector<std::string> runs;
  double duration = 0.0;
  std::vector<FramePtr> last;

  void judge_agreement(Watch& watch, const std::vector<FramePtr>& frames) const {
    const Frame& first = *frames.front();
    if (watch.model.until && first.time > *watch.model.until + 0.5 * first.dt) {
      watch.ever ? watch.decide(true, first.time, "")
                 : watch.decide(false, first.time, "never had a value");
      return;
    }
    for (const Signal& signal : watch.signals)
      watch.ever = watch.ever || !std::isnan(signal.evaluate(first));
    for (std::size_t i = 1; i < frames.size(); ++i) {
      const double error = norm_between(watch.signals, first, *frames[i]);
      if (error <= watch.model.tolerance) continue;
      const std::string& unit = watch.signals[0].unit();
      watch.fail_here(
          frames, std::isnan(error)
                      ? fmt::format("{} and {} diverge at {}: one of them has no value", runs[0],
                                    runs[i], seconds(first.time))
                      : fmt::format("{} and {} diverge at {}: {} between them, {} allowed", runs[0],
                                    runs[i], seconds(first.time), value_text(error, unit),
                                    value_text(watch.model.tolerance, unit)));
      return;
    }
  }

  static void judge_run(Watch& watch, const FramePtr& frame) {
    const ExpectationModel& e = watch.model;
    const double half = 0.5 * frame->dt;
    switch (e.kind) {
      case Kind::expect:
        if (!e.at || frame->time < *e.at - half - 1e-12) return;
        if (watch.truth(*frame) == Truth::yes)
          watch.decide(true, frame->time, "");
        else
          watch.fail_here({frame}, watch.why(*frame, "at " + seconds(frame->time)));
        return;
      case Kind::always:
        if (e.until && frame->time > *e.until + half)
          watch.decide(true, frame->time, "");
        else if (watch.truth(*frame) != Truth::yes)
          watch.fail_here({frame}, watch.why(*frame, "at " + seconds(frame->time)));
        return;
      case Kind::eventually:
        if (e.within && frame->time > *e.within + half) {
          watch.fail_here({frame}, "never held up to " + seconds(*e.within));
        } else if (watch.truth(*frame) == Truth::yes) {
          watch.decide(true, frame->time, "");
        }
        return;
      default:
        return;
    }
  }
};

TestJudge::TestJudge(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TestJudge::~TestJudge() = default;
TestJudge::TestJudge(TestJudge&&) noexcept = default;
TestJudge& TestJudge::operator=(TestJudge&&) noexcept = default;

Result<TestJudge> TestJudge::create(const SignalScope& scope, const TestModel& test,
                                    double duration, std::vector<std::string> runs) {
  auto impl = std::make_unique<Impl>();
  impl->runs = std::move(runs);
  impl->duration = duration;
  for (const ExpectationModel& e : test.expectations) {
    const bool agree = e.kind == Kind::agree;
    if (agree != (impl->runs.size() > 1)) continue;
    Watch watch;
    watch.model = e;
    watch.spacing = duration / kSamples;
    watch.verdict.expectation = expectation_text(e);
    watch.verdict.origin = e.origin;
    const auto wrong = [&](const Error& error) {
      return fail(error.message, source_position(scope.model, e.origin), error.hint);
    };
    if (agree) {
      auto signals = parse_agreement(scope, e.that);
      if (!signals) return wrong(signals.error());
      watch.shown = watch.signals = std::move(*signals);
    } else if (e.equals) {
      auto signal = Signal::parse(scope, e.that);
      if (!signal) return wrong(signal.error());
      watch.shown = watch.signals = {*signal};
    } else {
      auto condition = Condition::parse(scope, e.that);
      if (!condition) return wrong(condition.error());
      watch.condition = *condition;
      watch.shown = condition->signals();
    }
    for (const Signal& signal : watch.shown)
      for (const std::string& run : impl->runs)
        watch.verdict.columns.push_back(
            head(agree ? fmt::format("{}: {}", run, signal.text()) : signal.text(), signal.unit()));
    impl->watches.push_back(std::move(watch));
  }
  return TestJudge(std::move(impl));
}

bool TestJudge::empty() const { return impl_->watches.empty(); }

FrameContents TestJudge::needs() const {
  FrameContents needs;
  for (const Watch& watch : impl_->watches) {
    needs = needs | watch.condition.needs();
    for (const Signal& signal : watch.signals) needs = needs | signal.needs();
  }
  return needs;
}

void TestJudge::see(const std::vector<FramePtr>& frames) {
  const double time = frames.front()->time;
  for (Watch& watch : impl_->watches) {
    // A restarted run is evaluated from its new start.
    if (time <= watch.last && !watch.decided) watch.before.clear(), watch.next = time;
    watch.last = time;
    if (watch.complete()) continue;
    const bool open = !watch.decided;
    if (open && watch.model.kind == Kind::agree)
      impl_->judge_agreement(watch, frames);
    else if (open)
      Impl::judge_run(watch, frames.front());
    if (watch.decided == !open) watch.keep(frames);
  }
  impl_->last = frames;
}

bool TestJudge::decided() const {
  return std::all_of(impl_->watches.begin(), impl_->watches.end(),
                     [](const Watch& watch) { return watch.complete(); });
}

std::vector<Verdict> TestJudge::finish(const std::string& early) {
  std::vector<Verdict> verdicts;
  const bool any = !impl_->last.empty();
  const double end = any ? impl_->last.front()->time : 0.0;
  const double half = any ? 0.5 * impl_->last.front()->dt : 0.0;
  for (Watch& watch : impl_->watches) {
    const ExpectationModel& e = watch.model;
    const auto beyond = [&](const std::optional<double>& limit) {
      return limit && *limit > end + half + 1e-12;
    };
    if (!watch.decided && !any) {
      watch.decide(false, 0.0, "the run has no frames");
    } else if (!watch.decided && !early.empty()) {
      watch.fail_here(impl_->last, fmt::format("the run ended at {}: {}", seconds(end), early));
    } else if (!watch.decided &&
               (beyond(e.at) || (e.kind != Kind::eventually && beyond(e.until)))) {
      watch.fail_here(impl_->last,
                      fmt::format("the run ended at {}, before it could be decided", seconds(end)));
    } else if (!watch.decided) {
      switch (e.kind) {
        case Kind::expect:
          if (watch.truth(*impl_->last.front()) == Truth::yes)
            watch.decide(true, end, "");
          else
            watch.fail_here(impl_->last,
                            watch.why(*impl_->last.front(), "at the end, " + seconds(end)));
          break;
        case Kind::always:
          watch.decide(true, end, "");
          break;
        case Kind::eventually:
          watch.fail_here(impl_->last,
                          fmt::format("never held, the run ended at {}", seconds(end)));
          break;
        default:
          watch.ever ? watch.decide(true, end, "") : watch.decide(false, end, "never had a value");
      }
    }
    verdicts.push_back(watch.verdict);
  }
  return verdicts;
}

std::string to_text(const Verdict& verdict, const SceneModel& model) {
  const std::string where = source_position(model, verdict.origin).position_text();
  std::string out = fmt::format("{}{}{}\n", where, where.empty() ? "" : ": ", verdict.expectation);
  if (verdict.passed) return out;
  out += "  " + verdict.message + "\n";
  if (verdict.samples.empty() || verdict.columns.empty()) return out;
  std::vector<std::size_t> widths;
  out += fmt::format("    {:>10}", "time [s]");
  for (const std::string& column : verdict.columns) {
    widths.push_back(std::max<std::size_t>(column.size(), 10));
    out += fmt::format("  {:>{}}", column, widths.back());
  }
  out += "\n";
  for (const Verdict::Sample& sample : verdict.samples) {
    out += fmt::format("  {} {:>10.6g}", sample.decisive ? ">" : " ", sample.time);
    for (std::size_t i = 0; i < sample.values.size(); ++i)
      out += std::isnan(sample.values[i]) ? fmt::format("  {:>{}}", "-", widths[i])
                                          : fmt::format("  {:>{}.6g}", sample.values[i], widths[i]);
    out += "\n";
  }
  return out;
}

}  // namespace cogrsim
