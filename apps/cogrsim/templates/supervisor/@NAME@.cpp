// @NAME@: drops balls over a basket, counts those that fall into it, and ends the run.
//
// A supervisor is the hand from above: it sees the whole world and changes it by commands, which are
// carried out between two steps. Experiments are run by supervisors: what comes when, what counts,
// when it is over.
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
  // Before the run, and on a new object after every restart. What is wrong is thrown, and the load
  // fails with it.
  void configure(cogrsim::Stage& stage) override {
    wanted_ = std::get<std::int64_t>(*stage.parameter("wanted"));
    period_ = std::get<double>(*stage.parameter("period"));
    spread_ = std::get<double>(*stage.parameter("spread"));
    height_ = std::get<double>(*stage.parameter("height"));
    publish(stage);
  }

  // At the rate that the scene gives. stage.frame() is the world now, and has all events since the
  // update before.
  void update(const cogrsim::Tick& tick, cogrsim::Stage& stage) override {
    if (ended_) return;  // a command takes effect at the next step, so there may be one more update
    for (const cogrsim::Event& event : stage.frame().events) {
      // The region "basket" of the scene notices who comes in; the table of kinds is in
      // cogrsim/physics/frame.h.
      if (event.kind == "enter" && event.source == "basket") {
        ++caught_;
        // A ball's body is "Ball_3.ball", its assembly "Ball_3". Taken out, it is in nobody's way.
        const std::string ball = event.subject.substr(0, event.subject.find('.'));
        stage.send(cogrsim::Remove{ball});
      }
    }
    if (caught_ >= wanted_) {
      ended_ = true;
      stage.send(cogrsim::EndRun{std::to_string(caught_) + " of " + std::to_string(spawned_) +
                                 " balls are in the basket"});
    } else if (tick.time >= static_cast<double>(spawned_) * period_) {
      drop(stage);
    }
    publish(stage);
  }

  // With these a run can be saved to a file and gone on with. Without them it begins anew there.
  std::optional<std::string> save() const override {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out << spawned_ << ' ' << caught_ << ' ' << ended_;
    return out.str();
  }
  void restore(const std::string& memory) override {
    std::istringstream in(memory);
    in.imbue(std::locale::classic());
    if (!(in >> spawned_ >> caught_ >> ended_)) throw std::runtime_error("this is no memory of mine");
  }

 private:
  void drop(cogrsim::Stage& stage) {
    cogrsim::Spawn ball;
    ball.of = "Ball";  // a <template> of the scene
    // The supervisor's own random stream: another seed, other places; the same seed, the same run.
    ball.pose.p = cogrsim::Vec3(stage.uniform(-spread_, spread_), 0.0, height_);
    // Balls that missed go by themselves.
    ball.lifetime = 2.0;
    stage.send(ball);
    ++spawned_;
  }

  // Numbers of a run that can be plotted, tested and tabulated; after the supervisor's name in the
  // scene they are called counter.spawned and counter.caught.
  void publish(cogrsim::Stage& stage) const {
    stage.publish("spawned", static_cast<double>(spawned_));
    stage.publish("caught", static_cast<double>(caught_));
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
                   summary("drops balls over a basket and counts"),
                   parameter("wanted", 5, "balls in the basket that end the run").range(1, 1000),
                   parameter("period", 0.5, "s", "from one ball to the next").range(0.01, 60.0),
                   parameter("spread", 0.3, "m", "balls come this far to either side").range(0.0, 10.0),
                   parameter("height", 1.0, "m", "from which they fall").range(0.1, 10.0),
                   output("spawned", "1", "balls that came so far"),
                   output("caught", "1", "of them in the basket"))
