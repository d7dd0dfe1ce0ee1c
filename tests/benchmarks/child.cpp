#include "child.h"

#include <fcntl.h>
#include <poll.h>
#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>

namespace cogrsim::bench {

Child::Child(const std::vector<std::string>& command) {
  signal(SIGPIPE, SIG_IGN);  // a child that ended early is detected by its missing answer
  int in[2], out[2];
  if (pipe2(in, O_CLOEXEC) != 0 || pipe2(out, O_CLOEXEC) != 0) {
    throw std::runtime_error(std::string("cannot make a pipe: ") + std::strerror(errno));
  }
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error(std::string("cannot fork: ") + std::strerror(errno));
  if (pid_ == 0) {
    dup2(in[0], 0);
    dup2(out[1], 1);
    const int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) dup2(nowhere, 2);
    execv(words[0], words.data());
    _exit(127);
  }
  close(in[0]);
  close(out[1]);
  to_ = in[1];
  from_ = out[0];
}

Child::~Child() {
  close(to_);
  close(from_);
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

void Child::say(const std::string& line) {
  const std::string text = line + "\n";
  // A child that ended is found out when it is listened to.
  if (write(to_, text.data(), text.size()) < 0) ended_ = true;
}

std::optional<nlohmann::json> Child::hear(double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    const std::size_t newline = heard_.find('\n');
    if (newline != std::string::npos) {
      const nlohmann::json line = nlohmann::json::parse(heard_.substr(0, newline), nullptr, false);
      heard_.erase(0, newline + 1);
      if (!line.is_discarded()) return line;
      ended_ = true;
      return std::nullopt;
    }
    if (ended_) return std::nullopt;
    const double left = std::chrono::duration<double>(end - Clock::now()).count();
    if (left <= 0) return std::nullopt;
    pollfd wait{from_, POLLIN, 0};
    if (poll(&wait, 1, static_cast<int>(left * 1000) + 1) <= 0) continue;
    char buffer[65536];
    const ssize_t got = read(from_, buffer, sizeof buffer);
    if (got <= 0) {
      ended_ = true;
    } else {
      heard_.append(buffer, static_cast<std::size_t>(got));
    }
  }
}

}  // namespace cogrsim::bench
