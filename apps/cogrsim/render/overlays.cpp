#include "render/overlays.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/rendering/standard_view.h"
#include "cogrsim/sensing/sensor_rays.h"

namespace cogrsim::cli {
namespace {

constexpr Color kRay{1.0, 0.1, 0.1, 1}, kMiss{1.0, 0.55, 0.55, 0.6}, kContact{1.0, 0.75, 0.0, 1};
// A lidar has so many rays that only thin and pale ones leave anything to see.
constexpr Color kFan{0.35, 0.6, 0.9, 0.35}, kFanMiss{0.35, 0.6, 0.9, 0.15};
constexpr Color kAxes[3] = {{0.9, 0.1, 0.1, 1}, {0.1, 0.65, 0.1, 1}, {0.15, 0.3, 0.95, 1}};

/// Above all that is seen of a body without an assembly, and of a whole assembly.
void label_things(const Frame& frame, double size, Overlay& overlay) {
  const SceneModel& model = *frame.model;
  const auto label = [&](const geometry::Bounds& around, const std::string& text) {
    if (around.empty()) return;
    Vec3 at = 0.5 * (around.low + around.high);
    // So high that the nearer edge does not hide it from one who looks up by 14 degrees.
    const double half = 0.5 * (around.high - around.low).head<2>().maxCoeff();
    at.z() = around.high.z() + 0.02 * size + 0.25 * half;
    overlay.labels.push_back({at, text, {1, 1, 1, 1}});
  };
  std::vector<geometry::Bounds> assemblies(model.assemblies.size());
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const int assembly = top_level_assembly(model, model.bodies[b].assembly);
    if (assembly >= 0)
      assemblies[assembly].add(visible_bounds(frame, b));
    else
      label(visible_bounds(frame, b), model.bodies[b].name);
  }
  for (std::size_t a = 0; a < assemblies.size(); ++a)
    label(assemblies[a], model.assemblies[a].name);
}

}  // namespace

Result<OverlayChoice> parse_overlays(const std::vector<std::string>& arguments) {
  OverlayChoice choice;
  const std::vector<std::pair<std::string, bool*>> known = {{"rays", &choice.rays},
                                                            {"contacts", &choice.contacts},
                                                            {"frames", &choice.frames},
                                                            {"labels", &choice.labels},
                                                            {"trails", &choice.trails}};
  for (const std::string& argument : arguments) {
    if (argument.empty()) continue;
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const auto& k) { return k.first == argument; });
    if (found == known.end()) {
      std::vector<std::string> names;
      for (const auto& k : known) names.push_back(k.first);
      const std::string near = nearest_name(argument, names);
      return fail(fmt::format("there is no overlay '{}'", argument), "",
                  fmt::format("{}there are rays, contacts, frames, labels and trails",
                              near.empty() ? "" : fmt::format("did you mean '{}'? ", near)));
    }
    *found->second = true;
  }
  return choice;
}

Overlay make_overlay(const Frame& frame, const OverlayChoice& choice, double size,
                     const std::vector<MapTrail>& trails) {
  Overlay overlay;
  const auto line = [&](const Vec3& from, const Vec3& to, const Color& color, double width,
                        bool on_top) {
    if (from.allFinite() && to.allFinite()) {
      overlay.lines.push_back({from, to, color, width, on_top});
    }
  };
  if (choice.rays) {
    for (const SensorRay& ray : sensor_rays(frame)) {
      const bool lidar = frame.model->sensors[ray.sensor].type == "lidar";
      line(ray.from, ray.to, lidar ? (ray.hit ? kFan : kFanMiss) : (ray.hit ? kRay : kMiss),
           lidar ? 1.0 : 1.5, false);
    }
  }
  if (choice.contacts) {
    double largest = 0.0;
    for (const Contact& c : frame.contacts) largest = std::max(largest, c.force.norm());
    for (const Contact& c : frame.contacts) {
      if (largest > 0.0 && c.force.norm() > 1e-6 * largest) {
        line(c.point, c.point + c.force * (0.1 * size / largest), kContact, 2.5, true);
      }
      for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
        line(c.point - 0.004 * size * axis, c.point + 0.004 * size * axis, kContact, 2.5, true);
      }
    }
  }
  if (choice.frames) {
    for (std::size_t b = 0; b < frame.model->bodies.size(); ++b) {
      const Body& body = frame.model->bodies[b];
      if (body.removed || body.kind == BodyKind::static_body) continue;
      const Pose& X = frame.state.poses[b];
      for (int k = 0; k < 3; ++k) {
        line(X.p, X * Vec3(0.06 * size * Vec3::Unit(k)), kAxes[k], 2.0, true);
      }
    }
  }
  if (choice.trails) {
    for (const MapTrail& trail : trails) {
      // Dashed: every other stretch of a fixed length.
      const double dash = 0.012 * size;
      double along = 0.0;
      for (std::size_t i = 1; i < trail.points.size(); ++i) {
        const Vec3 &a = trail.points[i - 1], &b = trail.points[i];
        if (!a.allFinite() || !b.allFinite()) continue;
        if (std::fmod(along, 2.0 * dash) < dash) line(a, b, trail.color, 2.0, true);
        along += (b - a).norm();
      }
    }
  }
  if (choice.labels) label_things(frame, size, overlay);
  return overlay;
}

}  // namespace cogrsim::cli
