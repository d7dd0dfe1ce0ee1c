// One controller's process under gdb: what is asked of gdb, and what its records mean.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gdb_client.h"
#include "sources.h"

namespace cogrsim::studio {

struct DebugFrame {
  std::string function;
  std::string file;  ///< as SourceFolder names it; "": not one of them
  std::string path;  ///< as the compiler was given it; "": no debug information
  int line = 0;      ///< 0: not known
};

/// A breakpoint as the user wants it, and what came of it.
struct DebugBreakpoint {
  std::string file;  ///< as SourceFolder names it
  int line = 0;
  std::string condition;      ///< an expression of C++; "": none
  std::optional<int> placed;  ///< the line where it is
  std::string note;           ///< why it is not there, or not where it was wanted
  std::string id;             ///< gdb's; "": not placed

  bool wants_same(const DebugBreakpoint& other) const {
    return file == other.file && line == other.line && condition == other.condition;
  }
};

/// Why the process stands.
struct DebugStop {
  std::string reason;    ///< "breakpoint", "step", "paused", "SIGSEGV: Segmentation fault"
  bool crashed = false;  ///< by a signal that ends the process when it goes on
  std::string note;      ///< what gdb complained of
  std::vector<DebugFrame> frames;
};

/// Not thread-safe: all on one thread, but for the client's listener.
class DebugSession {
 public:
  /// Attaches to a process, which stands then. Errors: gdb is missing, or the system does not let it;
  /// the hint is the cure.
  static Result<std::unique_ptr<DebugSession>> attach(int process, const SourceFolder& sources,
                                                      GdbClient::Listener listener);
  /// Detaches: the process goes on.
  ~DebugSession();

  /// What a record means for the user.
  struct Event {
    enum class Kind { none, running, stopped, ended } kind = Kind::none;
    DebugStop stop;
    std::string ending;  ///< how the process ended
  };
  Event take(const MiRecord& record);

  void place(std::vector<DebugBreakpoint>& wanted);
  /// "continue", "over", "into", "out", "pause".
  Result<> run(const std::string& how);
  /// Variables of a frame: arguments, then locals.
  Answer variables(int frame);
  Answer children(const std::string& variable);
  Answer evaluate(const std::string& expression, int frame);
  bool stands() const { return gdb_ && gdb_->stopped(); }

 private:
  explicit DebugSession(const SourceFolder& sources) : sources_(sources) {}
  Result<> prepare(int process);
  Event stopped(const Json& fields);
  std::vector<DebugFrame> stack();
  bool is_declaration(const DebugFrame& frame) const;
  std::string source_name(const std::string& path);
  void place_one(DebugBreakpoint& wanted);
  void forget_stop();
  Result<> stop_at_next_call();
  Result<> need_stop() const;
  Answer variable_of(const std::string& expression, int frame, bool argument);
  Result<bool> list_children(const std::string& variable, Json& out, int depth);

  const SourceFolder& sources_;
  std::unique_ptr<GdbClient> gdb_;
  bool attached_ = false;
  std::map<std::string, std::string> names_;       ///< paths of the compiler to names of sources
  std::map<std::string, DebugBreakpoint> placed_;  ///< by gdb's number
  std::vector<std::string> passing_;               ///< numbers of breakpoints for one stop
  std::vector<std::string> shown_;                 ///< gdb's objects of variables of this stop
  std::string complaints_;                         ///< what gdb has written since the last stop
  std::string entry_;         ///< function of the sources called last from outside
  std::string thread_ = "1";  ///< that stands
  bool pausing_ = false;
  std::string stepping_;  ///< command of the present step; "": it is none
  int finishing_ = 0;  ///< returns from functions that are not of the sources, one after the other
};

Json to_json(const DebugFrame& frame);
Json to_json(const DebugBreakpoint& breakpoint);

}  // namespace cogrsim::studio
