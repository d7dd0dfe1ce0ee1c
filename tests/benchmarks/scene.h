// The benchmark scenes as plain numbers, for programs on any engine: no header of the project's own
// and none of an engine's.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace cogrsim::bench {

using Triple = std::array<double, 3>;
using Turn = std::array<double, 4>;  ///< unit quaternion, w x y z

enum class Form { box, sphere, cylinder, capsule, plane };

/// A shape of a body, axes along the body's. Plane: z = 0, solid below.
struct Part {
  Form form = Form::box;
  Triple size{};  ///< [m] box: edges; sphere: radius; cylinder, capsule: radius, length (along z,
                  ///< a capsule's without its ends)
  Triple at{};    ///< centre in the body's frame [m]
};

/// The body's origin is its centre of mass, its axes are principal.
struct Thing {
  double mass = 0.0;  ///< [kg]; 0: does not move
  Triple moments{};   ///< of inertia [kg m^2]
  Triple place{};     ///< [m]
  Turn turn{1, 0, 0, 0};
  Triple velocity{};         ///< at the start [m/s]
  Triple spin{};             ///< angular velocity at the start, world axes [rad/s]
  double friction = 0.0;     ///< of a pair: sqrt(a b)
  double restitution = 0.0;  ///< of a pair: the larger one
  int family = -1;           ///< things of one family >= 0 do not touch each other
  std::vector<Part> parts;
};

/// Parents come before their children, but for hinges that close a loop, which come last.
struct Hinge {
  int parent = -1, child = -1;  ///< Scene::things; parent -1: the world
  Triple anchor{}, axis{};      ///< world, at the start
  bool driven = false;          ///< an ideal speed source with bounded torque
  double speed = 0.0;           ///< of the child against the parent about the axis [rad/s]
  double max_torque = 0.0;      ///< [N m]
};

/// An infrared: one ray that does not see the body it is mounted on.
struct Eye {
  int thing = -1;
  Triple at{}, along{1, 0, 0};  ///< in the body's frame
};

/// What a run is judged by, so that nobody is fast by doing something else.
enum class Check { mean_height, last_height, drive, turned };

struct Scene {
  std::string name, title;
  std::vector<Thing> things;
  std::vector<Hinge> hinges;
  std::vector<Eye> eyes;
  double eye_range = 2.0;       ///< [m]
  int eye_period = 10;          ///< steps between readings
  Triple gravity{0, 0, -9.81};  ///< [m/s^2]
  double step = 1e-3;           ///< [s]
  bool contact = true;
  int warm_up = 300;  ///< steps before the first round; the check is made after them
  int round = 100;    ///< steps
  Check check = Check::mean_height;
  std::string check_text;    ///< "mean height of the boxes [m]"
  double expected = 0.0;     ///< NaN: no closed form; the median of all engines is taken
  double within = 0.0;       ///< relative
  std::string why_expected;  ///< one sentence
};

/// Where a body is.
struct ThingState {
  Triple place{};  ///< [m]
  Turn turn{1, 0, 0, 0};
};

struct SceneInfo {
  const char* name;
  const char* what;
  int count;  ///< what `count` means here by default
};

/// The scenes of the benchmark: "spheres", "pyramid", … with what they are.
const std::vector<SceneInfo>& scene_list();

/// The scenes on which a backend is compared with its bare engine, see tests/faithful.
struct FaithfulScene {
  const char* name;
  const char* what;
  int steps;  ///< of 1 ms
};
const std::vector<FaithfulScene>& faithful_list();

/// Of either list. `count` 0: the usual number. Returns a scene without a name for one that is not in the list.
Scene make_scene(const std::string& name, int count = 0);

/// The value that Scene::check asks for.
double check_value(const Scene& scene, const std::vector<ThingState>& states);

}  // namespace cogrsim::bench
