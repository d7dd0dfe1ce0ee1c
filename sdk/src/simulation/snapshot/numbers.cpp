// Values of snapshots as JSON, exact to the last bit.
#include <cmath>
#include <limits>

#include "cogrsim/core/random.h"
#include "model/model_json.h"
#include "simulation/snapshot/data.h"

namespace cogrsim::snapshots {

void not_whole(const Json& value, const std::string& lowest, const std::string& highest) {
  throw Damaged(
      (value.is_number() ? value.dump() : "a value of type " + std::string(value.type_name())) +
      " stands where a whole number from " + lowest + " to " + highest + " belongs");
}

Json number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

double number_from(const Json& value) {
  if (value.is_number()) return value.get<double>();
  if (value == "nan") return std::numeric_limits<double>::quiet_NaN();
  if (value == "inf") return std::numeric_limits<double>::infinity();
  if (value == "-inf") return -std::numeric_limits<double>::infinity();
  return value.get<double>();  // throws
}

Json numbers(const double* values, std::size_t count) {
  Json out = Json::array();
  for (std::size_t i = 0; i < count; ++i) out.push_back(number(values[i]));
  return out;
}

Json numbers(const std::vector<double>& values) { return numbers(values.data(), values.size()); }

std::vector<double> numbers_from(const Json& values) {
  std::vector<double> out;
  for (const Json& value : values) out.push_back(number_from(value));
  return out;
}

Json vector(const Vec3& v) { return numbers(v.data(), 3); }

Vec3 vector_from(const Json& value) {
  return {number_from(value.at(0)), number_from(value.at(1)), number_from(value.at(2))};
}

Json pose(const Pose& X) { return {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}; }

Pose pose_from(const Json& value) {
  Pose X;
  X.p = vector_from(value);
  X.q = Quat(number_from(value.at(3)), number_from(value.at(4)), number_from(value.at(5)),
             number_from(value.at(6)));
  return X;
}

Json twist(const Twist& V) {
  return {V.linear.x(), V.linear.y(), V.linear.z(), V.angular.x(), V.angular.y(), V.angular.z()};
}

Twist twist_from(const Json& value) {
  Twist V;
  V.linear = vector_from(value);
  V.angular = Vec3(number_from(value.at(3)), number_from(value.at(4)), number_from(value.at(5)));
  return V;
}

namespace {

// Without the source locations, which change with every comment.
void drop_origins(Json& value) {
  if (value.is_object()) {
    value.erase("origin");
    value.erase("backend_origin");
  }
  if (value.is_structured()) {
    for (Json& inner : value) drop_origins(inner);
  }
}

}  // namespace

std::string scene_signature(const SceneModel& model) {
  Json json = Json::parse(model_to_json(model));
  json.erase("files");
  drop_origins(json);
  // The engine-specific options belong to the run and not to the scene; step and seed are compared
  // separately.
  if (json.contains("physics")) {
    for (const char* key : {"backend", "engine_options", "step", "seed"})
      json["physics"].erase(key);
  }
  // The isolation of controllers does not count, because it does not affect the results.
  if (json.contains("controllers")) {
    for (Json& controller : json["controllers"]) {
      for (const char* key : {"isolation", "deadline", "memory"}) controller.erase(key);
    }
  }
  if (json.contains("supervisors")) {
    for (Json& controller : json["supervisors"]) {
      for (const char* key : {"isolation", "deadline", "memory"}) controller.erase(key);
    }
  }
  for (const char* key : {"assemblies", "materials", "joints", "couplings"}) {
    if (!json.contains(key)) continue;
    for (Json& element : json[key]) element.erase("engine_options");
  }
  std::string text = json.dump();
  std::uint64_t hash = hash_bytes(text.data(), text.size());
  for (const MeshPtr& mesh : model.meshes) {
    hash = hash_bytes(mesh->vertices.data(), mesh->vertices.size() * sizeof(Vec3), hash);
  }
  for (const HeightGridPtr& grid : model.heightmaps) {
    hash = hash_bytes(grid->heights.data(), grid->heights.size() * sizeof(double), hash);
  }
  return std::to_string(hash);
}

std::string listed(const std::string& one, const std::string& many,
                   const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 5;
  std::string out = names.size() == 1 ? one : many;
  for (std::size_t i = 0; i < names.size() && i < kShown; ++i) {
    out += (i == 0 ? " '" : ", '") + names[i] + "'";
  }
  if (names.size() > kShown) out += " and " + std::to_string(names.size() - kShown) + " more";
  return out;
}

}  // namespace cogrsim::snapshots
