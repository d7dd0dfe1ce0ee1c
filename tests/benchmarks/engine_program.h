// What all programs that simulate the benchmark scenes on one engine have in common: their options,
// and the few words they exchange with the program that measures them side by side.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "scene.h"

namespace cogrsim::bench {

/// One scene, running on an engine.
class Runner {
 public:
  virtual ~Runner() = default;
  /// Advances by dt [s]; reads the eyes when they are due.
  virtual void step(double dt) = 0;
  /// Of all Scene::things, in order; `states` has their size.
  virtual void get_states(std::vector<ThingState>& states) = 0;
  /// Sum over the eyes of what they read last [m]; the range where they see nothing.
  virtual double seen() { return 0.0; }
};

/// The engine cannot do the scene; what() says why.
struct Unsupported : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A program on one engine.
class EngineProgram {
 public:
  virtual ~EngineProgram() = default;
  virtual std::string name() const = 0;      ///< "raw-bullet"
  virtual std::string version() const = 0;   ///< of the engine
  virtual std::string settings() const = 0;  ///< solver, iterations, accuracy; one line
  /// Throws Unsupported, or any other exception for what went wrong.
  virtual std::unique_ptr<Runner> make(const Scene& scene) = 0;
};

/// main() of such a program. Options: --scene NAME [--count N] [--dt S] [--steps N] [--trace FILE].
///
/// With --trace it writes after each of the --steps what Runner::get_states() gives (nthing x 7
/// doubles: place, turn) and prints who computed it.
///
/// With --steps it runs alone and prints what it measured. Without, it answers lines on its
/// standard input by lines of JSON on its standard output (what an engine prints itself goes to
/// standard error):
///
///     (at the start)  {"engine", "version", "settings", "scene", "bodies", "build_us"}
///                      or {"unsupported": "why"} or {"failed": "why"}
///     step N          {"us": processor time of the N steps [us]}
///     state           {"check", "seen", "turn": of the last body, "memory": resident, more than
///                      before the scene was built [byte]}
///     quit            (ends)
int engine_main(int argc, char** argv, EngineProgram& program);

}  // namespace cogrsim::bench
