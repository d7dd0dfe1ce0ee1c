// Judges a run, or several at once, by the expectations of a `<test>`.
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

/// What `agree` compares: a signal, or PLACE.position, which is its x, y and z.
COGRSIM_API Result<std::vector<Signal>> parse_agreement(const SignalScope& scope,
                                                        const std::string& text);

/// What became of one expectation.
struct Verdict {
  /// Values of the signals at one time.
  struct Sample {
    double time = 0.0;           ///< [s]
    std::vector<double> values;  ///< as `columns`; NaN: none
    bool decisive = false;       ///< the frame that decided
  };
  bool passed = false;
  std::string expectation;  ///< "always abs(bot.roll) lt 10 deg"
  std::string message;      ///< what went wrong: "does not hold at 1.25 s"; empty when passed
  double time = 0.0;        ///< at which it was decided [s]
  std::vector<std::string> columns;  ///< signals with their units: "bot.roll [rad]"
  std::vector<Sample> samples;       ///< of a failure, around its time
  SourceSpan origin;
};

/// Watches runs of one scene, for one test. expect, always and eventually are judged where one run
/// is watched, agree where several are: what is not judged has no verdict.
///
/// A condition that is unknown (see condition.h) does not hold. A run that ends by itself ends the
/// test: `expect` without `at` holds at that end, `always` until then; what lies beyond it fails.
class COGRSIM_API TestJudge {
 public:
  /// `runs` names the runs (backends) watched, at least one; `duration`: how long they are meant to
  /// last [s]. Errors: an expectation that does not parse, `where` says which.
  static Result<TestJudge> create(const SignalScope& scope, const TestModel& test, double duration,
                                  std::vector<std::string> runs);
  ~TestJudge();
  TestJudge(TestJudge&&) noexcept;
  TestJudge& operator=(TestJudge&&) noexcept;

  /// Whether there is anything to judge.
  bool empty() const;
  /// What frames must contain.
  FrameContents needs() const;
  /// One frame of every run, of the same step, from the start on.
  void see(const std::vector<FramePtr>& frames);
  void see(const FramePtr& frame) { see(std::vector<FramePtr>{frame}); }
  /// Everything is decided: going on changes nothing.
  bool decided() const;
  /// After the last frame. `early`: why a run ended before its time ("diverged"); empty: it did
  /// not, or ended by its own will. Verdicts in the order of the test.
  std::vector<Verdict> finish(const std::string& early = {});

 private:
  struct Impl;
  explicit TestJudge(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// "maze.scene.xml:27:5: always abs(bot.roll) lt 10 deg\n  does not hold at 1.25 s\n" and a small
/// table of the values around.
COGRSIM_API std::string to_text(const Verdict& verdict, const SceneModel& model);

}  // namespace cogrsim
