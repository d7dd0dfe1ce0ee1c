// Memory and processor time of something that a hostile file asks for, in a process of its own, which
// the system ends if it far exceeds the bounds.
#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include <catch2/catch.hpp>

#include "sanitizers.h"

namespace cogrsim::test {

// Sanitizers add their own memory to every object, and their own work to every access.
inline constexpr double kCostFactor = kSanitized ? 8.0 : 1.0;
inline constexpr double kMostMegabytes = 500 * kCostFactor;
// Twice the documented bounds: processor time grows where other programs share the caches.
inline constexpr double kMostSeconds = 10 * kCostFactor;

struct Cost {
  double megabytes = 0.0, seconds = 0.0;  ///< peak of resident memory, processor time
  int status = -1;                        ///< as waitpid() gives it; 0: `work` returned true
};

/// `work` returns whether it ended as it should.
template <class Work>
Cost cost_of(const Work& work) {
  std::fflush(stdout);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const auto bound = [](int what, double value) {
      const rlimit limit{static_cast<rlim_t>(value), static_cast<rlim_t>(value)};
      ::setrlimit(static_cast<__rlimit_resource>(what), &limit);
    };
    bound(RLIMIT_CPU, 4 * kMostSeconds);
    if (!kSanitized) bound(RLIMIT_AS, 4e6 * kMostMegabytes);
    bound(RLIMIT_CORE, 0);
    try {
      const bool good = work();
      std::fflush(stdout);
      ::_exit(good ? 0 : 1);
    } catch (...) {  // the test's own handlers are those of the parent
      ::_exit(2);
    }
  }
  Cost cost;
  rusage used{};
  REQUIRE(::wait4(child, &cost.status, 0, &used) == child);
  cost.megabytes = static_cast<double>(used.ru_maxrss) / 1e3;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  cost.seconds = seconds(used.ru_utime) + seconds(used.ru_stime);
  return cost;
}

/// Checks the cost of `work`. COGRSIM_COSTS_OF="lidar" in the environment shows those of constructs
/// with that word alone, "" all.
template <class Work>
void check_cost(const std::string& construct, const Work& work) {
  const char* of = std::getenv("COGRSIM_COSTS_OF");
  if (of != nullptr && construct.find(of) == std::string::npos) return;
  const Cost cost = cost_of(work);
  if (of != nullptr)
    std::printf("%6.0f MB %6.2f s  status %d  %s\n", cost.megabytes, cost.seconds, cost.status,
                construct.c_str());
  INFO(construct << ": " << cost.megabytes << " MB, " << cost.seconds << " s, status "
                 << cost.status);
  CHECK(cost.status == 0);
  CHECK(cost.megabytes < kMostMegabytes);
  CHECK(cost.seconds < kMostSeconds);
}

}  // namespace cogrsim::test
