#include "cogrsim/rays/ray_caster.h"

#include <cmath>
#include <thread>

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"
#include "rays_reference.h"

using namespace cogrsim;
using namespace cogrsim::reference;

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A caster over a model at its initial poses.
struct World {
  explicit World(SceneModelPtr made, RayTargets targets = RayTargets::visible)
      : model(std::move(made)), poses(poses_of(*model)) {
    rays.update(model, poses, targets);
  }
  SceneModelPtr model;
  std::vector<Pose> poses;
  RayCaster rays;
};

Ray ray_from(const Vec3& origin, const Vec3& direction) {
  Ray ray;
  ray.origin = origin;
  ray.direction = direction.normalized();
  return ray;
}

/// A body of one shape; for a plane a static one.
SceneModelPtr one(ShapeType type, const Pose& pose) {
  ModelBuilder builder;
  switch (type) {
    case ShapeType::box:
      builder.box("it", {0.6, 1.0, 1.4}, 1.0, pose);
      break;
    case ShapeType::sphere:
      builder.sphere("it", 0.7, 1.0, pose);
      break;
    case ShapeType::cylinder:
      builder.cylinder("it", 0.6, 1.3, 1.0, pose);
      break;
    case ShapeType::capsule:
      builder.capsule("it", 0.4, 0.9, 1.0, pose);
      break;
    case ShapeType::plane:
      builder.plane("it", pose);
      break;
    case ShapeType::mesh:
      builder.mesh("it", ring(0.7, 0.25), false, 0.0, pose);
      break;
    case ShapeType::convex_mesh:
      builder.mesh("it", octahedron(0.8), true, 1.0, pose);
      break;
    case ShapeType::heightmap: {
      HeightGrid grid;
      grid.columns = 9;
      grid.rows = 7;
      grid.size_x = 2.0;
      grid.size_y = 1.5;
      RandomStream random(5, "heights");
      for (int i = 0; i < grid.columns * grid.rows; ++i)
        grid.heights.push_back(random.uniform(-0.3, 0.3));
      builder.heightmap("it", grid, pose);
      break;
    }
  }
  return builder.build();
}

/// Rays of all kinds around an object of about unit size at `pose`.
Ray varied_ray(RandomStream& random, const Pose& pose, int kind) {
  const Vec3 target = random_point(random, 0.8);
  Vec3 origin, direction;
  switch (kind % 4) {
    case 0:  // from outside
      origin = 3.0 * random_direction(random);
      direction = target - origin;
      break;
    case 1:  // mostly from inside
      origin = random_point(random, 0.3);
      direction = random_direction(random);
      break;
    case 2:  // along an axis of the shape
      origin = target;
      direction = Vec3::Unit(static_cast<int>(random.uniform(0.0, 3.0)));
      if (random.uniform() < 0.5) direction = -direction;
      origin -= random.uniform(0.0, 3.0) * direction;
      break;
    default:  // nearly along an axis
      direction = Vec3::Unit(static_cast<int>(random.uniform(0.0, 3.0))) +
                  std::pow(10.0, random.uniform(-12.0, -2.0)) * random_direction(random);
      origin = target - 2.0 * direction;
  }
  Ray ray = ray_from(pose * origin, pose.q * direction);
  if (random.uniform() < 0.2) ray.min_distance = random.uniform(0.0, 3.0);
  // A ray almost parallel to a plane may meet it anywhere.
  ray.max_distance = random.uniform() < 0.2 ? random.uniform(0.0, 3.0) : 1e4;
  return ray;
}

/// Rays whose answer is not within 1e-9 m of the reference; `loose` counts those of which the
/// rounding of the ray itself decides.
struct Verdict {
  int wrong = 0, loose = 0, hits = 0;
};

void judge(const World& world, const Ray& ray, Verdict& verdict) {
  const RayHit hit = world.rays.cast(ray);
  const double exact = cast(*world.model, world.poses, ray).distance;
  if (hit) ++verdict.hits;
  if (hit.distance == exact || std::abs(hit.distance - exact) <= 1e-9) return;
  ++verdict.loose;
  if (agrees(*world.model, world.poses, ray, hit.distance)) return;
  ++verdict.wrong;
  UNSCOPED_INFO("from " << ray.origin.transpose() << " along " << ray.direction.transpose() << ": "
                        << hit.distance << " instead of " << exact);
}

bool near_to(const Vec3& a, const Vec3& b, double tolerance) { return (a - b).norm() <= tolerance; }

}  // namespace

TEST_CASE("distances to every shape are exact near the origin and a kilometre away", "[rays]") {
  const ShapeType type =
      GENERATE(ShapeType::box, ShapeType::sphere, ShapeType::cylinder, ShapeType::capsule,
               ShapeType::plane, ShapeType::mesh, ShapeType::convex_mesh, ShapeType::heightmap);
  const double away = GENERATE(0.0, 1000.0);
  RandomStream random(11, to_string(type));
  Verdict any, aligned;  // rays in all directions, and along or almost along the shape's axes
  for (int scene = 0; scene < 12; ++scene) {
    Pose pose = random_pose(random, 2.0);
    if (scene == 0) pose = {};
    pose.p += away * random_direction(random);
    const World world(one(type, pose));
    for (int i = 0; i < 600; ++i)
      judge(world, varied_ray(random, pose, i), i % 4 < 2 ? any : aligned);
  }
  INFO(to_string(type) << ", " << any.hits << " and " << aligned.hits << " hits");
  CHECK(any.wrong == 0);
  CHECK(aligned.wrong == 0);
  CHECK(any.hits > 1000);
  CHECK(aligned.hits > 1000);
  // At a kilometre coordinates are rounded to 1.1e-13 m, so the answer depends on rounding below an
  // angle of some 1e-3 rad to the surface; so flat are less than 1 in 100 by chance.
  CHECK(any.loose <= any.hits / 100);
}

TEST_CASE("rays from a kilometre away hit small things exactly", "[rays]") {
  const ShapeType type = GENERATE(ShapeType::box, ShapeType::sphere, ShapeType::cylinder,
                                  ShapeType::capsule, ShapeType::mesh, ShapeType::convex_mesh);
  RandomStream random(12, to_string(type));
  const Pose pose = random_pose(random, 2.0);
  const World world(one(type, pose));
  Verdict verdict;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 target = pose * random_point(random, 0.6);
    const Vec3 direction = random_direction(random);
    judge(world, ray_from(target - 1000.0 * direction, direction), verdict);
  }
  CHECK(verdict.wrong == 0);
  CHECK(verdict.hits > 1000);
  CHECK(verdict.loose <= verdict.hits / 100);
}

TEST_CASE("tangent rays answer as one of their neighbours does", "[rays]") {
  const ShapeType type = GENERATE(ShapeType::sphere, ShapeType::cylinder, ShapeType::capsule);
  RandomStream random(13, to_string(type));
  const Pose pose = random_pose(random, 2.0);
  const World world(one(type, pose));
  const Shape& shape = world.model->bodies[0].shapes[0];
  Verdict verdict;
  for (int i = 0; i < 1000; ++i) {
    const double turn = random.uniform(0.0, 6.283185307179586);
    const Vec3 normal(std::cos(turn), std::sin(turn), 0.0);
    const Vec3 along = normal.cross(random_direction(random)).normalized();
    const double off = i % 3 == 0 ? 0.0 : std::pow(10.0, random.uniform(-12.0, -3.0));
    const Vec3 point = (shape.radius + (i % 2 == 0 ? off : -off)) * normal;
    judge(world, ray_from(pose * (point - 2.0 * along), pose.q * along), verdict);
  }
  CHECK(verdict.wrong == 0);
  CHECK(verdict.hits > 300);
}

TEST_CASE("a thousand mixed bodies: no wrong answer", "[rays]") {
  const bool meshes = GENERATE(false, true);
  const double away = GENERATE(0.0, 1000.0);
  const Vec3 middle = away * Vec3(0.6, -0.64, 0.48);
  const World world(mixed_bodies(1000, 8.0, middle, 7, meshes));
  RandomStream random(8, "rays");
  Verdict verdict;
  for (int i = 0; i < 1500; ++i) {
    const Vec3 origin = middle + random_point(random, 9.0);
    judge(world, ray_from(origin, random_direction(random)), verdict);
  }
  CHECK(verdict.wrong == 0);
  CHECK(verdict.hits > 700);
  CHECK(verdict.loose <= 5);
}

TEST_CASE("a hit says what was hit, where, and from which side", "[rays]") {
  RandomStream random(14, "hits");
  const ShapeType type =
      GENERATE(ShapeType::box, ShapeType::sphere, ShapeType::cylinder, ShapeType::capsule,
               ShapeType::plane, ShapeType::mesh, ShapeType::heightmap);
  const Pose pose = random_pose(random, 2.0);
  const World world(one(type, pose));
  int inside = 0, outside = 0;
  for (int i = 0; i < 1500; ++i) {
    const Ray ray = varied_ray(random, pose, i % 2);
    const RayHit hit = world.rays.cast(ray);
    if (!hit) continue;
    CHECK(hit.body == 0);
    CHECK(hit.shape == 0);
    CHECK((hit.triangle >= 0) == (type == ShapeType::mesh || type == ShapeType::heightmap));
    CHECK(near_to(hit.point, ray.origin + hit.distance * ray.direction, 1e-12));
    CHECK(std::abs(hit.normal.norm() - 1.0) < 1e-12);
    CHECK(hit.normal.dot(ray.direction) <= 0.0);
    // The normal is where the surface turns: a second ray, moved by h along a tangent, is met
    // h tan(slope) sooner or later; curvature adds h^2 / 2r.
    const Vec3 tangent = hit.normal.cross(ray.direction);
    if (tangent.norm() > 0.1 && -hit.normal.dot(ray.direction) > 0.1) {
      const double h = 1e-6;
      Ray beside = ray;
      const Vec3 sideways = (ray.direction.cross(tangent)).normalized();
      beside.origin += h * sideways;
      const RayHit there = world.rays.cast(beside);
      if (there && there.triangle == hit.triangle && (there.normal - hit.normal).norm() < 1e-3) {
        const double expected = -h * sideways.dot(hit.normal) / ray.direction.dot(hit.normal);
        CHECK(std::abs(there.distance - hit.distance - expected) < 1e-8);
      }
    }
    (hit.inside ? inside : outside)++;
  }
  CHECK(inside > 10);
  CHECK(outside > 10);
}

TEST_CASE("rays hit solids from inside, and the exit is reported", "[rays]") {
  ModelBuilder builder;
  builder.cylinder("can", 0.5, 2.0, 1.0, {});
  const World world(builder.build());
  const auto check = [&](const Vec3& origin, const Vec3& direction, double distance,
                         const Vec3& normal, bool inside) {
    const RayHit hit = world.rays.cast(ray_from(origin, direction));
    CHECK(hit.distance == Approx(distance).margin(1e-12));
    CHECK(near_to(hit.normal, normal, 1e-12));
    CHECK(hit.inside == inside);
  };
  check({0.2, 0, 0}, {1, 0, 0}, 0.3, {-1, 0, 0}, true);
  check({0.2, 0, 0}, {0, 0, 1}, 1.0, {0, 0, -1}, true);
  check({0.2, 0, 5}, {0, 0, -1}, 4.0, {0, 0, 1}, false);
  check({2.0, 0, 0.5}, {-1, 0, 0}, 1.5, {1, 0, 0}, false);
  // Along the wall itself: closed, so its rim is met.
  check({0.5, 0, 5}, {0, 0, -1}, 4.0, {0, 0, 1}, false);
  // Just beside it.
  CHECK_FALSE(world.rays.cast(ray_from({0.5 + 1e-12, 0, 5}, {0, 0, -1})));
  // From the surface: leaving it is nothing, entering it is a hit at no distance.
  CHECK(world.rays.cast(ray_from({0, 0, 1}, {0, 0, -1})).distance == 0.0);
  CHECK(world.rays.cast(ray_from({0, 0, 1}, {0, 0, 1})).distance == 0.0);
  Ray later = ray_from({0, 0, 1}, {0, 0, 1});
  later.min_distance = 1e-9;
  CHECK_FALSE(world.rays.cast(later));
}

TEST_CASE("a ray in the face of a box meets its edge, one in a plane meets nothing", "[rays]") {
  ModelBuilder builder;
  builder.box("box", {2, 2, 2}, 1.0, {});
  builder.plane("floor", {Vec3(0, 0, -1), Quat(1, 0, 0, 0)});
  const World world(builder.build());
  const RayHit face = world.rays.cast(ray_from({-3, 0, 1}, {1, 0, 0}));
  CHECK(face.body == 0);
  CHECK(face.distance == Approx(2.0).margin(1e-15));
  const RayHit edge = world.rays.cast(ray_from({-3, 1, 1}, {1, 0, 0}));
  CHECK(edge.distance == Approx(2.0).margin(1e-15));
  const RayHit corner = world.rays.cast(ray_from({-3, -1, 3}, {1, 1, -1}));
  CHECK(corner.distance == Approx(2.0 * std::sqrt(3.0)).margin(1e-12));
  CHECK_FALSE(world.rays.cast(ray_from({-3, 0, 1 + 1e-12}, {1, 0, 0})));
  CHECK_FALSE(world.rays.cast(ray_from({-3, 5, -1}, {1, 0, 0})));
  const RayHit below = world.rays.cast(ray_from({5, 5, -3}, {0, 0, 1}));
  CHECK(below.body == 1);
  CHECK(below.distance == 2.0);
  CHECK(below.inside);
  CHECK(near_to(below.normal, {0, 0, -1}, 1e-15));
}

TEST_CASE("no ray gets through between the triangles of a mesh", "[rays]") {
  // Through the corners and along the edges of an octahedron and of a flat heightmap.
  RandomStream random(15, "edges");
  ModelBuilder builder;
  const Pose pose = random_pose(random, 1.0);
  builder.mesh("stone", octahedron(1.0), true, 1.0, pose);
  const World world(builder.build());
  const TriangleMesh& mesh = *world.model->meshes[0];
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i % 8];
    const Vec3& a = mesh.vertices[t[i / 8 % 3]];
    const Vec3& b = mesh.vertices[t[(i / 8 + 1) % 3]];
    const double part = i % 5 == 0 ? 0.0 : random.uniform();
    const Vec3 target = pose * Vec3(a + part * (b - a));
    const RayHit hit = world.rays.cast(ray_from(pose.p, target - pose.p));
    REQUIRE(hit);
    REQUIRE(hit.distance == Approx((target - pose.p).norm()).margin(1e-12));
    REQUIRE(hit.inside);
  }
}

TEST_CASE("only rays between their limits hit", "[rays]") {
  ModelBuilder builder;
  builder.sphere("near", 1.0, 1.0, {Vec3(5, 0, 0), Quat(1, 0, 0, 0)});
  builder.sphere("far", 1.0, 1.0, {Vec3(10, 0, 0), Quat(1, 0, 0, 0)});
  const World world(builder.build());
  Ray ray;
  const auto distance = [&](double low, double high) {
    ray.min_distance = low;
    ray.max_distance = high;
    return world.rays.cast(ray).distance;
  };
  CHECK(distance(0.0, kInfinite) == 4.0);
  CHECK(distance(4.0, 4.0) == 4.0);
  CHECK(distance(4.5, kInfinite) == 6.0);
  CHECK(distance(6.5, kInfinite) == 9.0);
  CHECK(distance(0.0, 3.999) == kInfinite);
  CHECK(distance(6.5, 8.999) == kInfinite);
  CHECK(distance(12.0, kInfinite) == kInfinite);
  CHECK(distance(-3.0, kInfinite) == 4.0);
  CHECK(distance(5.0, 1.0) == kInfinite);
  // Not behind the start
  ray.origin = Vec3(20, 0, 0);
  CHECK(distance(0.0, kInfinite) == kInfinite);
}

TEST_CASE("excluded bodies are transparent", "[rays]") {
  ModelBuilder builder;
  for (int i = 0; i < 4; ++i)
    builder.box("box_" + std::to_string(i), {1, 1, 1}, 1.0,
                {Vec3(3.0 * (i + 1), 0, 0), Quat(1, 0, 0, 0)});
  builder.plane("wall", {Vec3(1, 0, 0), z_to(Vec3(-1, 0, 0))});
  const World world(builder.build());
  const Ray ray;
  CHECK(world.rays.cast(ray).body == 4);
  CHECK(world.rays.cast(ray, {4}).body == 0);
  CHECK(world.rays.cast(ray, {0, 4}).body == 1);
  CHECK(world.rays.cast(ray, {0, 1, 2, 4}).body == 3);
  CHECK_FALSE(world.rays.cast(ray, {0, 1, 2, 3, 4}));
  std::vector<RayHit> hits;
  world.rays.cast({ray, ray_from({4.5, 0, 0}, {-1, 0, 0})}, hits, {0, 4});
  REQUIRE(hits.size() == 2);
  CHECK(hits[0].body == 1);
  CHECK_FALSE(hits[1]);
}

TEST_CASE("what cannot be a ray hits nothing", "[rays]") {
  ModelBuilder builder;
  builder.plane("floor");
  builder.box("box", {100, 100, 1}, 1.0, {});
  const World world(builder.build());
  const double nan = std::nan("");
  CHECK_FALSE(world.rays.cast({Vec3(0, 0, 5), Vec3(0, 0, 0)}));
  CHECK_FALSE(world.rays.cast({Vec3(0, 0, 5), Vec3(0, nan, -1)}));
  CHECK_FALSE(world.rays.cast({Vec3(nan, 0, 5), Vec3(0, 0, -1)}));
  CHECK_FALSE(world.rays.cast({Vec3(0, 0, kInfinite), Vec3(0, 0, -1)}));
  CHECK_FALSE(world.rays.cast({Vec3(0, 0, 5), Vec3(0, 0, -kInfinite)}));
  CHECK_FALSE(world.rays.cast({Vec3(0, 0, 5), Vec3(0, 0, -1), nan}));
  CHECK_FALSE(world.rays.cast({Vec3(0, 0, 5), Vec3(0, 0, -1), 0.0, nan}));
  // Any other length is brought to one.
  CHECK(world.rays.cast({Vec3(0, 0, 5), Vec3(0, 0, -7e-3)}).distance == 4.5);
  CHECK(world.rays.cast({Vec3(0, 0, 5), Vec3(0, 0, -7e9)}).distance == 4.5);
  const RayCaster empty;
  CHECK_FALSE(empty.cast(Ray{}));
  RayCaster without;
  without.update(nullptr, {});
  CHECK_FALSE(without.cast(Ray{}));
}

TEST_CASE("answers follow moving bodies", "[rays]") {
  World world(mixed_bodies(150, 6.0, Vec3::Zero(), 21, true));
  RandomStream random(22, "moves");
  for (int round = 0; round < 120; ++round) {
    // Some move, some stay; sometimes one is set far away, to NaN, or back.
    for (std::size_t b = 0; b < world.poses.size(); ++b) {
      if (b % 3 == 0) continue;
      Pose& pose = world.poses[b];
      pose.p += random_point(random, 0.3);
      const Pose turn = random_pose(random, 0.0);
      pose.q = (pose.q * turn.q).normalized();
    }
    const auto one_of = static_cast<std::size_t>(random.uniform(0.0, 149.9));
    if (round % 10 == 3) world.poses[one_of].p = Vec3(2e6, 0, 1e6);
    if (round % 10 == 7) world.poses[one_of] = random_pose(random, 6.0);
    world.rays.update(world.model, world.poses);
    Verdict verdict;
    for (int i = 0; i < 40; ++i)
      judge(world, ray_from(random_point(random, 7.0), random_direction(random)), verdict);
    REQUIRE(verdict.wrong == 0);
  }
}

TEST_CASE("a body without a valid pose is not hit", "[rays]") {
  ModelBuilder builder;
  builder.box("a", {1, 1, 1}, 1.0, {Vec3(3, 0, 0), Quat(1, 0, 0, 0)});
  builder.box("b", {1, 1, 1}, 1.0, {Vec3(6, 0, 0), Quat(1, 0, 0, 0)});
  World world(builder.build());
  CHECK(world.rays.cast(Ray{}).body == 0);
  const Pose before = world.poses[0];
  world.poses[0].p.x() = std::nan("");
  world.rays.update(world.model, world.poses);
  CHECK(world.rays.cast(Ray{}).body == 1);
  world.poses[0] = before;
  world.poses[1].q.coeffs().setZero();
  world.rays.update(world.model, world.poses);
  CHECK(world.rays.cast(Ray{}).body == 0);
  CHECK_FALSE(world.rays.cast(Ray{}, {0}));
  RayCaster fresh;
  fresh.update(world.model, {before});
  CHECK(fresh.cast(Ray{}).body == 0);
  CHECK_FALSE(fresh.cast(Ray{}, {0}));
}

TEST_CASE("bodies come and go with the model", "[rays]") {
  const SceneModelPtr first = mixed_bodies(60, 4.0, Vec3::Zero(), 31, true);
  World world(first);
  RandomStream random(32, "rays");
  const auto right = [&] {
    Verdict verdict;
    for (int i = 0; i < 300; ++i)
      judge(world, ray_from(random_point(random, 5.0), random_direction(random)), verdict);
    INFO(verdict.hits << " hits");
    CHECK(verdict.hits > 30);
    return verdict.wrong == 0;
  };
  CHECK(right());
  auto fewer = std::make_shared<SceneModel>(*first);
  for (std::size_t b = 0; b < fewer->bodies.size(); b += 3) fewer->bodies[b].removed = true;
  world.model = fewer;
  world.rays.update(world.model, world.poses);
  CHECK(right());
  auto more = std::make_shared<SceneModel>(*fewer);
  const SceneModelPtr others = mixed_bodies(30, 4.0, Vec3::Zero(), 33, true);
  for (Body body : others->bodies) {
    for (Shape& shape : body.shapes)
      if (shape.mesh >= 0) shape.mesh += static_cast<int>(first->meshes.size());
    more->bodies.push_back(body);
  }
  more->meshes.insert(more->meshes.end(), others->meshes.begin(), others->meshes.end());
  world.model = more;
  world.poses = poses_of(*more);
  world.rays.update(world.model, world.poses);
  CHECK(right());
  // Another scene, whose meshes have the same indices and other triangles
  world.model = mixed_bodies(48, 4.0, Vec3::Zero(), 34, true);
  world.poses = poses_of(*world.model);
  world.rays.update(world.model, world.poses);
  CHECK(right());
}

TEST_CASE("visible and colliding shapes are distinguished", "[rays]") {
  ModelBuilder builder;
  const int ghost = builder.box("ghost", {1, 1, 1}, 1.0, {Vec3(3, 0, 0), Quat(1, 0, 0, 0)});
  const int glass = builder.box("glass", {1, 1, 1}, 1.0, {Vec3(6, 0, 0), Quat(1, 0, 0, 0)});
  const int wall = builder.box("wall", {1, 1, 1}, 1.0, {Vec3(9, 0, 0), Quat(1, 0, 0, 0)});
  const int idea = builder.box("idea", {1, 1, 1}, 1.0, {Vec3(1.5, 0, 0), Quat(1, 0, 0, 0)});
  const auto shape = [&](int body) -> Shape& { return builder.model.bodies[body].shapes[0]; };
  shape(ghost).collides = false;
  shape(glass).visible = false;
  shape(idea).visible = shape(idea).collides = false;
  World world(builder.build());
  CHECK(world.rays.cast(Ray{}).body == ghost);
  CHECK(world.rays.cast(Ray{}, {ghost}).body == wall);
  world.rays.update(world.model, world.poses, RayTargets::colliding);
  CHECK(world.rays.cast(Ray{}).body == glass);
  world.rays.update(world.model, world.poses, RayTargets::any);
  CHECK(world.rays.cast(Ray{}).body == ghost);
  CHECK(world.rays.cast(Ray{}, {ghost}).body == glass);
}

TEST_CASE("a convex mesh is seen as its triangles and touched as its hull", "[rays]") {
  ModelBuilder builder;
  builder.mesh("tyre", ring(1.0, 0.25), true, 1.0, {});
  World world(builder.build());
  const Ray through = ray_from({0.1, 0.2, 5}, {0, 0, -1});
  CHECK_FALSE(world.rays.cast(through));
  world.rays.update(world.model, world.poses, RayTargets::colliding);
  const RayHit hit = world.rays.cast(through);
  // The ring's height is its thickness exactly: one of its eight corners across is on top.
  CHECK(hit.distance == Approx(4.75).margin(1e-12));
  CHECK(near_to(hit.normal, {0, 0, 1}, 1e-12));
  CHECK(hit.triangle == -1);
  CHECK_FALSE(hit.inside);
  // From inside the exit is the hull's surface: at half a facet's turn, cos(pi/16) of the rim.
  const double turn = 3.14159265358979323846 / 16;
  const RayHit out = world.rays.cast(ray_from(Vec3::Zero(), {std::cos(turn), std::sin(turn), 0}));
  CHECK(out.distance == Approx(1.25 * std::cos(turn)).margin(1e-9));
  CHECK(out.inside);
}

TEST_CASE("of surfaces at the same distance the first in the model is hit", "[rays]") {
  ModelBuilder builder;
  for (int i = 0; i < 40; ++i) builder.box("box_" + std::to_string(i), {1, 1, 1}, 1.0, {});
  builder.plane("floor", {Vec3(0, 0, 0.5), Quat(1, 0, 0, 0)});
  const World world(builder.build());
  CHECK(world.rays.cast(ray_from({0.1, 0.2, 3}, {0, 0, -1})).body == 0);
  CHECK(world.rays.cast(ray_from({0.1, 0.2, 3}, {0, 0, -1}), {0, 1, 2}).body == 3);
}

TEST_CASE("several threads cast at once", "[rays]") {
  const World world(mixed_bodies(200, 6.0, Vec3::Zero(), 41, true));
  std::vector<Ray> rays;
  RandomStream random(42, "rays");
  for (int i = 0; i < 2000; ++i)
    rays.push_back(ray_from(random_point(random, 7.0), random_direction(random)));
  std::vector<RayHit> alone;
  world.rays.cast(rays, alone);
  std::vector<std::vector<RayHit>> together(4);
  std::vector<std::thread> threads;
  for (auto& hits : together) threads.emplace_back([&] { world.rays.cast(rays, hits); });
  for (auto& thread : threads) thread.join();
  for (const auto& hits : together) {
    REQUIRE(hits.size() == alone.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      REQUIRE(hits[i].distance == alone[i].distance);
      REQUIRE(hits[i].body == alone[i].body);
    }
  }
}
