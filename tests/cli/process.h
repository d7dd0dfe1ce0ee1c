// Runs the program as a user's shell would.
#pragma once

#include <string>
#include <vector>

/// How a program ended and what it said.
struct Outcome {
  int status = -1;  ///< exit status; 128 + n: killed by signal n
  std::string out, err;
};

/// Runs `cogrsim ARGS`, both streams piped. `interrupt_after` [s]: sends Ctrl-C then; 0: never.
Outcome cogrsim_run(const std::vector<std::string>& args, double interrupt_after = 0.0);

/// The same on a terminal of its own: `out` is all that appears there. `environment`: "NAME=value".
Outcome cogrsim_on_terminal(const std::vector<std::string>& args,
                            const std::vector<std::string>& environment = {});

/// A new empty folder, removed with all in it at the end of the scope.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  std::vector<std::string> files() const;

 private:
  std::string path_;
};

std::string read_file(const std::string& path);
