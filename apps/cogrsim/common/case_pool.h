// Runs of a study in processes of their own, several at a time.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "common/json_text.h"

namespace cogrsim::cli {

struct FinishedCase {
  std::size_t id = 0;
  Json result;  ///< see sweep_case_command(), or failed_result() of one that ended otherwise
};

/// Starts this same program as a child for every case. Children die with their parent.
class CasePool {
 public:
  struct Limits {
    int jobs = 1;
    double timeout = 0.0;            ///< of a case, in wall-clock time [s]; 0: none
    std::uint64_t memory_limit = 0;  ///< of a case's address space [byte]; 0: none
  };
  explicit CasePool(const Limits& limits) : limits_(limits) {}
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

 private:
  struct Child {
    std::size_t id = 0;
    pid_t pid = -1;
    int result = -1, errors = -1;  // ends of pipes
    std::string result_text, error_text;
    std::chrono::steady_clock::time_point start;
    bool timed_out = false;
  };
  void drain(Child& child) const;
  Json outcome(const Child& child, int status) const;

  Limits limits_;
  std::vector<Child> children_;
};

}  // namespace cogrsim::cli
