// One target as libFuzzer calls it; the target is selected at compile time.
#include <cstddef>
#include <cstdint>

#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cogrsim::fuzz::COGRSIM_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
