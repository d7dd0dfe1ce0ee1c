// `cogrsim studio` as a user starts it, and a page that talks to it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

#include <nlohmann/json.hpp>

#include "server_client.h"

namespace cogrsim::studio::testing {

using Json = nlohmann::json;

/// The program, until its end. The variables of `environment` are set for it, the others are ours.
class StudioProcess {
 public:
  StudioProcess(const std::vector<std::string>& arguments,
                const std::map<std::string, std::string>& environment = {});
  ~StudioProcess();
  StudioProcess(const StudioProcess&) = delete;
  StudioProcess& operator=(const StudioProcess&) = delete;

  const std::string& address() const { return address_; }
  unsigned short port() const { return port_; }
  /// The operator's.
  std::string token() const;
  pid_t pid() const { return child_; }
  /// Sends SIGTERM (or SIGKILL) and waits; the exit status, or minus the signal.
  int end(bool kill = false);

 private:
  pid_t child_ = -1;
  int output_ = -1;
  std::string address_;
  unsigned short port_ = 0;
};

/// A page that takes in everything at once.
class LivePage {
 public:
  LivePage(unsigned short port, const std::string& token);
  explicit LivePage(const StudioProcess& studio) : LivePage(studio.port(), studio.token()) {}

  /// The answer, good or not.
  Json ask(const std::string& what, Json fields = Json::object());
  /// The answer, which must be good.
  Json get(const std::string& what, Json fields = Json::object());
  /// The newest message of that topic for which `holds` is true; the test fails after 30 s.
  Json wait(const std::string& topic, const std::function<bool(const Json&)>& holds);
  /// The next picture, head and all.
  std::string picture();

  Json hello;

 private:
  bool take();

  SocketClient socket_;
  int last_id_ = 0;
  std::map<int, Json> answers_;
  std::map<std::string, Json> topics_;
  std::vector<std::string> pictures_;
};

/// Runs `cogrsim` with these arguments; returns its standard output. The test fails if it fails.
std::string run_cogrsim(const std::vector<std::string>& arguments);

}  // namespace cogrsim::studio::testing
