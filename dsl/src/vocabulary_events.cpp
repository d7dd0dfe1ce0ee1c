// What happens while a scene runs: regions, templates, rules and their actions.
#include "cogrsim/physics/frame.h"
#include "vocabulary_rows.h"

namespace cogrsim::dsl::rows {

namespace {

AttributeSpec target_name(std::string_view name, std::string_view doc) {
  return must(attr(name, Kind::reference, doc));
}

/// "enter leave (region, place), …": kinds with the same names in them together.
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
      case EventParty::place:
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
  static const Words words = {"open",   "close",    "spawn", "remove", "attach", "detach", "limit",
                              "freeze", "unfreeze", "drive", "switch", "raise",  "tell",   "end"};
  return words;
}

void add_events(std::vector<ElementSpec>& out, const Words& template_content) {
  const auto group = "Events";
  static const std::string event_doc =
      "KIND, KIND(SOURCE) or KIND(SOURCE, SUBJECT). Kinds (source; subject): " + event_kinds() +
      ". An assembly's name means its parts too.";
  AttributeSpec who = attr("who", Kind::references,
                           "Bodies, assemblies and frames it looks for, by where their origin is "
                           "(of an assembly: that of its first body). If left out: whatever can "
                           "move.");
  const AttributeSpec added =
      attr("added", Kind::text,
           "Names of things that a supervisor adds while it runs; what a <spawn> of the scene adds "
           "is known.");
  who.min_count = 0;
  who.max_count = 1000;
  out.push_back(element(
      group, "region",
      "A volume that notices who comes in and who goes out: events `enter` and `leave`. It stands "
      "in nobody's way and moves with what it stands on.",
      named_always("Name of the region.") +
          Attributes{above_zero(numbers("size", kLength, 3, "Full extents of a box.")),
                     above_zero(number("radius", kLength, "Of a ball, instead of a box.")), who,
                     added} +
          placed(),
      {}, "<region name=\"goal\" xyz=\"2 0 0.2\" size=\"50 50 40 cm\" who=\"robot\"/>"));
  out.push_back(element(
      group, "template",
      "Something that is not there at the start and can come while the scene runs: see <spawn>. "
      "Inside, places are in its own frame and names its own; materials of the scene are known.",
      named_always("Name of the template."), template_content,
      "<template name=\"Ball\"> <sphere name=\"ball\" radius=\"5 cm\"/> </template>"));
  out.push_back(element(
      group, "on",
      "What the scene does by itself, on an event, at a time, or when something becomes true. Its "
      "actions are carried out between two steps, in order.",
      named() +
          Attributes{
              attr("event", Kind::text, event_doc),
              at_least(number("time", kTime, "At this time; with `every` the first time."), 0.0),
              above_zero(number("every", kTime, "Again and again with this period.")),
              attr("when", Kind::text, "Condition: fires whenever it becomes true."),
              attr("if", Kind::text, "Condition that must hold when the event or time comes."),
              at_least(number("after", kTime, "Delay of the actions.", "0 s"), 0.0),
              at_least(attr("limit", Kind::integer, "Fires that often at most.", "1000"), 1.0),
              added},
      event_actions(),
      "<on event=\"enter(walls.T1, robot)\" limit=\"1\"> <open door=\"walls.A\"/> </on>"));

  const auto action = [&](std::string_view name, std::string_view doc, Attributes attributes,
                          std::string_view example) {
    out.push_back(element(group, name, doc, std::move(attributes), {}, example));
  };
  action("open", "Sends a door to its open end.", {target_name("door", "The door.")},
         "<open door=\"walls.A\"/>");
  action("close", "Sends a door to its closed end.", {target_name("door", "The door.")},
         "<close door=\"walls.A\"/>");
  AttributeSpec in = attr("in", Kind::references,
                          "Places of which one is drawn where there is room: MAZE.free, a maze's "
                          "cells without a name, MAZE, all its cells, or any places by name.");
  in.max_count = 1000;
  action("spawn", "Adds a copy of a template, where there is room.",
         Attributes{
             target_name("of", "The template."),
             attr("name", Kind::reference, "Name of the copy; TEMPLATE_1 and so on if left out."),
             attr("at", Kind::reference, "Named place where it stands."), in} +
             placed() +
             Attributes{at_least(number("clearance", kLength,
                                        "Kept free around it, level with the ground.", "0 m"),
                                 0.0),
                        above_zero(number("lifetime", kTime,
                                          "Is removed after this time; never if left out."))},
         "<spawn of=\"Ball\" in=\"walls.free\" xyz=\"0 0 5 cm\" clearance=\"3 cm\"/>");
  action("remove", "Takes out an assembly, or a body that belongs to none.",
         {target_name("name", "Assembly or body.")}, "<remove name=\"gate\"/>");
  AttributeSpec reach =
      number("reach", kLength, "Refused when they are farther apart; no bound if left out.");
  action(
      "attach", "Joins two bodies where they are.",
      {target_name("name", "Name of the new joint."),
       target_name("parent", "Body, frame or assembly that carries."),
       target_name("child", "Body, frame or assembly that is carried."),
       choice("type", {"fixed", "hinge", "ball"}, "How they are joined.", "fixed"),
       numbers("point", kLength, 3,
               "Place of a hinge or ball in the parent's frame; the child's origin if left out."),
       numbers("axis", kNone, 3, "Axis of a hinge, in the parent's frame.", "0 0 1"),
       at_least(reach, 0.0)},
      "<attach name=\"grip\" parent=\"robot.hand\" child=\"crate\" reach=\"2 cm\"/>");
  action("detach", "Takes out a joint, with its motors.", {target_name("joint", "The joint.")},
         "<detach joint=\"grip\"/>");
  action("limit", "Gives a joint other limits.",
         {target_name("joint", "The joint."),
          between(attr("axis", Kind::integer, "Which of its freedoms, from 1.", "1"), 1, 3),
          or_none(either("lower", {kAngle, kLength}, "Lower limit; stays if left out.")),
          or_none(either("upper", {kAngle, kLength}, "Upper limit; stays if left out."))},
         "<limit joint=\"lift\" upper=\"80 cm\"/>");
  action("freeze", "Makes a body, or all of an assembly, static where it is.",
         {target_name("name", "Body or assembly.")}, "<freeze name=\"crate\"/>");
  action("unfreeze", "Lets what was frozen move again.", {target_name("name", "Body or assembly.")},
         "<unfreeze name=\"crate\"/>");
  action("drive", "Sets the target of a motor or servo.",
         {target_name("motor", "The motor."),
          must(either("target", {kAngularSpeed, kSpeed, kTorque, kForce, kAngle, kLength, kVoltage},
                      "What its mode means by a target."))},
         "<drive motor=\"lift.motor\" target=\"20 cm\"/>");
  action("switch", "Switches a sensor on or off.",
         {target_name("sensor", "The sensor."), attr("on", Kind::boolean, "On or off.", "true")},
         "<switch sensor=\"robot.eye\" on=\"false\"/>");
  action("raise", "Raises an event of the scene's own: raised(NAME).",
         {must(attr("event", Kind::name, "Its name.")),
          attr("message", Kind::text, "What to say of it; nothing if left out.")},
         "<raise event=\"ready\"/>");
  action("tell", "Says something to the user.", {must(attr("message", Kind::text, "What."))},
         "<tell message=\"the doors open\"/>");
  action("end", "Ends the run.", {attr("reason", Kind::text, "Why; nothing is said if left out.")},
         "<end reason=\"goal reached\"/>");
}

}  // namespace cogrsim::dsl::rows
