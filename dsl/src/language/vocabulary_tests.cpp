// Tests and measures of the scene language.
#include "language/vocabulary_rows.h"

namespace cogrsim::dsl::rows {
namespace {

/// A value in the unit of a signal, whatever that is.
AttributeSpec of_signal(std::string_view name, std::string_view doc) {
  return either(
      name, {kLength, kAngle, kTime, kSpeed, kAngularSpeed, kMass, kForce, kTorque, kNone}, doc);
}

AttributeSpec added() {
  return attr("added", Kind::text,
              "Names of objects that a supervisor adds during the run; objects that a <spawn> of "
              "the scene adds are known.");
}

AttributeSpec when(std::string_view name, std::string_view doc) {
  return at_least(number(name, kTime, doc), 0.0);
}

/// A distribution of values of any quantity.
AttributeSpec distribution(std::string_view name, std::string_view doc) {
  AttributeSpec a = attr(name, Kind::noise, doc);
  a.dimensions = {kNone,
                  kMass,
                  kLength,
                  kForce,
                  kTorque,
                  kStiffness,
                  kAngularStiffness,
                  kDamping,
                  kAngularDamping,
                  kInertia,
                  kSpeed,
                  kTime,
                  kDensity,
                  kAngularSpeed,
                  kIntegralGain,
                  kAngularIntegralGain,
                  kLinearDensity};
  return a;
}

}  // namespace

void add_tests(std::vector<ElementSpec>& out) {
  const auto group = "Results";
  const AttributeSpec that =
      must(attr("that", Kind::text, "Condition on the run's signals, see scene-tests.md."));
  out.push_back(element(
      group, "test", "Expectations on a run; `cogrsim test` checks them.",
      {must(attr("name", Kind::text, "Description, unique in the scene.")),
       up_to(above_zero(number("duration", kTime, "Length of the run; the scene's if left out.")),
             1e9),
       attr("backends", Kind::text, "Engines that it runs on; all if left out."),
       attr("seeds", Kind::text,
            "Seeds that it runs with, \"1 .. 5\" or \"1 3 7\"; the scene's seed if left out."),
       added()},
      {"expect", "always", "eventually", "agree"},
      "<test name=\"parks\" seeds=\"1 .. 5\"> <always that=\"abs(bot.roll) lt 10 deg\"/> </test>"));
  out.push_back(element(
      group, "expect", "A condition that must hold at one time.",
      {must(attr("that", Kind::text,
                 "Condition on the run's signals, see scene-tests.md; with `equals` a signal.")),
       of_signal("equals", "Expected value of the signal."),
       at_least(of_signal("tolerance", "Largest allowed difference from `equals`."), 0.0),
       when("at", "Time; the end of the run if left out.")},
      {}, "<expect that=\"mass(robot)\" equals=\"1.58 kg\" tolerance=\"1 g\"/>"));
  out.push_back(
      element(group, "always", "A condition that must hold in every frame.",
              {that, when("until", "End of the interval; the end of the run if left out.")}, {},
              "<always that=\"abs(robot.roll) lt 10 deg\"/>"));
  out.push_back(element(group, "eventually", "A condition that must hold in at least one frame.",
                        {that, when("within", "Latest time; the end of the run if left out.")}, {},
                        "<eventually that=\"distance(robot, wall) lt 20 cm\" within=\"15 s\"/>"));
  out.push_back(
      element(group, "agree",
              "A signal must agree on all engines; use short times, because contacts make the "
              "engines diverge.",
              {must(attr("on", Kind::text, "Signal, or NAME.position for all of x, y and z.")),
               must(at_least(of_signal("tolerance", "Largest allowed difference."), 0.0)),
               when("until", "End of the interval; the end of the run if left out.")},
              {}, "<agree on=\"robot.position\" until=\"1 s\" tolerance=\"1 cm\"/>"));
  out.push_back(element(
      group, "measure", "A figure of merit of a whole run, for parameter studies.",
      named_always("Name of the measure.") +
          Attributes{
              must(attr("signal", Kind::text,
                        "Signal that is measured; for first-time a condition.")),
              choice("take", {"last", "minimum", "maximum", "mean", "integral", "first-time"},
                     "Reduction of its values; first-time: the first time at which the condition "
                     "held.",
                     "last"),
              added()},
      {}, "<measure name=\"time\" signal=\"inside(bot, goal)\" take=\"first-time\"/>"));
  out.push_back(element(
      group, "randomize",
      "Draws quantities of the scene for each run, and in a batch for each episode: from the seed, "
      "so "
      "that a seed gives the same values on every engine.",
      {must(attr(
           "what", Kind::text,
           "Quantities; * stands for any characters. Of a body: mass (with its inertia), com.x "
           "com.y com.z, friction restitution rolling-friction spinning-friction (of its "
           "shapes), and without joints x y z; of an assembly x y z; of a material the same "
           "four of surfaces; of a joint damping friction stiffness rotor-inertia max-effort; "
           "of a motor max-effort max-speed delay, with a curve stall-effort no-load-speed, of a "
           "servo "
           "kp ki kd, too; of a spring stiffness "
           "damping, of a drag linear quadratic angular, of a buoyancy density "
           "level, of a wind x y z; of a sensor noise-sigma latency.")),
       distribution("by",
                    "Factor: uniform(low, high) normal(mean, sigma) loguniform(low, high) "
                    "choice(a, b, c). A number that gives an impossible value is drawn again."),
       distribution("to", "Value that replaces that of the scene."),
       distribution("add", "Difference to the value of the scene."),
       attr("together", Kind::boolean, "One number for all of them; else one for each.", "false")},
      {}, "<randomize what=\"robot.*.mass\" by=\"uniform(0.9, 1.1)\"/>"));
}

}  // namespace cogrsim::dsl::rows
