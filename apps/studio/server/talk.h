// The interfaces between the parts of the studio's server. Requests and answers: ../PROTOCOL.md.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "cogrsim/core/result.h"
#include "net/talk.h"

namespace cogrsim::studio {

using Json = nlohmann::json;

using net::Bytes, net::ClientId, net::Outbox, net::Role;

/// Receives what comes from the network. Called from its thread; returns at once.
class Inbox : public net::Inbox {
 public:
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
