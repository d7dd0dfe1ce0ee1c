// The table's part about debugging.
#include "protocol_debug.h"

namespace cogrsim::studio {

namespace {

constexpr bool kOperatorsOnly = false;
constexpr double kMostLine = 1e7;

ProtocolField frame_field() { return {"frame?", "integer", "index in `frames`", "0", {0, 99}}; }

}  // namespace

void add_debug_requests(std::vector<ProtocolRequest>& requests) {
  FieldBounds few;
  few.most_entries = 200;
  const std::vector<ProtocolField> variables = {{"variables", "DebugVariable[]"},
                                                {"more", "boolean", "there are others"}};
  requests.insert(
      requests.end(),
      {{"debug-attach",
        Section::debug,
        kOperatorsOnly,
        {{"controller", "string", "dotted name"}},
        {},
        "gdb attaches to the controller's process, and to each that replaces it. `debug` says what "
        "came of it"},
       {"debug-detach",
        Section::debug,
        kOperatorsOnly,
        {},
        {},
        "gdb ends, and the controller goes on"},
       {"debug-breakpoints",
        Section::debug,
        kOperatorsOnly,
        {{"breakpoints", "DebugBreakpointWish[]", "", nullptr, few}},
        {},
        "these instead of all before; also without a controller in the debugger"},
       {"debug-run",
        Section::debug,
        kOperatorsOnly,
        {{"how", "\"continue\" | \"over\" | \"into\" | \"out\" | \"pause\""}},
        {},
        "of the controller. A step that leaves its sources ends where they are entered next. A "
        "pause "
        "between two updates takes effect with the next"},
       {"debug-variables",
        Section::debug,
        kOperatorsOnly,
        {frame_field()},
        variables,
        "arguments and locals, while it stands"},
       {"debug-children",
        Section::debug,
        kOperatorsOnly,
        {{"of", "string", "`children` of a variable"}},
        variables,
        "members or elements, 200 at most"},
       {"debug-evaluate",
        Section::debug,
        kOperatorsOnly,
        {{"expression", "string"}, frame_field()},
        {{"variable", "DebugVariable"}},
        "an expression of C++; calls in it are made"}});
}

void add_debug_types(std::vector<ProtocolType>& types) {
  types.insert(
      types.end(),
      {{"DebugBreakpointWish",
        "",
        {{"file", "string", "as in `sources`"},
         {"line", "integer", "", nullptr, {1, kMostLine}},
         {"condition?", "string", "an expression of C++", "\"\""}}},
       {"DebugBreakpoint",
        "",
        {{"file", "string"},
         {"line", "integer", "where it is wanted"},
         {"condition", "string"},
         {"placed", "integer | null", "the line where it is"},
         {"note", "string", "why it is not there, or not where it was wanted"}}},
       {"DebugFrame",
        "",
        {{"function", "string"},
         {"file", "string", "as in `sources`; \"\": not one of them"},
         {"line", "integer", "0: not known"}}},
       {"DebugVariable",
        "",
        {{"name", "string"},
         {"value", "string"},
         {"type", "string"},
         {"argument", "boolean"},
         {"children", "string", "for `debug-children`, until it goes on; \"\": has none"}}},
       {"DebugValue", "", {{"name", "string"}, {"unit", "string"}, {"value", "number | null"}}},
       {"DebugReading",
        "",
        {{"sensor", "string"},
         {"time", "number", "of the measurement [s]"},
         {"valid", "boolean"},
         {"count", "integer", "of values"},
         {"values", "DebugValue[]", "the first of them"}}},
       {"Debug",
        "Of the controller in the debugger",
        {{"state", "\"off\" | \"waiting\" | \"attaching\" | \"running\" | \"stopped\"",
          "waiting: for a process of the controller"},
         {"controller", "string"},
         {"process", "integer | null"},
         {"reason", "string", "why it stands: \"breakpoint\", \"SIGSEGV: Segmentation fault\""},
         {"crashed", "boolean", "it ends by that signal when it goes on"},
         {"note", "string", "what went wrong"},
         {"help", "string", "what can be done about it"},
         {"frames", "DebugFrame[]", "the innermost first"},
         {"breakpoints", "DebugBreakpoint[]"},
         {"time", "number | null", "of the run [s]"},
         {"readings", "DebugReading[]", "that the controller gets now"}}}});
}

}  // namespace cogrsim::studio
