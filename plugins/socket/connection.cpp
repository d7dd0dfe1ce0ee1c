#include "connection.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <stdexcept>

namespace cogrsim::socket_controller {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what); }
[[noreturn]] void fail_with_errno(const std::string& what) {
  fail(what + ": " + std::strerror(errno));
}

/// Whether the file is ready for `events` before the deadline.
bool wait_for(int file, short events, Deadline deadline) {
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    pollfd one{file, events, 0};
    const int ready =
        ::poll(&one, 1, static_cast<int>(std::clamp<long long>(left.count(), 0, 1 << 30)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) fail_with_errno("the connection failed");
    if (ready == 0) return false;
  }
}

int new_socket(int family) {
  const int file = ::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (file < 0) fail_with_errno("no socket could be made");
  return file;
}

void bind_and_listen(int file, const sockaddr* address, socklen_t size, const std::string& text) {
  if (::bind(file, address, size) != 0 || ::listen(file, 64) != 0) {
    const int fault = errno;
    ::close(file);
    errno = fault;
    fail_with_errno("'" + text + "' cannot be listened at");
  }
}

/// The open folder of a file.
class Folder {
 public:
  /// Empty: none.
  explicit Folder(const std::string& file)
      : open_(file.empty()
                  ? -1
                  : ::open(file.substr(0, file.rfind('/') + 1).c_str(), O_PATH | O_CLOEXEC)) {}
  ~Folder() {
    if (open_ >= 0) ::close(open_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  /// The same file, by the folder if it is open.
  std::string shorten(const std::string& file) const {
    if (open_ < 0) return file;
    return "/proc/self/fd/" + std::to_string(open_) + file.substr(file.rfind('/'));
  }

 private:
  int open_;
};

int listen_unix(const std::string& path, const std::string& text) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // An address takes 107 characters; a longer path goes by its open folder.
  const Folder folder(path.size() < sizeof address.sun_path ? std::string() : path);
  const std::string shorter = folder.shorten(path);
  if (shorter.size() >= sizeof address.sun_path)
    fail("the name of '" + text + "' is too long; use a shorter one, or tcp:127.0.0.1:PORT");
  std::memcpy(address.sun_path, shorter.data(), shorter.size());
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0) {
    if (!S_ISSOCK(there.st_mode)) fail("'" + text + "' is a file that is not a socket");
    // A socket at which nobody listens any more was left behind; one in use stays.
    const int probe = new_socket(AF_UNIX);
    const bool used =
        ::connect(probe, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 ||
        errno == EAGAIN;
    ::close(probe);
    if (used) fail("another process listens at '" + text + "'");
    ::unlink(path.c_str());
  }
  const int file = new_socket(AF_UNIX);
  bind_and_listen(file, reinterpret_cast<sockaddr*>(&address), sizeof address, text);
  ::chmod(path.c_str(), S_IRUSR | S_IWUSR);
  return file;
}

int listen_tcp(const std::string& rest, const std::string& text, bool has_token) {
  const std::size_t colon = rest.rfind(':');
  std::string host = colon == std::string::npos ? "" : rest.substr(0, colon);
  if (host == "localhost") host = "127.0.0.1";
  if (host.size() > 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  const std::string digits = colon == std::string::npos ? "" : rest.substr(colon + 1);
  const bool is_port =
      !digits.empty() && digits.size() <= 5 &&
      std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; }) &&
      std::stoi(digits) >= 1 && std::stoi(digits) <= 65535;
  if (!is_port) fail("'" + text + "' has no port; expected tcp:127.0.0.1:5555");
  sockaddr_storage address{};
  socklen_t size = 0;
  bool loopback = false;
  auto* four = reinterpret_cast<sockaddr_in*>(&address);
  auto* six = reinterpret_cast<sockaddr_in6*>(&address);
  const auto port = htons(static_cast<std::uint16_t>(std::stoi(digits)));
  if (::inet_pton(AF_INET, host.c_str(), &four->sin_addr) == 1) {
    four->sin_family = AF_INET;
    four->sin_port = port;
    size = sizeof *four;
    loopback = (ntohl(four->sin_addr.s_addr) >> 24) == 127;
  } else if (::inet_pton(AF_INET6, host.c_str(), &six->sin6_addr) == 1) {
    six->sin6_family = AF_INET6;
    six->sin6_port = port;
    size = sizeof *six;
    loopback = IN6_IS_ADDR_LOOPBACK(&six->sin6_addr);
  } else {
    fail("'" + text + "' names no address in numbers; expected tcp:127.0.0.1:5555");
  }
  if (!loopback && !has_token)
    fail("'" + text +
         "' can be reached from other machines; set COGRSIM_CONTROLLER_TOKEN to a secret of at "
         "least 16 characters, which clients must send, or use tcp:127.0.0.1:PORT");
  const int file = new_socket(address.ss_family);
  const int on = 1;
  ::setsockopt(file, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  bind_and_listen(file, reinterpret_cast<sockaddr*>(&address), size, text);
  return file;
}

}  // namespace

Connection::~Connection() { ::close(file_); }

void Connection::transfer(char* data, std::size_t size, bool out, Deadline deadline) {
  while (size > 0) {
    const ssize_t count =
        out ? ::send(file_, data, size, MSG_NOSIGNAL) : ::recv(file_, data, size, 0);
    if (count > 0) {
      data += count;
      size -= static_cast<std::size_t>(count);
    } else if (count == 0) {
      fail("the client closed the connection");
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (!wait_for(file_, out ? POLLOUT : POLLIN, deadline))
        fail("the client did not answer in time");
    } else if (errno != EINTR) {
      if (errno == EPIPE || errno == ECONNRESET) fail("the client closed the connection");
      fail_with_errno("the connection failed");
    }
  }
}

void Connection::send(const std::string& message, Deadline deadline) {
  const std::uint32_t size = htonl(static_cast<std::uint32_t>(message.size()));
  // One packet: the length and the text.
  std::string bytes(reinterpret_cast<const char*>(&size), sizeof size);
  bytes += message;
  transfer(bytes.data(), bytes.size(), true, deadline);
}

std::string Connection::receive(Deadline deadline) {
  std::uint32_t size = 0;
  transfer(reinterpret_cast<char*>(&size), sizeof size, false, deadline);
  size = ntohl(size);
  if (size > kLargestMessage)
    fail("the client announced a message of " + std::to_string(size) + " bytes, more than " +
         std::to_string(kLargestMessage) +
         "; a message starts with its length in 4 bytes, the "
         "highest first");
  std::string message(size, '\0');
  transfer(message.data(), message.size(), false, deadline);
  return message;
}

std::shared_ptr<Listener> Listener::at(const std::string& address, const std::string& folder,
                                       bool has_token) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<Listener>> listeners;
  const bool is_unix = address.rfind("unix:", 0) == 0;
  std::string key = address;
  if (is_unix) {
    const fs::path path = fs::path(address.substr(5)).lexically_normal();
    if (path.empty() || path == "." || path.is_absolute() || *path.begin() == "..")
      fail("'" + address + "' is not a path inside the scene's folder; expected unix:run.sock");
    // The folder, without links, so that a link cannot lead out of it.
    std::error_code fault;
    const fs::path root = fs::canonical(folder.empty() ? "." : folder, fault);
    const fs::path parent = fs::canonical((root / path).parent_path(), fault);
    const auto [end, rest] = std::mismatch(root.begin(), root.end(), parent.begin(), parent.end());
    if (fault || end != root.end())
      fail("'" + address + "' is in no folder inside the scene's folder");
    (void)rest;
    key = (parent / path.filename()).string();
  } else if (address.rfind("tcp:", 0) != 0) {
    fail("'" + address + "' is not an address; expected unix:run.sock or tcp:127.0.0.1:5555");
  }
  const std::lock_guard lock(mutex);
  if (auto known = listeners[key].lock()) return known;
  std::shared_ptr<Listener> made(new Listener);
  if (is_unix) {
    made->file_ = listen_unix(key, address);
    made->path_ = key;
  } else {
    made->file_ = listen_tcp(address.substr(4), address, has_token);
  }
  listeners[key] = made;
  return made;
}

Listener::~Listener() {
  if (file_ >= 0) ::close(file_);
  if (!path_.empty()) ::unlink(path_.c_str());
}

std::unique_ptr<Connection> Listener::accept(Deadline deadline) {
  while (true) {
    const int file = ::accept4(file_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (file >= 0) {
      const int on = 1;
      ::setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return std::make_unique<Connection>(file);
    }
    if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR && errno != ECONNABORTED)
      fail_with_errno("no client could be accepted");
    if (!wait_for(file_, POLLIN, deadline)) fail("no client connected in time");
  }
}

}  // namespace cogrsim::socket_controller
