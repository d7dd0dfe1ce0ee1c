#include "net/http.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace cogrsim::net {
namespace {

// Scripts, pictures and connections of this server alone. The editor, the docking panels and the big
// charts set styles on elements, which needs 'unsafe-inline' for styles.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self'; worker-src 'self' blob:; font-src 'self'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

const char* reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 303:
      return "See Other";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 413:
      return "Content Too Large";
    case 426:
      return "Upgrade Required";
    case 431:
      return "Request Header Fields Too Large";
    case 503:
      return "Service Unavailable";
    default:
      return "Error";
  }
}

}  // namespace

bool same_word(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(a[i])) !=
        std::tolower(static_cast<unsigned char>(b[i]))) {
      return false;
    }
  }
  return true;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

std::string HttpAnswer::head(bool keep_alive) const {
  std::string out = fmt::format("HTTP/1.1 {} {}\r\n", status, reason_of(status));
  const auto add = [&](std::string_view name, std::string_view value) {
    out.append(name).append(": ").append(value).append("\r\n");
  };
  for (const auto& [name, value] : headers) add(name, value);
  if (status != 304) add("Content-Length", std::to_string(std::max(body.size(), lasting.size())));
  add("Connection", keep_alive ? "keep-alive" : "close");
  add("Content-Security-Policy", kContentPolicy);
  add("X-Content-Type-Options", "nosniff");
  add("Referrer-Policy", "no-referrer");
  add("Cross-Origin-Opener-Policy", "same-origin");
  add("Cross-Origin-Resource-Policy", "same-origin");
  out += "\r\n";
  return out;
}

std::string_view HttpAnswer::content() const {
  if (!with_body || status == 304) return {};
  return lasting.empty() ? std::string_view(body) : lasting;
}

HttpAnswer refusal(int status, std::string text) {
  HttpAnswer answer;
  answer.status = status;
  answer.headers = {{"Content-Type", "text/plain; charset=utf-8"}, {"Cache-Control", "no-store"}};
  answer.body = std::move(text) + "\n";
  return answer;
}

std::pair<std::string_view, std::string_view> host_and_port(std::string_view host) {
  const auto colon = host.rfind(':');
  if (colon == std::string_view::npos || host.find(']', colon) != std::string_view::npos)
    return {host, "80"};
  return {host.substr(0, colon), host.substr(colon + 1)};
}

bool is_own_name(std::string_view name) {
  return same_word(name, "localhost") || name == "127.0.0.1" || name == "[::1]";
}

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.rfind("127.", 0) == 0;
}

bool known_host(std::string_view host, std::string_view local_address, std::string_view port) {
  const auto [name, named_port] = host_and_port(host);
  if (named_port != port) return false;
  return is_own_name(name) || (!local_address.empty() && same_word(name, local_address));
}

std::optional<HttpAnswer> host_refusal(const HttpRequest& request, std::string_view port) {
  if (!request.one_host || request.host.empty()) {
    return refusal(400, "A request needs one Host header.");
  }
  if (!known_host(request.host, request.local_address, port)) {
    return refusal(403,
                   "This server has another name. Open the address that was printed in "
                   "the terminal.");
  }
  return std::nullopt;
}

}  // namespace cogrsim::net
