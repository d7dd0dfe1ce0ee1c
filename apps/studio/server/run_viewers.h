// Who looks on, at what, and the thread that sends it to them.
#pragma once

#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "run_board.h"
#include "run_scenes.h"
#include "run_wire.h"
#include "talk.h"

namespace cogrsim::studio {

class Viewers {
 public:
  Viewers(Board& board, Frames& frames, Scenes& scenes, Outbox& outbox);
  ~Viewers();  ///< after stop()
  /// Nothing is sent any more.
  void stop();

  // From any thread.
  /// From now on it is told everything.
  void joined(ClientId client);
  void left(ClientId client);
  /// Errors: there are no frames.
  Result<Moment> seek(ClientId client, double time);
  Result<Moment> step_back(ClientId client);
  void follow(ClientId client);
  void subscribe(ClientId client, std::optional<bool> contacts, std::optional<bool> readings);
  std::size_t count() const;
  /// What that client looks at now; empty: nothing, or it is gone.
  Moment seen(ClientId client) const;
  /// The frames are gone: all follow the run again.
  void follow_all();

 private:
  struct Client {
    bool new_here = true;  ///< is to be told everything once
    bool live = true;
    Moment sought;
    Tail tail;
    std::uint32_t scene_sent = 0;
    // Of the frame sent last: not sent twice.
    FramePtr frame_sent;
    bool sent_live = false;
    Tail sent_tail;
  };
  void run();
  void tell_everything();
  void send_frames();
  Json status() const;

  Board& board_;
  Frames& frames_;
  Scenes& scenes_;
  Outbox& outbox_;
  mutable std::mutex mutex_;
  std::map<ClientId, Client> clients_;
  std::thread thread_;
};

}  // namespace cogrsim::studio
