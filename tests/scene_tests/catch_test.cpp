// The header for tests in C++.
#include "cogrsim/testing/catch.h"
#include "../support/temporary_folder.h"

#include "cogrsim/model/builder.h"

using namespace cogrsim;
namespace ct = cogrsim::testing;

TEST_CASE("poses match within two tolerances and say how far they are", "[catch]") {
  const Pose X{Vec3(1, 2, 3), Quat(1, 0, 0, 0)};
  const Pose Y{Vec3(1, 2, 3.002), Quat(Eigen::AngleAxisd(0.1, Vec3::UnitX()))};
  CHECK_THAT(X, ct::ApproxPose(X, 0.0, 1e-7));
  CHECK_THAT(Y, ct::ApproxPose(X, 0.003, 0.11));
  CHECK_THAT(Y, !ct::ApproxPose(X, 0.001, 0.11));
  CHECK_THAT(Y, !ct::ApproxPose(X, 0.003, 0.09));
  const ct::ApproxPose matcher(X, 0.001, 0.01);
  CHECK_FALSE(matcher.match(Y));
  CHECK(matcher.describe() ==
        "is within 0.001 m and 0.01 rad of p (1, 2, 3) m, q (1, 0, 0, 0): it is 0.002 m away and "
        "turned by 0.1 rad");
}

TEST_CASE("trajectories match and are kept on file", "[catch]") {
  ct::Trajectory a;
  a.signals = {"ball.x", "distance(ball, wall)"};
  a.times = {0, 0.1};
  a.values = {{1, std::numeric_limits<double>::quiet_NaN()}, {2, 1.0 / 3}};
  ct::Trajectory b = a;
  CHECK_THAT(b, ct::ApproxTrajectory(a, 0));
  b.values[1][0] = 2.5;
  CHECK_THAT(b, ct::ApproxTrajectory(a, 0.5));
  const ct::ApproxTrajectory matcher(a, 0.25);
  CHECK_FALSE(matcher.match(b));
  CHECK(matcher.describe() ==
        "is not as expected: ball.x is 2.5 at 0.1 s, expected 2: the difference is 0.5, at most "
        "0.25 is allowed");

  const cogrsim::test::TemporaryFolder folder;
  const std::string beside = folder / "test.cpp", file = "golden.csv";
  const ct::MatchesGolden missing(beside.c_str(), file, 0);
  CHECK_FALSE(missing.match(a));
  CHECK(missing.describe().find("write it with --update-golden") != std::string::npos);
  ct::update_golden() = true;
  CHECK_THAT(a, ct::MatchesGolden(beside.c_str(), file, 0));
  ct::update_golden() = false;
  CHECK_THAT(a, ct::MatchesGolden(beside.c_str(), file, 0));  // to the last bit
  CHECK_THAT(b, !ct::MatchesGolden(beside.c_str(), file, 0.25));
}

TEST_CASE("a run on every backend follows the parabola", "[catch]") {
  const std::string backend = GENERATE(ct::backends());
  ModelBuilder b("fall");
  b.sphere("ball", 0.1, 1.0, {Vec3(0, 0, 1), Quat(1, 0, 0, 0)});
  auto run = ct::start(b.build(), backend);
  const ct::Trajectory found = ct::record(*run, {"ball.z"}, 0.3, 0.1);
  ct::Trajectory expected = found;
  for (std::size_t i = 0; i < expected.times.size(); ++i)
    expected.values[i][0] = 1 - 0.5 * 9.81 * expected.times[i] * expected.times[i];
  // Semi-implicit Euler errs by g t dt / 2 = 1.5 mm at most.
  CHECK_THAT(found, ct::ApproxTrajectory(expected, 0.5 * 9.81 * 0.3 * 1e-3 + 1e-9));
  CHECK(found.times.size() == 4);
}
