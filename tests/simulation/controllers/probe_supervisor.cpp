// A supervisor that ends the run when a body has fallen below a height, draws one number and counts the
// events it is shown.
#include "cogrsim/control/supervisor.h"

namespace {

class ProbeSupervisor final : public cogrsim::Supervisor {
 public:
  void configure(cogrsim::SupervisorContext& context) override {
    height_ = std::get<double>(*context.parameter("height"));
    context.report("drew " + std::to_string(context.uniform(0.0, 1.0)));
  }
  void update(const cogrsim::Tick&, cogrsim::SupervisorContext& context) override {
    events_ += context.frame().events.size();
    context.publish("events", static_cast<double>(events_));
    if (context.frame().state.poses[0].p.z() < height_) {
      context.send(cogrsim::EndRun{"fell below the line"});
    }
  }

 private:
  double height_ = 0.0;
  std::size_t events_ = 0;
};

}  // namespace

COGRSIM_SUPERVISOR(ProbeSupervisor, "probe_supervisor", version("1.0.0"),
                   output("events", "1", "events seen so far"),
                   parameter("height", 0.0, "m", "where the run ends"))
