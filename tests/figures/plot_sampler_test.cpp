#include "cogrsim/figures/plot_sampler.h"

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::figures;

namespace {

/// A ball that moves 1 m/s along x, and a sensor that reads every fifth step of 1 ms.
struct Run {
  SceneModelPtr model;
  std::vector<Channel> channels = {{"distance", "m", true}};

  Run() {
    ModelBuilder b("runs");
    b.sphere("ball", 0.1, 1.0, {});
    SensorModel eye;
    eye.name = "eye";
    eye.type = "sonar";
    b.model.sensors.push_back(eye);
    model = b.build();
  }

  PlotSampler sampler(const std::string& kind, const std::vector<PlotSeries>& series,
                      double every = 0.0) const {
    PlotModel plot;
    plot.name = "plot";
    plot.kind = kind;
    plot.every = every;
    plot.series = series;
    auto made = PlotSampler::create(plot, *model, [this](int) { return &channels; });
    INFO((made ? "" : made.error().text()));
    REQUIRE(made);
    return std::move(*made);
  }

  PlotSampler sampled(const std::string& kind, const std::vector<PlotSeries>& series,
                      double every = 0.0, int steps = 100) const {
    PlotSampler sampler = this->sampler(kind, series, every);
    Frame frame;
    frame.model = model;
    frame.state.poses.resize(1);
    frame.state.twists.resize(1);
    frame.readings.resize(1);
    for (int i = 0; i <= steps; ++i) {
      frame.step = static_cast<std::uint64_t>(i);
      frame.time += i > 0 ? 1e-3 : 0.0;  // sums of steps, with their rounding
      frame.state.poses[0].p.x() = frame.time;
      frame.readings[0].valid = true;
      frame.readings[0].sequence = static_cast<std::uint64_t>(i / 5 + 1);
      frame.readings[0].values = {static_cast<double>(i / 5)};
      sampler.take(frame);
    }
    return sampler;
  }
};

PlotSeries xy(const std::string& x, const std::string& y, const std::string& label = {}) {
  PlotSeries series;
  series.x = x;
  series.y = y;
  series.label = label;
  return series;
}

}  // namespace

TEST_CASE("samples are taken every step or when they are due", "[plot]") {
  const Run run;
  CHECK(run.sampled("curve", {xy("", "ball.x")}).sample_count() == 101);
  const PlotSampler rare = run.sampled("curve", {xy("", "ball.x")}, 0.01);
  const auto figure = figure_of({&rare}, {});
  REQUIRE(figure);
  REQUIRE(figure->series[0].x.size() == 11);
  for (std::size_t i = 0; i < 11; ++i)
    CHECK(figure->series[0].x[i] == Approx(0.01 * static_cast<double>(i)).margin(1e-9));
  // Between steps it is the next one: 0, 3, 5, 8, 10 ms …
  CHECK(run.sampled("curve", {xy("", "ball.x")}, 0.0025, 10).sample_count() == 5);
}

TEST_CASE("boxes and histograms count each reading once", "[plot]") {
  const Run run;
  const PlotSampler boxes = run.sampled("box", {xy("", "eye.distance"), xy("", "ball.x")});
  const auto figure = figure_of({&boxes}, {});
  REQUIRE(figure);
  CHECK(figure->series[0].box->count == 21);
  CHECK(figure->series[0].box->median == 10);
  CHECK(figure->series[1].box->count == 101);
  PlotSeries counted;
  counted.x = "eye.distance";
  const PlotSampler bars = run.sampled("histogram", {counted});
  const auto histogram = figure_of({&bars}, {});
  REQUIRE(histogram);
  CHECK(histogram->series[0].counts == std::vector<double>(21, 1.0));
  CHECK(histogram->y.label == "count");
}

TEST_CASE("axes are named by their signals", "[plot]") {
  const Run run;
  const PlotSampler one = run.sampled("curve", {xy("", "ball.vx")});
  auto figure = figure_of({&one}, {});
  REQUIRE(figure);
  CHECK(figure->x.label == "time");
  CHECK(figure->x.unit == "s");
  CHECK(figure->y.label == "ball.vx");
  CHECK(figure->y.unit == "m/s");
  // Of one unit, but several quantities.
  const PlotSampler two = run.sampled("curve", {xy("", "ball.x"), xy("", "ball.y", "height")});
  figure = figure_of({&two}, {});
  REQUIRE(figure);
  CHECK(figure->y.label.empty());
  CHECK(figure->y.unit == "m");
  CHECK(figure->series[0].label == "ball.x");
  CHECK(figure->series[1].label == "height");
  // Of several units: each says its own.
  const PlotSampler mixed = run.sampled("curve", {xy("", "ball.x"), xy("", "ball.vx")});
  figure = figure_of({&mixed}, {});
  REQUIRE(figure);
  CHECK(figure->y.unit.empty());
  CHECK(figure->series[1].label == "ball.vx [m/s]");
}

TEST_CASE("several runs become several series", "[plot]") {
  const Run run;
  const PlotSampler a = run.sampled("map", {xy("ball.x", "ball.y")});
  const PlotSampler b = run.sampled("map", {xy("ball.x", "ball.y")});
  auto figure = figure_of({&a, &b}, {"bullet", "cogrsim"});
  REQUIRE(figure);
  REQUIRE(figure->series.size() == 2);
  CHECK(figure->series[0].label == "bullet");
  CHECK(figure->series[1].label == "cogrsim");
  CHECK(figure->y.label == "ball.y");
  const PlotSampler c = run.sampled("curve", {xy("", "ball.x"), xy("", "ball.y")});
  figure = figure_of({&c, &c}, {"1", "2"});
  REQUIRE(figure);
  CHECK(figure->series[2].label == "ball.x, 2");
}

TEST_CASE("plots that make no sense are refused", "[plot]") {
  const Run run;
  const auto refused = [&](const std::string& kind, const std::vector<PlotSeries>& series,
                           double every = 0.0) {
    PlotModel plot;
    plot.name = "p";
    plot.kind = kind;
    plot.every = every;
    plot.series = series;
    const auto made = PlotSampler::create(plot, *run.model, {});
    REQUIRE_FALSE(made);
    return made.error().text();
  };
  CHECK(refused("pie", {xy("", "ball.x")}).find("'pie'") != std::string::npos);
  CHECK(refused("curve", {}).find("no signal") != std::string::npos);
  CHECK(refused("map", {xy("ball.x", "")}).find("for y") != std::string::npos);
  CHECK(refused("box", {xy("ball.x", "ball.y")}).find("no use for x") != std::string::npos);
  CHECK(refused("curve", {xy("", "bal.x")}).find("did you mean 'ball'") != std::string::npos);
  CHECK(refused("curve", {xy("", "ball.x")}, -1.0).find("negative") != std::string::npos);
  CHECK(refused("curve", {xy("", "ball.x")}, kNaN).find("negative") != std::string::npos);
}
