#include "common/progress.h"

#include <unistd.h>
#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

#include "common/options.h"
#include "common/output_file.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

std::string bar_text(double part, int width) {
  const int filled = static_cast<int>(part * width + 0.5);
  return "[" + std::string(static_cast<std::size_t>(filled), '#') +
         std::string(static_cast<std::size_t>(width - filled), '-') + "]";
}

std::string progress_line(const std::string& title, double time, double duration, double elapsed,
                          int width) {
  // Of a run that nobody ends beforehand there is nothing left to say.
  if (duration >= kLongestDuration) {
    const std::string speed = elapsed > 0.2 ? "  " + factor_text(time / elapsed) : "";
    return shortened(fmt::format("{}  {:.2f} s{}", title, time, speed),
                     static_cast<std::size_t>(std::max(width - 1, 2)));
  }
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
  if (bar >= 5) line += " " + bar_text(done, bar);
  return shortened(line + tail, static_cast<std::size_t>(std::max(width - 1, 2)));
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

StatusLine::StatusLine() : shown_(is_live_terminal(STDERR_FILENO) && !is_quiet()) {}

bool StatusLine::due() const { return shown_ && (!drawn_ || seconds_since(last_) >= 0.1); }

void StatusLine::show(const std::string& text) {
  if (!shown_) return;
  last_ = Clock::now();
  drawn_ = true;
  std::fputs(("\r" + text + "\033[K").c_str(), stderr);
  std::fflush(stderr);
}

void StatusLine::clear() {
  if (!drawn_) return;
  drawn_ = false;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
}

Progress::Progress(std::string title, double duration)
    : title_(std::move(title)), duration_(duration), start_(Clock::now()) {}

void Progress::show(double time) {
  if (!line_.due()) return;
  line_.show(
      progress_line(title_, time, duration_, seconds_since(start_), terminal_width(STDERR_FILENO)));
}

}  // namespace cogrsim::cli
