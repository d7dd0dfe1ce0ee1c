#include "scene.h"

#include <cmath>
#include <limits>

namespace cogrsim::bench {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Numbers in [-1, 1) that are the same everywhere (the generator of Numerical Recipes).
class Noise {
 public:
  double next() {
    state_ = state_ * 1664525u + 1013904223u;
    return static_cast<double>(state_ >> 8) / 8388608.0 - 1.0;
  }

 private:
  unsigned state_ = 1;
};

Triple box_moments(double mass, const Triple& e) {
  return {mass / 12 * (e[1] * e[1] + e[2] * e[2]), mass / 12 * (e[0] * e[0] + e[2] * e[2]),
          mass / 12 * (e[0] * e[0] + e[1] * e[1])};
}

Thing box(const Triple& edges, double mass, const Triple& place, double friction) {
  Thing thing;
  thing.mass = mass;
  thing.moments = box_moments(mass, edges);
  thing.place = place;
  thing.friction = friction;
  thing.parts.push_back({Form::box, edges, {}});
  return thing;
}

Thing floor_plane(double friction) {
  Thing thing;
  thing.friction = friction;
  thing.parts.push_back({Form::plane, {}, {}});
  return thing;
}

/// A turn by `angle` about x, y or z (axis 0, 1, 2).
Turn turn_about(int axis, double angle) {
  Turn turn{std::cos(angle / 2), 0, 0, 0};
  turn[static_cast<std::size_t>(axis) + 1] = std::sin(angle / 2);
  return turn;
}

/// Six layers of six times six, every other layer shifted, fall into a bin that is a little wider.
void add_spheres(Scene& scene) {
  constexpr double kRadius = 0.1, kMass = 10.0, kFriction = 0.5;
  constexpr double kPitch = 2.1 * kRadius, kInner = 6.6 * 2 * kRadius, kWall = 0.4, kTall = 2.0;
  scene.things.push_back(floor_plane(kFriction));
  const double wall = (kInner + kWall) / 2, length = kInner + 2 * kWall;
  for (const double side : {-1.0, 1.0}) {
    scene.things.push_back(
        box({kWall, length, kTall}, 0.0, {side * wall, 0, kTall / 2}, kFriction));
    scene.things.push_back(
        box({length, kWall, kTall}, 0.0, {0, side * wall, kTall / 2}, kFriction));
  }
  for (int layer = 0; layer < 6; ++layer) {
    const double shift = layer % 2 == 0 ? -0.02 : 0.02;
    for (int i = 0; i < 36; ++i) {
      Thing ball;
      ball.mass = kMass;
      const double moment = 0.4 * kMass * kRadius * kRadius;
      ball.moments = {moment, moment, moment};
      ball.place = {(i % 6 - 2.5) * kPitch + shift, (i / 6 - 2.5) * kPitch - shift,
                    kRadius * (1.05 + 2.1 * layer)};
      ball.friction = kFriction;
      ball.parts.push_back({Form::sphere, {kRadius, 0, 0}, {}});
      scene.things.push_back(ball);
    }
  }
  scene.warm_up = 1000;
  scene.check_text = "mean height of the spheres [m]";
  scene.expected = kNan;
  scene.within = 0.03;
  scene.why_expected = "no closed form for a heap: the median of all engines";
}

void add_pyramid(Scene& scene) {
  constexpr int kBase = 20;
  constexpr double kSize = 0.5, kPitch = 0.55, kFriction = 0.6;
  scene.things.push_back(box({100, 100, 2}, 0.0, {0, 0, -1}, kFriction));
  double sum = 0;
  int count = 0;
  for (int row = 0; row < kBase; ++row) {
    for (int i = 0; i < kBase - row; ++i) {
      const double height = (row + 0.5) * kSize;
      scene.things.push_back(box({kSize, kSize, kSize}, 1.0,
                                 {(i - 0.5 * (kBase - row - 1)) * kPitch, 0, height}, kFriction));
      sum += height;
      ++count;
    }
  }
  scene.check_text = "mean height of the boxes [m]";
  scene.expected = sum / count;
  scene.within = 0.01;
  scene.why_expected = "it stands: the heights at the start";
}

/// Layers of 15 x 20, a little askew, fall and heap up.
void add_falling_boxes(Scene& scene, int count) {
  constexpr double kSize = 0.2, kPitch = 0.3, kFriction = 0.6;
  constexpr int kColumns = 15, kRows = 20;
  Noise noise;
  scene.things.push_back(floor_plane(kFriction));
  for (int i = 0; i < count; ++i) {
    const int layer = i / (kColumns * kRows), place = i % (kColumns * kRows);
    Thing thing = box({kSize, kSize, kSize}, 1.0,
                      {(place % kColumns) * kPitch + 0.05 * noise.next(),
                       (place / kColumns) * kPitch + 0.05 * noise.next(), 0.15 + layer * 0.25},
                      kFriction);
    thing.turn = turn_about(2, 0.3 * noise.next());
    scene.things.push_back(thing);
  }
  scene.warm_up = 300;
  scene.round = 20;
  scene.check_text = "mean height of the boxes [m]";
  scene.expected = kNan;
  scene.within = 0.03;
  scene.why_expected = "no closed form for a heap: the median of all engines";
}

void add_chain(Scene& scene, int links) {
  constexpr double kLength = 0.2, kWidth = 0.04, kTilt = 1.0;
  const Triple along{-std::sin(kTilt), 0, -std::cos(kTilt)};
  for (int i = 0; i < links; ++i) {
    const double middle = kLength * (i + 0.5), start = kLength * i;
    Thing link = box({kWidth, kWidth, kLength}, 1.0, {middle * along[0], 0, middle * along[2]}, 0);
    link.turn = turn_about(1, kTilt);
    scene.things.push_back(link);
    Hinge hinge;
    hinge.parent = i - 1;
    hinge.child = i;
    hinge.anchor = {start * along[0], 0, start * along[2]};
    hinge.axis = {0, 1, 0};
    scene.hinges.push_back(hinge);
  }
  scene.contact = false;
  scene.check = Check::last_height;
  scene.check_text = "height of the last link's middle after 0.3 s [m]";
  scene.expected = kNan;
  scene.within = 0.005;
  scene.why_expected = "the median of all engines";
}

/// Two wheels, a slick caster behind; drives a curve. `eyes`: two infrared sensors that look ahead.
void add_robots(Scene& scene, int count, bool eyes) {
  constexpr double kSpacing = 1.0, kChassisMass = 1.2, kHeight = 0.05;
  constexpr double kWheelRadius = 0.04, kWheelWidth = 0.02, kWheelMass = 0.15;
  constexpr double kAxleX = 0.05, kHalfTrack = 0.082, kCasterX = -0.09, kCasterRadius = 0.02;
  constexpr double kLeft = 5.0, kRight = 4.0;
  const Triple chassis_edges{0.24, 0.14, 0.04};
  const int per_side = static_cast<int>(std::ceil(std::sqrt(count)));
  scene.things.push_back(floor_plane(1.0));
  for (int i = 0; i < count; ++i) {
    const double x = (i / per_side) * kSpacing, y = (i % per_side) * kSpacing;
    const int chassis = static_cast<int>(scene.things.size());
    Thing body = box(chassis_edges, kChassisMass, {x, y, kHeight}, 0.0);
    body.family = i;
    body.parts.push_back(
        {Form::sphere, {kCasterRadius, 0, 0}, {kCasterX, 0, kCasterRadius - kHeight}});
    scene.things.push_back(body);
    for (const int side : {1, -1}) {
      Thing wheel;
      wheel.mass = kWheelMass;
      const double across =
          kWheelMass * (3 * kWheelRadius * kWheelRadius + kWheelWidth * kWheelWidth) / 12;
      wheel.moments = {across, across, kWheelMass * kWheelRadius * kWheelRadius / 2};
      wheel.place = {x + kAxleX, y + side * kHalfTrack, kWheelRadius};
      wheel.turn = turn_about(0, -std::acos(-1.0) / 2);  // its own z points along +y
      wheel.friction = 0.64;                             // with the floor's 1: 0.8
      wheel.family = i;
      wheel.parts.push_back({Form::cylinder, {kWheelRadius, kWheelWidth, 0}, {}});
      Hinge axle;
      axle.parent = chassis;
      axle.child = static_cast<int>(scene.things.size());
      axle.anchor = wheel.place;
      axle.axis = {0, 1, 0};
      axle.driven = true;
      axle.speed = side > 0 ? kLeft : kRight;
      axle.max_torque = 0.6;
      scene.things.push_back(wheel);
      scene.hinges.push_back(axle);
    }
    if (!eyes) continue;
    for (const int side : {1, -1}) {
      const double angle = side * 0.35;
      scene.eyes.push_back(
          {chassis, {0.12, side * 0.05, 0.01}, {std::cos(angle), std::sin(angle), 0}});
    }
  }
  scene.warm_up = 500;
  scene.check = Check::drive;
  scene.check_text = "mean distance driven in 0.5 s [m]";
  // An arc of radius v/w: its chord after t is 2 v/w sin(w t/2). Measured at the chassis' middle,
  // which lies kAxleX behind the axle: sqrt(c^2 + (2 kAxleX sin(w t/2))^2) with the angle between
  // them left out, below 0.1 mm here.
  const double t = 0.5, v = kWheelRadius * (kLeft + kRight) / 2,
               w = kWheelRadius * (kRight - kLeft) / (2 * kHalfTrack);
  scene.expected = std::abs(2 * v / w * std::sin(w * t / 2));
  scene.within = 0.06;
  scene.why_expected = "wheels that roll: the chord of the arc; pulling away takes part of it";
}

/// Boxes that lie on the floor in a grid.
void add_grid(Scene& scene, int count) {
  constexpr double kSize = 0.2, kPitch = 0.5, kFriction = 0.6;
  const int per_side = static_cast<int>(std::ceil(std::sqrt(count)));
  scene.things.push_back(floor_plane(kFriction));
  for (int i = 0; i < count; ++i) {
    scene.things.push_back(box({kSize, kSize, kSize}, 1.0,
                               {(i / per_side) * kPitch, (i % per_side) * kPitch, kSize / 2},
                               kFriction));
  }
  scene.warm_up = 50;
  scene.round = 20;
  scene.check_text = "mean height of the boxes [m]";
  scene.expected = kSize / 2;
  scene.within = 0.02;
  scene.why_expected = "they lie: half an edge";
}

void add_stack(Scene& scene, int count) {
  constexpr double kSize = 0.2, kFriction = 0.6;
  scene.things.push_back(floor_plane(kFriction));
  for (int i = 0; i < count; ++i) {
    scene.things.push_back(box({kSize, kSize, kSize}, 1.0, {0, 0, (i + 0.5) * kSize}, kFriction));
  }
  scene.warm_up = 30;
  scene.round = 30;
  scene.check_text = "mean height of the boxes [m]";
  scene.expected = count * kSize / 2;
  scene.within = 0.02;
  scene.why_expected = "it stands: the heights at the start";
}

void add_tumbling(Scene& scene) {
  Thing thing = box({0.2, 0.4, 0.6}, 1.0, {0, 0, 0}, 0.0);
  thing.spin = {1.0, 3.0, 1.0};
  scene.things.push_back(thing);
  scene.gravity = {0, 0, 0};
  scene.contact = false;
  scene.warm_up = 1000;
  scene.check = Check::turned;
  scene.check_text = "where the box has turned its long axis after 1 s, height [1]";
  scene.expected = kNan;
  scene.within = 0.05;
  scene.why_expected = "the median of all engines";
}

/// A box slides over the floor at `angle` to the axes [rad].
void add_sliding(Scene& scene, double angle) {
  constexpr double kSize = 0.2, kSpeed = 2.0;
  scene.things.push_back(floor_plane(0.5));
  Thing thing = box({kSize, kSize, kSize / 2}, 1.0, {0, 0, kSize / 4}, 0.5);
  thing.velocity = {kSpeed * std::cos(angle), kSpeed * std::sin(angle), 0};
  scene.things.push_back(thing);
}

void add_bouncing(Scene& scene) {
  scene.things.push_back(floor_plane(0.5));
  scene.things.front().restitution = 0.5;
  Thing ball;
  ball.mass = 1.0;
  ball.moments = {4e-3, 4e-3, 4e-3};
  ball.place = {0, 0, 1.1};
  ball.friction = ball.restitution = 0.5;
  ball.parts.push_back({Form::sphere, {0.1, 0, 0}, {}});
  scene.things.push_back(ball);
}

/// A ring of capsules, joined end to end by hinges along the ring's axis, falls upright on the floor.
void add_ring(Scene& scene, int count) {
  constexpr double kRadius = 0.03, kLength = 0.2, kMass = 0.5, kFriction = 0.5;
  const double turn = 2 * std::acos(-1.0) / count;
  // Of the middles; a corner, where two capsules meet, is farther out.
  const double middle = kLength / 2 / std::tan(turn / 2), corner = kLength / 2 / std::sin(turn / 2);
  const double centre = corner + kRadius + 0.2;
  scene.things.push_back(floor_plane(kFriction));
  for (int i = 0; i < count; ++i) {
    const double angle = turn * i;
    Thing link;
    link.mass = kMass;
    const double across = kMass * kLength * kLength / 12;
    link.moments = {across, across, kMass * kRadius * kRadius / 2};
    link.place = {middle * std::cos(angle), 0, centre + middle * std::sin(angle)};
    link.turn = turn_about(1, -angle);  // its own z is the tangent
    link.friction = kFriction;
    link.family = 0;
    link.parts.push_back({Form::capsule, {kRadius, kLength, 0}, {}});
    scene.things.push_back(link);
  }
  for (int i = 0; i < count; ++i) {
    const double angle = turn * (i + 0.5);
    Hinge hinge;
    hinge.parent = i + 1;
    hinge.child = (i + 1) % count + 1;
    hinge.anchor = {corner * std::cos(angle), 0, centre + corner * std::sin(angle)};
    hinge.axis = {0, 1, 0};
    scene.hinges.push_back(hinge);
  }
}

void add_heavy_on_light(Scene& scene) {
  constexpr double kSize = 0.2, kFriction = 0.6;
  scene.things.push_back(floor_plane(kFriction));
  scene.things.push_back(box({kSize, kSize, kSize}, 1.0, {0, 0, 0.5 * kSize}, kFriction));
  scene.things.push_back(box({kSize, kSize, kSize}, 300.0, {0, 0, 1.5 * kSize}, kFriction));
}

/// The height of the end of the body's own z axis.
double height_of_z(const Turn& q) { return 1 - 2 * (q[1] * q[1] + q[2] * q[2]); }

}  // namespace

const std::vector<SceneInfo>& scene_list() {
  static const std::vector<SceneInfo> list = {
      {"spheres", "6 x 6 x 6 spheres of 10 kg fall into a bin", 216},
      {"pyramid", "a wall of 210 boxes in the form of a pyramid", 210},
      {"falling-boxes", "boxes fall and heap up", 3000},
      {"chain", "links on hinges, without contact", 30},
      {"robots", "robots on two driven wheels and a caster", 100},
      {"robots-infrared", "the same with two infrared sensors each, read every 10 ms", 100},
      {"tumbling", "a box without forces", 1},
      {"stack", "boxes on top of each other", 5},
      {"grid", "boxes that lie on the floor", 200},
  };
  return list;
}

const std::vector<FaithfulScene>& faithful_list() {
  static const std::vector<FaithfulScene> list = {
      {"tumbling", "a box without forces", 10000},
      {"slide-0", "a box slides along x", 1000},
      {"slide-22", "a box slides at 22.5 degrees to x", 1000},
      {"slide-45", "a box slides at 45 degrees to x", 1000},
      {"bounce", "a ball falls 1 m, restitution 0.5", 3000},
      {"stack-10", "ten boxes on top of each other", 2000},
      {"spheres", "6 x 6 x 6 spheres of 10 kg fall into a bin", 400},
      {"chain", "30 links on hinges, without contact", 2000},
      {"double-pendulum", "two links on hinges", 3000},
      {"ring", "a ring of 20 hinged capsules falls on the floor", 2000},
      {"heavy", "300 kg on 1 kg", 2000},
      {"robot", "a robot on two driven wheels and a caster drives an arc", 3000},
  };
  return list;
}

Scene make_scene(const std::string& name, int count) {
  Scene scene;
  for (const SceneInfo& info : scene_list()) {
    if (info.name == name && count <= 0) count = info.count;
  }
  const std::string number = std::to_string(count);
  if (name == "spheres") {
    scene.title = "6x6x6 spheres";
    add_spheres(scene);
  } else if (name == "pyramid") {
    scene.title = "210-box pyramid";
    add_pyramid(scene);
  } else if (name == "falling-boxes") {
    scene.title = number + " falling boxes";
    add_falling_boxes(scene, count);
  } else if (name == "chain") {
    scene.title = number + "-link chain";
    add_chain(scene, count);
  } else if (name == "robots" || name == "robots-infrared") {
    const bool eyes = name == "robots-infrared";
    scene.title = number + (eyes ? " robots, infrared" : " two-wheel robots");
    add_robots(scene, count, eyes);
  } else if (name == "tumbling") {
    scene.title = "tumbling box";
    add_tumbling(scene);
  } else if (name == "stack") {
    scene.title = "stack of " + number + " boxes";
    add_stack(scene, count);
  } else if (name == "grid") {
    scene.title = number + " boxes on the floor";
    add_grid(scene, count);
  } else if (name == "slide-0") {
    scene.title = "sliding box";
    add_sliding(scene, 0);
  } else if (name == "slide-22") {
    scene.title = "box sliding at 22.5 degrees";
    add_sliding(scene, std::acos(-1.0) / 8);
  } else if (name == "slide-45") {
    scene.title = "box sliding at 45 degrees";
    add_sliding(scene, std::acos(-1.0) / 4);
  } else if (name == "bounce") {
    scene.title = "bouncing ball";
    add_bouncing(scene);
  } else if (name == "stack-10") {
    scene.title = "stack of 10 boxes";
    add_stack(scene, 10);
  } else if (name == "double-pendulum") {
    scene.title = "double pendulum";
    add_chain(scene, 2);
  } else if (name == "ring") {
    scene.title = "ring of 20 capsules";
    add_ring(scene, 20);
  } else if (name == "heavy") {
    scene.title = "300 kg on 1 kg";
    add_heavy_on_light(scene);
  } else if (name == "robot") {
    scene.title = "two-wheel robot";
    add_robots(scene, 1, false);
  } else {
    return scene;
  }
  scene.name = name;
  return scene;
}

double check_value(const Scene& scene, const std::vector<ThingState>& states) {
  if (scene.check == Check::turned) return height_of_z(states.back().turn);
  if (scene.check == Check::last_height) return states.back().place[2];
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Thing& thing = scene.things[i];
    if (thing.mass == 0) continue;
    if (scene.check == Check::mean_height) {
      sum += states[i].place[2];
      ++count;
    } else if (thing.parts.size() == 2) {  // a chassis
      sum += std::hypot(states[i].place[0] - thing.place[0], states[i].place[1] - thing.place[1]);
      ++count;
    }
  }
  return sum / count;
}

}  // namespace cogrsim::bench
