// Whether a sanitizer of the compiler looks on: it catches signals, takes far more memory than any bound
// lets it, and the one for threads knows no threads in a child of a process that has some.
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
