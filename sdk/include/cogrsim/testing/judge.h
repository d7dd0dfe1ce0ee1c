// Evaluation of the expectations of a `<test>` on one or several runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/signals/condition.h"
#include "cogrsim/signals/signal.h"

namespace cogrsim {

/// "expect", "always", "eventually", "agree".
COGRSIM_API const char* to_string(ExpectationModel::Kind kind);

/// Parses the argument of `agree`: a signal, or POSE.position for its x, y and z. Errors: as
/// Signal::parse().
COGRSIM_API Result<std::vector<Signal>> parse_agreement(const SignalScope& scope,
                                                        const std::string& text);

/// Result of one expectation.
struct Verdict {
  /// Values of the signals at one time.
  struct Sample {
    double time = 0.0;           ///< [s]
    std::vector<double> values;  ///< in the order of `columns`; NaN: no value
    bool decisive = false;       ///< the frame that decided the result
  };
  bool passed = false;
  std::string expectation;  ///< "always abs(bot.roll) lt 10 deg"
  std::string message;      ///< the failure: "does not hold at 1.25 s"; empty if passed
  double time = 0.0;        ///< time at which the result was decided [s]
  std::vector<std::string> columns;  ///< signals with their units: "bot.roll [rad]"
  std::vector<Sample> samples;       ///< samples around the time of a failure
  SourceSpan origin;
};

/// Evaluates one test on runs of a scene. The expectations expect, always and eventually are
/// evaluated for a single run, and agree for several runs; the other expectations have no verdict.
/// Not thread-safe.
///
/// An unknown condition (see condition.h) does not hold. If a run ends by itself, the test ends,
/// too: `expect` without `at` must hold at that time and `always` until then; expectations about
/// later times fail.
class COGRSIM_API TestJudge {
 public:
  /// `runs` has the names of the runs (backends), at least one; `duration` is their intended
  /// duration [s]. Errors: an expectation cannot be parsed; Error::where is its source location.
  static Result<TestJudge> create(const SignalScope& scope, const TestModel& test, double duration,
                                  std::vector<std::string> runs);
  ~TestJudge();
  TestJudge(TestJudge&&) noexcept;
  TestJudge& operator=(TestJudge&&) noexcept;

  /// Whether the test has no expectations to evaluate.
  bool empty() const;
  /// The frame contents that see() needs.
  FrameContents needs() const;
  /// Processes the frames of one step, one per run. Must be called for every step, including the
  /// start.
  void see(const std::vector<FramePtr>& frames);
  void see(const FramePtr& frame) { see(std::vector<FramePtr>{frame}); }
  /// Whether all results are decided, so that further frames change nothing.
  bool decided() const;
  /// Returns the verdicts in the order of the test; call it after the last frame. `early` is the
  /// reason for which a run failed early ("diverged"); empty: no run failed.
  std::vector<Verdict> finish(const std::string& early = {});

 private:
  struct Impl;
  explicit TestJudge(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A verdict as text, "maze.scene.xml:27:5: always abs(bot.roll) lt 10 deg\n  does not hold at
/// 1.25 s\n", followed by a small table of the values around that time.
COGRSIM_API std::string to_text(const Verdict& verdict, const SceneModel& model);

}  // namespace cogrsim
