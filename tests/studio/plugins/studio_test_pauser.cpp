// A supervisor that pauses the run once.
#include "cogrsim/control/supervisor.h"

namespace {

class Pauser final : public cogrsim::Supervisor {
 public:
  void configure(cogrsim::SupervisorContext& context) override { at_ = std::get<double>(*context.parameter("at")); }
  void update(const cogrsim::Tick&, cogrsim::SupervisorContext& context) override {
    if (done_ || context.frame().time < at_) return;
    done_ = true;
    context.send(cogrsim::Pause{});
  }

 private:
  double at_ = 0.0;
  bool done_ = false;
};

}  // namespace

COGRSIM_SUPERVISOR(Pauser, "studio_test_pauser", version("1.0.0"),
                   parameter("at", 0.1, "s", "when to pause").range(0.0, 1e3))
