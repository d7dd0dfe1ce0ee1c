// Scenes that must behave alike: moved, turned together with gravity, put together in another
// order.
#include <algorithm>

#include "pair_rig.h"
#include "scenes.h"

namespace conformance {
namespace {

// A scene as a list of things to add, so that their order can be changed.
using Adder = std::function<void(ModelBuilder&, const Pose& X_WO)>;

// Nothing touches: a tumbling box, a double pendulum, a spring, a thrown chain.
std::vector<Adder> smooth_scene() {
  return {
      [](ModelBuilder& b, const Pose& X) {
        const int body = b.box("tumbler", Vec3(0.1, 0.4, 0.9), 10.0, X * at(0, 5, 3));
        b.model.bodies[body].V_WB = {X.q * Vec3(1, 2, 3), X.q * Vec3(0.1, 3, 0.1)};
      },
      [](ModelBuilder& b, const Pose& X) {
        const Quat axis = z_to(Vec3::UnitY());
        const int one = b.box("one", Vec3(1, 0.05, 0.05), 1.0, X * at(0.5, 0, 3));
        const int two = b.box("two", Vec3(1, 0.05, 0.05), 1.0, X * at(1.5, 0, 3));
        b.joint("shoulder", JointType::hinge, kWorld, one, X * Pose(Vec3(0, 0, 3), axis));
        b.joint("elbow", JointType::hinge, one, two, X * Pose(Vec3(1, 0, 3), axis));
      },
      [](ModelBuilder& b, const Pose& X) {
        const int body = b.sphere("weight", 0.1, 1.0, X * at(-3, 0, 3));
        const int rail = b.joint("rail", JointType::slider, kWorld, body, X * at(-3, 0, 3));
        b.model.joints[rail].axes[0].stiffness = 40.0;
      },
  };
}

// Single points of contact and flat landings, each by itself.
std::vector<Adder> contact_scene() {
  const auto surface = [](ModelBuilder& b) {
    for (std::size_t i = 0; i < b.model.materials.size(); ++i) {
      if (b.model.materials[i].name == "surface") return static_cast<int>(i);
    }
    return b.material("surface", 0.4, 0.3);
  };
  return {
      [=](ModelBuilder& b, const Pose& X) {
        b.box("slab", Vec3(20, 20, 1), 0.0, X * at(0, 0, -0.5), surface(b));
      },
      [=](ModelBuilder& b, const Pose& X) {
        const int body = b.sphere("ball", 0.1, 1.0, X * at(0, 3, 0.3), surface(b));
        b.model.bodies[body].V_WB = {X.q * Vec3(1, 0.5, 0), X.q * Vec3(4, -3, 2)};
      },
      [=](ModelBuilder& b, const Pose& X) {
        const int body = b.box("slider", Vec3(0.4, 0.4, 0.1), 1.0, X * at(3, 0, 0.05), surface(b));
        b.model.bodies[body].V_WB = {X.q * Vec3(0.8, 0.6, 0), Vec3::Zero()};
      },
  };
}

std::map<std::string, Pose> run_scene(const std::vector<Adder>& adders, const Pose& X_WO,
                                      double seconds) {
  ModelBuilder builder;
  builder.model.physics.gravity = X_WO.q * Vec3(0, 0, -kGravity);
  for (const Adder& add : adders) add(builder, X_WO);
  Sim sim(builder);
  sim.run(seconds);
  std::map<std::string, Pose> poses;
  for (std::size_t i = 0; i < sim.model().bodies.size(); ++i) {
    poses[sim.model().bodies[i].name] = X_WO.inverse() * sim.pose(static_cast<int>(i));
  }
  return poses;
}

void compare(const std::vector<Adder>& one, const Pose& X_one, const std::vector<Adder>& two,
             const Pose& X_two, double seconds, double limit, double angle_limit) {
  const auto a = run_scene(one, X_one, seconds), b = run_scene(two, X_two, seconds);
  REQUIRE(a.size() == b.size());
  for (const auto& [name, pose] : a) {
    measure("difference of the " + name + " [m]", (pose.p - b.at(name).p).norm(), limit);
    measure("difference of the " + name + " [rad]", angle_between(pose.q, b.at(name).q),
            angle_limit);
  }
}

const Pose kMoved(Vec3(10, -7, 3), Quat(1, 0, 0, 0));

// Rounding: 1e-15 of 10 m, a thousand steps, grown by e^3 in a second by the pendulum's
// sensitivity: 1e-10. An adaptive integrator may pick other steps: its accuracy counts, 1e-8.
constexpr double kSmooth = 1e-8;
// With contact an iterative solver stops at a residual, which depends on the order and the numbers
// it works with: 1e-5 m/s or rad/s over the 0.6 s.
constexpr double kContact = 6e-6;
// Solvers that split friction along two world directions are not the same in every direction. The
// table allows 0.5 % of what friction does: of 0.6 m of displacement, and of the 6 rad that the
// ball turns.
constexpr double kContactTurned = 3e-3, kContactTurnedAngle = 3e-2;

TEST_CASE("moved scene runs alike, smooth", "[metamorphic]") {
  compare(smooth_scene(), Pose(), smooth_scene(), kMoved, 1.0, kSmooth, kSmooth);
}

TEST_CASE("moved scene runs alike, with contact", "[metamorphic]") {
  compare(contact_scene(), Pose(), contact_scene(), kMoved, 0.6, kContact, kContact);
}

TEST_CASE("scene turned together with gravity runs alike, smooth", "[metamorphic]") {
  const Pose turned(Vec3::Zero(), turn(Vec3(1, -2, 0.5), 1.1));
  compare(smooth_scene(), Pose(), smooth_scene(), turned, 1.0, kSmooth, kSmooth);
}

TEST_CASE("scene turned together with gravity runs alike, with contact", "[metamorphic]") {
  const Pose turned(Vec3::Zero(), turn(Vec3(1, -2, 0.5), 1.1));
  compare(contact_scene(), Pose(), contact_scene(), turned, 0.6, kContactTurned,
          kContactTurnedAngle);
}

TEST_CASE("order of bodies does not matter, smooth", "[metamorphic]") {
  auto reversed = smooth_scene();
  std::reverse(reversed.begin(), reversed.end());
  compare(smooth_scene(), Pose(), reversed, Pose(), 1.0, kSmooth, kSmooth);
}

TEST_CASE("order of bodies does not matter, with contact", "[metamorphic]") {
  auto reversed = contact_scene();
  std::reverse(reversed.begin(), reversed.end());
  compare(contact_scene(), Pose(), reversed, Pose(), 0.6, kContact, kContact);
}

TEST_CASE("bystanders do not matter", "[metamorphic]") {
  // One scene alone and with the other beside it.
  const auto alone = run_scene(smooth_scene(), Pose(), 1.0);
  auto both = contact_scene();
  for (const Adder& add : smooth_scene()) {
    both.push_back([add](ModelBuilder& b, const Pose& X) { add(b, X * at(0, 0, 20)); });
  }
  const auto together = run_scene(both, Pose(), 1.0);
  double largest = 0.0;
  for (const auto& [name, pose] : alone) {
    const Pose& other = together.at(name);
    largest = std::max(
        {largest, (pose.p + Vec3(0, 0, 20) - other.p).norm(), angle_between(pose.q, other.q)});
  }
  // An adaptive integrator takes shorter steps for the sake of the contacts, and a fixed one stays
  // as it was: what is left is the integrator's own accuracy.
  measure("difference [m, rad]", largest, 1e-4);
}

// Where a ball thrown with spin onto a floor of the given shape is after 0.6 s.
Pose throw_onto(ShapeType shape) {
  ModelBuilder builder;
  const int surface = builder.material("surface", 0.4, 0.3);
  const auto flat = [](double, double) { return 0.0; };
  switch (shape) {
    case ShapeType::box:
      builder.box("floor", Vec3(20, 20, 1), 0.0, at(0, 0, -0.5), surface);
      break;
    case ShapeType::mesh:
      builder.mesh("floor", grid_mesh(20.0, 7, flat), false, 0.0, Pose(), surface);
      break;
    case ShapeType::heightmap:
      builder.heightmap("floor", grid_heights(20.0, 7, flat), Pose(), surface);
      break;
    default:
      builder.plane("floor", Pose(), surface);
  }
  const int ball = builder.sphere("ball", 0.1, 1.0, at(0, 3, 0.3), surface);
  builder.model.bodies[ball].V_WB = {Vec3(1, 0.5, 0), Vec3(4, -3, 2)};
  Sim sim(builder);
  sim.run(0.6);
  return sim.pose(ball);
}

TEST_CASE("a level floor is a level floor, whatever its shape", "[metamorphic]") {
  const ShapeType shape = GENERATE(ShapeType::box, ShapeType::mesh, ShapeType::heightmap);
  const Pose on_plane = throw_onto(ShapeType::plane), on_other = throw_onto(shape);
  const std::string against = std::string(" on a ") + to_string(shape) + " against a plane";
  measure("place" + against + " [m]", (on_plane.p - on_other.p).norm(), kContactTurned);
  measure("turn" + against + " [rad]", angle_between(on_plane.q, on_other.q), kContactTurnedAngle);
}

}  // namespace
}  // namespace conformance
