#include "compare/compare.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <unordered_map>

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::cli {
namespace {

// The difference of two sets of coordinates of one joint; negative: the type has no such part.
struct JointGap {
  double distance = -1.0;
  double angle = -1.0;
};

JointGap joint_gap(JointType type, const double* a, const double* b) {
  const auto difference = [&](int i) { return std::fabs(a[i] - b[i]); };
  const auto turn = [](const double* p, const double* q) {
    return angle_between(Quat(p[0], p[1], p[2], p[3]), Quat(q[0], q[1], q[2], q[3]));
  };
  if (type == JointType::ball) return {-1.0, turn(a, b)};
  if (type == JointType::free) {
    return {std::hypot(difference(0), difference(1), difference(2)), turn(a + 3, b + 3)};
  }
  JointGap gap;
  for (int i = 0; i < speed_count(type); ++i) {
    if (axis_turns(type, i)) {
      gap.angle = std::max(difference(i), gap.angle);
    } else {
      gap.distance = std::hypot(std::max(gap.distance, 0.0), difference(i));
    }
  }
  return gap;
}

// Name to index of the elements of interest that are not removed.
template <class Elements, class Wanted>
std::unordered_map<std::string, int> indices(const Elements& elements, Wanted wanted) {
  std::unordered_map<std::string, int> out;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (!elements[i].removed && wanted(elements[i]))
      out.emplace(elements[i].name, static_cast<int>(i));
  }
  return out;
}

bool can_move(const Body& body) { return body.kind != BodyKind::static_body; }
bool has_coordinates(const Joint& joint) { return joint.type != JointType::fixed; }

void track(Drift& drift, double value, double change) {
  drift.end = value;
  drift.largest = std::max(drift.largest, change);
}

void track(Extreme& extreme, double value, double time, const std::string& where) {
  if (value <= extreme.value) return;
  extreme = {value, time, where};
}

// Joins values two by two, the later one stays.
void halve_later(std::vector<double>& values) {
  for (std::size_t i = 0; 2 * i + 1 < values.size(); ++i) values[i] = values[2 * i + 1];
  values.resize(values.size() / 2);
}

bool worse(const Difference& a, const Difference& b) { return a.severity > b.severity; }

}  // namespace

double angle_between(const Quat& a, const Quat& b) {
  const Quat turn = a.conjugate() * b;
  return 2.0 * std::atan2(turn.vec().norm(), std::fabs(turn.w()));
}

void Spread::add(double time, double value, std::size_t interval) {
  if (value > max || count_ == 0) {
    max = value;
    max_time = time;
  }
  // An element that came later, or was gone for a while, leaves a gap in its curve.
  while (curve.size() < interval) curve.push_back(std::nan(""));
  if (curve.size() == interval)
    curve.push_back(value);
  else
    curve[interval] = std::isnan(curve[interval]) ? value : std::max(curve[interval], value);
  end = value;
  sum_of_squares_ += value * value;
  ++count_;
}

void Spread::halve() {
  const std::size_t half = (curve.size() + 1) / 2;
  for (std::size_t i = 0; i < half; ++i) {
    const double first = curve[2 * i];
    const double second = 2 * i + 1 < curve.size() ? curve[2 * i + 1] : first;
    curve[i] = std::fmax(first, second);  // a gap yields to a value
  }
  curve.resize(half);
}

void Spread::finish() {
  if (count_ > 0) rms = std::sqrt(sum_of_squares_ / static_cast<double>(count_));
}

Comparison::Comparison(std::vector<std::string> runs, CompareOptions options) {
  assert(runs.size() >= 2 && options.curve_points > 0);
  const std::size_t others = runs.size() - 1;
  result_.options = options;
  result_.figures.resize(runs.size());
  result_.runs = std::move(runs);
  body_pairs_.resize(others);
  joint_pairs_.resize(others);
  body_index_.resize(others);
  joint_index_.resize(others);
}

// The end of a run is not known beforehand: when there are too many intervals they are joined.
void Comparison::halve_curves() {
  per_interval_ *= 2;
  halve_later(result_.times);
  for (RunFigures& figures : result_.figures) halve_later(figures.energy_curve);
  for (auto* differences : {&result_.bodies, &result_.joints}) {
    for (Difference& difference : *differences) {
      if (difference.distance) difference.distance->halve();
      if (difference.angle) difference.angle->halve();
    }
  }
}

void Comparison::pair_up(const std::vector<FramePtr>& frames) {
  const SceneModel& reference = *frames[0]->model;
  // Pairs keep the order of the reference, and find their statistics again by name.
  const auto pair = [&](const auto& elements, const auto& others, auto wanted, std::size_t run,
                        auto& index, auto& pairs, std::vector<Difference>& differences) {
    pairs.clear();
    const auto second = indices(others, wanted);
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const auto& element = elements[i];
      if (element.removed || !wanted(element)) continue;
      const auto found = second.find(element.name);
      if (found == second.end()) continue;
      const auto [entry, added] = index.emplace(element.name, differences.size());
      if (added) {
        Difference difference;
        difference.name = element.name;
        difference.run = run;
        differences.push_back(std::move(difference));
      }
      pairs.push_back({static_cast<int>(i), found->second, entry->second});
    }
  };
  std::set<std::string> lonely;
  for (std::size_t run = 1; run < frames.size(); ++run) {
    const SceneModel& other = *frames[run]->model;
    pair(reference.bodies, other.bodies, can_move, run, body_index_[run - 1], body_pairs_[run - 1],
         result_.bodies);
    pair(reference.joints, other.joints, has_coordinates, run, joint_index_[run - 1],
         joint_pairs_[run - 1], result_.joints);
    const auto first = indices(reference.bodies, can_move),
               second = indices(other.bodies, can_move);
    for (const auto& [name, i] : first) {
      if (second.count(name) == 0) lonely.insert(name);
    }
    for (const auto& [name, i] : second) {
      if (first.count(name) == 0) lonely.insert(name);
    }
  }
  result_.only_in_some.assign(lonely.begin(), lonely.end());
  models_.clear();
  for (const FramePtr& frame : frames) models_.push_back(frame->model);
}

void Comparison::add(double time, const std::vector<FramePtr>& frames) {
  assert(frames.size() == result_.runs.size());
  bool same = models_.size() == frames.size();
  for (std::size_t i = 0; same && i < frames.size(); ++i) same = models_[i] == frames[i]->model;
  if (!same) pair_up(frames);

  if (result_.samples / per_interval_ >=
      2 * static_cast<std::size_t>(result_.options.curve_points)) {
    halve_curves();
  }
  const std::size_t interval = result_.samples / per_interval_;
  if (result_.times.size() <= interval)
    result_.times.push_back(time);
  else
    result_.times[interval] = time;
  for (std::size_t run = 0; run < frames.size(); ++run) add_figures(time, *frames[run], run);
  for (std::size_t run = 1; run < frames.size(); ++run) {
    add_bodies(time, *frames[0], *frames[run], run);
    add_joints(time, *frames[0], *frames[run], run);
  }
  result_.end_time = time;
  ++result_.samples;
}

void Comparison::note_over(Difference& difference, double time, double distance, double angle) {
  const double excess = std::max(distance / result_.options.position_threshold,
                                 angle / result_.options.angle_threshold);
  difference.severity = std::max(difference.severity, excess);
  if (excess <= 1.0 || difference.first_over) return;
  difference.first_over = time;
  const bool counts = difference.run + result_.options.twins < result_.runs.size();
  if (counts && !result_.first_over) {
    result_.first_over = time;
    result_.first_over_name = difference.name;
  }
}

void Comparison::add_bodies(double time, const Frame& first, const Frame& second, std::size_t run) {
  const std::size_t interval = result_.samples / per_interval_;
  for (const Pair& pair : body_pairs_[run - 1]) {
    Difference& difference = result_.bodies[pair.difference];
    const Pose& a = first.state.poses[pair.first];
    const Pose& b = second.state.poses[pair.second];
    const double distance = (a.p - b.p).norm(), angle = angle_between(a.q, b.q);
    if (!difference.distance) {
      difference.distance.emplace();
      difference.angle.emplace();
    }
    difference.distance->add(time, distance, interval);
    difference.angle->add(time, angle, interval);
    note_over(difference, time, distance, angle);
  }
}

void Comparison::add_joints(double time, const Frame& first, const Frame& second, std::size_t run) {
  const std::size_t interval = result_.samples / per_interval_;
  for (const Pair& pair : joint_pairs_[run - 1]) {
    Difference& difference = result_.joints[pair.difference];
    const Joint& a = first.model->joints[pair.first];
    const Joint& b = second.model->joints[pair.second];
    if (a.type != b.type) continue;
    difference.type = to_string(a.type);
    const JointGap gap = joint_gap(a.type, first.state.joint_positions.data() + a.position_offset,
                                   second.state.joint_positions.data() + b.position_offset);
    const auto add_part = [&](std::optional<Spread>& spread, double value) {
      if (value < 0.0) return;
      if (!spread) spread.emplace();
      spread->add(time, value, interval);
    };
    add_part(difference.distance, gap.distance);
    add_part(difference.angle, gap.angle);
    note_over(difference, time, gap.distance, gap.angle);
  }
}

void Comparison::add_figures(double time, const Frame& frame, std::size_t run) {
  const SceneModel& model = *frame.model;
  RunFigures& figures = result_.figures[run];
  const Energy parts = energy_of(model, frame.state);
  const double energy = parts.kinetic + parts.potential;
  const Momentum momentum = momentum_of(model, frame.state);
  if (result_.samples == 0) {
    starts_.push_back({energy, momentum});
    contact_sums_.push_back(0.0);
    figures.energy.start = energy;
    figures.linear_momentum.start = momentum.linear.norm();
    figures.angular_momentum.start = momentum.angular.norm();
  }
  const Start& start = starts_[run];
  track(figures.energy, energy, std::fabs(energy - start.energy));
  track(figures.linear_momentum, momentum.linear.norm(),
        (momentum.linear - start.momentum.linear).norm());
  track(figures.angular_momentum, momentum.angular.norm(),
        (momentum.angular - start.momentum.angular).norm());
  const std::size_t interval = result_.samples / per_interval_;
  if (figures.energy_curve.size() <= interval)
    figures.energy_curve.push_back(energy);
  else
    figures.energy_curve[interval] = energy;

  // contacts are those of the step that led here
  contact_sums_[run] += static_cast<double>(frame.contacts.size());
  figures.most_contacts = std::max(figures.most_contacts, frame.contacts.size());
  figures.end_contacts = frame.contacts.size();
  for (const Contact& contact : frame.contacts) {
    if (contact.depth <= figures.penetration.value) continue;
    track(figures.penetration, contact.depth, time,
          model.bodies[contact.body_a].name + " and " + model.bodies[contact.body_b].name);
  }

  const auto pose = [&](int body) { return body == kWorld ? Pose() : frame.state.poses[body]; };
  for (const Joint& joint : model.joints) {
    if (joint.removed) continue;
    const JointError error =
        joint_error(joint, relative_pose(joint, pose(joint.parent), pose(joint.child)));
    track(figures.joint_distance, error.distance, time, joint.name);
    track(figures.joint_angle, error.angle, time, joint.name);
  }
}

CompareResult Comparison::finish() {
  for (std::size_t run = 0; run < result_.figures.size(); ++run) {
    if (result_.samples == 0) break;
    result_.figures[run].mean_contacts = contact_sums_[run] / static_cast<double>(result_.samples);
  }
  for (auto* differences : {&result_.bodies, &result_.joints}) {
    for (Difference& difference : *differences) {
      if (difference.distance) difference.distance->finish();
      if (difference.angle) difference.angle->finish();
    }
    std::stable_sort(differences->begin(), differences->end(), worse);
  }
  return std::move(result_);
}

}  // namespace cogrsim::cli
