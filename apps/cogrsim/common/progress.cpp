#include "common/progress.h"

#include <unistd.h>
#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

#include "common/terminal.h"

namespace cogrsim::cli {

std::string progress_line(const std::string& title, double time, double duration, double elapsed,
                          int width) {
  const double done = duration > 0.0 ? std::clamp(time / duration, 0.0, 1.0) : 0.0;
  std::string tail =
      fmt::format(" {:3.0f} %  {:.2f} s of {}", 100.0 * done, time, time_text(duration));
  // The start of a run says nothing about its speed.
  if (elapsed > 0.2 && time > 0.0) {
    tail += fmt::format("  {}  {} left", factor_text(time / elapsed),
                        elapsed_text(elapsed / done - elapsed));
  }
  const int space = width - 1 - static_cast<int>(display_width(title) + display_width(tail)) - 4;
  const int bar = std::clamp(space, 0, 30);
  std::string line = title;
  if (bar >= 5) {
    const int filled = static_cast<int>(done * bar + 0.5);
    line += " [" + std::string(static_cast<std::size_t>(filled), '#') +
            std::string(static_cast<std::size_t>(bar - filled), '-') + "]";
  }
  return shortened(line + tail, static_cast<std::size_t>(std::max(width - 1, 2)));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Progress::Progress(std::string title, double duration)
    : title_(std::move(title)),
      duration_(duration),
      shown_(is_live_terminal(STDERR_FILENO)),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() { finish(); }

void Progress::show(double time) {
  if (!shown_) return;
  const auto now = Clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const std::string line =
      progress_line(title_, time, duration_, elapsed, terminal_width(STDERR_FILENO));
  std::fputs(("\r" + line + "\033[K").c_str(), stderr);
  std::fflush(stderr);
}

void Progress::finish() {
  if (!drawn_) return;
  drawn_ = false;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
}

}  // namespace cogrsim::cli
