#include "process/child_process.h"

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>

#include "cogrsim/plugin/crash_report.h"

namespace cogrsim {

namespace {

/// The id of a process that the system names in its status, "PPid:"; nullopt: there is no process.
std::optional<std::int64_t> status_of(std::int64_t process, const std::string& entry) {
  if (process <= 0) return std::nullopt;
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(entry, 0) == 0) return std::atoll(line.c_str() + entry.size());
  }
  return std::nullopt;
}

/// Whether a process is `root`, or was started below it. Orphans below a watchdog become its children.
bool is_within(std::int64_t process, std::int64_t root) {
  for (std::optional<std::int64_t> at = process; at; at = status_of(*at, "PPid:")) {
    if (*at == root) return true;
  }
  return false;
}

/// Whether a debugger is attached to a process below a watchdog. A controller that lets its watchdog
/// or a process of its own trace it is in no debugger.
bool is_debugged(std::int64_t process, std::int64_t watchdog) {
  const auto tracer = status_of(process, "TracerPid:");
  return tracer && *tracer > 0 && !is_within(*tracer, watchdog);
}

}  // namespace

Result<std::unique_ptr<ChildProcess>> ChildProcess::start(std::vector<std::string> command) {
  std::unique_ptr<ChildProcess> child(new ChildProcess);
  WatchedProcess::Options options;
  options.command = std::move(command);
  if (auto made = child->channel_.create(); !made)
    return fail(made.error().message, "", remedy_of(errno, options.what));
  auto process = WatchedProcess::start(child->channel_.file(), std::move(options));
  if (!process) {
    Error error = process.error();
    if (error.hint.rfind("raise", 0) == 0) error.hint += ", with isolation=\"none\" none";
    return tl::unexpected(std::move(error));
  }
  child->process_ = std::move(*process);
  return child;
}

Result<CallChannel::Answer> ChildProcess::call(const std::vector<char>& request,
                                               std::vector<char>& reply,
                                               std::chrono::duration<double> patience,
                                               std::int64_t worker) {
  if (!alive()) return CallChannel::Answer::ended;
  if (auto asked = channel_.ask(request); !asked) return tl::unexpected(asked.error());
  std::optional<CallChannel::Clock::duration> limit;
  if (patience < std::chrono::hours(24 * 365))
    limit = std::chrono::duration_cast<CallChannel::Clock::duration>(patience);
  const auto answer = channel_.await(
      reply, limit, [this] { return process_->gone(); }, [] { return PluginCall::given_up(); },
      [this, worker] { return is_debugged(worker, process_->watchdog()); });
  if (answer != CallChannel::Answer::ended || process_->receive_end() || process_->gone())
    return answer;
  return CallChannel::Answer::broken;  // only the (damaged) shared memory reports the end
}

std::optional<bool> ChildProcess::has(std::int64_t process) const {
  if (!status_of(process, "PPid:")) return std::nullopt;
  return is_within(process, process_->watchdog());
}

}  // namespace cogrsim
