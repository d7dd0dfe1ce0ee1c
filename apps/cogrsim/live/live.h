// cogrsim run --live: the topics of a run over Foxglove's WebSocket protocol, and clients that steer it.
// docs/guide/live.md describes what is offered.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "cogrsim/recording/run_stream.h"
#include "cogrsim/simulation/simulation.h"
#include "common/options.h"

namespace cogrsim::cli {

/// The part of a run that is on the network. All functions are called by the thread of the run.
class Live {
 public:
  /// Listens and answers. `set`: the settings of the scene's parameters, as information. Errors: the
  /// address is none of this machine, the port is taken.
  static Result<std::unique_ptr<Live>> start(Simulation& simulation, const LiveOptions& options,
                                             const StreamOptions& stream, double speed,
                                             const std::map<std::string, std::string>& set);
  ~Live();  ///< gives the clients what waits, and says that the run has ended

  /// "ws://127.0.0.1:8765/"
  std::string address() const;

  /// Does what clients ask for: to be called between steps, a few times a second. While the run is
  /// paused, it waits, until a client resumes it, an interrupt ends it, or `end` [s] is reached.
  RunStatus serve(double end);
  /// Simulated seconds per second, as clients have set it; infinity: as fast as it can.
  double speed() const;

 private:
  struct Impl;
  explicit Live(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim::cli
