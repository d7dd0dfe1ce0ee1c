// Distributing a pair's friction over its points: the wrench is preserved, superfluous forces
// vanish.
#include <catch2/catch.hpp>

#include <vector>

#include "cogrsim/core/random.h"
#include "cogrsim/physics/friction_share.h"

using namespace cogrsim;

namespace {

struct Wrenches {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
};

Wrenches wrench(const std::vector<Vec3>& points, const std::vector<Vec3>& friction) {
  Wrenches sum;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum.force += friction[i];
    sum.moment += points[i].cross(friction[i]);
  }
  return sum;
}

const std::vector<Vec3> kCorners = {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}};

}  // namespace

TEST_CASE("forces that only press points against each other vanish", "[sdk][friction]") {
  const std::vector<double> loads(4, 7.0);
  std::vector<Vec3> friction = {{2, 2, 0}, {-2, 2, 0}, {-2, -2, 0}, {2, -2, 0}};
  share_friction(4, Vec3::UnitZ(), loads.data(), kCorners.data(), friction.data());
  for (const Vec3& f : friction) CHECK(f.norm() < 1e-15);
}

TEST_CASE("the wrench is preserved, and sharing again changes nothing", "[sdk][friction]") {
  RandomStream random(3, "friction");
  for (int trial = 0; trial < 50; ++trial) {
    const auto count = static_cast<std::size_t>(2 + trial % 4);
    std::vector<double> loads;
    std::vector<Vec3> points, friction;
    for (std::size_t i = 0; i < count; ++i) {
      loads.push_back(random.uniform(0.1, 5.0));
      points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), 0.3);
      friction.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), 0.0);
    }
    const Wrenches before = wrench(points, friction);
    share_friction(count, Vec3::UnitZ(), loads.data(), points.data(), friction.data());
    const Wrenches after = wrench(points, friction);
    CHECK((before.force - after.force).norm() < 1e-12);
    CHECK((before.moment - after.moment).norm() < 1e-12);
    std::vector<Vec3> again = friction;
    share_friction(count, Vec3::UnitZ(), loads.data(), points.data(), again.data());
    for (std::size_t i = 0; i < count; ++i) CHECK((again[i] - friction[i]).norm() < 1e-12);
  }
}

TEST_CASE("a mere force is shared by load and stays within the cone", "[sdk][friction]") {
  const std::vector<double> loads = {1.0, 2.0, 3.0, 0.0};
  std::vector<Vec3> friction = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0.6, 0, 0}};
  // The last point carries nothing: its share goes to the others, with its moment.
  share_friction(4, Vec3::UnitZ(), loads.data(), kCorners.data(), friction.data());
  CHECK(friction[3].norm() == 0.0);
  const Wrenches after = wrench(kCorners, friction);
  CHECK(after.force.x() == Approx(0.6));
  CHECK(after.moment.z() == Approx(0.6));
  std::vector<Vec3> pure = {{0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}, {0, 0, 0}};
  const std::vector<Vec3> expected = pure;
  share_friction(4, Vec3::UnitZ(), loads.data(), kCorners.data(), pure.data());
  for (std::size_t i = 0; i < 4; ++i) CHECK((pure[i] - expected[i]).norm() < 1e-12);
}

TEST_CASE("a single loaded point keeps its friction", "[sdk][friction]") {
  const std::vector<double> loads = {1.0, 0.0};
  std::vector<Vec3> friction = {{0.5, 0.1, 0}, {0, 0, 0}};
  share_friction(2, Vec3::UnitZ(), loads.data(), kCorners.data(), friction.data());
  CHECK(friction[0] == Vec3(0.5, 0.1, 0));
}
