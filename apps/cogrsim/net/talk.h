// The interfaces between a server and what it serves: who sends, who receives.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace cogrsim::net {

using ClientId = std::uint64_t;  ///< counts from 1; never used twice
enum class Role { viewer, operator_ };

/// Immutable bytes that several clients may be sent.
using Bytes = std::shared_ptr<const std::string>;

/// Sends messages to the clients. From any thread; returns at once, whatever the network does.
class Outbox {
 public:
  virtual ~Outbox() = default;

  /// A text message. A client that does not read its texts is cut off when too many wait.
  virtual void send(ClientId client, std::string text) = 0;
  /// To every client.
  virtual void send_all(std::string text) = 0;

  /// The client's newest frame: replaces one that still waits.
  virtual void offer_frame(ClientId client, Bytes frame) = 0;
  /// The client's newest picture of that key (kind and name): replaces one that still waits.
  virtual void offer_picture(ClientId client, const std::string& key, Bytes picture) = 0;
  /// Whether the client has taken in all pictures it was offered: only then is it worth rendering
  /// more. From any thread.
  virtual bool wants_picture(ClientId client) const = 0;
};

/// Receives what comes from the network. Called from its thread; returns at once.
class Inbox {
 public:
  virtual ~Inbox() = default;
  virtual void joined(ClientId client, Role role) = 0;
  virtual void left(ClientId client) = 0;
  /// A text message that is not an acknowledgement; at most as long as the network's limit.
  virtual void received(ClientId client, std::string text) = 0;
  /// A binary message; false: none is understood, and the client is cut off.
  virtual bool received_bytes(ClientId, const std::string&) { return false; }
};

}  // namespace cogrsim::net
