// Catch2 of version 2 cannot skip a case: a case that returns has passed. This macro states the
// reason, and CTest, which runs each case by itself, counts it as skipped (cogrsim_add_cases() in
// tests/CMakeLists.txt).
#pragma once

#include <iostream>

#define COGRSIM_SKIP(why)                           \
  do {                                              \
    std::cout << "SKIPPED: " << (why) << std::endl; \
    return;                                         \
  } while (false)
