// Thousands of misbehaving clients at one server: see studio.sh.
//
//     connect_storm PORT COUNT come-and-go   connects and closes at once, one after another
//     connect_storm PORT COUNT half          sends half a request on each and holds all for 3 s
//     connect_storm PORT COUNT deaf          asks for the page on each and reads nothing for 3 s
//     connect_storm PORT 1 ask               one proper request; prints the first line of the answer
//
// Prints how many connections it got. Exit status 1: the server could not be reached at all, or did
// not answer within 20 s.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace std::chrono_literals;

/// -1: refused, or no answer within 2 s.
int connect_to(int port) {
  const int s = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (s < 0) return -1;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<in_port_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(s, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return s;
  pollfd wait{s, POLLOUT, 0};
  int error = 1;
  socklen_t size = sizeof error;
  if (errno == EINPROGRESS && ::poll(&wait, 1, 2000) == 1 &&
      ::getsockopt(s, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0) {
    return s;
  }
  ::close(s);
  return -1;
}

void say(int s, const std::string& text) {
  // Errors after the server has closed do not matter.
  static_cast<void>(::send(s, text.data(), text.size(), MSG_NOSIGNAL));
}

std::string request(int port) {
  return "GET / HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n\r\n";
}

int ask(int port) {
  const auto end = std::chrono::steady_clock::now() + 20s;
  while (std::chrono::steady_clock::now() < end) {
    const int s = connect_to(port);
    if (s >= 0) {
      say(s, request(port));
      std::string answer;
      pollfd wait{s, POLLIN, 0};
      char part[4096];
      while (answer.find("\r\n") == std::string::npos && ::poll(&wait, 1, 2000) == 1) {
        const ssize_t count = ::recv(s, part, sizeof part, 0);
        if (count <= 0) break;
        answer.append(part, static_cast<std::size_t>(count));
      }
      ::close(s);
      if (const auto line = answer.find("\r\n"); line != std::string::npos) {
        std::printf("%s\n", answer.substr(0, line).c_str());
        return 0;
      }
    }
    std::this_thread::sleep_for(50ms);
  }
  std::fprintf(stderr, "no answer within 20 s\n");
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: connect_storm PORT COUNT come-and-go|half|deaf|ask\n");
    return 2;
  }
  const int port = std::atoi(argv[1]), count = std::atoi(argv[2]);
  const std::string how = argv[3];
  if (how == "ask") return ask(port);
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) == 0) {
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);
  }
  std::vector<int> held;
  int reached = 0, missed_in_a_row = 0;
  for (int i = 0; i < count && missed_in_a_row < 5; ++i) {
    const int s = connect_to(port);
    missed_in_a_row = s < 0 ? missed_in_a_row + 1 : 0;
    if (s < 0) continue;
    ++reached;
    if (how == "half") say(s, "GET / HT");
    if (how == "deaf") say(s, request(port));
    if (how == "come-and-go") {
      ::close(s);
    } else {
      held.push_back(s);
    }
  }
  if (!held.empty()) std::this_thread::sleep_for(3s);
  for (const int s : held) ::close(s);
  std::printf("%d\n", reached);
  return reached > 0 ? 0 : 1;
}
