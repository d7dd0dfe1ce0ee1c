// Requests and replies between a simulation and the process of one of its controllers, through
// shared memory. The two sides work in lockstep: one waits while the other computes.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim {

/// Header of the shared memory, one page; it is followed by the requests and the replies.
struct ChannelHeader {
  // Futexes; the sender of a message increments the one of the receiver.
  std::atomic<std::uint32_t> to_child, to_parent;
  std::atomic<std::uint32_t> child_sleeps, parent_sleeps;
  std::atomic<std::uint32_t> requests, replies;  ///< numbers of messages so far
  std::atomic<std::uint32_t> ended;              ///< the process ended and the watchdog reported it
  std::atomic<std::uint64_t> request_size, reply_size;          ///< [byte]
  std::atomic<std::uint64_t> request_capacity, reply_capacity;  ///< [byte]; the parent raises them
  std::atomic<std::uint32_t> does_not_fit;  ///< the reply is longer than reply_capacity
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// One end of the channel: a mapping of the shared memory.
class CallChannel {
 public:
  CallChannel() = default;
  CallChannel(const CallChannel&) = delete;
  CallChannel& operator=(const CallChannel&) = delete;
  ~CallChannel();

  /// Creates the shared memory; called by the parent. Errors: those of the operating system.
  Result<> create();
  /// Maps the shared memory of the parent. Errors: those of the operating system.
  Result<> open(int file);
  int file() const { return file_; }
  ChannelHeader& header() { return *static_cast<ChannelHeader*>(memory_); }

  using Clock = std::chrono::steady_clock;

  // ---- parent
  enum class Answer { reply, ended, late, broken };
  /// Sends a request. Errors: the request does not fit into the memory.
  Result<> ask(const std::vector<char>& request);
  /// Waits for the reply to the last request. It regularly calls `gone()`, which returns whether
  /// the watchdog has ended without a report, and `given_up()`, which returns whether the user has
  /// cancelled the call; the result is then Answer::late. So it is after `patience`, which begins
  /// again while `held()`: a debugger has stopped the process.
  template <class Gone, class GivenUp, class Held>
  Answer await(std::vector<char>& reply, std::optional<Clock::duration> patience, Gone&& gone,
               GivenUp&& given_up, Held&& held) {
    const auto from_now = [&] {
      return patience ? Clock::now() + *patience : Clock::time_point::max();
    };
    Clock::time_point deadline = from_now();
    while (true) {
      const auto until = std::min(deadline, Clock::now() + std::chrono::milliseconds(100));
      if (const auto answer = look(reply, until)) return *answer;
      if (gone()) return look(reply, Clock::now()).value_or(Answer::ended);
      const bool over = Clock::now() >= deadline;
      if (over && !given_up() && held())
        deadline = from_now();
      else if (over || given_up())
        return look(reply, Clock::now()).value_or(Answer::late);
    }
  }

  // ---- child
  /// Waits for a request without a time limit. False: the shared memory is damaged.
  bool next_request(std::vector<char>& request);
  /// Sends a reply. False: the shared memory is damaged.
  bool answer(const std::vector<char>& reply);

  // ---- watchdog
  void report_end();

 private:
  std::optional<Answer> look(std::vector<char>& reply, Clock::time_point until);
  Result<> map();
  Result<> grow(std::uint64_t request_capacity, std::uint64_t reply_capacity);
  char* requests();
  char* replies();

  int file_ = -1;
  void* memory_ = nullptr;
  std::size_t mapped_ = 0;
  // Own copies, because the values in the shared memory may be damaged.
  std::uint64_t request_capacity_ = 0, reply_capacity_ = 0;
  std::uint32_t asked_ = 0;
};

}  // namespace cogrsim
