// Preloaded into a program: its calendar clock jumps an hour back at every other look, and between
// jumps runs backwards. The steady clock, which the system promises never to go back, stays.
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <ctime>

namespace {

/// The time told [s]: before the one told last, always.
long told() {
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
  out->tv_sec = told();
  out->tv_nsec = 0;
  return 0;
}

extern "C" int gettimeofday(timeval* out, void*) {
  out->tv_sec = told();
  out->tv_usec = 0;
  return 0;
}

extern "C" time_t time(time_t* out) {
  const time_t now = told();
  if (out != nullptr) *out = now;
  return now;
}
