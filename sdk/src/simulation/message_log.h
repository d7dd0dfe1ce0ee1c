// The messages of a run.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "simulation/clock.h"

namespace cogrsim {

class MessageLog {
 public:
  /// `clock` gives the times of the messages and must outlive this object.
  explicit MessageLog(const Clock& clock) : clock_(clock) {}

  /// Stores a message. The number is limited, because a controller may report in every update.
  void report(Severity severity, const std::string& source, const std::string& message) {
    if (messages_.size() > kMost) return;
    if (messages_.size() == kMost) {
      messages_.push_back(
          {clock_.time(), Severity::warning, "run", "further messages are not stored"});
      return;
    }
    messages_.push_back({clock_.time(), severity, source, message});
  }
  const std::vector<RunMessage>& messages() const { return messages_; }
  void clear() { messages_.clear(); }

 private:
  static constexpr std::size_t kMost = 1000;

  const Clock& clock_;
  std::vector<RunMessage> messages_;
};

}  // namespace cogrsim
