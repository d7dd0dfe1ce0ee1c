// Events of a scene: regions, templates, rules and their actions.
#include "cogrsim/physics/frame.h"
#include "language/vocabulary_rows.h"

namespace cogrsim::dsl::rows {

namespace {

AttributeSpec target_name(std::string_view name, std::string_view doc) {
  return must(attr(name, Kind::reference, doc));
}

/// "enter leave (region; body), …": kinds with the same names in them together.
std::string event_kinds() {
  const auto word = [](EventParty party) -> std::string {
    switch (party) {
      case EventParty::none:
        return "";
      case EventParty::name:
        return "its name";
      case EventParty::region:
        return "region";
      case EventParty::door:
        return "door";
      case EventParty::joint:
        return "joint";
      case EventParty::thing:
        return "assembly or body";
      case EventParty::posed:
        return "assembly, body or frame";
      case EventParty::a_template:
        return "template";
      case EventParty::controller:
        return "controller or supervisor";
    }
    return "";
  };
  std::string out;
  const EventKind* before = nullptr;
  const auto names = [&] {
    if (before == nullptr || before->source == EventParty::none) return std::string();
    const std::string subject = word(before->subject);
    return " (" + word(before->source) + (subject.empty() ? "" : "; " + subject) + ")";
  };
  for (const EventKind& kind : kEventKinds) {
    if (kind.last) continue;  // no rule can act on it
    const bool same = before != nullptr && before->source != EventParty::none &&
                      before->source == kind.source && before->subject == kind.subject;
    out += before == nullptr ? "" : same ? " " : names() + ", ";
    out += kind.name;
    before = &kind;
  }
  return out + names();
}

}  // namespace

const Words& event_actions() {
  static const Words words = {"open",   "close", "spawn",       "remove",       "attach",
                              "detach", "limit", "make-static", "make-dynamic", "drive",
                              "switch", "raise", "log",         "end"};
  return words;
}

void add_events(std::vector<ElementSpec>& out, const Words& template_content) {
  const auto group = "Events";
  static const std::string event_doc =
      "KIND, KIND(SOURCE) or KIND(SOURCE, SUBJECT). Kinds (source; subject): " + event_kinds() +
      ". An assembly's name includes its parts.";
  AttributeSpec who = attr("who", Kind::references,
                           "Bodies, assemblies and frames that it detects by the position of their "
                           "origin (for an assembly: the origin of its first body). If left out: "
                           "everything that can move.");
  const AttributeSpec added =
      attr("added", Kind::text,
           "Names of objects that a supervisor adds during the run; objects that a <spawn> of the "
           "scene adds are known.");
  who.min_count = 0;
  who.max_count = 1000;
  out.push_back(element(
      group, "region",
      "A volume that detects objects entering and leaving it: events `enter` and `leave`. It does "
      "not collide, and it moves with the body it is mounted on.",
      named_always("Name of the region.") +
          Attributes{
              above_zero(numbers("size", kLength, 3, "Full extents of a box-shaped region.")),
              above_zero(
                  number("radius", kLength, "Radius of a spherical region, instead of a box.")),
              who, added} +
          placed(),
      {}, "<region name=\"goal\" xyz=\"2 0 0.2\" size=\"50 50 40 cm\" who=\"robot\"/>"));
  out.push_back(element(
      group, "template",
      "Objects that are not in the scene at the start and can be added during the run: see "
      "<spawn>. A template has its own frame and its own names; it can use the materials of the "
      "scene.",
      named_always("Name of the template."), template_content,
      "<template name=\"Ball\"> <sphere name=\"ball\" radius=\"5 cm\"/> </template>"));
  out.push_back(element(
      group, "on",
      "A rule: actions on an event, at a time, or when a condition becomes true. The actions are "
      "carried out between two steps, in order.",
      named() + Attributes{attr("event", Kind::text, event_doc),
                           at_least(number("time", kTime,
                                           "Time at which it fires; with `every`, the first time."),
                                    0.0),
                           above_zero(number("every", kTime, "Fires repeatedly with this period.")),
                           attr("when", Kind::text,
                                "Condition; the rule fires whenever it becomes true."),
                           attr("if", Kind::text, "Condition that must hold at the event or time."),
                           at_least(number("after", kTime, "Delay of the actions.", "0 s"), 0.0),
                           at_least(attr("limit", Kind::integer,
                                         "Largest number of times that it fires.", "1000"),
                                    1.0),
                           added},
      event_actions(),
      "<on event=\"enter(walls.T1, robot)\" limit=\"1\"> <open door=\"walls.A\"/> </on>"));

  const auto action = [&](std::string_view name, std::string_view doc, Attributes attributes,
                          std::string_view example) {
    out.push_back(element(group, name, doc, std::move(attributes), {}, example));
  };
  action("open", "Opens a door.", {target_name("door", "The door.")}, "<open door=\"walls.A\"/>");
  action("close", "Closes a door.", {target_name("door", "The door.")},
         "<close door=\"walls.A\"/>");
  AttributeSpec in = attr("in", Kind::references,
                          "Candidate positions, one of which is drawn at random from those with "
                          "enough clearance: MAZE.free for a maze's cells without a name, MAZE for "
                          "all its cells, or named frames and regions.");
  in.max_count = 1000;
  action("spawn", "Adds a copy of a template where there is enough clearance.",
         Attributes{
             target_name("of", "The template."),
             attr("name", Kind::reference, "Name of the copy; TEMPLATE_1 and so on if left out."),
             attr("at", Kind::reference, "Named frame at which it is placed."), in} +
             placed() +
             Attributes{at_least(number("clearance", kLength,
                                        "Horizontal distance that must be free around it.", "0 m"),
                                 0.0),
                        above_zero(number("lifetime", kTime,
                                          "Time after which it is removed; never if left out."))},
         "<spawn of=\"Ball\" in=\"walls.free\" xyz=\"0 0 5 cm\" clearance=\"3 cm\"/>");
  action("remove", "Removes an assembly, or a body that belongs to no assembly.",
         {target_name("name", "Assembly or body.")}, "<remove name=\"gate\"/>");
  AttributeSpec reach = number("reach", kLength,
                               "Largest distance between the two; the action is refused beyond it. "
                               "No limit if left out.");
  action("attach", "Adds a joint between two bodies at their current poses.",
         {target_name("name", "Name of the new joint."),
          target_name("parent", "Parent body, frame or assembly."),
          target_name("child", "Child body, frame or assembly."),
          choice("type", {"fixed", "hinge", "ball"}, "Type of the joint.", "fixed"),
          numbers("point", kLength, 3,
                  "Position of a hinge or ball joint in the parent's frame; the child's origin if "
                  "left out."),
          numbers("axis", kNone, 3, "Axis of a hinge, in the parent's frame.", "0 0 1"),
          at_least(reach, 0.0)},
         "<attach name=\"grip\" parent=\"robot.hand\" child=\"crate\" reach=\"2 cm\"/>");
  action("detach", "Removes a joint and its motors.", {target_name("joint", "The joint.")},
         "<detach joint=\"grip\"/>");
  action(
      "limit", "Changes the limits of a joint.",
      {target_name("joint", "The joint."),
       between(attr("axis", Kind::integer, "Degree of freedom of the joint, counted from 1.", "1"),
               1, 3),
       or_none(either("lower", {kAngle, kLength}, "Lower limit; unchanged if left out.")),
       or_none(either("upper", {kAngle, kLength}, "Upper limit; unchanged if left out."))},
      "<limit joint=\"lift\" upper=\"80 cm\"/>");
  action("make-static", "Makes a body or a whole assembly static at its current pose.",
         {target_name("name", "Body or assembly.")}, "<make-static name=\"crate\"/>");
  action("make-dynamic", "Makes a static body or assembly dynamic again.",
         {target_name("name", "Body or assembly.")}, "<make-dynamic name=\"crate\"/>");
  action("drive", "Sets the target of a motor or servo.",
         {target_name("motor", "The motor."),
          must(either("target", {kAngularSpeed, kSpeed, kTorque, kForce, kAngle, kLength, kVoltage},
                      "Target, in the unit of the motor's mode."))},
         "<drive motor=\"lift.motor\" target=\"20 cm\"/>");
  action("switch", "Switches a sensor on or off.",
         {target_name("sensor", "The sensor."), attr("on", Kind::boolean, "On or off.", "true")},
         "<switch sensor=\"robot.eye\" on=\"false\"/>");
  action("raise", "Raises a user-defined event: raised(NAME).",
         {must(attr("event", Kind::name, "Name of the event.")),
          attr("message", Kind::text, "Message of the event; none if left out.")},
         "<raise event=\"ready\"/>");
  action("log", "Logs a message.", {must(attr("message", Kind::text, "The message."))},
         "<log message=\"the doors open\"/>");
  action("end", "Ends the run.", {attr("reason", Kind::text, "Reason; none if left out.")},
         "<end reason=\"goal reached\"/>");
}

}  // namespace cogrsim::dsl::rows
