// Preloaded into a program: its calendar clock jumps an hour back at every other reading, and
// between jumps runs backwards. The steady clock, which by specification never goes back, is
// unchanged.
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <ctime>

namespace {

/// The reported time [s]: always before the last reported one.
long fake_time() {
  static std::atomic<long> looks{0};
  timespec now{};
  ::syscall(SYS_clock_gettime, CLOCK_REALTIME, &now);
  const long n = ++looks;
  return now.tv_sec - n - (n % 2) * 3600;
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* out) {
  if (clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE) {
    return static_cast<int>(::syscall(SYS_clock_gettime, clock, out));
  }
  out->tv_sec = fake_time();
  out->tv_nsec = 0;
  return 0;
}

extern "C" int gettimeofday(timeval* out, void*) {
  out->tv_sec = fake_time();
  out->tv_usec = 0;
  return 0;
}

extern "C" time_t time(time_t* out) {
  const time_t now = fake_time();
  if (out != nullptr) *out = now;
  return now;
}
