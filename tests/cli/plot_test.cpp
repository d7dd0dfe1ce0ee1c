// cogrsim plot and run --plots.
#include <algorithm>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "process.h"

using Catch::Contains;
using nlohmann::json;

namespace {

const std::string kPlotted = std::string(COGRSIM_SCENES) + "/plotted.scene.xml";
const std::string kFlight = std::string(COGRSIM_SCENES) + "/flight.scene.xml";

Outcome with_toys(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
  return cogrsim_run(arguments);
}

void good(const Outcome& outcome) {
  INFO(outcome.out << outcome.err);
  REQUIRE(outcome.status == 0);
}

}  // namespace

TEST_CASE("a run draws its plots, and its recording draws the same", "[cli][plot]") {
  const TemporaryFolder folder;
  const std::string run = folder / "run.mcap";
  good(with_toys({"run", kPlotted, "--plots", folder / "live", "--record", run}));
  const Outcome plot = cogrsim_run({"plot", run, "-o", folder / "later"});
  good(plot);
  CHECK(plot.out.empty());
  for (const std::string name : {"fall", "path", "gps"}) {
    CHECK_THAT(plot.err, Contains(name + ".png"));
    CHECK(read_file(folder / ("live/" + name + ".png")).substr(1, 3) == "PNG");
    const std::string live = read_file(folder / ("live/" + name + ".json"));
    CHECK_FALSE(live.empty());
    CHECK(read_file(folder / ("later/" + name + ".json")) == live);
  }
  const json fall = json::parse(read_file(folder / "live/fall.json"));
  CHECK(fall["title"] == "Fall");
  CHECK(fall["x"]["unit"] == "s");
  CHECK(fall["y"]["label"] == "ball.z");
  const auto& z = fall["series"][0]["y"];
  REQUIRE(z.size() == 201);
  // 0.2 s of free fall; the order of the integrator is worth g t dt / 2 = 1 mm.
  CHECK(z.back().get<double>() == Approx(2.0 - 0.5 * 9.81 * 0.04).margin(2e-3));
  const json boxes = json::parse(read_file(folder / "live/gps.json"));
  // Readings, not steps: at 0, 20, …, 180 ms, each when a step begins; at 200 ms none does.
  CHECK(boxes["series"][0]["box"]["count"] == 10);
}

TEST_CASE("figures that are not in the scene", "[cli][plot]") {
  const TemporaryFolder folder;
  const std::string run = folder / "run.mcap";
  good(with_toys({"run", kPlotted, "--record", run}));
  good(cogrsim_run({"plot", run, run, "--y", "ball.vz", "--y", "ball.vx", "--from", "50 ms",
                    "--every", "10 ms", "--title", "Speeds", "-o", folder / "v.json"}));
  const json figure = json::parse(read_file(folder / "v.json"));
  CHECK(figure["title"] == "Speeds");
  REQUIRE(figure["series"].size() == 4);
  CHECK(figure["y"]["unit"] == "m/s");
  CHECK(figure["series"][0]["x"][0].get<double>() == Approx(0.05));
  good(cogrsim_run({"plot", folder / "v.json", "-o", folder / "v.pdf"}));
  CHECK(read_file(folder / "v.pdf").substr(0, 5) == "%PDF-");
}

TEST_CASE("plots that cannot be drawn", "[cli][plot]") {
  const TemporaryFolder folder;
  const std::string run = folder / "run.mcap", bare = folder / "bare.mcap";
  good(with_toys({"run", kPlotted, "--record", run}));
  good(with_toys({"run", kFlight, "--record", bare}));
  const struct {
    std::vector<std::string> arguments;
    int status;
    const char* text;
  } cases[] = {
      {{"plot"}, 2, "files is required"},
      {{"plot", folder / "none.mcap"}, 1, "none.mcap"},
      {{"plot", kPlotted}, 1, "--record"},
      {{"plot", folder / "none.json"}, 1, "cannot read"},
      {{"plot", run, "--plot", "fal"}, 1, "did you mean 'fall'"},
      {{"plot", run, "-o", folder / "a.png"}, 2, "there are 3 plots"},
      {{"plot", run, "--plot", "fall", "--y", "ball.x"}, 2, "either"},
      {{"plot", run, "--kind", "pie"}, 2, "pie"},
      {{"plot", run, "--y", "bal.x"}, 1, "did you mean 'ball'"},
      {{"plot", run, "--kind", "map", "--x", "ball.x"}, 1, "needs a signal for y"},
      {{"plot", run, "--x", "time", "--x", "time", "--y", "time", "--y", "time", "--y", "time"},
       2,
       "one per series"},
      {{"plot", run, "--from", "7 s"}, 1, "no frame in the time asked for"},
      {{"plot", run, "--from", "2", "--to", "1"}, 2, "before it begins"},
      {{"plot", run, "--every", "-1"}, 2, "negative"},
      {{"plot", bare}, 1, "has no plots"},
      {{"plot", run, "--y", "time", "-o", "/dev/null/x/y.png"}, 1, "no folder"}};
  for (const auto& c : cases) {
    const Outcome outcome = cogrsim_run(c.arguments);
    INFO(outcome.out << outcome.err);
    CHECK(outcome.status == c.status);
    CHECK_THAT(outcome.out + outcome.err, Contains(c.text));
  }
}
