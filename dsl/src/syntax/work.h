// The budget of a compilation.
#pragma once

#include <cstddef>

namespace cogrsim::dsl {

/// All that may be read and computed for a scene with its imports and assets, in units of some
/// nanoseconds: a byte of a number is 2, a byte of a text or an expression 16, an entry of a list 64,
/// an element of a model 1500. The content of a repeat or a macro counts each time; a file counts
/// only for what is made of it beyond its own size.
inline constexpr std::size_t kMostWork = std::size_t{512} << 20;

}  // namespace cogrsim::dsl
