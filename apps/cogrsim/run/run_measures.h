// Measures (metrics) of one run: `<measure>`s of the scene and those named on the command line.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::cli {

/// Checks a measure before anything runs. Errors: the signal's, or the condition's.
Result<> check_measure(const SceneModel& model, const MeasureModel& measure);

class RunMeasures {
 public:
  /// Before the first step. Errors: a signal or condition that cannot be read, naming the measure.
  static Result<RunMeasures> attach(Simulation& simulation, std::vector<MeasureModel> measures);

  struct Value {
    std::string name, unit;
    double value;  ///< NaN: there is none
  };
  std::vector<Value> values() const;

 private:
  struct Sample;
  // The simulation's observer holds on to them, too.
  std::shared_ptr<std::vector<Sample>> samples_;
};

}  // namespace cogrsim::cli
