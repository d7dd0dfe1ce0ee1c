#include "net/server.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <set>

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/websocket.hpp>

#include "cogrsim/core/shown_text.h"
#include "net/http.h"
#include "net/mailbox.h"

namespace cogrsim::net {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kHeadBytes = 32u << 10;   // other servers of this machine set cookies
constexpr std::size_t kReadBytes = 64u << 10;
constexpr std::size_t kLingerBytes = 256u << 10;  // read and thrown away behind a refusal
constexpr std::chrono::seconds kLinger{2}, kGoodbye{1};

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<long long>(seconds * 1e3));
}

std::string literal(const asio::ip::address& address) {
  return address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
}

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

class Connection;
class WebClient;

struct Server::Impl {
  ServerOptions options;
  tcp::endpoint endpoint;
  Inbox* inbox = nullptr;
  Gatekeeper* gate = nullptr;

  std::size_t sockets = 0, viewers = 0;  // WebSockets open or being opened, and viewers' of them
  std::set<Connection*> connections;
  std::map<ClientId, WebClient*> clients;
  ClientId last_client = 0;
  bool stopping = false, over = false;  // over: run() has returned

  mutable std::mutex mutex;  // guards the boxes, which other threads look up
  std::map<ClientId, std::shared_ptr<Mailbox>> boxes;

  // Last: what waits in it refers to the above.
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::posix::stream_descriptor stop_event{io};
  asio::steady_timer goodbye{io}, accept_again{io};

  void accept();
  bool make_space(const asio::ip::address& from);
  void shut();
  void gone();
  std::shared_ptr<Mailbox> box(ClientId client) const {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = boxes.find(client);
    return found == boxes.end() ? nullptr : found->second;
  }
  void wake(ClientId client);
};

// One WebSocket, from its opening to its end.
class WebClient : public std::enable_shared_from_this<WebClient> {
 public:
  WebClient(Server::Impl& server, beast::tcp_stream stream, Role role)
      : server_(server),
        socket_(std::move(stream)),
        role_(role),
        allowance_(2.0 * server.options.limits.messages_per_second) {
    ++server_.sockets;
    if (role_ == Role::viewer) ++server_.viewers;
  }
  ~WebClient() {
    if (box_) end();
    --server_.sockets;
    if (role_ == Role::viewer) --server_.viewers;
  }

  void open(const http::request<http::empty_body>& request, const std::string& subprotocol) {
    const auto& limits = server_.options.limits;
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has clocks of its own
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = milliseconds(limits.request_seconds);
    timeout.idle_timeout = milliseconds(limits.idle_seconds);
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.set_option(
        websocket::stream_base::decorator([subprotocol](websocket::response_type& answer) {
          answer.set(http::field::sec_websocket_protocol, subprotocol);
        }));
    // Counted in read(): Beast's own limit closes the socket while bytes are unread, by which the other
    // side loses the reason (its teardown reads 2 kB, then stops).
    socket_.read_message_max(0);
    most_bytes_ = role_ == Role::viewer ? limits.viewer_message_bytes : limits.message_bytes;
    socket_.auto_fragment(false);
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (!error && !self->server_.stopping) self->join();
    });
  }

  // Sends the waiting messages, one at a time.
  void pump() {
    if (writing_ || ended_) return;
    if (box_->overfull()) return end();  // it reads nothing, so no reason would reach it
    const auto item = box_->next();
    if (!item) {
      if (leaving_) close(websocket::close_code::going_away, server_.options.ending.c_str());
      return;
    }
    writing_ = true;
    socket_.binary(item->binary);
    head_ = item->head;
    socket_.async_write(
        std::array<asio::const_buffer, 2>{asio::buffer(head_), asio::buffer(*item->bytes)},
        [self = shared_from_this(), bytes = item->bytes](error_code error, std::size_t) {
          self->writing_ = false;
          if (error) return self->end();
          if (self->closing_) return self->close_now();
          self->pump();
        });
  }

  void wake() {
    box_->wake_seen();
    // A write that is stuck must not keep a client whose texts pile up.
    if (box_->overfull()) return end();
    pump();
  }

  void leave() {
    if (!server_.options.goodbye.empty()) {
      box_->put_text(std::make_shared<const std::string>(server_.options.goodbye));
    }
    leaving_ = true;
    pump();
  }

 private:
  void join() {
    id_ = ++server_.last_client;
    box_ = std::make_shared<Mailbox>(server_.options.limits.waiting_bytes,
                                     server_.options.limits.stream_bytes);
    server_.clients[id_] = this;
    {
      const std::lock_guard<std::mutex> lock(server_.mutex);
      server_.boxes[id_] = box_;
    }
    server_.inbox->joined(id_, role_);
    read();
  }

  void read() {
    socket_.async_read_some(
        buffer_, kReadBytes, [self = shared_from_this()](error_code error, std::size_t) {
          if (error) return self->end();
          if (!self->closing_ && self->buffer_.size() > self->most_bytes_) {
            self->close(websocket::close_code::too_big, "the message is too long");
          }
          self->closing_ || self->socket_.is_message_done() ? self->take() : self->read();
        });
  }

  void take() {
    if (ended_) return;
    if (closing_) {  // what comes now is too late
      buffer_.clear();
      return read();
    }
    if (!allowed()) {
      close(websocket::close_code::policy_error, "too many messages");
      return read();
    }
    std::string text = beast::buffers_to_string(buffer_.data());
    buffer_.clear();
    if (buffer_.capacity() > (64u << 10)) buffer_.shrink_to_fit();
    if (!socket_.got_text()) {
      if (!server_.inbox->received_bytes(id_, text))
        close(websocket::close_code::unknown_data, "messages of a page are texts");
    } else if (server_.options.acknowledgements && (text == "a" || text == "p")) {
      text == "a" ? box_->frame_taken() : box_->picture_taken();
      pump();
    } else {
      server_.inbox->received(id_, std::move(text));
    }
    read();
  }

  // A bucket that fills at the rate allowed and holds two seconds of it.
  bool allowed() {
    const double rate = server_.options.limits.messages_per_second;
    const auto now = Clock::now();
    allowance_ += rate * std::chrono::duration<double>(now - counted_).count();
    allowance_ = std::min(allowance_, 2.0 * rate);
    counted_ = now;
    if (allowance_ < 1.0) return false;
    allowance_ -= 1.0;
    return true;
  }

  // Says why, then ends; the message that is being written comes first.
  void close(websocket::close_code code, const char* why) {
    if (closing_ || ended_) return;
    closing_ = true;
    reason_ = websocket::close_reason(code, why);
    box_->close();
    if (!writing_) close_now();
  }

  void close_now() {
    socket_.async_close(reason_, [self = shared_from_this()](error_code) { self->end(); });
  }

  void end() {
    if (ended_) return;
    ended_ = true;
    box_->close();
    server_.clients.erase(id_);
    {
      const std::lock_guard<std::mutex> lock(server_.mutex);
      server_.boxes.erase(id_);
    }
    if (server_.over) return;
    beast::get_lowest_layer(socket_).close();
    server_.inbox->left(id_);
    server_.gone();
  }

  Server::Impl& server_;
  websocket::stream<beast::tcp_stream> socket_;
  Role role_;
  ClientId id_ = 0;
  std::shared_ptr<Mailbox> box_;
  beast::flat_buffer buffer_;
  std::string head_;  // of the message that is being written
  std::size_t most_bytes_ = 0;  // of a message
  double allowance_;            // of messages
  Clock::time_point counted_ = Clock::now();
  websocket::close_reason reason_;
  bool writing_ = false, closing_ = false, leaving_ = false, ended_ = false;
};

// One TCP connection that speaks HTTP.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Server::Impl& server, tcp::socket socket)
      : server_(server), stream_(std::move(socket)) {
    server_.connections.insert(this);
    error_code ignored;
    const auto local = stream_.socket().local_endpoint(ignored);
    if (!ignored) local_address_ = literal(local.address());
    from_ = stream_.socket().remote_endpoint(ignored).address();
  }
  ~Connection() {
    server_.connections.erase(this);
    server_.gone();
  }

  const asio::ip::address& from() const { return from_; }
  /// When it began to send its request, or to be answered.
  Clock::time_point since() const { return since_; }

  void read() {
    since_ = Clock::now();
    parser_.emplace();
    parser_->header_limit(kHeadBytes);
    // For the whole head: one byte a second is not good enough.
    stream_.expires_after(milliseconds(server_.options.limits.request_seconds));
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](error_code error, std::size_t) { self->take(error); });
  }

  void drop() {
    server_.connections.erase(this);
    stream_.close();
  }

 private:
  void take(error_code error) {
    if (server_.stopping) return;
    if (error == http::error::end_of_stream || error == asio::error::operation_aborted) return;
    if (error == beast::error::timeout) {
      stream_.close();
      return;
    }
    if (error == http::error::header_limit) {
      return answer(refusal(431, "The head of the request is too long."), false);
    }
    bool with_body = error == http::error::unexpected_body || error == http::error::body_limit;
    if (error && !with_body) {
      if (error.category() != http::make_error_code(http::error::bad_method).category()) return;
      return answer(refusal(400, "This is no request that can be understood."), false);
    }
    const auto& message = parser_->get();
    with_body = with_body || message.count(http::field::transfer_encoding) > 0;
    HttpRequest request;
    request.method = view(message.method_string());
    request.target = view(message.target());
    request.host = view(message[http::field::host]);
    request.one_host = message.count(http::field::host) == 1;
    request.origin = view(message[http::field::origin]);
    request.accept_encoding = view(message[http::field::accept_encoding]);
    request.if_none_match = view(message[http::field::if_none_match]);
    const auto [first, last] = message.equal_range(http::field::sec_websocket_protocol);
    for (auto field = first; field != last; ++field) {
      request.protocols.push_back(view(field->value()));
    }
    request.upgrade = websocket::is_upgrade(message);
    request.local_address = local_address_;
    Gatekeeper::Decision decision = server_.gate->decide(request);
    if (with_body && (decision.upgrade || decision.answer.status < 400)) {
      return answer(refusal(413, "A request has no body here."), false);
    }
    if (!decision.upgrade) {
      // A refused client is dropped: nothing is kept open for it.
      const bool keep = message.keep_alive() && decision.answer.status < 400;
      return answer(std::move(decision.answer), keep);
    }
    const auto& limits = server_.options.limits;
    if (server_.sockets >= limits.clients ||
        (*decision.upgrade == Role::viewer && server_.viewers >= limits.viewers)) {
      return answer(refusal(503, "There are as many clients as are allowed."), false);
    }
    if (buffer_.size() > 0) {
      return answer(refusal(400, "A WebSocket begins after its answer."), false);
    }
    std::make_shared<WebClient>(server_, std::move(stream_), *decision.upgrade)
        ->open(parser_->release(), decision.subprotocol);
  }

  void answer(HttpAnswer what, bool keep_alive) {
    since_ = Clock::now();
    out_ = std::move(what);
    head_ = out_.head(keep_alive);
    const std::string_view content = out_.content();
    stream_.expires_after(milliseconds(server_.options.limits.idle_seconds));
    asio::async_write(stream_,
                      std::array<asio::const_buffer, 2>{
                          asio::buffer(head_), asio::buffer(content.data(), content.size())},
                      [self = shared_from_this(), keep_alive](error_code error, std::size_t) {
                        self->out_ = {};
                        if (error || self->server_.stopping) return;
                        keep_alive ? self->read() : self->close_gracefully();
                      });
  }

  // Closing with unread bytes would make the other side lose the answer: keeps reading for a while.
  void close_gracefully() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(kLinger);
    linger();
  }
  void linger() {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(16u << 10),
                            [self = shared_from_this()](error_code error, std::size_t more) {
                              self->lingered_ += more;
                              if (!error && self->lingered_ < kLingerBytes) self->linger();
                            });
  }

  Server::Impl& server_;
  beast::tcp_stream stream_;
  std::string local_address_, head_;
  asio::ip::address from_;
  Clock::time_point since_ = Clock::now();
  HttpAnswer out_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::size_t lingered_ = 0;
};

void Server::Impl::accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (stopping) return;
    if (error) {
      // Out of descriptors, most likely: trying again at once would only burn time.
      accept_again.expires_after(std::chrono::milliseconds(100));
      accept_again.async_wait([this](error_code) {
        if (!stopping) accept();
      });
      return;
    }
    error_code ignored;
    const auto from = socket.remote_endpoint(ignored).address();
    // Beyond the limits it is closed as it goes out of scope.
    if (!ignored && make_space(from)) {
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Connection>(*this, std::move(socket))->read();
    }
    accept();
  });
}

// For one more connection: silent connections keep no client out.
bool Server::Impl::make_space(const asio::ip::address& from) {
  Connection *oldest = nullptr, *oldest_there = nullptr;
  std::size_t there = 0;
  const auto older = [](const Connection* one, const Connection* other) {
    return !other || one->since() < other->since();
  };
  for (Connection* connection : connections) {
    if (older(connection, oldest)) oldest = connection;
    if (connection->from() != from) continue;
    ++there;
    if (older(connection, oldest_there)) oldest_there = connection;
  }
  if (there >= options.limits.of_one_address) {
    oldest_there->drop();
  } else if (connections.size() + sockets >= options.limits.connections) {
    if (!oldest) return false;
    oldest->drop();
  }
  return true;
}

void Server::Impl::shut() {
  stopping = true;
  error_code ignored;
  acceptor.close(ignored);
  // The stop event stays open: a second stop() must not write into what has its number then.
  accept_again.cancel();
  for (Connection* connection : std::set<Connection*>(connections)) connection->drop();
  goodbye.expires_after(kGoodbye);
  goodbye.async_wait([this](error_code error) {
    if (!error) io.stop();
  });
  for (const auto& [id, client] : std::map<ClientId, WebClient*>(clients)) client->leave();
  gone();
}

// A client has left: when the server ends and all are gone, the wait is over.
void Server::Impl::gone() {
  if (stopping && !over && clients.empty() && connections.empty()) goodbye.cancel();
}

void Server::Impl::wake(ClientId client) {
  asio::post(io, [this, client] {
    const auto found = clients.find(client);
    if (found != clients.end()) found->second->wake();
  });
}

Result<std::shared_ptr<Server::Impl>> Server::open(const ServerOptions& options) {
  auto impl = std::make_shared<Impl>();
  impl->options = options;
  error_code error;
  const auto address =
      asio::ip::make_address(options.host == "localhost" ? "127.0.0.1" : options.host, error);
  if (error) {
    return fail(fmt::format("'{}' is not an address to listen at", options.host), "",
                "write 127.0.0.1 for this machine alone, or an address it has in its network");
  }
  const auto try_port = [&](unsigned short port) {
    const tcp::endpoint wanted(address, port);
    tcp::acceptor& acceptor = impl->acceptor;
    error = {};
    if (acceptor.is_open()) acceptor.close(error);
    acceptor.open(wanted.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error && address.is_v6()) acceptor.set_option(asio::ip::v6_only(true), error);
    if (!error) acceptor.bind(wanted, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (!error) impl->endpoint = acceptor.local_endpoint(error);
    return !error;
  };
  bool listening = false;
  if (options.port == 0) {
    for (const unsigned short port : options.preferred) {
      listening = listening || try_port(port);
    }
  }
  if (!listening && !try_port(options.port)) {
    return fail(
        fmt::format("cannot listen at {}:{}: {}", literal(address), options.port, error.message()),
        "",
        error == asio::error::address_in_use
            ? "choose another port, or leave it out for one that is free"
            : "");
  }
  const int event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (event < 0) return fail(fmt::format("no event to be had: {}", std::strerror(errno)));
  impl->stop_event.assign(event, error);
  return impl;
}

Result<std::unique_ptr<Server>> Server::listen(const ServerOptions& options) {
  auto opened = open(options);
  if (!opened) return tl::unexpected(opened.error());
  return std::unique_ptr<Server>(new Server(std::move(*opened)));
}

Server::Server(std::shared_ptr<Impl> impl)
    : impl_(std::move(impl)), stop_event_(impl_->stop_event.native_handle()) {}

Server::~Server() = default;

std::string Server::address(const std::string& rest, const char* scheme) const {
  asio::ip::address host = impl_->endpoint.address();
  if (host.is_unspecified()) {
    host = host.is_v6() ? asio::ip::address(asio::ip::address_v6::loopback())
                        : asio::ip::address(asio::ip::address_v4::loopback());
  }
  return fmt::format("{}://{}:{}/{}", scheme, literal(host), port(), rest);
}

unsigned short Server::port() const { return impl_->endpoint.port(); }

std::string Server::endpoint_name() const {
  return fmt::format("{}_{}", impl_->endpoint.address().to_string(), port());
}

std::size_t Server::client_count() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->boxes.size();
}

void Server::run(Inbox& inbox, Gatekeeper& gate) {
  impl_->inbox = &inbox;
  impl_->gate = &gate;
  impl_->stop_event.async_wait(asio::posix::stream_descriptor::wait_read,
                               [impl = impl_.get()](error_code) { impl->shut(); });
  impl_->accept();
  while (true) {
    try {
      impl_->io.run();
      break;
    } catch (const std::exception& e) {
      // Memory, most likely: this client gets no answer, the others continue.
      fmt::print(stderr, "warning: a request failed: {}\n", paragraph(message_of(e)));
    }
  }
  impl_->over = true;
}

void Server::stop() noexcept {
  const std::uint64_t one = 1;
  // The event's count cannot overflow, so writing succeeds; a handler of signals could do nothing else.
  [[maybe_unused]] const auto written = write(stop_event_, &one, sizeof one);
}

void Server::send(ClientId client, std::string text) {
  const auto box = impl_->box(client);
  if (box && box->put_text(std::make_shared<const std::string>(std::move(text)))) {
    impl_->wake(client);
  }
}

void Server::send_all(std::string text) {
  const auto shared = std::make_shared<const std::string>(std::move(text));
  std::vector<std::pair<ClientId, std::shared_ptr<Mailbox>>> all;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    all.assign(impl_->boxes.begin(), impl_->boxes.end());
  }
  for (const auto& [client, box] : all) {
    if (box->put_text(shared)) impl_->wake(client);
  }
}

void Server::offer_frame(ClientId client, Bytes frame) {
  const auto box = impl_->box(client);
  if (box && frame && box->put_frame(std::move(frame))) impl_->wake(client);
}

void Server::offer_picture(ClientId client, const std::string& key, Bytes picture) {
  const auto box = impl_->box(client);
  if (box && picture && box->put_picture(key, std::move(picture))) impl_->wake(client);
}

std::size_t Server::stream(ClientId client, std::string head, Bytes body, bool keep) {
  std::size_t dropped = 0;
  const auto box = impl_->box(client);
  if (box && body && box->put_stream(std::move(head), std::move(body), dropped, keep))
    impl_->wake(client);
  return dropped;
}

bool Server::wants_picture(ClientId client) const {
  const auto box = impl_->box(client);
  return box && box->wants_picture();
}

}  // namespace cogrsim::net
