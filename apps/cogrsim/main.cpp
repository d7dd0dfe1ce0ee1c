#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include "cogrsim/core/shown_text.h"
#include "cogrsim/plugin/crash_report.h"
#include "common/command_line.h"
#include "common/interrupt.h"
#include "common/output_file.h"

namespace {

constexpr const char* kNoMemory =
    "error: the memory ran out\n"
    "help: a smaller scene or a larger limit (ulimit -v) is needed\n";
constexpr const char* kNoThread =
    "error: the system gives no more threads or memory\n"
    "help: see the limits of this shell: ulimit -u, ulimit -v\n";

int print_failure(const char* text) {
  std::fputs(text, stderr);
  return 1;
}

void print_error_of(const std::exception& e) {
  try {
    std::fprintf(stderr, "error: %s\n", cogrsim::paragraph(e.what()).c_str());
  } catch (const std::bad_alloc&) {
    print_failure(kNoMemory);
  }
}

/// Prints the exception that is being handled.
int report_exception() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return print_failure(kNoMemory);
  } catch (const std::system_error& e) {
    if (e.code() == std::errc::resource_unavailable_try_again) return print_failure(kNoThread);
    print_error_of(e);
  } catch (const std::exception& e) {
    print_error_of(e);
  } catch (...) {
    return print_failure("error: an exception was thrown that is not a std::exception\n");
  }
  return 1;
}

bool g_at_its_end = false;

/// A plugin or a library has called exit(): the command has not finished.
void end_by_others() {
  if (g_at_its_end) return;
  const std::string call = cogrsim::PluginCall::described();
  print_failure(("error: " + (call.empty() ? "a plugin or a library" : call) +
        " called exit() before the work was done; a controller's own process keeps that to itself: "
        "isolation=\"process\"\n")
           .c_str());
  std::fflush(nullptr);
  _exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  // A file beyond `ulimit -f` is then an error of the write, printed with its name, and no silent
  // end.
  std::signal(SIGXFSZ, SIG_IGN);
  // The parent process may ignore SIGCHLD, which children inherit: the end of runs in processes of
  // their own would go unnoticed, and the program would wait for ever.
  std::signal(SIGCHLD, SIG_DFL);
  cogrsim::report_crashes();
  // Nothing here throws on purpose; memory may still run out on a scene that is too large. When it
  // does in a thread of the program's own, or in a destructor, no catch clause sees it, and the
  // process would be aborted without a message.
  static const std::terminate_handler usual = std::get_terminate();
  std::set_terminate([] {
    const int status = std::current_exception() ? report_exception() : 0;
    std::fflush(nullptr);
    // A plugin that ends the process is a crash, whose report names the plugin.
    if (status == 0 || !cogrsim::PluginCall::described().empty()) usual();
    _exit(status);
  });
  try {
    cogrsim::cli::claim_standard_output();
    std::atexit(end_by_others);
    const int status = cogrsim::cli::run_command_line(argc, argv, cogrsim::cli::extra_commands());
    cogrsim::cli::end_as_interrupted();
    g_at_its_end = true;
    return status;
  } catch (...) {
    g_at_its_end = true;
    return report_exception();
  }
}
