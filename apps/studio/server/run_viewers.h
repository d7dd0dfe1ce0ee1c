// The viewers, the instant that each of them views, and the thread that sends it to them.
#pragma once

#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "run_status.h"
#include "run_scenes.h"
#include "run_wire.h"
#include "talk.h"

namespace cogrsim::studio {

class Viewers {
 public:
  Viewers(StatusPublisher& publisher, Frames& frames, Scenes& scenes, Outbox& outbox);
  ~Viewers();  ///< after stop()
  /// Nothing is sent any more.
  void stop();

  // From any thread.
  /// From now on it is sent everything.
  void joined(ClientId client);
  void left(ClientId client);
  /// Errors: there are no frames.
  Result<Instant> seek(ClientId client, double time);
  Result<Instant> step_back(ClientId client);
  void follow(ClientId client);
  void subscribe(ClientId client, std::optional<bool> contacts, std::optional<bool> readings,
                 std::optional<bool> joints);
  std::size_t count() const;
  /// What that client views now; empty: nothing, or it is gone.
  Instant seen(ClientId client) const;
  /// The frames are gone: all follow the run again.
  void follow_all();

 private:
  struct Client {
    bool new_here = true;  ///< is to be sent everything once
    bool live = true;
    Instant sought;
    Tail tail;
    std::uint32_t scene_sent = 0;
    // Of the frame sent last: not sent twice.
    FramePtr frame_sent;
    bool sent_live = false;
    Tail sent_tail;
  };
  void run();
  void publish_everything();
  void send_frames();
  Json status() const;

  StatusPublisher& publisher_;
  Frames& frames_;
  Scenes& scenes_;
  Outbox& outbox_;
  mutable std::mutex mutex_;
  std::map<ClientId, Client> clients_;
  std::thread thread_;
};

}  // namespace cogrsim::studio
