// One line on stderr that shows how far a run has come; nothing at all when piped.
#pragma once

#include <chrono>
#include <string>

namespace cogrsim::cli {

/// The text of the line: "bullet  [#####-----]  50 %  5 s of 10 s  4.1x  1.2 s left".
/// `elapsed`: wall-clock seconds since the start.
std::string progress_line(const std::string& title, double time, double duration, double elapsed,
                          int width);

/// Wall-clock time that has passed [s].
double seconds_since(std::chrono::steady_clock::time_point start);

class Progress {
 public:
  /// `title` stands before the bar. Shows itself only if stderr is a terminal.
  explicit Progress(std::string title, double duration);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  bool shown() const { return shown_; }
  /// Redraws, a few times a second at most.
  void show(double time);
  /// Takes the line away.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  std::string title_;
  double duration_;
  bool shown_;
  bool drawn_ = false;
  Clock::time_point start_, last_;
};

}  // namespace cogrsim::cli
