// What a person did during a run: targets of motors, forces on bodies, another step length. Kept with
// the number of the step before which each took effect, so that the same run can be made again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/control/command.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::cli {

/// Name of the inputs among the attachments of a recording.
inline constexpr const char* kInputsFile = "cogrsim.inputs.jsonl";

/// Inputs of a run at most: at one per step an hour of steps of 1 ms.
inline constexpr std::size_t kMostInputs = 3'600'000;

struct Input {
  std::uint64_t step = 0;  ///< the number of steps done before
  Command command;         ///< SetMotor, ApplyForce, SetInput or SetStep
};

struct Inputs {
  std::string backend;  ///< of the run
  double dt = 0.0;      ///< its step length at the start [s]
  /// Why the run cannot be made again from them alone; empty: it can.
  std::string lost;
  std::vector<Input> list;  ///< in the order in which they were given
};

/// A line of JSON about the run, and one for each input. Numbers are read back to the same bits.
std::string to_text(const Inputs& inputs);
/// Errors name the line and what it must be.
Result<Inputs> inputs_from(const std::string& text, const std::string& file);
/// Those of a recording, or a file with the text above. Errors: the file cannot be read, holds no
/// inputs, or is damaged.
Result<Inputs> read_inputs(const std::string& file);

/// Gives a run the inputs of another one, each before the step before which it was given then.
class InputPlayer {
 public:
  explicit InputPlayer(std::vector<Input> inputs) : inputs_(std::move(inputs)) {}
  /// Those that are due: to be called before each step. `taken` is called with each of them.
  template <class Taken>
  void give(std::uint64_t step, Taken taken) {
    for (; next_ < inputs_.size() && inputs_[next_].step <= step; ++next_) {
      // One for a step that is over must not hold up those that follow.
      if (inputs_[next_].step == step) {
        taken(inputs_[next_]);
      } else {
        ++missed_;
      }
    }
  }
  std::size_t left() const { return inputs_.size() - next_; }
  /// Those that were not given: their step was over.
  std::size_t missed() const { return missed_; }
  /// Those that are not due yet.
  std::vector<Input> rest() const {
    return {inputs_.begin() + static_cast<std::ptrdiff_t>(next_), inputs_.end()};
  }

 private:
  std::vector<Input> inputs_;
  std::size_t next_ = 0, missed_ = 0;
};

}  // namespace cogrsim::cli
