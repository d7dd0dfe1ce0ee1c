// Codes of what happens while a scene runs: CG13.
#include "codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> event_codes() {
  const Severity error = Severity::error, advice = Severity::advice;
  return {
      {"CG1301", error, "a region without a shape",
       "A region is a box, which has a `size`, or a ball, which has a `radius`: one of the two.",
       "Give it one of them.",
       "bad:  <region name=\"goal\"/>\ngood: <region name=\"goal\" size=\"1 1 1 m\"/>"},
      {"CG1302", error, "something that is not there",
       "A region, rule or action names something that the scene does not have and that no <spawn> "
       "or <attach> of it can make.",
       "Correct the name.",
       "bad:  <region name=\"goal\" size=\"1 1 1 m\" who=\"\"/>\n"
       "good: <region name=\"goal\" size=\"1 1 1 m\" who=\"robot\"/>"},
      {"CG1303", error, "a rule without a trigger, or with two",
       "An <on> fires on an `event`, at a `time` (and `every` so often), or `when` a condition "
       "becomes true. It has one of these, not several.",
       "Write one of them; make two rules of what should happen on either; write the condition "
       "that "
       "must hold beside an event or a time as `if`.",
       "bad:  <on event=\"opened(gate)\" time=\"2 s\"> … </on>\n"
       "good: <on event=\"opened(gate)\" if=\"time ge 2 s\"> … </on>"},
      {"CG1304", error, "a rule that does nothing", "There is no action in this <on>.",
       "Add one: open, close, spawn, remove, attach, detach, limit, freeze, unfreeze, drive, "
       "switch, "
       "raise, tell or end.",
       "good: <on time=\"5 s\"> <tell message=\"five seconds\"/> </on>"},
      {"CG1305", error, "an event there is none of",
       "An event is written KIND, KIND(SOURCE) or KIND(SOURCE, SUBJECT), and this kind does not "
       "exist or has no subject.",
       "The kinds are listed with <on> in the reference of the scene language.",
       "bad:  <on event=\"open(gate)\"> … </on>\ngood: <on event=\"opened(gate)\"> … </on>"},
      {"CG1306", error, "a template that cannot be used",
       "A <spawn> names no template of the scene, or a template has nothing in it.",
       "Correct the name, or write the <template>.",
       "good: <template name=\"Ball\"> <sphere radius=\"5 cm\"/> </template>\n"
       "      <on time=\"1 s\"> <spawn of=\"Ball\" xyz=\"0 0 1\"/> </on>"},
      {"CG1307", error, "an action that lacks something, or has too much",
       "A spawn stands `at` a place, `in` one of several, or at `xyz`; a limit changes `lower`, "
       "`upper` or both; an axis must exist.",
       "See the message.", "bad:  <spawn of=\"Ball\"/>\ngood: <spawn of=\"Ball\" xyz=\"0 0 1\"/>"},
      {"CG1308", error, "a condition that cannot be read",
       "`when` and `if` compare signals: distance(robot, wall) lt 20 cm.",
       "Correct what the message names; the page on scene tests shows what can be written.",
       "bad:  <on when=\"robot.sped gt 1\"> … </on>\n"
       "good: <on when=\"robot.speed gt 1 m/s\"> … </on>"},
      {"CG2030", advice, "something that only a supervisor could bring",
       "A region, rule or action names something that the scene does not have and that no <spawn> "
       "or <attach> of it makes. The scene has a supervisor, which may add anything; if it does "
       "not, the rule never fires and the action is refused.",
       "Correct the name, or list it in `added` if a supervisor adds it.",
       "<on event=\"enter(goal, parcel)\" added=\"parcel\"> <tell message=\"it is here\"/> </on>"},
  };
}

}  // namespace cogrsim::dsl
