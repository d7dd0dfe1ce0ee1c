// Unsaved changes are offered again, whatever ended the studio.
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include <sys/stat.h>

#include "document_support.h"
#include "journal.h"
#include "studio_process.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

std::string scene(const std::string& name) {
  return "<scene name=\"" + name + "\">\n  <plane name=\"floor\"/>\n</scene>\n";
}
const std::string kOne = scene("one"), kTwo = scene("two"), kThree = scene("three");

const char* const kScene = "t.scene.xml";
const char* const kJournal = ".t.scene.xml.journal";

Answer type(RequestHandler& requests, const std::string& text) {
  return requests.ask("set-text", {{"version", requests.version}, {"text", text}});
}

Json offer(RequestHandler& requests) { return requests.page.wait("unsaved", 1)["offer"]; }

Json restore(RequestHandler& requests) { return requests.get("restore", {{"number", offer(requests)["number"]}}); }

/// A document whose journals lie in this folder when they cannot lie beside the scene.
struct Room {
  Room() { folder.write(kScene, kOne); }
  std::unique_ptr<RequestHandler> open(const std::string& name = kScene) const {
    auto requests = std::make_unique<RequestHandler>(folder.path(name), false, folder.path("state"));
    requests->document->joined(1, Role::operator_);
    requests->page.wait("unsaved", 1);
    return requests;
  }
  std::vector<std::string> elsewhere() const {
    std::vector<std::string> out;
    std::error_code error;
    for (const auto& entry :
         fs::directory_iterator(folder.folder() / "state/cogrsim/studio/unsaved", error)) {
      out.push_back(entry.path().string());
    }
    return out;
  }
  Folder folder;
};

}  // namespace

TEST_CASE("an edit that was answered is on the disk until it is saved", "[document][journal]") {
  const Room room;
  const auto requests = room.open();
  CHECK_FALSE(room.folder.has(kJournal));
  REQUIRE(type(*requests, kTwo));
  CHECK_THAT(room.folder.read(kJournal), Contains(kTwo));
  struct stat about {};
  REQUIRE(::stat(room.folder.path(kJournal).c_str(), &about) == 0);
  CHECK((about.st_mode & 0777) == 0600);
  const int floor = requests->id("plane", "floor");
  requests->edit({{"op", "rename"}, {"element", floor}, {"name", "ground"}});
  CHECK_THAT(room.folder.read(kJournal), Contains("ground"));
  const auto gone = [&] { return !room.folder.has(kJournal); };
  SECTION("saved") {
    requests->get("save");
    CHECK(gone());
    requests->get("undo");
    CHECK_THAT(room.folder.read(kJournal), Contains(kTwo));
  }
  SECTION("reverted") {
    requests->get("revert");
    CHECK(gone());
  }
  SECTION("undone") {
    requests->get("undo");
    requests->get("undo");
    CHECK(gone());
  }
  SECTION("saved under another name") {
    requests->get("save", {{"file", "other.scene.xml"}});
    CHECK(gone());
    REQUIRE(type(*requests, kThree));
    CHECK(gone());
    CHECK_THAT(room.folder.read(".other.scene.xml.journal"), Contains(kThree));
  }
  CHECK(room.elsewhere().empty());
}

TEST_CASE("unsaved changes are offered at the next start", "[document][journal]") {
  const Room room;
  const std::string name = GENERATE(std::string(kScene), std::string("new.scene.xml"));
  std::string before;
  {
    const auto requests = room.open(name);
    CHECK(offer(*requests).is_null());
    before = requests->text();
    REQUIRE(type(*requests, kTwo));
    CHECK_THAT(requests->document->finish(), Contains("." + name + ".journal"));
  }
  SECTION("restored") {
    {
      const auto requests = room.open(name);
      REQUIRE(requests->document->notes().size() == 1);
      CHECK_THAT(requests->document->notes()[0], Contains("'" + name + "' has changes of 20"));
      CHECK(requests->text() == before);
      CHECK(offer(*requests)["changed"] == false);
      CHECK(requests->get("unsaved", {{"number", offer(*requests)["number"]}})["text"] == kTwo);
      restore(*requests);
      CHECK(requests->text() == kTwo);
      CHECK(offer(*requests).is_null());
      requests->get("undo");
      CHECK(requests->text() == before);
      requests->get("redo");
    }
    // It is still not saved.
    const auto requests = room.open(name);
    restore(*requests);
    requests->get("save");
    CHECK(room.folder.read(name) == kTwo);
    CHECK_FALSE(room.folder.has("." + name + ".journal"));
    CHECK(requests->document->finish() == "");
  }
  SECTION("discarded") {
    const auto requests = room.open(name);
    const Json number = offer(*requests)["number"];
    requests->get("discard", {{"number", number}});
    CHECK(offer(*requests).is_null());
    CHECK_FALSE(room.folder.has("." + name + ".journal"));
    const Answer late = requests->ask("restore", {{"number", number}});
    REQUIRE_FALSE(late);
    CHECK(late.error().code == "stale");
  }
  SECTION("the file was changed meanwhile") {
    room.folder.write(name, kThree);
    const auto requests = room.open(name);
    CHECK(offer(*requests)["changed"] == true);
    restore(*requests);
    requests->get("save");
    CHECK(room.folder.read(name) == kTwo);
    CHECK(room.folder.read(name + "~") == kThree);
  }
  SECTION("the file has it already") {
    room.folder.write(name, kTwo);
    CHECK(offer(*room.open(name)).is_null());
  }
  SECTION("no decision") {
    {
      const auto requests = room.open(name);
      REQUIRE(type(*requests, kThree));
    }
    const auto requests = room.open(name);
    CHECK(offer(*requests)["more"] == 1);
    restore(*requests);
    CHECK(requests->text() == kThree);
    restore(*requests);
    CHECK(requests->text() == kTwo);
  }
}

TEST_CASE("where the journal cannot lie beside the scene it lies elsewhere",
          "[document][journal]") {
  Room room;
  std::string name = kScene;
  const std::string secret = "no journal\n";
  room.folder.write("secret", secret);
  SECTION("a folder") { fs::create_directory(room.folder.path(kJournal)); }
  SECTION("a link") { fs::create_symlink("secret", room.folder.path(kJournal)); }
  SECTION("a link to nowhere") { fs::create_symlink("nowhere", room.folder.path(kJournal)); }
  SECTION("a pipe") { REQUIRE(::mkfifo(room.folder.path(kJournal).c_str(), 0600) == 0); }
  SECTION("another file") { room.folder.write(kJournal, secret); }
  const auto kind = fs::symlink_status(room.folder.path(kJournal)).type();
  {
    const auto requests = room.open();
    CHECK(offer(*requests).is_null());
    CHECK(requests->document->notes().size() == 1);
    REQUIRE(type(*requests, kTwo));
    REQUIRE(room.elsewhere().size() == 1);
    CHECK_THAT(requests->document->finish(), Contains(room.elsewhere()[0]));
  }
  CHECK(fs::symlink_status(room.folder.path(kJournal)).type() == kind);
  CHECK(room.folder.read("secret") == secret);
  CHECK_FALSE(room.folder.has("nowhere"));
  const auto requests = room.open();
  restore(*requests);
  CHECK(requests->text() == kTwo);
  requests->get("save");
  CHECK(room.elsewhere().empty());
}

TEST_CASE("a journal that can lie nowhere is missed aloud", "[document][journal]") {
  Room room;
  fs::create_directory(room.folder.path(kJournal));
  room.folder.write("state", "no folder\n");
  const auto requests = room.open();
  REQUIRE(type(*requests, kTwo));
  CHECK_THAT(requests->page.wait("unsaved", 2)["not_kept"].get<std::string>(), Contains(kJournal));
  CHECK_THAT(requests->document->finish(), Contains("is lost"));
}

TEST_CASE("the journal of a link lies beside the link", "[document][journal]") {
  Room room;
  room.folder.write("far/real.scene.xml", kOne);
  fs::create_symlink("far/real.scene.xml", room.folder.path("link.scene.xml"));
  {
    const auto requests = room.open("link.scene.xml");
    REQUIRE(type(*requests, kTwo));
  }
  CHECK(room.folder.has(".link.scene.xml.journal"));
  CHECK(std::distance(fs::directory_iterator(room.folder.path("far")), fs::directory_iterator()) ==
        1);
  const auto requests = room.open("link.scene.xml");
  restore(*requests);
  requests->get("save");
  CHECK(room.folder.read("far/real.scene.xml") == kTwo);
}

TEST_CASE("two studios of one scene keep what each has", "[document][journal]") {
  const Room room;
  {
    const auto first = room.open(), second = room.open();
    REQUIRE(type(*first, kTwo));
    REQUIRE(type(*second, kThree));
    CHECK_THAT(room.folder.read(kJournal), Contains(kTwo));
    // A studio that starts while the first one runs is offered nothing of it.
    CHECK(offer(*room.open()).is_null());
    REQUIRE(type(*first, scene("two again")));
  }
  const auto requests = room.open();
  std::vector<std::string> found;
  while (!offer(*requests).is_null()) {
    restore(*requests);
    found.push_back(requests->text());
  }
  std::sort(found.begin(), found.end());
  CHECK(found == std::vector<std::string>{kThree, scene("two again")});
}

TEST_CASE("a journal that a studio did not write is neither believed nor touched",
          "[document][journal]") {
  const Room room;
  const auto head = [](const std::string& texts) {
    return R"({"cogrsim-journal":1,"texts":)" + texts + "}\n";
  };
  const std::string one = R"([{"base":"","bytes":3,"time":0}])";
  std::string many = "[";
  for (int i = 0; i < 1000; ++i) many += R"({"base":"","bytes":0,"time":0},)";
  many.back() = ']';
  const std::string bytes =
      GENERATE_COPY(std::string(), std::string("\n"), std::string("{}"), std::string("<scene/>\n"),
                    std::string(100'000, '{'), head("7"), head("[7]"), head("[{}]"), head(one),
                    head(one) + "ab", head(one) + "abcd",
                    head(one) +
                        "a\xFF"
                        "c",
                    head(many), head(R"([{"base":"","bytes":-3,"time":0}])") + "abc",
                    head(R"([{"base":"","bytes":3.0,"time":0}])") + "abc",
                    head(R"([{"base":"","bytes":18446744073709551615,"time":0}])") + "abc",
                    head(R"([{"base":7,"bytes":3,"time":0}])") + "abc",
                    head(R"([{"base":"","bytes":3,"time":"now"}])") + "abc",
                    R"({"cogrsim-journal":2,"texts":)" + one + "}\nabc");
  room.folder.write(kJournal, bytes);
  const auto requests = room.open();
  CHECK(offer(*requests).is_null());
  REQUIRE(requests->document->notes().size() == 1);
  CHECK_THAT(requests->document->notes()[0], Contains(kJournal));
  REQUIRE(type(*requests, kTwo));
  CHECK(room.folder.read(kJournal) == bytes);
  CHECK(room.elsewhere().size() == 1);
  requests->get("save");
  CHECK(room.folder.read(kJournal) == bytes);
}

TEST_CASE("a journal beyond all bounds is not read", "[document][journal]") {
  const Room room;
  room.folder.write(kJournal, "{\"cogrsim-journal\":1");
  fs::resize_file(room.folder.path(kJournal), std::uintmax_t{1} << 40);
  const auto requests = room.open();
  REQUIRE(requests->document->notes().size() == 1);
  CHECK_THAT(requests->document->notes()[0], Contains("too large"));
}

TEST_CASE("a studio that is killed at any time loses no edit that was answered",
          "[studio][program][journal]") {
  // COGRSIM_KILLS=200 for more.
  const char* const wanted = std::getenv("COGRSIM_KILLS");
  const int kills = wanted ? std::atoi(wanted) : 20;
  REQUIRE(kills > 0);
  const Folder folder;
  folder.write(kScene, scene("k0"));
  const std::map<std::string, std::string> home = {{"XDG_RUNTIME_DIR", folder.path("run")},
                                                   {"XDG_STATE_HOME", folder.path("state")}};
  std::random_device device;
  const auto seed = device();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  using Clock = std::chrono::steady_clock;
  double oldest = 0.0;  // [s] age of what was lost
  int sent = 0, answered = 0;
  for (int i = 0; i < kills; ++i) {
    StudioProcess studio({folder.path(kScene)}, home);
    SocketClient socket(studio.port(), studio.token());
    REQUIRE(socket.status() == 101);
    // The next text message for which this holds; nullopt: the studio is gone.
    const auto next = [&](const auto& holds) -> std::optional<Json> {
      while (auto message = socket.receive()) {
        if (message->opcode == 9) socket.send(message->payload, 10);
        if (message->opcode == 2) socket.send("a");
        if (message->opcode != 1) continue;
        Json text = Json::parse(message->payload);
        if (holds(text)) return text;
      }
      return std::nullopt;
    };
    const auto topic = [](const char* name) {
      return [name](const Json& text) { return text.value("topic", "") == name; };
    };
    const auto answer = [](int id) {
      return [id](const Json& text) { return text.value("id", -1) == id; };
    };
    int id = 0;
    REQUIRE(socket.send(Json{{"id", ++id}, {"do", "hello"}}.dump()));
    const auto unsaved = next(topic("unsaved"));
    REQUIRE(unsaved);
    Json version = (*unsaved)["version"];
    int found = 0;
    if ((*unsaved)["offer"].is_object()) {
      const Json number = (*unsaved)["offer"]["number"];
      REQUIRE(socket.send(Json{{"id", ++id}, {"do", "restore"}, {"number", number}}.dump()));
      version = (*next(answer(id)))["version"];
      const Json document = *next([&](const Json& text) {
        return text.value("topic", "") == "document" && text["version"] == version;
      });
      const std::string text = document["text"];
      found = std::stoi(text.substr(text.find("\"k") + 2));
    }
    INFO("kill " << i << ": answered " << answered << ", sent " << sent << ", found " << found);
    REQUIRE(found >= answered);
    REQUIRE(found <= sent);
    sent = answered = found;
    // One thread types, the other kills.
    std::thread killer([&, after = std::uniform_int_distribution<int>(0, 400'000)(random)] {
      std::this_thread::sleep_for(std::chrono::microseconds(after));
      studio.end(true);
    });
    Clock::time_point on_its_way;
    for (;;) {
      ++sent;
      on_its_way = Clock::now();
      const std::string name = "k" + std::to_string(sent);
      Json request = {{"id", ++id}, {"version", version}};
      if (sent % 3 == 0) {
        request["do"] = "edit";
        request["label"] = "name";
        request["ops"] = {{{"op", "set"}, {"element", 0}, {"attribute", "name"}, {"value", name}}};
      } else {
        request["do"] = "set-text";
        request["text"] = scene(name);
      }
      if (!socket.send(request.dump())) break;
      const auto done = next(answer(id));
      if (!done) break;
      if ((*done)["ok"] != true) {
        killer.join();
        FAIL(*done);
      }
      version = (*done)["version"];
      answered = sent;
    }
    killer.join();
    oldest = std::max(oldest, std::chrono::duration<double>(Clock::now() - on_its_way).count());
  }
  if (wanted) {
    WARN(kills << " kills: of " << answered
               << " answered edits none is lost; the oldest that was not answered was "
               << 1e3 * oldest << " ms old");
  }
  // Only the scene, its journal, and files that a killed studio was writing are left.
  int remains = 0;
  for (const auto& entry : fs::directory_iterator(folder.folder())) {
    const std::string name = entry.path().filename().string();
    if (name != kScene && name != kJournal && name != "run" && name != "state") ++remains;
  }
  CHECK(remains <= 1);
}
