// The engines of this build (COGRSIM_ENGINES, see tests/CMakeLists.txt). Properties of every engine
// are tested on all engines.
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

/// Whether it guarantees the figures of rigid bodies that a test states. An engine with its default
/// settings has its own figures, in its table of the conformance suite; a test only requires that
/// the feature works.
inline bool states_figures(const std::string& engine) { return engine == "cogrsim"; }

}  // namespace cogrsim::test
