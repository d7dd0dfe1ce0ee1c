// Sets an environment variable, and restores it at the end of the scope.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace cogrsim::test {

class EnvironmentVariable {
 public:
  explicit EnvironmentVariable(const char* name) : name_(name) {
    if (const char* const value = std::getenv(name)) before_ = value;
  }
  EnvironmentVariable(const char* name, const std::string& value) : EnvironmentVariable(name) {
    ::setenv(name, value.c_str(), 1);
  }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;
  ~EnvironmentVariable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }

 private:
  const char* name_;
  std::optional<std::string> before_;
};

}  // namespace cogrsim::test
