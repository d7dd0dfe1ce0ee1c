// Which clients of --live may open a WebSocket.
#pragma once

#include <string>
#include <vector>

#include "net/http.h"

namespace cogrsim::cli {

/// There is no secret: viewers can be given none. So a page of a stranger that is open in a browser
/// of this machine must not connect: its Origin is none of those known. Programs send none.
class LiveGate final : public net::Gatekeeper {
 public:
  LiveGate(unsigned short port, std::vector<std::string> origins)
      : port_(std::to_string(port)), origins_(std::move(origins)) {}
  Decision decide(const net::HttpRequest& request) override;

 private:
  bool known_origin(std::string_view origin) const;

  std::string port_;
  std::vector<std::string> origins_;
};

}  // namespace cogrsim::cli
