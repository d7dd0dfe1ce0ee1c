// Messages over a stream socket: 4 bytes of length, big-endian, then that many bytes.
#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace cogrsim::socket_controller {

/// The largest message that a client may send [byte].
inline constexpr std::size_t kLargestMessage = std::size_t{1} << 24;

using Deadline = std::chrono::steady_clock::time_point;

/// One connected client. Not for several threads.
class Connection {
 public:
  explicit Connection(int file) : file_(file) {}
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Both throw std::runtime_error: the client closed the connection, took longer than the deadline,
  // or sent a message that is too long.
  void send(const std::string& message, Deadline deadline);
  std::string receive(Deadline deadline);

 private:
  void transfer(char* data, std::size_t size, bool out, Deadline deadline);
  int file_;
};

/// Waits for clients at an address. Controllers with the same address, in several simulations of
/// one process, share it; each takes the next client. Thread-safe.
class Listener {
 public:
  /// `address`: unix:PATH, relative to `folder` and inside it, or tcp:HOST:PORT with an address in
  /// numbers or localhost. An address that is not of the loopback needs a token. Throws
  /// std::runtime_error: not such an address, or it cannot be listened at.
  static std::shared_ptr<Listener> at(const std::string& address, const std::string& folder,
                                      bool has_token);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// Throws std::runtime_error: no client came before the deadline.
  std::unique_ptr<Connection> accept(Deadline deadline);

 private:
  Listener() = default;
  int file_ = -1;
  std::string path_;  ///< of a Unix socket, removed at the end
};

}  // namespace cogrsim::socket_controller
