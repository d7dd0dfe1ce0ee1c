// Meshes, heightmaps, hulls and glued bodies where their own geometry matters.
#include "pair_rig.h"

namespace conformance {
namespace {

constexpr double kRadius = 0.1;

TEST_CASE("heightmap: rows and columns lie as documented", "[terrain]") {
  // Four terraces of different heights, one per quadrant; a ball on each.
  const auto terrace = [](double x, double y) {
    return (x > 0 ? 0.1 : 0.0) + (y > 0 ? 0.25 : 0.0);
  };
  ModelBuilder builder;
  builder.heightmap("terrain", grid_heights(4.0, 7, terrace), at(1, 2, 0.5));
  const double offset = GENERATE(0.9, 1.3);
  std::vector<Vec3> expected;
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const Vec3 place(1 + sx * offset, 2 + sy * offset, 0.5 + terrace(sx, sy) + kRadius);
      expected.push_back(place);
      builder.sphere("ball" + std::to_string(expected.size()), kRadius, 1.0,
                     {place + Vec3(0, 0, 0.02), Quat(1, 0, 0, 0)});
    }
  }
  Sim sim(builder);
  sim.run(1.5);
  for (int i = 0; i < 4; ++i) {
    measure("height error [m]", std::abs(sim.pose(i + 1).p.z() - expected[i].z()), 1e-3);
  }
}

TEST_CASE("ball in a groove", "[terrain]") {
  // Between two flanks at 45 degrees its centre stands r sqrt(2) above the edge.
  const bool as_mesh = GENERATE(true, false), along_x = GENERATE(true, false);
  const auto groove = [along_x](double x, double y) { return std::abs(along_x ? y : x); };
  ModelBuilder builder;
  const int slick = builder.material("slick", 0.2);
  if (as_mesh) {
    builder.mesh("groove", grid_mesh(2.0, 4, groove), false, 0.0, Pose(), slick);
  } else {
    builder.heightmap("groove", grid_heights(2.0, 4, groove), Pose(), slick);
  }
  const double rest = kRadius * std::sqrt(2.0);
  const int ball = builder.sphere("ball", kRadius, 1.0, at(0.13, 0.13, rest + 0.2), slick);
  Sim sim(builder);
  sim.run(4.0);
  const Vec3 p = sim.pose(ball).p;
  measure("height error [m]", std::abs(p.z() - rest), 1e-3);
  measure("off the middle [m]", std::abs(along_x ? p.y() : p.x()), 1e-3);
}

TEST_CASE("heightmap: cells fold along the documented diagonal", "[terrain]") {
  // One cell, two opposite corners raised so that its halves slope by 45 degrees towards the
  // diagonal from the lowest x and y to the highest: a groove. Folded the other way it is a ridge.
  HeightGrid grid;
  grid.columns = grid.rows = 2;
  const double h = std::sqrt(0.5);  // as high as the raised corners are off the diagonal
  grid.heights = {0.0, h, h, 0.0};
  ModelBuilder builder;
  const int slick = builder.material("slick", 0.2);
  builder.heightmap("cell", grid, Pose(), slick);
  const double rest = kRadius * std::sqrt(2.0);
  const int ball = builder.sphere("ball", kRadius, 1.0, at(0.05, -0.05, rest + h), slick);
  Sim sim(builder);
  sim.run(4.0);
  const Vec3 p = sim.pose(ball).p;
  measure("height error [m]", std::abs(p.z() - rest), 1e-3);
  measure("off the diagonal [m]", std::abs(p.x() - p.y()), 1e-3);
}

TEST_CASE("ball rolls over the inner edges of a mesh", "[terrain]") {
  // Flat, so that no edge may have an effect: rolling without loss, v = w r.
  const bool as_mesh = GENERATE(true, false);
  const double v = 1.0;
  const auto flat = [](double, double) { return 0.0; };
  ModelBuilder builder;
  const int rough = builder.material("rough", 0.8);
  if (as_mesh) {
    builder.mesh("floor", grid_mesh(4.0, 9, flat), false, 0.0, Pose(), rough);
  } else {
    builder.heightmap("floor", grid_heights(4.0, 9, flat), Pose(), rough);
  }
  const int ball = builder.sphere("ball", kRadius, 1.0, at(-1.0, 0.13, kRadius), rough);
  builder.model.bodies[ball].V_WB = {Vec3(v, 0, 0), Vec3(0, v / kRadius, 0)};
  Sim sim(builder);
  double jump = 0.0;
  sim.run(2.0, kDt, [&] { jump = std::max(jump, std::abs(sim.pose(ball).p.z() - kRadius)); });
  measure("height error on the way [m]", jump, 1e-3);
  measure_relative("speed at the end", sim.twist(ball).linear.x(), v, 0.01);
  measure("sideways [m]", std::abs(sim.pose(ball).p.y() - 0.13), 0.01);
}

TEST_CASE("box slides over the inner edges of a mesh", "[terrain]") {
  // d = v^2 / (2 mu g) whatever the triangles are.
  const bool as_mesh = GENERATE(true, false);
  const double v = 2.0, mu = 0.3;
  const auto flat = [](double, double) { return 0.0; };
  ModelBuilder builder;
  const int surface = builder.material("surface", mu);
  if (as_mesh) {
    builder.mesh("floor", grid_mesh(4.0, 9, flat), false, 0.0, Pose(), surface);
  } else {
    builder.heightmap("floor", grid_heights(4.0, 9, flat), Pose(), surface);
  }
  const int box = builder.box("box", Vec3(0.3, 0.3, 0.1), 1.0, at(-1.0, 0.1, 0.05), surface);
  builder.model.bodies[box].V_WB.linear = Vec3(v, 0, 0);
  Sim sim(builder);
  sim.run(1.5);
  measure_relative("sliding distance", sim.pose(box).p.x() + 1.0, v * v / (2.0 * mu * 9.81), 0.02);
  measure("height error [m]", std::abs(sim.pose(box).p.z() - 0.05), 1e-3);
}

TEST_CASE("hull whose centre of mass is off its origin", "[terrain]") {
  // A wedge's body frame stands at its corner; it rests on its base, z of the frame at the floor.
  TriangleMesh wedge;
  wedge.name = "wedge";
  wedge.vertices = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.2}};
  wedge.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  ModelBuilder builder;
  builder.plane("floor");
  const int body = builder.mesh("wedge", wedge, true, 1.0, at(0.5, 0.5, 0.02));
  Sim sim(builder);
  sim.run(1.5);
  measure("height error [m]", std::abs(sim.pose(body).p.z()), 1e-3);
  measure("lean [rad]", angle_between(sim.pose(body).q, Quat(1, 0, 0, 0)), 1e-3 / 0.15);
  measure("sideways [m]", (sim.pose(body).p.head<2>() - Vec3(0.5, 0.5, 0).head<2>()).norm(), 5e-3);
}

TEST_CASE("glued shapes are one body", "[terrain]") {
  // A bar on two balls of different size rests on both: it leans by asin((R - r) / d), the larger
  // ball's centre R above the floor.
  const double big = 0.15, small = 0.1, apart = 0.6;
  ModelBuilder builder;
  builder.plane("floor");
  const int body = builder.sphere("dumbbell", big, 2.0, at(0, 0, big + 0.01));
  for (const double side : {-0.1, 0.1}) {  // two small ones, so that it cannot roll over sideways
    Shape end;
    end.name = side < 0 ? "dumbbell.right" : "dumbbell.left";
    end.type = ShapeType::sphere;
    end.radius = small;
    end.X_BS = at(apart, side, 0);
    builder.add_shape(body, end, 0.5);
  }
  Sim sim(builder);
  sim.run(3.0);
  const Pose& X = sim.pose(body);
  const Vec3 axis = X.q * Vec3::UnitX();
  measure("height error of the large ball [m]", std::abs(X.p.z() - big), 1e-3);
  measure("height error of the small balls [m]", std::abs(X.p.z() + apart * axis.z() - small),
          1e-3);
}

}  // namespace
}  // namespace conformance
