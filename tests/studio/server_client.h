// A client that speaks HTTP and WebSocket byte by byte, well or badly, and a server for it.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/server.h"

namespace cogrsim::studio {

/// A port for servers that start and end at the same one: it is not taken in between, as the system
/// does not give it out by itself, and tests that run beside this one have others.
unsigned short own_port();

/// A TCP connection; nothing waits for longer than a minute.
class RawClient {
 public:
  /// `from`: the address it comes from; empty: the system's choice.
  explicit RawClient(unsigned short port, const std::string& from = {});
  ~RawClient();
  RawClient(RawClient&& other) noexcept;
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// False: the other side does not take it in any more.
  bool send(std::string_view bytes);
  /// At least one byte more; false: the other side has closed.
  bool receive();
  /// Everything until the other side closes.
  std::string rest();
  void close();

  std::string taken;  ///< received and not yet used

 private:
  int socket_;
};

struct HttpReply {
  int status = 0;                              ///< 0: closed without an answer
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;
  const std::string& header(const std::string& name) const;
};

/// Reads one answer. `with_body`: false after HEAD.
HttpReply read_reply(RawClient& client, bool with_body = true);

/// A WebSocket over a RawClient.
class SocketClient {
 public:
  /// The status of the answer to the upgrade: 101 when it was opened.
  SocketClient(unsigned short port, const std::string& token, const std::string& origin = {});
  int status() const { return answer_.status; }
  const HttpReply& answer() const { return answer_; }

  struct Message {
    int opcode = 0;  ///< 1: text, 2: binary, 8: close, 9: ping
    std::string payload;
  };
  bool send(const std::string& text, int opcode = 1);
  /// Empty: the other side has closed without a message. Answers no pings.
  std::optional<Message> receive();
  /// The next of that kind, others left out.
  std::optional<Message> receive(int opcode);
  void close() { client_.close(); }
  RawClient& raw() { return client_; }

 private:
  RawClient client_;
  HttpReply answer_;
};

/// What the network has received.
class FakeInbox final : public Inbox {
 public:
  void joined(ClientId client, Role role) override;
  void left(ClientId client) override;
  void received(ClientId client, std::string text) override;
  std::string asset(std::size_t number) override;

  /// Each waits until so many there were.
  std::vector<std::pair<ClientId, Role>> wait_joined(std::size_t count);
  std::vector<ClientId> wait_left(std::size_t count);
  std::vector<std::string> wait_received(std::size_t count);

  std::string asset_file;  ///< of number 0
  std::function<void(ClientId, const std::string&)> on_received;

 private:
  std::mutex mutex_;
  std::condition_variable news_;
  std::vector<std::pair<ClientId, Role>> joined_;
  std::vector<ClientId> left_;
  std::vector<std::string> received_;
};

/// A server on a thread of its own.
class Served {
 public:
  explicit Served(ServerOptions options = {}) : Served(options, nullptr) {}
  /// With another inbox than the fake one.
  Served(const ServerOptions& options, Inbox* inbox);
  ~Served() { stop(); }
  void stop();
  Server& server() { return *server_; }

  FakeInbox inbox;
  unsigned short port = 0;
  std::string host;  ///< "127.0.0.1:40213"
  std::string operator_token, viewer_token;

  /// GET with `more` header lines, each with its "\r\n".
  HttpReply get(const std::string& target, const std::string& more = {});
  /// The answer to this raw request.
  HttpReply raw(std::string_view request);

 private:
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

}  // namespace cogrsim::studio
