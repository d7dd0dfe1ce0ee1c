// Faults of a plugin in the program that runs it.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>

namespace misdeed {

// Each level has a block that the next one writes to, lest the compiler make a loop of it.
inline int deeper(int level, volatile char* outer) {
  if (level < 0) return 0;  // never: the stack is gone long before
  volatile char block[4096] = {};
  outer[level % 4096] = 1;
  const int below = deeper(level + 1, block);
  return below + block[level % 4096];
}

inline void throws() { throw std::runtime_error("on request"); }
inline void throws_where_nothing_may() noexcept { throws(); }

/// Makes the file that RASCAL_MARK names: the test sees that the plugin is running.
inline void mark() {
  if (std::FILE* const file = std::fopen(std::getenv("RASCAL_MARK"), "w")) std::fclose(file);
}

inline void commit(const std::string& what) {
  if (what == "mark" || what == "stay") mark();
  while (what == "stay") pause();
  if (what == "crash") std::abort();
  if (what == "segv") {
    int* nowhere = nullptr;
    *nowhere = 1;
  }
  if (what == "overflow") {
    volatile char block[4096] = {};
    std::printf("%d\n", deeper(0, block));
  }
  if (what == "terminate") std::terminate();
  if (what == "noexcept") throws_where_nothing_may();
  if (what == "exit") std::exit(0);
  if (what == "print") std::puts("error: a plugin may print what it likes");
  if (what == "throw") throw std::runtime_error("on request");
  volatile bool for_ever = what == "hang";  // a loop that the compiler may not remove
  if (for_ever) std::fputs("the plugin hangs\n", stderr);
  while (for_ever) {
  }
}

/// What the environment variable RASCAL, "WHERE:WHAT", says for this call.
inline void commit_at(const std::string& where) {
  const char* asked = std::getenv("RASCAL");
  const std::string text = asked ? asked : "";
  if (text.compare(0, where.size() + 1, where + ":") == 0) commit(text.substr(where.size() + 1));
}

}  // namespace misdeed
