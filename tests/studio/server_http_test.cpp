// Which HTTP requests are accepted, and how they are answered: over real sockets.
#include <filesystem>
#include <fstream>

#include <sys/stat.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include "../support/temporary_folder.h"
#include "server/page.h"
#include "server_client.h"

using namespace cogrsim::studio;
using Catch::Matchers::Contains;

namespace {

using Texts = std::vector<std::string>;

std::string gunzipped(const std::string& bytes) {
  PageFile file{};
  file.gzip = bytes;
  return inflated(file);
}

/// Address of the script that the page loads first.
std::string script_of(const std::string& page) {
  const auto script = page.find("src=\"");
  REQUIRE(script != std::string::npos);
  std::string name = page.substr(script + 5, page.find('"', script + 5) - script - 5);
  return "/" + name.substr(name.find_first_not_of("./"));
}

}  // namespace

TEST_CASE("the printed address has its token behind the '#'", "[studio][server]") {
  Served served;
  // Browsers send nothing of it to anybody, and the page is no secret.
  CHECK(served.server().address(Role::operator_) ==
        "http://" + served.host + "/#token=" + served.operator_token);
  CHECK(served.server().address(Role::viewer) ==
        "http://" + served.host + "/#token=" + served.viewer_token);
  CHECK(served.operator_token != served.viewer_token);
  CHECK(served.get("/").status == 200);
}

TEST_CASE("the address for the browser is good for one visit", "[studio][server]") {
  Served served;
  const std::string address = served.server().launch_address();
  const std::string target = address.substr(address.find("/?launch="));
  CHECK(target.find(served.operator_token) == std::string::npos);
  const std::string line = " HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n";
  CHECK(served.raw("HEAD " + target + line).status == 403);
  CHECK(served.get("/?launch=" + served.operator_token).status == 403);
  const HttpReply reply = served.raw("GET " + target + line);
  CHECK(reply.status == 303);
  CHECK(reply.header("location") == "/#token=" + served.operator_token);
  CHECK(reply.header("cache-control") == "no-store");
  CHECK(served.raw("GET " + target + line).status == 403);
  CHECK(served.get("/?launch=").status == 403);
}

TEST_CASE("without the right token there is the page and nothing else", "[studio][server]") {
  Served served;
  std::string almost = served.operator_token;
  almost.back() = almost.back() == '0' ? '1' : '0';
  for (const std::string& token :
       Texts{"x", almost, served.operator_token + "0", served.operator_token.substr(1),
             served.operator_token + "." + served.operator_token}) {
    const SocketClient refused(served.port, token);
    INFO(token);
    CHECK(refused.status() == 403);
    CHECK_THAT(refused.answer().body, Contains("terminal"));
    CHECK(refused.answer().header("content-type") == "text/plain; charset=utf-8");
  }
  // Nor where browsers would put it by themselves.
  const std::string upgrade =
      "Upgrade: websocket\r\nConnection: Upgrade\r\nOrigin: http://" + served.host +
      "\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n";
  for (const std::string& line :
       Texts{std::string(),
             "Cookie: cogrsim_studio_" + std::to_string(served.port) + "=" + served.operator_token +
                 "\r\n",
             "Sec-WebSocket-Protocol: cogrsim-studio\r\n",
             "Sec-WebSocket-Protocol: " + served.operator_token + "\r\n"}) {
    INFO(line);
    CHECK(served.get("/socket", upgrade + line).status == 403);
    CHECK(served.get("/socket?token=" + served.operator_token, upgrade + line).status == 403);
  }
  // One header or two, in any order.
  CHECK(served
            .get("/socket", upgrade + "Sec-WebSocket-Protocol: " + served.viewer_token +
                                "\r\nSec-WebSocket-Protocol: a, cogrsim-studio\r\n")
            .status == 101);
  CHECK(served.inbox.wait_joined(1).front().second == Role::viewer);
  // A browser takes the answer only if it names one of those it asked for.
  CHECK(
      SocketClient(served.port, served.operator_token).answer().header("sec-websocket-protocol") ==
      "cogrsim-studio");
}

TEST_CASE("no answer makes a browser send a secret by itself", "[studio][server]") {
  Served served;
  const std::string launch = served.server().launch_address();
  for (const std::string& target :
       Texts{std::string("/"), "/?token=" + served.operator_token,
             launch.substr(launch.find("/?launch=")), served.server().assets() + "0",
             std::string("/nothing"), std::string("/socket")}) {
    INFO(target);
    CHECK(served.get(target).header("set-cookie").empty());
  }
  CHECK(SocketClient(served.port, served.operator_token).answer().header("set-cookie").empty());
}

TEST_CASE("other names of this machine are refused", "[studio][server]") {
  Served served;
  const std::string port = std::to_string(served.port);
  const auto ask = [&](const std::string& hosts, const std::string& more = {}) {
    return served.raw("GET / HTTP/1.1\r\n" + hosts + more + "\r\n").status;
  };
  for (const std::string& good :
       Texts{"127.0.0.1:" + port, "localhost:" + port, "LocalHost:" + port, "[::1]:" + port}) {
    CHECK(ask("Host: " + good + "\r\n") == 200);
  }
  for (const std::string& bad :
       Texts{"evil.example:" + port, "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:" + port,
             "evil.example", "127.0.0.1.nip.io:" + port, "127.0.0.1:" + port + "@evil.example",
             "evil@127.0.0.1:" + port, "192.168.0.1:" + port, "0.0.0.0:" + port, ":" + port,
             "127.0.0.2:" + port}) {
    INFO(bad);
    CHECK(ask("Host: " + bad + "\r\n") == 403);
  }
  CHECK(ask("Host: \r\n") == 400);
  CHECK(ask("") == 400);
  CHECK(ask("Host: 127.0.0.1:" + port + "\r\nHost: evil.example\r\n") == 400);
}

TEST_CASE("pages of other servers are refused", "[studio][server]") {
  Served served;
  for (const std::string& bad :
       Texts{std::string("http://evil.example"), std::string("null"),
             std::string("http://127.0.0.1:1"), "https://" + served.host,
             "http://localhost:" + std::to_string(served.port),
             "http://" + served.host + ".evil.example", "http://" + served.host + "/"}) {
    INFO(bad);
    CHECK(served.get("/", "Origin: " + bad + "\r\n").status == 403);
    CHECK(SocketClient(served.port, served.operator_token, bad).status() == 403);
  }
  CHECK(served.get("/", "Origin: http://" + served.host + "\r\n").status == 200);
  CHECK(SocketClient(served.port, served.operator_token).status() == 101);
  // Browsers always say it when they open a WebSocket.
  CHECK(served
            .get("/socket",
                 "Sec-WebSocket-Protocol: cogrsim-studio, " + served.operator_token +
                     "\r\n"
                     "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n")
            .status == 403);
  CHECK(served.get("/socket").status == 426);
}

TEST_CASE("no address leads into the file system", "[studio][server]") {
  Served served;
  const std::string etc = "etc/passwd", assets = served.server().assets();
  CHECK(served.get("/asset/../../" + etc).status == 403);
  for (const std::string& target :
       Texts{"/../" + etc, "/../../../../../../" + etc, "/%2e%2e/%2e%2e/" + etc,
             "/..%2f..%2f" + etc, "/..\\..\\" + etc, "//" + etc, "/" + etc, "/./index.html",
             assets + "../../" + etc, assets + "/" + etc, assets + "-1", assets, assets + "0x0",
             assets + "0/..", assets + "99999999999999999999999", std::string("/index.html%00.png"),
             assets + "+0", assets + "%30"}) {
    INFO(target);
    const HttpReply reply = served.get(target);
    CHECK(reply.status == 404);
    CHECK_THAT(reply.body, !Contains("root:"));
  }
  // Whole addresses and others that start with no slash; a NUL; a bare line feed.
  for (const std::string& target :
       Texts{"http://" + served.host + "/", "file:///" + etc, std::string("*"), etc,
             std::string("/index.html\0", 12), std::string("/a\nb"), std::string("/a b")}) {
    const int status = served.get(target).status;
    INFO(target);
    CHECK(status == 400);
  }
}

TEST_CASE("textures are files by number and regular files alone", "[studio][server]") {
  const cogrsim::test::TemporaryFolder folder;
  const std::string png = folder / "a.png";
  std::ofstream(png) << "\x89PNG\r\n\x1a\n and what follows";
  Served served;
  served.inbox.asset_file = png;
  const std::string assets = served.server().assets();
  const HttpReply reply = served.get(assets + "0");
  CHECK(reply.status == 200);
  CHECK(reply.header("content-type") == "image/png");
  CHECK(reply.body == "\x89PNG\r\n\x1a\n and what follows");
  CHECK(served.get(assets + "0", "If-None-Match: " + reply.header("etag") + "\r\n").status == 304);
  CHECK(served.get(assets + "1").status == 404);
  // Only clients that received the address over the WebSocket know it.
  for (const std::string& wrong :
       Texts{std::string("/asset/0"), std::string("/asset//0"),
             "/asset/" + std::string(32, '0') + "/0", "/asset/" + served.operator_token + "/0"}) {
    INFO(wrong);
    CHECK(served.get(wrong).status == 403);
  }
  // A texture must never be served as a page of our own address.
  std::ofstream(png) << "<script>alert(1)</script>";
  CHECK(served.get(assets + "0").header("content-type") == "application/octet-stream");
  served.stop();

  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  for (const std::string& other : Texts{folder.path, folder / "pipe", folder / "gone"}) {
    Served again;
    again.inbox.asset_file = other;
    CHECK(again.get(again.server().assets() + "0").status == 404);
  }
}

TEST_CASE("every answer forbids what pages do not need", "[studio][server]") {
  Served served;
  for (const HttpReply& reply :
       {served.get("/"), served.get("/nothing"), served.get("/", "Origin: http://evil\r\n"),
        served.raw("GET / HTTP/1.1\r\n\r\n")}) {
    const std::string& policy = reply.header("content-security-policy");
    CHECK_THAT(policy, Contains("default-src 'none'; script-src 'self';"));
    CHECK_THAT(policy, Contains("connect-src 'self'"));
    CHECK_THAT(policy, Contains("frame-ancestors 'none'; base-uri 'none'; form-action 'none'"));
    CHECK_THAT(policy, !Contains("unsafe-eval"));
    CHECK(reply.header("x-content-type-options") == "nosniff");
    CHECK(reply.header("referrer-policy") == "no-referrer");
    CHECK(reply.header("cross-origin-opener-policy") == "same-origin");
  }
}

TEST_CASE("the page is sent compressed or not, and cached", "[studio][server]") {
  Served served;
  const HttpReply plain = served.get("/");
  const HttpReply packed = served.get("/index.html", "Accept-Encoding: br, gzip;q=0.8\r\n");
  REQUIRE(packed.status == 200);
  CHECK(packed.header("content-encoding") == "gzip");
  CHECK(plain.header("content-encoding").empty());
  CHECK(gunzipped(packed.body) == plain.body);
  CHECK_THAT(plain.body, Contains("<html"));
  CHECK(plain.header("content-type") == "text/html; charset=utf-8");
  CHECK(plain.header("cache-control") == "private, no-cache");
  CHECK(served.get("/", "Accept-Encoding: gzip;q=0, br\r\n").header("content-encoding").empty());
  const HttpReply again = served.get("/", "If-None-Match: " + plain.header("etag") + "\r\n");
  CHECK(again.status == 304);
  CHECK(again.body.empty());
  // The page's first files are there, and never change.
  const std::string name = script_of(plain.body);
  const HttpReply code = served.get(name);
  INFO(name);
  CHECK(code.status == 200);
  CHECK(code.header("content-type") == "text/javascript; charset=utf-8");
  CHECK(code.header("cache-control") == "private, max-age=31536000, immutable");
}

TEST_CASE("HEAD gives the length without the body", "[studio][server]") {
  Served served;
  const HttpReply page = served.get("/");
  RawClient client(served.port);
  client.send("HEAD / HTTP/1.1\r\nHost: " + served.host + "\r\nConnection: close\r\n\r\n");
  const HttpReply head = read_reply(client, false);
  CHECK(head.status == 200);
  CHECK(head.header("content-length") == std::to_string(page.body.size()));
  CHECK(client.rest().empty());
}

TEST_CASE("one connection serves several requests", "[studio][server]") {
  Served served;
  RawClient client(served.port);
  for (int i = 0; i < 3; ++i) {
    client.send("GET / HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n");
    CHECK(read_reply(client).status == 200);
  }
}

TEST_CASE("other methods and bodies are refused", "[studio][server]") {
  Served served;
  const std::string lines = "Host: " + served.host + "\r\n";
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "BREW"}) {
    const HttpReply reply = served.raw(std::string(method) + " / HTTP/1.1\r\n" + lines + "\r\n");
    INFO(method);
    CHECK(reply.status == 405);
    CHECK(reply.header("allow") == "GET, HEAD");
  }
  CHECK(served.raw("POST / HTTP/1.1\r\n" + lines + "Content-Length: 4\r\n\r\nbody").status == 405);
  CHECK(served.raw("GET / HTTP/1.1\r\n" + lines + "Content-Length: 4\r\n\r\nbody").status == 413);
  CHECK(served.raw("GET / HTTP/1.1\r\n" + lines + "Content-Length: 99999999999\r\n\r\n").status ==
        413);
  CHECK(served
            .raw("GET / HTTP/1.1\r\n" + lines +
                 "Transfer-Encoding: chunked\r\n\r\n4\r\nbody\r\n0\r\n\r\n")
            .status == 413);
  CHECK(served.raw("GET / HTTP/1.1\r\n" + lines + "X: " + std::string(1u << 20, 'x') + "\r\n\r\n")
            .status == 431);
  for (const std::string& nonsense :
       Texts{std::string("nonsense\r\n\r\n"), std::string("GET /\r\n\r\n"),
             std::string("GET / HTTP/9.9\r\n\r\n"),
             std::string("\x16\x03\x01\x02\x00\x01\x00\x01", 8),
             "GET / HTTP/1.1\r\n" + lines + "Bad Name: x\r\n\r\n",
             "GET / HTTP/1.1\r\n" + lines + "Content-Length: -1\r\n\r\n"}) {
    const int status = served.raw(nonsense).status;
    CHECK((status == 400 || status == 413));
  }
  CHECK(served.get("/").status == 200);
}

TEST_CASE("a client that takes too long for a request is dropped", "[studio][server]") {
  ServerOptions options;
  options.limits.request_seconds = 0.2;
  Served served(options);
  RawClient silent(served.port), slow(served.port);
  slow.send("GET / HTTP/1.1\r\nHost: ");
  CHECK(silent.rest().empty());
  CHECK(slow.rest().empty());
}

TEST_CASE("silent connections keep no client out", "[studio][server]") {
  ServerOptions options;
  options.limits.connections = 4;
  Served served(options);
  const std::string request = "GET / HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n";
  std::vector<RawClient> silent;
  for (int i = 0; i < 4; ++i) silent.emplace_back(served.port);
  // The one that has been silent for the longest time is closed, the others stay.
  RawClient fifth(served.port);
  fifth.send(request);
  CHECK(read_reply(fifth).status == 200);
  CHECK(silent[0].rest().empty());
  for (int i = 1; i < 4; ++i) {
    silent[i].send(request);
    CHECK(read_reply(silent[i]).status == 200);
  }
  // Those that sent a request start again: now it is the fifth's turn.
  RawClient sixth(served.port);
  sixth.send(request);
  CHECK(read_reply(sixth).status == 200);
  CHECK(fifth.rest().empty());
}

TEST_CASE("an open page stays, whatever many connections come", "[studio][server]") {
  ServerOptions options;
  options.limits.connections = 4;
  Served served(options);
  SocketClient page(served.port, served.operator_token);
  served.inbox.wait_joined(1);
  std::vector<RawClient> silent;
  for (int i = 0; i < 12; ++i) silent.emplace_back(served.port);
  CHECK(served.get("/").status == 200);
  served.server().send(1, "still there");
  CHECK(page.receive(1)->payload == "still there");
}

TEST_CASE("one address has its share of the connections", "[studio][server]") {
  ServerOptions options;
  options.limits.of_one_address = 2;
  Served served(options);
  const std::string request = "GET / HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n";
  RawClient other(served.port, "127.0.0.3");
  std::vector<RawClient> greedy;
  for (int i = 0; i < 3; ++i) greedy.emplace_back(served.port, "127.0.0.2");
  // Its own first one goes, though another's is older.
  CHECK(greedy[0].rest().empty());
  other.send(request);
  CHECK(read_reply(other).status == 200);
  for (int i = 1; i < 3; ++i) {
    greedy[i].send(request);
    CHECK(read_reply(greedy[i]).status == 200);
  }
}

TEST_CASE("a client that reads slowly keeps no other out", "[studio][server]") {
  ServerOptions options;
  options.limits.connections = 2;
  Served served(options);
  const std::string script = script_of(served.get("/").body);
  const std::string request = "GET " + script + " HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n";
  const std::size_t size = served.get(script).body.size();
  REQUIRE(size > 100'000);
  // 64 MB of answers are more than the system's own buffers take, and it reads none of them.
  RawClient slow(served.port);
  std::string many;
  for (std::size_t asked = 0; asked < (64u << 20); asked += size) many += request;
  slow.send(many);
  for (int i = 0; i < 4; ++i) CHECK(served.get("/").status == 200);
}

TEST_CASE("an address that cannot be listened at is reported", "[studio][server]") {
  ServerOptions options;
  options.host = "no.such.name";
  CHECK_THAT(Server::listen(options).error().text(), Contains("'no.such.name' is not an address"));
  options.host = "192.0.2.1";  // reserved for documentation: no machine has it
  CHECK_THAT(Server::listen(options).error().text(), Contains("cannot listen at 192.0.2.1:0"));
  Served served;
  options = {};
  options.port = served.port;
  CHECK_THAT(Server::listen(options).error().text(), Contains("choose another port"));
}
