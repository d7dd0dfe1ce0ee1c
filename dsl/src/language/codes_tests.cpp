// Codes of tests in scenes: CG11.
#include "language/codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> test_codes() {
  const Severity error = Severity::error;
  return {
      {"CG1101", error, "a test that expects nothing",
       "A <test> without an expectation always passes.",
       "Write <expect>, <always>, <eventually> or <agree> into it.",
       "good: <test name=\"rests\"> <expect that=\"ball.speed lt 1 mm/s\"/> </test>"},
      {"CG1102", error, "an invalid expectation",
       "A condition or signal of a test or measure cannot be parsed, names an object that does not "
       "exist, or compares a length with an angle.",
       "Correct it; docs/guide/scene-tests.md describes conditions. List objects that a supervisor "
       "adds during the run in `added` of the test.",
       "bad:  <always that=\"robot.roll lt 10\"/>\ngood: <always that=\"robot.roll lt 10 deg\"/>"},
      {"CG1103", error, "a value without a tolerance, or a tolerance without a value",
       "`equals` is the expected value of a signal, `tolerance` the largest allowed difference; "
       "each needs the other.",
       "Write both, or compare in the condition.",
       "good: <expect that=\"mass(robot)\" equals=\"1.58 kg\" tolerance=\"1 g\"/>"},
      {"CG1104", error, "a time after the end of a test",
       "`at`, `until` or `within` lies beyond the duration of the test, so it would never be "
       "evaluated.",
       "Give the test a longer `duration`, or name an earlier time.",
       "bad:  <test name=\"a\" duration=\"2 s\"> <eventually that=\"…\" within=\"3 s\"/> </test>"},
      {"CG1105", error, "backends that cannot be compared",
       "`agree` compares engines with each other, but the test names only one, or names one twice.",
       "Name at least two different backends, or none to use all of them.",
       "good: <test name=\"a\" backends=\"bullet cogrsim\"> <agree …/> </test>"},
      {"CG1106", error, "seeds that are not a list of numbers",
       "Seeds are whole numbers from 0, as a list or as a range.",
       "Write \"1 3 7\" or \"1 .. 5\".", "bad:  seeds=\"five\"\ngood: seeds=\"1 .. 5\""},
      {"CG1107", error, "a test without a unique name",
       "Reports and `cogrsim test --filter` distinguish tests by their names.",
       "Give each test of the scene another name.", "<test name=\"parks in front of the wall\"> …"},
  };
}

}  // namespace cogrsim::dsl
