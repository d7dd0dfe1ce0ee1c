// The checksum at the end of a snapshot file, for tests that forge one.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "cogrsim/core/random.h"

namespace cogrsim {

/// The "checksum" that SnapshotFile::read() expects for this "content".
inline std::string snapshot_sum(const nlohmann::ordered_json& content) {
  const std::string text =
      content.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return std::to_string(hash_bytes(text.data(), text.size()));
}

}  // namespace cogrsim
