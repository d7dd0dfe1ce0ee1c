// Codes of regions, rules and templates: CG13.
#include "language/codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> event_codes() {
  const Severity error = Severity::error, warning = Severity::warning;
  return {
      {"CG1301", error, "a region without a shape",
       "A region is a box with a `size` or a ball with a `radius`.",
       "Add one of the two attributes.",
       "bad:  <region name=\"goal\"/>\ngood: <region name=\"goal\" size=\"1 1 1 m\"/>"},
      {"CG1302", error, "an object that does not exist",
       "A region, rule or action names an object that the scene does not have and that none of its "
       "<spawn> or <attach> actions creates.",
       "Correct the name.",
       "bad:  <region name=\"goal\" size=\"1 1 1 m\" who=\"\"/>\n"
       "good: <region name=\"goal\" size=\"1 1 1 m\" who=\"robot\"/>"},
      {"CG1303", error, "a rule without a trigger, or with two",
       "An <on> fires on an `event`, at a `time` (repeated with `every`), or `when` a condition "
       "becomes true. It has exactly one of these triggers.",
       "Keep one trigger; for two triggers write two rules. If a condition must hold in addition "
       "to an event or a time, write it as `if`.",
       "bad:  <on event=\"opened(gate)\" time=\"2 s\"> … </on>\n"
       "good: <on event=\"opened(gate)\" if=\"time ge 2 s\"> … </on>"},
      {"CG1304", error, "a rule that does nothing", "This <on> has no action.",
       "Add one: open, close, spawn, remove, attach, detach, limit, make-static, make-dynamic, "
       "drive, switch, raise, log or end.",
       "good: <on time=\"5 s\"> <log message=\"five seconds\"/> </on>"},
      {"CG1305", error, "an unknown event",
       "An event is written KIND, KIND(SOURCE) or KIND(SOURCE, SUBJECT), and this kind does not "
       "exist or has no subject.",
       "The scene language reference lists the kinds under <on>.",
       "bad:  <on event=\"open(gate)\"> … </on>\ngood: <on event=\"opened(gate)\"> … </on>"},
      {"CG1306", error, "a template that cannot be used",
       "A <spawn> does not name a template of the scene, or a template is empty.",
       "Correct the name, or write the <template>.",
       "good: <template name=\"Ball\"> <sphere radius=\"5 cm\"/> </template>\n"
       "      <on time=\"1 s\"> <spawn of=\"Ball\" xyz=\"0 0 1\"/> </on>"},
      {"CG1307", error, "an action with missing or conflicting attributes",
       "A spawn is placed `at` a named frame, `in` one of several regions, or at `xyz`; a limit "
       "changes `lower`, `upper` or both; an axis must exist.",
       "Correct the attribute that the message names.",
       "bad:  <spawn of=\"Ball\"/>\ngood: <spawn of=\"Ball\" xyz=\"0 0 1\"/>"},
      {"CG1308", error, "a condition that cannot be parsed",
       "`when` and `if` compare signals: distance(robot, wall) lt 20 cm.",
       "Correct what the message names; the page on scene tests describes conditions.",
       "bad:  <on when=\"robot.sped gt 1\"> … </on>\n"
       "good: <on when=\"robot.speed gt 1 m/s\"> … </on>"},
      {"CG2030", warning, "an object that only a supervisor could add",
       "A region, rule or action names an object that the scene does not have and that none of its "
       "<spawn> or <attach> actions creates. The supervisor of the scene may add it; otherwise the "
       "rule never fires and the action is refused.",
       "Correct the name, or list it in `added` if a supervisor adds it.",
       "<on event=\"enter(goal, parcel)\" added=\"parcel\"> <log message=\"it is here\"/> </on>"},
  };
}

}  // namespace cogrsim::dsl
