#include "common/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

namespace cogrsim::cli {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

Colors g_colors = Colors::automatic;

bool dumb_terminal() {
  const char* term = std::getenv("TERM");
  return term != nullptr && std::strcmp(term, "dumb") == 0;
}

// Three significant digits, without an exponent where that stays short.
std::string three_digits(double value) {
  const double size = std::fabs(value);
  if (value == 0.0) return "0";
  if (size >= 1e5 || size < 1e-3) return fmt::format("{:.2e}", value);
  if (size >= 99.95) return fmt::format("{:.0f}", value);
  if (size >= 9.995) return fmt::format("{:.1f}", value);
  if (size >= 0.9995) return fmt::format("{:.2f}", value);
  return fmt::format("{:.3g}", value);
}

bool continues_code_point(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; }

// A message, and its help on a line of its own; all other lines are indented.
std::string with_help(const std::string& text) {
  constexpr std::string_view kHelp = "\nhelp: ";
  const std::size_t help = text.rfind(kHelp);
  if (help == std::string::npos) return paragraph(text);
  return paragraph(text.substr(0, help)) + std::string(kHelp) +
         paragraph(text.substr(help + kHelp.size()));
}

void print_marked(const std::string& colour, const char* word, const Style& style,
                  const std::string& text) {
  std::fputs(fmt::format("{}{}:{} {}\n", colour, word, style.off, with_help(text)).c_str(), stderr);
}

}  // namespace

void set_colors(Colors colors) { g_colors = colors; }

Style style_of(int file_descriptor) {
  const char* no_color = std::getenv("NO_COLOR");
  const bool unwanted = no_color != nullptr && no_color[0] != '\0';
  const bool automatic = !unwanted && !dumb_terminal() && isatty(file_descriptor) != 0;
  if (g_colors == Colors::never || (g_colors == Colors::automatic && !automatic)) return {};
  return {"\033[1m", "\033[2m", "\033[1;31m", "\033[32m", "\033[33m", "\033[36m", "\033[0m"};
}

std::string count_text(std::size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

bool is_live_terminal(int file_descriptor) {
  return isatty(file_descriptor) != 0 && !dumb_terminal();
}

int terminal_width(int file_descriptor) {
  winsize size{};
  if (ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

void print_error(const std::string& text) {
  const Style style = style_of(STDERR_FILENO);
  print_marked(style.red, "error", style, text);
}

void print_warning(const std::string& text) {
  const Style style = style_of(STDERR_FILENO);
  print_marked(style.yellow, "warning", style, text);
}

std::size_t display_width(const std::string& text) {
  std::size_t width = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\033') {
      const auto end = text.find('m', i);
      if (end == std::string::npos) break;
      i = end;
    } else if (!continues_code_point(text[i])) {
      ++width;
    }
  }
  return width;
}

std::string shell_quoted(const std::string& text) {
  const bool plain = !text.empty() && text.front() != '-' && text.front() != '=' &&
                     std::all_of(text.begin(), text.end(), [](char c) {
                       return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                              (c >= '0' && c <= '9') ||
                              std::string_view("_-./+,:@%=").find(c) != std::string_view::npos;
                     });
  if (plain) return text;
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string shortened(const std::string& name, std::size_t width) {
  const std::string text = one_line(name);
  if (display_width(text) <= width) return text;
  std::string out;
  std::size_t used = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!continues_code_point(text[i]) && ++used >= width) break;
    out += text[i];
  }
  return out + "…";
}

std::string length_text(double metres) {
  const double size = std::fabs(metres);
  if (!std::isfinite(metres)) return "-";
  if (metres == 0.0) return "0 m";
  if (size < 1e-12) return "<0.001 nm";  // rounding
  if (size >= 0.9995) return three_digits(metres) + " m";
  if (size >= 0.9995e-3) return three_digits(metres * 1e3) + " mm";
  if (size >= 0.9995e-6) return three_digits(metres * 1e6) + " µm";
  return three_digits(metres * 1e9) + " nm";
}

std::string angle_text(double radians) {
  if (!std::isfinite(radians)) return "-";
  if (radians != 0.0 && std::fabs(radians) < 1e-6 * kDegree) return "<1e-6°";  // rounding
  return three_digits(radians / kDegree) + "°";
}

std::string time_text(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  return fmt::format("{:.6g} s", seconds);
}

std::string step_text(double seconds) {
  if (seconds >= 1.0) return fmt::format("{:.6g} s", seconds);
  if (seconds >= 1e-4) return fmt::format("{:.6g} ms", seconds * 1e3);
  return fmt::format("{:.6g} µs", seconds * 1e6);
}

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 10'000) return fmt::format("{} bytes", bytes);
  const double size = static_cast<double>(bytes);
  if (size < 1e6) return fmt::format("{:.3g} kB", size / 1e3);
  if (size < 1e9) return fmt::format("{:.3g} MB", size / 1e6);
  return fmt::format("{:.3g} GB", size / 1e9);
}

std::string elapsed_text(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  if (seconds < 0.9995) return three_digits(seconds * 1e3) + " ms";
  if (seconds < 60.0) return three_digits(seconds) + " s";
  const auto whole = static_cast<long long>(seconds + 0.5);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string quantity_text(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "-";
  return three_digits(value) + (unit.empty() ? "" : " " + unit);
}

std::string factor_text(double factor) {
  if (!std::isfinite(factor)) return "-";
  return three_digits(factor) + "x";
}

std::string TextTable::text(const std::string& indent, const std::string& head_on,
                            const std::string& head_off) const {
  std::vector<std::size_t> widths(columns_.size(), 0);
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < row.size() && c < widths.size(); ++c) {
      widths[c] = std::max(widths[c], display_width(row[c]));
    }
  }
  std::string out;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    std::string line = indent;
    for (std::size_t c = 0; c < rows_[r].size() && c < widths.size(); ++c) {
      const std::string& cell = rows_[r][c];
      const std::string pad(widths[c] - display_width(cell), ' ');
      if (c > 0) line += "  ";
      line += columns_[c] == Align::right ? pad + cell : cell + pad;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += r == 0 ? head_on + line + head_off : line;
    out += '\n';
  }
  return out;
}

}  // namespace cogrsim::cli
