// A supervisor that requests far too much in every step.
#include "cogrsim/control/supervisor.h"

namespace {

class Flood final : public cogrsim::Supervisor {
 public:
  void configure(cogrsim::SupervisorContext& context) override {
    count_ = std::get<std::int64_t>(*context.parameter("count"));
  }
  void update(const cogrsim::Tick& tick, cogrsim::SupervisorContext& context) override {
    cogrsim::Spawn spawn;
    spawn.of = "Ball";
    for (std::int64_t i = 0; i < count_; ++i) {
      // Side by side, on a level of their own in every step.
      spawn.pose.p =
          cogrsim::Vec3(0.3 * static_cast<double>(i % 10), 0.3 * static_cast<double>(i / 10 % 10),
                        100.0 + 0.3 * static_cast<double>(tick.count));
      context.send(spawn);
    }
    context.publish("sent", static_cast<double>(count_) * static_cast<double>(tick.count + 1));
  }

 private:
  std::int64_t count_ = 0;
};

}  // namespace

COGRSIM_SUPERVISOR(Flood, "flood", version("1.0.0"), parameter("count", 1000000, "per step"),
                   output("sent", "1", "spawns so far"))
