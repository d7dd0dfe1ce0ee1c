// How algorithms are asked for: by programs, and by controllers.
#include <filesystem>
#include <fstream>
#include <sstream>

#include "../support/temporary_folder.h"
#include "cogrsim/algorithms/grid_planner.h"
#include "cogrsim/algorithms/learner.h"
#include "cogrsim/algorithms/space_planner.h"
#include "cogrsim/algorithms/steering.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/simulation/simulation.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

ControllerModel asker(const std::string& name, int assembly) {
  ControllerModel controller;
  controller.name = name;
  controller.plugin = "asker";
  controller.rate = 10.0;
  controller.assembly = assembly;
  return controller;
}

/// A ball with two controllers that ask.
ModelBuilder two_askers(const std::string& planner = "a_star", const std::string& table = {}) {
  ModelBuilder builder("askers");
  const int ball = builder.body("bot.ball", 1.0, Mat3::Identity(), Pose{});
  const int bot = builder.assembly("bot", {ball}, {});
  for (const std::string name : {"bot.driver", "bot.other"}) {
    ControllerModel controller = asker(name, bot);
    controller.parameters["planner"] = planner;
    controller.parameters["table"] = table;
    builder.model.controllers.push_back(controller);
  }
  return builder;
}

std::string run(const SceneModelPtr& scene, std::uint64_t seed) {
  SimulationOptions options;
  options.backend = "bullet";
  options.seed = seed;
  const auto own =
      std::make_shared<PluginLoader>(std::vector<std::string>{COGRSIM_TEST_ALGORITHMS});
  auto simulation = Simulation::create(scene, options, own);
  std::string out;
  if (!simulation) {
    for (const Diagnostic& d : simulation.error()) out += d.message + "\n";
    return "refused: " + out;
  }
  (*simulation)->run_until(0.15);
  for (const auto& message : (*simulation)->messages()) out += message.message + "\n";
  return out;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

}  // namespace

TEST_CASE("every algorithm describes itself", "[algorithms][loading]") {
  int count = 0;
  for (const PluginPtr& plugin : loader().all()) {
    const PluginDescriptor& d = plugin->descriptor();
    if (d.kind != PluginKind::algorithm || d.name == "thrower") continue;
    INFO(d.name);
    ++count;
    CHECK_FALSE(d.summary.empty());
    CHECK(d.version != "0.0.0");
    for (const ParameterSpec& spec : d.parameters) {
      CHECK_FALSE(spec.description.empty());
      // Every number has its unit and at least one bound.
      if (spec.type() != ParameterType::number) continue;
      CHECK_FALSE(spec.unit.empty());
      CHECK((std::isfinite(spec.minimum) && std::isfinite(spec.maximum)));
    }
    const std::string family = static_cast<const AlgorithmEntry*>(d.factory)->family;
    CHECK((family == GridPlanner::kFamily || family == SpacePlanner::kFamily ||
           family == Steering::kFamily || family == Learner::kFamily));
  }
  CHECK(count == 12);  // eleven, and the one in own/
}

TEST_CASE("an unknown algorithm is reported with the known ones", "[algorithms][loading]") {
  CHECK(has(said(load_algorithm<GridPlanner>(loader(), "rrt")),
            "'rrt' is a space-planner, and was asked for as a grid-planner"));
  const auto unknown = load_algorithm<GridPlanner>(loader(), "a_strar");
  REQUIRE_FALSE(unknown);
  CHECK(has(unknown.error().text(), "there is no algorithm 'a_strar'"));
  CHECK(has(unknown.error().text(), "did you mean 'a_star'?"));
  CHECK(has(said(load_algorithm<GridPlanner>(loader(), "asker")),
            "is a controller, not an algorithm"));
  CHECK(has(said(load_algorithm<GridPlanner>(loader(), "a_star", {{"weight", 0.5}})),
            "algorithm 'a_star': parameter 'weight' is 0.5, but must be 1 to 100"));
  CHECK(has(said(load_algorithm<GridPlanner>(loader(), "a_star", {{"wieght", 2.0}})),
            "did you mean 'weight'?"));
  CHECK(has(said(load_algorithm<GridPlanner>(loader(), "thrower")),
            "algorithm 'thrower' did not start: the moon is in the wrong phase"));
}

TEST_CASE("an algorithm outlives its loader", "[algorithms][loading]") {
  std::shared_ptr<GridPlanner> planner;
  {
    PluginLoader passing;
    planner = *load_algorithm<GridPlanner>(passing, "d_star_lite");
  }
  planner->set_grid(Grid(3, 3));
  CHECK(planner->plan({0, 0}, {2, 2})->cost == 4.0);
}

TEST_CASE("a user's own algorithm is requested in the same way", "[algorithms][loading]") {
  auto own = make<Steering>("beeline", {{"clearance", 0.2}});
  SteeringTask task;
  task.path = {{2.0, 0.0}};
  CHECK(own->steer(task)->velocity.forward == Approx(0.3));
  task.obstacles = {{0.25, 0.0}};
  CHECK(own->steer(task)->stuck);
}

TEST_CASE("a controller asks for algorithms by name", "[algorithms][loading]") {
  const auto scene = two_askers().build();
  const std::string first = run(scene, 1);
  const auto reports = lines(first);
  REQUIRE(reports.size() == 4);  // two controllers, two updates
  CHECK(has(reports[0], "path 5, choices "));
  // The seed decides, and each controller draws for itself.
  CHECK(run(scene, 1) == first);
  CHECK(run(scene, 2) != first);
  CHECK(reports[0] != reports[1]);
}

TEST_CASE("a controller's mistakes in asking fail the load", "[algorithms][loading]") {
  const std::string unknown = run(two_askers("d_star_light").build(), 1);
  CHECK(has(unknown, "refused: "));
  CHECK(has(unknown, "there is no algorithm 'd_star_light'"));
  CHECK(has(unknown, "did you mean 'd_star_lite'?"));
  const std::string family = run(two_askers("sarsa").build(), 1);
  CHECK(has(family, "'sarsa' is a learner, and was asked for as a grid-planner"));
}

TEST_CASE("a controller's table lies beside its scene", "[algorithms][loading]") {
  const cogrsim::test::TemporaryFolder there;
  const std::filesystem::path& folder = there.path;
  ModelBuilder builder = two_askers("a_star", "table.txt");
  builder.model.controllers.pop_back();
  builder.model.files = {(folder / "some.scene.xml").string()};
  const auto scene = builder.build();
  run(scene, 1);
  run(scene, 1);
  std::ostringstream text;
  text << std::ifstream(folder / "table.txt").rdbuf();
  CHECK(has(text.str(), "episodes 4\n"));  // two updates in each of two runs
  std::ofstream(folder / "table.txt") << "spoilt\n";
  CHECK(has(run(scene, 1), (folder / "table.txt").string() + ":1: not a learner's table"));
}

TEST_CASE("the document shows the sources that are built here", "[algorithms][loading]") {
  const auto text_of = [](const std::string& path) {
    std::ostringstream out;
    out << std::ifstream(path).rdbuf();
    return out.str();
  };
  const std::string document = text_of(COGRSIM_TEST_SOURCES "/docs/plugins/algorithms.md");
  REQUIRE_FALSE(document.empty());
  for (const std::string file : {"beeline", "seeker"}) {
    const std::string source =
        text_of(COGRSIM_TEST_SOURCES "/tests/algorithms/own/" + file + ".cpp");
    REQUIRE_FALSE(source.empty());
    INFO(file);
    CHECK(document.find("```cpp\n" + source + "```") != std::string::npos);
  }
}
