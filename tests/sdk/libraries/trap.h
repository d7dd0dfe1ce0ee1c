// Leaves a trace in COGRSIM_TRAP as soon as anything of the library runs.
#pragma once

#include <cstdlib>
#include <fstream>

namespace {
struct Trap {
  Trap() {
    if (const char* file = std::getenv("COGRSIM_TRAP")) std::ofstream(file) << "sprung\n";
  }
};
const Trap trap;
}  // namespace
