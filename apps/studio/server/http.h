// Who may come in by HTTP, and what they are given: rules alone, no network.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

/// What of a request's head counts here. Empty: not there.
struct HttpRequest {
  std::string_view method, target, host, origin, accept_encoding, if_none_match;
  std::vector<std::string_view> cookies;  ///< the values of all Cookie headers
  bool one_host = true;                   ///< exactly one Host header
  bool upgrade = false;                   ///< it asks for a WebSocket
  std::string_view local_address;         ///< that the connection came in at: "127.0.0.1", "[::1]"
};

struct HttpAnswer {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  bool with_body = true;  ///< false: its length alone is told (HEAD)

  /// Status line, headers and body as they go over the wire, with the headers that every answer has.
  std::string text(bool keep_alive) const;
};

/// A plain text with the reason of a refusal.
HttpAnswer refusal(int status, std::string text);

/// "Refused by what it says", in this order: its Host, its Origin, its method, its secret, its address.
class Gate {
 public:
  struct Secrets {
    std::string operator_token, viewer_token;
    std::string launch_token;  ///< the operator's for one visit; empty: none
  };
  /// `asset`: the file behind a number, see Inbox.
  Gate(Secrets secrets, unsigned short port, std::function<std::string(std::size_t)> asset);

  /// An answer, or the role in which the WebSocket may be opened.
  struct Decision {
    HttpAnswer answer;
    std::optional<Role> upgrade;
  };
  Decision decide(const HttpRequest& request);

  /// "cogrsim_studio_40213": cookies do not tell ports apart.
  const std::string& cookie_name() const { return cookie_name_; }

 private:
  bool known_host(std::string_view host, std::string_view local_address) const;
  std::optional<Role> role_of(std::string_view token) const;
  std::optional<Role> role_of(const std::vector<std::string_view>& cookies) const;
  HttpAnswer take_token(std::string_view query, bool head);
  HttpAnswer page(std::string_view path, const HttpRequest& request) const;
  HttpAnswer asset(std::string_view number, const HttpRequest& request) const;

  Secrets secrets_;
  std::string port_, cookie_name_;
  std::function<std::string(std::size_t)> asset_;
};

}  // namespace cogrsim::studio
