// Common functions of the parts of snapshot files.
#pragma once

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "cogrsim/simulation/snapshot_file.h"

namespace cogrsim {

using SnapshotJson = nlohmann::ordered_json;

struct SnapshotFile::Impl {
  SnapshotInfo info;
  SnapshotJson content;
};

/// Access to the implementation of a simulation.
struct SnapshotAccess {
  static Simulation::Impl& of(Simulation& simulation) { return *simulation.impl_; }
  static const Simulation::Impl& of(const Simulation& simulation) { return *simulation.impl_; }
};

namespace snapshots {

using Json = SnapshotJson;

/// A value in a snapshot is invalid; the text follows "is damaged: ".
struct Damaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] void not_whole(const Json& value, const std::string& lowest,
                            const std::string& highest);

/// Converts a JSON value to an integer. Throws Damaged if it is out of the range of Integer or not
/// an integer, where a cast would be undefined.
template <class Integer>
Integer whole_from(const Json& value) {
  constexpr Integer lowest = std::numeric_limits<Integer>::min();
  constexpr Integer highest = std::numeric_limits<Integer>::max();
  if (value.is_number_unsigned()) {
    const auto number = value.get<std::uint64_t>();
    if (number <= static_cast<std::uint64_t>(highest)) return static_cast<Integer>(number);
  } else if (value.is_number_integer()) {  // below zero
    const auto number = value.get<std::int64_t>();
    if (number >= static_cast<std::int64_t>(lowest)) return static_cast<Integer>(number);
  }
  not_whole(value, std::to_string(lowest), std::to_string(highest));
}

// Numbers are exact to the last bit; infinities and NaN, which JSON lacks, are texts.
Json number(double value);
double number_from(const Json& value);
Json numbers(const double* values, std::size_t count);
Json numbers(const std::vector<double>& values);
std::vector<double> numbers_from(const Json& values);
Json vector(const Vec3& v);
Vec3 vector_from(const Json& value);
Json pose(const Pose& X);
Pose pose_from(const Json& value);
Json twist(const Twist& V);
Twist twist_from(const Json& value);

/// Signature that distinguishes scenes; it does not depend on source locations and file names.
std::string scene_signature(const SceneModel& model);

/// The elements that were added, removed or changed since the start; null: none.
Json changes_of(const SceneModel& original, const SceneModel& now);

/// Applies the changes of changes_of() to `scene` by the names of the elements; the bodies have the
/// poses of `content`. Elements that are not found are reported in `notes`. Throws Damaged.
SceneModelPtr with_changes(const SceneModel& scene, const Json& content,
                           std::vector<std::string>& notes);

/// List of names for messages: "the body 'a'", "the bodies 'a', 'b' and 3 more".
std::string listed(const std::string& one, const std::string& many,
                   const std::vector<std::string>& names);

}  // namespace snapshots
}  // namespace cogrsim
