// The interfaces between the parts of the studio's server. Requests and answers: ../PROTOCOL.md.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "cogrsim/core/result.h"

namespace cogrsim::studio {

using Json = nlohmann::json;

using ClientId = std::uint64_t;  ///< counts from 1; never used twice
enum class Role { viewer, operator_ };

/// Immutable bytes that several clients may be sent.
using Bytes = std::shared_ptr<const std::string>;

/// Sends messages to the pages. From any thread; returns at once, whatever the network does.
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
  /// The file behind /asset/NUMBER: absolute path, "" for none. From the network's thread.
  virtual std::string asset(std::size_t number) = 0;
};

/// A group of requests, which one part answers.
enum class Section { session, start, run, numbers, document, debug };

/// One request of a page.
struct Request {
  ClientId client = 0;
  Role role = Role::viewer;
  std::string what;  ///< its "do"
  Json fields;       ///< as the table of the protocol has them: check_fields()
};

/// An answer's fields beside id and ok, or why not; Error::code may be "viewer" or "stale".
using Answer = Result<Json>;
/// To be called once, from any thread.
using Reply = std::function<void(Answer)>;

/// A part that answers some of the requests: the run, the document, pictures.
class Part {
 public:
  virtual ~Part() = default;
  virtual bool answers(Section section) const = 0;
  /// Called from one thread, one request at a time; long work is done in another thread.
  virtual void handle(Request request, Reply reply) = 0;
  virtual void joined(ClientId, Role) {}
  virtual void left(ClientId) {}
};

}  // namespace cogrsim::studio
