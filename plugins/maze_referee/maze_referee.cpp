// Puts obstacles into a maze while a robot drives through it, and judges the run. See README.md.
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
using cogrsim::Stage;
using cogrsim::Vec3;

constexpr double kNever = std::numeric_limits<double>::infinity();
/// So many updates after it was asked for, an obstacle is there or was refused.
constexpr int kRefused = 3;

/// An obstacle as it was drawn before the run, so that it is the same on every backend.
struct Obstacle {
  std::string name, of;
  bool cube = false;
  double time = 0.0;         ///< when it is to appear [s]
  double lifetime = kNever;  ///< [s]
  double x = 0.0, y = 0.0;   ///< off the cell's middle [m]
  double yaw = 0.0;          ///< [rad]
  std::vector<int> cells;    ///< to be tried, in this order
  std::size_t tried = 0;     ///< of them
  int asked = 0;             ///< updates since it was asked for; 0: not yet
  bool there = false;
  Cell cell;
};

template <class Type>
Type parameter(const Stage& stage, const std::string& name) {
  return std::get<Type>(*stage.parameter(name));
}

class MazeReferee final : public cogrsim::Supervisor {
 public:
  cogrsim::FrameContents needs() const override {
    cogrsim::FrameContents contents;
    contents.contacts = true;
    return contents;
  }
  void configure(Stage& stage) override;
  void update(const cogrsim::Tick& tick, Stage& stage) override;
  std::optional<std::string> save() const override;
  void restore(const std::string& memory) override;

 private:
  void draw_obstacles(Stage& stage);
  void watch_model(const cogrsim::SceneModelPtr& model);
  cogrsim::Side looks(const cogrsim::Quat& q) const;
  void follow_robot(const Frame& frame, Stage& stage);
  void count_touches(const Frame& frame);
  void place_obstacles(const Frame& frame, Stage& stage);
  bool fits(const Frame& frame, const Obstacle& obstacle, const Cell& cell) const;
  void ask_for(Obstacle& obstacle, Stage& stage);
  std::vector<Cube> cubes() const;
  void publish(Stage& stage);

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
  std::optional<std::size_t> judged_;              // cubes it was found with
};

void MazeReferee::configure(Stage& stage) {
  const SceneModel& model = *stage.frame().model;
  const auto name = parameter<std::string>(stage, "maze");
  const auto maze = std::find_if(model.mazes.begin(), model.mazes.end(), [&](const auto& m) {
    return name.empty() ? model.mazes.size() == 1 : m.name == name;
  });
  if (maze == model.mazes.end()) {
    throw std::runtime_error(name.empty() ? "there is not just one maze: name it ('maze')"
                                          : "there is no maze '" + name + "'");
  }
  maze_ = *maze;
  const auto cell = [&](const char* which) {
    const auto found = cogrsim::find_cell(maze_, parameter<std::string>(stage, which));
    if (!found) throw std::runtime_error(std::string(which) + ": " + found.error().text());
    return *found;
  };
  task_ = {cell("start"), cell("trigger"), cell("goal")};
  robot_ = parameter<std::string>(stage, "robot");
  if (cogrsim::find_assembly(model, robot_) < 0) {
    throw std::runtime_error("there is no assembly '" + robot_ + "' to watch");
  }
  const double speed = parameter<double>(stage, "speed"),
               turn_rate = parameter<double>(stage, "turn_rate"),
               turn_acceleration = parameter<double>(stage, "turn_acceleration");
  // Turning by an angle from rest to rest, and the time that braking before it and starting again
  // lose against full speed.
  const auto turn = [&](double angle) {
    const double ramps = turn_rate * turn_rate / turn_acceleration;  // turned while both last
    const double turning = angle > ramps ? angle / turn_rate + turn_rate / turn_acceleration
                                         : 2 * std::sqrt(angle / turn_acceleration);
    return turning + speed / parameter<double>(stage, "acceleration");
  };
  pace_ = {maze_.cell / speed, turn(kPi / 2), turn(kPi), {}};
  arrival_ = parameter<double>(stage, "arrival");
  cube_height_ = parameter<double>(stage, "cube");
  ball_radius_ = parameter<double>(stage, "ball");
  end_run_ = parameter<bool>(stage, "end_run");
  draw_obstacles(stage);
  publish(stage);
}

void MazeReferee::draw_obstacles(Stage& stage) {
  const auto cubes = parameter<std::int64_t>(stage, "cubes");
  const auto balls = parameter<std::int64_t>(stage, "balls");
  const double from = parameter<double>(stage, "from"), until = parameter<double>(stage, "until");
  if (until < from) throw std::runtime_error("'until' is before 'from'");
  std::vector<int> free;
  for (int i = 0; i < maze_.rows * maze_.columns; ++i) {
    const Cell cell{i / maze_.columns, i % maze_.columns};
    const bool named = std::any_of(
        maze_.places.begin(), maze_.places.end(),
        [&](const auto& place) { return place.row == cell.row && place.column == cell.column; });
    if (!named) free.push_back(i);
  }
  for (std::int64_t i = 0; i < cubes + balls; ++i) {
    Obstacle one;
    one.cube = i < cubes;
    const std::int64_t number = one.cube ? i + 1 : i - cubes + 1;
    one.name = (one.cube ? "cube_" : "ball_") + std::to_string(number);
    one.of = parameter<std::string>(stage, one.cube ? "cube_template" : "ball_template");
    one.time = stage.uniform(from, until);
    // Drawn for cubes too, so that the number of draws does not depend on what it is.
    const double odds = stage.uniform(0.0, 1.0), lifetime = stage.uniform(4.0, 12.0);
    if (!one.cube && odds < parameter<double>(stage, "vanishing")) one.lifetime = lifetime;
    const double scatter = parameter<double>(stage, "scatter");
    one.x = stage.uniform(-scatter, scatter);
    one.y = stage.uniform(-scatter, scatter);
    one.yaw = stage.uniform(-0.3, 0.3);
    one.cells = free;
    // Fisher and Yates.
    for (std::size_t k = one.cells.size(); k > 1; --k) {
      const auto pick = static_cast<std::size_t>(stage.uniform(0.0, static_cast<double>(k)));
      std::swap(one.cells[k - 1], one.cells[std::min(pick, k - 1)]);
    }
    obstacles_.push_back(std::move(one));
  }
  std::stable_sort(obstacles_.begin(), obstacles_.end(),
                   [](const Obstacle& a, const Obstacle& b) { return a.time < b.time; });
}

// Bodies keep their indices, so what is known of them is renewed only when the model changes.
void MazeReferee::watch_model(const cogrsim::SceneModelPtr& model) {
  if (model == model_) return;
  model_ = model;
  parts_.assign(model->bodies.size(), Part::none);
  const int robot = cogrsim::find_assembly(*model, robot_);
  if (robot < 0) throw std::runtime_error("'" + robot_ + "' is gone");
  const std::vector<int> own = cogrsim::bodies_of(*model, robot);
  if (own.empty()) throw std::runtime_error("'" + robot_ + "' has no body");
  base_ = own.front();
  for (const int body : own) parts_[static_cast<std::size_t>(body)] = Part::robot;
  balls_.clear();
  for (const Obstacle& obstacle : obstacles_) {
    const int assembly = cogrsim::find_assembly(*model, obstacle.name);
    if (assembly < 0) continue;
    for (const int body : cogrsim::bodies_of(*model, assembly)) {
      if (obstacle.cube) {
        parts_[static_cast<std::size_t>(body)] = Part::cube;
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

// Which of the four directions of the maze is nearest to a body's x axis.
cogrsim::Side MazeReferee::looks(const cogrsim::Quat& q) const {
  const Vec3 forward = maze_.X_WM.q.conjugate() * (q * Vec3::UnitX());
  if (std::abs(forward.x()) > std::abs(forward.y())) {
    return forward.x() > 0 ? cogrsim::Side::east : cogrsim::Side::west;
  }
  return forward.y() > 0 ? cogrsim::Side::north : cogrsim::Side::south;
}

void MazeReferee::follow_robot(const Frame& frame, Stage& stage) {
  const Vec3 place = frame.state.poses[static_cast<std::size_t>(base_)].p;
  if (!started_) pace_.heading = looks(frame.state.poses[static_cast<std::size_t>(base_)].q);
  if (started_) path_ += (place - last_).head<2>().norm();
  started_ = true;
  last_ = place;
  if (const auto cell = cogrsim::cell_at(maze_, place)) at_ = *cell;
  if (std::isnan(trigger_time_) && at_ == task_.trigger) trigger_time_ = frame.time;
  if (!std::isnan(trigger_time_) && std::isnan(goal_time_) &&
      (place - cogrsim::centre_of(maze_, task_.goal)).head<2>().norm() < arrival_) {
    goal_time_ = frame.time;
    stage.report("the robot is at the goal");
  }
}

void MazeReferee::count_touches(const Frame& frame) {
  const auto part = [&](int body) {
    return body < 0 ? Part::none : parts_[static_cast<std::size_t>(body)];
  };
  const bool touching =
      std::any_of(frame.contacts.begin(), frame.contacts.end(), [&](const cogrsim::Contact& c) {
        const Part a = part(c.body_a), b = part(c.body_b);
        return ((a == Part::robot && b == Part::cube) || (a == Part::cube && b == Part::robot)) &&
               (c.depth >= 0.0 || c.force.norm() > 0.0);
      });
  if (touching && !touching_) ++touched_;
  touching_ = touching;
}

// A fair experimenter: nothing appears where the robot is or next to it, on another obstacle, or so
// that no way is left.
bool MazeReferee::fits(const Frame& frame, const Obstacle& obstacle, const Cell& cell) const {
  if (std::abs(cell.row - at_.row) <= 1 && std::abs(cell.column - at_.column) <= 1) return false;
  std::vector<Cube> all;
  for (const Obstacle& one : obstacles_) {
    if (!one.there && one.asked == 0) continue;
    if (one.cube && one.cell == cell) return false;
    if (one.cube) all.push_back({one.cell, one.time});
  }
  for (const int ball : balls_) {
    if (model_->bodies[static_cast<std::size_t>(ball)].removed) continue;
    const auto there = cogrsim::cell_at(maze_, frame.state.poses[static_cast<std::size_t>(ball)].p);
    if (there && *there == cell) return false;
  }
  if (!obstacle.cube) return true;
  all.push_back({cell, frame.time});
  return can_be_done(maze_, task_, at_, !std::isnan(trigger_time_), all);
}

void MazeReferee::ask_for(Obstacle& obstacle, Stage& stage) {
  // A hair above the floor: it must not count as standing in it.
  const double up = 1e-3 + (obstacle.cube ? cube_height_ / 2 : ball_radius_);
  const Vec3 p_M =
      maze_.centre(obstacle.cell.row, obstacle.cell.column) + Vec3(obstacle.x, obstacle.y, up);
  const cogrsim::Quat turn(Eigen::AngleAxisd(obstacle.yaw, Vec3::UnitZ()));
  cogrsim::Spawn spawn;
  spawn.of = obstacle.of;
  spawn.name = obstacle.name;
  spawn.pose = maze_.X_WM * Pose(p_M, turn);
  spawn.lifetime = obstacle.lifetime;
  stage.send(spawn);
  obstacle.asked = 1;
}

void MazeReferee::place_obstacles(const Frame& frame, Stage& stage) {
  for (Obstacle& one : obstacles_) {
    if (one.there || one.time > frame.time) continue;
    // In a run that is gone on from its middle without the memory of it, some are there already.
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
    // Where there is no room now there may be later: the list is gone through again and again.
    for (std::size_t i = 0; i < one.cells.size(); ++i) {
      const int index = one.cells[one.tried % one.cells.size()];
      ++one.tried;
      one.cell = {index / maze_.columns, index % maze_.columns};
      if (!fits(frame, one, one.cell)) continue;
      ask_for(one, stage);
      return;  // one at a time: the next sees where this one is
    }
  }
}

void MazeReferee::publish(Stage& stage) {
  const std::vector<Cube> known = cubes();
  if (!judged_ || *judged_ != known.size()) {
    const auto steps = fewest_steps(maze_, task_, known, pace_);
    optimum_ = steps ? *steps * maze_.cell : kNaN;
    judged_ = known.size();
  }
  const bool arrived = !std::isnan(goal_time_);
  stage.publish("success", arrived && touched_ == 0 ? 1.0 : 0.0);
  stage.publish("arrived", arrived ? 1.0 : 0.0);
  stage.publish("path", path_);
  stage.publish("optimum", optimum_);
  stage.publish("ratio", arrived ? path_ / optimum_ : kNaN);
  stage.publish("touched", touched_);
  stage.publish("time_to_trigger", trigger_time_);
  stage.publish("time_to_goal", goal_time_);
  stage.publish("obstacles",
                static_cast<double>(std::count_if(obstacles_.begin(), obstacles_.end(),
                                                  [](const Obstacle& one) { return one.there; })));
}

void MazeReferee::update(const cogrsim::Tick&, Stage& stage) {
  if (ending_) {
    // The frame in between has carried the verdict.
    stage.send(cogrsim::EndRun{"the goal is reached"});
    return;
  }
  const Frame& frame = stage.frame();
  watch_model(frame.model);
  follow_robot(frame, stage);
  count_touches(frame);
  place_obstacles(frame, stage);
  publish(stage);
  ending_ = end_run_ && !std::isnan(goal_time_);
}

// What has happened so far; what is to come is drawn anew from the same seed.
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
  const auto word = [&] {
    std::string text;
    if (!(in >> text)) throw std::runtime_error("the memory of the referee ends too early");
    return text;
  };
  // Not by >>, which does not know the "nan" and "inf" that it wrote.
  const auto number = [&] {
    const std::string text = word();
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (*end != '\0') throw std::runtime_error("'" + text + "' is no number");
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
      throw std::runtime_error("the snapshot knows a cell that is not in this maze");
    }
    return out;
  };
  if (word() != "maze_referee" || whole() != 1) {
    throw std::runtime_error("this is not the memory of a maze_referee");
  }
  if (number() != static_cast<double>(obstacles_.size())) {
    throw std::runtime_error("the snapshot knows another number of obstacles");
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
    if (word() != one.name) throw std::runtime_error("the snapshot knows other obstacles");
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
    summary("puts cubes and balls into a maze while a robot drives through it, and judges the run"),
    parameter("maze", "", "name of the maze; empty: the only one"),
    parameter("robot", "bot", "the assembly that is watched"),
    parameter("start", "", "cell in which it starts: a named place, or \"r2c5\"").must_be_set(),
    parameter("trigger", "", "cell it must visit first").must_be_set(),
    parameter("goal", "", "cell at which the run ends").must_be_set(),
    parameter("speed", 0.5, "m/s", "the fastest the robot can be, for the optimum")
        .range(0.01, 10.0),
    parameter("acceleration", 2.0, "m/s^2", "the same").range(0.01, 100.0),
    parameter("turn_rate", 6.0, "rad/s", "the same").range(0.1, 100.0),
    parameter("turn_acceleration", 30.0, "rad/s^2", "the same").range(0.1, 1000.0),
    parameter("arrival", 0.03, "m", "the goal counts as reached this near to its middle")
        .range(1e-3, 1.0),
    parameter("cubes", 5, "cubes that appear").range(0, 200),
    parameter("balls", 4, "balls that appear").range(0, 200),
    parameter("from", 1.0, "s", "nothing appears before").range(0.0, 1e6),
    parameter("until", 15.0, "s", "the last appears by then").range(0.0, 1e6),
    parameter("vanishing", 0.5, "1", "share of the balls that vanish again after 4 s to 12 s")
        .range(0.0, 1.0),
    parameter("scatter", 0.03, "m",
              "obstacles stand this far off the middle of their cell, at most")
        .range(0.0, 1.0),
    parameter("cube", 0.2, "m", "edge of the cubes").range(0.01, 2.0),
    parameter("ball", 0.06, "m", "radius of the balls").range(0.005, 1.0),
    parameter("cube_template", "Cube", "what a cube is made from"),
    parameter("ball_template", "Ball", "what a ball is made from"),
    parameter("end_run", true, "the run ends at the goal"),
    output("success", "1", "1 once the goal is reached and no cube was touched"),
    output("arrived", "1", "1 once the goal is reached"), output("path", "m", "driven so far"),
    output("optimum", "m", "the shortest way, known in hindsight"),
    output("ratio", "1", "path / optimum, once the goal is reached"),
    output("touched", "1", "times it touched a cube"),
    output("time_to_trigger", "s", "when the trigger was reached"),
    output("time_to_goal", "s", "when the goal was reached"),
    output("obstacles", "1", "placed so far"))
