// A controller in a process of its own, as that process sees it: it makes the controller as a
// simulation would, on a Simulation::Impl that is filled in from outside.
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include "control/child_process.h"
#include "control/hosted_controller.h"
#include "control/mirror.h"
#include "control/shape_of_plugin.h"

namespace cogrsim {

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // their bookkeeping alone exceeds any bound
#else
constexpr bool kSanitized = false;
#endif

/// Private memory that can be written: what RLIMIT_DATA counts [byte].
double data_in_use() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0.0;
    if (word == "VmData:" && status >> kilobytes) return kilobytes * 1024.0;
  }
  return 0.0;
}

/// `more` bytes beside what is in use: what the scene takes is not the controller's.
void limit_memory(double more) {
  if (kSanitized || !std::isfinite(more)) return;
  rlimit limit{};
  ::getrlimit(RLIMIT_DATA, &limit);
  const double sum = data_in_use() + more;
  if (sum >= 0x1p63) return;  // more than there is in any machine, and than an rlim_t holds
  const auto wanted = static_cast<rlim_t>(sum);
  if (limit.rlim_max != RLIM_INFINITY && wanted > limit.rlim_max) return;
  limit.rlim_cur = limit.rlim_max = wanted;
  ::setrlimit(RLIMIT_DATA, &limit);
}

/// What the process holds.
class Host {
 public:
  explicit Host(CallChannel& channel) : channel_(channel) {}

  /// False: the end.
  bool serve() {
    if (!channel_.next_request(request_)) return false;
    WireReader in(request_);
    const auto call = static_cast<HostCall>(in.take<std::uint8_t>());
    if (call == HostCall::end) {
      controller_.reset();
      told_to_end_ = true;
      return false;
    }
    const pid_t own = ::getpid();
    WireWriter out(reply_);
    if (call == HostCall::configure) {
      configure(in, out);
    } else {
      mirror_->take_scene(in);
      mirror_->take_state(in, *access_);
      dispatch(call, in, out);
    }
    std::fflush(nullptr);
    // A controller that calls fork() and lets the copy return.
    if (::getpid() != own) ::_exit(0);
    return channel_.answer(reply_);
  }

  bool told_to_end() const { return told_to_end_; }

 private:
  void configure(WireReader& in, WireWriter& out) {
    std::vector<std::string> folders;
    std::string path, shape;
    in.get(folders);
    in.get(path);
    const auto index = static_cast<std::size_t>(in.take<std::uint64_t>());
    const auto memory = in.take<double>();
    in.get(shape);
    simulation_ = std::make_unique<Simulation::Impl>(std::make_shared<PluginLoader>(folders));
    mirror_ = std::make_unique<MirrorReader>(*simulation_);
    mirror_->take_scene(in);
    limit_memory(memory);

    std::optional<std::string> refused, thrown;
    if (!in.good() || index >= simulation_->model->controllers.size()) {
      refused = "was told of a scene that cannot be read";
    } else {
      refused = load(path, shape, simulation_->model->controllers[index]);
    }
    out.put(static_cast<std::int64_t>(::getpid()));
    if (!refused) {
      mirror_->take_state(in, *access_);
      controller_ = host_here(plugin_, access_);
      if (auto failure = controller_->configure()) thrown = failure->what;
    }
    out.put(refused);
    out.put(thrown);
    if (!refused) mirror_->put_deeds(out, *access_);
  }

  /// What is in the way.
  std::optional<std::string> load(const std::string& path, const std::string& shape,
                                  const ControllerModel& description) {
    auto plugin = simulation_->loader->load_from(path);
    if (!plugin) return "cannot be loaded in its process: " + plugin.error().text();
    plugin_ = *plugin;
    const PluginDescriptor& descriptor = plugin_->descriptor();
    if (descriptor.kind != PluginKind::controller || shape_of(descriptor) != shape) {
      return "has another library ('" + path +
             "') now than when the run began: reload it, or begin the run anew";
    }
    auto parameters = complete_parameters(descriptor.parameters, description.parameters);
    if (!parameters) return "does not take its parameters: " + parameters.error().message;
    access_ = make_access(*simulation_, description, plugin_, std::move(*parameters));
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
    mirror_->put_deeds(out, *access_);
  }

  CallChannel& channel_;
  bool told_to_end_ = false;
  std::vector<char> request_, reply_;
  std::unique_ptr<Simulation::Impl> simulation_;
  std::unique_ptr<MirrorReader> mirror_;
  PluginPtr plugin_;
  std::shared_ptr<AssemblyAccess> access_;
  std::unique_ptr<HostedController> controller_;
};

}  // namespace

int serve_controller(CallChannel& channel) {
  Host host(channel);
  while (host.serve()) {
  }
  return host.told_to_end() ? 0 : 1;
}

}  // namespace cogrsim
