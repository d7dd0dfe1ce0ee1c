// Codes of tests in scenes: CG11.
#include "codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> test_codes() {
  const Severity error = Severity::error;
  return {
      {"CG1101", error, "a test that expects nothing",
       "A <test> without an expectation passes whatever happens.",
       "Write <expect>, <always>, <eventually> or <agree> into it.",
       "good: <test name=\"rests\"> <expect that=\"ball.speed lt 1 mm/s\"/> </test>"},
      {"CG1102", error, "an expectation that means nothing",
       "A condition or signal of a test or measure does not parse, names what is not there, or "
       "compares a length with an angle.",
       "Correct it; docs/scene-tests.md shows how conditions are written. What a supervisor adds "
       "while the scene runs is named in `added` of the test.",
       "bad:  <always that=\"robot.roll lt 10\"/>\ngood: <always that=\"robot.roll lt 10 deg\"/>"},
      {"CG1103", error, "a value without a tolerance, or a tolerance without a value",
       "`equals` says what a signal must be, `tolerance` how near it must come: one is nothing "
       "without the other.",
       "Write both, or compare in the condition.",
       "good: <expect that=\"mass(robot)\" equals=\"1.58 kg\" tolerance=\"1 g\"/>"},
      {"CG1104", error, "a time after the end of a test",
       "`at`, `until` or `within` lies beyond the duration of the test, so it would never be "
       "looked at.",
       "Give the test a longer `duration`, or name an earlier time.",
       "bad:  <test name=\"a\" duration=\"2 s\"> <eventually that=\"…\" within=\"3 s\"/> </test>"},
      {"CG1105", error, "backends that cannot be compared",
       "`agree` compares engines with each other, and the test names one alone; or one is named "
       "twice.",
       "Name two different ones, or none for all there are.",
       "good: <test name=\"a\" backends=\"bullet cogrsim\"> <agree …/> </test>"},
      {"CG1106", error, "seeds that are no list of numbers",
       "Seeds are whole numbers from 0, one by one or from the first to the last.",
       "Write \"1 3 7\" or \"1 .. 5\".", "bad:  seeds=\"five\"\ngood: seeds=\"1 .. 5\""},
      {"CG1107", error, "a test without a name of its own",
       "Reports and `cogrsim test --filter` tell tests apart by their names.",
       "Give each test of the scene another name.", "<test name=\"parks in front of the wall\"> …"},
  };
}

}  // namespace cogrsim::dsl
