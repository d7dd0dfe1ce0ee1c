// A controller that does what it is told, to see what becomes of those around it.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "cogrsim/control/controller.h"

namespace {

class Rascal final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    does_ = robot.parameter<std::string>("does");
  }
  void update(const cogrsim::Tick&) override {
    if (does_ == "crash") std::abort();
    if (does_ == "throw") throw std::runtime_error("told to");
    volatile bool for_ever = does_ == "hang";
    if (for_ever) std::fputs("the rascal hangs\n", stderr);
    while (for_ever) {
    }
  }

 private:
  std::string does_;
};

}  // namespace

COGRSIM_CONTROLLER(
    Rascal, "rascal", version("1.0.0"), summary("misbehaves"),
    parameter("does", "nothing", "what it does").one_of({"nothing", "crash", "hang", "throw"}),
    parameter("notes", "", "a file it could read"))
