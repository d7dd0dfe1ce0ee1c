// Test cases made by loops: one per shape pair, one per joint axis, so that each has its own line
// in the table.
#pragma once

#include <vector>

#include "record.h"

namespace conformance {

std::vector<GeneratedTest> pair_tests();   ///< every shape on every other
std::vector<GeneratedTest> axis_tests();   ///< every joint axis, passive
std::vector<GeneratedTest> motor_tests();  ///< every joint axis with a motor
std::vector<GeneratedTest> servo_tests();  ///< every joint axis with a servo or a DC motor

inline std::vector<GeneratedTest> generated_tests() {
  std::vector<GeneratedTest> all;
  for (const auto& tests : {pair_tests(), axis_tests(), motor_tests(), servo_tests()}) {
    all.insert(all.end(), tests.begin(), tests.end());
  }
  return all;
}

}  // namespace conformance
