// The watchdog of a controller's process: see child_process.h.
#pragma once

namespace cogrsim {
class CallChannel;
}

namespace cogrsim::watchdog {

// Descriptors that the program finds open.
inline constexpr int kMemory = 3;
inline constexpr int kLink = 4;
inline constexpr int kFirstFree = 10;

/// Starts the worker, which calls `serve` and ends with its return value, and waits for its end.
/// Returns the exit code.
int run(int (*serve)(CallChannel&));

}  // namespace cogrsim::watchdog
