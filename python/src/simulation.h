// A simulation as Python sees it: one user at a time.
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "cogrsim/simulation/simulation.h"
#include "frame.h"
#include "scene.h"

namespace cogrsim::python {

/// Who is using an object at present.
struct Usage {
  /// forks, where threads work for the object: it is of no use in a process that was forked later.
  std::optional<int> made_after;
  std::atomic<bool> busy{false};
  std::atomic<std::thread::id> thread{};
};

/// Marks an object as in use. Errors: RuntimeError if it is already.
class Use {
 public:
  Use(Usage& usage, const char* what);
  template <class Owner>
  explicit Use(Owner& owner) : Use(owner.usage, Owner::kWhat) {}
  ~Use() {
    usage_.busy.store(false);
    --calls_under_way;
  }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  Usage& usage_;
};

struct Session {
  static constexpr const char* kWhat = "simulation";
  ScenePtr scene;
  std::unique_ptr<Simulation> simulation;
  std::vector<std::string> notes;  ///< of resume()
  Usage usage;
  std::size_t warned = 0;  ///< number of messages that have been looked at
  /// The exception of an observer, raised when the step has ended.
  Held observer_error;
  std::atomic<bool> observer_failed{false};
  std::size_t observers = 0;
};
using SessionPtr = std::shared_ptr<Session>;

SimulationOptions simulation_options(const py::object& backend, double step,
                                     const std::optional<std::uint64_t>& seed, double speed,
                                     const std::string& isolation,
                                     std::vector<std::string> without);
/// Steps until `end` [s], or `most` steps, and returns the frame there; with `progress`, with a line of
/// progress. Raises KeyboardInterrupt between two steps.
PyFrame advance(Session& session, double end, std::uint64_t most, bool progress = false);

/// The errors of a run beyond the first `known` messages, which it counts on.
std::vector<std::string> new_errors(const Simulation& run, std::size_t& known);
/// Shows them as RunWarning, so that a run that failed is not taken for a good one.
void warn(const std::vector<std::string>& errors);

void bind_commands(py::class_<Session, SessionPtr>& type);
void bind_snapshots(py::module_& m, py::class_<Session, SessionPtr>& type);

}  // namespace cogrsim::python
