// A supervisor that acts as its parameter says: nothing, or something that ends its process. With
// `above` > 0 only in runs whose first random number is above it, so that the seed decides.
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include "cogrsim/control/supervisor.h"

namespace {

class Trouble final : public cogrsim::Supervisor {
 public:
  void configure(cogrsim::SupervisorContext& context) override {
    what_ = std::get<std::string>(*context.parameter("what"));
    const double above = std::get<double>(*context.parameter("above"));
    draw_ = context.uniform(0.0, 1.0);
    if (draw_ < above) what_ = "nothing";
  }
  void update(const cogrsim::Tick& tick, cogrsim::SupervisorContext& context) override {
    context.publish("draw", draw_);
    if (tick.count != 3) return;
    if (what_ == "crash") std::raise(SIGSEGV);
    if (what_ == "abort") {
      std::fputs("the last message\n", stderr);
      std::abort();
    }
    if (what_ == "exit") std::exit(7);
    if (what_ == "print") std::puts("{\"status\": \"a plugin may print what it likes\"}");
    if (what_ == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
    if (what_ == "linger") std::this_thread::sleep_for(std::chrono::milliseconds(150));
    if (what_ == "eat") {
      for (;;) eaten_.push_back(std::vector<char>(16u << 20, 1));
    }
    if (what_ == "end") context.send(cogrsim::EndRun{"enough"});
  }

 private:
  std::string what_;
  double draw_ = 0.0;
  std::vector<std::vector<char>> eaten_;
};

}  // namespace

COGRSIM_SUPERVISOR(Trouble, "trouble", version("1.0.0"), summary("ends processes"),
                   parameter("what", "nothing", "what it does"),
                   parameter("above", 0.0, "", "only when the first random number is above it"),
                   output("draw", "1", "the first random number"))
