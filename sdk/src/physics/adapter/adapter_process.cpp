#include "physics/adapter/adapter_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cogrsim/core/shown_text.h"
#include "cogrsim/core/units.h"
#include "cogrsim/plugin/crash_report.h"

namespace cogrsim {

namespace {

static_assert(std::endian::native == std::endian::little);

struct FrameHead {
  std::uint32_t mark = 0x53524743, kind = 0;
  std::uint64_t size = 0;
};
static_assert(sizeof(FrameHead) == 16);

/// Of an answer: a state of a hundred thousand bodies, or its snapshot.
constexpr std::uint64_t kMostAnswer = std::uint64_t{256} << 20;
/// Of the output of an adapter that a fault shows.
constexpr std::size_t kShownOutput = 2000;
/// Time of busy waiting before sleeping: waking up takes as long as a step of a small scene.
constexpr auto kBusy = std::chrono::microseconds(50);

bool is_debugged() {
  const char* value = std::getenv("COGRSIM_DEBUG_BACKENDS");
  return value && *value != '\0' && std::strcmp(value, "0") != 0;
}

/// The folders of a system, from which every program reads; those of a program and of its language; and what
/// the manifest adds. Its own folder is the adapter's to write in.
Confinement confinement_of(const AdapterManifest& manifest) {
  namespace files = std::filesystem;
  Confinement out;
  out.reads = {"/usr",
               "/lib",
               "/lib64",
               "/lib32",
               "/bin",
               "/sbin",
               "/opt",
               "/etc",
               "/proc",
               "/sys",
               "/dev",
               "/nix",
               "/run/current-system"};
  out.writes = {manifest.folder, "/dev/null"};
  const char* const home_text = std::getenv("HOME");
  const files::path home = home_text ? home_text : "/";
  out.reads.push_back(home / ".local/lib");
  for (const char* const name :
       {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "NODE_PATH", "LD_LIBRARY_PATH"}) {
    const char* const list = std::getenv(name);
    std::istringstream paths(list ? list : "");
    for (std::string path; std::getline(paths, path, ':');)
      if (!path.empty()) out.reads.push_back(path);
  }
  // "PREFIX/bin/program", and where it is linked to, with PREFIX, but never the home folder as that.
  std::error_code error;
  const std::string& named = manifest.command.front();
  files::path program = named.find('/') == std::string::npos ? program_on_path(named) : named;
  if (program.is_relative()) program = files::path(manifest.folder) / program;
  for (const files::path& file : {program, files::canonical(program, error)}) {
    if (file.empty()) continue;
    out.reads.push_back(file.parent_path());
    const files::path prefix = file.parent_path().parent_path();
    const auto below = home.lexically_relative(prefix).string();
    if (below.empty() || below.rfind("..", 0) == 0) out.reads.push_back(prefix);
  }
  for (const auto& [from, to] :
       {std::pair{&manifest.reads, &out.reads}, {&manifest.writes, &out.writes}})
    for (const std::string& path : *from)
      to->push_back(path.rfind("~/", 0) == 0 ? home / path.substr(2) : files::path(path));
  return out;
}

}  // namespace

const char* during(AdapterCall call) {
  switch (call) {
    case AdapterCall::hello:
      return "while it was started";
    case AdapterCall::provenance:
      return "while it said what computes its results";
    case AdapterCall::scene:
    case AdapterCall::build:
      return "while a world was built";
    case AdapterCall::step:
      return "in a step";
    case AdapterCall::report:
      return "while its contacts and reactions were read";
    case AdapterCall::write:
      return "while its state was set";
    case AdapterCall::save:
      return "while its state was saved";
    case AdapterCall::restore:
      return "while its state was restored";
    case AdapterCall::free:
    case AdapterCall::error:
      break;
  }
  return "while a world ended";
}

AdapterProcess::AdapterProcess(std::shared_ptr<const AdapterManifest> manifest)
    : manifest_(std::move(manifest)), owner_(::getpid()), shows_output_(is_debugged()) {
  patience_ = shows_output_ ? std::numeric_limits<double>::infinity() : manifest_->patience;
}

Result<std::unique_ptr<AdapterProcess>> AdapterProcess::start(
    std::shared_ptr<const AdapterManifest> manifest) {
  std::unique_ptr<AdapterProcess> out(new AdapterProcess(manifest));
  const char* const what = "each world of a backend";
  const auto refuse = [&](int why) {
    return fail(
        fmt::format("backend '{}' cannot be started: {}", manifest->name, std::strerror(why)),
        manifest->path, remedy_of(why, what), "CG0910");
  };
  int ends[2], pipe_ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return refuse(errno);
  out->channel_ = ends[0];
  if (::pipe2(pipe_ends, O_CLOEXEC) != 0) {
    const int why = errno;
    ::close(ends[1]);
    return refuse(why);
  }
  out->output_ = pipe_ends[0];
  ::fcntl(out->channel_, F_SETFL, O_NONBLOCK);
  ::fcntl(out->output_, F_SETFL, O_NONBLOCK);
  WatchedProcess::Options options;
  options.command = manifest->command;
  if (options.command.front().find('/') != std::string::npos &&
      options.command.front().front() != '/')
    options.command.front() = manifest->folder + "/" + options.command.front();
  options.folder = manifest->folder;
  // Whoever looks into an adapter with a debugger needs more.
  if (!out->shows_output_) options.confined = confinement_of(*manifest);
  options.output = pipe_ends[1];
  options.what = what;
  auto process = WatchedProcess::start(ends[1], std::move(options));
  ::close(ends[1]);
  ::close(pipe_ends[1]);
  if (!process) {
    Error error = process.error();
    error.where = manifest->path;
    error.code = "CG0910";
    return tl::unexpected(std::move(error));
  }
  out->process_ = std::move(*process);
  out->request();
  return out;
}

AdapterProcess::~AdapterProcess() {
  // In a fork its descriptors are closed, and the process goes on for its owner.
  process_.reset();
  drain();
  if (channel_ >= 0) ::close(channel_);
  if (output_ >= 0) ::close(output_);
}

bool AdapterProcess::is_own() const { return owner_ == ::getpid(); }

std::vector<char>& AdapterProcess::request() {
  request_.resize(sizeof(FrameHead));
  return request_;
}

void AdapterProcess::put_text(const std::string& text) {
  request_.insert(request_.end(), text.begin(), text.end());
}

void AdapterProcess::put(const double* values, std::size_t count) {
  const auto* const bytes = reinterpret_cast<const char*>(values);
  request_.insert(request_.end(), bytes, bytes + count * sizeof(double));
}

/// Keeps the end of what the adapter has written to its standard output and error.
void AdapterProcess::drain() {
  char part[4096];
  for (ssize_t got = 0; output_ >= 0 && (got = ::read(output_, part, sizeof part)) > 0;) {
    const std::string text(part, static_cast<std::size_t>(got));
    if (shows_output_) std::fputs(printable(text).c_str(), stderr);
    last_output_ += text;
    if (last_output_.size() > 2 * kShownOutput)
      last_output_.erase(0, last_output_.size() - kShownOutput);
    if (got < static_cast<ssize_t>(sizeof part)) return;
  }
}

/// Waits until the channel is ready; meanwhile the adapter may write, so that a full pipe never
/// holds it up.
AdapterProcess::Wait AdapterProcess::await(short event, Clock::time_point until) {
  while (true) {
    const auto left =
        std::min<Clock::duration>(until - Clock::now(), std::chrono::milliseconds(100));
    const auto wait = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    pollfd watched[2] = {{channel_, event, 0}, {output_, POLLIN, 0}};
    if (::poll(watched, 2, static_cast<int>(std::max<std::int64_t>(wait, 0))) < 0 && errno != EINTR)
      return Wait::ended;
    if (watched[1].revents & POLLIN) drain();
    if (watched[0].revents != 0) return Wait::ready;
    if (process_->gone()) return Wait::ended;
    if (PluginCall::given_up() || Clock::now() >= until) return Wait::late;
  }
}

AdapterProcess::Wait AdapterProcess::send(Clock::time_point until) {
  for (std::size_t sent = 0; sent < request_.size();) {
    const ssize_t now =
        ::send(channel_, request_.data() + sent, request_.size() - sent, MSG_NOSIGNAL);
    if (now >= 0) {
      sent += static_cast<std::size_t>(now);
    } else if (errno == EAGAIN) {
      if (const Wait wait = await(POLLOUT, until); wait != Wait::ready) return wait;
    } else if (errno != EINTR) {
      return Wait::ended;
    }
  }
  return Wait::ready;
}

AdapterProcess::Wait AdapterProcess::receive(char* to, std::size_t count, Clock::time_point until) {
  const auto busy_until = Clock::now() + kBusy;
  for (std::size_t got = 0; got < count;) {
    const ssize_t now = ::recv(channel_, to + got, count - got, 0);
    if (now > 0) {
      got += static_cast<std::size_t>(now);
      continue;
    }
    if (now == 0 || (errno != EAGAIN && errno != EINTR)) return Wait::ended;
    if (errno == EINTR || Clock::now() < busy_until) continue;
    if (const Wait wait = await(POLLIN, until); wait != Wait::ready) return wait;
  }
  return Wait::ready;
}

AdapterResult<> AdapterProcess::exchange(AdapterCall call, double time) {
  if (!alive()) return tl::unexpected(broken(call, "has no process any more"));
  const PluginCall mark("backend", manifest_->name.c_str(), "", "", during(call), time, patience_);
  auto until = Clock::time_point::max();
  if (patience_ < 3e7)
    until = Clock::now() +
            std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(patience_));
  FrameHead head;
  head.kind = static_cast<std::uint32_t>(call);
  head.size = request_.size() - sizeof head;
  std::memcpy(request_.data(), &head, sizeof head);
  Wait wait = send(until);
  request();
  FrameHead got;
  if (wait == Wait::ready) wait = receive(reinterpret_cast<char*>(&got), sizeof got, until);
  if (wait != Wait::ready) return lost(call, wait);
  const bool refused = got.kind == static_cast<std::uint32_t>(AdapterCall::error);
  if (got.mark != head.mark || (got.kind != head.kind && !refused) || got.size > kMostAnswer)
    return tl::unexpected(nonsense(call, "an answer to another question"));
  answer_.resize(got.size);
  wait = receive(answer_.data(), answer_.size(), until);
  if (wait != Wait::ready) return lost(call, wait);
  if (refused) return tl::unexpected(refusal_in_answer(call));
  return {};
}

AdapterResult<> AdapterProcess::lost(AdapterCall call, Wait why) {
  if (why == Wait::late) {
    const std::string what =
        PluginCall::given_up()
            ? "was ended by the user"
            : "hung: it did not answer within " + units::number_text(patience_) +
                  " s (`patience` in its backend.json), and its process was killed";
    return tl::unexpected(broken(call, what));
  }
  // The watchdog reports after it has ended what the adapter has started.
  const auto last = Clock::now() + std::chrono::seconds(10);
  while (!process_->receive_end() && !process_->gone() && Clock::now() < last) ::usleep(200);
  process_->receive_end();
  return tl::unexpected(broken(call, process_->end().text()));
}

AdapterFault AdapterProcess::broken(AdapterCall call, const std::string& what) {
  if (process_) process_->kill();
  drain();
  AdapterFault fault;
  fault.message = fmt::format("backend '{}' {} {}", manifest_->name, what, during(call));
  std::string shown = last_output_;
  while (!shown.empty() && std::isspace(static_cast<unsigned char>(shown.back()))) shown.pop_back();
  if (shown.size() > kShownOutput) shown = "…" + shown.substr(shown.size() - kShownOutput);
  if (!shown.empty()) fault.message += "; it had written:\n" + printable(shown);
  return fault;
}

AdapterFault AdapterProcess::nonsense(AdapterCall call, const std::string& what) {
  return broken(call, "sent " + what);
}

AdapterFault AdapterProcess::refusal_in_answer(AdapterCall call) {
  const auto json = nlohmann::json::parse(answer_.begin(), answer_.end(), nullptr, false);
  if (!json.is_object() || !json.contains("kind") || !json.contains("message") ||
      !json["kind"].is_string() || !json["message"].is_string())
    return nonsense(call, "an error that cannot be read");
  const auto kind = json["kind"].get<std::string>();
  const auto message = printable(json["message"].get<std::string>());
  AdapterFault fault;
  fault.message = message;
  if (kind == "refused") {
    fault.kind = AdapterFault::Kind::refused;
    return fault;
  }
  if (kind == "diverged" && call == AdapterCall::step) {
    fault.kind = AdapterFault::Kind::diverged;
    if (json.contains("body") && json["body"].is_number_integer())
      fault.body = json["body"].get<int>();
    return fault;
  }
  // What threw may have left its engine in any state.
  return broken(call, "failed (" + message + ")");
}

}  // namespace cogrsim
