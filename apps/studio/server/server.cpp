#include "server.h"

#include <vector>

#include <fmt/format.h>

#include "cogrsim/core/shown_text.h"
#include "kept_tokens.h"
#include "token.h"

namespace cogrsim::studio {

Result<> Server::make_secrets(bool new_tokens) {
  std::vector<std::string*> wanted = {&secrets_.launch_token, &secrets_.asset_token};
  Result<KeptTokens> kept = fail("not asked for");
  if (!tokens_.empty()) {
    Result<> ready = new_tokens ? forget_tokens(tokens_, endpoint_name()) : Result<>();
    kept = ready ? kept_tokens(tokens_, endpoint_name())
                 : tl::unexpected<Error>(std::move(ready.error()));
    if (!kept) {
      fmt::print(stderr, "warning: pages will not find the studio again after a restart: {}\n",
                 paragraph(kept.error().text()));
      tokens_.clear();
    }
  }
  if (kept) {
    secrets_.operator_token = kept->operator_token;
    secrets_.viewer_token = kept->viewer_token;
  } else {
    wanted.push_back(&secrets_.operator_token);
    wanted.push_back(&secrets_.viewer_token);
  }
  for (std::string* token : wanted) {
    auto made = new_token();
    if (!made) return tl::unexpected<Error>(made.error());
    *token = std::move(*made);
  }
  return {};
}

Result<std::unique_ptr<Server>> Server::listen(const ServerOptions& options) {
  auto opened = open(options);
  if (!opened) return tl::unexpected(opened.error());
  std::unique_ptr<Server> server(new Server(std::move(*opened)));
  server->tokens_ = options.tokens;
  if (auto made = server->make_secrets(options.new_tokens); !made) {
    return tl::unexpected<Error>(made.error());
  }
  return server;
}

std::string Server::address(Role role) const {
  return net::Server::address(
      "#token=" + (role == Role::operator_ ? secrets_.operator_token : secrets_.viewer_token));
}

std::string Server::launch_address() const {
  return net::Server::address("?launch=" + secrets_.launch_token);
}

std::string Server::assets() const { return "/asset/" + secrets_.asset_token + "/"; }

void Server::run(Inbox& inbox) {
  Gate gate(secrets_, port(), [&inbox](std::size_t number) { return inbox.asset(number); });
  net::Server::run(inbox, gate);
  if (!tokens_.empty()) keep_tokens(tokens_, endpoint_name());
}

}  // namespace cogrsim::studio
