// Writes JSON as other programs of the project read it.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "cogrsim/core/types.h"
#include "cogrsim/physics/provenance.h"

namespace cogrsim::cli {

/// Keys keep the order in which they were put in.
using Json = nlohmann::ordered_json;

/// The document as text with a newline at its end. Floating-point numbers have 17 significant
/// digits, so that reading them gives the same bits; numbers that are not finite become null.
/// Invalid UTF-8 in strings is replaced. Arrays of plain values stay on one line.
std::string json_text(const Json& value);

Json text_or_null(const std::string& text);  ///< null where it is empty

Json to_json(const Vec3& v);  ///< [x, y, z]
Json to_json(const Quat& q);  ///< [w, x, y, z]

Json to_json(const Provenance& provenance);

}  // namespace cogrsim::cli
