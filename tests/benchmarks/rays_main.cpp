// 1000 rays at 1000 mixed bodies: cogrsim_ray_benchmark [ROUNDS] [--json]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "../sdk/rays_reference.h"
#include "rays.h"

using namespace cogrsim;

namespace {

constexpr int kBodies = 1000, kRays = 1000;
constexpr double kExtent = 15.0;   // half width of the cube the bodies are in [m]
constexpr double kLength = 100.0;  // Bullet's rays have an end [m]

double seconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Wrong {
  int by_micrometre = 0, by_millimetre = 0;
  double worst = 0.0;  // where both hit [m]
};

Wrong compare(const std::vector<double>& found, const std::vector<double>& exact) {
  Wrong wrong;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] == exact[i]) continue;
    const double error = std::abs(found[i] - exact[i]);
    wrong.by_micrometre += !(error <= 1e-6);
    wrong.by_millimetre += !(error <= 1e-3);
    if (std::isfinite(error)) wrong.worst = std::max(wrong.worst, error);
  }
  return wrong;
}

}  // namespace

int main(int argc, char** argv) {
  const bool json = argc > 1 && std::strcmp(argv[argc - 1], "--json") == 0;
  const int rounds = argc - json > 1 ? std::max(1, std::atoi(argv[1])) : 21;
  const SceneModelPtr model = reference::mixed_bodies(kBodies, kExtent, Vec3::Zero(), 17, false);
  std::vector<Pose> poses = reference::poses_of(*model);
  // From outside of all bodies, as both casters count what is met from within differently.
  std::vector<Ray> rays;
  std::vector<double> exact;
  RandomStream random(18, "rays");
  while (rays.size() < kRays) {
    Ray ray;
    ray.origin = reference::random_point(random, kExtent);
    ray.direction = reference::random_direction(random);
    ray.max_distance = kLength;
    const bool buried = std::any_of(model->bodies.begin(), model->bodies.end(), [&](const auto& b) {
      return (b.X_WB.p - ray.origin).norm() < 1.5;
    });
    if (buried) continue;
    rays.push_back(ray);
    exact.push_back(reference::cast(*model, poses, ray).distance);
  }

  RayCaster ours;
  ours.update(model, poses);
  const auto bullet = bench::make_bullet_rays(*model);
  std::vector<RayHit> hits;
  std::vector<double> distances, ours_time, bullet_time, ratio, moved_time;
  for (int round = 0; round < rounds; ++round) {
    const double start = seconds();
    for (int i = 0; i < 10; ++i) ours.cast(rays, hits);
    const double between = seconds();
    bullet->cast(rays, kLength, distances);
    const double end = seconds();
    ours_time.push_back((between - start) / 10);
    bullet_time.push_back(end - between);
    ratio.push_back(bullet_time.back() / ours_time.back());
  }
  std::vector<double> ours_distances;
  for (const RayHit& hit : hits) ours_distances.push_back(hit.distance);
  const Wrong wrong_ours = compare(ours_distances, exact), wrong_bullet = compare(distances, exact);
  const auto met =
      kRays - std::count(exact.begin(), exact.end(), std::numeric_limits<double>::infinity());

  for (int round = 0; round < rounds; ++round) {
    for (Pose& pose : poses) pose.p += reference::random_point(random, 0.01);
    const double start = seconds();
    ours.update(model, poses);
    moved_time.push_back(seconds() - start);
  }

  if (json) {
    const auto row = [&](const char* name, double time, const Wrong& wrong) {
      return nlohmann::json{{"engine", name},
                            {"rays_per_s", kRays / time},
                            {"wrong_by_1_um", wrong.by_micrometre},
                            {"wrong_by_1_mm", wrong.by_millimetre},
                            {"largest_error_m", wrong.worst}};
    };
    nlohmann::json rows = {row("cogrsim", median(ours_time), wrong_ours),
                           row("raw-bullet", median(bullet_time), wrong_bullet)};
    rows[0]["ratio_to_raw_bullet"] = median(ratio);
    rows[0]["moving_all_us"] = median(moved_time) * 1e6;
    fmt::print("{}\n", rows.dump(2));
    return 0;
  }
  fmt::print("{} rays at {} bodies, {} of them hit something; {} rounds\n", kRays, kBodies, met,
             rounds);
  fmt::print("| caster | rays/s | wrong by 1 um | by 1 mm | largest error [m] |\n");
  fmt::print("|---|---|---|---|---|\n");
  const auto row = [&](const char* name, double time, const Wrong& wrong) {
    fmt::print("| {} | {:.2f} million | {} | {} | {:.2g} |\n", name, kRays / time / 1e6,
               wrong.by_micrometre, wrong.by_millimetre, wrong.worst);
  };
  row("CogRSim", median(ours_time), wrong_ours);
  row("Bullet rayTest", median(bullet_time), wrong_bullet);
  fmt::print("ratio {:.1f}; moving all bodies costs CogRSim {:.0f} us\n", median(ratio),
             median(moved_time) * 1e6);
  return 0;
}
