// Whether a sanitizer of the compiler is active: it catches signals, takes far more memory than any
// limit allows, and the thread sanitizer does not support threads in a child of a multi-threaded
// process.
#pragma once

namespace cogrsim::test {

#if defined(__SANITIZE_THREAD__)
inline constexpr bool kThreadSanitized = true;
#else
inline constexpr bool kThreadSanitized = false;
#endif

#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = kThreadSanitized;
#endif

inline constexpr const char* kCatchesSignals =
    "a sanitizer catches signals and takes more memory than any bound lets it";

}  // namespace cogrsim::test
