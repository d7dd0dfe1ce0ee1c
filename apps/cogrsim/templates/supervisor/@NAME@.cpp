// @NAME@: drops balls over a basket, counts those that fall into it, and ends the run.
//
// A supervisor observes the whole world and changes it by commands, which are applied between two
// steps. Supervisors control experiments: they add objects, evaluate the run, and end it.
#include <cstdint>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <variant>

#include <cogrsim/control/supervisor.h>

namespace {

class @CLASS@ final : public cogrsim::Supervisor {
 public:
  // Called before the run, and on a new object after every restart. An exception makes loading fail
  // with its message.
  void configure(cogrsim::SupervisorContext& context) override {
    wanted_ = std::get<std::int64_t>(*context.parameter("wanted"));
    period_ = std::get<double>(*context.parameter("period"));
    spread_ = std::get<double>(*context.parameter("spread"));
    height_ = std::get<double>(*context.parameter("height"));
    publish(context);
  }

  // Called at the rate in the scene. context.frame() is the current frame, with all events since
  // the previous update.
  void update(const cogrsim::Tick& tick, cogrsim::SupervisorContext& context) override {
    if (ended_) return;  // EndRun takes effect at the next step, so there may be one more update
    for (const cogrsim::Event& event : context.frame().events) {
      // The region "basket" of the scene detects objects that enter; cogrsim/physics/frame.h lists
      // the kinds of events.
      if (event.kind == "enter" && event.source == "basket") {
        ++caught_;
        // The body of a ball is "Ball_3.ball" and its assembly "Ball_3", which is removed.
        const std::string ball = event.subject.substr(0, event.subject.find('.'));
        context.send(cogrsim::Remove{ball});
      }
    }
    if (caught_ >= wanted_) {
      ended_ = true;
      context.send(cogrsim::EndRun{std::to_string(caught_) + " of " + std::to_string(spawned_) +
                                 " balls are in the basket"});
    } else if (tick.time >= static_cast<double>(spawned_) * period_) {
      drop(context);
    }
    publish(context);
  }

  // With these functions a run can be saved to a file and resumed. Without them the supervisor
  // restarts.
  std::optional<std::string> save() const override {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out << spawned_ << ' ' << caught_ << ' ' << ended_;
    return out.str();
  }
  void restore(const std::string& memory) override {
    std::istringstream in(memory);
    in.imbue(std::locale::classic());
    if (!(in >> spawned_ >> caught_ >> ended_)) throw std::runtime_error("the state is invalid");
  }

 private:
  void drop(cogrsim::SupervisorContext& context) {
    cogrsim::Spawn ball;
    ball.of = "Ball";  // a <template> of the scene
    // The random stream of the supervisor depends on the seed: the same seed gives the same run.
    ball.pose.p = cogrsim::Vec3(context.uniform(-spread_, spread_), 0.0, height_);
    // Balls that missed are removed automatically.
    ball.lifetime = 2.0;
    context.send(ball);
    ++spawned_;
  }

  // Outputs can be plotted, tested and tabulated. With the name of the supervisor in the scene they
  // are counter.spawned and counter.caught.
  void publish(cogrsim::SupervisorContext& context) const {
    context.publish("spawned", static_cast<double>(spawned_));
    context.publish("caught", static_cast<double>(caught_));
  }

  std::int64_t wanted_ = 0;
  double period_ = 0.0;  // [s]
  double spread_ = 0.0;  // [m]
  double height_ = 0.0;  // [m]
  std::int64_t spawned_ = 0, caught_ = 0;
  bool ended_ = false;
};

}  // namespace

COGRSIM_SUPERVISOR(@CLASS@, "@NAME@", version("0.1.0"), author("you"),
                   summary("drops balls over a basket and counts them"),
                   parameter("wanted", 5, "balls in the basket that end the run").range(1, 1000),
                   parameter("period", 0.5, "s", "time between two balls").range(0.01, 60.0),
                   parameter("spread", 0.3, "m", "largest offset to either side").range(0.0, 10.0),
                   parameter("height", 1.0, "m", "height from which they fall").range(0.1, 10.0),
                   output("spawned", "1", "number of balls so far"),
                   output("caught", "1", "number of balls in the basket"))
