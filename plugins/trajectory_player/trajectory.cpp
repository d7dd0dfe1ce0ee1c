#include "trajectory.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace trajectory_player {

namespace {

constexpr std::size_t kMaxErrors = 10;
constexpr std::uintmax_t kMaxBytes = 64u << 20;
constexpr double kDegree = 3.14159265358979323846 / 180;

struct Unit {
  const char* name;
  double factor;  // conversion to SI
};
constexpr Unit kUnits[] = {{"s", 1},           {"ms", 1e-3},         {"rad", 1},   {"deg", kDegree},
                           {"m", 1},           {"cm", 1e-2},         {"mm", 1e-3}, {"rad/s", 1},
                           {"deg/s", kDegree}, {"rpm", 6 * kDegree}, {"m/s", 1},   {"cm/s", 1e-2},
                           {"mm/s", 1e-3},     {"N*m", 1},           {"N", 1},     {"V", 1}};

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t start = 0;;) {
    const auto comma = line.find(',', start);
    fields.push_back(trimmed(line.substr(start, comma - start)));
    if (comma == std::string_view::npos) return fields;
    start = comma + 1;
  }
}

/// Parses a field, independently of the locale; the whole field must be one finite number.
bool read_number(std::string_view field, double& out) {
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  const auto [end, status] = std::from_chars(field.data(), field.data() + field.size(), out);
  return status == std::errc() && end == field.data() + field.size() && std::isfinite(out);
}

/// Splits "elbow [deg]" into name and factor; false if the unit is unknown.
bool read_column(std::string_view field, std::string& name, std::string& unit, double& factor) {
  factor = 1.0;
  unit.clear();
  const auto bracket = field.find('[');
  if (bracket == std::string_view::npos || field.back() != ']') {
    name = field;
    return true;
  }
  name = trimmed(field.substr(0, bracket));
  unit = trimmed(field.substr(bracket + 1, field.size() - bracket - 2));
  for (const Unit& known : kUnits) {
    if (unit == known.name) {
      factor = known.factor;
      return true;
    }
  }
  return false;
}

std::string unit_names() {
  std::string out;
  for (const Unit& unit : kUnits) out += (out.empty() ? "" : ", ") + std::string(unit.name);
  return out;
}

/// Reads header and rows line by line and collects errors.
class Reader {
 public:
  explicit Reader(std::string name) : name_(std::move(name)) {}

  void line(std::string_view text, int number) {
    number_ = number;
    text = trimmed(text);
    if (text.empty() || text.front() == '#') return;
    if (!header_seen_) {
      header_seen_ = true;
      header(fields_of(text));
    } else if (header_good_) {
      row(fields_of(text));
    }
  }

  Parsed finish() {
    if (!header_seen_) {
      out_.errors.push_back(name_ + ": empty: expected a header row: time, then motor names");
    } else if (out_.errors.empty() && out_.trajectory.times.empty()) {
      out_.errors.push_back(name_ + ": no rows after the header");
    }
    return std::move(out_);
  }
  bool full() const { return out_.errors.size() >= kMaxErrors; }

 private:
  void fail(const std::string& what) {
    out_.errors.push_back(name_ + ":" + std::to_string(number_) + ": " + what);
  }

  void header(const std::vector<std::string_view>& fields) {
    header_good_ = true;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      std::string column, unit;
      double factor = 1.0;
      if (!read_column(fields[i], column, unit, factor)) {
        bad_header("column " + std::to_string(i + 1) + ": unknown unit '" + unit +
                   "'; known: " + unit_names());
      }
      if (i == 0 && (column != "time" || !(unit.empty() || unit == "s" || unit == "ms"))) {
        bad_header("expected the first column to be 'time' (seconds, or 'time [ms]'), found '" +
                   std::string(fields[0]) + "'");
      }
      if (column.empty()) bad_header("column " + std::to_string(i + 1) + " has no name");
      auto& columns = out_.trajectory.columns;
      if (i > 0 && std::find(columns.begin(), columns.end(), column) != columns.end()) {
        bad_header("column '" + column + "' appears twice");
      }
      if (i > 0) columns.push_back(column);
      factors_.push_back(factor);
    }
    if (fields.size() < 2) bad_header("expected at least one motor name after 'time'");
  }

  void bad_header(const std::string& what) {
    header_good_ = false;
    fail(what);
  }

  void row(const std::vector<std::string_view>& fields) {
    if (fields.size() != factors_.size()) {
      fail("expected " + std::to_string(factors_.size()) + " fields as in the header, found " +
           std::to_string(fields.size()));
      return;
    }
    std::vector<double> values(fields.size());
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (!read_number(fields[i], values[i])) {
        fail("column '" + (i == 0 ? std::string("time") : out_.trajectory.columns[i - 1]) +
             "': expected a number, found '" + std::string(fields[i].substr(0, 40)) + "'");
        return;
      }
      values[i] *= factors_[i];
    }
    auto& times = out_.trajectory.times;
    if (!times.empty() && values[0] <= times.back()) {
      fail("expected a time after that of the previous row");
      return;
    }
    times.push_back(values[0]);
    out_.trajectory.rows.emplace_back(values.begin() + 1, values.end());
  }

  std::string name_;
  int number_ = 0;
  bool header_seen_ = false, header_good_ = false;
  std::vector<double> factors_;
  Parsed out_;
};

Parsed failed(const std::string& what) {
  Parsed out;
  out.errors.push_back(what);
  return out;
}

}  // namespace

Parsed parse_trajectory(std::string_view text, const std::string& name) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  Reader reader(name);
  int number = 1;
  for (std::size_t start = 0; start <= text.size() && !reader.full(); ++number) {
    const auto end = std::min(text.find('\n', start), text.size());
    reader.line(text.substr(start, end - start), number);
    start = end + 1;
  }
  return reader.finish();
}

void sample(const Trajectory& trajectory, double time, AtEnd at_end, std::vector<double>& out) {
  const auto& times = trajectory.times;
  const double period = times.back() - times.front();
  if (at_end == AtEnd::loop && time > times.back() && period > 0) {
    time = times.front() + std::fmod(time - times.front(), period);
  }
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.begin()) {
    out = trajectory.rows.front();
    return;
  }
  if (next == times.end()) {
    out = trajectory.rows.back();
    return;
  }
  const auto i = static_cast<std::size_t>(next - times.begin());
  const double s = (time - times[i - 1]) / (times[i] - times[i - 1]);
  out.resize(trajectory.columns.size());
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c] = trajectory.rows[i - 1][c] * (1 - s) + trajectory.rows[i][c] * s;
  }
}

Parsed load_trajectory(const std::string& folder, const std::string& path) {
  namespace fs = std::filesystem;
  if (fs::path(path).is_absolute()) {
    return failed("file '" + path + "': expected a path relative to the scene's folder");
  }
  std::error_code error;
  const fs::path base =
      fs::weakly_canonical(folder.empty() ? fs::path(".") : fs::path(folder), error);
  const fs::path full = fs::weakly_canonical(base / path, error);
  if (error) return failed("file '" + path + "': " + error.message());
  // Compared by path elements after resolving links: "scene2" is not inside "scene".
  const auto [at, rest] = std::mismatch(base.begin(), base.end(), full.begin(), full.end());
  if (at != base.end()) {
    return failed("file '" + path + "' lies outside the scene's folder " + base.string());
  }
  if (!fs::is_regular_file(full, error)) {
    return failed("file '" + path + "' does not exist in " + base.string());
  }
  if (fs::file_size(full, error) > kMaxBytes) {
    return failed("file '" + path + "' is larger than 64 MB");
  }
  std::ifstream in(full, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) return failed("file '" + path + "' cannot be read");
  return parse_trajectory(text, path);
}

}  // namespace trajectory_player
