// The committed table of known results of each backend.
#pragma once

#include <map>
#include <string>

#include "record.h"

namespace conformance {

struct Expectation {
  Status status = Status::pass;
  std::string reason;                     ///< of an expected failure, written by hand
  std::map<std::string, double> reached;  ///< figures beyond their limits, by label
  std::string note;                       ///< what is unsupported, as the backend reports it
};

/// Figures of an expected failure may grow by this factor before they count as a change: tolerance
/// for another compiler or library version, not for a regression.
inline constexpr double kReachedSlack = 1.25;

/// Figure label under which failed assertions that measure nothing are counted.
inline constexpr const char* kAssertions = "failed assertions";

class ExpectationTable {
 public:
  /// A missing file is an empty table. Throws std::runtime_error naming the file and the fault.
  static ExpectationTable load(const std::string& path);
  void save(const std::string& path, const std::string& title) const;

  /// Empty when the outcome is what the table says; else what differs.
  std::string compare(const std::string& test, const Outcome& outcome) const;

  /// Stores the status and the figures; a reason stays while the test keeps failing.
  void update(const std::string& test, const Outcome& outcome);

  const Expectation* find(const std::string& test) const;
  std::map<std::string, Expectation>& entries() { return entries_; }
  const std::map<std::string, Expectation>& entries() const { return entries_; }

 private:
  std::map<std::string, Expectation> entries_;
};

/// Figures beyond their limits, and kAssertions with their number where there were others.
std::map<std::string, double> reached_figures(const Outcome& outcome);

}  // namespace conformance
