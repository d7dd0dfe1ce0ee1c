// The backend of a scene that names none, where no other is asked for.
#pragma once

namespace cogrsim {

inline constexpr const char* kDefaultBackend = "cogrsim";

}  // namespace cogrsim
