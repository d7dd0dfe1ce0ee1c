// Between the network and the parts: reads requests, checks access, and passes them on.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/json_bounds.h"
#include "talk.h"

namespace cogrsim::studio {

/// What a page receives in answer to hello.
struct StudioInfo {
  std::string version;
  std::string kind;  ///< "scene" or "recording"
  std::string file;
  bool allow_build = false;
  std::vector<std::string> backends;
  std::string assets;  ///< Server::assets()
};

/// Requests as in protocol.h. A page says `hello` first; then joined() of the parts is called, on
/// the thread on which they handle requests.
class Studio final : public Inbox {
 public:
  /// What a client may have pending at a time; more is refused with the code "busy".
  struct Limits {
    std::size_t requests = 256;     ///< without an answer yet
    std::size_t bytes = 64u << 20;  ///< of their texts
    JsonBounds json;
  };

  /// `parts`, asked in this order, `asset` and `outbox` outlive the studio.
  Studio(StudioInfo info, std::vector<Part*> parts, std::function<std::string(std::size_t)> asset,
         Outbox& outbox, Limits limits);
  Studio(StudioInfo info, std::vector<Part*> parts, std::function<std::string(std::size_t)> asset,
         Outbox& outbox);
  /// Waits for the request that is being handled; those behind it are dropped.
  ~Studio() override;

  void joined(ClientId client, Role role) override;
  void left(ClientId client) override;
  void received(ClientId client, std::string text) override;
  std::string asset(std::size_t number) override;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  // answers that come late refer to it
};

}  // namespace cogrsim::studio
