// Requests over HTTP: verified, bounded in size and time, tried again where that can help.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim::share {

/// How far a transfer is; `total` is 0 while it is not known [byte].
using TransferProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

struct HttpOptions {
  std::string user, password;  ///< sent with every request
  bool netrc = false;          ///< without `user`: the entry of the host in ~/.netrc
  std::string sigv4;           ///< "aws:amz:REGION:s3": `user` and `password` sign instead
  long connect_timeout = 15;   ///< [s]
  long stall_timeout = 60;     ///< given up after so long without a byte [s]
  int attempts = 4;            ///< in all
  double first_pause = 0.5;    ///< before the second attempt [s]; doubles from then on
};

struct HttpRequest {
  std::string method = "GET", url;
  std::vector<std::string> headers;  ///< "Name: value"
  std::string body;
  std::string body_file;  ///< instead of `body`, of any size
  bool has_body = false;
  std::string to_file;               ///< a good answer goes there instead of into memory
  std::uint64_t limit = 4ull << 20;  ///< longest answer [byte]
};

struct HttpAnswer {
  long status = 0;
  std::string body;
  std::map<std::string, std::string> headers;  ///< names in small letters
};

/// Connections are kept between requests. Not for several threads.
class Http {
 public:
  explicit Http(HttpOptions options);
  ~Http();
  Http(const Http&) = delete;
  Http& operator=(const Http&) = delete;

  /// Observes the progress of large transfers; empty: none.
  void on_progress(TransferProgress progress);
  /// Called often during a request; true ends it.
  void on_cancel(std::function<bool()> cancelled);

  /// An answer, be its status good or bad. 429, 500, 502, 503 and 504, a connection that is refused
  /// or breaks off are tried again, with growing pauses, as "Retry-After" says if that is not long.
  /// Redirections are not followed: a password would be sent to another server.
  /// Errors: no answer, with the cause; one that is longer than `limit`.
  Result<HttpAnswer> run(const HttpRequest& request);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// RFC 3986: all but letters, digits and "-._~" as %XX; "/" stays if `keep_slashes`.
std::string percent_encoded(const std::string& text, bool keep_slashes = false);
/// Empty for text that is not well encoded.
std::string percent_decoded(const std::string& text);

}  // namespace cogrsim::share
