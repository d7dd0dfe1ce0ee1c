#include "paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace cogrsim::studio {

namespace {

constexpr std::size_t kMostPaths = 64;
constexpr std::size_t kMostPoints = 200'000;  // of all
constexpr std::size_t kFewestPoints = 2000;   // of one, before it is thinned
constexpr std::size_t kMost = 10'000;
// A chord of twice the length is four times as far from its arc.
constexpr double kCoarser = 4.0;
constexpr double kCoarsest = 1.0;  // [m]

struct Followed {
  std::string label, body;
  bool steered = false;
};

std::vector<Followed> followed(const SceneModel& model) {
  std::set<int> steered, seen;
  for (const ControllerModel& controller : model.controllers) {
    if (!controller.removed) steered.insert(top_level_assembly(model, controller.assembly));
  }
  std::vector<Followed> out;
  for (const Body& body : model.bodies) {
    if (body.removed || body.kind == BodyKind::static_body) continue;
    const int top = top_level_assembly(model, body.assembly);
    if (top < 0) {
      out.push_back({body.name, body.name, false});
    } else if (seen.insert(top).second) {
      out.push_back({model.assemblies[top].name, body.name, steered.count(top) > 0});
    }
  }
  std::stable_partition(out.begin(), out.end(), [](const Followed& one) { return one.steered; });
  if (out.size() > kMostPaths) out.resize(kMostPaths);
  return out;
}

/// A tenth of the tolerance of a path: numbers stay short.
double rounded(double metres) { return std::round(metres * 1e6) / 1e6; }

void append(Json& to, const Vec3& point) {
  for (const double v : {point.x(), point.y(), point.z()}) to.push_back(rounded(v));
}

}  // namespace

void Path::end_at(double time, const Vec3& point) {
  times.push_back(time);
  points.push_back(point);
  low = Vec3::Constant(-std::numeric_limits<double>::infinity());
  high = -low;
}

void Path::add(double time, const Vec3& point) {
  if (times.empty()) {
    end_at(time, point);
  } else if (time <= last_time) {
    if (point == last) return;
    if (times.back() < last_time) end_at(last_time, last);
    end_at(time, point);
  } else {
    Vec3 speed = (point - points.back()) / (time - times.back());
    const bool passes =
        (speed.array() >= low.array()).all() && (speed.array() <= high.array()).all();
    if (!passes) end_at(last_time, last);
    const double since = time - times.back();
    const Vec3 slack = Vec3::Constant(tolerance);
    low = low.cwiseMax((point - slack - points.back()) / since);
    high = high.cwiseMin((point + slack - points.back()) / since);
  }
  last_time = time;
  last = point;
}

void Path::thin() {
  Path coarser;
  coarser.label = label;
  coarser.body = body;
  coarser.tolerance = kCoarser * tolerance;
  for (std::size_t i = 0; i < times.size(); ++i) coarser.add(times[i], points[i]);
  coarser.add(last_time, last);
  *this = std::move(coarser);
}

void Path::keep_newest(std::size_t most) {
  if (times.size() <= most) return;
  const auto old = static_cast<std::ptrdiff_t>(times.size() - most);
  times.erase(times.begin(), times.begin() + old);
  points.erase(points.begin(), points.begin() + old);
}

void Paths::follow(const SceneModel& model) {
  std::vector<Path> paths;
  bool same = true;
  for (const Followed& one : followed(model)) {
    const auto old = std::find_if(paths_.begin(), paths_.end(),
                                  [&](const Path& path) { return path.body == one.body; });
    Path path;
    if (old != paths_.end()) path = std::move(*old);
    same = same && path.label == one.label && paths.size() < paths_.size() &&
           old == paths_.begin() + static_cast<std::ptrdiff_t>(paths.size());
    path.label = one.label;
    path.body = one.body;
    paths.push_back(std::move(path));
  }
  if (!same || paths.size() != paths_.size()) ++revision_;
  paths_ = std::move(paths);
  indices_.clear();
  for (const Path& path : paths_) indices_.push_back(find_body(model, path.body));
}

void Paths::take(const Frame& frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (any_ && frame.time < until_) {
    ++revision_;
    paths_.clear();
    model_.reset();
  }
  if (frame.model != model_) {
    model_ = frame.model;
    follow(*model_);
  }
  any_ = true;
  until_ = frame.time;
  const std::size_t most =
      std::clamp(kMostPoints / std::max<std::size_t>(paths_.size(), 1), kFewestPoints, kMost);
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    const auto body = static_cast<std::size_t>(indices_[i]);
    if (indices_[i] < 0 || body >= frame.state.poses.size()) continue;
    const Vec3& p = frame.state.poses[body].p;
    if (!p.allFinite()) continue;
    paths_[i].add(frame.time, p);
    if (paths_[i].times.size() <= most) continue;
    ++revision_;
    while (paths_[i].times.size() > most / 2 && paths_[i].tolerance < kCoarsest) paths_[i].thin();
    paths_[i].keep_newest(most / 2);
  }
}

void Paths::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++revision_;
  model_.reset();
  paths_.clear();
  indices_.clear();
  any_ = false;
}

Json Paths::since(std::uint64_t revision, const std::vector<std::size_t>& counts) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Json list = Json::array();
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    const Path& path = paths_[i];
    const std::size_t known = revision == revision_ && i < counts.size() ? counts[i] : 0;
    const std::size_t from = std::min(known, path.times.size());
    Json times = Json::array(), points = Json::array(), last = Json::array();
    for (std::size_t k = from; k < path.times.size(); ++k) {
      times.push_back(path.times[k]);
      append(points, path.points[k]);
    }
    if (!path.times.empty()) append(last, path.last);
    list.push_back({{"label", path.label},
                    {"body", path.body},
                    {"from", from},
                    {"times", std::move(times)},
                    {"points", std::move(points)},
                    {"last", std::move(last)}});
  }
  return {
      {"revision", revision_}, {"until", any_ ? Json(until_) : Json()}, {"paths", std::move(list)}};
}

std::vector<Path> Paths::all() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<Path> out = paths_;
  for (Path& path : out) {
    if (path.times.empty() || path.last_time <= path.times.back()) continue;
    path.times.push_back(path.last_time);
    path.points.push_back(path.last);
  }
  return out;
}

}  // namespace cogrsim::studio
