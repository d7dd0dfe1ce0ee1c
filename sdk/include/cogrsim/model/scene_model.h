// A scene as plain data: what the compiler makes, what every backend is given. No engine owns it.
//
// Everything is in SI units. Elements refer to each other by index into the vectors of SceneModel;
// -1 as a body means the world. Indices stay valid for the life of a run: what is removed while
// running is marked (`removed`), what is added goes to the end.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/model/action.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim {

inline constexpr int kWorld = -1;  ///< as a body index

enum class BodyKind {
  dynamic,    ///< moved by forces
  kinematic,  ///< moves with the twist it is given, whatever pushes it
  fixed       ///< static: never moves
};

struct Body {
  std::string name;  ///< dotted, unique: "robot.wheel_left"
  BodyKind kind = BodyKind::dynamic;
  Pose X_WB;                        ///< at time 0
  Twist V_WB;                       ///< at time 0: of the body frame's origin, world axes
  double mass = 1.0;                ///< [kg], > 0 when dynamic
  Vec3 com = Vec3::Zero();          ///< centre of mass, in the body frame [m]
  Mat3 inertia = Mat3::Identity();  ///< about the centre of mass, body axes [kg m^2]
  std::vector<Shape> shapes;
  int assembly = -1;  ///< SceneModel::assemblies
  bool removed = false;
  SourceSpan origin;
};

/// A named place: `<frame>`.
struct NamedFrame {
  std::string name;  ///< dotted
  int body = kWorld;
  Pose X_BF;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

// Joint frames: F is fixed in the parent, M in the child; q = 0 where they coincide.
//
// | type        | coordinates q                            | speeds u                               |
// |-------------|------------------------------------------|----------------------------------------|
// | fixed       | -                                        | -                                      |
// | hinge       | angle about z [rad], not wrapped         | its rate                               |
// | slider      | travel along z [m]                       | its rate                               |
// | screw       | angle about z [rad]; travel = pitch*angle/(2 pi) | its rate                       |
// | cylindrical | angle about z [rad], travel along z [m]  | their rates                            |
// | universal   | angle about F's x, then about M's y [rad]| their rates                            |
// | planar      | x, y in F [m], angle about z [rad]       | their rates                            |
// | ball        | quaternion w x y z of M in F             | angular velocity of M in F, axes F     |
// | free        | x y z in F [m], quaternion w x y z       | linear, then angular velocity, axes F  |
enum class JointType { fixed, hinge, slider, screw, cylindrical, universal, planar, ball, free };

/// "hinge", "slider", ….
COGRSIM_API const char* to_string(JointType type);
COGRSIM_API int position_count(JointType type);  ///< 0 1 1 1 2 2 3 4 7
COGRSIM_API int speed_count(JointType type);     ///< 0 1 1 1 2 2 3 3 6

/// What acts along one speed of a joint, beside its drives. Units: rad and N m, or m and N.
struct JointAxis {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double damping = 0.0;    ///< effort per speed, >= 0
  double friction = 0.0;   ///< Coulomb effort, >= 0: holds below, opposes motion above
  double stiffness = 0.0;  ///< effort per coordinate, >= 0
  double rest = 0.0;       ///< coordinate at which the spring is slack
  /// Bounds of the drive train: no motor or servo on this axis pushes harder or runs faster.
  double max_effort = std::numeric_limits<double>::infinity();
  double max_speed = std::numeric_limits<double>::infinity();

  bool has_limit() const {
    return lower > -std::numeric_limits<double>::infinity() ||
           upper < std::numeric_limits<double>::infinity();
  }
};

/// `axes` has speed_count(type) entries, except: ball has one, whose coordinate is the angle
/// between M and F (0 to pi; `upper` is a cone around the start of all rotations, damping and
/// friction act against the relative angular velocity, stiffness towards q = identity);
/// free has none.
struct Joint {
  std::string name;  ///< dotted
  JointType type = JointType::hinge;
  int parent = kWorld;
  int child = kWorld;
  Pose X_PF;  ///< in the parent body (the world: world frame)
  Pose X_CM;  ///< in the child body
  std::vector<JointAxis> axes;
  double pitch = 0.0;            ///< of a screw: travel per turn [m]
  std::vector<double> position;  ///< at time 0, position_count(type); agrees with the bodies' poses
  std::vector<double> velocity;  ///< at time 0, speed_count(type); agrees with the bodies' twists
  /// Closes a loop: the other joints already connect its two bodies. Decided by the compiler
  /// (the later joint in the file is the one), the same for every backend.
  bool closes_loop = false;
  bool bodies_collide = false;  ///< parent and child collide with each other
  int position_offset = 0;      ///< first entry in the flat arrays of a state
  int speed_offset = 0;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

enum class MotorMode { velocity, torque, position, servo, dc };

/// "velocity", "torque", "position", "servo", "dc".
COGRSIM_API const char* to_string(MotorMode mode);

/// Drives one axis of a joint. Laws: see cogrsim/physics/drive.h. Units: rad, N m, or m, N.
struct Motor {
  std::string name;  ///< dotted
  int joint = -1;
  int axis = 0;  ///< of the joint
  MotorMode mode = MotorMode::velocity;
  double max_effort = std::numeric_limits<double>::infinity();
  double max_speed = std::numeric_limits<double>::infinity();
  double response = 0.05;  ///< position mode: time constant [s], > 0
  double kp = 0.0, ki = 0.0,
         kd = 0.0;  ///< servo gains: effort per coordinate, per its integral, per speed
  // DC model; the effort at the joint is gear * kt * current.
  double kt = 0.0;          ///< torque constant [N m/A]
  double ke = 0.0;          ///< back-EMF constant [V s/rad]
  double resistance = 0.0;  ///< of the winding [ohm], > 0 in dc mode
  double gear = 1.0;        ///< motor turns per joint turn
  double max_voltage = std::numeric_limits<double>::infinity();
  double max_current = std::numeric_limits<double>::infinity();
  /// At time 0: speed, effort, position or voltage. Empty: 0, but position and servo hold the
  /// joint's initial position.
  std::optional<double> target;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// One term of a sensor's noise, applied in file order.
struct NoiseTerm {
  enum class Kind { normal, uniform, bias, dropout, quantisation, bias_walk } kind = Kind::normal;
  double a = 0.0;  ///< normal: mean; uniform: low; bias: offset; dropout: probability;
                   ///< quantisation: step; bias walk: sigma per sqrt(s)
  double b = 0.0;  ///< normal: sigma; uniform: high
  /// What it disturbs: 0 what `noise` is about; 1 the sensor's second quantity (the angular velocity
  /// of an imu, the torque of a force-torque sensor, the depth of a camera).
  int group = 0;
};

struct SensorModel {
  std::string name;  ///< dotted
  std::string type;  ///< "camera", "encoder", …: built_in_sensors(), or a plugin's
  int body = kWorld;
  Pose X_BS;          ///< looks along its own +x, z up
  int joint = -1;     ///< encoder, force-torque
  double rate = 0.0;  ///< [Hz]; 0: every step
  bool enabled = true;
  bool show = false;
  std::vector<NoiseTerm> noise;
  Parameters parameters;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

enum class FaultPolicy { stop_controller, end_run };
/// Where a controller lives: in the simulation's process, or in one of its own.
enum class Isolation { none, process };

/// A number that a controller or supervisor publishes, as its plugin declares it.
struct OutputModel {
  std::string name;
  std::string unit;  ///< as in the scene language; "1": none
};

/// `<controller>` of an assembly, or `<supervisor>` of the scene (assembly -1).
struct ControllerModel {
  std::string name;  ///< dotted, unique
  std::string plugin;
  double rate = 0.0;  ///< [Hz]; 0: every step
  Parameters parameters;
  FaultPolicy on_fault = FaultPolicy::stop_controller;
  std::optional<Isolation> isolation;  ///< of controllers only; empty: as the run has it
  /// With a process of its own: longest time of an update by the clock on the wall [s], and what
  /// it may take of memory [byte]; infinite: no bound.
  double deadline = 10.0, memory = 1e9;
  std::vector<OutputModel> outputs;  ///< filled in when the plugin is known
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

struct AssemblyInfo {
  std::string name;  ///< dotted
  int parent = -1;   ///< SceneModel::assemblies; -1: top level
  Pose X_WA;         ///< at time 0
  bool rigid = false;
  /// Engine block, by engine name: `<NAME …/>` inside the assembly.
  std::map<std::string, Parameters> engine_options;
  bool removed = false;
  SourceSpan origin;
};

struct LightModel {
  enum class Type { directional, point, spot } type = Type::directional;
  std::string name;
  Pose X_WL;  ///< shines along its own +x
  Color color{1, 1, 1, 1};
  double intensity = 1.0;
  double cone = 0.5;  ///< spot: half angle [rad]
  bool shadows = true;
  SourceSpan origin;
};

/// A saved viewpoint; looks along its own +x, z up.
struct ViewModel {
  std::string name;
  Pose X_WV;
  double fov = 1.0;  ///< horizontal [rad]
  SourceSpan origin;
};

struct PhysicsSettings {
  std::string backend;               ///< the scene's wish; empty: none
  double step = 1e-3;                ///< [s]
  Vec3 gravity = Vec3(0, 0, -9.81);  ///< [m/s^2]
  std::uint64_t seed = 1;
  std::optional<double> duration;  ///< [s]
  /// Slower approaches than this do not bounce [m/s].
  double bounce_threshold = 0.05;
  std::map<std::string, Parameters> engine_options;  ///< by engine name
  SourceSpan origin;
  SourceSpan backend_origin;  ///< where the scene names its backend
};

/// `<record>`: what a run keeps of itself.
struct RecordModel {
  std::string file;    ///< relative to where the program was started; empty: SCENE.mcap
  double every = 0.0;  ///< time between frames kept [s]; 0: every step
  bool contacts = true;
  bool images = true;  ///< of cameras
  bool jpeg = false;   ///< colour pictures as JPEG; else PNG
  SourceSpan origin;
};

/// One line, cloud or box of a plot. Entries are signals, see cogrsim/signals/signal.h.
struct PlotSeries {
  std::string x, y, z;  ///< empty where the kind of plot needs none
  std::string label;    ///< empty: the signal's own text
  SourceSpan origin;
};

/// `<plot>`.
struct PlotModel {
  std::string name;            ///< dotted, unique
  std::string kind = "curve";  ///< "curve", "box", "surface", "histogram" or "map"
  std::string title;
  double every = 0.0;  ///< time between samples [s]; 0: every step
  std::vector<PlotSeries> series;
  SourceSpan origin;
};

/// `<region>`: a volume that notices who comes in and who goes out (events "enter" and "leave").
struct RegionModel {
  enum class Type { box, sphere };
  std::string name;  ///< dotted
  Type type = Type::box;
  int body = kWorld;  ///< moves with it
  Pose X_BR;
  Vec3 size = Vec3::Ones();  ///< box: full extents [m]
  double radius = 0.5;       ///< sphere [m]
  /// Bodies, named frames and assemblies it looks for, by dotted name; what counts is where their
  /// origin is (of an assembly: its base's). Empty: every top-level assembly and every body outside
  /// of one that can move, those added later among them.
  std::vector<std::string> who;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// `<door>`: what its motor moves between two ends (events "opening", "opened", "closing", "closed",
/// the latter two when it has really arrived).
struct DoorModel {
  std::string name;                 ///< dotted
  int motor = -1;                   ///< SceneModel::motors
  double closed = 0.0, open = 1.0;  ///< targets of the motor [m] or [rad]
  bool starts_open = false;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// `<maze>`: the plan of its walls, which are bodies like any others. A robot that is given the plan
/// knows the walls and doors, not what else stands there.
///
/// Cells count from 0, rows from the south (lowest y), columns from the west (lowest x). The maze's
/// frame M has its origin at the outer south-west corner of cell (0, 0), on the floor.
struct MazeModel {
  static constexpr int kOpen = -1, kWall = -2;  ///< else: a door, SceneModel::doors
  struct Place {
    std::string name;  ///< as in the drawing: "S", "T1"
    int row = 0, column = 0;
  };
  std::string name;  ///< dotted
  Pose X_WM;
  int rows = 0, columns = 0;
  double cell = 1.0;       ///< from centre to centre [m]
  double thickness = 0.0;  ///< of the walls [m]
  double height = 0.0;     ///< [m]
  /// What stands between a cell and its neighbour: kOpen, kWall or a door.
  std::vector<int> vertical;    ///< rows x (columns + 1): entry [row][c] is west of column c
  std::vector<int> horizontal;  ///< (rows + 1) x columns: entry [r][column] is south of row r
  std::vector<Place> places;
  SourceSpan origin;

  int west(int row, int column) const {
    return vertical[static_cast<std::size_t>(row * (columns + 1) + column)];
  }
  int east(int row, int column) const { return west(row, column + 1); }
  int south(int row, int column) const {
    return horizontal[static_cast<std::size_t>(row * columns + column)];
  }
  int north(int row, int column) const { return south(row + 1, column); }
  /// Of a cell's floor, in M [m].
  Vec3 centre(int row, int column) const {
    return {(column + 0.5) * cell, (row + 0.5) * cell, 0.0};
  }
};

/// `<template>`: what is not there at the start and can be added by name, see Spawn.
struct TemplateModel {
  std::string name;  ///< dotted
  std::shared_ptr<const struct SceneModel> fragment;
  SourceSpan origin;
};

/// `<on>`: what a scene does by itself. It fires on an event, at a time, or when a condition becomes
/// true; its actions are applied at the next step boundary (`after` it), in order.
struct RuleModel {
  std::string name;                   ///< dotted, unique
  std::string kind, source, subject;  ///< of the event; empty: any. `kind` empty: no event
  std::optional<double> time;         ///< [s]
  std::optional<double> every;        ///< again and again, first at `time` or one period in [s]
  std::string when;    ///< condition (cogrsim/signals/condition.h): alone, fires when it becomes
                       ///< true; beside an event or a time, it must hold then
  double after = 0.0;  ///< delay [s]
  int limit = 1000;    ///< fires that often at most; more is reported once and ignored
  std::vector<Action> actions;
  SourceSpan origin;
};

/// `<measure>`: a number of merit of a whole run.
struct MeasureModel {
  enum class Take { last, minimum, maximum, mean, integral, first_time };
  std::string name;    ///< dotted, unique
  std::string signal;  ///< of first_time: a condition; the time at which it first held, NaN: never
  Take take = Take::last;
  SourceSpan origin;
};

/// One line of a `<test>`.
struct ExpectationModel {
  enum class Kind {
    expect,      ///< holds at `at`, default the end
    always,      ///< in every frame up to `until`
    eventually,  ///< in some frame up to `within`
    agree        ///< a signal is the same on all backends up to `until`, within `tolerance`
  };
  Kind kind = Kind::expect;
  std::string that;                         ///< condition; with `equals`, and of agree: a signal
  std::optional<double> equals;             ///< in the signal's SI unit
  double tolerance = 0.0;                   ///< the same unit, >= 0
  std::optional<double> at, until, within;  ///< [s]
  SourceSpan origin;
};

/// `<test>`: what must be true of a run of the scene.
struct TestModel {
  std::string name;
  std::optional<double> duration;     ///< [s]; empty: the scene's
  std::vector<std::string> backends;  ///< empty: those the user names, else all
  std::vector<std::uint64_t> seeds;   ///< empty: the scene's
  std::vector<ExpectationModel> expectations;
  SourceSpan origin;
};

/// Two bodies that pass through each other.
using BodyPair = std::pair<int, int>;  ///< first < second

struct SceneModel {
  std::string name;
  std::vector<std::string> files;  ///< SourceSpan::file; [0] is the scene
  PhysicsSettings physics;
  std::vector<Material> materials;  ///< [0] is the default
  std::vector<MaterialPair> material_pairs;
  std::vector<TriangleMesh> meshes;
  std::vector<HeightGrid> heightmaps;
  std::vector<AssemblyInfo> assemblies;
  std::vector<Body> bodies;
  std::vector<NamedFrame> frames;
  std::vector<Joint> joints;
  std::vector<Motor> motors;
  std::vector<SensorModel> sensors;
  std::vector<ControllerModel> controllers;
  std::vector<ControllerModel> supervisors;
  std::vector<LightModel> lights;
  std::vector<ViewModel> views;
  std::optional<RecordModel> record;
  std::vector<PlotModel> plots;
  std::vector<RegionModel> regions;
  std::vector<DoorModel> doors;
  std::vector<MazeModel> mazes;
  std::vector<TemplateModel> templates;
  std::vector<RuleModel> rules;
  std::vector<MeasureModel> measures;
  std::vector<TestModel> tests;
  std::vector<BodyPair> no_collide;  ///< sorted, without doubles; joints' pairs are not in it
  int joint_positions = 0;           ///< length of the flat array of all q
  int joint_speeds = 0;              ///< length of the flat array of all u
};

using SceneModelPtr = std::shared_ptr<const SceneModel>;

/// Gives every joint its place in the flat arrays, fills missing initial positions and velocities
/// with zeros (quaternions with 1 0 0 0), and sorts `no_collide`. To be called once on a model
/// that was put together by hand.
COGRSIM_API void finish_model(SceneModel& model);

/// Sets `closes_loop` of every joint: true where the joints before it already connect its two
/// bodies. The world and all static and kinematic bodies count as one ground.
COGRSIM_API void mark_loops(SceneModel& model);

/// Whether contacts between two bodies count: not of one body with itself, of two that cannot
/// move, of a joint's parent and child unless it says so, nor of a pair in `no_collide`.
/// Built once per model; a query costs a hash look-up. Nothing touches a removed body.
class COGRSIM_API CollisionFilter {
 public:
  CollisionFilter() = default;
  explicit CollisionFilter(const SceneModel& model);
  bool collide(int body_a, int body_b) const;

 private:
  enum class Part : char { absent, immobile, mobile };
  std::vector<Part> bodies_;
  std::vector<std::uint64_t> excluded_;  // hash table of pair keys, open addressing
};

/// What the scene decides for two touching materials, the same on every backend: the pair's own
/// entry (`<contact between>`), else friction sqrt(a*b), restitution max(a, b), and stiffness of
/// the two in series where either gives one.
struct SurfacePair {
  double friction = 0.5;
  double restitution = 0.0;
  std::optional<double> stiffness;  ///< [N/m]
};
COGRSIM_API SurfacePair surface_pair(const SceneModel& model, int material_a, int material_b);

/// The bodies of an assembly and of all assemblies inside it, in model order, not the removed ones.
COGRSIM_API std::vector<int> bodies_of(const SceneModel& model, int assembly);

/// The assembly that is inside no other and holds this one, or is it; -1 for -1.
COGRSIM_API int top_level_assembly(const SceneModel& model, int assembly);

/// Looks up by dotted name among what is not removed; -1: none.
COGRSIM_API int find_body(const SceneModel& model, const std::string& name);
COGRSIM_API int find_joint(const SceneModel& model, const std::string& name);
COGRSIM_API int find_assembly(const SceneModel& model, const std::string& name);

/// "maze.scene.xml:27:48", or "" for an element made by a program.
COGRSIM_API std::string place_of(const SceneModel& model, const SourceSpan& span);

}  // namespace cogrsim
