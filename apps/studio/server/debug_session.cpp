#include "debug_session.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

constexpr int kMostFrames = 100;
constexpr std::size_t kMostVariables = 100;  // of a frame
constexpr int kMostChildren = 200;
constexpr std::size_t kMostValue = 1000;  // [byte] of a value that is shown
constexpr int kMostReturns = 20;
/// Large libraries have many symbols.
constexpr auto kToAttach = std::chrono::seconds(120);
constexpr auto kToStop = std::chrono::seconds(5);

std::string cut(std::string text) {
  if (text.size() > kMostValue) text = text.substr(0, kMostValue) + "…";
  return text;
}

/// As the compiler was given it; empty: it cannot be told.
std::string full_path(const std::string& path) {
  std::error_code error;
  return fs::absolute(path, error).lexically_normal().string();
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// Why the system lets no debugger in, and what the user can do.
Error refused(const std::string& said, int process) {
  const std::string what = "gdb cannot attach to the controller's process: " + first_line(said);
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  bool there = false;
  for (std::string line; std::getline(status, line);) {
    there = true;
    if (line.rfind("TracerPid:", 0) != 0) continue;
    if (const int tracer = std::atoi(line.c_str() + 10); tracer > 0)
      return Error(what, "", fmt::format("process {} debugs it already: end that first", tracer));
  }
  if (!there) return Error(what, "", "it has ended: restart the run");
  int scope = 0;
  std::ifstream("/proc/sys/kernel/yama/ptrace_scope") >> scope;
  if (scope >= 2)
    return Error(what, "",
                 fmt::format("the system lets nobody debug (ptrace_scope is {}): as root, sysctl "
                             "kernel.yama.ptrace_scope=1",
                             scope));
  if (said.find("permitted") != std::string::npos)
    return Error(what, "",
                 "the system forbids ptrace; in a container, start it with --cap-add=SYS_PTRACE");
  return Error(what);
}

}  // namespace

Json to_json(const DebugFrame& frame) {
  return {{"function", frame.function}, {"file", frame.file}, {"line", frame.line}};
}

Json to_json(const DebugBreakpoint& breakpoint) {
  return {{"file", breakpoint.file},
          {"line", breakpoint.line},
          {"condition", breakpoint.condition},
          {"placed", breakpoint.placed ? Json(*breakpoint.placed) : Json(nullptr)},
          {"note", breakpoint.note}};
}

Result<std::unique_ptr<DebugSession>> DebugSession::attach(int process, const SourceFolder& sources,
                                                           GdbClient::Listener listener) {
  std::unique_ptr<DebugSession> session(new DebugSession(sources));
  auto gdb = GdbClient::start("gdb", std::move(listener));
  if (!gdb) return tl::unexpected(gdb.error());
  session->gdb_ = std::move(*gdb);
  if (auto good = session->prepare(process); !good) return tl::unexpected(good.error());
  return session;
}

Result<> DebugSession::prepare(int process) {
  // Commands may come while the process runs; nothing asks, and nothing is downloaded.
  for (const char* setting :
       {"mi-async on", "confirm off", "width 0", "height 0", "print elements 200"}) {
    if (auto good = gdb_->command(std::string("-gdb-set ") + setting); !good)
      return tl::unexpected(good.error());
  }
  static_cast<void>(gdb_->command("-gdb-set debuginfod enabled off"));  // since gdb 10
  static_cast<void>(gdb_->command("-enable-pretty-printing"));
  // Steps go into the user's functions alone.
  for (const char* skipped : {"std", "__gnu_cxx", "Eigen"})
    static_cast<void>(
        gdb_->command(fmt::format("-interpreter-exec console \"skip -rfu ^{}::\"", skipped)));
  auto attached = gdb_->command(fmt::format("-target-attach {}", process), kToAttach);
  if (!attached) return tl::unexpected(refused(attached.error().message, process));
  if (!gdb_->wait_until_stopped(kToAttach))
    return fail("the process did not stop for gdb", "", "press End, then Restart, then Debug");
  attached_ = true;
  return {};
}

DebugSession::~DebugSession() {
  if (!attached_ || !gdb_->alive()) return;
  if (!gdb_->stopped()) {
    static_cast<void>(gdb_->command("-exec-interrupt", kToStop));
    gdb_->wait_until_stopped(kToStop);
  }
  static_cast<void>(gdb_->command("-target-detach", kToStop));
}

// ---- what gdb reports

DebugSession::Event DebugSession::take(const MiRecord& record) {
  if (record.kind == MiRecord::Kind::log) {
    if (complaints_.size() < 4000) complaints_ += record.what.substr(0, 4000);
    return {};
  }
  if (record.kind != MiRecord::Kind::exec) return {};
  if (record.what == "running") return {Event::Kind::running, {}, {}};
  if (record.what == "stopped") return stopped(record.fields);
  return {};
}

DebugSession::Event DebugSession::stopped(const Json& fields) {
  const std::string reason = mi_text(fields, "reason");
  Event out;
  if (reason.rfind("exited", 0) == 0) {
    out.kind = Event::Kind::ended;
    out.ending = reason == "exited-signalled" ? "was ended by " + mi_text(fields, "signal-name")
                 : reason == "exited" ? "ended with exit code " + mi_text(fields, "exit-code")
                                      : "ended";
    return out;
  }
  if (reason.empty()) return {};  // it was attached
  if (std::string thread = mi_text(fields, "thread-id"); !thread.empty())
    thread_ = std::move(thread);
  const bool paused = pausing_ && reason == "signal-received";
  pausing_ = false;
  out.stop.frames = stack();
  const auto own = [](const DebugFrame& frame) { return !frame.file.empty(); };
  const auto outermost = std::find_if(out.stop.frames.rbegin(), out.stop.frames.rend(), own);
  const bool within = outermost != out.stop.frames.rend();
  if (paused && !within) {
    // It waits for the run: nothing to be seen before it is called again.
    if (auto next = stop_at_next_call(); next) return {};
  }
  const bool stepped = reason == "end-stepping-range" || reason == "function-finished";
  if (stepped && !own(out.stop.frames.empty() ? DebugFrame() : out.stop.frames.front())) {
    // A step that has left the sources: back to them, or on to where they are entered next.
    if (within && ++finishing_ <= kMostReturns && gdb_->command("-exec-finish")) return {};
    if (!within && stop_at_next_call()) return {};
  }
  // Back in the sources, in the middle of the line that was stepped from.
  if (reason == "function-finished" && finishing_ > 0 && !stepping_.empty() &&
      ++finishing_ <= kMostReturns && gdb_->command(stepping_))
    return {};
  finishing_ = 0;
  if (within) entry_ = outermost->function;
  for (const std::string& number : passing_)
    static_cast<void>(gdb_->command("-break-delete " + number));
  passing_.clear();
  out.kind = Event::Kind::stopped;
  if (reason == "breakpoint-hit") {
    const auto hit = placed_.find(mi_text(fields, "bkptno"));
    out.stop.reason = hit == placed_.end() ? "step" : "breakpoint";
    if (complaints_.find("Error in testing") != std::string::npos) out.stop.note = complaints_;
  } else if (stepped) {
    out.stop.reason = "step";
  } else if (paused) {
    out.stop.reason = "paused";
  } else {
    const std::string name = mi_text(fields, "signal-name");
    out.stop.reason = name.empty() ? reason : name + ": " + mi_text(fields, "signal-meaning");
    for (const char* fatal : {"SIGSEGV", "SIGABRT", "SIGFPE", "SIGILL", "SIGBUS", "SIGSYS"})
      out.stop.crashed = out.stop.crashed || name == fatal;
  }
  complaints_.clear();
  return out;
}

std::string DebugSession::source_name(const std::string& path) {
  if (path.empty()) return {};
  if (const auto known = names_.find(path); known != names_.end()) return known->second;
  std::error_code error;
  const fs::path found = fs::weakly_canonical(path, error);
  std::string& name = names_[path];
  for (const SourceFolder::File& file : sources_.files())
    if (fs::weakly_canonical(file.path, error) == found) name = file.name;
  return name;
}

/// Whether a frame is in what a macro of CogRSim has made (COGRSIM_CONTROLLER): no code of the user's.
bool DebugSession::is_declaration(const DebugFrame& frame) const {
  if (frame.file.empty()) return false;
  std::ifstream text(frame.path);
  std::string line;
  for (int n = 0; n < frame.line && std::getline(text, line); ++n) {
  }
  return line.rfind("COGRSIM_", 0) == 0;
}

std::vector<DebugFrame> DebugSession::stack() {
  std::vector<DebugFrame> out;
  const auto found =
      gdb_->command(fmt::format("-stack-list-frames --thread {} 0 {}", thread_, kMostFrames - 1));
  if (!found) return out;
  const auto list = found->find("stack");
  if (list == found->end() || !list->is_array()) return out;
  for (const Json& frame : *list) {
    DebugFrame one;
    one.function = mi_text(frame, "func");
    if (one.function.empty()) one.function = mi_text(frame, "addr");
    one.path = mi_text(frame, "fullname");
    one.file = source_name(one.path);
    one.line = mi_number(frame, "line").value_or(0);
    if (is_declaration(one)) one.file.clear();
    out.push_back(std::move(one));
  }
  return out;
}

// ---- what the user asks

void DebugSession::place(std::vector<DebugBreakpoint>& wanted) {
  for (auto old = placed_.begin(); old != placed_.end();) {
    const bool kept = std::any_of(wanted.begin(), wanted.end(), [&](const DebugBreakpoint& one) {
      return one.wants_same(old->second);
    });
    if (!kept) static_cast<void>(gdb_->command("-break-delete " + old->first));
    old = kept ? std::next(old) : placed_.erase(old);
  }
  for (DebugBreakpoint& one : wanted) {
    const auto there = std::find_if(placed_.begin(), placed_.end(), [&](const auto& placed) {
      return placed.second.wants_same(one);
    });
    if (there != placed_.end())
      one = there->second;
    else
      place_one(one);
  }
}

void DebugSession::place_one(DebugBreakpoint& wanted) {
  wanted.placed.reset();
  wanted.id.clear();
  std::string path;
  for (const SourceFolder::File& file : sources_.files())
    if (file.name == wanted.file) path = full_path(file.path);
  if (path.empty()) {
    wanted.note = "there is no such source beside the scene";
    return;
  }
  std::string command = "-break-insert ";
  const auto place = mi_quoted("\"" + path + "\":" + std::to_string(wanted.line));
  const auto condition = mi_quoted(wanted.condition);
  if (!place || !condition) {
    wanted.note = (place ? condition : place).error().message;
    return;
  }
  if (!wanted.condition.empty()) command += "-c " + *condition + " ";
  const auto made = gdb_->command(command + *place);
  if (!made) {
    wanted.note = made.error().message;
    if (wanted.note.rfind("No source file", 0) == 0)
      wanted.note = "the running controller has no debug information of " + wanted.file +
                    ": build it with Debug, which also loads it";
    if (wanted.note.rfind("No line", 0) == 0)
      wanted.note = "there is no code on this line or below it";
    return;
  }
  const Json& about = made->value("bkpt", Json::object());
  wanted.id = mi_text(about, "number");
  // Of several places in one line the first.
  const Json& places = about.value("locations", Json::array());
  wanted.placed = mi_number(places.empty() ? about : places.front(), "line");
  wanted.note =
      wanted.placed && *wanted.placed != wanted.line
          ? fmt::format("line {} has no code: it is at line {}", wanted.line, *wanted.placed)
          : "";
  placed_[wanted.id] = wanted;
}

Result<> DebugSession::need_stop() const {
  if (stands()) return {};
  return fail("the controller runs: its variables are there when it stands", "",
              "set a breakpoint, or pause it");
}

void DebugSession::forget_stop() {
  for (const std::string& name : shown_) static_cast<void>(gdb_->command("-var-delete " + name));
  shown_.clear();
  complaints_.clear();
  finishing_ = 0;
}

/// A breakpoint for one stop, where the controller's sources are entered.
Result<> DebugSession::stop_at_next_call() {
  std::vector<std::string> places;
  if (const auto entry = mi_quoted(entry_); !entry_.empty() && entry)
    places.push_back("--function " + *entry);
  const bool known = !places.empty();
  for (const SourceFolder::File& file : sources_.files()) {
    if (known || fs::path(file.name).extension() != ".cpp") continue;
    const auto place = mi_quoted("\"" + full_path(file.path) + "\":update");
    if (place) places.push_back(*place);
  }
  for (const std::string& place : places) {
    const auto made = gdb_->command("-break-insert -t " + place);
    if (made) passing_.push_back(mi_text(made->value("bkpt", Json::object()), "number"));
  }
  if (passing_.empty()) return fail("no function 'update' of the sources is known to gdb");
  if (auto going = gdb_->command("-exec-continue"); !going) return tl::unexpected(going.error());
  return {};
}

Result<> DebugSession::run(const std::string& how) {
  if (how == "pause") {
    if (stands()) return {};
    pausing_ = true;
    if (auto done = gdb_->command("-exec-interrupt"); !done) return tl::unexpected(done.error());
    return {};
  }
  if (!stands()) return fail("the controller runs already", "", "pause it, or set a breakpoint");
  forget_stop();
  const char* const command = how == "over"   ? "-exec-next"
                              : how == "into" ? "-exec-step"
                              : how == "out"  ? "-exec-finish"
                                              : "-exec-continue";
  auto done = gdb_->command(command);
  stepping_ = how == "over" || how == "into" ? command : "";
  // The outermost function of all has nothing that it returns to.
  if (!done && how == "out") done = gdb_->command("-exec-continue");
  if (!done) return tl::unexpected(done.error());
  return {};
}

Answer DebugSession::variable_of(const std::string& expression, int frame, bool argument) {
  const auto quoted = mi_quoted(expression);
  if (!quoted) return tl::unexpected(quoted.error());
  const auto made = gdb_->command(
      fmt::format("-var-create --thread {} --frame {} - * {}", thread_, frame, *quoted));
  if (!made) return tl::unexpected(made.error());
  shown_.push_back(mi_text(*made, "name"));
  const bool more =
      mi_number(*made, "numchild").value_or(0) > 0 || mi_text(*made, "has_more") == "1";
  return Json{{"name", expression},
              {"value", cut(mi_text(*made, "value"))},
              {"type", cut(mi_text(*made, "type"))},
              {"argument", argument},
              {"children", more ? shown_.back() : std::string()}};
}

Answer DebugSession::variables(int frame) {
  if (auto good = need_stop(); !good) return tl::unexpected(good.error());
  const auto found = gdb_->command(
      fmt::format("-stack-list-variables --thread {} --frame {} --no-values", thread_, frame));
  if (!found) return tl::unexpected(found.error());
  Json out = Json::array();
  std::vector<std::string> seen;
  bool more = false;
  for (const Json& one : found->value("variables", Json::array())) {
    const std::string name = mi_text(one, "name");
    // Of blocks in each other, the innermost comes first: the others are hidden in the code, too.
    if (std::find(seen.begin(), seen.end(), name) != seen.end()) continue;
    more = out.size() >= kMostVariables;
    if (more) break;
    seen.push_back(name);
    auto variable = variable_of(name, frame, mi_text(one, "arg") == "1");
    out.push_back(variable ? std::move(*variable)
                           : Json{{"name", name},
                                  {"value", first_line(variable.error().message)},
                                  {"type", ""},
                                  {"argument", false},
                                  {"children", ""}});
  }
  return Json{{"variables", std::move(out)}, {"more", more}};
}

Result<bool> DebugSession::list_children(const std::string& variable, Json& out, int depth) {
  const auto quoted = mi_quoted(variable);
  if (!quoted) return tl::unexpected(quoted.error());
  const auto found =
      gdb_->command(fmt::format("-var-list-children --all-values {} 0 {}", *quoted, kMostChildren));
  if (!found) return tl::unexpected(found.error());
  bool more = mi_text(*found, "has_more") == "1";
  for (const Json& child : found->value("children", Json::array())) {
    const std::string name = mi_text(child, "exp");
    const bool access = child.find("type") == child.end();  // "public", "private"
    if (access && depth < 2) {
      const auto inner = list_children(mi_text(child, "name"), out, depth + 1);
      if (!inner) return inner;
      more = more || *inner;
      continue;
    }
    const bool inside =
        mi_number(child, "numchild").value_or(0) > 0 || mi_text(child, "dynamic") == "1";
    // A text has no members to look at.
    const bool text = mi_text(child, "displayhint") == "string";
    out.push_back({{"name", name},
                   {"value", cut(mi_text(child, "value"))},
                   {"type", cut(mi_text(child, "type"))},
                   {"argument", false},
                   {"children", inside && !text ? mi_text(child, "name") : std::string()}});
  }
  return more;
}

Answer DebugSession::children(const std::string& variable) {
  if (auto good = need_stop(); !good) return tl::unexpected(good.error());
  Json out = Json::array();
  const auto more = list_children(variable, out, 0);
  if (!more) return tl::unexpected(more.error());
  return Json{{"variables", std::move(out)}, {"more", *more}};
}

Answer DebugSession::evaluate(const std::string& expression, int frame) {
  if (auto good = need_stop(); !good) return tl::unexpected(good.error());
  auto variable = variable_of(expression, frame, false);
  if (!variable) return tl::unexpected(variable.error());
  return Json{{"variable", std::move(*variable)}};
}

}  // namespace cogrsim::studio
