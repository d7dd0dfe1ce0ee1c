#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include "cogrsim/plugin/crash_report.h"
#include "command_line.h"
#include "interrupt.h"
#include "output_file.h"

namespace {

constexpr const char* kNoMemory =
    "error: the memory ran out\n"
    "help: a smaller scene or a larger limit (ulimit -v) is needed\n";
constexpr const char* kNoThread =
    "error: the system gives no more threads or memory\n"
    "help: see the limits of this shell: ulimit -u, ulimit -v\n";

int tell(const char* text) {
  std::fputs(text, stderr);
  return 1;
}

/// What the exception that is under way means to the user.
int tell_exception() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return tell(kNoMemory);
  } catch (const std::system_error& e) {
    if (e.code() == std::errc::resource_unavailable_try_again) return tell(kNoThread);
    std::fprintf(stderr, "error: %s\n", e.what());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
  } catch (...) {
    return tell("error: something was thrown that is not a std::exception\n");
  }
  return 1;
}

bool g_at_its_end = false;

/// A plugin or a library has called exit(): what was asked for has not been done.
void end_by_others() {
  if (g_at_its_end) return;
  const std::string call = cogrsim::PluginCall::described();
  tell(("error: " + (call.empty() ? "a plugin or a library" : call) +
        " called exit() before the work was done; a controller's own process keeps that to itself: "
        "isolation=\"process\"\n")
           .c_str());
  std::fflush(nullptr);
  _exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  // A file beyond `ulimit -f` is then an error of the write, told with its name, and no silent end.
  std::signal(SIGXFSZ, SIG_IGN);
  // Whoever started this may ignore it, and would be obeyed: runs in processes of their own would end
  // unheard, and be waited for without end.
  std::signal(SIGCHLD, SIG_DFL);
  cogrsim::report_crashes();
  // Nothing here throws on purpose; memory may still run out on a scene that is too large. When it
  // does in a thread of the program's own, or while something is being cleaned up, no catch hears
  // of it, and without words the process would be aborted.
  static const std::terminate_handler usual = std::get_terminate();
  std::set_terminate([] {
    const int status = std::current_exception() ? tell_exception() : 0;
    std::fflush(nullptr);
    // A plugin's end is a crash, which says whose.
    if (status == 0 || !cogrsim::PluginCall::described().empty()) usual();
    _exit(status);
  });
  try {
    cogrsim::cli::claim_standard_output();
    std::atexit(end_by_others);
    const int status = cogrsim::cli::run_command_line(argc, argv, cogrsim::cli::more_words());
    cogrsim::cli::end_as_interrupted();
    g_at_its_end = true;
    return status;
  } catch (...) {
    g_at_its_end = true;
    return tell_exception();
  }
}
