// Requests and answers of HTTP as the server of this program sees them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "net/talk.h"

namespace cogrsim::net {

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
  std::string_view lasting;  ///< instead of `body`: bytes that live as long as the gatekeeper
  bool with_body = true;     ///< false: only its length is sent (HEAD)

  /// Status line and headers as they go over the wire, with those that every answer has.
  std::string head(bool keep_alive) const;
  /// The body.
  std::string_view content() const;
};

/// A plain text with the reason of a refusal.
HttpAnswer refusal(int status, std::string text);

/// Decides about every request, on the thread of the network.
class Gatekeeper {
 public:
  virtual ~Gatekeeper() = default;
  /// An answer, or the role and the subprotocol in which the WebSocket may be opened.
  struct Decision {
    HttpAnswer answer;
    std::optional<Role> upgrade;
    std::string subprotocol;
  };
  virtual Decision decide(const HttpRequest& request) = 0;
};

/// Whether a Host header names this machine, and `port`. A name that an attacker's DNS server gives
/// out may lead here (DNS rebinding): only addresses that are this machine's, and the name that
/// never leaves it, are known.
bool known_host(std::string_view host, std::string_view local_address, std::string_view port);
/// The refusal of a request whose Host header is missing, there twice, or not known.
std::optional<HttpAnswer> host_refusal(const HttpRequest& request, std::string_view port);

/// Host and port of "name:port" or "[address]:port"; without a port "80".
std::pair<std::string_view, std::string_view> host_and_port(std::string_view host);
/// The names by which only this machine calls itself.
bool is_own_name(std::string_view name);
/// Whether only this machine reaches an address to listen at.
bool is_loopback(const std::string& host);

/// Equal but for the case of ASCII letters.
bool same_word(std::string_view a, std::string_view b);
std::string_view trimmed(std::string_view text);

/// Calls `visit` for each part between separators, trimmed, until it returns true.
template <class Visit>
bool any_part(std::string_view list, char separator, const Visit& visit) {
  while (true) {
    const auto end = list.find(separator);
    if (visit(trimmed(list.substr(0, end)))) return true;
    if (end == std::string_view::npos) return false;
    list.remove_prefix(end + 1);
  }
}

}  // namespace cogrsim::net
