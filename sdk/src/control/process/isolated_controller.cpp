// The simulation side of a controller in a process of its own.
#include <sys/wait.h>
#include <csignal>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>

#include "cogrsim/core/shown_text.h"
#include "cogrsim/core/units.h"
#include "cogrsim/plugin/crash_report.h"
#include "control/hosted_controller.h"
#include "control/process/proxy.h"
#include "plugin/host_command.h"
#include "process/child_process.h"

namespace cogrsim {

namespace {

using Seconds = std::chrono::duration<double>;

/// Time limit for all calls except updates: starting, configuring, saving, ending [s].
constexpr double kPatience = 10.0;

/// Fraction of the allowed memory above which messages mention the memory use.
constexpr double kNearlyAll = 0.5;

std::string megabytes(double bytes) { return fmt::format("{:.4g} MB", bytes * 1e-6); }

/// The call during which a process ended, for messages.
const char* during(HostCall call) {
  switch (call) {
    case HostCall::configure:
      return "while being configured";
    case HostCall::update:
      return "in update";
    case HostCall::save:
      return "while its state was saved";
    case HostCall::restore:
      return "while its state was restored";
    case HostCall::end:
      break;
  }
  return "while it was destroyed";
}

/// Whether the user debugs controllers; there is no deadline then.
bool debugging() {
  const char* value = std::getenv("COGRSIM_DEBUG_CONTROLLERS");
  return value && *value != '\0' && std::strcmp(value, "0") != 0;
}

class IsolatedController final : public HostedController {
 public:
  IsolatedController(PluginPtr plugin, std::shared_ptr<AssemblyAccess> access,
                     std::size_t controller, SceneForControllers& scene,
                     std::unique_ptr<ChildProcess> process)
      : plugin_(std::move(plugin)),
        access_(std::move(access)),
        proxy_(*access_, scene),
        controller_(controller),
        who_("controller '" + access_->plugin + "' of '" + access_->name + "'"),
        process_(std::move(process)) {
    const ControllerModel& model = access_->port->model()->controllers[controller];
    deadline_ = debugging() ? std::numeric_limits<double>::infinity() : model.deadline;
    memory_ = model.memory;
  }

  ~IsolatedController() override {
    if (!process_->alive()) return;
    WireWriter out(request_);
    out.put(HostCall::end);
    // The simulation can no longer report messages, so the error goes to the terminal.
    if (auto failure = exchange(patience())) {
      std::fprintf(stderr, "%s %s while it was destroyed\n", one_line(who_).c_str(),
                   paragraph(failure->what).c_str());
    }
  }

  std::optional<HostFailure> configure() override {
    WireWriter out(request_);
    out.put(HostCall::configure);
    out.put(access_->port->loader().folders());
    out.put(plugin_->path());
    out.put(static_cast<std::uint64_t>(controller_));
    out.put(memory_);
    out.put(shape_of(plugin_->descriptor()));
    proxy_.put_scene(out);
    proxy_.put_state(out);
    if (auto failure = exchange(patience())) return failure;
    WireReader in(reply_);
    // While this process is debugged there is no deadline, so it must be the controller's own.
    const auto reported = in.take<std::int64_t>();
    const std::optional<bool> own = process_->has(reported);
    if (own && !*own) return damaged();
    worker_ = own ? reported : 0;
    std::optional<std::string> refused, thrown;
    in.get(refused);
    in.get(thrown);
    if (refused) return HostFailure{HostFailure::Kind::refused, *refused};
    if (!proxy_.take_effects(in)) return damaged();
    access_->configured = true;
    if (debugging()) {
      std::fprintf(stderr, "%s runs in process %lld\n", one_line(who_).c_str(),
                   static_cast<long long>(worker_));
    }
    return failure_of(std::move(thrown));
  }

  std::int64_t process() const override { return process_->alive() ? worker_ : 0; }

  std::optional<HostFailure> update(const Tick& tick) override {
    WireWriter out(request_);
    begin(out, HostCall::update);
    out.put(tick.time);
    out.put(tick.period);
    out.put(tick.count);
    if (auto failure = exchange(deadline_)) return failure;
    WireReader in(reply_);
    return finish(in);
  }

  std::optional<HostFailure> save(std::optional<std::string>& memory) override {
    if (!process_->alive()) return std::nullopt;  // its state is lost
    WireWriter out(request_);
    begin(out, HostCall::save);
    if (auto failure = exchange(patience())) return failure;
    WireReader in(reply_);
    in.get(memory);
    return finish(in);
  }

  std::optional<HostFailure> restore(const std::string& memory) override {
    if (!process_->alive()) return std::nullopt;
    WireWriter out(request_);
    begin(out, HostCall::restore);
    out.put(memory);
    if (auto failure = exchange(patience())) return failure;
    WireReader in(reply_);
    return finish(in);
  }

 private:
  double patience() const { return std::max(deadline_, kPatience); }

  void begin(WireWriter& out, HostCall call) {
    out.put(call);
    proxy_.put_scene(out);
    proxy_.put_state(out);
  }

  std::optional<HostFailure> finish(WireReader& in) {
    std::optional<std::string> thrown;
    in.get(thrown);
    if (!proxy_.take_effects(in)) return damaged();
    return failure_of(std::move(thrown));
  }

  std::optional<HostFailure> failure_of(std::optional<std::string> thrown) const {
    if (!thrown) return std::nullopt;
    HostFailure failure{HostFailure::Kind::thrown, std::move(*thrown)};
    if (!std::isfinite(memory_)) return failure;
    if (failure.what == "std::bad_alloc") failure.more = allowed();
    // std::thread throws this if the memory for a stack is not available.
    if (failure.what == std::strerror(EAGAIN)) {
      failure.more = allowed() + ", stacks of threads included";
    }
    return failure;
  }

  std::string allowed() const { return "it may take " + megabytes(memory_) + " of memory"; }

  std::optional<HostFailure> damaged() {
    process_->kill();
    lost_ = "it sent inconsistent data";
    return HostFailure{HostFailure::Kind::process, "sent inconsistent data",
                       "it may have written to memory that is not its own; its process was killed"};
  }

  /// Sends request_ and waits for reply_; returns the failure of the process, if any.
  std::optional<HostFailure> exchange(double patience) {
    if (!process_->alive()) {
      return HostFailure{HostFailure::Kind::process, "has no process any more", lost_};
    }
    const char* const doing = during(static_cast<HostCall>(request_.front()));
    const PluginCall call("controller", access_->controller.c_str(), access_->name.c_str(),
                          access_->plugin.c_str(), doing, access_->port->time(), patience);
    auto failure = attempt(patience);
    if (failure) lost_ = "it " + failure->what + " " + doing;
    return failure;
  }

  std::optional<HostFailure> attempt(double patience) {
    const auto answer = process_->call(request_, reply_, Seconds(patience), worker_);
    if (!answer) {
      process_->kill();
      return HostFailure{HostFailure::Kind::process, "could not be reached",
                         answer.error().message};
    }
    switch (*answer) {
      case CallChannel::Answer::reply:
        return std::nullopt;
      case CallChannel::Answer::late:
        process_->kill();
        if (PluginCall::given_up()) {
          return HostFailure{HostFailure::Kind::process, "was ended by the user",
                             "it had not returned, and its process was killed"};
        }
        return HostFailure{HostFailure::Kind::process, "hung",
                           "it did not return within " + units::number_text(patience) +
                               " s, and its process was killed"};
      case CallChannel::Answer::broken:
        return damaged();
      case CallChannel::Answer::ended:
        break;
    }
    const ProcessEnd end = process_->end();
    process_->kill();
    HostFailure failure{HostFailure::Kind::process, ""};
    if (request_.front() == static_cast<char>(HostCall::end) && WIFEXITED(end.status) &&
        WEXITSTATUS(end.status) == 0) {
      return std::nullopt;
    }
    failure.what = end.text();
    const auto most = static_cast<double>(end.most_bytes);
    if (std::isfinite(memory_) && most > kNearlyAll * memory_) {
      failure.more = "it had taken up to " + megabytes(most) + ", and " + allowed();
    }
    return failure;
  }

  PluginPtr plugin_;
  std::shared_ptr<AssemblyAccess> access_;
  ProxyWriter proxy_;
  std::size_t controller_;
  std::string who_;
  double deadline_ = 0.0, memory_ = 0.0;  // [s], [byte]
  std::string lost_;                      // how its process ended
  std::unique_ptr<ChildProcess> process_;
  std::int64_t worker_ = 0;  // id of the process that runs it, once it is configured
  std::vector<char> request_, reply_;
};

}  // namespace

Result<std::unique_ptr<HostedController>> make_isolated_controller(
    PluginPtr plugin, std::shared_ptr<AssemblyAccess> access, std::size_t controller,
    SceneForControllers& scene) {
  std::vector<std::string> command;
  if (plugin->path().empty()) {
    auto host = host_command(plugin->descriptor().name);
    if (!host) return tl::unexpected(host.error());
    command = std::move(*host);
  }
  auto process = ChildProcess::start(std::move(command));
  if (!process) return tl::unexpected(process.error());
  return std::make_unique<IsolatedController>(std::move(plugin), std::move(access), controller,
                                              scene, std::move(*process));
}

}  // namespace cogrsim
