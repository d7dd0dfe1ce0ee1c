// Edits and other engines during a run; comparing; recording; figures; cameras.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>

#include "../support/temporary_folder.h"
#include "cogrsim/physics/frame_memory.h"
#include "cogrsim/recording/recording.h"
#include "cogrsim/signals/signal.h"
#include "cogrsim/simulation/simulation.h"
#include "history.h"
#include "run_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::test;

namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// Pose of a body in the newest frame that client 1 was sent, once it is of that step.
std::vector<float> pose_at(Page& page, double step, const std::string& body) {
  ReadFrame frame;
  Json scene;
  REQUIRE(page.outbox().wait([&] {
    const Bytes bytes = page.outbox().last_frame(1);
    scene = page.outbox().last(1, "scene");
    if (!bytes || scene.is_null()) return false;
    frame = read_frame(*bytes);
    return frame.step == step && frame.scene == page.status().at("scene") &&
           frame.scene == scene.at("scene");
  }));
  for (std::size_t b = 0; b < scene.at("bodies").size(); ++b) {
    if (scene.at("bodies")[b].at("name") != body) continue;
    return {frame.poses.begin() + static_cast<std::ptrdiff_t>(7 * b),
            frame.poses.begin() + static_cast<std::ptrdiff_t>(7 * b + 7)};
  }
  FAIL("there is no body " << body);
  return {};
}

/// Whether the run shows that scene.
bool takes(Page& page, const Scene& scene) {
  std::promise<bool> promise;
  page.run().show(scene, [&](const auto& taken) { promise.set_value(taken.has_value()); });
  return promise.get_future().get();
}

}  // namespace

TEST_CASE("an edit moves its elements and leaves the others running", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  page.get("step", {{"count", 100}});
  page.hash_after(100);
  const auto rod = pose_at(page, 100, "swing.rod");
  const auto ball = pose_at(page, 100, "ball");
  page.show(replaced(small_scene(), "xyz=\"0.1 0 0.3\"", "xyz=\"0.1 0.7 0.9\""), 2);
  CHECK(page.status("paused").at("step_count") == 100);
  const auto moved = pose_at(page, 100, "ball");
  CHECK(moved[1] == Approx(0.7));
  CHECK(moved[2] == Approx(0.9));
  CHECK(ball[2] < 0.3f);
  const auto rod_now = pose_at(page, 100, "swing.rod");
  // The state goes through text with all its digits; an engine may keep other coordinates.
  for (std::size_t k = 0; k < 7; ++k) CHECK(rod_now[k] == Approx(rod[k]).margin(1e-6));
  // The edit survives going back to the start.
  page.get("stop");
  page.hash_after(0);
  CHECK(pose_at(page, 0, "ball")[1] == Approx(0.7));
}

TEST_CASE("an edit of comments does not affect the run", "[studio][run]") {
  const auto run = [](bool edited) {
    Page page;
    page.join(1);
    page.show(small_scene());
    page.get("step", {{"count", 300}});  // the ball touches the plate
    page.hash_after(300);
    if (edited) page.show(replaced(small_scene(), "  <sphere", "  <!-- a ball -->\n  <sphere"), 2);
    page.get("step", {{"count", 100}});
    const std::string hash = page.hash_after(400);
    if (edited)
      CHECK(page.outbox().wait([&] {
        const Json scene = page.outbox().last(1, "scene");
        return !scene.is_null() && scene.at("version") == 2;
      }));
    return hash;
  };
  CHECK(run(true) == run(false));
}

TEST_CASE("the backend is switched in place", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  page.get("step", {{"count", 100}});
  page.hash_after(100);
  const auto rod = pose_at(page, 100, "swing.rod");
  const auto ball = pose_at(page, 100, "ball");
  const std::string before = page.status().at("backend");
  const std::string other = before == "bullet" ? "cogrsim" : "bullet";
  CHECK(page.get("backend", {{"name", other}}).at("notes").is_array());
  REQUIRE(page.outbox().wait([&] { return page.status().at("backend") == other; }));
  CHECK(page.status().at("time").get<double>() == Approx(0.1));
  for (std::size_t k = 0; k < 7; ++k) {
    // Poses are computed from joint coordinates again: equal to rounding in single precision.
    CHECK(pose_at(page, 100, "swing.rod")[k] == Approx(rod[k]).margin(1e-5));
    CHECK(pose_at(page, 100, "ball")[k] == Approx(ball[k]).margin(1e-5));
  }
  page.get("step", {{"count", 5}});
  page.hash_after(105);
}

TEST_CASE("what an engine lacks is left out once that is chosen", "[studio][run]") {
  // Bullet has no spring on a ball joint.
  const std::string scene = R"(<scene name="lamp" version="1">
  <physics backend="cogrsim" step="1 ms"/>
  <sphere name="lamp" radius="5 cm" xyz="0 0 1" mass="1 kg"/>
  <ball name="neck" child="lamp" xyz="0 0 1.2" stiffness="3"/>
</scene>)";
  const Json all = {{{"feature", "joint.stiffness.ball"}, {"of", "joint"}, {"count", 1}}};
  Page page;
  page.join(1);
  page.show(scene);
  page.get("step", {{"count", 10}});
  const std::string before = page.hash_after(10);

  const Json lacking = page.get("lacking", {{"name", "bullet"}});
  CHECK(lacking.at("name") == "bullet");
  CHECK(lacking.at("left_out") == all);
  CHECK(lacking.at("needed").empty());
  CHECK(page.get("lacking", {{"name", ""}}).at("left_out").empty());
  CHECK_THAT(page.error("lacking", {{"name", "nosuch"}}), Catch::Contains("nosuch"));
  CHECK_THAT(page.error("lacking", {{"name", "../evil"}}), Catch::Contains("'name'"));

  // Refused without a choice, with a code that says why, and the run goes on as it was.
  const Answer refused = page.ask("backend", {{"name", "bullet"}});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == "CG0801");
  CHECK_THAT(page.error("backend", {{"name", "bullet"}, {"without", {"wings"}}}),
             Catch::Contains("wings"));
  CHECK(page.status().at("backend") == "cogrsim");
  CHECK(page.hash_after(10) == before);

  page.get("backend", {{"name", "bullet"}, {"without", {"lacking"}}});
  REQUIRE(page.outbox().wait([&] { return page.status().at("backend") == "bullet"; }));
  CHECK(page.status().at("provenance").at("left_out") == all);
  CHECK(page.status().at("time").get<double>() == Approx(0.01));
  page.get("step", {{"count", 5}});
  page.hash_after(15);

  // The choice holds for every engine, and each leaves out what it lacks and nothing else.
  page.get("backend", {{"name", "cogrsim"}});
  REQUIRE(page.outbox().wait([&] { return page.status().at("backend") == "cogrsim"; }));
  CHECK(page.status().at("provenance").at("left_out").empty());
  page.get("compare", {{"backend", "bullet"}, {"step", nullptr}});
  REQUIRE(page.outbox().wait([&] { return !page.status().at("compare").is_null(); }));
  CHECK(page.status().at("compare").at("left_out") == all);
  page.get("compare-off");

  // Until everything is asked for again.
  page.get("backend", {{"name", "cogrsim"}, {"without", Json::array()}});
  CHECK_FALSE(page.ask("backend", {{"name", "bullet"}}));
  CHECK_FALSE(page.ask("compare", {{"backend", "bullet"}, {"step", nullptr}}));
  page.get("compare", {{"backend", "bullet"}, {"step", nullptr}, {"without", {"lacking"}}});
}

TEST_CASE("a scene that its engine refuses runs once another one takes it", "[studio][run]") {
  const std::string scene = R"(<scene name="lamp" version="1">
  <physics backend="bullet" step="1 ms"/>
  <sphere name="lamp" radius="5 cm" xyz="0 0 1" mass="1 kg"/>
  <ball name="neck" child="lamp" xyz="0 0 1.2" stiffness="3"/>
</scene>)";
  Page page;
  page.join(1);
  CHECK_THAT(page.refused(scene), Catch::Contains("joint.stiffness.ball") || Catch::Contains("spring"));
  CHECK_FALSE(page.ask("play"));
  CHECK(page.get("lacking", {{"name", ""}}).at("name") == "bullet");
  SECTION("another engine") { page.get("backend", {{"name", "cogrsim"}}); }
  SECTION("the same one, without what it lacks") {
    CHECK_FALSE(page.ask("backend", {{"name", "bullet"}}));
    page.get("backend", {{"name", "bullet"}, {"without", {"lacking"}}});
  }
  page.get("step", {{"count", 3}});
  page.hash_after(3);
}

TEST_CASE("what an engine has but cannot build is not for leaving out", "[studio][run]") {
  const std::string scene = R"(<scene name="roll" version="1">
  <physics backend="cogrsim" step="1 ms"/>
  <plane name="floor"/>
  <capsule name="roll" radius="5 cm" length="20 cm" xyz="0 0 1" mass="1 kg"/>
</scene>)";
  Page page;
  page.join(1);
  Scene shown = scene_of(scene);
  auto model = std::make_shared<SceneModel>(*shown.model);
  model->physics.engine_options["simbody"]["contact"] = std::string("simbody");
  shown.model = model;
  REQUIRE(takes(page, shown));
  const Answer refused = page.ask("backend", {{"name", "simbody"}});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == "CG0802");
  CHECK_THAT(refused.error().message, Catch::Contains("no geometry for 'roll'"));
  const Json lacking = page.get("lacking", {{"name", "simbody"}});
  CHECK(lacking.at("left_out").empty());
  CHECK(lacking.at("needed").empty());
}

TEST_CASE("an edit that the second engine of a comparison refuses", "[studio][run]") {
  const auto scene = [](const std::string& spring) {
    return R"(<scene name="lamp" version="1">
  <physics backend="cogrsim" step="1 ms"/>
  <sphere name="lamp" radius="5 cm" xyz="0 0 1" mass="1 kg"/>
  <ball name="neck" child="lamp" xyz="0 0 1.2" )" +
           spring + "/>\n</scene>";
  };
  Page page;
  page.join(1);
  page.show(scene(""));
  page.get("compare", {{"backend", "bullet"}, {"step", nullptr}});
  CHECK_THAT(page.refused(scene("stiffness=\"3\"")), Catch::Contains("bullet"));
  CHECK_FALSE(page.ask("backend", {{"name", "cogrsim"}}));
  const Json lacking = page.get("lacking", {{"name", "cogrsim"}});
  CHECK(lacking.at("name") == "bullet");
  CHECK(lacking.at("left_out").size() == 1);
  // A comparison is of what runs, which has no spring.
  CHECK(page.get("lacking", {{"name", "bullet"}, {"beside", true}}).at("left_out").empty());
  page.get("backend", {{"name", "cogrsim"}, {"without", {"lacking"}}});
  REQUIRE(page.outbox().wait([&] { return page.status().at("compare").at("left_out").size() == 1; }));
  CHECK(page.status().at("backend") == "cogrsim");
  CHECK(page.status().at("provenance").at("left_out").empty());
}

TEST_CASE("a choice stays where the run has taken it and cannot play on", "[studio][run]") {
  const std::string text = R"(<scene name="lamp" version="1">
  <physics backend="cogrsim" step="1 ms"/>
  <sphere name="lamp" radius="5 cm" xyz="0 0 1" mass="1 kg"/>
  <ball name="neck" child="lamp" xyz="0 0 1.2" stiffness="3"/>
</scene>)";
  Page page;
  page.join(1);
  page.show(text);
  page.get("step", {{"count", 1}});
  page.get("play");
  Scene shown = scene_of(text, 2);
  shown.only_shown = true;
  auto edited = std::make_shared<SceneModel>(*shown.model);
  edited->bodies.at(0).mass = 2.0;
  shown.model = edited;
  REQUIRE(takes(page, shown));
  const Json beside = {{"backend", "bullet"}, {"step", nullptr}, {"without", {"lacking"}}};
  CHECK_THAT(page.error("compare", beside), Catch::Contains("does not run"));
  CHECK(page.status("stopped").at("compare").at("left_out").size() == 1);
  // The same two runs once more.
  page.get("stop");
}

TEST_CASE("two engines run side by side until they diverge", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(replaced(small_scene(), "radius=\"5 cm\" xyz", "radius=\"5 cm\" restitution=\"0.8\" xyz"));
  CHECK_THAT(page.error("divergence"), Catch::Contains("nothing is compared"));
  page.get("compare", {{"backend", "bullet"}, {"step", nullptr}});
  page.get("step", {{"count", 2000}});
  page.hash_after(2000);
  const Json status = page.status();
  CHECK(status.at("compare").at("labels") == Json({"cogrsim", "bullet"}));
  // A ball that bounces: no two engines agree on that to a centimetre for two seconds.
  REQUIRE(status.at("compare").at("first_over").is_number());
  const Json divergence = page.get("divergence");
  CHECK(divergence.at("first").at("time") == status.at("compare").at("first_over"));
  CHECK(divergence.at("time").size() == divergence.at("worst").size());
  double worst = 0.0;
  for (const Json& v : divergence.at("worst")) worst = std::max(worst, v.get<double>());
  CHECK(worst > 0.0);
  const ReadFrame frame = read_frame(*page.outbox().last_frame(1));
  CHECK(frame.ghost);
  CHECK(frame.ghost_poses.size() == frame.poses.size());
  CHECK(page.get("series", {{"signals", {"ball.z"}}, {"run", "ghost"}}).at("series").size() == 1);
  // The first of the two runs as it would alone.
  const std::string compared = status.at("state_hash");
  page.get("compare-off");
  page.get("stop");
  page.hash_after(0);
  page.get("step", {{"count", 2000}});
  CHECK(page.hash_after(2000) == compared);
}

TEST_CASE("one engine is compared at two steps at common times", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  CHECK_THAT(page.error("compare", {{"step", 0.00123456789}}), Catch::Contains("in common"));
  page.get("compare", {{"step", 0.0004}});
  page.get("step", {{"count", 10}});
  // 1 ms and 0.4 ms meet every 2 ms: ten such times.
  const Json status = page.status("paused");
  REQUIRE(page.outbox().wait([&] { return page.status().at("time").get<double>() > 0.0199; }));
  CHECK(page.status().at("time").get<double>() == Approx(0.020));
  CHECK(page.status().at("frames") == 11);
  CHECK_THAT(page.error("dt", {{"value", 0.002}}), Catch::Contains("steps of their own"));
}

TEST_CASE("a recording is made beside the scene and can be viewed", "[studio][run]") {
  const cogrsim::test::TemporaryFolder folder;
  RunOptions options;
  options.folder = folder.path;
  const std::string file = folder / "small.mcap";
  {
    Page page(options);
    page.join(1);
    page.show(small_scene());
    for (const char* bad : {"../x", "/tmp/x", "a/b", ".hidden"}) {
      CHECK_THAT(page.error("record", {{"on", true}, {"file", bad}}), Catch::Contains("bare"));
    }
    std::ofstream(folder / "notes.mcap") << "shopping list";
    CHECK_THAT(page.error("record", {{"on", true}, {"file", "notes"}}),
               Catch::Contains("no recording"));
    page.get("step", {{"count", 20}});
    page.hash_after(20);
    CHECK(page.get("record", {{"on", true}}).at("file") == "small.mcap");
    page.get("step", {{"count", 80}});
    page.hash_after(100);
    CHECK(page.get("record", {{"on", false}}).at("file") == "small.mcap");
    CHECK(page.get("record", {{"on", true}}).at("file") == "small-2.mcap");
  }
  const auto recording = Recording::open(file);
  REQUIRE(recording);
  CHECK((*recording)->info().complete);
  CHECK((*recording)->frame_count() >= 80);
  FakeOutbox outbox;
  auto run = Run::of_recording(file, std::make_shared<PluginLoader>(), outbox);
  REQUIRE(run);
  Page page(std::move(*run), outbox);
  page.join(1);
  CHECK(page.status("recording").at("last").get<double>() == Approx(0.1));
  CHECK_THAT(page.error("play"), Catch::Contains("only be viewed"));
  CHECK(page.get("seek", {{"time", 0.0555}}).at("time").get<double>() == Approx(0.055));
  CHECK(page.get("step-back").at("time").get<double>() == Approx(0.054));
  REQUIRE(outbox.wait([&] {
    const Bytes bytes = outbox.last_frame(1);
    return bytes && read_frame(*bytes).step == 54;
  }));
  const Json curve = page.get("series", {{"signals", {"time"}}});
  CHECK(curve.at("time").size() == (*recording)->frame_count());
  CHECK(curve.at("series")[0].at("low") == curve.at("time"));
}

TEST_CASE("a series has the signal's values of the frames", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  page.get("step", {{"count", 200}});
  page.hash_after(200);
  auto bare =
      Simulation::create(scene_of(small_scene()).model, {}, std::make_shared<PluginLoader>());
  REQUIRE(bare);
  const SignalScope scope{*(*bare)->model(), {}, {}, {}};
  const auto height = Signal::parse(scope, "ball.z"),
             angle = Signal::parse(scope, "swing.pivot.position");
  REQUIRE(height);
  REQUIRE(angle);
  const Json curves = page.get("series", {{"signals", {"ball.z", "swing.pivot.position"}}});
  REQUIRE(curves.at("time").size() == 201);
  CHECK(curves.at("series")[0].at("unit") == "m");
  CHECK(curves.at("series")[1].at("unit") == "rad");
  double lowest = 1e9;
  for (std::size_t i = 0; i <= 200; ++i) {
    const FramePtr frame = (*bare)->frame();
    CHECK(curves.at("time")[i] == frame->time);
    CHECK(curves.at("series")[0].at("low")[i] == height->evaluate(*frame));
    CHECK(curves.at("series")[1].at("high")[i] == angle->evaluate(*frame));
    lowest = std::min(lowest, height->evaluate(*frame));
    (*bare)->step();
  }
  const Json thin = page.get("series", {{"signals", {"ball.z"}}, {"points", 10}});
  REQUIRE(thin.at("time").size() == 10);
  double found = 1e9;
  for (const Json& v : thin.at("series")[0].at("low")) found = std::min(found, v.get<double>());
  CHECK(found == lowest);
  const Json part = page.get("series", {{"signals", {"ball.z"}}, {"from", 0.0995}, {"to", 0.1505}});
  CHECK(part.at("time").size() == 51);
  CHECK_THAT(page.error("series", {{"signals", {"unknown.z"}}}), Catch::Contains("unknown"));
  std::size_t named = 0;
  const Json list = page.get("signals");
  for (const Json& signal : list.at("signals")) {
    if (signal.at("name") == "ball.z" && signal.at("owner") == "ball") ++named;
    if (signal.at("name") == "swing.pivot.position") ++named;
  }
  CHECK(named == 2);
}

TEST_CASE("history lets go of every other old frame where memory ends", "[studio][run]") {
  const auto frame_at = [](double time) {
    auto frame = std::make_shared<Frame>();
    frame->time = time;
    frame->state.poses.resize(100);
    return Instant{frame, nullptr, 1};
  };
  const std::size_t each = bytes_of(*frame_at(0.0).frame) + sizeof(Instant);
  History history(100 * each);
  std::size_t gone = 0;
  for (int i = 0; i < 1000; ++i) gone += history.add(frame_at(i)).size();
  const Frames::Extent extent = history.extent();
  CHECK(extent.first == 0.0);
  CHECK(extent.last == 999.0);
  CHECK(extent.count <= 100);
  CHECK(extent.count >= 50);
  CHECK(extent.count + gone == 1000);
  // The newest are all there; older ones are at least sometimes.
  for (int i = 980; i < 1000; ++i) CHECK(history.at(i).time() == i);
  CHECK(history.at(500.0).time() <= 500.0);
  CHECK(history.before(999.0).time() == 998.0);
  CHECK(!history.before(0.0));
  CHECK(history.after(990.0, 100).size() == 9);
  CHECK(history.after(-1.0, 5).size() == 5);
}

TEST_CASE("cameras that no client views are not rendered", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(replaced(small_scene(), "</scene>",
                     R"(  <camera name="eye" on="plate" xyz="-2 0 0.5"/>
  <view name="side" xyz="0 -3 1" rpy="0 0 90 deg"/>
</scene>)"));
  CHECK_THAT(page.error("cameras", {{"show", {{{"name", "nose"}}}}}), Catch::Contains("nose"));
  page.get("step", {{"count", 10}});
  CHECK(page.outbox().picture_count() == 0);
  page.get("cameras", {{"show",
                        {{{"name", "eye"}, {"kind", "segmentation"}, {"width", 64}},
                         {{"name", "side"}, {"kind", "color"}, {"width", 80}}}}});
  REQUIRE(page.outbox().wait([&] { return page.outbox().picture_count() >= 2; }));
  const std::string picture = *page.outbox().last_picture();
  CHECK(picture[0] == 2);
  // Unchanged pictures are not drawn again; nor any for a page that acknowledges none.
  page.get("step", {{"count", 1}});
  REQUIRE(page.outbox().wait([&] { return page.outbox().picture_count() >= 4; }));
  page.outbox().want_pictures(false);
  page.get("step", {{"count", 5}});
  page.outbox().want_pictures(true);
  REQUIRE(page.outbox().wait([&] { return page.outbox().picture_count() >= 6; }));
  page.get("cameras", {{"show", Json::array()}});
  const std::size_t then = page.outbox().picture_count();
  for (int i = 0; i < 5; ++i) page.get("step", {{"count", 3}});
  // `view` comes through the same thread, later than anything it could still have drawn.
  page.get("view", {{"width", 32}, {"height", 24}});
  REQUIRE(page.outbox().wait([&] { return page.outbox().picture_count() > then; }));
  CHECK(page.outbox().picture_count() <= then + 2);  // one may have been in progress
}
