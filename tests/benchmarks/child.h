// A program that answers lines by lines of JSON, run as a child process.
#pragma once

#include <sys/types.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cogrsim::bench {

class Child {
 public:
  /// Starts `command`; its standard error is dropped.
  explicit Child(const std::vector<std::string>& command);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void say(const std::string& line);
  /// The next line of it, as JSON; empty when it has ended, says something else, or when
  /// `seconds` have passed. Only in the last case is running() still true.
  std::optional<nlohmann::json> hear(double seconds);
  bool running() const { return pid_ > 0 && !ended_; }

 private:
  pid_t pid_ = -1;
  int to_ = -1, from_ = -1;
  bool ended_ = false;
  std::string heard_;
};

}  // namespace cogrsim::bench
