#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>
#include <thread>

#include "server.h"
#include "targets.h"

namespace cogrsim::fuzz {
namespace {

using namespace studio;

// Answers every text, so that the output path is tested, too.
class Echo final : public Inbox {
 public:
  explicit Echo(Outbox& out) : out_(out) {}
  void joined(ClientId client, studio::Role) override { out_.send(client, "{}"); }
  void left(ClientId) override {}
  void received(ClientId client, std::string text) override {
    out_.send(client, text);
    out_.offer_frame(client, std::make_shared<const std::string>("frame"));
  }
  std::string asset(std::size_t) override { return {}; }

 private:
  Outbox& out_;
};

struct RunningServer {
  std::unique_ptr<Server> server;
  std::unique_ptr<Echo> echo;
  std::thread thread;
  std::string token, viewer;
  unsigned short port = 0;

  RunningServer() {
    ServerOptions options;
    options.limits.request_seconds = 5.0;
    auto listening = Server::listen(options);
    require(listening.has_value(), "the server listens");
    server = std::move(*listening);
    const std::string address = server->address(studio::Role::operator_);
    const auto colon = address.rfind(':'), equals = address.rfind('=');
    port = static_cast<unsigned short>(std::stoi(address.substr(colon + 1)));
    token = address.substr(equals + 1);
    const std::string other = server->address(studio::Role::viewer);
    viewer = other.substr(other.rfind('=') + 1);
    echo = std::make_unique<Echo>(*server);
    thread = std::thread([this] { server->run(*echo); });
  }
  ~RunningServer() {
    server->stop();
    thread.join();
  }
};

std::string with(std::string text, const std::string& name, const std::string& value) {
  for (auto at = text.find(name); at != std::string::npos; at = text.find(name, at)) {
    text.replace(at, name.size(), value);
    at += value.size();
  }
  return text;
}

int connect_to(unsigned short port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  require(socket >= 0, "there are sockets left");
  const int one = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  // From another address of this machine each time: a port that has just been used rests a minute.
  static std::uint32_t counter = 0;
  sockaddr_in from{}, to{};
  from.sin_family = to.sin_family = AF_INET;
  from.sin_addr.s_addr = htonl(0x7f010001u + (counter++ % 60000u));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(port);
  ::bind(socket, reinterpret_cast<const sockaddr*>(&from), sizeof from);
  require(::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0,
          "the server can be reached");
  return socket;
}

}  // namespace

void http(std::string_view input) {
  static RunningServer running;
  if (input.size() > (64u << 10)) return;
  std::string bytes = with(std::string(input), "$TOKEN", running.token);
  bytes = with(bytes, "$VIEWER", running.viewer);
  bytes = with(bytes, "$PORT", std::to_string(running.port));
  const int socket = connect_to(running.port);
  const timeval patience{20, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t more = ::send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (more <= 0) break;  // it was refused meanwhile
    sent += static_cast<std::size_t>(more);
  }
  ::shutdown(socket, SHUT_WR);
  std::string answer;
  char buffer[4096];
  ssize_t got = 0;
  while ((got = ::recv(socket, buffer, sizeof buffer, 0)) > 0) {
    if (answer.size() < 64) answer.append(buffer, static_cast<std::size_t>(got));
  }
  require(got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK),
          "whoever says no more is let go within 20 s");
  ::close(socket);
  require(answer.empty() || answer.rfind("HTTP/1.", 0) == 0, "an answer is HTTP");
  if (input.find("$TOKEN") == std::string_view::npos &&
      input.find("$VIEWER") == std::string_view::npos) {
    require(answer.rfind("HTTP/1.1 101", 0) != 0, "no connection without a token");
  }
}

}  // namespace cogrsim::fuzz
