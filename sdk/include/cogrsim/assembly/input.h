// Inputs of controllers: numbers that a person or a program sets while the run goes.
#pragma once

#include <string>
#include <vector>

namespace cogrsim {

/// Declared by a controller, see Assembly::input(), and set by the command SetInput.
struct ControllerInput {
  std::string name;
  std::string unit;     ///< "" if it has none
  double lower = -1.0;  ///< smallest and largest value, both finite
  double upper = 1.0;
  double value = 0.0;
  double start = value;  ///< the value with which it was declared

  /// Whether somebody has given it another value.
  bool was_set() const { return value != start; }
};

/// Those of one controller of a run; see Simulation::controller_inputs().
struct ControllerInputs {
  std::string controller;  ///< dotted name
  std::vector<ControllerInput> inputs;
};

}  // namespace cogrsim
