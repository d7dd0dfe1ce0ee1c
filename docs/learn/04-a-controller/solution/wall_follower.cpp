// Exercise 3: keeps a wall on its right at a distance, by a PD law on two infrared sensors; a scanner looks forward.
#include <cogrsim/control/controller.h>

#include <algorithm>
#include <cmath>

class WallFollower final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    left_ = robot.motor("base.left");
    right_ = robot.motor("base.right");
    scan_ = robot.sensor<cogrsim::Lidar>("base.scan");
    side_ = robot.sensor<cogrsim::Infrared>("base.side");
    slant_ = robot.sensor<cogrsim::Infrared>("base.slant");
    speed_ = robot.parameter<double>("speed");
    gap_ = robot.parameter<double>("gap");
  }

  void update(const cogrsim::Tick&) override {
    if (!scan_.valid() || !side_.valid() || !slant_.valid()) return;
    double forward = speed_, turn = 0.0;
    if (scan_.range(scan_.size() / 2) < gap_ + 0.05) {
      forward = 0.0;  // a corner: on the spot to the left, until the path is free
      turn = 1.5;
    } else if (std::isinf(slant_.distance()) || slant_.distance() > 4 * gap_) {
      turn = -speed_ / (gap_ + 0.08);  // the wall has ended: around its end
    } else {
      // The slanted eye looks 45° ahead: along a wall it reads the gap times the root of two. What it reads less
      // means that the robot heads for the wall.
      const double heading = slant_.distance() / std::sqrt(2.0) - side_.distance();
      const double away = side_.distance() - gap_;
      turn = std::clamp(-6.0 * away - 5.0 * heading, -1.5, 1.5);
    }
    left_.set((forward - turn * kTrack / 2) / kRadius);
    right_.set((forward + turn * kTrack / 2) / kRadius);
  }

 private:
  static constexpr double kRadius = 0.05, kTrack = 0.2;  // [m]
  cogrsim::MotorHandle left_, right_;
  cogrsim::Lidar scan_;
  cogrsim::Infrared side_, slant_;
  double speed_ = 0.0, gap_ = 0.0;
};

COGRSIM_CONTROLLER(WallFollower, "wall_follower", version("1.0.0"),
                   summary("keeps a wall on its right"),
                   parameter("speed", 0.2, "m/s", "along the wall").range(0.0, 1.0),
                   parameter("gap", 0.2, "m", "to the wall").range(0.05, 1.0))
