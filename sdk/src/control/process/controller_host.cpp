// The worker side of an isolated controller. It hosts the controller as a simulation does, on
// devices whose state comes from the simulation process.
#include "control/process/controller_host.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include "cogrsim/plugin/source.h"
#include "control/hosted_controller.h"
#include "control/process/proxy.h"
#include "process/child_process.h"
#include "process/watchdog.h"

namespace cogrsim {

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // the memory of the sanitizers alone exceeds every limit
#else
constexpr bool kSanitized = false;
#endif

/// Private writable memory, as counted by RLIMIT_DATA [byte].
double data_in_use() {
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key;) {
    double kilobytes = 0.0;
    if (key == "VmData:" && status >> kilobytes) return kilobytes * 1024.0;
  }
  return 0.0;
}

/// Limits the memory to `more` bytes above the current use, so that the scene does not count.
void limit_memory(double more) {
  if (kSanitized || !std::isfinite(more)) return;
  rlimit limit{};
  ::getrlimit(RLIMIT_DATA, &limit);
  const double sum = data_in_use() + more;
  if (sum >= 0x1p63) return;  // exceeds the range of rlim_t
  const auto wanted = static_cast<rlim_t>(sum);
  if (limit.rlim_max != RLIM_INFINITY && wanted > limit.rlim_max) return;
  limit.rlim_cur = limit.rlim_max = wanted;
  ::setrlimit(RLIMIT_DATA, &limit);
}

/// State of the worker process.
class Host {
 public:
  explicit Host(CallChannel& channel) : channel_(channel) {}

  /// Serves one request; false: the process is to end.
  bool serve() {
    if (!channel_.next_request(request_)) return false;
    WireReader in(request_);
    const auto call = static_cast<HostCall>(in.take<std::uint8_t>());
    if (call == HostCall::end) {
      controller_.reset();
      end_requested_ = true;
      return false;
    }
    const pid_t own = ::getpid();
    WireWriter out(reply_);
    if (call == HostCall::configure) {
      configure(in, out);
    } else {
      devices_->take_scene(in);
      devices_->take_state(in, *access_);
      dispatch(call, in, out);
    }
    std::fflush(nullptr);
    // The controller has called fork() and the child has returned from the call.
    if (::getpid() != own) ::_exit(0);
    return channel_.answer(reply_);
  }

  bool end_requested() const { return end_requested_; }

 private:
  void configure(WireReader& in, WireWriter& out) {
    std::vector<std::string> folders;
    std::string path, shape;
    in.get(folders);
    in.get(path);
    const auto index = static_cast<std::size_t>(in.take<std::uint64_t>());
    const auto memory = in.take<double>();
    in.get(shape);
    devices_ = std::make_unique<RemoteDevices>(folders);
    devices_->take_scene(in);
    limit_memory(memory);

    std::optional<std::string> refused, thrown;
    if (!in.good() || index >= devices_->model()->controllers.size()) {
      refused = "received a scene that cannot be read";
    } else {
      refused = load(path, shape, devices_->model()->controllers[index]);
    }
    out.put(static_cast<std::int64_t>(::getpid()));
    if (!refused) {
      devices_->take_state(in, *access_);
      controller_ = make_in_process_controller(plugin_, access_);
      if (auto failure = controller_->configure()) thrown = failure->what;
    }
    out.put(refused);
    out.put(thrown);
    if (!refused) devices_->put_effects(out, *access_);
  }

  /// Loads the plugin; returns the error, if any.
  std::optional<std::string> load(const std::string& path, const std::string& shape,
                                  const ControllerModel& description) {
    auto plugin = path.empty() ? devices_->loader().load(PluginKind::controller, description.plugin)
                               : devices_->loader().load_from(path);
    if (!plugin) return "cannot be loaded in its process: " + plugin.error().text();
    plugin_ = *plugin;
    const PluginDescriptor& descriptor = plugin_->descriptor();
    if (descriptor.kind != PluginKind::controller || shape_of(descriptor) != shape) {
      return "has another library ('" + path +
             "') now than when the run began: reload it, or restart the run";
    }
    auto parameters = complete_parameters(descriptor.parameters, description.parameters);
    if (!parameters) return "rejects its parameters: " + parameters.error().message;
    access_ = make_access(*devices_, description, plugin_, std::move(*parameters));
    return std::nullopt;
  }

  void dispatch(HostCall call, WireReader& in, WireWriter& out) {
    std::optional<HostFailure> failure;
    if (call == HostCall::update) {
      Tick tick;
      in.get(tick.time);
      in.get(tick.period);
      in.get(tick.count);
      failure = controller_->update(tick);
    } else if (call == HostCall::save) {
      std::optional<std::string> memory;
      failure = controller_->save(memory);
      out.put(memory);
    } else if (call == HostCall::restore) {
      std::string memory;
      in.get(memory);
      failure = controller_->restore(memory);
    }
    out.put(failure ? std::optional<std::string>(failure->what) : std::nullopt);
    devices_->put_effects(out, *access_);
  }

  CallChannel& channel_;
  bool end_requested_ = false;
  std::vector<char> request_, reply_;
  std::unique_ptr<RemoteDevices> devices_;
  PluginPtr plugin_;
  std::shared_ptr<AssemblyAccess> access_;
  std::unique_ptr<HostedController> controller_;
};

/// Serves requests until it is asked to end.
int serve_controller(CallChannel& channel) {
  Host host(channel);
  while (host.serve()) {
  }
  return host.end_requested() ? 0 : 1;
}

}  // namespace

int run_controller_host(char** command) { return watchdog::run(serve_controller, command); }

int serve_isolated_controller() { return watchdog::serve_as_worker(serve_controller); }

}  // namespace cogrsim
