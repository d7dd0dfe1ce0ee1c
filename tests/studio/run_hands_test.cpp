// What a person does in a run: motors, pulling bodies; and the same run made again from what was recorded.
#include <catch2/catch.hpp>

#include "../support/engines.h"
#include "../support/temporary_folder.h"
#include "cogrsim/simulation/simulation.h"
#include "run/inputs.h"
#include "run_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::test;

namespace {

/// A crate that lies there and a wheel with a motor.
const char* const kScene = R"(<scene name="bench" version="1">
  <physics step="1 ms"/>
  <box name="plate" static="true" size="4 4 0.1" xyz="0 0 -0.05"/>
  <box name="crate" size="20 20 20 cm" mass="2 kg" xyz="0 0 0.1"/>
  <assembly name="mill" xyz="1.5 0 1">
    <cylinder name="wheel" radius="10 cm" length="4 cm" mass="1 kg"/>
    <hinge name="axle" child="wheel" axis="0 0 1"/>
    <motor name="drive" joint="axle" mode="velocity" max-torque="1 N*m" max-speed="20 rad/s" max-target="5 rad/s"/>
  </assembly>
</scene>
)";

/// Pulls the crate, turns the wheel: 400 steps.
void play_about(Page& page) {
  page.get("step", {{"count", 20}});
  const Json set = page.get("motor", {{"motor", "mill.drive"}, {"target", 3.5}});
  CHECK(set.at("target") == 3.5);
  page.get("step", {{"count", 60}});
  const Json spring = page.get(
      "grab", {{"body", "crate"}, {"point", {0.05, 0.0, 0.1}}, {"target", {0.2, 0.1, 0.6}}});
  CHECK(spring.at("stiffness") > 0.0);
  page.get("step", {{"count", 120}});
  page.get("grab-move", {{"target", {-0.3, 0.2, 0.5}}});
  page.get("motor", {{"motor", "mill.drive"}, {"target", -2.0}});
  page.get("step", {{"count", 120}});
  page.get("release");
  page.get("step", {{"count", 80}});
}

std::string hash_with(const std::string& backend, std::vector<cli::Input> inputs) {
  SimulationOptions options;
  options.backend = backend;
  auto made =
      Simulation::create(scene_of(kScene).model, options, std::make_shared<PluginLoader>());
  REQUIRE(made);
  cli::InputPlayer player(std::move(inputs));
  for (std::uint64_t i = 0; i < 400; ++i) {
    player.give(i, [&](const cli::Input& input) { (*made)->send(input.command); });
    (*made)->step();
  }
  CHECK(player.left() == 0);
  char text[17];
  std::snprintf(text, sizeof text, "%016llx",
                static_cast<unsigned long long>(state_hash((*made)->frame()->state)));
  return text;
}

}  // namespace

TEST_CASE("what was done by hand comes again to the last bit", "[studio][run][hands]") {
  const std::string backend = GENERATE(cogrsim::test::engines());
  CAPTURE(backend);
  const cogrsim::test::TemporaryFolder folder;
  RunOptions options;
  options.backend = backend;
  options.folder = folder.path.string();
  Page page(options);
  page.join(1);
  page.show(kScene);
  page.get("record", {{"file", "seen.mcap"}});
  play_about(page);
  const std::string hash = page.hash_after(400);
  page.get("record", {{"on", false}});
  // 120 + 120 steps of pulling and two targets
  CHECK(page.status().at("inputs") == 242);

  SECTION("from the recording") {
    const auto inputs = cli::read_inputs(folder / "seen.mcap");
    REQUIRE(inputs);
    CHECK(inputs->backend == backend);
    CHECK(inputs->dt == 0.001);
    CHECK(inputs->lost.empty());
    CHECK(inputs->list.size() == 242);
    CHECK(hash_with(backend, inputs->list) == hash);
    CHECK(hash_with(backend, {}) != hash);
    // and as the text that `cogrsim info --extract` writes
    const auto again = cli::inputs_from(cli::to_text(*inputs), "seen.jsonl");
    REQUIRE(again);
    CHECK(hash_with(backend, again->list) == hash);
  }
  SECTION("in the studio, after Stop, too") {
    if (GENERATE(false, true)) page.get("stop");
    // so slowly that it is paused before it is over, on any machine
    page.get("speed", {{"factor", 0.01}});
    CHECK(page.get("repeat").at("inputs") == 242);
    page.status("playing");
    page.get("pause");
    const int done = page.status("paused").at("step_count");
    REQUIRE(done < 400);
    page.get("step", {{"count", 400 - done}});
    CHECK(page.hash_after(400) == hash);
  }
}

TEST_CASE("inputs of controllers are set, limited, and come again", "[studio][run][hands]") {
  const bool own_process = GENERATE(false, true);
  std::string text = kScene;
  text.replace(
      text.find("  </assembly>"), 0,
      std::string("    <controller plugin=\"studio_test_asker\" rate=\"100 Hz\" isolation=\"") +
          (own_process ? "process" : "none") + "\"/>\n");
  const cogrsim::test::TemporaryFolder folder;
  RunOptions options;
  options.folder = folder.path.string();
  Page page(options, std::make_shared<PluginLoader>(std::vector<std::string>{STUDIO_TEST_PLUGINS}));
  page.join(1);
  page.show(text);
  page.get("record", {{"file", "seen.mcap"}});
  const std::string name = page.status().at("controllers").at(0).at("controller");
  const Json shown = page.status().at("controllers").at(0).at("inputs");
  CHECK(shown == Json::parse(R"([{"name":"speed","unit":"rad/s","lower":-2,"upper":4,"value":1},
      {"name":"trim","unit":"","lower":-0.5,"upper":0.5,"value":0}])"));
  const auto set = [&](const char* input, double value) {
    return page.get("input", {{"controller", name}, {"input", input}, {"value", value}})
        .at("value");
  };
  page.get("step", {{"count", 100}});
  CHECK(set("speed", -1.5) == -1.5);
  page.get("step", {{"count", 100}});
  page.hash_after(200);
  CHECK(page.status().at("controllers").at(0).at("inputs").at(0).at("value") == -1.5);
  // beyond its limits: what it takes is answered, and recorded
  CHECK(set("trim", 1e6) == 0.5);
  CHECK(set("speed", 1e6) == 4.0);
  page.get("step", {{"count", 200}});
  const std::string hash = page.hash_after(400);
  CHECK(page.status().at("inputs") == 3);
  page.get("record", {{"on", false}});

  const auto wrong = [&](const char* key, const Json& value) {
    Json fields = {{"controller", name}, {"input", "speed"}, {"value", 1.0}};
    fields[key] = value;
    return page.error("input", fields);
  };
  CHECK_THAT(wrong("controller", "mill.nobody"), Catch::Contains("no controller 'mill.nobody'"));
  CHECK_THAT(wrong("input", "sped"), Catch::Contains("with an input 'sped'"));
  for (const Json& value : {Json("fast"), Json(nullptr), Json(1e30), Json::array({1})})
    CHECK_THAT(wrong("value", value), Catch::Contains("'value'"));

  const auto inputs = cli::read_inputs(folder / "seen.mcap");
  REQUIRE(inputs);
  REQUIRE(inputs->list.size() == 3);
  const auto again = cli::inputs_from(cli::to_text(*inputs), "seen.jsonl");
  REQUIRE(again);
  const auto* last = std::get_if<SetInput>(&again->list[2].command);
  REQUIRE(last);
  CHECK((last->controller == name && last->input == "speed" && last->value == 4.0));
  page.get("speed", {{"factor", 0.01}});
  CHECK(page.get("repeat").at("inputs") == 3);
  page.status("playing");
  page.get("pause");
  const int done = page.status("paused").at("step_count");
  REQUIRE(done < 400);
  page.get("step", {{"count", 400 - done}});
  CHECK(page.hash_after(400) == hash);

  // What is given at a pause has not reached the run that an edit ends.
  CHECK(set("speed", 2.5) == 2.5);
  std::string heavier = text;
  heavier.insert(heavier.find("</scene>"), "  <box name=\"late\" size=\"1 1 1 cm\" xyz=\"9 9 9\"/>\n");
  page.show(heavier);
  page.get("step", {{"count", 1}});
  page.hash_after(401);
  CHECK(page.status().at("controllers").at(0).at("inputs").at(0).at("value") == 2.5);
}

TEST_CASE("a body that is pulled comes to where it is pulled", "[studio][run][hands]") {
  const std::string backend = GENERATE(cogrsim::test::engines());
  const double step = GENERATE(0.001, 0.01);
  CAPTURE(backend, step);
  RunOptions options;
  options.backend = backend;
  options.step = step;
  Page page(options);
  page.join(1);
  page.show(kScene);
  const Json spring =
      page.get("grab", {{"body", "crate"}, {"point", {0.0, 0.0, 0.0}}, {"target", {0.3, 0.2, 0.8}}});
  page.get("step", {{"count", static_cast<int>(3.0 / step)}});
  REQUIRE(page.outbox().wait([&] {
    const Bytes frame = page.outbox().last_frame(1);
    return frame && read_frame(*frame).time > 2.99;
  }));
  const ReadFrame frame = read_frame(*page.outbox().last_frame(1));
  // It hangs m g / k below. Critically damped at 18 rad/s it is there within e^-54 after 3 s; what is left
  // is the poses' single precision, and what an engine adds of its own: damping of bodies, for one.
  const double sag = 2.0 * 9.81 / spring.at("stiffness").get<double>();
  CHECK(frame.poses[7] == Approx(0.3).margin(2e-3));
  CHECK(frame.poses[8] == Approx(0.2).margin(2e-3));
  CHECK(frame.poses[9] == Approx(0.8 - sag).margin(2e-3));
}

TEST_CASE("pulling and motors are refused where they mean nothing", "[studio][run][hands]") {
  Page page;
  page.join(1);
  page.join(2);
  CHECK_THAT(page.error("motor", {{"motor", "m"}, {"target", 1}}), Catch::Contains("no scene"));
  page.show(kScene);
  const Json grab = {{"body", "crate"}, {"point", {0, 0, 0}}, {"target", {0, 0, 1}}};
  const auto with = [&](const char* key, const Json& value) {
    Json out = grab;
    out[key] = value;
    return out;
  };
  CHECK_THAT(page.error("grab", with("body", "nobody")), Catch::Contains("no body 'nobody'"));
  CHECK_THAT(page.error("grab", with("body", "plate")), Catch::Contains("static"));
  CHECK_THAT(page.error("grab", with("point", {0, 0})), Catch::Contains("'point'"));
  CHECK_THAT(page.error("grab", with("target", {0, 0, 1e30})), Catch::Contains("'target[2]'"));
  CHECK_THAT(page.error("grab", with("stiffness", 0.0)), Catch::Contains("'stiffness'"));
  CHECK_THAT(page.error("motor", {{"motor", "mill.drve"}, {"target", 1}}), Catch::Contains("no motor"));
  CHECK_THAT(page.error("grab-move", {{"target", {0, 0, 0}}}), Catch::Contains("nothing is pulled"));
  CHECK_THAT(page.error("repeat"), Catch::Contains("nothing was done"));
  // beyond what the motor takes: what it takes is answered, and recorded
  CHECK(page.get("motor", {{"motor", "mill.drive"}, {"target", 1000}}).at("target") == 5.0);
  // stiffer than the step allows: s <= 1/4 of m / dt^2
  const Json stiff = page.get("grab", with("stiffness", 1e8));
  CHECK(stiff.at("stiffness").get<double>() == Approx(0.25 * 2.0 / 1e-6));
  CHECK_THAT(page.error("grab", grab, 2), Catch::Contains("somebody else"));
  // a page that is gone pulls nothing
  page.leave(1);
  page.join(3);
  CHECK(page.get("grab", grab, 3).at("damping") > 0.0);
  page.get("release", Json::object(), 3);
  page.get("compare", {{"backend", nullptr}}, 3);
  CHECK_THAT(page.error("grab", grab, 3), Catch::Contains("compared"));
}

TEST_CASE("a run that was edited is not made again", "[studio][run][hands]") {
  Page page;
  page.join(1);
  page.show(kScene);
  page.get("step", {{"count", 10}});
  page.get("motor", {{"motor", "mill.drive"}, {"target", 1.0}});
  page.get("step", {{"count", 10}});
  std::string edited = kScene;
  edited.replace(edited.find("2 kg"), 4, "3 kg");
  page.show(edited, 2);
  CHECK_THAT(page.error("repeat"), Catch::Contains("changed at 0.02 s"));
  page.get("stop");
  CHECK_THAT(page.error("repeat"), Catch::Contains("changed at 0.02 s"));
}

TEST_CASE("a run of another scene or engine is not made again", "[studio][run][hands]") {
  Page page;
  page.join(1);
  page.show(kScene);
  page.get("step", {{"count", 10}});
  page.get("motor", {{"motor", "mill.drive"}, {"target", 1.0}});
  page.get("step", {{"count", 10}});
  page.get("stop");
  SECTION("scene") {
    std::string edited = kScene;
    edited.replace(edited.find("2 kg"), 4, "3 kg");
    page.show(edited, 2);
    CHECK_THAT(page.error("repeat"), Catch::Contains("scene was changed"));
  }
  SECTION("engine") {
    const std::string before = page.status().at("backend");
    const std::string other = before == "bullet" ? "cogrsim" : "bullet";
    page.get("backend", {{"name", other}});
    CHECK_THAT(page.error("repeat"), Catch::Contains("the engine is " + other));
    page.get("backend", {{"name", before}});
    CHECK(page.get("repeat").at("inputs") == 1);
  }
  SECTION("without something else") {
    const std::string engine = page.status().at("backend");
    page.get("backend", {{"name", engine}, {"without", {"limits"}}});
    CHECK_THAT(page.error("repeat"), Catch::Contains("left out"));
    page.get("backend", {{"name", engine}, {"without", Json::array()}});
    CHECK(page.get("repeat").at("inputs") == 1);
  }
}

TEST_CASE("a repetition that is stopped early forgets nothing", "[studio][run][hands]") {
  Page page;
  page.join(1);
  page.show(kScene);
  page.get("speed", {{"factor", 0.01}});
  for (const double target : {1.0, 2.0, 3.0}) {
    page.get("step", {{"count", 100}});
    page.get("motor", {{"motor", "mill.drive"}, {"target", target}});
  }
  for (const bool stopped : {false, true, false, true}) {
    CHECK(page.get("repeat").at("inputs") == 3);
    page.get("pause");
    if (stopped) page.get("stop");
  }
}

TEST_CASE("a step length given by hand is not repeated for two runs with their own",
          "[studio][run][hands]") {
  Page page;
  page.join(1);
  page.show(kScene);
  page.get("step", {{"count", 10}});
  page.get("dt", {{"value", 0.0005}});
  page.get("step", {{"count", 10}});
  page.get("compare", {{"backend", nullptr}, {"step", 0.002}});
  CHECK_THAT(page.error("repeat"), Catch::Contains("steps of their own"));
}

TEST_CASE("inputs for a step that is over hold up no others", "[studio][hands]") {
  cli::InputPlayer player(
      {{1, SetMotor{"m", 1.0}}, {5, SetMotor{"m", 5.0}}, {7, SetMotor{"m", 7.0}}});
  std::vector<std::uint64_t> given;
  const auto taken = [&](const cli::Input& input) { given.push_back(input.step); };
  player.give(5, taken);
  CHECK(given == std::vector<std::uint64_t>{5});
  CHECK(player.missed() == 1);
  REQUIRE(player.rest().size() == 1);
  CHECK(player.rest()[0].step == 7);
  CHECK(player.left() == 1);
}

TEST_CASE("frames have joints and efforts for who asks", "[studio][run][hands]") {
  Page page;
  page.join(1);
  page.show(kScene);
  page.get("subscribe", {{"joints", true}});
  page.get("motor", {{"motor", "mill.drive"}, {"target", 2.0}});
  page.get("step", {{"count", 500}});
  REQUIRE(page.outbox().wait([&] {
    const Bytes frame = page.outbox().last_frame(1);
    return frame && read_frame(*frame).time > 0.499 && read_frame(*frame).tail.contains("joints");
  }));
  const Json tail = read_frame(*page.outbox().last_frame(1)).tail;
  REQUIRE(tail.at("joints").size() == 1);
  CHECK(tail.at("joints")[0].at("speed")[0].get<double>() == Approx(2.0).margin(1e-3));
  CHECK(tail.at("joints")[0].at("position")[0].get<double>() > 0.5);
  CHECK(tail.at("efforts").size() == 1);
  const Json scene = page.outbox().last(1, "scene");
  const Json& motor = scene.at("motors")[0];
  CHECK(motor.at("unit") == "rad/s");
  CHECK(motor.at("low") == -20.0);
  CHECK(motor.at("high") == 5.0);
  CHECK(motor.at("max_effort") == 1.0);
}

TEST_CASE("inputs of strangers are refused with their line", "[studio][hands]") {
  const auto error = [](const std::string& text) {
    const auto read = cli::inputs_from(text, "x.jsonl");
    REQUIRE_FALSE(read);
    return read.error().text();
  };
  const std::string head = R"({"inputs":1,"backend":"bullet","dt":0.001,"lost":""})" "\n";
  CHECK_THAT(error(""), Catch::Contains("no inputs"));
  CHECK_THAT(error("PNG\n"), Catch::Contains("x.jsonl:1") && Catch::Contains("no line of inputs"));
  CHECK_THAT(error(R"({"inputs":-1,"backend":"b","dt":1,"lost":""})"), Catch::Contains("their number"));
  CHECK_THAT(error(head), Catch::Contains("end early: 0 of 1"));
  CHECK_THAT(error(head + R"({"step":0.5,"motor":"m","target":1})"), Catch::Contains("x.jsonl:2") && Catch::Contains("whole number"));
  CHECK_THAT(error(head + R"({"step":1,"motor":"m","target":"much"})"), Catch::Contains("'target'"));
  CHECK_THAT(error(head + R"({"step":1,"body":"b","force":[1,2],"point":[0,0,0]})"), Catch::Contains("'force'"));
  CHECK_THAT(error(head + R"({"step":1,"explode":true})"), Catch::Contains("'motor', 'body', 'controller' or 'dt'"));
  CHECK_THAT(error(head + std::string(100, '[') + "\n"), Catch::Contains("deeper"));
  const std::string motor = R"({"step":1,"motor":"m","target":1})" "\n";
  CHECK_THAT(error(head + motor + motor), Catch::Contains("more inputs"));
  CHECK(cli::inputs_from(head + motor, "x.jsonl"));
  CHECK_FALSE(cli::read_inputs("/nonexistent/inputs"));
}
