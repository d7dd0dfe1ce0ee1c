// A run of a program of tests/benchmarks, see engine_program.h.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "scene.h"

namespace cogrsim::faithful {

constexpr std::size_t kNumbers = 7;  // of a thing: place, turn

/// Says why it ended, or gives the numbers of all things after each step.
struct Run {
  std::vector<double> trace;
  std::string unsupported, failed;
};

/// `command` is for the shell; files go to `folder`.
Run run(const std::string& command, const bench::FaithfulScene& scene,
        const std::filesystem::path& folder);

}  // namespace cogrsim::faithful
