#include <cstdio>
#include <exception>

#include "command_line.h"

int main(int argc, char** argv) {
  // Nothing here throws on purpose; memory may still run out on a scene that is too large.
  try {
    return cogrsim::cli::run_command_line(argc, argv, cogrsim::cli::more_words());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
    return 1;
  }
}
