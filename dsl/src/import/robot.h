// A robot between its source and the scene: links, joints and what is on them, in SI units and in
// the order of the source.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/roll_pitch_yaw.h"
#include "cogrsim/core/types.h"
#include "cogrsim/model/mass_properties.h"
#include "cogrsim/model/shapes.h"
#include "import/context.h"

namespace cogrsim::dsl::import {

/// Heights from 0 to 1, the row with the largest y first.
struct HeightField {
  int columns = 0, rows = 0;
  std::vector<double> samples;
};
using HeightFieldPtr = std::shared_ptr<const HeightField>;

struct Geometry {
  enum class Type {
    box,
    sphere,
    cylinder,
    capsule,
    ellipsoid,
    cone,
    prism,
    plane,
    mesh,
    heightmap
  } type = Type::box;
  Vec3 size = Vec3::Zero();  ///< box, heightmap: whole extents; ellipsoid: half axes [m]
  double radius = 0.0;       ///< [m]
  double length = 0.0;       ///< capsule: without its ends; others: whole [m]
  std::string mesh;          ///< canonical path
  std::vector<Vec3> points;  ///< prism: of its convex outline, z = 0 [m]
  Vec3 scale = Vec3::Ones();
  HeightFieldPtr heights;
};

/// Attributes of `<mujoco>` in an element: what one engine does, and others do not have.
using MujocoAttributes = std::vector<std::pair<std::string, std::string>>;

struct RobotShape {
  std::string name;
  Pose X;  ///< in the link
  Geometry geometry;
  std::optional<Color> color;
  std::string texture;  ///< canonical path
  bool visible = true, collides = true;
  /// Two shapes touch where the type of one and the affinity of the other have a common bit.
  unsigned contact_type = 1, contact_affinity = 1;
  std::optional<double> friction;
  double rolling_friction = 0.0, spinning_friction = 0.0;  ///< [m]
  double restitution = 0.0;
  CombineRule friction_combine = CombineRule::usual, restitution_combine = CombineRule::usual;
  int material = -1;  ///< by RobotModel::materials, which then has what is above; -1: none
  Source at;
};

/// What shapes have in common that RobotContact names, or an engine has for them.
struct RobotMaterial {
  std::string name;
  double friction = 0.0, rolling_friction = 0.0, spinning_friction = 0.0;
  CombineRule friction_combine = CombineRule::usual;
  MujocoAttributes of_mujoco;
};

/// What holds between two materials, by RobotModel::materials.
struct RobotContact {
  std::size_t a = 0, b = 0;
  double friction = 0.0, rolling_friction = 0.0, spinning_friction = 0.0;
};

struct RobotInertia {
  double mass = 0.0;        ///< [kg]
  Vec3 com = Vec3::Zero();  ///< in the link [m]
  Mat3 I = Mat3::Zero();    ///< about the centre of mass, the link's axes [kg m^2]
};

/// A named frame on a link: of a link that was welded, a site, a sensor.
struct RobotFrame {
  std::string name;
  Pose X;                ///< in the link
  bool is_site = false;  ///< springs find their ends among these
};

struct RobotSensor {
  std::string name, element;  ///< the element of the scene language: "imu"
  Pose X;                     ///< in the link
  std::vector<std::pair<std::string, std::string>> attributes;  ///< in the scene's notation
  std::string joint;                                            ///< of an encoder, a force-torque
  Source at;
};

/// The fluid that a link is in.
struct RobotFluid {
  double level = 0.0;    ///< height of its surface [m]
  double density = 0.0;  ///< [kg/m^3]
};

struct RobotLink {
  std::string name;
  Pose X;  ///< of a link that no joint carries, in the model
  std::optional<RobotInertia> inertia;
  std::vector<RobotShape> shapes;
  std::vector<RobotFrame> frames;
  std::vector<RobotSensor> sensors;
  bool has_lost_shape = false;  ///< there is one that cannot be read
  bool is_static = false;
  bool is_ground = false;   ///< the world of the source itself
  bool is_scenery = false;  ///< stands around the robot and is no part of it
  double gravity_scale = 1.0;
  /// Links of one model, 0 or above, touch each other only where one of them does so by itself.
  int model = -1;
  bool self_collides = false;
  bool in_wind = false;
  double drag = 0.0;  ///< at its centre of mass [N s/m]
  /// Force per speed of its origin, and torque per angular speed [N s/m, N m s/rad].
  double free_damping = 0.0;
  std::optional<RobotFluid> fluid;
  Source at;
};

/// q = Σ ratio * q of `joint` + offset.
struct RobotCoupling {
  struct Term {
    std::string joint;
    double ratio = 1.0;
  };
  std::vector<Term> terms;
  double offset = 0.0;
  MujocoAttributes of_mujoco;
};

/// Limits and passive efforts along one axis.
struct AxisLaw {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double max_effort = std::numeric_limits<double>::infinity();
  double max_speed = std::numeric_limits<double>::infinity();
  double damping = 0.0, friction = 0.0, stiffness = 0.0, rest = 0.0;
};

struct RobotJoint : AxisLaw {
  enum class Type {
    fixed,
    hinge,
    slider,
    ball,
    planar,
    free,
    universal,
    screw,
    gimbal
  } type = Type::fixed;
  std::string name;
  int parent = -1;  ///< by RobotModel::links; -1: the world
  int child = -1;
  Pose X_PC;                   ///< of the child in the parent, at zero
  Vec3 anchor = Vec3::Zero();  ///< of the joint in the child
  Vec3 axis = Vec3::UnitX();   ///< in the joint's frame, unit
  Vec3 axis2 = Vec3::UnitY();
  AxisLaw second;                ///< of a universal joint's second axis
  double rotor_inertia = 0.0;    ///< added to the axis [kg m^2] or [kg]
  double position = 0.0;         ///< at the start
  Quat turn = Quat::Identity();  ///< of a ball or gimbal at the start
  double pitch = 0.0;            ///< of a screw [m/turn]
  std::optional<RobotCoupling> coupling;
  MujocoAttributes of_mujoco;
  Source at;

  bool has_one_axis() const {
    return type == Type::hinge || type == Type::slider || type == Type::screw;
  }
};

/// A motor or servo on a joint.
struct RobotDrive {
  std::string name, joint;
  int axis = 1;  ///< of a gimbal, from 1
  enum class Mode { position, velocity, torque } mode = Mode::torque;
  double kp = 0.0, ki = 0.0, kd = 0.0;  ///< of a position drive
  double max_effort = std::numeric_limits<double>::infinity();
  std::optional<double> target;
  double min_target = -std::numeric_limits<double>::infinity();
  double max_target = std::numeric_limits<double>::infinity();
  std::vector<std::string> followers;  ///< joints that it moves too, by their couplings
  Source at;
};

/// A spring with a damper between two points.
struct RobotSpring {
  std::string name, ends[2];  ///< sites
  double stiffness = 0.0, damping = 0.0;
  std::optional<double> length;  ///< without force; empty: with all joints where they rest
  bool pulls_only = false;
  Source at;
};

struct RobotLight {
  std::string name, type;
  Vec3 position = Vec3::Zero(), direction = -Vec3::UnitZ();
  Color color{1, 1, 1, 1};
  double intensity = 1.0;
  std::optional<double> cone;  ///< half angle of a spot [rad]
  bool shadows = false;
  Source at;
};

struct RobotModel {
  std::string name;
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;  ///< a tree: no link is the child of two
  std::vector<RobotJoint> loops;   ///< joints that close loops; X_PC is not used
  std::vector<RobotDrive> drives;
  std::vector<RobotSpring> springs;
  std::vector<RobotLight> lights;
  std::vector<RobotMaterial> materials;
  std::vector<RobotContact> contacts;
  MujocoAttributes of_mujoco;                                   ///< in <physics>
  std::vector<std::pair<std::string, std::string>> no_contact;  ///< links that do not touch
  std::vector<std::pair<std::string, std::string>> touching;    ///< shapes that do, by name
  /// What in the source says which shapes touch, and the bits of what is not in it.
  std::string contact_rule = "contype and conaffinity";
  unsigned usual_bits = 1;
  /// Nothing of the robot touches each other, but for these pairs of links.
  std::optional<std::vector<std::pair<std::string, std::string>>> only_contact;
  std::optional<double> step;   ///< [s]
  std::optional<Vec3> gravity;  ///< [m/s^2]
  std::optional<Vec3> wind;     ///< [m/s]
  bool has_ground = false;

  /// The step of the file at `at`; one that no scene has is reported.
  void take_step(Context& context, double seconds, const Source& at);
  /// The index of the first of that name; -1: none. In constant time.
  int link(const std::string& wanted) const { return link_names_.find(links, wanted); }
  int joint(const std::string& wanted) const { return joint_names_.find(joints, wanted); }
  /// To be called when links or joints were renamed or removed.
  void names_changed() { link_names_ = joint_names_ = {}; }
  /// Whether a link never moves; -1: the world.
  bool stands(int link) const { return link < 0 || links[link].is_static; }

 private:
  /// Takes in what was added to a list since the last call.
  struct NameIndex {
    std::unordered_map<std::string, int> first;
    std::size_t known = 0;
    template <class List>
    int find(const List& list, const std::string& wanted) {
      for (; known < list.size(); ++known) first.emplace(list[known].name, static_cast<int>(known));
      const auto found = first.find(wanted);
      return found == first.end() ? -1 : found->second;
    }
  };
  mutable NameIndex link_names_, joint_names_;
};

/// Makes every link's inertia one that a rigid body can have: principal moments that are positive
/// and of which none exceeds the sum of the others. The nearest one in the Frobenius norm is taken;
/// what changed is reported as approximate.
void repair_inertias(Context& context, RobotModel& robot);
/// Of a primitive or ellipsoid that is filled evenly, with this mass, or with this density where none
/// is given, in its own axes; nullopt: it is another shape, or has no volume.
std::optional<MassProperties> solid_mass(const Geometry& g, std::optional<double> mass,
                                         double density);

/// Makes the axes of universal joints perpendicular, as the scene language has them.
void square_axes(Context& context, RobotModel& robot);

/// Welds what fixed joints hold: shapes, frames and inertias of the child go to the parent, and the
/// child's name becomes a frame there. Links without mass become frames or are given a small mass,
/// which is reported. Limits that leave no freedom become fixed joints first.
void weld(Context& context, RobotModel& robot);

/// Shows the collision shapes of links of which nothing else is seen, and the box of the inertia of
/// those whose meshes cannot be read and of which nothing else is left; both are reported.
void show_unseen(Context& context, RobotModel& robot);

/// Finds the pairs of links that do not touch, by the bits of their shapes and by their models.
void separate_by_bits(Context& context, RobotModel& robot);

/// Marks what stands around the robot; see RobotLink::is_scenery.
void set_scenery_apart(Context& context, RobotModel& robot);

/// Names that the scene language takes, unique among bodies, joints, frames, drives and sensors;
/// what was renamed is reported.
void make_names(Context& context, RobotModel& robot);

/// A name that a scene takes, of the robot's.
std::string scene_name(std::string name);

/// Writes the scene, and fills `context.result.files` with the meshes that belong beside it.
void write_scene(Context& context, const RobotModel& robot);

/// The brightness of a PNG's points, by its first channel. Errors: no PNG, or too many points.
Result<HeightField> heights_of_picture(Context& context, const std::string& bytes,
                                       const Source& at);

/// Height fields of files, each read once.
class HeightFiles {
 public:
  using Reader = Result<HeightField> (*)(Context&, const std::string& bytes, const Source& at);
  /// The field that `reader` makes of the file, and `scale` brings to heights from 0 to 1. Throws
  /// Refused. Errors: those of `reader`, or the file cannot be read.
  const Result<HeightFieldPtr>& read(Context& context, const std::string& path, const Source& at,
                                     Reader reader, void (*scale)(HeightField&));

 private:
  std::map<std::string, Result<HeightFieldPtr>> fields_;  ///< by path
};

// ---- readers; each throws Refused, or leaves context.failed()

RobotModel read_urdf(Context& context, const XmlElement& root);
void read_srdf(Context& context, const XmlElement& root, RobotModel& robot);
RobotModel read_mjcf(Context& context, const XmlElement& root);
RobotModel read_sdf(Context& context, const XmlElement& root);

/// Expands xacro: a tree without elements and attributes of xacro, all `${…}` and `$(…)` replaced.
std::unique_ptr<XmlElement> expand_xacro(Context& context, const XmlElement& root);
bool uses_xacro(const XmlElement& root);

}  // namespace cogrsim::dsl::import
