// Who is let in by HTTP, and what they are given: over real sockets.
#include <filesystem>
#include <fstream>

#include <sys/stat.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include "../support/temporary_folder.h"
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

}  // namespace

TEST_CASE("the printed address sets a cookie and leads to the page", "[studio][server]") {
  Served served;
  const std::string line = "\r\nHost: " + served.host + "\r\n\r\n";
  for (const std::string& token : Texts{served.operator_token, served.viewer_token}) {
    const HttpReply reply = served.raw("GET /?token=" + token + " HTTP/1.1" + line);
    CHECK(reply.status == 303);
    CHECK(reply.header("location") == "/");
    CHECK(reply.header("set-cookie") == "cogrsim_studio_" + std::to_string(served.port) + "=" +
                                            token + "; HttpOnly; SameSite=Strict; Path=/");
  }
  CHECK(served.operator_token != served.viewer_token);
  CHECK(served.get("/").status == 200);
  // Other cookies of the same machine are in the way of nothing.
  CHECK(served
            .raw("GET / HTTP/1.1\r\nHost: " + served.host + "\r\nCookie: a=b; " +
                 served.viewer_cookie + "; _xsrf=2\r\n\r\n")
            .status == 200);
}

TEST_CASE("the address for the browser is good for one visit", "[studio][server]") {
  Served served;
  const std::string address = served.server().launch_address();
  const std::string target = address.substr(address.find("/?token="));
  const std::string line = " HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n";
  CHECK(served.raw("HEAD " + target + line).status == 403);
  const HttpReply reply = served.raw("GET " + target + line);
  CHECK(reply.status == 303);
  CHECK_THAT(reply.header("set-cookie"), Contains("=" + served.operator_token + ";"));
  CHECK(served.raw("GET " + target + line).status == 403);
  CHECK(served.raw("GET /?token= HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n").status == 403);
}

TEST_CASE("without the right token everything is refused with what to do", "[studio][server]") {
  Served served;
  const std::string host = "Host: " + served.host + "\r\n";
  const std::string name = "cogrsim_studio_" + std::to_string(served.port) + "=";
  std::string almost = served.operator_token;
  almost.back() = almost.back() == '0' ? '1' : '0';
  for (const std::string& cookie :
       Texts{std::string(), "Cookie: " + name + almost + "\r\n", "Cookie: " + name + "\r\n",
             "Cookie: " + name + served.operator_token + "0\r\n",
             "Cookie: other=" + served.operator_token + "\r\n",
             "Cookie: cogrsim_studio_1=" + served.operator_token + "\r\n"}) {
    for (const char* path : {"/", "/index.html", "/asset/0", "/socket", "/nothing"}) {
      const HttpReply reply =
          served.raw("GET " + std::string(path) + " HTTP/1.1\r\n" + host + cookie + "\r\n");
      INFO(cookie << path);
      CHECK(reply.status == 403);
      CHECK_THAT(reply.body, Contains("terminal"));
      CHECK(reply.header("content-type") == "text/plain; charset=utf-8");
      CHECK(reply.header("set-cookie").empty());
    }
    CHECK(SocketClient(served.port, cookie.empty() ? "a=b" : cookie.substr(8, cookie.size() - 10))
              .status() == 403);
  }
  for (const std::string& query : Texts{"token=", "token=" + almost, "a=1&token=x",
                                        "token=" + served.operator_token + "%00"}) {
    const HttpReply reply = served.raw("GET /?" + query + " HTTP/1.1\r\n" + host + "\r\n");
    CHECK(reply.status == 403);
    CHECK(reply.header("set-cookie").empty());
  }
}

TEST_CASE("other names of this machine are refused", "[studio][server]") {
  Served served;
  const std::string port = std::to_string(served.port);
  const auto ask = [&](const std::string& hosts, const std::string& more = {}) {
    return served
        .raw("GET / HTTP/1.1\r\n" + hosts + "Cookie: " + served.operator_cookie + "\r\n" + more +
             "\r\n")
        .status;
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
  // A name is refused even with the token itself.
  CHECK(served
            .raw("GET /?token=" + served.operator_token +
                 " HTTP/1.1\r\nHost: evil.example:" + port + "\r\n\r\n")
            .status == 403);
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
    CHECK(SocketClient(served.port, served.operator_cookie, bad).status() == 403);
  }
  CHECK(served.get("/", "Origin: http://" + served.host + "\r\n").status == 200);
  CHECK(SocketClient(served.port, served.operator_cookie).status() == 101);
  // Browsers always say it when they open a WebSocket.
  CHECK(served
            .get("/socket",
                 "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n")
            .status == 403);
  CHECK(served.get("/socket").status == 426);
}

TEST_CASE("no address leads into the file system", "[studio][server]") {
  Served served;
  const std::string etc = "etc/passwd";
  for (const std::string& target : Texts{
           "/../" + etc, "/../../../../../../" + etc, "/%2e%2e/%2e%2e/" + etc, "/..%2f..%2f" + etc,
           "/..\\..\\" + etc, "//" + etc, "/" + etc, "/./index.html", "/asset/../../" + etc,
           "/asset//" + etc, "/asset/-1", "/asset/", "/asset/0x0", "/asset/0/..",
           std::string("/asset/99999999999999999999999"), std::string("/index.html%00.png"),
           std::string("/asset/+0"), std::string("/asset/%30")}) {
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
  const HttpReply reply = served.get("/asset/0");
  CHECK(reply.status == 200);
  CHECK(reply.header("content-type") == "image/png");
  CHECK(reply.body == "\x89PNG\r\n\x1a\n and what follows");
  CHECK(served.get("/asset/0", "If-None-Match: " + reply.header("etag") + "\r\n").status == 304);
  CHECK(served.get("/asset/1").status == 404);
  // A page of our own address must not come of a texture.
  std::ofstream(png) << "<script>alert(1)</script>";
  CHECK(served.get("/asset/0").header("content-type") == "application/octet-stream");
  served.stop();

  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  for (const std::string& other : Texts{folder.path, folder / "pipe", folder / "gone"}) {
    Served again;
    again.inbox.asset_file = other;
    CHECK(again.get("/asset/0").status == 404);
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

TEST_CASE("the page comes compressed or not and is kept", "[studio][server]") {
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
  // What the page loads first is there, and for ever the same.
  const auto script = plain.body.find("src=\"");
  REQUIRE(script != std::string::npos);
  std::string name = plain.body.substr(script + 5, plain.body.find('"', script + 5) - script - 5);
  name = name.substr(name.find_first_not_of("./"));
  const HttpReply code = served.get("/" + name);
  INFO(name);
  CHECK(code.status == 200);
  CHECK(code.header("content-type") == "text/javascript; charset=utf-8");
  CHECK(code.header("cache-control") == "private, max-age=31536000, immutable");
}

TEST_CASE("HEAD tells the length without the body", "[studio][server]") {
  Served served;
  const HttpReply page = served.get("/");
  RawClient client(served.port);
  client.send("HEAD / HTTP/1.1\r\nHost: " + served.host + "\r\nCookie: " + served.operator_cookie +
              "\r\nConnection: close\r\n\r\n");
  const HttpReply head = read_reply(client, false);
  CHECK(head.status == 200);
  CHECK(head.header("content-length") == std::to_string(page.body.size()));
  CHECK(client.rest().empty());
}

TEST_CASE("one connection serves several requests", "[studio][server]") {
  Served served;
  RawClient client(served.port);
  for (int i = 0; i < 3; ++i) {
    client.send("GET / HTTP/1.1\r\nHost: " + served.host + "\r\nCookie: " + served.operator_cookie +
                "\r\n\r\n");
    CHECK(read_reply(client).status == 200);
  }
}

TEST_CASE("other methods and bodies are refused", "[studio][server]") {
  Served served;
  const std::string lines =
      "Host: " + served.host + "\r\nCookie: " + served.operator_cookie + "\r\n";
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

TEST_CASE("who takes too long for a request is let go", "[studio][server]") {
  ServerOptions options;
  options.limits.request_seconds = 0.2;
  Served served(options);
  RawClient silent(served.port), slow(served.port);
  slow.send("GET / HTTP/1.1\r\nHost: ");
  CHECK(silent.rest().empty());
  CHECK(slow.rest().empty());
}

TEST_CASE("there are no more connections than allowed", "[studio][server]") {
  ServerOptions options;
  options.limits.connections = 4;
  Served served(options);
  std::vector<RawClient> waiting;
  for (int i = 0; i < 4; ++i) waiting.emplace_back(served.port);
  // One by one the server takes them in, and the fifth goes at once.
  CHECK(RawClient(served.port).rest().empty());
  const std::string request = "GET / HTTP/1.1\r\nHost: " + served.host +
                              "\r\nCookie: " + served.operator_cookie +
                              "\r\nConnection: close\r\n\r\n";
  waiting[0].send(request);
  CHECK_THAT(waiting[0].rest(), Contains("200 OK"));
  waiting[0].close();
  // There is room again as soon as the server has seen it.
  std::string answer;
  for (int i = 0; i < 1000 && answer.empty(); ++i) {
    RawClient next(served.port);
    if (next.send(request)) answer = next.rest();
  }
  CHECK_THAT(answer, Contains("200 OK"));
}

TEST_CASE("an address that cannot be listened at is told", "[studio][server]") {
  ServerOptions options;
  options.host = "no.such.name";
  CHECK_THAT(Server::listen(options).error().text(), Contains("'no.such.name' is no address"));
  options.host = "192.0.2.1";  // reserved for documentation: no machine has it
  CHECK_THAT(Server::listen(options).error().text(), Contains("cannot listen at 192.0.2.1:0"));
  Served served;
  options = {};
  options.port = served.port;
  CHECK_THAT(Server::listen(options).error().text(), Contains("choose another port"));
}
