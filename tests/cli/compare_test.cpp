// The statistics of a comparison, on frames made by hand.
#include <cmath>

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"
#include "compare/compare.h"
#include "compare/convergence.h"

using namespace cogrsim;
using namespace cogrsim::cli;

namespace {

SceneModelPtr two_bodies_and_a_hinge() {
  ModelBuilder builder("pair");
  builder.plane("floor");
  const int a = builder.box("a", Vec3(1, 1, 1), 2.0, Pose(Vec3(0, 0, 1), Quat(1, 0, 0, 0)));
  builder.box("b", Vec3(1, 1, 1), 1.0, Pose(Vec3(3, 0, 1), Quat(1, 0, 0, 0)));
  builder.joint("hinge", JointType::hinge, kWorld, a, Pose(Vec3(0, 0, 1), Quat(1, 0, 0, 0)));
  return builder.build();
}

std::shared_ptr<Frame> frame_of(const SceneModelPtr& model) {
  auto frame = std::make_shared<Frame>();
  frame->model = model;
  for (const Body& body : model->bodies) {
    frame->state.poses.push_back(body.X_WB);
    frame->state.twists.push_back(body.V_WB);
  }
  frame->state.joint_positions.assign(static_cast<std::size_t>(model->joint_positions), 0.0);
  frame->state.joint_velocities.assign(static_cast<std::size_t>(model->joint_speeds), 0.0);
  frame->state.joint_efforts = frame->state.joint_velocities;
  return frame;
}

std::size_t index_of(const SceneModelPtr& model, const char* name) {
  return static_cast<std::size_t>(find_body(*model, name));
}

}  // namespace

TEST_CASE("differences: maximum, rms, end, first time over, worst first", "[cli][compare]") {
  const SceneModelPtr model = two_bodies_and_a_hinge();
  CompareOptions options;
  options.position_threshold = 0.05;
  options.angle_threshold = 0.1;
  Comparison comparison({"one", "two"}, options);
  const double offsets[] = {0.0, 0.04, 0.08, 0.02};
  for (int i = 0; i < 4; ++i) {
    auto first = frame_of(model), second = frame_of(model);
    second->state.poses[index_of(model, "b")].p.x() += offsets[i];
    second->state.poses[index_of(model, "a")].q = Quat(Eigen::AngleAxisd(-0.01 * i, Vec3::UnitZ()));
    second->state.joint_positions[0] = -0.01 * i;
    comparison.add(0.5 * i, {first, second});
  }
  const CompareResult result = comparison.finish();
  REQUIRE(result.bodies.size() == 2);  // the floor cannot move
  const Difference& worst = result.bodies[0];
  CHECK(worst.name == "b");
  CHECK(worst.distance->max == Approx(0.08));
  CHECK(worst.distance->max_time == 1.0);
  CHECK(worst.distance->end == Approx(0.02));
  CHECK(worst.distance->rms == Approx(std::sqrt((0.0016 + 0.0064 + 0.0004) / 4)));
  REQUIRE(worst.first_over);
  CHECK(*worst.first_over == 1.0);
  CHECK(result.first_over.value() == 1.0);
  CHECK(result.first_over_name == "b");
  CHECK(result.bodies[1].angle->max == Approx(0.03));
  CHECK_FALSE(result.bodies[1].first_over);
  REQUIRE(result.joints.size() == 1);
  CHECK(result.joints[0].angle->end == Approx(0.03));
  CHECK_FALSE(result.joints[0].distance);
  CHECK(result.samples == 4);
  CHECK(result.end_time == 1.5);
}

TEST_CASE("figures of each run: energy, momentum, contacts, joint error", "[cli][compare]") {
  const SceneModelPtr model = two_bodies_and_a_hinge();
  const std::size_t b = index_of(model, "b"), a = index_of(model, "a");
  Comparison comparison({"one", "two"}, {});
  comparison.add(0.0, {frame_of(model), frame_of(model)});
  auto moved = frame_of(model);
  moved->state.twists[b].linear = Vec3(0, 0, 2);
  moved->state.poses[a].p.x() += 0.001;  // out of its hinge
  Contact contact;
  contact.body_a = static_cast<int>(index_of(model, "floor"));
  contact.body_b = static_cast<int>(b);
  contact.depth = 0.003;
  moved->contacts = {contact, contact};
  comparison.add(0.1, {moved, frame_of(model)});
  const CompareResult result = comparison.finish();
  const RunFigures& figures = result.figures[0];
  CHECK(figures.energy.end - figures.energy.start == Approx(2.0));  // 1/2 m v^2, m = 1
  CHECK(figures.linear_momentum.largest == Approx(2.0));
  CHECK(figures.angular_momentum.largest == Approx(6.0));  // 3 m away from the origin
  CHECK(figures.mean_contacts == Approx(1.0));
  CHECK(figures.most_contacts == 2);
  CHECK(figures.penetration.value == Approx(0.003));
  CHECK(figures.penetration.where == "floor and b");
  CHECK(figures.joint_distance.value == Approx(0.001));
  CHECK(figures.joint_distance.where == "hinge");
  CHECK(result.figures[1].energy.largest == 0.0);
  CHECK(result.figures[1].penetration.where.empty());
}

TEST_CASE("a curve keeps every peak", "[cli][compare]") {
  const SceneModelPtr model = two_bodies_and_a_hinge();
  CompareOptions options;
  options.curve_points = 10;
  Comparison comparison({"one", "two"}, options);
  for (int i = 0; i < 1000; ++i) {
    auto second = frame_of(model);
    if (i == 537) second->state.poses[index_of(model, "b")].p.y() += 0.5;
    comparison.add(0.001 * i, {frame_of(model), second});
  }
  const CompareResult result = comparison.finish();
  REQUIRE(result.times.size() >= 10);
  REQUIRE(result.times.size() <= 20);
  const std::vector<double>& curve = result.bodies[0].distance->curve;
  REQUIRE(curve.size() == result.times.size());
  REQUIRE(result.figures[0].energy_curve.size() == result.times.size());
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const double start = i == 0 ? -1.0 : result.times[i - 1];
    CHECK(curve[i] == (start < 0.537 && 0.537 <= result.times[i] ? Approx(0.5) : Approx(0.0)));
  }
}

TEST_CASE("bodies are paired by name while others come and go", "[cli][compare]") {
  const SceneModelPtr model = two_bodies_and_a_hinge();
  auto without = std::make_shared<SceneModel>(*model);
  without->bodies[index_of(model, "b")].removed = true;
  Comparison comparison({"one", "two"}, {});
  comparison.add(0.0, {frame_of(model), frame_of(model)});
  comparison.add(0.1, {frame_of(model), frame_of(without)});
  comparison.add(0.2, {frame_of(model), frame_of(model)});
  const CompareResult result = comparison.finish();
  CHECK(result.only_in_some.empty());
  REQUIRE(result.bodies.size() == 2);
  for (const Difference& difference : result.bodies) {
    REQUIRE(difference.distance->curve.size() == 3);
    CHECK(std::isnan(difference.distance->curve[1]) == (difference.name == "b"));
  }
}

TEST_CASE("three runs are each measured against the first", "[cli][compare]") {
  const SceneModelPtr model = two_bodies_and_a_hinge();
  Comparison comparison({"one", "two", "three"}, {});
  auto second = frame_of(model), third = frame_of(model);
  second->state.poses[index_of(model, "b")].p.x() += 0.1;
  third->state.poses[index_of(model, "b")].p.x() += 0.2;
  comparison.add(0.0, {frame_of(model), second, third});
  const CompareResult result = comparison.finish();
  REQUIRE(result.bodies.size() == 4);
  CHECK(result.bodies[0].run == 2);
  CHECK(result.bodies[0].distance->max == Approx(0.2));
  CHECK(result.bodies[1].run == 1);
}

TEST_CASE("angles between orientations do not depend on the quaternion's sign", "[cli][compare]") {
  const Quat a(Eigen::AngleAxisd(0.3, Vec3::UnitX())), b(Eigen::AngleAxisd(0.5, Vec3::UnitX()));
  const Quat minus_b(-b.w(), -b.x(), -b.y(), -b.z());
  CHECK(angle_between(a, b) == Approx(0.2));
  CHECK(angle_between(a, minus_b) == Approx(0.2));
  CHECK(angle_between(a, a) == Approx(0.0).margin(1e-15));
}

TEST_CASE("the observed order is that of the error", "[cli][convergence]") {
  for (const double p : {1.0, 2.0, 4.0}) {
    const auto error = [&](double h) { return 3.0 * std::pow(h, p); };
    // halved steps, and steps in no fixed ratio
    for (const auto& h : {std::array<double, 3>{4, 2, 1}, std::array<double, 3>{6, 2, 1}}) {
      const auto order =
          observed_order(h[0], h[1], h[2], error(h[0]) - error(h[1]), error(h[1]) - error(h[2]));
      REQUIRE(order);
      CHECK(*order == Approx(p).epsilon(1e-6));
    }
  }
  CHECK_FALSE(observed_order(4, 2, 1, 1.0, 2.0));
  CHECK_FALSE(observed_order(4, 2, 1, 1.0, 0.0));
}
