#include "studio_command.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include <unistd.h>

#include <fmt/format.h>

#include "browser.h"
#include "cogrsim/plugin/loader.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "debugger.h"
#include "document.h"
#include "kept_tokens.h"
#include "net/http.h"
#include "render/frames.h"
#include "run.h"
#include "server.h"
#include "start.h"
#include "studio.h"
#include "user_folders.h"

namespace cogrsim::studio {
namespace {

// Reached by the signal handler, which knows nothing but statics.
std::atomic<Server*> g_server{nullptr};

void on_signal(int) {
  if (Server* server = g_server.load()) server->stop();
}

// While it lives, SIGINT and SIGTERM stop the server; the second time they end the process.
class SignalsStop {
 public:
  explicit SignalsStop(Server& server) {
    g_server.store(&server);
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigaction(SIGINT, &action, &interrupt_);
    sigaction(SIGTERM, &action, &terminate_);
  }
  ~SignalsStop() {
    sigaction(SIGINT, &interrupt_, nullptr);
    sigaction(SIGTERM, &terminate_, nullptr);
    g_server.store(nullptr);
  }
  SignalsStop(const SignalsStop&) = delete;
  SignalsStop& operator=(const SignalsStop&) = delete;

 private:
  struct sigaction interrupt_ {
  }, terminate_{};
};

int failed(const Error& error) {
  cli::print_error(error.text());
  return cli::kFailed;
}

// The ports at which a page that is still open finds a studio after a restart.
constexpr unsigned short kFirstPort = 8642, kPreferredPorts = 10;

StudioInfo info_of(const StudioOptions& options, const char* kind) {
  StudioInfo info;
  info.version = COGRSIM_VERSION;
  info.kind = kind;
  info.file = std::filesystem::path(options.file).filename().string();
  info.allow_build = options.allow_build;
  if (info.kind != "scene") return info;
  info.backends = cli::installed_backends(std::make_shared<PluginLoader>(options.plugin_paths));
  return info;
}

ServerOptions network_of(const StudioOptions& options) {
  ServerOptions network;
  network.host = options.host;
  network.port = options.port;
  for (unsigned short i = 0; i < kPreferredPorts; ++i)
    network.preferred.push_back(static_cast<unsigned short>(kFirstPort + i));
  // A token that was seen once is valid after a restart too: where that could mean running
  // programs, or access from the network, only the user may decide to keep it.
  const bool by_itself = net::is_loopback(options.host) && !options.allow_build;
  if (options.keep_token.value_or(false) || by_itself) {
    network.tokens = kept_tokens_base();
    network.new_tokens = options.keep_token == false;
  }
  network.goodbye = R"({"topic":"goodbye","reason":"the studio was ended"})";
  return network;
}

/// A scene or recording that is served. Each part refers to those above it, and goes before them.
struct Session {
  // Of each thread its own: a loader is for one at a time.
  std::shared_ptr<PluginLoader> run_loader, document_loader;
  std::unique_ptr<Run> run;
  std::unique_ptr<Document> document;
  std::unique_ptr<Debugger> debugger;
  std::unique_ptr<Studio> studio;
};

Result<std::unique_ptr<Session>> open_session(const StudioOptions& options, Server& server) {
  auto session = std::make_unique<Session>();
  session->run_loader = std::make_shared<PluginLoader>(options.plugin_paths);
  session->document_loader = std::make_shared<PluginLoader>(options.plugin_paths);
  const bool recording = cli::is_recording(options.file);
  StudioInfo info = info_of(options, recording ? "recording" : "scene");
  if (recording) {
    auto opened = Run::of_recording(options.file, session->run_loader, server);
    if (!opened) return tl::unexpected(opened.error());
    session->run = std::move(*opened);
  } else {
    RunOptions about_run;
    about_run.backend = options.backend;
    about_run.step = options.step;
    about_run.seed = options.seed;
    about_run.isolation = options.isolation;
    about_run.without = options.without;
    about_run.parameters = options.parameters;
    const auto folder = std::filesystem::path(options.file).parent_path();
    about_run.folder = folder.empty() ? "." : folder.string();
    session->run = Run::of_scene(std::move(about_run), session->run_loader, server);
    DocumentOptions about_document;
    about_document.path = options.file;
    about_document.parameters = options.parameters;
    about_document.seed = options.seed;
    about_document.without = options.without;
    about_document.allow_build = options.allow_build;
    about_document.state_folder = user_state_folder();
    auto opened = Document::open(std::move(about_document), session->document_loader,
                                 *session->run, server);
    if (!opened) return tl::unexpected(opened.error());
    session->document = std::move(*opened);
    for (const std::string& note : session->document->notes()) cli::print_warning(note);
    DebuggerOptions about_debugger;
    about_debugger.folder = folder.empty() ? "." : folder.string();
    about_debugger.allowed = options.allow_build;
    session->debugger =
        std::make_unique<Debugger>(std::move(about_debugger), *session->run, server);
  }
  std::vector<Part*> parts = {session->run.get()};
  if (session->document) parts.push_back(session->document.get());
  if (session->debugger) parts.push_back(session->debugger.get());
  info.assets = server.assets();
  session->studio = std::make_unique<Studio>(
      std::move(info), std::move(parts),
      [run = session->run.get()](std::size_t number) { return run->asset(number); }, server);
  remember_file(user_state_folder(), options.file);
  return session;
}

/// Passes on what comes from the network: to the start page, later to what was opened there. Clients
/// of before are strangers to the new one, until they connect again.
class Desk final : public Inbox {
 public:
  void serve(Inbox& inbox) { now_.store(&inbox); }
  void joined(ClientId client, Role role) override { now_.load()->joined(client, role); }
  void left(ClientId client) override { now_.load()->left(client); }
  void received(ClientId client, std::string text) override {
    now_.load()->received(client, std::move(text));
  }
  std::string asset(std::size_t number) override { return now_.load()->asset(number); }

 private:
  std::atomic<Inbox*> now_{nullptr};
};

StartOptions start_options() {
  StartOptions options;
  std::error_code error;
  options.folder = std::filesystem::current_path(error);
  options.library = installed_folder("library");
  options.examples = installed_folder("examples");
  options.state_folder = user_state_folder();
  return options;
}

void finish(Session& session) {
  if (session.debugger) session.debugger->finish();  // the run may wait for it
  if (const std::string unsaved = session.document ? session.document->finish() : "";
      !unsaved.empty()) {
    cli::print_warning(unsaved);
  }
  if (const std::string stuck = session.run->finish(); !stuck.empty()) {
    cli::print_error("the studio was ended while something did not return: " + stuck);
    std::fflush(nullptr);
    ::_exit(cli::kFailed);  // its thread cannot be
  }
}

}  // namespace

int studio_command(const StudioOptions& options) {
  auto server = Server::listen(network_of(options));
  if (!server) return failed(server.error());
  const SignalsStop stopping(**server);

  Desk desk;
  std::unique_ptr<Session> session;  // made by the start page's thread, or here
  const auto open = [&](const std::string& file) -> Result<> {
    StudioOptions chosen = options;
    chosen.file = file;
    auto opened = open_session(chosen, **server);
    if (!opened) return tl::unexpected(opened.error());
    session = std::move(*opened);
    desk.serve(*session->studio);
    return {};
  };
  Start start(start_options(), open);
  std::unique_ptr<Studio> lobby;
  if (options.file.empty()) {
    lobby = std::make_unique<Studio>(
        info_of(options, "start"), std::vector<Part*>{&start},
        [](std::size_t) { return std::string(); }, **server);
    desk.serve(*lobby);
  } else if (const auto opened = open(options.file); !opened) {
    return failed(opened.error());
  }

  if (auto shown = cli::print_output((*server)->address(Role::operator_) + "\n"); !shown) {
    return failed(shown.error());
  }
  fmt::print(stderr, "for viewers, who can change nothing: {}\n", (*server)->address(Role::viewer));
  if (!net::is_loopback(options.host)) {
    cli::print_warning(
        "others in the network reach this studio; whoever has the address with its token may do "
        "all "
        "that you may, and nothing is encrypted\nhelp: leave --host out and come by `ssh -L`");
  }
  if (options.open) open_browser((*server)->launch_address());
  (*server)->run(desk);
  lobby.reset();  // waits for what it opens
  if (session) finish(*session);
  fmt::print(stderr, "the studio has ended\n");
  return cli::kGood;
}

}  // namespace cogrsim::studio
