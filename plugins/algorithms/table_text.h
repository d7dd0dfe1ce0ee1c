// The table of a learner as text, and its file.
//
//     cogrsim-learner 1            format and its version
//     learner q_learning
//     episodes 120
//     state 17 -3.25 40 -1.5 2     state, then value and count of each action
//     …
//     end 1                        number of states; missing in a truncated file
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"

namespace algorithms {

struct TableRow {
  std::vector<double> values;         // by action
  std::vector<std::uint64_t> counts;  // number of experiences, by action
};

struct ReadTable {
  std::uint64_t episodes = 0;
  std::map<std::int64_t, TableRow> rows;
};

/// Writes a table; numbers are exact to the last bit.
std::string write_table(const std::string& learner, std::uint64_t episodes,
                        const std::map<std::int64_t, TableRow>& rows);

/// Parses a table; errors name `where` and the line.
cogrsim::Result<ReadTable> read_table(const std::string& learner, const std::string& text,
                                      const std::string& where);

bool file_exists(const std::string& path);
cogrsim::Result<std::string> read_file(const std::string& path);

}  // namespace algorithms
