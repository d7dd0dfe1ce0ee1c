// Which HTTP requests are accepted, and how they are answered: rules alone, no network.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "net/http.h"
#include "talk.h"

namespace cogrsim::studio {

using net::HttpAnswer, net::HttpRequest, net::host_refusal, net::refusal;

/// The subprotocol that a page's WebSocket requests, beside its token: see Gate.
constexpr std::string_view kSubprotocol = "cogrsim-studio";

/// Checks requests, in this order: Host, Origin, method, address, secret.
///
/// The page itself is no secret. Its token comes in the printed address behind the '#', which browsers
/// never send, and is shown in the opening of the WebSocket: Sec-WebSocket-Protocol has
/// kSubprotocol and the token. There are no cookies: they do not distinguish ports, so that every
/// server at the same address would be sent them. Textures have the secret in their addresses,
/// which the page receives over the WebSocket, as images can be requested in no other way.
class Gate final : public net::Gatekeeper {
 public:
  struct Secrets {
    std::string operator_token, viewer_token;
    std::string launch_token;  ///< leads to the operator's address, once; empty: none
    std::string asset_token;   ///< in the addresses of textures
  };
  /// `asset`: the file behind a number, see Inbox.
  Gate(Secrets secrets, unsigned short port, std::function<std::string(std::size_t)> asset);

  Decision decide(const HttpRequest& request) override;

 private:
  std::optional<Role> role_of(const std::vector<std::string_view>& protocols) const;
  HttpAnswer launch(std::string_view token, bool head);
  HttpAnswer page(std::string_view path, const HttpRequest& request);
  HttpAnswer asset(std::string_view path, const HttpRequest& request) const;

  Secrets secrets_;
  std::string port_;
  std::map<std::string_view, std::string> inflated_;  ///< files of the page, as they were asked for
  std::function<std::string(std::size_t)> asset_;
};

}  // namespace cogrsim::studio
