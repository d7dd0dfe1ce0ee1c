// The same as a supervisor.
#include "cogrsim/control/supervisor.h"
#include "misdeed.h"

namespace {

class Boss final : public cogrsim::Supervisor {
 public:
  ~Boss() override { misdeed::commit_at("rascal_boss.unmake"); }
  void configure(cogrsim::SupervisorContext&) override { misdeed::commit_at("rascal_boss.configure"); }
  void update(const cogrsim::Tick& tick, cogrsim::SupervisorContext&) override {
    if (tick.time >= 0.1) misdeed::commit_at("rascal_boss.update");
  }
};

}  // namespace

COGRSIM_SUPERVISOR(Boss, "rascal_boss", version("1.0.0"), summary("misbehaves"))
