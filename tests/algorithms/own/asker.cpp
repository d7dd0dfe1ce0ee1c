// Requests algorithms, and reports what it received.
#include <stdexcept>

#include "cogrsim/algorithms/grid_planner.h"
#include "cogrsim/algorithms/learner.h"
#include "cogrsim/control/controller.h"

namespace {

class Asker final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = std::make_unique<cogrsim::Assembly>(robot);
    planner_ = robot.algorithm<cogrsim::GridPlanner>(robot.parameter<std::string>("planner"));
    cogrsim::Parameters parameters{{"exploration", robot.parameter<double>("exploration")}};
    const auto table = robot.parameter<std::string>("table");
    if (!table.empty()) parameters["table"] = table;
    learner_ = robot.algorithm<cogrsim::Learner>("q_learning", parameters);
  }

  void update(const cogrsim::Tick&) override {
    planner_->set_grid(cogrsim::Grid(3, 3));
    const auto path = planner_->plan({0, 0}, {2, 2});
    std::string text = path ? "path " + std::to_string(path->cells.size()) : path.error().message;
    text += ", choices ";
    for (int i = 0; i < 24; ++i) text += std::to_string(*learner_->choose(0, 4, true));
    robot_->report(text);
    const auto learnt = learner_->learn({0, 1, 1.0, 0, true, -1});
    if (!learnt) throw std::runtime_error(learnt.error().text());
  }

 private:
  std::unique_ptr<cogrsim::Assembly> robot_;
  std::shared_ptr<cogrsim::GridPlanner> planner_;
  std::shared_ptr<cogrsim::Learner> learner_;
};

}  // namespace

COGRSIM_CONTROLLER(Asker, "asker", output("asked", "m/s", "speed of asking"),
                   parameter("planner", "a_star", "of grids"),
                   parameter("table", "", "of the learner"),
                   parameter("exploration", 1.0, "1", "of the learner"))
