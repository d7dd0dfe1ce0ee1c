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

/// Parses `text`; every error starts with `name`. The first row is `time` and then motor names,
/// each with an optional unit in brackets (`elbow [deg]`). The other rows are numbers. Empty lines,
/// lines that start with '#', spaces around fields, CRLF and a byte order mark are allowed. Errors,
/// at most ten: an invalid header, a field that is not a finite number, a row of another length,
/// times that do not rise, no rows.
Parsed parse_trajectory(std::string_view text, const std::string& name);

/// Behaviour after the last row.
enum class AtEnd { hold, loop };

/// Targets at `time` [s], interpolated linearly between rows; before the first row those of the
/// first row. `loop` restarts after the last row, whose values should then equal those of the
/// first.
void sample(const Trajectory& trajectory, double time, AtEnd at_end, std::vector<double>& out);

/// Reads the file `path`, which is relative to `folder` and must be inside it after links are
/// resolved. Errors (in `errors`): the path is absolute or leaves the folder, or the file is
/// unreadable or larger than 64 MB.
Parsed load_trajectory(const std::string& folder, const std::string& path);

}  // namespace trajectory_player
