// The table's part about what a person does in a run, and about tests.
#include "protocol_hands.h"

namespace cogrsim::studio {

namespace {

constexpr bool kEverybody = true, kOperatorsAlone = false;
constexpr double kFar = 1e9;  // [m], and of targets

FieldBounds far() { return {-kFar, kFar}; }

}  // namespace

void add_hand_requests(std::vector<ProtocolRequest>& requests) {
  FieldBounds engines;
  engines.fewest_entries = 1;
  engines.most_entries = 50;
  requests.insert(
      requests.end(),
      {{"motor",
        Section::run,
        kOperatorsAlone,
        {{"motor", "string", "dotted name"}, {"target", "number", "in its unit", nullptr, far()}},
        {{"target", "number", "as it is limited"}},
        "sets a motor's target before the next step, until a controller or something else sets it"},
       {"input",
        Section::run,
        kOperatorsAlone,
        {{"controller", "string", "dotted name"},
         {"input", "string", "name"},
         {"value", "number", "in its unit", nullptr, far()}},
        {{"value", "number", "as it is limited"}},
        "sets an input of a controller (`controllers` in `status`) before the next step"},
       {"grab",
        Section::run,
        kOperatorsAlone,
        {{"body", "string", "dotted name"},
         {"point", "Vec3", "of it, in its frame [m]", nullptr, far()},
         {"target", "Vec3", "in the world [m]", nullptr, far()},
         {"stiffness?", "number | null", "[N/m]; null: by the mass", nullptr, {0.0, 1e9, true}}},
        {{"stiffness", "number", "[N/m], as it is limited by the step"},
         {"damping", "number", "[N s/m]"}},
        "pulls a body by a spring in every step, until `release`, or until this client leaves"},
       {"grab-move",
        Section::run,
        kOperatorsAlone,
        {{"target", "Vec3", "in the world [m]", nullptr, far()}},
        {},
        "where it is pulled to from now on"},
       {"release", Section::run, kOperatorsAlone, {}, {}, "ends the pulling of this client"},
       {"repeat",
        Section::run,
        kOperatorsAlone,
        {},
        {{"inputs", "integer"}},
        "`restart`, with all that was done by hand in this run, or in the one before: the same "
        "states come again. Refused after an edit or a change of the engine in the run"},
       {"tests",
        Section::document,
        kEverybody,
        {},
        {{"version", "integer", "of the text"}, {"tests", "SceneTest[]"}},
        "those of the present text; none while it has errors"},
       {"test",
        Section::document,
        kOperatorsAlone,
        {{"test", "integer", "index in `tests`", nullptr, {0, 1e6}},
         {"backends", "string[]", "several: for `agree` alone", nullptr, engines},
         {"version", "integer", "of the text that `tests` were of"}},
        {{"status", "\"passed\" | \"failed\" | \"error\""},
         {"message", "string", "why there is no verdict"},
         {"verdicts", "TestVerdict[]"},
         {"errors", "string[]", "of the run, that the test does not check"}},
        "runs a test of the present text from its start, in a process of its own, and answers when "
        "it is over"},
       {"test-cancel", Section::document, kOperatorsAlone, {}, {}, "ends the test that runs"}});
}

void add_hand_types(std::vector<ProtocolType>& types) {
  const std::vector<ProtocolType> more = {
      {"FrameJoint",
       "",
       {{"position", "(number | null)[]", "coordinates [rad] or [m]"},
        {"speed", "(number | null)[]"}}},
      {"ControllerInput",
       "",
       {{"name", "string"},
        {"unit", "string"},
        {"lower", "number"},
        {"upper", "number"},
        {"value", "number"}}},
      {"ControllerInputs",
       "A controller that has inputs",
       {{"controller", "string", "dotted name"}, {"inputs", "ControllerInput[]"}}},
      {"SceneTest",
       "A `<test>` of the scene",
       {{"name", "string"},
        {"line", "integer"},
        {"expectations", "integer", "without `agree`: each engine is judged alone"},
        {"agrees", "integer", "`agree`: needs several engines"},
        {"backends", "string[]", "that it is for; empty: all"}}},
      {"TestVerdict",
       "",
       {{"expectation", "string"},
        {"passed", "boolean"},
        {"message", "string"},
        {"time", "number | null", "when it was decided [s]"},
        {"line", "integer", "0: none"},
        {"column", "integer"}}}};
  types.insert(types.end(), more.begin(), more.end());
}

}  // namespace cogrsim::studio
