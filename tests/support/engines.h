// The engines of this build (COGRSIM_ENGINES, see tests/CMakeLists.txt). What holds on every engine is tested on all.
#pragma once

#include <catch2/catch.hpp>

#include <string>
#include <vector>

namespace cogrsim::test {

inline const std::vector<std::string>& all_engines() {
  static const std::vector<std::string> engines = {COGRSIM_ENGINES};
  return engines;
}

/// For GENERATE(): one after the other.
inline auto engines() { return Catch::Generators::from_range(all_engines()); }

/// Does it promise the figures of rigid bodies that a test states? An engine as it ships has its own,
/// in its table of the conformance suite; of it a test asks that the feature works.
inline bool states_figures(const std::string& engine) { return engine == "cogrsim"; }

}  // namespace cogrsim::test
