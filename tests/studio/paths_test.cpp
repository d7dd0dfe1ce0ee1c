// Paths are made from the steps of a run, whatever frames a page has seen.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "cogrsim/recording/recording.h"
#include "document_support.h"
#include "history.h"
#include "paths.h"
#include "run_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::test;

namespace {

/// A path as a page draws it: straight from point to point.
struct Line {
  std::vector<double> times;
  std::vector<Vec3> points;

  Vec3 at(double time) const {
    const auto next = std::lower_bound(times.begin(), times.end(), time);
    REQUIRE(next != times.end());
    const auto i = static_cast<std::size_t>(next - times.begin());
    if (i == 0 || *next == time) return points[i];
    const double share = (time - times[i - 1]) / (times[i] - times[i - 1]);
    return points[i - 1] + share * (points[i] - points[i - 1]);
  }
};

Line line_of(const Json& answer, const std::string& label) {
  for (const Json& path : answer.at("paths")) {
    if (path.at("label") != label) continue;
    CHECK(path.at("from") == 0);
    Line line;
    line.times = path.at("times").get<std::vector<double>>();
    const auto numbers = path.at("points").get<std::vector<double>>();
    REQUIRE(numbers.size() == 3 * line.times.size());
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
      line.points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    }
    const auto last = path.at("last").get<std::vector<double>>();
    if (answer.at("until") > line.times.back()) {
      line.times.push_back(answer.at("until"));
      line.points.emplace_back(last.at(0), last.at(1), last.at(2));
    }
    return line;
  }
  FAIL("no path of " << label << ": " << answer);
  return {};
}

/// Farthest of any coordinate [m].
double off(const Vec3& a, const Vec3& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Of a path (paths.h), and half of the last digit that is sent, 1e-6 m.
const double kTolerance = Path().tolerance + 0.5e-6 + 1e-12;

}  // namespace

TEST_CASE("a path is as near to the steps as it says, with few points", "[studio][paths]") {
  const double dt = 1e-3;
  Path path;
  std::vector<Vec3> steps;
  // Rest, straight on, a circle of 0.5 m at 0.3 m/s, rest.
  for (int i = 0; i < 40'000; ++i) {
    const double t = dt * i;
    const double gone = std::clamp(t - 10.0, 0.0, 10.0),
                 angle = 0.6 * std::clamp(t - 20.0, 0.0, 10.0);
    steps.emplace_back(0.3 * gone + 0.5 * std::sin(angle), 0.5 - 0.5 * std::cos(angle), 0.1);
    path.add(t, steps.back());
  }
  const auto worst = [&] {
    const Line line{path.times, path.points};
    double most = 0.0;
    for (std::size_t i = 0; dt * static_cast<double>(i) <= line.times.back(); ++i) {
      most = std::max(most, off(line.at(dt * static_cast<double>(i)), steps[i]));
    }
    return most;
  };
  CHECK(worst() <= path.tolerance + 1e-12);
  // A chord that is nowhere farther than e from its arc of radius r is sqrt(8 r e) long; one that begins
  // and ends on the arc, with each coordinate within e, is at least half as long.
  const double chords = 3.0 / (0.5 * std::sqrt(8.0 * 0.5 * path.tolerance));
  CHECK(static_cast<double>(path.times.size()) < chords + 10.0);
  const std::size_t before = path.times.size();
  path.thin();
  CHECK(path.times.size() < 2 * before / 3);
  CHECK(worst() <= 2.0 * path.tolerance);
  // Put elsewhere: the line goes there at once, from where it was.
  const double now = path.last_time;
  path.add(now, Vec3(7, 7, 7));
  path.add(now + dt, Vec3(7, 7, 7));
  REQUIRE(path.times.size() >= 2);
  CHECK(path.times[path.times.size() - 2] == now);
  CHECK(off(path.points[path.points.size() - 2], steps.back()) == 0.0);
  CHECK(path.points.back() == Vec3(7, 7, 7));
}

TEST_CASE("a path of any length has bounded points and is sent piece by piece", "[studio][paths]") {
  auto model = std::make_shared<SceneModel>();
  for (int i = 0; i < 100; ++i) {
    Body body;
    body.name = "b" + std::to_string(i);
    body.kind = i == 0 ? BodyKind::static_body : BodyKind::dynamic;
    model->bodies.push_back(body);
  }
  Paths paths;
  Frame frame;
  frame.model = model;
  frame.state.poses.resize(100);
  const auto step = [&](int i) {
    frame.time = 1e-3 * i;
    for (Pose& pose : frame.state.poses) pose.p = Vec3(std::sin(0.1 * i), std::cos(0.07 * i), 0.0);
    paths.take(frame);
  };
  Json known = paths.since(0, {});
  CHECK(known["until"].is_null());
  std::map<std::string, std::size_t> counts;
  std::size_t most = 0;
  int pieces = 0;
  for (int i = 0; i < 20'000; ++i) {
    step(i);
    if (i % 100 != 0) continue;
    std::vector<std::size_t> have;
    for (const Json& path : known["paths"])
      have.push_back(path["from"].get<std::size_t>() + path["times"].size());
    const Json more = paths.since(known["revision"], have);
    if (more["revision"] == known["revision"]) {
      ++pieces;
      for (std::size_t k = 0; k < have.size(); ++k) CHECK(more["paths"][k]["from"] == have[k]);
    }
    known = more;
    CHECK(known["until"] == frame.time);
    most = std::max(most, paths.since(0, {})["paths"][0]["times"].size());
  }
  // Sixty-four of those that move.
  CHECK(known["paths"].size() == 64);
  CHECK(known["paths"][0]["body"] == "b1");
  CHECK(pieces > 100);
  CHECK(most > 1000);
  CHECK(most <= 200'000 / 64);
  // A run that restarts has nothing of the one before.
  step(0);
  const Json restarted = paths.since(known["revision"], std::vector<std::size_t>(64, 5));
  CHECK(restarted["revision"] != known["revision"]);
  CHECK(restarted["paths"][0]["times"] == Json{0.0});
  paths.clear();
  CHECK(paths.since(0, {})["paths"].empty());
}

TEST_CASE("paths are the same at any speed, and when frames were dropped", "[studio][paths][run]") {
  const std::string xml = [] {
    std::string text = small_scene();
    text.replace(text.find("<physics step=\"1 ms\""), 20,
                 "<physics step=\"1 ms\" duration=\"1 s\"");
    return text;
  }();
  const auto played = [&](std::optional<double> factor, std::size_t history) {
    RunOptions options;
    options.history_bytes = history;
    Page page(options);
    page.join(1);
    page.show(xml);
    page.get("speed", {{"factor", factor ? Json(*factor) : Json()}});
    page.get("play");
    page.status("paused");
    REQUIRE(page.outbox().wait([&] { return page.status().at("step_count") == 1000; }));
    Json all = page.get("paths");
    CHECK(all.erase("revision") == 1);
    return all;
  };
  const Json stepped = [&] {
    Page page;
    page.join(1);
    page.show(xml);
    page.get("step", {{"count", 1000}});
    page.hash_after(1000);
    Json all = page.get("paths");
    all.erase("revision");
    return all;
  }();
  CHECK(stepped.at("until") == Approx(1.0));
  CHECK(played(std::nullopt, 512u << 20) == stepped);
  CHECK(played(20.0, 512u << 20) == stepped);
  CHECK(played(std::nullopt, 20'000) == stepped);
  // And they are where the run was.
  auto bare = Simulation::create(scene_of(xml).model, {}, std::make_shared<PluginLoader>());
  REQUIRE(bare);
  const Line ball = line_of(stepped, "ball"), swing = line_of(stepped, "swing");
  const auto index = [&](const char* name) {
    return static_cast<std::size_t>(find_body(*(*bare)->model(), name));
  };
  double worst = 0.0;
  for (int i = 0; i <= 1000; ++i) {
    const FramePtr frame = (*bare)->frame();
    worst = std::max(worst, off(ball.at(frame->time), frame->state.poses[index("ball")].p));
    worst = std::max(worst, off(swing.at(frame->time), frame->state.poses[index("swing.rod")].p));
    (*bare)->step();
  }
  CHECK(worst <= kTolerance);
}

TEST_CASE("a recording's paths are those of its frames", "[studio][paths][run]") {
  const studio::testing::Folder folder;
  RunOptions options;
  options.folder = folder.folder().string();
  {
    Page page(options);
    page.join(1);
    page.show(small_scene());
    page.get("record", {{"on", true}});
    page.get("step", {{"count", 300}});
    page.hash_after(300);
    page.get("record", {{"on", false}});
  }
  const std::string file = folder.path("small.mcap");
  const auto recording = Recording::open(file);
  REQUIRE(recording);
  FakeOutbox outbox;
  auto run = Run::of_recording(file, std::make_shared<PluginLoader>(), outbox);
  REQUIRE(run);
  Page page(std::move(*run), outbox);
  page.join(1);
  const double end = page.status("recording").at("last");
  Json all;
  // It is read through while the page looks already.
  REQUIRE(outbox.wait([&] {
    all = page.get("paths");
    return all.at("until") == end;
  }));
  const Line ball = line_of(all, "ball");
  for (std::size_t i = 0; i < (*recording)->frame_count(); ++i) {
    const auto frame = (*recording)->frame(i);
    REQUIRE(frame);
    const auto body = static_cast<std::size_t>(find_body(*(*frame)->model, "ball"));
    CHECK(off(ball.at((*frame)->time), (*frame)->state.poses[body].p) <= kTolerance);
  }
}

TEST_CASE("requests for paths are checked", "[studio][paths][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  for (const Json& bad : {Json{{"counts", 7}}, Json{{"counts", {-1}}}, Json{{"counts", {"x"}}}}) {
    CHECK_THAT(page.error("paths", bad), Catch::Contains("'counts"));
  }
  CHECK_THAT(page.error("paths", {{"revision", "x"}}), Catch::Contains("'revision'"));
  CHECK(page.get("paths", {{"revision", 1e9}, {"counts", {1u << 30}}}).at("paths")[0].at("from") ==
        0);
}
