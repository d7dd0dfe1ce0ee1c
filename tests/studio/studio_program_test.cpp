// The whole program: what pages see of runs, pictures, figures and textures, and restarts.
#include <catch2/catch.hpp>

#include <cstring>

#include "../support/engines.h"
#include "document_support.h"
#include "studio_process.h"

using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;
using Catch::Matchers::Contains;

namespace {

std::string scene(const std::string& duration, const std::string& more = {}) {
  return R"(<scene name="room" version="1">
  <physics step="1 ms")" +
         (duration.empty() ? "" : " duration=\"" + duration + "\"") + R"(/>
  <material name="tiles" texture="tiles.png" texture-size="1 m"/>
  <box name="plate" static="true" size="2 2 0.1" xyz="0 0 -0.05" material="tiles"/>
  <sphere name="ball" radius="5 cm" xyz="0.1 0 0.3" linear-velocity="0.5 0.1 0"/>
  <plot name="fall" title="How it falls"><series y="ball.z" label="height"/></plot>
)" + more +
         "</scene>\n";
}

// A PNG file of one pixel.
const std::string kPixel(
    "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x02\0\0\0\x90wS\xde\0\0\0\x0cIDATx\x9c"
    "c\xf8\xcf\xc0\0\0\x03\x01\x01\0\xc9\xfe\x92\xef\0\0\0\0IEND\xae"
    "B`\x82",
    69);

/// A folder with a scene in it, and with the files of this user.
struct Room {
  explicit Room(const std::string& text) {
    folder.write("room.scene.xml", text);
    folder.write("tiles.png", kPixel);
  }
  std::string file() const { return folder.path("room.scene.xml"); }
  std::map<std::string, std::string> home() const {
    return {{"XDG_RUNTIME_DIR", folder.path("run")}};
  }
  Folder folder;
};

std::string hash_of(const Room& room, const std::string& backend, const std::string& duration) {
  const Json result = Json::parse(run_cogrsim(
      {"run", room.file(), "--backend", backend, "--duration", duration, "--json", "-"}));
  CHECK(result["status"] == "completed");
  return result["state_hash"];
}

Json stands(LivePage& page, std::uint64_t steps) {
  return page.wait("status", [&](const Json& status) {
    return status["state"] != "playing" && status["step_count"] == steps &&
           status["state_hash"] != "";
  });
}

/// Width and height of a picture, after its head was checked.
struct Size {
  std::uint32_t width = 0, height = 0;
};
Size size_of(const std::string& picture, const std::string& name) {
  REQUIRE(picture.size() > 20 + name.size() + 100);
  CHECK(picture[0] == 2);
  CHECK(picture[1] == 0);
  std::uint16_t length = 0;
  Size size;
  std::memcpy(&length, &picture[2], 2);
  std::memcpy(&size.width, &picture[4], 4);
  std::memcpy(&size.height, &picture[8], 4);
  CHECK(picture.substr(20, length) == name);
  CHECK(picture.substr(20u + length, 3) == "\xff\xd8\xff");
  return size;
}

}  // namespace

TEST_CASE("the scene's duration ends playing where it ends a headless run", "[studio][program]") {
  const std::string backend = GENERATE(cogrsim::test::engines());
  const Room room(scene("0.2 s"));
  const StudioProcess studio({room.file(), "--backend", backend}, room.home());
  LivePage page(studio);
  const std::string start = stands(page, 0)["state_hash"];
  page.get("speed", {{"factor", nullptr}});
  page.get("play");
  const Json over = stands(page, 200);
  CHECK(over["state"] == "paused");
  CHECK(over["ending"] == "the scene's duration, 0.2 s, is over");
  CHECK(over["time"].get<double>() == Approx(0.2));
  CHECK(over["state_hash"] == hash_of(room, backend, "0.2 s"));
  // The run can continue: by steps, and by playing.
  page.get("step", {{"count", 100}});
  const Json later = stands(page, 300);
  CHECK(later["ending"] == "");
  CHECK(later["state_hash"] == hash_of(room, backend, "0.3 s"));
  page.get("play");
  page.wait("status", [](const Json& s) { return s["time"].get<double>() > 0.5; });
  page.get("pause");
  page.wait("status", [](const Json& s) { return s["state"] == "paused"; });
  // Steps alone lead past it; back at the start it ends playing again.
  page.get("stop");
  CHECK(stands(page, 0)["state_hash"] == start);
  page.get("step", {{"count", 300}});
  CHECK(stands(page, 300)["state_hash"] == later["state_hash"]);
  page.get("restart");
  CHECK(stands(page, 200)["state_hash"] == over["state_hash"]);
}

TEST_CASE("a scene without a duration plays on", "[studio][program]") {
  const Room room(scene(""));
  const StudioProcess studio({room.file()}, room.home());
  LivePage page(studio);
  stands(page, 0);
  page.get("speed", {{"factor", nullptr}});
  page.get("play");
  // Longer than a run from the command line lasts by itself.
  page.wait("status", [](const Json& s) { return s["time"].get<double>() > 10.5; });
  CHECK(page.wait("status", [](const Json&) { return true; })["state"] == "playing");
}

TEST_CASE("an edit that lengthens the scene takes back that it is over", "[studio][program]") {
  const Room room(scene("50 ms"));
  const StudioProcess studio({room.file()}, room.home());
  LivePage page(studio);
  stands(page, 0);
  page.get("play");
  CHECK_THAT(stands(page, 50)["ending"].get<std::string>(), Contains("0.05 s"));
  const Json document = page.wait("document", [](const Json& d) { return d["good"] == true; });
  page.get("set-text", {{"version", document["version"]}, {"text", scene("80 ms")}});
  page.wait("status", [](const Json& s) { return s["ending"] == ""; });
  page.get("play");
  CHECK(stands(page, 80)["ending"] == "the scene's duration, 0.08 s, is over");
}

TEST_CASE("pages without 3D are sent pictures of scenes and recordings", "[studio][program]") {
  const Room room(scene("0.1 s"));
  std::string shown = room.file();
  const bool recording = GENERATE(false, true);
  if (recording) {
    shown = room.folder.path("room.mcap");
    run_cogrsim({"run", room.file(), "--record", shown, "--json", "-"});
  }
  const StudioProcess studio({shown}, room.home());
  LivePage page(studio);
  CHECK(page.hello["kind"] == (recording ? "recording" : "scene"));
  page.wait("status", [](const Json& s) { return s["frames"].get<int>() > 0; });
  page.get("view", {{"width", 64}, {"height", 48}});
  const std::string whole = page.picture();
  CHECK(size_of(whole, "").width == 64);
  CHECK(size_of(whole, "").height == 48);
  page.get("view", {{"width", 64}, {"height", 48}});
  CHECK(page.picture() == whole);
  // From 3 m above the plate, looking down: the camera looks along its x axis.
  const double half = std::sqrt(0.5);
  const Json above{0.0, 0.0, 3.0, half, 0.0, half, 0.0};
  page.get("view", {{"width", 80}, {"height", 80}, {"pose", above}, {"fov", 1.0}});
  const std::string top = page.picture();
  CHECK(size_of(top, "").width == 80);
  CHECK(top.substr(20) != whole.substr(20));
  for (const Json& bad :
       {Json{{"width", 5}}, Json{{"height", 1e6}}, Json{{"fov", 4}}, Json{{"pose", {1, 2, 3}}},
        Json{{"pose", {0, 0, 0, 0, 0, 0, 0}}}, Json{{"width", "wide"}}}) {
    const Json refused = page.ask("view", bad);
    INFO(bad << ": " << refused);
    CHECK(refused["ok"] == false);
    CHECK_THAT(refused["error"]["message"].get<std::string>(),
               Contains("'" + bad.begin().key() + "'"));
  }
  LivePage viewer(studio.port(), studio.token());
  viewer.wait("status", [](const Json& s) { return s["viewers"] == 2; });
  viewer.get("view", {{"width", 32}, {"height", 32}});
  CHECK(size_of(viewer.picture(), "").width == 32);
}

TEST_CASE("textures and figures are those of the scene", "[studio][program]") {
  const Room room(scene("0.2 s"));
  const StudioProcess studio({room.file()}, room.home());
  LivePage page(studio);
  const Json model = page.wait("scene", [](const Json&) { return true; });
  CHECK(model["bodies"][0]["shapes"][0]["texture"] == "0");
  const auto asset = [&](const std::string& number) {
    RawClient client(studio.port());
    client.send("GET " + page.hello["assets"].get<std::string>() + number +
                " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(studio.port()) + "\r\n\r\n");
    return read_reply(client);
  };
  const HttpReply tiles = asset("0");
  CHECK(tiles.status == 200);
  CHECK(tiles.header("content-type") == "image/png");
  CHECK(tiles.body == kPixel);
  CHECK(asset("1").status == 404);
  CHECK(asset("../0").status == 404);
  CHECK(asset("0x0").status == 404);
  CHECK(asset("tiles.png").status == 404);

  page.get("step", {{"count", 100}});
  stands(page, 100);
  const Json plots = page.get("plots")["plots"];
  REQUIRE(plots.size() == 1);
  CHECK(plots[0]["name"] == "fall");
  CHECK(plots[0]["title"] == "How it falls");
  const Json figure = page.get("figure", {{"plot", "fall"}});
  CHECK(figure["title"] == "How it falls");
  REQUIRE(figure["series"].size() == 1);
  CHECK(figure["series"][0]["label"] == "height");
  CHECK(figure["y"]["unit"] == "m");
  const Json curve = page.get("series", {{"signals", {"ball.z"}}});
  const Json &x = figure["series"][0]["x"], &y = figure["series"][0]["y"];
  REQUIRE(x.size() == y.size());
  REQUIRE(x.size() > 10);
  // The figure agrees with the frames, and with free fall up to dt g t / 2.
  std::size_t found = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = x[i];
    CHECK(y[i].get<double>() == Approx(0.3 - 0.5 * 9.81 * t * t).margin(0.5e-3 * 9.81 * t + 1e-6));
    for (std::size_t k = 0; k < curve["time"].size(); ++k) {
      if (curve["time"][k] != x[i]) continue;
      CHECK(curve["series"][0]["low"][k] == y[i]);
      ++found;
    }
  }
  CHECK(found == x.size());
  CHECK(page.ask("figure", {{"plot", "no"}})["ok"] == false);
}

TEST_CASE("a run that diverges ends, and the text mends it", "[studio][program]") {
  std::string diverging = scene("");
  diverging.replace(diverging.find("0.5 0.1 0"), 9, "9e7 0 0");
  const Room room(diverging);
  const StudioProcess studio({room.file()}, room.home());
  LivePage page(studio);
  stands(page, 0);
  page.get("play");
  const Json ended = page.wait("status", [](const Json& s) { return s["state"] == "ended"; });
  CHECK_THAT(ended["ending"].get<std::string>(), Contains("'ball'"));
  CHECK(ended["state_hash"] != "");
  CHECK_THAT(page.ask("play")["error"]["message"].get<std::string>(), Contains("has ended"));
  const Json published = page.wait("messages", [](const Json& m) {
    for (const Json& one : m["messages"]) {
      if (one["severity"] == "error") return true;
    }
    return false;
  });
  CHECK(published["messages"].size() >= 1);
  const Json document = page.wait("document", [](const Json&) { return true; });
  page.get("set-text", {{"version", document["version"]}, {"text", scene("")}});
  page.wait("status", [](const Json& s) { return s["state"] == "stopped"; });
  page.get("step", {{"count", 20}});
  CHECK(stands(page, 20)["ending"] == "");
}

TEST_CASE("a supervisor pauses the run and play resumes it", "[studio][program]") {
  const Room room(scene("0.2 s", R"(<supervisor name="boss" plugin="studio_test_pauser">)"
                                 R"(<set at="0.1 s"/></supervisor>)"));
  const StudioProcess studio({room.file(), "--plugin-path", STUDIO_TEST_PLUGINS}, room.home());
  LivePage page(studio);
  stands(page, 0);
  page.get("speed", {{"factor", nullptr}});
  page.get("play");
  const Json paused = page.wait("status", [](const Json& s) { return s["state"] == "paused"; });
  // It is shown the state after a step and pauses at the next boundary.
  CHECK(paused["time"].get<double>() == Approx(0.1).margin(0.0021));
  CHECK(paused["ending"] == "");
  CHECK(paused["state_hash"] != "");
  page.get("play");
  CHECK(stands(page, 200)["ending"] == "the scene's duration, 0.2 s, is over");
}

TEST_CASE("a page that is still open finds the studio after a restart", "[studio][program]") {
  const Room room(scene("0.2 s"));
  std::string token;
  const unsigned short port = own_port();
  const std::vector<std::string> arguments = {room.file(), "--port", std::to_string(port)};
  {
    StudioProcess first(arguments, room.home());
    token = first.token();
    LivePage page(first);
    // However it ended.
    CHECK(first.end(GENERATE(false, true)) <= 0);
  }
  const auto comes_in = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), more.begin(), more.end());
    const StudioProcess studio(all, room.home());
    SocketClient socket(port, token);
    return socket.status() == 101;
  };
  CHECK(comes_in({}));
  // Where the page may run programs, the previous token is valid only if that is asked for.
  CHECK_FALSE(comes_in({"--allow-build"}));
  CHECK(comes_in({"--allow-build", "--keep-token"}));
  CHECK_FALSE(comes_in({"--host", "0.0.0.0"}));
  CHECK(comes_in({}));
  CHECK_FALSE(comes_in({"--new-token"}));
  CHECK_FALSE(comes_in({}));
}
