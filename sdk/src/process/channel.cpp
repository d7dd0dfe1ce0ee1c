#include "process/channel.h"

#include <fcntl.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <new>
#include <thread>

namespace cogrsim {

namespace {

constexpr std::size_t kHeaderSize = 4096;
constexpr std::uint64_t kFirstCapacity = 64 << 10;
constexpr std::uint64_t kMostRequest = std::uint64_t{4} << 30;  // enough for the largest images
constexpr std::uint64_t kMostReply = std::uint64_t{256} << 20;
/// Time of busy waiting before sleeping; an update of a simple controller takes less.
constexpr auto kSpin = std::chrono::microseconds(20);

static_assert(sizeof(ChannelHeader) <= kHeaderSize);

Error system_error(const std::string& what) { return Error(what + ": " + std::strerror(errno)); }

void futex_wake(std::atomic<std::uint32_t>& futex) {
  ::syscall(SYS_futex, &futex, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

/// Sleeps while the value of `futex` is `seen`, at most until `until`.
void futex_wait(std::atomic<std::uint32_t>& futex, std::uint32_t seen,
                std::optional<CallChannel::Clock::time_point> until) {
  timespec wait{};
  if (until) {
    const auto left =
        std::chrono::duration_cast<std::chrono::nanoseconds>(*until - CallChannel::Clock::now())
            .count();
    if (left <= 0) return;
    wait.tv_sec = static_cast<time_t>(left / 1'000'000'000);
    wait.tv_nsec = static_cast<long>(left % 1'000'000'000);
  }
  ::syscall(SYS_futex, &futex, FUTEX_WAIT, seen, until ? &wait : nullptr, nullptr, 0);
}

void ring(std::atomic<std::uint32_t>& futex, std::atomic<std::uint32_t>& sleeps) {
  futex.fetch_add(1);
  if (sleeps.exchange(0) != 0) futex_wake(futex);
}

/// Waits for `ready()`; returns false if it is still false at the time `until`.
template <class Ready>
bool wait_for(std::atomic<std::uint32_t>& futex, std::atomic<std::uint32_t>& sleeps,
              std::optional<CallChannel::Clock::time_point> until, Ready&& ready) {
  const auto spin_end = CallChannel::Clock::now() + kSpin;
  while (CallChannel::Clock::now() < spin_end) {
    for (int i = 0; i < 50; ++i) {
      if (ready()) return true;
    }
  }
  while (true) {
    const std::uint32_t seen = futex.load();
    sleeps.store(1);
    if (ready()) return true;
    if (until && CallChannel::Clock::now() >= *until) return false;
    futex_wait(futex, seen, until);
  }
}

}  // namespace

CallChannel::~CallChannel() {
  if (memory_) ::munmap(memory_, mapped_);
  if (file_ >= 0) ::close(file_);
}

char* CallChannel::requests() { return static_cast<char*>(memory_) + kHeaderSize; }
char* CallChannel::replies() { return requests() + request_capacity_; }

Result<> CallChannel::map() {
  if (memory_) ::munmap(memory_, mapped_);
  memory_ = nullptr;
  mapped_ = kHeaderSize + request_capacity_ + reply_capacity_;
  void* memory = ::mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (memory == MAP_FAILED) return tl::unexpected(system_error("shared memory cannot be mapped"));
  memory_ = memory;
  return {};
}

Result<> CallChannel::create() {
  file_ = ::memfd_create("cogrsim-controller", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (file_ < 0) return tl::unexpected(system_error("shared memory cannot be made"));
  request_capacity_ = reply_capacity_ = kFirstCapacity;
  const auto size = static_cast<off_t>(kHeaderSize + request_capacity_ + reply_capacity_);
  if (::ftruncate(file_, size) != 0) {
    return tl::unexpected(system_error("shared memory cannot be made"));
  }
  // If the child could shrink the memory, reading there would crash this process.
  if (::fcntl(file_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_SEAL) != 0) {
    return tl::unexpected(system_error("shared memory cannot be sealed"));
  }
  if (auto mapped = map(); !mapped) return mapped;
  new (memory_) ChannelHeader();
  header().request_capacity = request_capacity_;
  header().reply_capacity = reply_capacity_;
  return {};
}

Result<> CallChannel::open(int file) {
  file_ = file;
  request_capacity_ = reply_capacity_ = 0;
  if (auto mapped = map(); !mapped) return mapped;
  request_capacity_ = header().request_capacity;
  reply_capacity_ = header().reply_capacity;
  return map();
}

Result<> CallChannel::grow(std::uint64_t request_capacity, std::uint64_t reply_capacity) {
  const auto size = static_cast<off_t>(kHeaderSize + request_capacity + reply_capacity);
  if (request_capacity > kMostRequest || reply_capacity > kMostReply) {
    return fail("a message is too large for the shared memory");
  }
  if (::ftruncate(file_, size) != 0) {
    return tl::unexpected(system_error("shared memory cannot be enlarged"));
  }
  request_capacity_ = request_capacity;
  reply_capacity_ = reply_capacity;
  if (auto mapped = map(); !mapped) return mapped;
  header().request_capacity = request_capacity_;
  header().reply_capacity = reply_capacity_;
  return {};
}

Result<> CallChannel::ask(const std::vector<char>& request) {
  if (request.size() > request_capacity_) {
    if (auto grown = grow(request.size() + request.size() / 2, reply_capacity_); !grown) {
      return grown;
    }
  }
  if (!request.empty()) std::memcpy(requests(), request.data(), request.size());
  header().request_size = request.size();
  asked_ = header().replies.load() + 1;
  header().does_not_fit = 0;
  ++header().requests;
  ring(header().to_child, header().child_sleeps);
  return {};
}

std::optional<CallChannel::Answer> CallChannel::look(std::vector<char>& reply,
                                                     Clock::time_point until) {
  while (true) {
    const bool news = wait_for(header().to_parent, header().parent_sleeps, until, [this] {
      return header().replies.load() == asked_ || header().ended.load() != 0;
    });
    if (!news) return std::nullopt;
    if (header().replies.load() != asked_) return Answer::ended;
    const std::uint64_t size = header().reply_size;
    if (header().does_not_fit != 0) {
      if (!grow(request_capacity_, size + size / 2)) return Answer::broken;
      asked_ = header().replies.load() + 1;
      header().does_not_fit = 0;
      ring(header().to_child, header().child_sleeps);
      continue;
    }
    if (size > reply_capacity_) return Answer::broken;
    reply.assign(replies(), replies() + size);
    return Answer::reply;
  }
}

bool CallChannel::next_request(std::vector<char>& request) {
  ++asked_;
  wait_for(header().to_child, header().child_sleeps, std::nullopt,
           [this] { return header().requests.load() == asked_; });
  const std::uint64_t request_capacity = header().request_capacity;
  const std::uint64_t reply_capacity = header().reply_capacity;
  if (request_capacity != request_capacity_ || reply_capacity != reply_capacity_) {
    request_capacity_ = request_capacity;
    reply_capacity_ = reply_capacity;
    if (!map()) return false;
  }
  const std::uint64_t size = header().request_size;
  if (size > request_capacity_) return false;
  request.assign(requests(), requests() + size);
  return true;
}

bool CallChannel::answer(const std::vector<char>& reply) {
  header().reply_size = reply.size();
  if (reply.size() > reply_capacity_) {
    header().does_not_fit = 1;
    ++header().replies;
    ring(header().to_parent, header().parent_sleeps);
    wait_for(header().to_child, header().child_sleeps, std::nullopt,
             [&] { return header().does_not_fit.load() == 0; });
    request_capacity_ = header().request_capacity;
    reply_capacity_ = header().reply_capacity;
    if (!map() || reply.size() > reply_capacity_) return false;
  }
  if (!reply.empty()) std::memcpy(replies(), reply.data(), reply.size());
  ++header().replies;
  ring(header().to_parent, header().parent_sleeps);
  return true;
}

void CallChannel::report_end() {
  header().ended = 1;
  ring(header().to_parent, header().parent_sleeps);
}

}  // namespace cogrsim
