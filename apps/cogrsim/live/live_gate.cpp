#include "live/live_gate.h"

#include <algorithm>

namespace cogrsim::cli {
namespace {

// Of the protocol and of its successor with the same messages; clients prefer the first they offer.
constexpr std::string_view kSubprotocols[] = {"foxglove.sdk.v1", "foxglove.websocket.v1"};

// Foxglove's page, and its program for desktops, whose pages are files. Pages of this machine are as
// trusted as its programs.
constexpr std::string_view kOrigins[] = {"https://app.foxglove.dev", "file://"};

}  // namespace

bool LiveGate::known_origin(std::string_view origin) const {
  const auto is = [&](std::string_view known) { return net::same_word(known, origin); };
  if (origin.empty() || std::any_of(std::begin(kOrigins), std::end(kOrigins), is) ||
      std::any_of(origins_.begin(), origins_.end(), is)) {
    return true;
  }
  const auto scheme = origin.find("://");
  if (scheme == std::string_view::npos) return false;
  return net::is_own_name(net::host_and_port(origin.substr(scheme + 3)).first);
}

net::Gatekeeper::Decision LiveGate::decide(const net::HttpRequest& request) {
  const auto with = [&](net::HttpAnswer answer) {
    answer.with_body = request.method != "HEAD";
    return Decision{std::move(answer), std::nullopt, {}};
  };
  if (auto refused = net::host_refusal(request, port_)) return with(std::move(*refused));
  if (!known_origin(request.origin)) {
    return with(net::refusal(403, "Pages of '" + std::string(request.origin.substr(0, 200)) +
                                      "' may not steer this run. Allow them by --live-origin."));
  }
  if (request.method != "GET" || !request.upgrade) {
    net::HttpAnswer answer = net::refusal(
        426, "Here is a WebSocket: connect with Foxglove, or another client of its protocol.");
    answer.headers.emplace_back("Upgrade", "websocket");
    return with(std::move(answer));
  }
  Decision decision;
  for (const std::string_view header : request.protocols) {
    net::any_part(header, ',', [&](std::string_view item) {
      if (decision.upgrade || std::find(std::begin(kSubprotocols), std::end(kSubprotocols), item) ==
                                  std::end(kSubprotocols)) {
        return false;
      }
      decision.upgrade = net::Role::operator_;
      decision.subprotocol = item;
      return true;
    });
  }
  if (decision.upgrade) return decision;
  return with(
      net::refusal(400, "The subprotocol has to be foxglove.websocket.v1 or foxglove.sdk.v1."));
}

}  // namespace cogrsim::cli
