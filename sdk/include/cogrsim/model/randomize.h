// Values of a model that `<randomize>` draws for each run. Names and units:
//
// | quantity                                                       | of                         |
// |----------------------------------------------------------------|----------------------------|
// | BODY.mass (the inertia in proportion), BODY.com.x .y .z        | a dynamic body             |
// | BODY.x .y .z                                                   | a body without joints      |
// | ASSEMBLY.x .y .z                                               | without joints to outside  |
// | BODY.friction .restitution .rolling-friction .spinning-friction| its shapes                 |
// | MATERIAL.friction and so on                                    | shapes of this material    |
// | JOINT.damping .friction .stiffness .rotor-inertia .max-effort  | all axes of the joint      |
// | MOTOR.max-effort .max-speed .delay .kp .ki .kd                 |                            |
// | MOTOR.stall-effort .no-load-speed                              | with these                 |
// | SPRING.stiffness .damping, DRAG.linear .quadratic .angular     |                            |
// | BUOYANCY.density .level, WIND.x .y .z                          |                            |
// | SENSOR.noise-sigma, SENSOR.latency                             | its normal noise terms     |
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/units.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// A quantity of a model.
struct VariableQuantity {
  std::string name;  ///< "robot.arm.mass"
  /// Empty: the unit depends on the sensor; such a quantity can only be multiplied.
  std::optional<units::Dimension> dimension;
  double low = -std::numeric_limits<double>::infinity();  ///< smallest valid value
  double high = std::numeric_limits<double>::infinity();  ///< largest valid value
  bool above = false;                                     ///< `low` itself is not valid
  std::vector<double> values;  ///< one for every axis, shape or noise term [SI units]

  COGRSIM_API bool valid(double value) const;
  /// Writes new values to a copy of the model.
  std::function<void(SceneModel&, const std::vector<double>&)> set;
};

/// Whether a name matches a pattern, in which every `*` stands for any characters.
COGRSIM_API bool matches_pattern(std::string_view name, std::string_view pattern);

/// The quantities of a model whose names are `wanted`. The model must outlive them.
COGRSIM_API std::vector<VariableQuantity> variable_quantities(
    const SceneModel& model, const std::function<bool(const std::string&)>& wanted);

/// What a drawn number makes of a value.
COGRSIM_API double drawn_value(const RandomizeModel& randomize, double value, double number);

/// A copy of the model with drawn values, and these in SceneModel::drawn. The same seed of the model
/// gives the same values, whatever else is in the scene. A number that would make a value invalid is
/// drawn again. Without `<randomize>`, or with values that are drawn already, it is the model itself.
COGRSIM_API SceneModelPtr with_drawn_values(SceneModelPtr model);

}  // namespace cogrsim
