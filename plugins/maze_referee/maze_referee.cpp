// Adds obstacles to a maze while a robot drives through it, and evaluates the run. See README.md.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/control/supervisor.h"
#include "cogrsim/core/constants.h"
#include "hindsight.h"

namespace maze_referee {
namespace {

using cogrsim::Frame;
using cogrsim::kNaN;
using cogrsim::kPi;
using cogrsim::Pose;
using cogrsim::SceneModel;
using cogrsim::SupervisorContext;
using cogrsim::Vec3;

constexpr double kNever = std::numeric_limits<double>::infinity();
/// Number of updates after a request until an obstacle exists or was rejected.
constexpr int kRefused = 3;

/// An obstacle, drawn before the run so that it is the same on every backend.
struct Obstacle {
  std::string name, of;
  bool cube = false;
  double time = 0.0;         ///< time at which it appears [s]
  double lifetime = kNever;  ///< [s]
  double x = 0.0, y = 0.0;   ///< offset from the centre of the cell [m]
  double yaw = 0.0;          ///< [rad]
  std::vector<int> cells;    ///< candidate cells in the order of trial
  std::size_t tried = 0;     ///< number of tried cells
  int asked = 0;             ///< number of updates since the request; 0: not requested
  bool there = false;
  Cell cell;
};

template <class Type>
Type parameter(const SupervisorContext& context, const std::string& name) {
  return std::get<Type>(*context.parameter(name));
}

class MazeReferee final : public cogrsim::Supervisor {
 public:
  cogrsim::FrameContents needs() const override {
    cogrsim::FrameContents contents;
    contents.contacts = true;
    return contents;
  }
  void configure(SupervisorContext& context) override;
  void update(const cogrsim::Tick& tick, SupervisorContext& context) override;
  std::optional<std::string> save() const override;
  void restore(const std::string& memory) override;

 private:
  void draw_obstacles(SupervisorContext& context);
  void watch_model(const cogrsim::SceneModelPtr& model);
  cogrsim::Side heading_of(const cogrsim::Quat& q) const;
  void follow_robot(const Frame& frame, SupervisorContext& context);
  void count_touches(const Frame& frame);
  void place_obstacles(const Frame& frame, SupervisorContext& context);
  bool fits(const Frame& frame, const Obstacle& obstacle, const Cell& cell) const;
  void ask_for(Obstacle& obstacle, SupervisorContext& context);
  std::vector<Cube> cubes() const;
  void publish(SupervisorContext& context);

  cogrsim::MazeModel maze_;
  Task task_;
  std::string robot_, cube_template_, ball_template_;
  Pace pace_;
  double arrival_ = 0.03, cube_height_ = 0.2, ball_radius_ = 0.06;
  bool end_run_ = true;

  std::vector<Obstacle> obstacles_;
  cogrsim::SceneModelPtr model_;
  int base_ = -1;
  enum class Part : char { none, robot, cube };
  std::vector<Part> parts_;  // of every body
  std::vector<int> balls_;   // bodies

  Cell at_;
  bool started_ = false, touching_ = false, ending_ = false;
  Vec3 last_ = Vec3::Zero();
  double path_ = 0.0;  // [m]
  int touched_ = 0;
  double trigger_time_ = kNaN, goal_time_ = kNaN;  // [s]
  double optimum_ = kNaN;                          // [m]
  std::optional<std::size_t> judged_;              // number of cubes for which it was computed
};

void MazeReferee::configure(SupervisorContext& context) {
  const SceneModel& model = *context.frame().model;
  const auto name = parameter<std::string>(context, "maze");
  const auto maze = std::find_if(model.mazes.begin(), model.mazes.end(), [&](const auto& m) {
    return name.empty() ? model.mazes.size() == 1 : m.name == name;
  });
  if (maze == model.mazes.end()) {
    throw std::runtime_error(name.empty() ? "there is not just one maze: name it ('maze')"
                                          : "there is no maze '" + name + "'");
  }
  maze_ = *maze;
  const auto cell = [&](const char* which) {
    const auto found = cogrsim::find_cell(maze_, parameter<std::string>(context, which));
    if (!found) throw std::runtime_error(std::string(which) + ": " + found.error().text());
    return *found;
  };
  task_ = {cell("start"), cell("trigger"), cell("goal")};
  robot_ = parameter<std::string>(context, "robot");
  if (cogrsim::find_assembly(model, robot_) < 0) {
    throw std::runtime_error("there is no assembly '" + robot_ + "' to observe");
  }
  const double speed = parameter<double>(context, "speed"),
               turn_rate = parameter<double>(context, "turn_rate"),
               turn_acceleration = parameter<double>(context, "turn_acceleration");
  // Time of a turn from rest to rest, and the time lost by braking before it and accelerating
  // again.
  const auto turn = [&](double angle) {
    const double ramps = turn_rate * turn_rate / turn_acceleration;  // angle during both ramps
    const double turning = angle > ramps ? angle / turn_rate + turn_rate / turn_acceleration
                                         : 2 * std::sqrt(angle / turn_acceleration);
    return turning + speed / parameter<double>(context, "acceleration");
  };
  pace_ = {maze_.cell / speed, turn(kPi / 2), turn(kPi), {}};
  arrival_ = parameter<double>(context, "arrival");
  cube_height_ = parameter<double>(context, "cube");
  ball_radius_ = parameter<double>(context, "ball");
  end_run_ = parameter<bool>(context, "end_run");
  draw_obstacles(context);
  publish(context);
}

void MazeReferee::draw_obstacles(SupervisorContext& context) {
  const auto cubes = parameter<std::int64_t>(context, "cubes");
  const auto balls = parameter<std::int64_t>(context, "balls");
  const double from = parameter<double>(context, "from");
  const double until = parameter<double>(context, "until");
  if (until < from) throw std::runtime_error("'until' is before 'from'");
  std::vector<int> free;
  for (int i = 0; i < maze_.rows * maze_.columns; ++i) {
    const Cell cell{i / maze_.columns, i % maze_.columns};
    const bool named =
        std::any_of(maze_.named_cells.begin(), maze_.named_cells.end(),
                    [&](const auto& p) { return p.row == cell.row && p.column == cell.column; });
    if (!named) free.push_back(i);
  }
  for (std::int64_t i = 0; i < cubes + balls; ++i) {
    Obstacle one;
    one.cube = i < cubes;
    const std::int64_t number = one.cube ? i + 1 : i - cubes + 1;
    one.name = (one.cube ? "cube_" : "ball_") + std::to_string(number);
    one.of = parameter<std::string>(context, one.cube ? "cube_template" : "ball_template");
    one.time = context.uniform(from, until);
    // Drawn for cubes, too, so that the number of draws does not depend on the kind.
    const double odds = context.uniform(0.0, 1.0), lifetime = context.uniform(4.0, 12.0);
    if (!one.cube && odds < parameter<double>(context, "vanishing")) one.lifetime = lifetime;
    const double scatter = parameter<double>(context, "scatter");
    one.x = context.uniform(-scatter, scatter);
    one.y = context.uniform(-scatter, scatter);
    one.yaw = context.uniform(-0.3, 0.3);
    one.cells = free;
    // Fisher and Yates.
    for (std::size_t k = one.cells.size(); k > 1; --k) {
      const auto pick = static_cast<std::size_t>(context.uniform(0.0, static_cast<double>(k)));
      std::swap(one.cells[k - 1], one.cells[std::min(pick, k - 1)]);
    }
    obstacles_.push_back(std::move(one));
  }
  std::stable_sort(obstacles_.begin(), obstacles_.end(),
                   [](const Obstacle& a, const Obstacle& b) { return a.time < b.time; });
}

// Bodies keep their indices, so these data are updated only when the model changes.
void MazeReferee::watch_model(const cogrsim::SceneModelPtr& model) {
  if (model == model_) return;
  model_ = model;
  parts_.assign(model->bodies.size(), Part::none);
  const int robot = cogrsim::find_assembly(*model, robot_);
  if (robot < 0) throw std::runtime_error("'" + robot_ + "' was removed");
  const std::vector<int> own = cogrsim::bodies_of(*model, robot);
  if (own.empty()) throw std::runtime_error("'" + robot_ + "' has no body");
  base_ = own.front();
  for (const int body : own) parts_[body] = Part::robot;
  balls_.clear();
  for (const Obstacle& obstacle : obstacles_) {
    const int assembly = cogrsim::find_assembly(*model, obstacle.name);
    if (assembly < 0) continue;
    for (const int body : cogrsim::bodies_of(*model, assembly)) {
      if (obstacle.cube) {
        parts_[body] = Part::cube;
      } else {
        balls_.push_back(body);
      }
    }
  }
}

std::vector<Cube> MazeReferee::cubes() const {
  std::vector<Cube> out;
  for (const Obstacle& one : obstacles_) {
    if (one.cube && one.there) out.push_back({one.cell, one.time});
  }
  return out;
}

// The direction of the maze that is closest to the x axis of a body.
cogrsim::Side MazeReferee::heading_of(const cogrsim::Quat& q) const {
  const Vec3 forward = maze_.X_WM.q.conjugate() * (q * Vec3::UnitX());
  if (std::abs(forward.x()) > std::abs(forward.y())) {
    return forward.x() > 0 ? cogrsim::Side::east : cogrsim::Side::west;
  }
  return forward.y() > 0 ? cogrsim::Side::north : cogrsim::Side::south;
}

void MazeReferee::follow_robot(const Frame& frame, SupervisorContext& context) {
  const Vec3 position = frame.state.poses[base_].p;
  if (!started_) pace_.heading = heading_of(frame.state.poses[base_].q);
  if (started_) path_ += (position - last_).head<2>().norm();
  started_ = true;
  last_ = position;
  if (const auto cell = cogrsim::cell_at(maze_, position)) at_ = *cell;
  if (std::isnan(trigger_time_) && at_ == task_.trigger) trigger_time_ = frame.time;
  if (!std::isnan(trigger_time_) && std::isnan(goal_time_) &&
      (position - cogrsim::centre_of(maze_, task_.goal)).head<2>().norm() < arrival_) {
    goal_time_ = frame.time;
    context.report("the robot is at the goal");
  }
}

void MazeReferee::count_touches(const Frame& frame) {
  const auto part = [&](int body) { return body < 0 ? Part::none : parts_[body]; };
  const bool touching =
      std::any_of(frame.contacts.begin(), frame.contacts.end(), [&](const cogrsim::Contact& c) {
        const Part a = part(c.body_a), b = part(c.body_b);
        return ((a == Part::robot && b == Part::cube) || (a == Part::cube && b == Part::robot)) &&
               (c.depth >= 0.0 || c.force.norm() > 0.0);
      });
  if (touching && !touching_) ++touched_;
  touching_ = touching;
}

// Fair positions: no obstacle appears in the cell of the robot or next to it, on another obstacle,
// or so that no path remains.
bool MazeReferee::fits(const Frame& frame, const Obstacle& obstacle, const Cell& cell) const {
  if (std::abs(cell.row - at_.row) <= 1 && std::abs(cell.column - at_.column) <= 1) return false;
  std::vector<Cube> all;
  for (const Obstacle& one : obstacles_) {
    if (!one.there && one.asked == 0) continue;
    if (one.cube && one.cell == cell) return false;
    if (one.cube) all.push_back({one.cell, one.time});
  }
  for (const int ball : balls_) {
    if (model_->bodies[ball].removed) continue;
    const auto there = cogrsim::cell_at(maze_, frame.state.poses[ball].p);
    if (there && *there == cell) return false;
  }
  if (!obstacle.cube) return true;
  all.push_back({cell, frame.time});
  return can_be_done(maze_, task_, at_, !std::isnan(trigger_time_), all);
}

void MazeReferee::ask_for(Obstacle& obstacle, SupervisorContext& context) {
  // Slightly above the floor, so that it does not overlap the floor.
  const double up = 1e-3 + (obstacle.cube ? cube_height_ / 2 : ball_radius_);
  const Vec3 p_M =
      maze_.centre(obstacle.cell.row, obstacle.cell.column) + Vec3(obstacle.x, obstacle.y, up);
  const cogrsim::Quat turn(Eigen::AngleAxisd(obstacle.yaw, Vec3::UnitZ()));
  cogrsim::Spawn spawn;
  spawn.of = obstacle.of;
  spawn.name = obstacle.name;
  spawn.pose = maze_.X_WM * Pose(p_M, turn);
  spawn.lifetime = obstacle.lifetime;
  context.send(spawn);
  obstacle.asked = 1;
}

void MazeReferee::place_obstacles(const Frame& frame, SupervisorContext& context) {
  for (Obstacle& one : obstacles_) {
    if (one.there || one.time > frame.time) continue;
    // In a run that is resumed without the state of the referee, some obstacles already exist.
    const int there = one.asked == 0 ? cogrsim::find_assembly(*model_, one.name) : -1;
    if (there >= 0) {
      const std::vector<int> bodies = cogrsim::bodies_of(*model_, there);
      if (!bodies.empty()) {
        const auto body = static_cast<std::size_t>(bodies.front());
        if (const auto cell = cogrsim::cell_at(maze_, frame.state.poses[body].p)) one.cell = *cell;
      }
      one.there = true;
      continue;
    }
    if (one.asked > 0) {
      if (cogrsim::find_assembly(*model_, one.name) >= 0) {
        one.there = true;
        one.time = frame.time;
      } else if (++one.asked > kRefused) {
        one.asked = 0;
      }
      continue;
    }
    // An occupied cell may become free later, so the list is repeated.
    for (std::size_t i = 0; i < one.cells.size(); ++i) {
      const int index = one.cells[one.tried % one.cells.size()];
      ++one.tried;
      one.cell = {index / maze_.columns, index % maze_.columns};
      if (!fits(frame, one, one.cell)) continue;
      ask_for(one, context);
      return;  // one at a time, so that the next check includes this obstacle
    }
  }
}

void MazeReferee::publish(SupervisorContext& context) {
  const std::vector<Cube> known = cubes();
  if (!judged_ || *judged_ != known.size()) {
    const auto steps = fewest_steps(maze_, task_, known, pace_);
    optimum_ = steps ? *steps * maze_.cell : kNaN;
    judged_ = known.size();
  }
  const bool arrived = !std::isnan(goal_time_);
  context.publish("success", arrived && touched_ == 0 ? 1.0 : 0.0);
  context.publish("arrived", arrived ? 1.0 : 0.0);
  context.publish("path", path_);
  context.publish("optimum", optimum_);
  context.publish("ratio", arrived ? path_ / optimum_ : kNaN);
  context.publish("touched", touched_);
  context.publish("time_to_trigger", trigger_time_);
  context.publish("time_to_goal", goal_time_);
  context.publish("obstacles", static_cast<double>(
                                   std::count_if(obstacles_.begin(), obstacles_.end(),
                                                 [](const Obstacle& one) { return one.there; })));
}

void MazeReferee::update(const cogrsim::Tick&, SupervisorContext& context) {
  if (ending_) {
    // The result was published in the frame before.
    context.send(cogrsim::EndRun{"the goal is reached"});
    return;
  }
  const Frame& frame = context.frame();
  watch_model(frame.model);
  follow_robot(frame, context);
  count_touches(frame);
  place_obstacles(frame, context);
  publish(context);
  ending_ = end_run_ && !std::isnan(goal_time_);
}

// The state of the run so far; the future is drawn again from the same seed.
std::optional<std::string> MazeReferee::save() const {
  std::ostringstream out;
  out.precision(17);
  out << "maze_referee 1 " << obstacles_.size() << ' ' << started_ << ' ' << touching_ << ' '
      << touched_ << ' ' << path_ << ' ' << trigger_time_ << ' ' << goal_time_ << ' ' << last_.x()
      << ' ' << last_.y() << ' ' << last_.z() << ' '
      << (pace_.heading ? static_cast<int>(*pace_.heading) : -1) << ' ' << at_.row << ' '
      << at_.column << '\n';
  for (const Obstacle& one : obstacles_) {
    out << one.name << ' ' << one.there << ' ' << one.time << ' ' << one.tried << ' '
        << one.cell.row << ' ' << one.cell.column << '\n';
  }
  return out.str();
}

void MazeReferee::restore(const std::string& memory) {
  std::istringstream in(memory);
  const auto token = [&] {
    std::string text;
    if (!(in >> text)) throw std::runtime_error("the state of the referee ends too early");
    return text;
  };
  // Not with >>, which cannot read the texts "nan" and "inf".
  const auto number = [&] {
    const std::string text = token();
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (*end != '\0') throw std::runtime_error("'" + text + "' is not a number");
    return value;
  };
  const auto whole = [&] {
    const double value = number();
    if (!(std::abs(value) < 1e9)) throw std::runtime_error("a count is out of range");
    return static_cast<int>(value);
  };
  const auto cell = [&] {
    Cell out{whole(), 0};
    out.column = whole();
    if (out.row < 0 || out.row >= maze_.rows || out.column < 0 || out.column >= maze_.columns) {
      throw std::runtime_error("the snapshot has a cell that is not in this maze");
    }
    return out;
  };
  if (token() != "maze_referee" || whole() != 1) {
    throw std::runtime_error("this is not the state of a maze_referee");
  }
  if (number() != static_cast<double>(obstacles_.size())) {
    throw std::runtime_error("the snapshot has another number of obstacles");
  }
  started_ = whole() != 0;
  touching_ = whole() != 0;
  touched_ = whole();
  path_ = number();
  trigger_time_ = number();
  goal_time_ = number();
  for (int i = 0; i < 3; ++i) last_[i] = number();
  const int heading = whole();
  if (heading >= 0 && heading < 4) pace_.heading = static_cast<cogrsim::Side>(heading);
  at_ = cell();
  for (Obstacle& one : obstacles_) {
    if (token() != one.name) throw std::runtime_error("the snapshot has other obstacles");
    one.there = whole() != 0;
    one.time = number();
    one.tried = static_cast<std::size_t>(std::max(0, whole()));
    one.cell = cell();
  }
}

}  // namespace
}  // namespace maze_referee

COGRSIM_SUPERVISOR(
    maze_referee::MazeReferee, "maze_referee", version("1.0.0"), author("CogRSim"),
    summary("adds cubes and balls to a maze while a robot drives, and evaluates the run"),
    parameter("maze", "", "name of the maze; empty: the only one"),
    parameter("robot", "bot", "the observed assembly"),
    parameter("start", "", "cell in which it starts: a named cell, or \"r2c5\"").must_be_set(),
    parameter("trigger", "", "cell it must visit first").must_be_set(),
    parameter("goal", "", "cell at which the run ends").must_be_set(),
    parameter("speed", 0.5, "m/s", "highest speed of the robot, for the optimum").range(0.01, 10.0),
    parameter("acceleration", 2.0, "m/s^2", "the same").range(0.01, 100.0),
    parameter("turn_rate", 6.0, "rad/s", "the same").range(0.1, 100.0),
    parameter("turn_acceleration", 30.0, "rad/s^2", "the same").range(0.1, 1000.0),
    parameter("arrival", 0.03, "m", "distance from its centre at which the goal is reached")
        .range(1e-3, 1.0),
    parameter("cubes", 5, "number of cubes that appear").range(0, 200),
    parameter("balls", 4, "number of balls that appear").range(0, 200),
    parameter("from", 1.0, "s", "no obstacle appears earlier").range(0.0, 1e6),
    parameter("until", 15.0, "s", "time by which the last appears").range(0.0, 1e6),
    parameter("vanishing", 0.5, "1", "fraction of the balls that vanish after 4 s to 12 s")
        .range(0.0, 1.0),
    parameter("scatter", 0.03, "m", "largest offset of an obstacle from the centre of its cell")
        .range(0.0, 1.0),
    parameter("cube", 0.2, "m", "edge of the cubes").range(0.01, 2.0),
    parameter("ball", 0.06, "m", "radius of the balls").range(0.005, 1.0),
    parameter("cube_template", "Cube", "template of the cubes"),
    parameter("ball_template", "Ball", "template of the balls"),
    parameter("end_run", true, "the run ends at the goal"),
    output("success", "1", "1 if the goal is reached and no cube was touched"),
    output("arrived", "1", "1 if the goal is reached"),
    output("path", "m", "distance driven so far"),
    output("optimum", "m", "length of the shortest path in hindsight"),
    output("ratio", "1", "path / optimum, once the goal is reached"),
    output("touched", "1", "number of times it touched a cube"),
    output("time_to_trigger", "s", "time at which the trigger was reached"),
    output("time_to_goal", "s", "time at which the goal was reached"),
    output("obstacles", "1", "number of obstacles so far"))
