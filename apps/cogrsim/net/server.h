// HTTP and WebSocket: access, answers and messages, without ever waiting for a client.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "net/http.h"
#include "net/talk.h"

namespace cogrsim::net {

struct ServerOptions {
  std::string host = "127.0.0.1";          ///< an address of this machine, or "localhost"
  unsigned short port = 0;                 ///< 0: one of `preferred`, or any that is free
  std::vector<unsigned short> preferred;   ///< the first that is free
  std::string goodbye;                     ///< a text for all when the server ends; empty: none
  std::string ending = "the server ends";  ///< the reason with which WebSockets are closed then
  /// The texts "a" and "p" acknowledge a frame and a picture.
  bool acknowledgements = false;
  struct Limits {
    std::size_t message_bytes = 8u << 20;  ///< of one text from a page
    /// The same of a viewer: the long ones are edits, and reading them takes time.
    std::size_t viewer_message_bytes = 256u << 10;
    std::size_t clients = 32;  ///< WebSockets at a time
    std::size_t viewers = 24;  ///< of these: the others are for operators
    /// TCP at a time. Beyond, the connection that has been silent or has read an answer for the
    /// longest time is closed for the next one. WebSockets stay.
    std::size_t connections = 128;
    std::size_t of_one_address = 64;        ///< of these, WebSockets not counted
    double messages_per_second = 400.0;     ///< of one client, on average; bursts of twice as many
    double idle_seconds = 60.0;             ///< without an answer to a ping
    double request_seconds = 10.0;          ///< for the request's head and body
    std::size_t waiting_bytes = 32u << 20;  ///< texts that one client has not taken in
    std::size_t stream_bytes = 8u << 20;    ///< of the stream, likewise: the oldest are dropped
  } limits;
};

class Server : public Outbox {
 public:
  /// Listens; answers once run() is called. Errors: no such address, the port is taken.
  static Result<std::unique_ptr<Server>> listen(const ServerOptions& options);
  ~Server() override;

  /// "http://127.0.0.1:40213/" and `rest`. Of all addresses of the machine, the one for itself.
  std::string address(const std::string& rest, const char* scheme = "http") const;
  unsigned short port() const;
  /// The address that it listens at, and the port: a name for what belongs to it.
  std::string endpoint_name() const;
  std::size_t client_count() const;

  /// Serves until stop(), on the calling thread; once. Later messages are dropped.
  void run(Inbox& inbox, Gatekeeper& gate);
  /// From any thread or a signal handler, also before run(): clients are sent the goodbye and have a
  /// second to read their waiting messages.
  void stop() noexcept;

  void send(ClientId client, std::string text) override;
  void send_all(std::string text) override;
  void offer_frame(ClientId client, Bytes frame) override;
  void offer_picture(ClientId client, const std::string& key, Bytes picture) override;
  bool wants_picture(ClientId client) const override;

  /// One more binary message, `head` and then `body`, behind those that wait. Returns how many of
  /// the oldest were dropped for it, because the client reads too slowly. `keep`: this one is never
  /// dropped; where too many of these wait the client is cut off, as with texts. From any thread.
  std::size_t stream(ClientId client, std::string head, Bytes body, bool keep = false);

 protected:
  struct Impl;
  friend class WebClient;
  friend class Connection;
  explicit Server(std::shared_ptr<Impl> impl);
  static Result<std::shared_ptr<Impl>> open(const ServerOptions& options);

 private:
  std::shared_ptr<Impl> impl_;
  int stop_event_;  ///< written to by stop()
};

}  // namespace cogrsim::net
