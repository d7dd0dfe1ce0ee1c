// What waits to be sent to one client: bounded, whatever the client does.
#pragma once

#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "talk.h"

namespace cogrsim::studio {

/// Texts are kept all and in order; of frames, and of pictures of each key, only the newest. One frame and
/// one picture are on their way at a time, until the client says that it has taken them in.
/// Every function may be called from any thread.
class Mailbox {
 public:
  /// `limit`: of the texts that wait [byte], not counting the one whose turn it is.
  explicit Mailbox(std::size_t limit) : limit_(limit) {}

  /// Each: whether the network has to be told that there is something to send. It is told once until it
  /// has answered with wake_seen().
  bool put_text(Bytes text);
  bool put_frame(Bytes frame);
  bool put_picture(const std::string& key, Bytes picture);
  void wake_seen();

  /// No picture waits, and none is on its way.
  bool wants_picture() const;
  /// More texts waited than allowed: they were given up, the client has to go.
  bool overfull() const;
  /// What all that waits takes [byte].
  std::size_t waiting_bytes() const;

  struct Item {
    Bytes bytes;
    bool binary = false;
  };
  /// What to send now. Texts go first, so that a scene is there before its frames.
  std::optional<Item> next();
  void frame_taken();
  void picture_taken();
  /// From now on nothing is kept.
  void close();

 private:
  bool wake();

  mutable std::mutex mutex_;
  std::size_t limit_, text_bytes_ = 0;
  std::deque<Bytes> texts_;
  Bytes frame_;
  std::map<std::string, Bytes> pictures_;
  std::string last_key_;  ///< of the picture sent last: the others take turns
  bool frame_on_way_ = false, picture_on_way_ = false;
  bool woken_ = false, overfull_ = false, closed_ = false;
};

}  // namespace cogrsim::studio
