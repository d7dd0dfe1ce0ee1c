// A controller that misbehaves as commanded, to test the containment of its faults.
#include "cogrsim/control/controller.h"
#include "misdeed.h"

namespace {

[[maybe_unused]] const bool kLoaded = (misdeed::commit_at("rascal.load"), true);

class Rascal final : public cogrsim::Controller {
 public:
  Rascal() { misdeed::commit_at("rascal.make"); }
  ~Rascal() override { misdeed::commit_at("rascal.unmake"); }
  void configure(cogrsim::Assembly& robot) override {
    misdeed::commit_at("rascal.configure");
    does_ = robot.parameter<std::string>("does");
    from_ = robot.parameter<double>("from");
  }
  void update(const cogrsim::Tick& tick) override {
    if (tick.time >= from_) misdeed::commit(does_);
  }

 private:
  std::string does_;
  double from_ = 0.0;
};

}  // namespace

COGRSIM_CONTROLLER(Rascal, "rascal", version("1.0.0"), summary("misbehaves"),
                   parameter("does", "nothing", "what it does, see misdeed.h"),
                   parameter("from", 0.0, "s", "when it begins to"),
                   parameter("notes", "", "a file it could read"))
