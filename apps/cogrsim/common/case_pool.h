// Cases of a sweep or a test in processes of their own, several at a time.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "common/json_text.h"

namespace cogrsim::cli {

/// In the child: what it shall run, from its standard input; discarded if that is not JSON.
Json case_input();
/// In the child: hands its result to the parent. Plugins may print to the standard output, so that a
/// descriptor of its own is for that. False: the parent does not read it.
bool write_case_result(const Json& result);

/// How a child ended.
struct CaseEnd {
  int status = 0;  ///< as waitpid() gives it
  bool timed_out = false;
  Json result;             ///< as it wrote it; discarded if it did not, or not as JSON
  std::string error_text;  ///< the end of its standard error
};

struct FinishedCase {
  std::size_t id = 0;
  Json result;             ///< as the pool's `outcome` gave it
  double wall_time = 0.0;  ///< [s]
};

/// Starts this same program as a child for every case. Children die with their parent.
class CasePool {
 public:
  struct Limits {
    int jobs = 1;
    double timeout = 0.0;            ///< of a case, in wall-clock time [s]; 0: none
    std::uint64_t memory_limit = 0;  ///< of a case's address space [byte]; 0: none
  };
  using Outcome = std::function<Json(CaseEnd, const Limits&)>;
  /// `command`: the hidden subcommand that the children are; `outcome`: result of one that ended.
  CasePool(const char* command, const Limits& limits, Outcome outcome)
      : command_(command), limits_(limits), outcome_(std::move(outcome)) {}
  ~CasePool();
  CasePool(const CasePool&) = delete;
  CasePool& operator=(const CasePool&) = delete;

  bool has_free_slot() const { return running() < limits_.jobs; }
  int running() const { return static_cast<int>(children_.size()); }
  int jobs() const { return limits_.jobs; }

  /// Errors: no process can be started.
  Result<> start(std::size_t id, const Json& input);
  /// The finished cases; waits up to `milliseconds` for the first.
  std::vector<FinishedCase> wait(int milliseconds);
  /// Asks all to end, and waits up to `grace` [s] for them. What they still do is not used.
  void end(double grace);

 private:
  struct Child {
    std::size_t id = 0;
    pid_t pid = -1;
    int result = -1, errors = -1;  // ends of pipes
    std::string result_text, error_text;
    std::chrono::steady_clock::time_point start;
    bool timed_out = false;
  };
  static void drain(Child& child);

  const char* command_;
  Limits limits_;
  Outcome outcome_;
  std::vector<Child> children_;
};

/// Runs `count` cases, each as `input` gives it, and gives `take` each when it ends. False: a process could
/// not be started. Where the command is interrupted, the rest is not run.
bool run_cases(CasePool& pool, std::size_t count, const std::function<Json(std::size_t)>& input,
               const std::function<void(FinishedCase&)>& take);

}  // namespace cogrsim::cli
