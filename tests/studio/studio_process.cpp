#include "studio_process.h"

#include <chrono>
#include <csignal>
#include <cstdlib>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

namespace cogrsim::studio::testing {

namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPatience = std::chrono::seconds(60);

/// Starts `cogrsim`, its standard output in a pipe.
pid_t start(const std::vector<std::string>& arguments,
            const std::map<std::string, std::string>& environment, int& output) {
  int ends[2];
  REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
  std::vector<std::string> all = {COGRSIM_PROGRAM};
  all.insert(all.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : all) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::dup2(ends[1], 1);
    for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  output = ends[0];
  return child;
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace

StudioProcess::StudioProcess(const std::vector<std::string>& arguments,
                             const std::map<std::string, std::string>& environment) {
  std::vector<std::string> all = {"studio", "--no-open"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  child_ = start(all, environment, output_);
  const auto end_of_patience = Clock::now() + kPatience;
  while (address_.find('\n') == std::string::npos && Clock::now() < end_of_patience) {
    pollfd waiting{output_, POLLIN, 0};
    if (::poll(&waiting, 1, 100) <= 0) continue;
    char buffer[512];
    const ssize_t got = ::read(output_, buffer, sizeof buffer);
    if (got <= 0) break;
    address_.append(buffer, static_cast<std::size_t>(got));
  }
  const auto line = address_.find('\n');
  INFO("the studio wrote: " << address_);
  if (line == std::string::npos) {
    end(true);
    FAIL("no address");
  }
  address_.resize(line);
  const auto colon = address_.rfind(':');
  port_ = static_cast<unsigned short>(std::stoi(address_.substr(colon + 1)));
}

StudioProcess::~StudioProcess() {
  end();
  if (output_ >= 0) ::close(output_);
}

std::string StudioProcess::token() const { return address_.substr(address_.find("token=") + 6); }

int StudioProcess::end(bool kill) {
  if (child_ < 0) return 0;
  ::kill(child_, kill ? SIGKILL : SIGTERM);
  return wait_for(std::exchange(child_, -1));
}

LivePage::LivePage(unsigned short port, const std::string& token) : socket_(port, token) {
  REQUIRE(socket_.status() == 101);
  hello = get("hello");
}

bool LivePage::take() {
  const auto message = socket_.receive();
  if (!message || message->opcode == 8) return false;
  if (message->opcode == 9) {
    socket_.send(message->payload, 10);
  } else if (message->opcode == 2) {
    const bool picture = message->payload.at(0) == 2;
    if (picture) pictures_.push_back(message->payload);
    socket_.send(picture ? "p" : "a");
  } else if (message->opcode == 1) {
    Json text = Json::parse(message->payload);
    if (text.contains("topic")) {
      const std::string name = text["topic"];
      topics_[name] = std::move(text);
    } else {
      const int id = text.at("id");
      answers_[id] = std::move(text);
    }
  }
  return true;
}

Json LivePage::ask(const std::string& what, Json fields) {
  const int id = ++last_id_;
  fields["id"] = id;
  fields["do"] = what;
  REQUIRE(socket_.send(fields.dump()));
  while (answers_.count(id) == 0) {
    if (!take()) FAIL("the studio went away instead of answering " << what);
  }
  return answers_[id];
}

Json LivePage::get(const std::string& what, Json fields) {
  Json answer = ask(what, std::move(fields));
  if (answer["ok"] != true) FAIL(what << ": " << answer);
  return answer;
}

Json LivePage::wait(const std::string& topic, const std::function<bool(const Json&)>& holds) {
  const auto end = Clock::now() + kPatience;
  for (;;) {
    const auto found = topics_.find(topic);
    if (found != topics_.end() && holds(found->second)) return found->second;
    const bool late = Clock::now() > end;
    if (late || !take()) {
      FAIL((late ? "waited in vain for '" : "the studio went away before '")
           << topic << "': " << (found == topics_.end() ? Json() : found->second));
    }
  }
}

std::string LivePage::picture() {
  while (pictures_.empty()) {
    if (!take()) FAIL("the studio went away before the picture");
  }
  std::string first = std::move(pictures_.front());
  pictures_.erase(pictures_.begin());
  return first;
}

std::string run_cogrsim(const std::vector<std::string>& arguments) {
  int output = -1;
  const pid_t child = start(arguments, {}, output);
  std::string text;
  char buffer[4096];
  for (ssize_t got = 0; (got = ::read(output, buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(got));
  }
  ::close(output);
  const int status = wait_for(child);
  INFO(text);
  REQUIRE(status == 0);
  return text;
}

}  // namespace cogrsim::studio::testing
