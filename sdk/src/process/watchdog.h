// The watchdog of another process: see watched_process.h.
#pragma once

namespace cogrsim {
class CallChannel;
}

namespace cogrsim::watchdog {

// Descriptors that the program finds open.
inline constexpr int kChannel = 3;
inline constexpr int kLink = 4;
inline constexpr int kFirstFree = 10;
/// Begins an argument before the command of the worker: what it may reach, see Confinement.
inline constexpr const char* kConfined = "--confined=";

/// Starts the worker, and waits for its end. The worker calls `serve` and ends with its return value,
/// or becomes the program of `command`, which ends with a nullptr; it must, where the channel is a
/// socket. Returns the exit code.
int run(int (*serve)(CallChannel&), char** command);

/// What such a program does: calls `serve` and returns its value; 2: it was not started as a worker.
int serve_as_worker(int (*serve)(CallChannel&));

}  // namespace cogrsim::watchdog
