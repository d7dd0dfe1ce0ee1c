// One line on stderr that shows how far a run has come; nothing at all when piped.
#pragma once

#include <chrono>
#include <string>

namespace cogrsim::cli {

/// The text of the line: "bullet  [#####-----]  50 %  5 s of 10 s  4.1x  1.2 s left".
/// `elapsed`: wall-clock seconds since the start.
std::string progress_line(const std::string& title, double time, double duration, double elapsed,
                          int width);

/// "[#####-----]", `width` characters between the brackets, `part` (0 to 1) of them filled.
std::string bar_text(double part, int width);

/// Wall-clock time that has passed [s].
double seconds_since(std::chrono::steady_clock::time_point start);

/// A line that is written over and over; shown only if stderr is a terminal.
class StatusLine {
 public:
  StatusLine();
  ~StatusLine() { clear(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  bool shown() const { return shown_; }
  /// True if another text is due: a few times a second.
  bool due() const;
  void show(const std::string& text);
  /// Takes the line away.
  void clear();

 private:
  bool shown_, drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
};

class Progress {
 public:
  /// `title` stands before the bar.
  Progress(std::string title, double duration);

  bool shown() const { return line_.shown(); }
  /// Redraws, a few times a second at most.
  void show(double time);
  /// Takes the line away.
  void finish() { line_.clear(); }

 private:
  std::string title_;
  double duration_;
  StatusLine line_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace cogrsim::cli
