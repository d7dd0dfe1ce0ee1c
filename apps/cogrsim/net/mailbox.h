// The messages that wait for one client: bounded, whatever the client does.
#pragma once

#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "net/talk.h"

namespace cogrsim::net {

/// Texts are kept all and in order; of frames, and of pictures of each key, only the newest. One frame and
/// one picture are in flight at a time, until the client acknowledges them. Of a stream the newest are kept
/// that fit.
/// Every function may be called from any thread.
class Mailbox {
 public:
  /// `limit`: of the waiting texts [byte], not counting the next one. `stream_limit`: of the waiting
  /// messages of the stream [byte], not counting the newest one and those that are kept.
  explicit Mailbox(std::size_t limit, std::size_t stream_limit = 0)
      : limit_(limit), stream_limit_(stream_limit) {}

  /// Each: whether the network thread has to be woken. It is woken once, until it has answered with
  /// wake_seen().
  bool put_text(Bytes text);
  bool put_frame(Bytes frame);
  bool put_picture(const std::string& key, Bytes picture);
  /// Appends to the stream, and drops the oldest for it where it does not fit; adds their number to
  /// `dropped`. `keep`: this one is never dropped, and counts as the texts do.
  bool put_stream(std::string head, Bytes body, std::size_t& dropped, bool keep = false);
  void wake_seen();

  /// No picture waits, and none is in flight.
  bool wants_picture() const;
  /// More texts waited than allowed: they were dropped, the client is to be cut off.
  bool overfull() const;
  /// Size of all waiting messages [byte].
  std::size_t waiting_bytes() const;

  struct Item {
    Bytes bytes;
    bool binary = false;
    std::string head = {};  ///< goes before the bytes, in the same message
    bool keep = false;      ///< of the stream: not dropped
  };
  /// What to send now. Texts go first, so that a scene is there before its frames.
  std::optional<Item> next();
  void frame_taken();
  void picture_taken();
  /// From now on nothing is kept.
  void close();

 private:
  bool wake();
  void check_limit();
  void drop_all();

  mutable std::mutex mutex_;
  std::size_t limit_, stream_limit_, text_bytes_ = 0, stream_bytes_ = 0;
  std::size_t kept_bytes_ = 0;    ///< of the stream's messages that are kept
  std::size_t largest_kept_ = 0;  ///< of them, since none waited [byte]
  std::deque<Bytes> texts_;
  std::deque<Item> stream_;
  Bytes frame_;
  std::map<std::string, Bytes> pictures_;
  std::string last_key_;  ///< of the picture sent last: the others take turns
  bool frame_in_flight_ = false, picture_in_flight_ = false;
  bool woken_ = false, overfull_ = false, closed_ = false;
};

}  // namespace cogrsim::net
