#include "live/live.h"

#include <sys/resource.h>

#include <thread>

#include "live/live_gate.h"
#include "live/live_session.h"
#include "run/run_log.h"

namespace cogrsim::cli {
namespace {

constexpr unsigned short kUsualPort = 8765;                  // what Foxglove offers to connect to
constexpr auto kPausedLook = std::chrono::milliseconds(50);  // between looks at a paused run
constexpr int kNetworkNice = 5;  // where there are too few processors, the run goes first

net::ServerOptions server_options(const LiveOptions& options) {
  net::ServerOptions out;
  out.host = options.host;
  out.port = options.port;
  out.preferred = {kUsualPort};
  out.ending = "the run has ended";
  out.limits.message_bytes = 1u << 20;
  out.limits.messages_per_second = 2000.0;  // joints may be commanded at a controller's rate
  return out;
}

}  // namespace

struct Live::Impl {
  Impl(std::unique_ptr<net::Server> listening, Simulation& run, const LiveOptions& options,
       double speed, const std::map<std::string, std::string>& set)
      : server(std::move(listening)),
        simulation(run),
        gate(server->port(), options.origins),
        session(*server, run, speed, set) {}

  std::unique_ptr<net::Server> server;
  Simulation& simulation;
  LiveGate gate;
  LiveSession session;
  std::unique_ptr<RunStream> stream;
  std::thread thread;
};

Result<std::unique_ptr<Live>> Live::start(Simulation& simulation, const LiveOptions& options,
                                          const StreamOptions& stream, double speed,
                                          const std::map<std::string, std::string>& set) {
  auto listening = net::Server::listen(server_options(options));
  if (!listening) return tl::unexpected(listening.error());
  auto impl = std::make_unique<Impl>(std::move(*listening), simulation, options, speed, set);
  impl->stream = RunStream::start(simulation, stream, impl->session);
  impl->thread = std::thread([raw = impl.get()] {
    static_cast<void>(
        setpriority(PRIO_PROCESS, 0, kNetworkNice));  // of this thread alone, on Linux
    raw->server->run(raw->session, raw->gate);
  });
  return std::unique_ptr<Live>(new Live(std::move(impl)));
}

Live::Live(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Live::~Live() {
  impl_->session.serve(0);
  impl_->stream.reset();
  impl_->server->stop();
  impl_->thread.join();
}

std::string Live::address() const { return impl_->server->address("", "ws"); }

RunStatus Live::serve(double end) {
  Simulation& simulation = impl_->simulation;
  LiveSession& session = impl_->session;
  session.serve(impl_->stream->left_out());
  RunStatus status = simulation.status();
  while (can_step(status) && simulation.paused() && simulation.time() < end) {
    session.wait(kPausedLook);
    status = simulation.step();
    session.serve(impl_->stream->left_out());
  }
  return status;
}

double Live::speed() const { return impl_->session.speed(); }

}  // namespace cogrsim::cli
