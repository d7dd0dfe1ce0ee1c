// WebSockets: no client waits for another, and nothing grows without bounds.
#include <atomic>

#include <catch2/catch.hpp>

#include "net/mailbox.h"
#include "server_client.h"

using namespace cogrsim::studio;
using cogrsim::net::Mailbox;
using Catch::Matchers::Contains;

namespace {

Bytes bytes(std::string text) { return std::make_shared<const std::string>(std::move(text)); }

// The code and the reason of a close message.
int code_of(const std::optional<SocketClient::Message>& message) {
  if (!message || message->opcode != 8 || message->payload.size() < 2) return 0;
  return static_cast<unsigned char>(message->payload[0]) * 256 +
         static_cast<unsigned char>(message->payload[1]);
}

}  // namespace

TEST_CASE("a mailbox keeps texts in order and the newest of all else", "[studio][mailbox]") {
  Mailbox box(1000);
  CHECK(box.put_frame(bytes("f1")));
  CHECK_FALSE(box.put_frame(bytes("f2")));  // it was woken already
  CHECK_FALSE(box.put_text(bytes("t1")));
  CHECK_FALSE(box.put_text(bytes("t2")));
  box.wake_seen();
  CHECK(box.put_picture("b", bytes("b1")));
  box.put_picture("a", bytes("a1"));
  box.put_picture("a", bytes("a2"));
  CHECK(*box.next()->bytes == "t1");
  CHECK(*box.next()->bytes == "t2");
  CHECK(*box.next()->bytes == "f2");
  box.put_frame(bytes("f3"));
  CHECK(*box.next()->bytes == "a2");
  CHECK_FALSE(box.next());  // one of each is in flight
  CHECK_FALSE(box.wants_picture());
  box.put_picture("a", bytes("a3"));
  box.picture_taken();
  CHECK(*box.next()->bytes == "b1");  // not "a" again: they take turns
  box.picture_taken();
  CHECK(*box.next()->bytes == "a3");
  CHECK_FALSE(box.wants_picture());
  box.picture_taken();
  CHECK(box.wants_picture());
  box.frame_taken();
  CHECK(*box.next()->bytes == "f3");
  CHECK(box.waiting_bytes() == 0);
}

TEST_CASE("a mailbox gives up beyond its limit", "[studio][mailbox]") {
  Mailbox box(1000);
  box.put_text(bytes(std::string(5000, 'x')));  // alone it may be longer
  CHECK_FALSE(box.overfull());
  box.put_text(bytes(std::string(1000, 'x')));
  CHECK_FALSE(box.overfull());
  box.put_text(bytes("x"));
  CHECK(box.overfull());
  CHECK(box.waiting_bytes() == 0);
  CHECK_FALSE(box.put_text(bytes("x")));
  CHECK_FALSE(box.put_frame(bytes("x")));
  CHECK(box.waiting_bytes() == 0);
}

TEST_CASE("a stream in a mailbox loses its oldest messages", "[studio][mailbox]") {
  Mailbox box(1000, 10);
  std::size_t dropped = 0;
  CHECK(box.put_stream("h", bytes("four"), dropped));
  box.put_stream("h", bytes("four"), dropped);
  CHECK(dropped == 0);
  CHECK(box.waiting_bytes() == 10);
  box.put_stream("2", bytes("more"), dropped);
  CHECK(dropped == 1);
  box.put_stream("3", bytes(std::string(100, 'x')), dropped);  // alone it may be longer
  CHECK(dropped == 3);
  box.put_text(bytes("text"));
  CHECK(*box.next()->bytes == "text");
  const auto item = box.next();
  CHECK(item->head == "3");
  CHECK(item->bytes->size() == 100);
  CHECK(item->binary);
  CHECK_FALSE(box.next());
  CHECK(box.waiting_bytes() == 0);
}

TEST_CASE("a stream in a mailbox keeps what is to be kept", "[studio][mailbox]") {
  Mailbox box(20, 10);
  std::size_t dropped = 0;
  box.put_stream("s", bytes(std::string(100, 's')), dropped, true);  // the largest may be longer
  for (int i = 0; i < 5; ++i) box.put_stream("h", bytes("four"), dropped);
  CHECK(dropped == 3);
  CHECK(box.waiting_bytes() == 111);
  box.put_stream("a", bytes("answer"), dropped, true);
  CHECK(dropped == 3);
  CHECK_FALSE(box.overfull());
  // in their order
  for (const char* head : {"s", "h", "h", "a"}) CHECK(box.next()->head == head);
  CHECK_FALSE(box.next());
  CHECK(box.waiting_bytes() == 0);
  // and no more of them than of texts
  for (int i = 0; i < 4; ++i) box.put_stream("a", bytes("answer"), dropped, true);
  CHECK(box.overfull());
  CHECK(box.waiting_bytes() == 0);
}

TEST_CASE("texts go in both directions with the client's role", "[studio][server]") {
  Served served;
  SocketClient one(served.port, served.operator_token);
  served.inbox.wait_joined(1);
  SocketClient two(served.port, served.viewer_token);
  const auto joined = served.inbox.wait_joined(2);
  REQUIRE(joined.size() == 2);
  CHECK(joined[0] == std::make_pair(ClientId{1}, Role::operator_));
  CHECK(joined[1] == std::make_pair(ClientId{2}, Role::viewer));
  CHECK(served.server().client_count() == 2);
  one.send("hello \xc3\xa4");
  CHECK(served.inbox.wait_received(1).back() == "hello \xc3\xa4");
  served.server().send(2, "to two");
  served.server().send_all("to all");
  served.server().send(77, "to no client");
  CHECK(one.receive(1)->payload == "to all");
  CHECK(two.receive(1)->payload == "to two");
  CHECK(two.receive(1)->payload == "to all");
  one.close();
  CHECK(served.inbox.wait_left(1) == std::vector<ClientId>{1});
}

TEST_CASE("a client that takes no frame in costs one that waits", "[studio][server]") {
  Served served;
  SocketClient frozen(served.port, served.operator_token);
  served.inbox.wait_joined(1);
  SocketClient lively(served.port, served.operator_token);
  served.inbox.wait_joined(2);

  std::vector<std::weak_ptr<const std::string>> frames;
  std::string got;
  for (int i = 0; i < 500; ++i) {
    const Bytes frame = bytes(std::to_string(i) + " " + std::string(100000, 'f'));
    frames.push_back(frame);
    served.server().offer_frame(1, frame);
    served.server().offer_frame(2, frame);
    // Only the one that reads and answers is sent them all.
    got = lively.receive(2)->payload;
    REQUIRE(got == *frame);
    lively.send("a");
  }
  // Of the other's the newest waits, beside one in flight.
  int alive = 0;
  for (const auto& frame : frames) alive += frame.expired() ? 0 : 1;
  CHECK(alive <= 2);
  // Texts get through to it all the same, behind the first frame.
  served.server().send(1, "text");
  CHECK(frozen.receive()->payload.substr(0, 2) == "0 ");
  CHECK(frozen.receive()->payload == "text");
  frozen.send("a");
  CHECK(frozen.receive()->payload.substr(0, 4) == "499 ");
}

TEST_CASE("pictures wait for each other and not for frames", "[studio][server]") {
  Served served;
  SocketClient client(served.port, served.operator_token);
  served.inbox.wait_joined(1);
  CHECK(served.server().wants_picture(1));
  CHECK_FALSE(served.server().wants_picture(2));
  served.server().offer_picture(1, "left", bytes("left 1"));
  CHECK_FALSE(served.server().wants_picture(1));
  CHECK(client.receive(2)->payload == "left 1");
  served.server().offer_picture(1, "left", bytes("left 2"));
  served.server().offer_picture(1, "right", bytes("right 1"));
  served.server().offer_picture(1, "left", bytes("left 3"));
  served.server().offer_frame(1, bytes("frame"));
  CHECK(client.receive(2)->payload == "frame");
  client.send("p");
  CHECK(client.receive(2)->payload == "right 1");
  client.send("p");
  CHECK(client.receive(2)->payload == "left 3");
  CHECK_FALSE(served.server().wants_picture(1));
  client.send("p");
  client.send("after");  // taken in behind the "p"
  served.inbox.wait_received(1);
  CHECK(served.server().wants_picture(1));
}

TEST_CASE("a client whose texts pile up is cut off and the others stay", "[studio][server]") {
  ServerOptions options;
  options.limits.waiting_bytes = 2u << 20;
  Served served(options);
  SocketClient frozen(served.port, served.operator_token);
  served.inbox.wait_joined(1);
  SocketClient lively(served.port, served.operator_token);
  served.inbox.wait_joined(2);
  // The system's own buffers take some of it in: 64 MB are more than they have.
  const std::string text(1u << 20, 't');
  for (int i = 0; i < 64; ++i) {
    served.server().send_all(text);
    REQUIRE(lively.receive(1)->payload.size() == text.size());
  }
  CHECK(served.inbox.wait_left(1) == std::vector<ClientId>{1});
  served.server().send_all("still there");
  CHECK(lively.receive(1)->payload == "still there");
}

TEST_CASE("messages that break the rules end with a reason", "[studio][server]") {
  ServerOptions options;
  options.limits.message_bytes = 1000;
  options.limits.viewer_message_bytes = 100;
  options.limits.messages_per_second = 5.0;
  Served served(options);
  SECTION("too long") {
    SocketClient client(served.port, served.operator_token);
    client.send(std::string(1000, 'x'));
    CHECK(served.inbox.wait_received(1).size() == 1);
    client.send(std::string(1001, 'x'));
    CHECK(code_of(client.receive(8)) == 1009);
  }
  SECTION("too long for a viewer, which edits nothing") {
    SocketClient client(served.port, served.viewer_token);
    client.send(std::string(100, 'x'));
    CHECK(served.inbox.wait_received(1).size() == 1);
    client.send(std::string(101, 'x'));
    CHECK(code_of(client.receive(8)) == 1009);
  }
  SECTION("no text") {
    SocketClient client(served.port, served.operator_token);
    client.send("x", 2);
    CHECK(code_of(client.receive(8)) == 1003);
  }
  SECTION("no UTF-8") {
    SocketClient client(served.port, served.operator_token);
    client.send("\xff\xfe");
    CHECK(code_of(client.receive(8)) == 1007);
  }
  SECTION("too many") {
    SocketClient client(served.port, served.operator_token);
    // So many would be allowed in 18 s; they are sent in one go.
    for (int i = 0; i < 100; ++i) client.send("x");
    const auto message = client.receive(8);
    CHECK(code_of(message) == 1008);
    CHECK_THAT(message->payload, Contains("too many messages"));
  }
  SECTION("a frame that is none") {
    SocketClient client(served.port, served.operator_token);
    client.raw().send(std::string(20, '\xff'));
    CHECK(code_of(client.receive(8)) == 1002);
  }
  served.inbox.wait_left(1);
  SocketClient next(served.port, served.operator_token);
  CHECK(next.status() == 101);
}

TEST_CASE("a client that answers no ping is cut off", "[studio][server]") {
  ServerOptions options;
  options.limits.idle_seconds = 0.4;
  Served served(options);
  SocketClient client(served.port, served.operator_token);
  CHECK(client.receive(9));
  CHECK(served.inbox.wait_left(1) == std::vector<ClientId>{1});
}

TEST_CASE("there are no more WebSockets than allowed", "[studio][server]") {
  ServerOptions options;
  options.limits.clients = 2;
  Served served(options);
  SocketClient one(served.port, served.operator_token), two(served.port, served.viewer_token);
  CHECK(one.status() == 101);
  CHECK(two.status() == 101);
  CHECK(SocketClient(served.port, served.operator_token).status() == 503);
  one.close();
  served.inbox.wait_left(1);
  int status = 0;
  for (int i = 0; i < 1000 && status != 101; ++i) {
    status = SocketClient(served.port, served.operator_token).status();
  }
  CHECK(status == 101);
}

TEST_CASE("viewers leave a connection for an operator", "[studio][server]") {
  ServerOptions options;
  options.limits.clients = 3;
  options.limits.viewers = 2;
  Served served(options);
  SocketClient one(served.port, served.viewer_token), two(served.port, served.viewer_token);
  CHECK(two.status() == 101);
  CHECK(SocketClient(served.port, served.viewer_token).status() == 503);
  SocketClient own(served.port, served.operator_token);
  CHECK(own.status() == 101);
  // When an operator leaves, a third viewer is still refused.
  own.close();
  served.inbox.wait_left(1);
  CHECK(SocketClient(served.port, served.viewer_token).status() == 503);
}

TEST_CASE("the end is reported to every client", "[studio][server]") {
  ServerOptions options;
  options.goodbye = "goodbye";
  Served served(options);
  SocketClient client(served.port, served.operator_token);
  RawClient idle(served.port);
  served.inbox.wait_joined(1);
  served.server().send(1, "first");
  served.server().stop();
  CHECK(client.receive(1)->payload == "first");
  CHECK(client.receive(1)->payload == "goodbye");
  CHECK(code_of(client.receive(8)) == 1001);
  client.close();
  served.stop();
  served.server().send_all("too late");
  CHECK(served.inbox.wait_left(1).size() == 1);
}

TEST_CASE("a server that is stopped before it runs ends", "[studio][server]") {
  auto server = Server::listen({});
  REQUIRE(server);
  (*server)->stop();
  FakeInbox inbox;
  (*server)->run(inbox);
}

TEST_CASE("clients come and go while threads send", "[studio][server]") {
  Served served;
  std::atomic<bool> enough{false};
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      for (ClientId i = 1; !enough; ++i) {
        served.server().offer_frame(i % 40, bytes(std::string(1000, 'f')));
        served.server().offer_picture(i % 40, std::to_string(t), bytes(std::string(1000, 'p')));
        served.server().send(i % 40, "text");
        served.server().wants_picture(i % 40);
        if (i % 1000 == 0) served.server().send_all("all");
        std::this_thread::yield();
      }
    });
  }
  for (int i = 0; i < 30; ++i) {
    SocketClient client(served.port, i % 2 ? served.operator_token : served.viewer_token);
    REQUIRE(client.status() == 101);
    for (int k = 0; k < 20; ++k) {
      const auto message = client.receive();
      REQUIRE(message);
      if (message->opcode == 2) client.send(message->payload[0] == 'f' ? "a" : "p");
    }
    if (i % 3 == 0) client.send("", 8);  // some go politely
  }
  served.stop();
  enough = true;
  for (std::thread& thread : threads) thread.join();
  CHECK(served.inbox.wait_left(30).size() == 30);
}
