// Which HTTP requests are accepted, and how they are answered: rules alone, no network.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

/// The parts of a request's head that are used here. Empty: not there.
struct HttpRequest {
  std::string_view method, target, host, origin, accept_encoding, if_none_match;
  std::vector<std::string_view> protocols;  ///< the values of all Sec-WebSocket-Protocol headers
  bool one_host = true;                     ///< exactly one Host header
  bool upgrade = false;                     ///< it asks for a WebSocket
  std::string_view local_address;  ///< that the connection came in at: "127.0.0.1", "[::1]"
};

struct HttpAnswer {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  std::string_view lasting;  ///< instead of `body`: bytes that live as long as the gate
  bool with_body = true;     ///< false: only its length is sent (HEAD)

  /// Status line and headers as they go over the wire, with those that every answer has.
  std::string head(bool keep_alive) const;
  /// The body.
  std::string_view content() const;
};

/// A plain text with the reason of a refusal.
HttpAnswer refusal(int status, std::string text);

/// The subprotocol that a page's WebSocket requests, beside its token: see Gate.
constexpr std::string_view kSubprotocol = "cogrsim-studio";

/// Checks requests, in this order: Host, Origin, method, address, secret.
///
/// The page itself is no secret. Its token comes in the printed address behind the '#', which browsers
/// never send, and is shown in the opening of the WebSocket: Sec-WebSocket-Protocol has
/// kSubprotocol and the token. There are no cookies: they do not distinguish ports, so that every
/// server at the same address would be sent them. Textures have the secret in their addresses,
/// which the page receives over the WebSocket, as images can be requested in no other way.
class Gate {
 public:
  struct Secrets {
    std::string operator_token, viewer_token;
    std::string launch_token;  ///< leads to the operator's address, once; empty: none
    std::string asset_token;   ///< in the addresses of textures
  };
  /// `asset`: the file behind a number, see Inbox.
  Gate(Secrets secrets, unsigned short port, std::function<std::string(std::size_t)> asset);

  /// An answer, or the role in which the WebSocket may be opened.
  struct Decision {
    HttpAnswer answer;
    std::optional<Role> upgrade;
  };
  Decision decide(const HttpRequest& request);

 private:
  bool known_host(std::string_view host, std::string_view local_address) const;
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
