#include "server_client.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace cogrsim::studio {
namespace {

constexpr std::chrono::seconds kLongest{60};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

unsigned short own_port() {
  // Below those that Linux gives away of itself (32768 and above), above those that services like.
  constexpr int kFirst = 12000, kCount = 20000;
  for (int tried = 0; tried < kCount; ++tried) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    const auto port = static_cast<unsigned short>(kFirst + (::getpid() + tried) % kCount);
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int probe = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool free = ::bind(probe, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
    ::close(probe);
    if (free) return port;
  }
  throw std::runtime_error("no port is free");
}

RawClient::RawClient(unsigned short port, const std::string& from)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (!from.empty()) {
    sockaddr_in own{};
    own.sin_family = AF_INET;
    inet_pton(AF_INET, from.c_str(), &own.sin_addr);
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) {
      throw std::runtime_error("cannot come from " + from);
    }
  }
  const timeval limit{kLongest.count(), 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("cannot connect");
  }
}

RawClient::RawClient(RawClient&& other) noexcept
    : taken(std::move(other.taken)), socket_(other.socket_) {
  other.socket_ = -1;
}

RawClient::~RawClient() { close(); }

void RawClient::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

bool RawClient::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool RawClient::receive() {
  char block[65536];
  const ssize_t got = recv(socket_, block, sizeof block, 0);
  if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
    throw std::runtime_error("the server says nothing");
  }
  if (got <= 0) return false;
  taken.append(block, static_cast<std::size_t>(got));
  return true;
}

std::string RawClient::rest() {
  while (receive()) {
  }
  return std::move(taken);
}

const std::string& HttpReply::header(const std::string& name) const {
  static const std::string none;
  const auto found = headers.find(name);
  return found == headers.end() ? none : found->second;
}

HttpReply read_reply(RawClient& client, bool with_body) {
  HttpReply reply;
  std::size_t end = 0;
  while ((end = client.taken.find("\r\n\r\n")) == std::string::npos) {
    if (!client.receive()) return reply;
  }
  const std::string head = client.taken.substr(0, end + 2);
  client.taken.erase(0, end + 4);
  reply.status = std::stoi(head.substr(9, 3));
  for (std::size_t at = head.find("\r\n") + 2; at < head.size();) {
    const auto next = head.find("\r\n", at);
    const auto colon = head.find(':', at);
    reply.headers[lower(head.substr(at, colon - at))] = head.substr(colon + 2, next - colon - 2);
    at = next + 2;
  }
  if (!with_body || reply.headers.count("content-length") == 0) return reply;
  const std::size_t size = std::stoul(reply.headers["content-length"]);
  while (client.taken.size() < size) {
    if (!client.receive()) break;
  }
  reply.body = client.taken.substr(0, size);
  client.taken.erase(0, size);
  return reply;
}

SocketClient::SocketClient(unsigned short port, const std::string& token, const std::string& origin)
    : client_(port) {
  const std::string host = "127.0.0.1:" + std::to_string(port);
  client_.send("GET /socket HTTP/1.1\r\nHost: " + host +
               "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
               "Origin: " +
               (origin.empty() ? "http://" + host : origin) +
               "\r\nSec-WebSocket-Protocol: cogrsim-studio, " + token + "\r\n\r\n");
  answer_ = read_reply(client_);
}

bool SocketClient::send(const std::string& text, int opcode) {
  std::string frame;
  frame += static_cast<char>(0x80 | opcode);
  // Masked with zeros, which leaves the text as it is.
  if (text.size() < 126) {
    frame += static_cast<char>(0x80 | text.size());
  } else {
    const int bytes = text.size() < 65536 ? 2 : 8;
    frame += static_cast<char>(0x80 | (bytes == 2 ? 126 : 127));
    for (int i = bytes - 1; i >= 0; --i) {
      frame += static_cast<char>((static_cast<std::uint64_t>(text.size()) >> (8 * i)) & 0xff);
    }
  }
  frame.append(4, '\0');
  return client_.send(frame + text);
}

std::optional<SocketClient::Message> SocketClient::receive() {
  const auto need = [this](std::size_t bytes) {
    while (client_.taken.size() < bytes) {
      if (!client_.receive()) return false;
    }
    return true;
  };
  const auto byte = [this](std::size_t at) {
    return static_cast<std::uint64_t>(static_cast<unsigned char>(client_.taken[at]));
  };
  if (!need(2)) return std::nullopt;
  std::uint64_t size = byte(1) & 0x7f;
  std::size_t head = 2;
  if (size >= 126) {
    const std::size_t bytes = size == 126 ? 2 : 8;
    if (!need(2 + bytes)) return std::nullopt;
    size = 0;
    for (std::size_t i = 0; i < bytes; ++i) size = size << 8 | byte(2 + i);
    head = 2 + bytes;
  }
  if (!need(head + size)) return std::nullopt;
  Message message{static_cast<int>(byte(0) & 0x0f), client_.taken.substr(head, size)};
  client_.taken.erase(0, head + size);
  return message;
}

std::optional<SocketClient::Message> SocketClient::receive(int opcode) {
  auto message = receive();
  while (message && message->opcode != opcode) message = receive();
  return message;
}

void FakeInbox::joined(ClientId client, Role role) {
  const std::lock_guard<std::mutex> lock(mutex_);
  joined_.emplace_back(client, role);
  news_.notify_all();
}

void FakeInbox::left(ClientId client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  left_.push_back(client);
  news_.notify_all();
}

void FakeInbox::received(ClientId client, std::string text) {
  if (on_received) on_received(client, text);
  const std::lock_guard<std::mutex> lock(mutex_);
  received_.push_back(std::move(text));
  news_.notify_all();
}

std::string FakeInbox::asset(std::size_t number) { return number == 0 ? asset_file : ""; }

std::vector<std::pair<ClientId, Role>> FakeInbox::wait_joined(std::size_t count) {
  std::unique_lock<std::mutex> lock(mutex_);
  news_.wait_for(lock, kLongest, [&] { return joined_.size() >= count; });
  return joined_;
}

std::vector<ClientId> FakeInbox::wait_left(std::size_t count) {
  std::unique_lock<std::mutex> lock(mutex_);
  news_.wait_for(lock, kLongest, [&] { return left_.size() >= count; });
  return left_;
}

std::vector<std::string> FakeInbox::wait_received(std::size_t count) {
  std::unique_lock<std::mutex> lock(mutex_);
  news_.wait_for(lock, kLongest, [&] { return received_.size() >= count; });
  return received_;
}

Served::Served(const ServerOptions& options, Inbox* other) {
  auto listening = Server::listen(options);
  if (!listening) throw std::runtime_error(listening.error().text());
  server_ = std::move(*listening);
  const auto token_of = [this](Role role) {
    const std::string address = server_->address(role);
    return address.substr(address.find("token=") + 6);
  };
  operator_token = token_of(Role::operator_);
  viewer_token = token_of(Role::viewer);
  const std::string address = server_->address(Role::operator_);
  host = address.substr(7, address.find('/', 7) - 7);
  port = static_cast<unsigned short>(std::stoi(host.substr(host.rfind(':') + 1)));
  thread_ = std::thread([this, other] { server_->run(other ? *other : inbox); });
}

void Served::stop() {
  server_->stop();
  if (thread_.joinable()) thread_.join();
}

HttpReply Served::get(const std::string& target, const std::string& more) {
  return raw("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n");
}

HttpReply Served::raw(std::string_view request) {
  RawClient client(port);
  client.send(request);
  const bool head = request.substr(0, 5) == "HEAD ";
  return read_reply(client, !head);
}

}  // namespace cogrsim::studio
