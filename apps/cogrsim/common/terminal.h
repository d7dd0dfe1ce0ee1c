// Output on the terminal: colours, widths, aligned tables, figures a person can read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/core/shown_text.h"

namespace cogrsim::cli {

using cogrsim::one_line;
using cogrsim::paragraph;
using cogrsim::printable;

/// `--color`: `automatic` for terminals that want them (NO_COLOR is unset or empty, TERM is not
/// "dumb"). Set before there are threads.
enum class Colors { automatic, always, never };
void set_colors(Colors colors);

/// Colour codes for one stream; empty where there are none.
struct Style {
  std::string bold, dim, red, green, yellow, cyan, off;
};
Style style_of(int file_descriptor);

/// "1 body", "2 bodies".
std::string count_text(std::size_t count, const char* one, const char* many);

/// A terminal that can redraw a line.
bool is_live_terminal(int file_descriptor);
/// Columns of a terminal; 80 when not known.
int terminal_width(int file_descriptor);

/// Prints to stderr: "error: …", and behind the last "\nhelp: " the help, on a line of its own. What
/// strangers wrote must not come last without one_line() or paragraph().
void print_error(const std::string& text);
void print_warning(const std::string& text);

/// Quotes any text as one argument for a shell.
std::string shell_quoted(const std::string& text);

/// Columns that `text` takes: its UTF-8 code points, colour codes not counted.
std::size_t display_width(const std::string& text);
/// `text` cut to `width` columns, with "…" where something was left out.
std::string shortened(const std::string& name, std::size_t width);

/// Three significant digits with a fitting prefix: "12.3 mm", "0 m", "<0.001 nm". Not finite: "-".
std::string length_text(double metres);
/// "1.23°", "0.00456°", "0°"; takes rad.
std::string angle_text(double radians);
/// "4.213 s", "12 ms"; as many digits as a simulated time deserves.
std::string time_text(double seconds);
/// "1 ms", "0.5 ms", "1 s": a step, with all its digits up to six.
std::string step_text(double seconds);
/// "850 ms", "12.3 s", "2 min 03 s": how long something took or will take.
std::string elapsed_text(double seconds);
/// "812 bytes", "31.2 kB", "1.5 GB".
std::string bytes_text(std::uint64_t bytes);
/// Three significant digits, then the unit.
std::string quantity_text(double value, const std::string& unit);
/// "0.85x", "12.3x", "1500x".
std::string factor_text(double factor);

/// Columns lined up by display width. The first row is the head.
class TextTable {
 public:
  enum class Align { left, right };
  explicit TextTable(std::vector<Align> columns) : columns_(std::move(columns)) {}
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Every line starts with `indent`; the head is set in `head_on` … `head_off`.
  std::string text(const std::string& indent, const std::string& head_on = {},
                   const std::string& head_off = {}) const;

 private:
  std::vector<Align> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace cogrsim::cli
