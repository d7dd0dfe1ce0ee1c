// A table of targets over time, read from CSV text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace trajectory_player {

struct Trajectory {
  std::vector<std::string> columns;       ///< motor names, without the time
  std::vector<double> times;              ///< [s], strictly rising (nrow)
  std::vector<std::vector<double>> rows;  ///< SI (nrow x ncolumn)
};

struct Parsed {
  Trajectory trajectory;
  std::vector<std::string> errors;  ///< "arm.csv:3: …"; empty: the trajectory is good
};

/// Reads `text`; `name` stands before every error. First row: `time`, then motor names, each with
/// an optional unit in brackets (`elbow [deg]`). Then rows of numbers. Empty lines, lines that
/// start with '#', spaces around fields, CRLF and a byte order mark are fine. Errors: a bad header,
/// a field that is not a finite number, a row of another length, times that do not rise, no rows;
/// ten at most are listed.
Parsed parse_trajectory(std::string_view text, const std::string& name);

/// What happens after the last row.
enum class AtEnd { hold, loop };

/// Targets at `time` [s], linear between rows; before the first row the first. `loop` starts over
/// after the last row, whose values should then equal the first's.
void sample(const Trajectory& trajectory, double time, AtEnd at_end, std::vector<double>& out);

/// Reads the file `path`, relative to `folder` and below it, whatever links lie between.
/// Errors (in `errors`): an absolute path, one that leaves the folder, unreadable, over 64 MB.
Parsed load_trajectory(const std::string& folder, const std::string& path);

}  // namespace trajectory_player
