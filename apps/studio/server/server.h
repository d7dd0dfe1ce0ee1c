// The studio's server: that of the program, and the tokens that let browsers in.
#pragma once

#include <memory>
#include <string>

#include "http.h"
#include "net/server.h"
#include "talk.h"

namespace cogrsim::studio {

struct ServerOptions : net::ServerOptions {
  ServerOptions() { acknowledgements = true; }
  std::string tokens;       ///< folder to keep tokens in, see kept_tokens(); empty: always new ones
  bool new_tokens = false;  ///< leave those that are kept, keep new ones
};

class Server final : public net::Server {
 public:
  /// As that of the program. Errors: also, the system has no randomness to give.
  static Result<std::unique_ptr<Server>> listen(const ServerOptions& options);

  /// "http://127.0.0.1:40213/#token=…", for operators, or for viewers.
  std::string address(Role role) const;
  /// Leads to the operator's, once: for a browser whose command line other users may read.
  std::string launch_address() const;
  /// "/asset/…/": the address before the numbers of textures.
  std::string assets() const;

  void run(Inbox& inbox);

 private:
  explicit Server(std::shared_ptr<Impl> impl) : net::Server(std::move(impl)) {}
  Result<> make_secrets(bool new_tokens);

  Gate::Secrets secrets_;
  std::string tokens_;  // the folder
};

}  // namespace cogrsim::studio
