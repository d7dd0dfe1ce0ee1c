// Expectations, passing and failing, on frames made by hand: every text exact.
#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"
#include "cogrsim/testing/judge.h"

using namespace cogrsim;

namespace {

using Kind = ExpectationModel::Kind;

/// A ball whose x a test sets, in steps of 0.1 s.
struct Run {
  SceneModelPtr model;
  TestModel test;

  Run() {
    ModelBuilder b("judged");
    b.sphere("ball", 0.1, 1.0, {});
    model = b.build();
    test.name = "t";
  }
  ExpectationModel& add(Kind kind, const std::string& that) {
    test.expectations.emplace_back();
    test.expectations.back().kind = kind;
    test.expectations.back().that = that;
    return test.expectations.back();
  }
  FramePtr frame(int step, double x) const {
    auto frame = std::make_shared<Frame>();
    frame->model = model;
    frame->step = static_cast<std::uint64_t>(step);
    frame->time = 0.1 * step;
    frame->dt = step == 0 ? 0.0 : 0.1;
    frame->state.poses = {{Vec3(x, 0, 0), Quat(1, 0, 0, 0)}};
    frame->state.twists.resize(1);
    return frame;
  }
  /// Runs with x of these values; the text of every verdict, "" for one that passed.
  std::vector<std::string> judge(const std::vector<std::vector<double>>& runs,
                                 const std::string& early = {}) const {
    const std::vector<std::string> names = {"one", "two", "three"};
    auto judge = TestJudge::create(
        {*model, built_in_channels(*model), {}}, test, 1.0,
        {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(runs.size())});
    INFO((judge ? "" : judge.error().text()));
    REQUIRE(judge);
    for (std::size_t i = 0; i < runs[0].size(); ++i) {
      std::vector<FramePtr> frames;
      for (const auto& x : runs) frames.push_back(frame(static_cast<int>(i), x[i]));
      judge->see(frames);
    }
    std::vector<std::string> texts;
    for (const Verdict& verdict : judge->finish(early))
      texts.push_back(verdict.passed ? "" : to_text(verdict, *model));
    return texts;
  }
};

const std::vector<double> kRise = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};

}  // namespace

TEST_CASE("expect holds at its time or at the end", "[judge]") {
  Run run;
  run.add(Kind::expect, "ball.x eq 10 m");
  run.add(Kind::expect, "ball.x eq 4 m").at = 0.4;
  run.add(Kind::expect, "ball.x eq 0 m").at = 0.0;
  auto& near = run.add(Kind::expect, "ball.x");
  near.equals = 9.5;
  near.tolerance = 0.5;
  CHECK(run.judge({kRise}) == std::vector<std::string>(4));

  run.test.expectations.clear();
  run.add(Kind::expect, "ball.x eq 4 m").at = 0.5;
  auto& far = run.add(Kind::expect, "ball.x");
  far.equals = 9.25;
  far.tolerance = 0.5;
  const auto texts = run.judge({kRise});
  CHECK(texts[0] ==
        "expect ball.x eq 4 m at 0.5 s\n"
        "  does not hold at 0.5 s\n"
        "      time [s]  ball.x [m]\n"
        "           0.2           2\n"
        "           0.3           3\n"
        "           0.4           4\n"
        "  >        0.5           5\n"
        "           0.6           6\n"
        "           0.7           7\n");
  CHECK(texts[1] ==
        "expect ball.x equals 9.25 within 0.5\n"
        "  ball.x is 10 m at the end, 1 s, 0.75 m off\n"
        "      time [s]  ball.x [m]\n"
        "           0.8           8\n"
        "           0.9           9\n"
        "             1          10\n"
        "  >          1          10\n");
}

TEST_CASE("always holds in every frame", "[judge]") {
  Run run;
  run.add(Kind::always, "ball.x le 10 m");
  run.add(Kind::always, "ball.x le 5 m").until = 0.5;
  CHECK(run.judge({kRise}) == std::vector<std::string>(2));
  run.test.expectations.clear();
  run.add(Kind::always, "ball.x lt 5 m").until = 0.5;
  run.add(Kind::always, "not ball.x eq 0 m");  // the first frame counts
  run.add(Kind::always, "ball.x lt 10 m");
  const auto texts = run.judge({kRise});
  CHECK(texts[0].find("does not hold at 0.5 s") != std::string::npos);
  CHECK(texts[1].find("does not hold at 0 s") != std::string::npos);
  CHECK(texts[2].find("does not hold at 1 s") != std::string::npos);  // and the last
}

TEST_CASE("eventually holds in some frame", "[judge]") {
  Run run;
  run.add(Kind::eventually, "ball.x eq 10 m");
  run.add(Kind::eventually, "ball.x eq 5 m").within = 0.5;
  CHECK(run.judge({kRise}) == std::vector<std::string>(2));
  run.test.expectations.clear();
  run.add(Kind::eventually, "ball.x eq 6 m").within = 0.5;
  run.add(Kind::eventually, "ball.x gt 10 m");
  const auto texts = run.judge({kRise});
  CHECK(texts[0].find("  never held up to 0.5 s\n") != std::string::npos);
  CHECK(texts[1].find("  never held, the run ended at 1 s\n") != std::string::npos);
}

TEST_CASE("backends agree within the tolerance up to their time", "[judge]") {
  Run run;
  auto& all = run.add(Kind::agree, "ball.position");
  all.tolerance = 0.25;
  run.add(Kind::always, "ball.x lt 0 m");  // not judged here
  std::vector<double> other = kRise;
  other[6] += 0.25;
  CHECK(run.judge({kRise, other}) == std::vector<std::string>{""});
  other[6] += 0.5;
  CHECK(run.judge({kRise, other})[0] ==
        "agree ball.position within 0.25\n"
        "  one and two diverge at 0.6 s: 0.75 m between them, 0.25 m allowed\n"
        "      time [s]  one: ball.x [m]  two: ball.x [m]  one: ball.y [m]  two: ball.y [m]  "
        "one: ball.z [m]  two: ball.z [m]\n"
        "           0.3                3                3                0                0  "
        "              0                0\n"
        "           0.4                4                4                0                0  "
        "              0                0\n"
        "           0.5                5                5                0                0  "
        "              0                0\n"
        "  >        0.6                6             6.75                0                0  "
        "              0                0\n"
        "           0.7                7                7                0                0  "
        "              0                0\n"
        "           0.8                8                8                0                0  "
        "              0                0\n");
  run.test.expectations[0].until = 0.5;
  CHECK(run.judge({kRise, other}) == std::vector<std::string>{""});
  run.test.expectations[0].until.reset();
  CHECK(run.judge({kRise, kRise, other})[0].find("one and three diverge at 0.6 s") !=
        std::string::npos);
}

TEST_CASE("a run that ends before its time fails what it left open", "[judge]") {
  Run run;
  run.add(Kind::always, "ball.x lt 20 m");
  run.add(Kind::eventually, "ball.x eq 1 m");
  run.add(Kind::expect, "ball.x eq 3 m").at = 0.8;
  const std::vector<double> short_run = {0, 1, 2, 3};
  const auto bad = run.judge({short_run}, "diverged");
  CHECK(bad[0].find("the run ended at 0.3 s: diverged") != std::string::npos);
  CHECK(bad[1].empty());  // it had held
  const auto ended = run.judge({short_run});
  CHECK(ended[0].empty());
  CHECK(ended[2].find("the run ended at 0.3 s, before it could be decided") != std::string::npos);
}

TEST_CASE("a signal without a value passes no test", "[judge]") {
  Run run;
  auto changed = std::make_shared<SceneModel>(*run.model);
  SensorModel mute;
  mute.name = "mute";
  mute.type = "pose";
  mute.body = 0;
  changed->sensors.push_back(mute);
  run.model = changed;
  run.add(Kind::always, "mute.x lt 1 m");
  run.add(Kind::always, "not mute.x lt 1 m");
  run.add(Kind::eventually, "mute.x lt 1 m");
  run.add(Kind::expect, "mute.x").equals = 0.0;
  const auto texts = run.judge({kRise});
  CHECK(texts[0].find("is not known at 0 s: mute.x has no value") != std::string::npos);
  for (const std::string& text : texts) CHECK_FALSE(text.empty());
  CHECK(texts[3].find("mute.x has no value at the end, 1 s") != std::string::npos);
  run.test.expectations.clear();
  run.add(Kind::agree, "mute.x").tolerance = 1.0;
  CHECK(run.judge({kRise, kRise})[0].find("never had a value") != std::string::npos);
}
