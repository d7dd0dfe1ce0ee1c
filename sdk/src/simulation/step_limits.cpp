#include "simulation/step_limits.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "cogrsim/geometry/convex.h"
#include "cogrsim/physics/backend_checks.h"
#include "core/index.h"

namespace cogrsim {
namespace {

// Of a shape that contact is resolved on: its least extent; a surface without a volume has none [m].
double thickness(const SceneModel& model, const Shape& shape) {
  if (is_surface(shape.type)) return std::numeric_limits<double>::infinity();
  return 2.0 * geometry::local_bounds(model, shape).half().minCoeff();
}

}  // namespace

void StepLimits::check(WorldHost& host, const Clock& clock, MessageLog& log) {
  constexpr std::uint64_t kEvery = 64;  // steps
  if (clock.steps() % kEvery != 1) return;
  spin_reported_ = spin_reported_ || check_spin(host, clock, log);
  overlap_reported_ = overlap_reported_ || check_overlap(host, log);
}

void StepLimits::check_start(WorldHost& host, const Clock& clock, MessageLog& log) {
  if (clock.steps() == 0) spin_reported_ = spin_reported_ || check_spin(host, clock, log);
}

bool StepLimits::check_spin(WorldHost& host, const Clock& clock, MessageLog& log) {
  constexpr double kMost = 0.5;  // [rad] in a step
  const double dt = clock.dt();
  const WorldState& now = host.state();
  const SceneModel& model = *host.model();
  for (std::size_t i = 0; i < now.twists.size(); ++i) {
    const double turned = now.twists[i].angular.norm() * dt;
    const std::string& name = model.bodies[i].name;
    if (model.bodies[i].removed || !(turned > kMost)) continue;
    log.report(
        Severity::warning, name,
        fmt::format("body '{}' turns by {:.2g} rad in a step of {} ms: beyond {} rad engines "
                    "gain or lose energy; a step of {:.2g} ms keeps it below",
                    name, turned, 1e3 * dt, kMost, 1e3 * dt * kMost / turned));
    return true;
  }
  return false;
}

// In two looks one after the other: what starts inside another, or hits it, has been parted by then.
bool StepLimits::check_overlap(WorldHost& host, MessageLog& log) {
  constexpr double kMost = 0.1;  // of the thinner body
  const SceneModel& model = *host.model();
  host.world().get_contacts(contacts_);
  now_deep_.clear();
  for (const Contact& contact : contacts_) {
    if (!(contact.depth > 0.0)) continue;
    const Body &a = model.bodies[at(contact.body_a)], &b = model.bodies[at(contact.body_b)];
    const Shape &of_a = a.shapes[at(contact.shape_a)], &of_b = b.shapes[at(contact.shape_b)];
    const double thin = std::min(thickness(model, of_a), thickness(model, of_b));
    if (!(contact.depth > kMost * thin)) continue;
    // Surfaces with a stiffness are meant to yield.
    if (surface_pair(model, of_a.material, of_b.material).stiffness) continue;
    const std::pair<int, int> pair(contact.body_a, contact.body_b);
    now_deep_.push_back(pair);
    if (std::find(deep_.begin(), deep_.end(), pair) == deep_.end()) continue;
    const bool both = a.kind == BodyKind::dynamic && b.kind == BodyKind::dynamic;
    log.report(Severity::warning, a.name,
               fmt::format("bodies '{}' and '{}' overlap by {:.2g} mm, and the thinner one is "
                           "{:.2g} mm thick: contact "
                           "does not hold what presses them together{}; a shorter step, more "
                           "iterations of the solver "
                           "or masses nearer to each other help",
                           a.name, b.name, 1e3 * contact.depth, 1e3 * thin,
                           both ? fmt::format(" ({:.3g} and {:.3g} kg)", a.mass, b.mass) : ""));
    return true;
  }
  deep_.swap(now_deep_);
  return false;
}

}  // namespace cogrsim
