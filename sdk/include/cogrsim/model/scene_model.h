// The scene as plain data. The scene compiler creates it and every backend reads it; it is
// independent of all engines.
//
// All quantities are in SI units. Elements refer to each other by index into the vectors of
// SceneModel; the body index -1 means the world. Indices stay valid for a whole run: an element
// that is removed is only marked (`removed`), and a new element is appended at the end.
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

/// Largest Motor::delay and SensorModel::latency [s].
inline constexpr double kLongestDelay = 10.0;
inline constexpr int kWorld = -1;  ///< as a body index

enum class BodyKind {
  dynamic,     ///< moved by forces
  kinematic,   ///< moves with its prescribed twist, regardless of forces
  static_body  ///< never moves
};

/// A rigid body with its shapes.
struct Body {
  std::string name;  ///< dotted, unique: "robot.wheel_left"
  BodyKind kind = BodyKind::dynamic;
  Pose X_WB;                        ///< pose in the world at time 0
  Twist V_WB;                       ///< twist at time 0, of the body origin, in world axes
  double mass = 1.0;                ///< [kg], > 0 when dynamic
  Vec3 com = Vec3::Zero();          ///< centre of mass, in the body frame [m]
  Mat3 inertia = Mat3::Identity();  ///< about the centre of mass, body axes [kg m^2]
  double gravity_scale = 1.0;       ///< factor on the body's weight; 0: weightless
  std::vector<Shape> shapes;
  int assembly = -1;  ///< index into SceneModel::assemblies; -1: none
  bool removed = false;
  SourceSpan origin;
};

/// A named frame that is fixed to a body: `<frame>`.
struct NamedFrame {
  std::string name;  ///< dotted
  int body = kWorld;
  Pose X_BF;  ///< pose in the body
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

// Joint frames: F is fixed in the parent, M in the child. They coincide at q = 0.
//
// | type        | coordinates q                           | speeds u                              |
// |-------------|-----------------------------------------|---------------------------------------|
// | fixed       | -                                       | -                                     |
// | hinge       | angle about z [rad], not wrapped        | its rate                              |
// | slider      | travel along z [m]                      | its rate                              |
// | screw       | angle about z [rad], see pitch          | its rate                              |
// | cylindrical | angle about z [rad], travel along z [m] | their rates                           |
// | universal   | angles about F's x and M's y [rad]      | their rates                           |
// | gimbal      | angles about x, y and z, each as the    | their rates                           |
// |             | ones before it have turned it [rad]     |                                       |
// | planar      | x, y in F [m], angle about z [rad]      | their rates                           |
// | ball        | quaternion w x y z of M in F            | angular velocity of M in F, axes F    |
// | free        | x y z in F [m], quaternion w x y z      | linear, then angular velocity, axes F |
//
// A gimbal is singular where its second angle is a right one: x and z then turn about one line.
enum class JointType {
  fixed,
  hinge,
  slider,
  screw,
  cylindrical,
  universal,
  planar,
  ball,
  free,
  gimbal
};

/// "hinge", "slider", ….
COGRSIM_API const char* to_string(JointType type);
COGRSIM_API int position_count(JointType type);  ///< 0 1 1 1 2 2 3 4 7 3
COGRSIM_API int speed_count(JointType type);     ///< 0 1 1 1 2 2 3 3 6 3

/// Limits and passive forces along one axis of a joint. Coordinates are in rad and efforts in N m
/// (rotation), or in m and N (translation).
struct JointAxis {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double damping = 0.0;    ///< effort per speed, >= 0
  double friction = 0.0;   ///< Coulomb friction effort, >= 0; static and kinetic
  double stiffness = 0.0;  ///< effort per coordinate, >= 0
  double rest = 0.0;       ///< coordinate at which the spring exerts no effort
  /// Limits of the drive train: the largest effort and speed of any motor or servo on this axis.
  double max_effort = std::numeric_limits<double>::infinity();
  double max_speed = std::numeric_limits<double>::infinity();
  /// Inertia of the rotor of a drive, reflected to the axis (armature), >= 0: [kg m^2] or [kg]. It
  /// adds 1/2 rotor_inertia u^2 to the kinetic energy and acts on this axis alone.
  double rotor_inertia = 0.0;

  bool has_limit() const {
    return lower > -std::numeric_limits<double>::infinity() ||
           upper < std::numeric_limits<double>::infinity();
  }
};

/// A joint between two bodies. `axes` has speed_count(type) entries, with two exceptions. A ball
/// joint has one entry, whose coordinate is the rotation angle between M and F (0 to pi): `upper`
/// limits this angle, damping and friction oppose the relative angular velocity, and stiffness acts
/// towards q = identity. A free joint has no entries.
struct Joint {
  std::string name;  ///< dotted
  JointType type = JointType::hinge;
  int parent = kWorld;
  int child = kWorld;
  Pose X_PF;  ///< pose of F in the parent body, or in the world frame if `parent` is kWorld
  Pose X_CM;  ///< pose of M in the child body
  std::vector<JointAxis> axes;
  double pitch = 0.0;            ///< of a screw: travel per turn [m]; travel = pitch q / (2 pi)
  std::vector<double> position;  ///< position_count(type) entries at time 0; match the body poses
  std::vector<double> velocity;  ///< speed_count(type) entries at time 0; match the body twists
  /// The joint closes a kinematic loop: other joints already connect its two bodies. The compiler
  /// decides this (the last joint of a loop in the file), so it is the same for every backend.
  bool closes_loop = false;
  bool bodies_collide = false;  ///< parent and child collide with each other
  /// Engine-specific options by engine name: `<NAME …/>` inside the joint.
  std::map<std::string, Parameters> engine_options;
  int position_offset = 0;  ///< index of the first coordinate in the flat array of all q
  int speed_offset = 0;     ///< index of the first speed in the flat array of all u
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// One joint of a coupling, with exactly one axis.
struct CouplingTerm {
  int joint = -1;      ///< index into SceneModel::joints
  double ratio = 1.0;  ///< change of the coupled coordinate per change of this one
};

/// `<couple>`: keeps the coordinate of a joint at a linear function of others, as gears, belts and
/// linkages do: q = offset + sum of ratio * q of the terms. The effort E on the joint comes with
/// the efforts -ratio E on the others.
struct Coupling {
  std::string name;                 ///< dotted
  int joint = -1;                   ///< index into SceneModel::joints; has exactly one axis
  std::vector<CouplingTerm> terms;  ///< at least one; not the joint itself
  double offset = 0.0;              ///< [rad] or [m]
  /// Largest effort on the joint [N m] or [N], > 0: beyond it the coupling slips.
  double max_effort = std::numeric_limits<double>::infinity();
  std::map<std::string, Parameters> engine_options;  ///< by engine name: `<NAME …/>` inside it
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

enum class MotorMode { velocity, torque, position, servo, dc };

/// "velocity", "torque", "position", "servo", "dc".
COGRSIM_API const char* to_string(MotorMode mode);

/// A motor that drives one axis of a joint; cogrsim/physics/drive.h has the control laws. Positions
/// and efforts are in rad and N m (rotation), or in m and N (translation).
struct Motor {
  std::string name;  ///< dotted
  int joint = -1;    ///< index into SceneModel::joints
  int axis = 0;      ///< index of the axis of the joint
  MotorMode mode = MotorMode::velocity;
  double max_effort = std::numeric_limits<double>::infinity();
  double max_speed = std::numeric_limits<double>::infinity();
  double response = 0.05;  ///< position mode: time constant [s], > 0
  /// Speed-torque curve of all modes but dc: in the direction of motion no more effort than
  /// stall_effort (1 - |speed| / no_load_speed), see docs/guide/concepts.md. Both infinite: none.
  double stall_effort = std::numeric_limits<double>::infinity();   ///< [N m] or [N], > 0
  double no_load_speed = std::numeric_limits<double>::infinity();  ///< [rad/s] or [m/s], > 0
  double delay = 0.0;  ///< from a target to its effect [s], 0 to kLongestDelay
  /// Servo gains: effort per coordinate, per integral of the coordinate, and per speed.
  double kp = 0.0, ki = 0.0, kd = 0.0;
  // DC motor model: the effort at the joint is gear * kt * current.
  double kt = 0.0;          ///< torque constant [N m/A]
  double ke = 0.0;          ///< back-EMF constant [V s/rad]
  double resistance = 0.0;  ///< of the winding [ohm], > 0 in dc mode
  double gear = 1.0;        ///< motor turns per joint turn
  double max_voltage = std::numeric_limits<double>::infinity();
  double max_current = std::numeric_limits<double>::infinity();
  /// Target at time 0: a speed, effort, position or voltage [V], depending on `mode`. Empty: 0; in
  /// the position and servo modes the initial position of the joint.
  std::optional<double> target;
  /// Targets beyond these are taken as these; in its unit.
  double min_target = -std::numeric_limits<double>::infinity();
  double max_target = std::numeric_limits<double>::infinity();
  /// A signal (cogrsim/signals/signal.h) that gives the target in every step, until a command or a
  /// controller sets the target; empty: none.
  std::string target_signal;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// `<force>`, `<drag>`, `<spring>` or `<buoyancy>`: a force and a torque on a body, computed by
/// CogRSim from the state and given to the engine for each step. They act at the frame E of the
/// element. `<wind>` is what the drags add to their own wind.
struct ForceModel {
  enum class Kind {
    force,  ///< `factor` times `force` and `torque`
    drag,  ///< -(linear + quadratic |v|) v - angular w, with v the velocity of E relative to `wind`
           ///< and w the angular velocity of the body
    spring,    ///< between E and E2, along the line: stiffness (l - length) + damping dl/dt
    buoyancy,  ///< density * volume of the body's shapes below `level` * -gravity, at its centroid
    wind       ///< `factor` times `wind`, for all drags
  } kind = Kind::force;
  std::string name;  ///< dotted
  int body = kWorld;
  Pose X_BE;                        ///< of E in the body
  int other = kWorld;               ///< spring: the second body
  Vec3 other_point = Vec3::Zero();  ///< spring: E2 in it [m]
  bool in_body = false;             ///< force: the vectors are in the axes of E; else in world axes
  Vec3 force = Vec3::Zero();        ///< [N]
  Vec3 torque = Vec3::Zero();       ///< [N m]
  std::string factor;               ///< force, wind: a signal (cogrsim/signals/signal.h); empty: 1
  double from = 0.0;                ///< force, wind: time at which it begins [s]
  double until = std::numeric_limits<double>::infinity();  ///< and ends [s]
  double linear = 0.0;                                     ///< drag [N s/m], >= 0
  double quadratic = 0.0;                                  ///< drag [N s^2/m^2], >= 0
  double angular = 0.0;                                    ///< drag [N m s/rad], >= 0
  Vec3 wind = Vec3::Zero();  ///< drag, wind: velocity of the medium [m/s]
  double stiffness = 0.0;    ///< spring [N/m], >= 0
  double damping = 0.0;      ///< spring [N s/m], >= 0
  double length = 0.0;       ///< spring: at which it exerts no force [m], >= 0
  bool cable = false;        ///< spring: pulls only
  double density = 1000.0;   ///< buoyancy: of the fluid [kg/m^3], > 0
  double level = 0.0;        ///< buoyancy: height of the surface against gravity [m]
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// One term of the noise model of a sensor. The terms are applied in the order of the file.
struct NoiseTerm {
  enum class Kind { normal, uniform, bias, dropout, quantisation, bias_walk } kind = Kind::normal;
  double a = 0.0;  ///< normal: mean; uniform: low; bias: offset; dropout: probability;
                   ///< quantisation: step; bias walk: sigma per sqrt(s)
  double b = 0.0;  ///< normal: sigma; uniform: high
  /// The quantity it disturbs: 0 for the first quantity of the sensor; 1 for the second (the
  /// angular velocity of an imu, the torque of a force-torque sensor, the depth of a camera).
  int group = 0;
};

/// A sensor on a body or a joint.
struct SensorModel {
  std::string name;  ///< dotted
  std::string type;  ///< "camera", "encoder", … (see built_in_sensors()), or a plugin's type
  int body = kWorld;
  Pose X_BS;             ///< pose in the body; the viewing direction is +x, and z is up
  int joint = -1;        ///< index into SceneModel::joints, for encoder and force-torque sensors
  double rate = 0.0;     ///< measurements per second [Hz]; 0: one in every step
  double latency = 0.0;  ///< from a measurement to its delivery [s], 0 to kLongestDelay
  bool enabled = true;
  bool show = false;  ///< draw the sensor's rays
  std::vector<NoiseTerm> noise;
  Parameters parameters;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// What follows an error of a controller: it alone stops, or the run ends.
enum class FaultPolicy { stop_controller, end_run };
/// Where a controller runs: in the process of the simulation, or in a process of its own.
enum class Isolation { none, process };

/// Declaration of a number that a controller or supervisor publishes.
struct OutputModel {
  std::string name;
  std::string unit;  ///< as in the scene language; "1": none
};

/// `<controller>` of an assembly, or `<supervisor>` of the scene (assembly -1).
struct ControllerModel {
  std::string name;  ///< dotted, unique
  std::string plugin;
  double rate = 0.0;  ///< updates per second [Hz]; 0: one in every step
  Parameters parameters;
  FaultPolicy on_fault = FaultPolicy::stop_controller;
  std::optional<Isolation> isolation;  ///< of controllers only; empty: the setting of the run
  /// Limits of a controller in a process of its own: wall-clock time of one update [s] and memory
  /// [byte]; infinite: no limit.
  double deadline = 10.0, memory = 1e9;
  std::vector<OutputModel> outputs;  ///< filled in when the plugin has been loaded
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// An assembly: a named group of bodies, joints, motors, sensors and other assemblies.
struct AssemblyInfo {
  std::string name;  ///< dotted
  int parent = -1;   ///< index into SceneModel::assemblies; -1: top level
  Pose X_WA;         ///< pose of the assembly frame in the world at time 0
  bool rigid = false;
  /// Engine-specific options by engine name: `<NAME …/>` inside the assembly.
  std::map<std::string, Parameters> engine_options;
  bool removed = false;
  SourceSpan origin;
};

/// A light source.
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

/// A named viewpoint. Its viewing direction is +x, and z is up.
struct ViewModel {
  std::string name;
  Pose X_WV;
  double fov = 1.0;  ///< horizontal field of view [rad]
  SourceSpan origin;
};

/// `<physics>`: settings of the simulation.
struct PhysicsSettings {
  std::string backend;               ///< backend that the scene requests; empty: none
  double step = 1e-3;                ///< time step [s]
  Vec3 gravity = Vec3(0, 0, -9.81);  ///< [m/s^2]
  std::uint64_t seed = 1;
  std::optional<double> duration;  ///< [s]
  /// Relative normal speed below which impacts are inelastic [m/s].
  double bounce_threshold = 0.05;
  std::map<std::string, Parameters> engine_options;  ///< by engine name
  SourceSpan origin;
  SourceSpan backend_origin;  ///< source location of the backend's name
};

/// `<record>`: what a run records.
struct RecordModel {
  std::string file;    ///< relative to the working directory; empty: SCENE.mcap
  double every = 0.0;  ///< time between recorded frames [s]; 0: every step
  bool contacts = true;
  bool images = true;  ///< camera images
  bool jpeg = false;   ///< colour images as JPEG, otherwise as PNG
  SourceSpan origin;
};

/// One line, point cloud or box of a plot. The entries are signals, see cogrsim/signals/signal.h.
struct PlotSeries {
  std::string x, y, z;  ///< empty if the kind of plot does not use this axis
  std::string label;    ///< empty: the text of the signal
  SourceSpan origin;
};

/// `<plot>`: a plot of signals over a run.
struct PlotModel {
  std::string name;            ///< dotted, unique
  std::string kind = "curve";  ///< "curve", "box", "surface", "histogram" or "map"
  std::string title;
  double every = 0.0;  ///< time between samples [s]; 0: every step
  std::vector<PlotSeries> series;
  SourceSpan origin;
};

/// `<region>`: a volume that detects objects entering and leaving it (events "enter" and "leave").
struct RegionModel {
  enum class Type { box, sphere };
  std::string name;  ///< dotted
  Type type = Type::box;
  int body = kWorld;         ///< body that the region is fixed to
  Pose X_BR;                 ///< pose in the body
  Vec3 size = Vec3::Ones();  ///< box: full extents [m]
  double radius = 0.5;       ///< sphere [m]
  /// Dotted names of the bodies, named frames and assemblies that it detects. An object is inside
  /// if its origin is (for an assembly: the origin of its base body). Empty: every top-level
  /// assembly and every movable body without an assembly, including those that are added later.
  std::vector<std::string> who;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// `<door>`: a door that a motor moves between two positions. Its events are "opening" and
/// "closing" for the command, and "opened" and "closed" when it has reached its position.
struct DoorModel {
  std::string name;                 ///< dotted
  int motor = -1;                   ///< index into SceneModel::motors
  double closed = 0.0, open = 1.0;  ///< targets of the motor [m] or [rad]
  bool starts_open = false;
  int assembly = -1;
  bool removed = false;
  SourceSpan origin;
};

/// `<maze>`: the plan of a maze. Its walls are ordinary bodies. A robot that receives the plan
/// knows the walls and doors, but no other obstacles.
///
/// Cells count from 0, rows from the south (lowest y), columns from the west (lowest x). The maze
/// frame M has its origin at the outer south-west corner of cell (0, 0), on the floor.
struct MazeModel {
  static constexpr int kOpen = -1, kWall = -2;  ///< other values: index into SceneModel::doors
  /// A named cell.
  struct NamedCell {
    std::string name;  ///< as in the drawing: "S", "T1"
    int row = 0, column = 0;
  };
  std::string name;  ///< dotted
  Pose X_WM;         ///< pose of the maze frame in the world
  int rows = 0, columns = 0;
  double cell = 1.0;       ///< distance between the centres of neighbouring cells [m]
  double thickness = 0.0;  ///< of the walls [m]
  double height = 0.0;     ///< of the walls [m]
  // Each entry is the boundary between two neighbouring cells: kOpen, kWall or a door.
  std::vector<int> vertical;    ///< rows x (columns + 1): entry [row][c] is west of column c
  std::vector<int> horizontal;  ///< (rows + 1) x columns: entry [r][column] is south of row r
  std::vector<NamedCell> named_cells;
  SourceSpan origin;

  // The boundary of a cell on one side: kOpen, kWall or a door. Indices are not checked.
  int west(int row, int column) const { return vertical[row * (columns + 1) + column]; }
  int east(int row, int column) const { return west(row, column + 1); }
  int south(int row, int column) const { return horizontal[row * columns + column]; }
  int north(int row, int column) const { return south(row + 1, column); }
  /// Centre of the floor of a cell, in the maze frame M [m].
  Vec3 centre(int row, int column) const {
    return {(column + 0.5) * cell, (row + 0.5) * cell, 0.0};
  }
};

/// `<template>`: an assembly that does not exist at the start and can be added by name, see Spawn.
struct TemplateModel {
  std::string name;  ///< dotted
  std::shared_ptr<const struct SceneModel> fragment;
  SourceSpan origin;
};

/// `<on>`: a rule of the scene. It fires on an event, at a time, or when a condition becomes true.
/// Its actions are applied in order at the next step boundary, or `after` seconds later.
struct RuleModel {
  std::string name;  ///< dotted, unique
  /// Kind, source and subject of the event. An empty source or subject matches any; an empty kind
  /// means that the rule does not depend on an event.
  std::string kind, source, subject;
  std::optional<double> time;   ///< time at which the rule fires [s]
  std::optional<double> every;  ///< period [s]; fires first at `time`, or after one period
  /// Condition (cogrsim/signals/condition.h). Alone: the rule fires when it becomes true. Together
  /// with an event or a time: it must be true then.
  std::string when;
  double after = 0.0;  ///< delay [s]
  int limit = 1000;    ///< largest number of firings; exceeding it is reported once
  std::vector<Action> actions;
  SourceSpan origin;
};

/// `<measure>`: a performance measure of a whole run, computed from a signal.
struct MeasureModel {
  enum class Take { last, minimum, maximum, mean, integral, first_time };
  std::string name;  ///< dotted, unique
  /// The signal. For first_time: a condition; the measure is the time at which it first became true
  /// [s], or NaN if it never did.
  std::string signal;
  Take take = Take::last;
  SourceSpan origin;
};

/// One line of a `<test>`.
struct ExpectationModel {
  enum class Kind {
    expect,      ///< true at the time `at`, by default at the end
    always,      ///< true in every frame up to `until`
    eventually,  ///< true in at least one frame up to `within`
    agree        ///< the signal is the same on all backends up to `until`, within `tolerance`
  };
  Kind kind = Kind::expect;
  std::string that;                         ///< a condition; for `equals` and agree a signal
  std::optional<double> equals;             ///< in the signal's SI unit
  double tolerance = 0.0;                   ///< the same unit, >= 0
  std::optional<double> at, until, within;  ///< [s]
  SourceSpan origin;
};

/// `<test>`: expectations about a run of the scene.
struct TestModel {
  std::string name;
  std::optional<double> duration;     ///< [s]; empty: that of the scene
  std::vector<std::string> backends;  ///< empty: those that the user names, otherwise all
  std::vector<std::uint64_t> seeds;   ///< empty: the seed of the scene
  std::vector<ExpectationModel> expectations;
  SourceSpan origin;
};

/// Two bodies that do not collide with each other.
using BodyPair = std::pair<int, int>;  ///< first < second

/// `<randomize>`: quantities that are drawn for each run, see cogrsim/model/randomize.h.
struct RandomizeModel {
  enum class How { multiply, set, add } how = How::multiply;
  enum class Shape { uniform, normal, loguniform, choice } shape = Shape::uniform;
  std::string what;                     ///< as in the scene: "robot.*.mass"
  std::vector<std::string> quantities;  ///< those of the scene that it names: "robot.arm.mass"
  /// uniform, loguniform: low and high; normal: mean and standard deviation; choice: the values. In
  /// SI units.
  std::vector<double> numbers;
  bool together = false;  ///< one number for all quantities; else one for each
  SourceSpan origin;
};

/// A quantity of a model with its drawn value.
struct DrawnValue {
  std::string quantity;  ///< "robot.arm.mass"
  double value = 0.0;    ///< [SI units]; of several axes, shapes or noise terms the first one's
};

/// A complete scene.
struct SceneModel {
  std::string name;
  std::vector<std::string> files;  ///< source files; [0] is the scene. See SourceSpan::file
  /// Parameters of the scene that were set when it was compiled (`--set`), as texts by name.
  std::map<std::string, std::string> set_parameters;
  PhysicsSettings physics;
  std::vector<Material> materials;  ///< [0] is the default
  std::vector<MaterialPair> material_pairs;
  std::vector<MeshPtr> meshes;
  std::vector<HeightGridPtr> heightmaps;
  std::vector<AssemblyInfo> assemblies;
  std::vector<Body> bodies;
  std::vector<NamedFrame> frames;
  std::vector<Joint> joints;
  std::vector<Coupling> couplings;
  std::vector<Motor> motors;
  std::vector<ForceModel> forces;
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
  std::vector<RandomizeModel> randomize;
  std::vector<DrawnValue> drawn;     ///< in the model of a run
  std::vector<BodyPair> no_collide;  ///< sorted and unique; without the pairs that joints exclude
  int joint_positions = 0;           ///< length of the flat array of all q
  int joint_speeds = 0;              ///< length of the flat array of all u
};

using SceneModelPtr = std::shared_ptr<const SceneModel>;

/// Assigns every joint its offsets in the flat arrays, fills missing initial positions and
/// velocities with zeros (quaternions with 1 0 0 0), and sorts `no_collide`. Call it once on a
/// model that was assembled by a program.
COGRSIM_API void finish_model(SceneModel& model);

/// Sets `closes_loop` of every joint: true if the joints before it already connect its two bodies.
/// The world and all static and kinematic bodies count as one ground body.
COGRSIM_API void mark_loops(SceneModel& model);

/// Decides which pairs of bodies collide. Excluded are a body with itself, two immobile bodies, the
/// parent and child of a joint without `bodies_collide`, the pairs in `no_collide`, and removed
/// bodies. The filter is built once per model; a query costs one hash look-up and is thread-safe.
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

/// Contact properties of two touching materials, the same on every backend: those of the material
/// pair (`<contact between>`) if the scene defines them; otherwise friction and restitution follow the
/// rule of the materials, the later one of CombineRule where they differ, and without one sqrt(a*b)
/// and max(a, b). Rolling and spinning friction are max(a, b), and the stiffness is that of the two
/// stiffnesses in series.
struct SurfacePair {
  double friction = 0.5;
  double rolling_friction = 0.0, spinning_friction = 0.0;  ///< [m], see Material
  double restitution = 0.0;
  std::optional<double> stiffness;  ///< [N/m]; empty: neither material defines one
};
/// One coefficient of two, by a rule that is not `usual`.
COGRSIM_API double combine(CombineRule rule, double a, double b);
COGRSIM_API SurfacePair surface_pair(const SceneModel& model, int material_a, int material_b);

/// Indices of the bodies of an assembly and of all assemblies inside it, in model order, without
/// the removed ones.
COGRSIM_API std::vector<int> bodies_of(const SceneModel& model, int assembly);

/// The top-level assembly that contains `assembly` or is `assembly` itself; -1 for -1.
COGRSIM_API int top_level_assembly(const SceneModel& model, int assembly);

/// Index of the element with this dotted name that is not removed, or -1.
COGRSIM_API int find_body(const SceneModel& model, const std::string& name);
COGRSIM_API int find_joint(const SceneModel& model, const std::string& name);
COGRSIM_API int find_motor(const SceneModel& model, const std::string& name);
COGRSIM_API int find_assembly(const SceneModel& model, const std::string& name);

/// The source location with the file's name; without one for an element that a program created.
COGRSIM_API SourcePosition source_position(const SceneModel& model, const SourceSpan& span);

}  // namespace cogrsim
