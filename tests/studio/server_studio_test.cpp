// Requests: access, and the answers to malformed ones.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <future>

#include "server/protocol.h"
#include "server/studio.h"
#include "server/turns.h"
#include "server_client.h"

using namespace cogrsim::studio;
using Catch::Matchers::Contains;

namespace {

// Answers "play" (operators), "seek" (all), holds "series", throws at "view", forgets "figure";
// "seek" to 1e9 s is an error of a file.
class FakePart final : public Part {
 public:
  explicit FakePart(Outbox& outbox) : outbox_(outbox) {}
  bool answers(Section section) const override { return section != Section::document; }
  void handle(Request request, Reply reply) override {
    last = request.fields;
    if (request.what == "view") throw std::runtime_error("no such thing");
    if (request.what == "figure") return;
    if (request.what == "seek" && request.fields.value("time", 0.0) == 1e9) {
      return reply(cogrsim::fail("not there", cogrsim::SourcePosition{"a.scene.xml", 3, 5, 2}));
    }
    if (request.what == "series") return held.push_back(std::move(reply));
    if (request.what == "play") {
      for (Reply& waiting : held) waiting(Json{{"late", true}});
      for (Reply& waiting : held) waiting(Json{{"twice", true}});
      held.clear();
    }
    reply(Json{{"time", request.fields.value("time", 0.0)}, {"text", "\xff"}});
  }
  void joined(ClientId client, Role) override { outbox_.send(client, R"({"topic": "status"})"); }
  void left(ClientId) override { ++gone; }

  std::vector<Reply> held;
  Json last;  // fields of the last request
  std::atomic<int> gone{0};

 private:
  Outbox& outbox_;
};

// Takes the part of the network.
class FakeOutbox final : public Outbox {
 public:
  void send(ClientId, std::string text) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    sent_.push_back(Json::parse(text));
    news_.notify_all();
  }
  void send_all(std::string) override {}
  void offer_frame(ClientId, Bytes) override {}
  void offer_picture(ClientId, const std::string&, Bytes) override {}
  bool wants_picture(ClientId) const override { return false; }
  // The next that was sent.
  Json next() {
    std::unique_lock<std::mutex> lock(mutex_);
    if (!news_.wait_for(lock, std::chrono::seconds(60), [&] { return sent_.size() > read_; })) {
      throw std::runtime_error("nothing was sent");
    }
    return sent_[read_++];
  }

 private:
  std::mutex mutex_;
  std::condition_variable news_;
  std::vector<Json> sent_;
  std::size_t read_ = 0;
};

StudioInfo info() { return {"1.2.3", "recording", "x.mcap", false, {"one", "two"}, "/asset/0f/"}; }

struct Bench {
  FakeOutbox outbox;
  FakePart part{outbox};
  Studio studio{info(), {&part}, [](std::size_t) { return ""; }, outbox, {4, 1000, 8}};

  explicit Bench(Role role = Role::operator_, bool greet = true) {
    studio.joined(1, role);
    if (!greet) return;
    ask(R"({"id": 0, "do": "hello"})");
    outbox.next();
  }
  Json ask(const std::string& text) {
    studio.received(1, text);
    return outbox.next();
  }
};

}  // namespace

TEST_CASE("hello comes first and reports roles", "[studio][requests]") {
  Bench bench(Role::viewer, false);
  CHECK_THAT(
      bench.ask(R"({"id": 1, "do": "seek", "time": 1})")["error"]["message"].get<std::string>(),
      Contains("say hello first"));
  const Json hello = bench.ask(R"({"id": 2, "do": "hello"})");
  CHECK(hello == Json::parse(R"({"id": 2, "ok": true, "protocol": 4, "role": "viewer",
      "client": 1, "version": "1.2.3", "kind": "recording", "file": "x.mcap", "allow_build": false,
      "assets": "/asset/0f/", "backends": ["one", "two"]})"));
  CHECK(bench.outbox.next()["topic"] == "status");
  const Json seek = bench.ask(R"({"id": 3, "do": "seek", "time": 1.5})");
  CHECK(seek["ok"] == true);
  CHECK(seek["id"] == 3);
  CHECK(seek["time"] == 1.5);
  CHECK(seek["text"] == "\xef\xbf\xbd");  // what is no UTF-8 becomes U+FFFD
}

TEST_CASE("viewers are refused what operators may do", "[studio][requests]") {
  Bench viewer(Role::viewer), operator_;
  const std::string play = R"({"id": 5, "do": "play"})";
  const Json refused = viewer.ask(play);
  CHECK(refused["ok"] == false);
  CHECK(refused["id"] == 5);
  CHECK(refused["error"]["code"] == "viewer");
  CHECK(operator_.ask(play)["ok"] == true);
}

TEST_CASE("viewers neither build nor debug", "[studio][requests][debug]") {
  Bench viewer(Role::viewer), operator_;
  std::size_t found = 0;
  for (const ProtocolRequest& request : protocol_requests()) {
    if (request.section != Section::debug) continue;
    INFO(request.name);
    ++found;
    const std::string text = Json{{"id", 5}, {"do", request.name}}.dump();
    CHECK(viewer.ask(text)["error"]["code"] == "viewer");
    // An operator's is looked at.
    CHECK(operator_.ask(text).dump().find("viewer") == std::string::npos);
  }
  CHECK(found == 7);
  for (const char* name : {"build", "save-source"}) {
    INFO(name);
    REQUIRE(find_request(name));
    CHECK_FALSE(find_request(name)->viewers);
  }
}

TEST_CASE("malformed requests are answered with their error", "[studio][requests]") {
  Bench bench;
  const auto message = [&](const std::string& text) {
    const Json answer = bench.ask(text);
    CHECK(answer["ok"] == false);
    return answer["error"]["message"].get<std::string>();
  };
  CHECK(message("") == "the request is not well-formed JSON");
  CHECK(message("{\"id\": 1, \"do\": \"seek\"") == "the request is not well-formed JSON");
  CHECK(message("{\"id\": 1e999, \"do\": \"seek\"}") == "the request is not well-formed JSON");
  CHECK(message("[1]") == "a request is an object");
  CHECK(message("3") == "a request is an object");
  CHECK(message(R"({"do": "seek"})") == "the request's 'id' is missing or no whole number");
  CHECK(message(R"({"id": "1", "do": "seek"})") ==
        "the request's 'id' is missing or no whole number");
  CHECK(message(R"({"id": 1})") == "the request's 'do' is missing or no text");
  CHECK(message(R"({"id": 1, "do": 2})") == "the request's 'do' is missing or no text");
  CHECK(message(std::string(500, '[')) == "the request is nested deeper than 8");
  CHECK(message(R"({"id": 1, "do": "seek", "x": [[[[[[[[]]]]]]]]})") ==
        "the request is nested deeper than 8");
  std::string wide = R"({"id": 1, "do": "seek", "x": [[])";
  for (int i = 0; i < 300'000; ++i) wide += ",[]";
  CHECK(message(wide + "]}") == "the request has more than 200000 values");
  // Brackets in a text are none.
  CHECK(bench.ask(R"({"id": 1, "do": "backend", "name": "[[[[[[[[[[\"[[["})")["ok"] == true);
  CHECK(message(R"({"id": 1, "do": "edit"})") == "'edit' is not there for a recording");
  const Json unknown = bench.ask(R"({"id": 9, "do": "plya"})");
  CHECK(unknown["error"]["message"] == "there is no request 'plya'");
  CHECK(unknown["error"]["help"] == "did you mean 'play'?");
  // What a file causes has its position as data.
  const Json placed = bench.ask(R"({"id": 1, "do": "seek", "time": 1e9})")["error"];
  CHECK(placed == Json{{"message", "not there"},
                       {"file", "a.scene.xml"},
                       {"line", 3},
                       {"column", 5},
                       {"length", 2}});
  // Parts that throw or forget.
  CHECK_THAT(message(R"({"id": 1, "do": "view"})"), Contains("'view' failed: no such thing"));
  CHECK(message(R"({"id": 1, "do": "figure", "plot": "p"})") == "the request was given up");
}

TEST_CASE("fields are as the table of the protocol has them", "[studio][requests]") {
  Bench bench;
  const auto error = [&](const std::string& text) {
    const Json answer = bench.ask(R"({"id": 1, "do": )" + text + "}");
    CHECK(answer["ok"] == false);
    const Json& found = answer["error"];
    return found["message"].get<std::string>() + "; " + found.value("help", "");
  };
  CHECK(error(R"("seek")") == "'seek' needs the field 'time': a number; ");
  CHECK(error(R"("seek", "time": null)") == "'time' must be a number; ");
  CHECK(error(R"("seek", "tiem": 1)") == "'seek' has no field 'tiem'; did you mean 'time'?");
  CHECK(error(R"("play", "now": true)") == "'play' has no field 'now'; it has none");
  CHECK(error(R"("step", "count": 0)") == "'count' must be a whole number from 1 to 10000; ");
  CHECK(error(R"("step", "count": 1.5)") == "'count' must be a whole number from 1 to 10000; ");
  CHECK(error(R"("speed", "factor": "fast")") ==
        "'factor' must be a number from 0.01 to 1000, or null; ");
  CHECK(error(R"("dt", "value": 0)") ==
        "'value' must be a number above 0 and at most 1, or null; ");
  CHECK(error(R"("series", "signals": ["a", 7])") == "'signals[1]' must be text; ");
  CHECK(error(R"("view", "pose": [1, 2])") == "'pose' must be a list of 7 numbers, or null; ");
  CHECK(error(R"("cameras", "show": [{"name": "eye", "kind": "xray"}])") ==
        "'show[0].kind' must be \"color\", \"depth\" or \"segmentation\"; ");
  CHECK(error(R"("cameras", "show": [{"name": "eye", "widht": 8}])") ==
        "'show[0]' has no field 'show[0].widht'; did you mean 'width'?");
  // What is left out, or null, gets its standard.
  CHECK(bench.ask(R"({"id": 1, "do": "step", "count": null})")["ok"] == true);
  CHECK(bench.part.last["count"] == 1);
  CHECK(bench.ask(R"({"id": 1, "do": "cameras", "show": [{"name": "eye"}]})")["ok"] == true);
  CHECK(bench.part.last["show"][0] == Json{{"name", "eye"}, {"kind", "color"}, {"width", 320}});
}

TEST_CASE("operations of an edit are distinguished by their name", "[studio][requests]") {
  const ProtocolRequest& edit = *find_request("edit");
  const auto error = [&](const char* op) {
    Json fields = {{"version", 1}, {"ops", Json::array({Json::parse(op)})}};
    const auto good = check_fields(edit, fields);
    return good ? std::string() : good.error().message + "; " + good.error().hint;
  };
  CHECK(error(R"({"op": "rename", "element": 1, "name": "a"})") == "");
  CHECK(error(R"({"op": "renam", "element": 1, "name": "a"})").find("; did you mean 'rename'?") !=
        std::string::npos);
  CHECK(error(R"({"op": "rename", "element": 1})") ==
        "'ops[0]' needs the field 'ops[0].name': text; ");
  CHECK(error(R"({"op": "remove", "elements": []})") ==
        "'ops[0].elements' must be a list of whole numbers from 0, not an empty one; ");
  CHECK(error("7").find("'ops[0]' must be an object") == 0);
}

TEST_CASE("answers may come late and come once", "[studio][requests]") {
  Bench bench;
  bench.studio.received(1, R"({"id": 1, "do": "series", "signals": []})");
  bench.studio.received(1, R"({"id": 2, "do": "play"})");
  const Json first = bench.outbox.next(), second = bench.outbox.next();
  CHECK(first["id"] == 1);
  CHECK(first["late"] == true);
  CHECK(second["id"] == 2);
  CHECK(bench.ask(R"({"id": 3, "do": "seek", "time": 0})")["id"] == 3);
}

TEST_CASE("too much at a time is refused and accepted later", "[studio][requests]") {
  Bench bench;
  for (int i = 0; i < 4; ++i) {
    bench.studio.received(1,
                          R"({"id": )" + std::to_string(i) + R"(, "do": "series", "signals": []})");
  }
  const Json busy = bench.ask(R"({"id": 7, "do": "seek", "time": 0})");
  CHECK(busy["id"] == 7);
  CHECK(busy["error"]["code"] == "busy");
}

TEST_CASE("operators come before viewers, and each kind takes turns", "[studio][requests]") {
  Turns<std::string> turns;
  const auto put = [&](ClientId client, Role role, int count) {
    for (int i = 1; i <= count; ++i) {
      turns.put(client, role, std::to_string(client) + "." + std::to_string(i));
    }
  };
  const auto take_all = [&] {
    std::string order;
    while (!turns.empty()) {
      const std::string next = turns.next();
      CHECK(turns.take() == next);
      order += next + " ";
    }
    return order;
  };
  put(7, Role::viewer, 3);
  put(8, Role::viewer, 2);
  put(3, Role::operator_, 2);
  put(5, Role::operator_, 1);
  put(0, Role::operator_, 2);
  CHECK(take_all() == "0.1 0.2 3.1 5.1 3.2 7.1 8.1 7.2 8.2 7.3 ");
  // A client that comes later waits only for the one whose turn it is.
  put(7, Role::viewer, 100);
  CHECK(turns.take() == "7.1");
  put(8, Role::viewer, 1);
  CHECK(turns.take() == "8.1");
  put(3, Role::operator_, 1);
  CHECK(turns.take() == "3.1");
  CHECK(turns.take() == "7.2");
  const auto is = [](const char* text) {
    return [text](const std::string& s) { return s == text; };
  };
  CHECK(turns.take_if(7, Role::viewer, is("7.9")) == "7.9");
  CHECK_FALSE(turns.take_if(7, Role::viewer, is("7.9")));
  CHECK_FALSE(turns.take_if(9, Role::viewer, is("9.1")));
  turns.clear();
  CHECK(turns.empty());
}

TEST_CASE("an operator waits for one request of viewers, whatever many there are",
          "[studio][requests]") {
  // Handles one request at a time, the first one until it is released.
  class SlowPart final : public Part {
   public:
    bool answers(Section) const override { return true; }
    void handle(Request request, Reply reply) override {
      order.push_back(request.client);
      if (order.size() == 1) {
        begun.set_value();
        go_on.get_future().wait();
      }
      reply(Json::object());
    }
    std::vector<ClientId> order;
    std::promise<void> begun, go_on;
  };
  FakeOutbox outbox;
  SlowPart part;
  Studio studio(
      info(), {&part}, [](std::size_t) { return ""; }, outbox);
  for (const ClientId client : {1, 2, 3, 4}) {
    studio.joined(client, client == 1 ? Role::operator_ : Role::viewer);
    studio.received(client, R"({"id": 0, "do": "hello"})");
    outbox.next();
  }
  const std::string request = R"({"id": 1, "do": "seek", "time": 1})";
  studio.received(2, request);
  part.begun.get_future().wait();
  for (int i = 0; i < 50; ++i) {
    for (const ClientId viewer : {2, 3, 4}) studio.received(viewer, request);
  }
  // When a viewer leaves, its answers are dropped.
  studio.joined(5, Role::viewer);
  studio.received(5, R"({"id": 0, "do": "hello"})");
  for (int i = 0; i < 50; ++i) studio.received(5, request);
  studio.left(5);
  studio.received(1, request);
  studio.received(1, request);
  part.go_on.set_value();
  for (int i = 0; i < 153; ++i) outbox.next();
  // The one that was being handled, the operator's two, then each viewer in turn.
  CHECK(std::vector<ClientId>(part.order.begin(), part.order.begin() + 9) ==
        std::vector<ClientId>{2, 1, 1, 3, 4, 2, 3, 4, 2});
  CHECK(std::count(part.order.begin(), part.order.end(), 5) == 0);
}

TEST_CASE("parts hear of a client's end if they heard of its start", "[studio][requests]") {
  FakeOutbox outbox;
  FakePart part(outbox);
  {
    Studio studio(
        info(), {&part}, [](std::size_t) { return ""; }, outbox);
    studio.joined(1, Role::operator_);
    studio.joined(2, Role::operator_);
    studio.received(1, R"({"id": 0, "do": "hello"})");
    outbox.next();
    outbox.next();
    studio.received(1, R"({"id": 1, "do": "series", "signals": []})");
    studio.left(1);
    studio.left(2);
    studio.received(2, "too late");
    studio.joined(3, Role::operator_);
    studio.received(3, R"({"id": 0, "do": "hello"})");
    outbox.next();
    // Clients of one role take turns: with the answer to the second of these, four of client 3's
    // events were taken, and so at least three of client 1's, which are two.
    for (int i = 1; i <= 2; ++i) {
      studio.received(3, R"({"id": )" + std::to_string(i) + R"(, "do": "seek", "time": 0})");
      outbox.next();
    }
    CHECK(part.gone == 1);
  }
  part.held.front()(Json::object());  // after the studio's end
}

TEST_CASE("a page asks over a WebSocket", "[studio][requests]") {
  auto listening = Server::listen({});
  REQUIRE(listening);
  Server& server = **listening;
  FakePart part(server);
  Studio studio(
      info(), {&part}, [](std::size_t) { return ""; }, server);
  std::thread thread([&] { server.run(studio); });
  const std::string address = server.address(Role::operator_);
  const auto colon = address.rfind(':');
  const std::string port = address.substr(colon + 1, address.find('/', colon) - colon - 1);
  SocketClient page(static_cast<unsigned short>(std::stoi(port)),
                    address.substr(address.find("token=") + 6));
  page.send(R"({"id": 1, "do": "hello"})");
  CHECK(Json::parse(page.receive(1)->payload)["role"] == "operator");
  CHECK(Json::parse(page.receive(1)->payload)["topic"] == "status");
  page.send(R"({"id": 2, "do": "seek", "time": 2})");
  CHECK(Json::parse(page.receive(1)->payload)["time"] == 2.0);
  server.stop();
  thread.join();
}
