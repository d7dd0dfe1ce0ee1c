// Requests and replies between a simulation and the process of one of its controllers, through memory
// that both have mapped. One side waits while the other one works: lockstep.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim {

/// How a process ended, as its guard tells: over a socket that the process itself does not have.
struct ProcessEnd {
  bool told = false;            ///< false: its guard has gone without a word
  int status = 0;               ///< as waitpid() gives it
  std::int64_t most_bytes = 0;  ///< largest resident memory it had
};

/// The shared memory: a page with this, then requests, then replies.
struct ChannelHeader {
  // Counted up by whoever has news; a futex each.
  std::atomic<std::uint32_t> to_child, to_parent;
  std::atomic<std::uint32_t> child_sleeps, parent_sleeps;
  std::atomic<std::uint32_t> requests, replies;  ///< so far
  std::atomic<std::uint32_t> ended;              ///< the process is gone; its guard has said how
  std::atomic<std::uint64_t> request_size, reply_size;          ///< [byte]
  std::atomic<std::uint64_t> request_capacity, reply_capacity;  ///< [byte]; the parent's to raise
  std::atomic<std::uint32_t> does_not_fit;  ///< the reply is longer than reply_capacity
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// A mapping of the shared memory, one's own end of it.
class CallChannel {
 public:
  CallChannel() = default;
  CallChannel(const CallChannel&) = delete;
  CallChannel& operator=(const CallChannel&) = delete;
  ~CallChannel();

  /// Makes the memory; only the parent does. Errors: the system's.
  Result<> create();
  /// Maps memory made by the parent. Errors: the system's.
  Result<> open(int file);
  int file() const { return file_; }
  ChannelHeader& header() { return *static_cast<ChannelHeader*>(memory_); }

  using Clock = std::chrono::steady_clock;

  // ---- the parent's end
  enum class Answer { reply, ended, late, broken };
  /// Hands a request over. Errors: it does not fit into the machine's memory.
  Result<> ask(const std::vector<char>& request);
  /// Waits for the reply to what was last asked. `gone()` is asked now and then whether the guard
  /// has gone without a word, and `given_up()` whether nobody wants the reply any more: it is late then.
  template <class Gone, class GivenUp>
  Answer await(std::vector<char>& reply, Clock::time_point deadline, Gone&& gone,
               GivenUp&& given_up) {
    while (true) {
      const auto until = std::min(deadline, Clock::now() + std::chrono::milliseconds(100));
      if (const auto answer = look(reply, until)) return *answer;
      if (gone()) return look(reply, Clock::now()).value_or(Answer::ended);
      if (Clock::now() >= deadline || given_up())
        return look(reply, Clock::now()).value_or(Answer::late);
    }
  }

  // ---- the child's end
  /// Waits for a request, however long. False: something is wrong with the memory.
  bool next_request(std::vector<char>& request);
  /// False: something is wrong with the memory.
  bool answer(const std::vector<char>& reply);

  // ---- the guard's
  void tell_end();

 private:
  std::optional<Answer> look(std::vector<char>& reply, Clock::time_point until);
  Result<> map();
  Result<> grow(std::uint64_t request_capacity, std::uint64_t reply_capacity);
  char* requests();
  char* replies();

  int file_ = -1;
  void* memory_ = nullptr;
  std::size_t mapped_ = 0;
  // As this side knows them: what stands in the shared memory may be damaged.
  std::uint64_t request_capacity_ = 0, reply_capacity_ = 0;
  std::uint32_t asked_ = 0;
};

}  // namespace cogrsim
