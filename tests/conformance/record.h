// Results of a test case for a backend: its status and the figures it measured.
#pragma once

#include <ctime>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace conformance {

/// A measured figure and its limit.
struct Figure {
  std::string label;  ///< with its unit
  double value = 0.0;
  double limit = 0.0;                             ///< infinity: observed only
  bool within() const { return value <= limit; }  // false for NaN
};

enum class Status { pass, fail, unsupported };

/// "pass", "expected-failure", "unsupported": as the table writes a status.
const char* to_string(Status status);

struct Outcome {
  Status status = Status::pass;
  std::string note;                   ///< unsupported: what the backend lacks
  std::vector<Figure> figures;        ///< one per label: the worst seen
  std::vector<std::string> failures;  ///< of assertions that were not figures
  std::clock_t start = std::clock();
  double most_seconds = std::numeric_limits<double>::infinity();  ///< see give_up_after()
  bool given_up = false;
};

/// The outcome of the test case that runs now.
Outcome& current();

/// Thrown to leave a test case that the backend cannot run; not a failure.
struct Unsupported : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Marks the running test case unsupported and leaves it.
[[noreturn]] void leave_unsupported(const std::string& note);

/// Records a figure; of several with one label the worst is kept.
void note_figure(const std::string& label, double value, double limit);

/// A test case that is made by a loop, not by TEST_CASE.
struct GeneratedTest {
  std::string name;
  std::string tags;
  std::function<void()> run;
};

}  // namespace conformance
