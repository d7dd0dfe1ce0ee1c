// Counts calls of the allocator while armed, and records whose code made them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cogrsim::bench {

/// Allocations that came by one way: the same chain of return addresses.
struct AllocationSite {
  std::uint64_t count = 0;
  std::uint64_t bytes = 0;
  bool ours = false;  ///< the nearest frame outside the allocators is in CogRSim's own code
  /// That frame and those that called it, nearest first: "bullet.so+0x1f2a3" (for addr2line), with
  /// the function's name where the library has it.
  std::vector<std::string> frames;
};

struct AllocationReport {
  std::uint64_t ours = 0, engine = 0;  ///< calls of malloc, calloc, realloc and their kin
  std::uint64_t ours_bytes = 0, engine_bytes = 0;
  std::uint64_t lost = 0;  ///< came by more ways than there is room for: in no other count
  std::vector<AllocationSite> sites;  ///< most frequent first
};

/// The program this is linked into has its malloc replaced by one that hands on to the C library's
/// and, between start and stop, notes who called. All threads are counted. One at a time.
///
/// Ours is what libcogrsim, a plugin of ours (a backend too) or the program itself asked for: the
/// nearest frame that is neither in the C and C++ libraries nor in an engine's bare allocator.
/// Templates of an engine's headers that were compiled into a plugin count as ours.
void start_counting_allocations();
AllocationReport stop_counting_allocations();

}  // namespace cogrsim::bench
