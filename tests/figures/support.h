// Temporary folders, contents of files, and drawings.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "../support/temporary_folder.h"
#include "cogrsim/figures/draw.h"

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Folder = cogrsim::test::TemporaryFolder;

std::string content(const std::string& path);

/// Draws and fails the test with gnuplot's message if that does not work.
std::vector<std::string> drawn(const cogrsim::figures::Figure& figure, const std::string& path);
