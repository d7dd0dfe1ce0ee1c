// What the parts of a snapshot on file share.
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

/// The way into a simulation.
struct SnapshotAccess {
  static Simulation::Impl& of(Simulation& simulation) { return *simulation.impl_; }
  static const Simulation::Impl& of(const Simulation& simulation) { return *simulation.impl_; }
};

namespace snapshots {

using Json = SnapshotJson;

/// What stands in a snapshot cannot stand there; its text goes on after "is damaged: ".
struct Damaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] void not_whole(const Json& value, const std::string& lowest,
                            const std::string& highest);

/// A whole number as a file has it. Throws Damaged for one that an Integer cannot be, and for
/// anything else: what a cast would make of it is not defined.
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

// Numbers keep their bits; what JSON has no numbers for is text.
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

/// Tells two scenes apart; places in source files and the names of these do not count.
std::string scene_signature(const SceneModel& model);

/// What has come, gone or been changed since the start; null: nothing.
Json changes_of(const SceneModel& original, const SceneModel& now);

/// `scene` with the changes of `changes_of()`, found again by name; bodies stand where `content`
/// has them. What cannot be found is told in `notes`. Throws Damaged.
SceneModelPtr with_changes(const SceneModel& scene, const Json& content,
                           std::vector<std::string>& notes);

/// "the body 'a'", "the bodies 'a', 'b' and 3 more".
std::string listed(const std::string& one, const std::string& many,
                   const std::vector<std::string>& names);

}  // namespace snapshots
}  // namespace cogrsim
