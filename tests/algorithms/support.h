// Algorithms as a program loads them.
#pragma once

#include <catch2/catch.hpp>

#include <memory>
#include <string>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/random.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim::test {

inline PluginLoader& loader() {
  static PluginLoader made({COGRSIM_TEST_ALGORITHMS});
  return made;
}

template <class Type>
std::shared_ptr<Type> make(const std::string& name, const Parameters& parameters = {},
                           std::uint64_t seed = 1, const std::string& folder = {}) {
  auto made = load_algorithm<Type>(loader(), name, parameters, seed, folder);
  if (!made) FAIL(made.error().text());
  return *made;
}

/// Text of an error; "" when there is none.
template <class Outcome>
std::string said(const Outcome& outcome) {
  return outcome ? std::string() : outcome.error().text();
}

inline bool has(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return true;
  UNSCOPED_INFO("\"" << text << "\" lacks \"" << part << "\"");
  return false;
}

inline int draw(RandomStream& random, int count) {
  return static_cast<int>(random.uniform(0.0, count));
}

}  // namespace cogrsim::test
