// Plays motor targets from a CSV file. See README.md.
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/control/controller.h"
#include "trajectory.h"

namespace trajectory_player {
namespace {

class TrajectoryPlayer final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    Parsed parsed = load_trajectory(robot.scene_folder(), robot.parameter<std::string>("file"));
    for (const auto& error : parsed.errors) robot.fail(error);
    if (!parsed.errors.empty()) return;
    trajectory_ = std::move(parsed.trajectory);
    at_end_ = robot.parameter<std::string>("at_end") == "loop" ? AtEnd::loop : AtEnd::hold;
    if (at_end_ == AtEnd::loop && trajectory_.times.size() < 2) {
      robot.fail(robot.parameter<std::string>("file") + ": a loop needs at least two rows");
    }
    delay_ = robot.parameter<double>("delay");
    rate_ = robot.parameter<double>("playback_rate");
    for (const auto& column : trajectory_.columns) motors_.push_back(robot.motor(column));
  }

  void update(const cogrsim::Tick& tick) override {
    sample(trajectory_, (tick.time - delay_) * rate_, at_end_, targets_);
    for (std::size_t i = 0; i < motors_.size(); ++i) motors_[i].set(targets_[i]);
  }

  // The state depends on the time only.
  std::optional<std::string> save() const override { return std::string(); }

 private:
  Trajectory trajectory_;
  AtEnd at_end_ = AtEnd::hold;
  double delay_ = 0.0;  // [s]
  double rate_ = 1.0;
  std::vector<cogrsim::MotorHandle> motors_;
  std::vector<double> targets_;
};

}  // namespace
}  // namespace trajectory_player

COGRSIM_CONTROLLER(
    trajectory_player::TrajectoryPlayer, "trajectory_player", version("1.0.0"), author("CogRSim"),
    summary("plays a CSV file of motor targets, linear between its rows"),
    parameter("file", "", "CSV file inside the folder of the scene").must_be_set(),
    parameter("at_end", "hold", "after the last row: hold it, or loop").one_of({"hold", "loop"}),
    parameter("delay", 0.0, "s", "time at which the file's time 0 is played").range(-1e6, 1e6),
    parameter("playback_rate", 1.0, "", "2 plays twice as fast").range(1e-3, 1e3))
