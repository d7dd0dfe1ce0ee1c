// The start page's requests: what they list, make and open, and what they keep away from.
#include <catch2/catch.hpp>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "../support/temporary_folder.h"
#include "protocol.h"
#include "start.h"

namespace fs = std::filesystem;
using namespace cogrsim;
using namespace cogrsim::studio;

namespace {

/// A folder to start in, with a library and examples beside it.
struct Place {
  Place() {
    put("work/there.scene.xml", "<scene name=\"there\" version=\"1\"/>");
    put("work/models/cart.urdf",
        R"(<robot name="cart"><link name="base"><visual><geometry><box size="1 1 1"/></geometry>
           </visual></link></robot>)");
    put("secret.scene.xml", "<scene name=\"secret\" version=\"1\"/>");
    put("library/robots/car/demo.scene.xml",
        "<scene name=\"c\" version=\"1\"><import href=\"car.scene.xml\"/></scene>");
    put("examples/010_first/first.scene.xml", "<scene name=\"first\" version=\"1\"/>");
  }
  void put(const std::string& name, const std::string& text) const {
    fs::create_directories((root / name).parent_path());
    std::ofstream(root / name) << text;
  }
  std::string text(const std::string& name) const {
    std::ostringstream out;
    out << std::ifstream(root / name).rdbuf();
    return out.str();
  }
  Start start() {
    return Start({root / "work", root / "library", root / "examples", (root / "state").string()},
                 [this](const std::string& file) -> Result<> {
                   opened = file;
                   return {};
                 });
  }
  Answer ask(Start& start, const char* what, Json fields) const {
    const ProtocolRequest* known = find_request(what);
    REQUIRE(known != nullptr);
    REQUIRE(check_fields(*known, fields));
    std::optional<Answer> answer;
    start.handle({1, Role::operator_, what, std::move(fields)},
                 [&](Answer given) { answer = std::move(given); });
    REQUIRE(answer);
    if (*answer) CHECK(check_answer(what, **answer));
    return std::move(*answer);
  }
  test::TemporaryFolder folder;
  const fs::path& root = folder.path;
  std::string opened;
};

}  // namespace

TEST_CASE("the start page lists what can be opened, in its folder only", "[studio][start]") {
  Place place;
  Start start = place.start();
  const Answer here = place.ask(start, "start", Json::object());
  REQUIRE(here);
  CHECK(here->at("files") == Json::parse(R"([{"name": "models", "kind": "folder"},
                                             {"name": "there.scene.xml", "kind": "scene"}])"));
  CHECK(here->at("examples") == Json{"010_first"});
  CHECK(here->at("robots") == Json{"car"});
  const Answer inside = place.ask(start, "start", {{"folder", "models"}});
  REQUIRE(inside);
  CHECK(inside->at("files")[0]["name"] == "models/cart.urdf");
  for (const char* outside : {"..", "/", "models/../.."}) {
    INFO(outside);
    CHECK_FALSE(place.ask(start, "start", {{"folder", outside}}));
  }
}

TEST_CASE("the start page opens, makes, copies and imports", "[studio][start]") {
  Place place;
  Start start = place.start();
  const auto open = [&](const char* what, const char* name, const char* text = "") {
    return place.ask(start, "start-open", {{"what", what}, {"name", name}, {"text", text}});
  };
  SECTION("a file, once") {
    REQUIRE(open("open", "there.scene.xml"));
    CHECK(fs::equivalent(place.opened, place.root / "work/there.scene.xml"));
    CHECK_FALSE(open("open", "there.scene.xml"));
  }
  SECTION("a new scene, and never over another") {
    CHECK_FALSE(open("new", "there"));
    CHECK_FALSE(open("new", "../out"));
    REQUIRE(open("new", "fresh"));
    CHECK(fs::path(place.opened).filename() == "fresh.scene.xml");
  }
  SECTION("a copy of an example") {
    REQUIRE(open("example", "010_first"));
    CHECK(fs::equivalent(place.opened, place.root / "work/010_first/first.scene.xml"));
  }
  SECTION("a scene with a robot") {
    REQUIRE(open("robot", "car"));
    CHECK(place.text("work/car.scene.xml").find("robots/car/car.scene.xml") != std::string::npos);
  }
  SECTION("an import of a file that is there, and of one that is dropped") {
    REQUIRE(open("import", "models/cart.urdf"));
    CHECK(place.text("work/cart.scene.xml").find("<scene") != std::string::npos);
  }
  SECTION("a dropped model that is no model, and files outside") {
    const Answer broken = open("import", "broken.urdf", "<robot><link/></robot>");
    REQUIRE_FALSE(broken);
    CHECK_FALSE(broken.error().message.empty());
    CHECK_FALSE(open("open", "../secret.scene.xml"));
    CHECK_FALSE(open("import", "../secret.scene.xml"));
    CHECK_FALSE(open("robot", "../robots/car"));
    CHECK(place.opened.empty());
  }
}

TEST_CASE("recent files are kept, newest first and once, as long as they are there",
          "[studio][start]") {
  Place place;
  const std::string state = (place.root / "state").string();
  const std::string a = (place.root / "secret.scene.xml").string();
  const std::string b = (place.root / "work/there.scene.xml").string();
  CHECK(recent_files(state).empty());
  for (const std::string& file : {a, b, a}) remember_file(state, file);
  CHECK(recent_files(state) == std::vector<std::string>{a, b});
  fs::remove(a);
  CHECK(recent_files(state) == std::vector<std::string>{b});
  CHECK(recent_files("").empty());
}
