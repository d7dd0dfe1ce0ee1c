#include "gdb_client.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstring>

extern char** environ;

namespace cogrsim::studio {

namespace {

constexpr auto kToEnd = std::chrono::seconds(3);

}  // namespace

Result<std::unique_ptr<GdbClient>> GdbClient::start(const std::string& program, Listener listener) {
  std::unique_ptr<GdbClient> client(new GdbClient(std::move(listener)));
  // A socket, for which a write to a gdb that has ended is an error and no signal.
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    return fail(std::string("gdb cannot be started: ") + std::strerror(errno));
  client->socket_ = ends[0];
  const timeval patience = {5, 0};  // a gdb that is busy reads nothing
  ::setsockopt(ends[0], SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);  // Ctrl-C in the terminal is for the studio
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string name = program, plain = "--nx", quiet = "--quiet", interface = "--interpreter=mi3";
  char* arguments[] = {name.data(), plain.data(), quiet.data(), interface.data(), nullptr};
  const int problem =
      ::posix_spawnp(&client->process_, name.c_str(), &actions, &attributes, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  ::close(ends[1]);
  if (problem != 0) {
    client->process_ = -1;
    return fail("'" + program + "' cannot be started: " + std::strerror(problem), "",
                "install gdb (Debian, Ubuntu: apt install gdb)");
  }
  client->reader_ = std::thread([raw = client.get()] { raw->read(); });
  return client;
}

GdbClient::~GdbClient() {
  if (process_ > 0) {
    write("-gdb-exit\n");
    std::unique_lock lock(mutex_);
    if (!news_.wait_for(lock, kToEnd, [this] { return ended_; })) ::kill(process_, SIGKILL);
  }
  if (reader_.joinable()) reader_.join();
  if (socket_ >= 0) ::close(socket_);
}

bool GdbClient::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t sent = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

Result<Json> GdbClient::command(const std::string& text, std::chrono::milliseconds patience) {
  const std::string verb = text.substr(0, text.find(' '));
  std::unique_lock lock(mutex_);
  if (ended_) return fail("the debugger has ended", "", "press Debug again");
  const std::uint64_t token = ++last_token_;
  results_[token] = std::nullopt;
  lock.unlock();
  const bool sent = write(std::to_string(token) + text + "\n");
  lock.lock();
  if (sent) news_.wait_for(lock, patience, [&] { return ended_ || results_[token].has_value(); });
  const std::optional<MiRecord> result = std::move(results_[token]);
  results_.erase(token);
  if (!result) {
    if (ended_) return fail("the debugger has ended", "", "press Debug again");
    // It waits for a call that does not return, and would at every command to come.
    ::kill(process_, SIGINT);
    ::shutdown(socket_, SHUT_RDWR);
    ended_ = true;
    return fail("gdb did not answer '" + verb + "' in time and was ended", "",
                "press Debug again; do not watch calls that do not return");
  }
  if (result->what == "error") {
    std::string said = mi_text(result->fields, "msg");
    return fail(said.empty() ? "gdb refused '" + verb + "'" : said.substr(0, 2000));
  }
  return result->fields;
}

bool GdbClient::stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_ && !ended_;
}

bool GdbClient::wait_until_stopped(std::chrono::milliseconds patience) const {
  std::unique_lock lock(mutex_);
  news_.wait_for(lock, patience, [this] { return stopped_ || ended_; });
  return stopped_ && !ended_;
}

bool GdbClient::alive() const {
  const std::lock_guard lock(mutex_);
  return !ended_;
}

void GdbClient::read() {
  std::string text;
  bool skipping = false;  // the rest of a line that is too long
  char part[16384];
  while (true) {
    const ssize_t got = ::recv(socket_, part, sizeof part, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    text.append(part, static_cast<std::size_t>(got));
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos;
         begin = end + 1) {
      std::string_view line(text.data() + begin, end - begin);
      if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
      if (!skipping) take(line);
      skipping = false;
    }
    text.erase(0, begin);
    if (text.size() > kMostMiLine) {
      skipping = true;
      text.clear();
    }
  }
  const std::string how = reap();
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  news_.notify_all();
  listener_.ended(how);
}

/// gdb has closed its output: it is ending.
std::string GdbClient::reap() {
  int status = 0;
  for (int tries = 0; ::waitpid(process_, &status, WNOHANG) == 0; ++tries) {
    if (tries == 300) ::kill(process_, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (!WIFSIGNALED(status)) return "exit code " + std::to_string(WEXITSTATUS(status));
  const char* const signal = ::sigabbrev_np(WTERMSIG(status));
  return signal ? std::string("SIG") + signal : "signal " + std::to_string(WTERMSIG(status));
}

void GdbClient::take(std::string_view line) {
  // What is no record was written by the debugged program, or is of a gdb that we do not know.
  auto record = read_mi_record(line);
  if (!record || record->kind == MiRecord::Kind::prompt) return;
  {
    const std::lock_guard lock(mutex_);
    if (record->kind == MiRecord::Kind::exec) stopped_ = record->what == "stopped";
    if (record->kind == MiRecord::Kind::result) {
      if (record->what == "running") stopped_ = false;  // `*running` comes later
      const auto waited = record->token ? results_.find(*record->token) : results_.end();
      if (waited != results_.end()) waited->second = std::move(*record);
    }
  }
  news_.notify_all();
  if (record->kind != MiRecord::Kind::result) listener_.record(std::move(*record));
}

}  // namespace cogrsim::studio
