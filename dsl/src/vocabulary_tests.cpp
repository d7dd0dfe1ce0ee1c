// Tests and measures of the scene language.
#include "vocabulary_rows.h"

namespace cogrsim::dsl::rows {
namespace {

/// A value in the unit of a signal, whatever that is.
AttributeSpec of_signal(std::string_view name, std::string_view doc) {
  return either(
      name, {kLength, kAngle, kTime, kSpeed, kAngularSpeed, kMass, kForce, kTorque, kNone}, doc);
}

AttributeSpec added() {
  return attr("added", Kind::text,
              "Names of things that a supervisor adds while it runs; what a <spawn> of the scene "
              "adds is known.");
}

AttributeSpec when(std::string_view name, std::string_view doc) {
  return at_least(number(name, kTime, doc), 0.0);
}

}  // namespace

void add_tests(std::vector<ElementSpec>& out) {
  const auto group = "Results";
  const AttributeSpec that =
      must(attr("that", Kind::text, "Condition on the run's signals, see scene-tests.md."));
  out.push_back(element(
      group, "test", "What must be true of a run; `cogrsim test` sees to it.",
      {must(attr("name", Kind::text, "What it is about, in words; unique in the scene.")),
       up_to(above_zero(number("duration", kTime, "Length of the run; the scene's if left out.")),
             1e9),
       attr("backends", Kind::text, "Engines it holds on; all if left out."),
       attr("seeds", Kind::text,
            "Seeds it holds for, \"1 .. 5\" or \"1 3 7\"; the scene's if left out."),
       added()},
      {"expect", "always", "eventually", "agree"},
      "<test name=\"parks\" seeds=\"1 .. 5\"> <always that=\"abs(bot.roll) lt 10 deg\"/> </test>"));
  out.push_back(element(
      group, "expect", "Holds at one time.",
      {must(attr("that", Kind::text,
                 "Condition on the run's signals, see scene-tests.md; with `equals` a signal.")),
       of_signal("equals", "Value that the signal must have."),
       at_least(of_signal("tolerance", "How far from `equals` it may be."), 0.0),
       when("at", "Time; the end of the run if left out.")},
      {}, "<expect that=\"mass(robot)\" equals=\"1.58 kg\" tolerance=\"1 g\"/>"));
  out.push_back(element(group, "always", "Holds in every frame.",
                        {that, when("until", "Until then; to the end of the run if left out.")}, {},
                        "<always that=\"abs(robot.roll) lt 10 deg\"/>"));
  out.push_back(element(group, "eventually", "Holds in some frame.",
                        {that, when("within", "By then; by the end of the run if left out.")}, {},
                        "<eventually that=\"distance(robot, wall) lt 20 cm\" within=\"15 s\"/>"));
  out.push_back(
      element(group, "agree",
              "A signal is the same on all engines; for short times, since contacts part them.",
              {must(attr("on", Kind::text, "Signal, or PLACE.position for all of x, y and z.")),
               must(at_least(of_signal("tolerance", "How far apart they may be."), 0.0)),
               when("until", "Until then; to the end of the run if left out.")},
              {}, "<agree on=\"robot.position\" until=\"1 s\" tolerance=\"1 cm\"/>"));
  out.push_back(element(
      group, "measure", "A number of merit of a whole run, for parameter studies.",
      named_always("Name of the number.") +
          Attributes{
              must(attr("signal", Kind::text, "What is measured; of first-time a condition.")),
              choice("take", {"last", "minimum", "maximum", "mean", "integral", "first-time"},
                     "What is made of its values; first-time: when the condition first held.",
                     "last"),
              added()},
      {}, "<measure name=\"time\" signal=\"inside(bot, goal)\" take=\"first-time\"/>"));
}

}  // namespace cogrsim::dsl::rows
