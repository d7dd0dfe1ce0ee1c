// Motors and servos.
#include "build/build_scene.h"

namespace cogrsim::dsl {
namespace {

constexpr std::string_view kDcNames[] = {"kt",   "ke",          "resistance",
                                         "gear", "max-voltage", "max-current"};

}  // namespace

Dimension target_dimension(const SceneModel& model, const Motor& motor) {
  const Joint& joint = model.joints[motor.joint];
  const bool turns = axis_turns(joint.type, motor.axis);
  switch (motor.mode) {
    case MotorMode::velocity:
      return turns ? dim::kAngularSpeed : dim::kSpeed;
    case MotorMode::torque:
      return turns ? dim::kTorque : dim::kForce;
    case MotorMode::dc:
      return dim::kVoltage;
    case MotorMode::position:
    case MotorMode::servo:
      break;
  }
  return turns ? dim::kAngle : dim::kLength;
}

void Builder::effort_limit(std::string_view code, const Element& element,
                           const std::string& subject, bool turns, double& effort,
                           const std::string& which) {
  const std::string right = which + (turns ? "-torque" : "-force");
  const std::string wrong = which + (turns ? "-force" : "-torque");
  Reader r = reader(element);
  if (r.has(wrong))
    fault(code, element, wrong,
          subject + (turns ? " turns" : " slides") + ", so it has no " + wrong)
        .help("use " + right);
  const auto given = r.number(right);
  if (given.given()) effort = *given;
}

void Builder::motor(const Element& element) {
  Motor motor;
  motor.name = element.path;
  motor.assembly = note(element).assembly;
  motor.origin = element.span();
  Reader r = reader(element);
  const auto word = r.word("joint");
  const Element* joint_element =
      word.given() ? names_.find(element, *word, Wanted::joint) : nullptr;
  const auto axis = r.integer("axis");
  if (joint_element == nullptr || axis.failed()) return;
  motor.joint = note(*joint_element).joint;
  const Joint& joint = model_.joints[motor.joint];
  const std::string kind = "'" + joint.name + "' is " + kind_of(*joint_element) + " joint";
  if (joint.type == JointType::fixed || joint.type == JointType::free ||
      joint.type == JointType::ball) {
    fault("CG0704", element, "joint",
          kind + (joint.type == JointType::ball
                      ? ": it has no axis of its own that one motor could drive"
                  : joint.type == JointType::free ? ": it leaves all freedom and drives nothing"
                                                  : ": it cannot move"))
        .help("drive a hinge, slider or another joint with axes");
    return;
  }
  const int axes = speed_count(joint.type);
  if (*axis > axes) {
    fault("CG0704", element, "axis",
          kind + " with " + std::to_string(axes) + (axes == 1 ? " axis" : " axes") +
              "; it has no axis " + std::to_string(*axis));
    return;
  }
  motor.axis = static_cast<int>(*axis) - 1;
  const bool turns = axis_turns(joint.type, motor.axis);
  effort_limit("CG0704", element, "this axis of '" + joint.name + "'", turns, motor.max_effort);
  const auto speed = r.number("max-speed", turns ? dim::kAngularSpeed : dim::kSpeed);
  if (speed.given()) motor.max_speed = *speed;
  if (!motor_laws(element, motor, turns) || !motor_curve(element, motor, turns)) return;
  motor_elements_.push_back(&element);
  model_.motors.push_back(std::move(motor));
}

bool Builder::motor_curve(const Element& element, Motor& motor, bool turns) {
  Reader r = reader(element);
  const std::string stall = turns ? "stall-torque" : "stall-force", no_load = "no-load-speed";
  effort_limit("CG0704", element, "this axis of '" + model_.joints[motor.joint].name + "'", turns,
               motor.stall_effort, "stall");
  const auto speed = r.number(no_load, turns ? dim::kAngularSpeed : dim::kSpeed);
  const auto delay = r.number("delay");
  if (speed.failed() || delay.failed()) return false;
  motor.delay = *delay;
  if (speed.given()) motor.no_load_speed = *speed;
  if (r.has(stall) == r.has(no_load)) {
    if (!r.has(stall) || motor.mode != MotorMode::dc) return true;
    fault("CG0708", element, stall,
          "'" + stall +
              "' belongs to other modes: the torque of a DC motor falls with its speed by "
              "'ke' and 'resistance'")
        .help("delete '" + stall + "' and '" + no_load + "', or mode=\"dc\"");
    return false;
  }
  const std::string& given = r.has(stall) ? stall : no_load;
  fault("CG0608", element, given,
        "'" + given + "' has no effect without '" + (r.has(stall) ? no_load : stall) + "'")
      .help("a curve has both ends: " + stall + "=\"" + (turns ? "3 N*m" : "30 N") +
            "\" no-load-speed=\"" + (turns ? "20 rad/s" : "2 m/s") + "\"");
  return false;
}

bool Builder::motor_laws(const Element& element, Motor& motor, bool turns) {
  Reader r = reader(element);
  bool good = true;
  const auto take = [&](std::string_view attribute, const Dimension& dimension, double& value) {
    const auto given = r.number(attribute, dimension);
    good = good && !given.failed();
    if (given.given()) value = *given;
    return given.given();
  };
  if (element.tag() == "servo") {
    motor.mode = MotorMode::servo;
    take("kp", turns ? dim::kAngularStiffness : dim::kStiffness, motor.kp);
    take("ki", turns ? dim::kAngularIntegralGain : dim::kIntegralGain, motor.ki);
    take("kd", turns ? dim::kAngularDamping : dim::kDamping, motor.kd);
  } else {
    const auto mode = r.text("mode");
    if (mode.failed()) return false;
    if (*mode == "torque") {
      motor.mode = MotorMode::torque;
    } else if (*mode == "position") {
      motor.mode = MotorMode::position;
    } else if (*mode == "dc") {
      motor.mode = MotorMode::dc;
    } else {
      motor.mode = MotorMode::velocity;
    }
    if (r.has("response") && motor.mode != MotorMode::position)
      fault("CG0608", element, "response",
            "'response' belongs to position mode, this motor is in " + *mode + " mode");
    take("response", dim::kTime, motor.response);
    if (motor.mode == MotorMode::dc) {
      const bool has_kt = take("kt", turns ? dim::kTorqueConstant : dim::kForceConstant, motor.kt);
      const bool has_ke = take("ke", turns ? dim::kBackEmf : dim::kForceConstant, motor.ke);
      const bool has_resistance = take("resistance", dim::kResistance, motor.resistance);
      // In SI units the two constants of an ideal motor are one number.
      if (has_kt && !has_ke) motor.ke = motor.kt;
      take("gear", dim::kNone, motor.gear);
      take("max-voltage", dim::kVoltage, motor.max_voltage);
      take("max-current", dim::kCurrent, motor.max_current);
      if (good && (!has_kt || !has_resistance)) {
        fault("CG0708", element, "mode",
              std::string("a DC motor needs ") +
                  (has_kt           ? ""
                   : has_resistance ? "'kt'"
                                    : "'kt' and ") +
                  (has_resistance ? "" : "'resistance'"))
            .help("for example kt=\"0.02 N*m/A\" resistance=\"1.5 ohm\"");
        return false;
      }
    } else {
      for (const std::string_view dc : kDcNames)
        if (r.has(dc))
          fault("CG0708", element, dc,
                "'" + std::string(dc) + "' belongs to mode=\"dc\", this motor is in " + *mode +
                    " mode");
    }
  }
  take("min-target", target_dimension(model_, motor), motor.min_target);
  take("max-target", target_dimension(model_, motor), motor.max_target);
  if (good && motor.min_target > motor.max_target) {
    fault("CG0608", element, "min-target", "'min-target' exceeds 'max-target'");
    return false;
  }
  const auto at = r.number("target", target_dimension(model_, motor));
  good = good && !at.failed();
  if (at.given()) motor.target = *at;
  if (at.given() && r.has("target-signal"))
    fault("CG0608", element, "target-signal", "'target' and 'target-signal' both set the target")
        .help("leave one of them out");
  return good;
}

// When everything that a signal can name is known.
void Builder::target_signal(const Element& element, Motor& motor) {
  const auto text = reader(element).text("target-signal");
  if (!text.given()) return;
  const Dimension wanted = target_dimension(model_, motor);
  const auto parse = [&](const SignalScope& scope) -> Result<std::string> {
    const auto parsed = Signal::parse(scope, *text);
    if (!parsed) return tl::unexpected(parsed.error());
    const auto unit = units::parse_unit(parsed->unit());
    const bool number = parsed->unit() == "1";
    if (!number && (!unit || units::fits(unit->dimension, wanted))) return parsed->text();
    const std::string si = units::unit_of(wanted);
    return fail("the target is " + units::describe(wanted) + ", but the signal " +
                    (number ? "has no unit" : "is in " + parsed->unit()),
                "",
                number ? "multiply it by one: 1 " + si + " * (" + *text + ")"
                       : "the unit of the signal must be that of " + si);
  };
  if (const auto full = with_signals("CG1201", element, "target-signal", *text, {}, parse))
    motor.target_signal = *full;
}

}  // namespace cogrsim::dsl
