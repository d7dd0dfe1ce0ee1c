// Reader of MJCF, MuJoCo's own format (mujoco.readthedocs.io, "XML reference"): default classes, bodies
// with several joints, geoms with and without masses, sites, loops by equalities, actuators, sensors.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/model/mass_properties.h"
#include "import/robot.h"

namespace cogrsim::dsl::import {

class MjcfReader {
 public:
  explicit MjcfReader(Context& context) : context_(context) {}
  RobotModel read(XmlElement& root);

 private:
  using Attributes = std::map<std::string, std::string>;
  /// Attributes by element: "geom" → size, rgba, …
  using Defaults = std::map<std::string, Attributes>;
  struct Mesh {
    std::string path;
    Vec3 scale = Vec3::Ones();
    Source at;
  };
  struct JointSource {
    const XmlElement* source = nullptr;
    XmlElement e;  ///< with its defaults
    Pose frame;    ///< of the <frame> around it, in the body
  };
  /// The content of a <body>, with the defaults of its classes.
  struct BodyParts {
    RobotLink link;
    std::vector<JointSource> joints;
    std::vector<RobotInertia> masses;  ///< of its geoms
    const XmlElement* inertial = nullptr;
    const XmlElement* mesh = nullptr;  ///< a geom among those of `masses`
    bool is_free = false;
    std::unique_ptr<XmlElement> free_joint;  ///< unless it is a <freejoint>, which has no laws
  };
  /// A length that depends on joints, as an actuator or a tendon has it: at_zero + Σ coef q, where no
  /// joint of the sum follows another.
  struct Transmission {
    std::vector<std::pair<int, double>> joints;  ///< index and coef, none 0
    double at_zero = 0.0;
    std::vector<std::string> followers;  ///< joints of the sum that follow those
  };
  /// Joints and their factors, in the order in which they came.
  struct JointSum {
    std::vector<int> order;
    std::map<int, double> factors, sizes;
    void add(int joint, double factor);
    /// Those that are not zero but for rounding.
    std::vector<std::pair<int, double>> terms() const;
  };
  /// The coordinates of one joint in MuJoCo's order.
  struct Coordinates {
    int joint = -1;
    std::size_t count = 1;     ///< 7: free, 4: ball
    std::optional<Pose> part;  ///< of a planar joint: its travel by one unit, or by one radian
    double ref = 0.0;          ///< where the scene's coordinate is zero
  };
  /// The target of a drive is scale * control + offset.
  struct Control {
    std::size_t drive = 0;
    double scale = 1.0, offset = 0.0;
    double least = -std::numeric_limits<double>::infinity();
    double most = std::numeric_limits<double>::infinity();
    double of(double control) const { return scale * std::clamp(control, least, most) + offset; }
  };
  struct Weld {
    int body1 = -1, body2 = -1;  ///< links; -1: the world
    Pose X_12;
    std::string name;
    Source at;
  };
  struct Tendon {
    XmlElement e;                                ///< with its defaults
    std::vector<std::pair<int, double>> joints;  ///< as written, none 0
    std::optional<Transmission> sum;             ///< once the couplings are known
  };
  /// Coefficients of a pair that act.
  struct Frictions {
    double sliding = 0.0, rolling = 0.0, spinning = 0.0;
    bool operator==(const Frictions&) const = default;
    Frictions larger(const Frictions& o) const {
      return {std::max(sliding, o.sliding), std::max(rolling, o.rolling),
              std::max(spinning, o.spinning)};
    }
  };
  /// What a geom says of its contacts.
  struct Surface {
    double priority = 0.0, dimensions = 3.0;
    std::array<double, 3> friction{1.0, 0.005, 0.0001};  ///< sliding, spinning, rolling
    double mix = 1.0;
    std::array<double, 2> solref{0.02, 1.0};
    std::array<double, 5> solimp{0.9, 0.95, 0.001, 0.5, 2.0};
    double margin = 0.0, gap = 0.0;
    std::string of;  ///< the geom that alone has it, where a <pair> names it
    bool operator==(const Surface& o) const;
    Frictions frictions() const;
    /// What it has beside friction, where that is not the default.
    MujocoAttributes of_mujoco() const;
    /// What holds between two.
    Surface with(const Surface& other) const;
  };
  /// Values of solref or solimp, as text, and how many have each.
  struct Softness {
    std::map<std::string, std::size_t> values;
    std::map<std::string, Source> at;
    std::size_t count = 0;
  };
  /// effort = gain * control + b0 + b1 * length + b2 * speed, or a speed.
  struct ActuatorLaw {
    RobotDrive::Mode mode = RobotDrive::Mode::torque;
    double gain = 1.0, b0 = 0.0, b1 = 0.0, b2 = 0.0;
    double damping_ratio = 0.0;  ///< of a position drive, instead of b2
    std::string note;            ///< what the drive does not have
  };

  // ---- files
  void include(XmlElement& in, int depth);
  /// Puts copies in the place of each <replicate> of a <worldbody>.
  void replicate(XmlElement& in, XmlElement& root, int depth);
  std::vector<std::unique_ptr<XmlElement>> copies_of(const XmlElement& e, XmlElement& root);

  // ---- settings
  void compiler(const XmlElement& e);
  void option(const XmlElement& e);
  void solver_option(const XmlElement& e, const std::string& key, const std::string& value);
  void flag(const XmlElement& e, const std::string& key, bool on);
  void settings(const XmlElement& root);
  /// What an element says takes the place of what was said for it.
  static void override_by(const XmlElement& e, Attributes& all);
  void default_class(const XmlElement& e, const std::string& parent, bool top);
  void assets(const XmlElement& e);
  void height_field(const XmlElement& source, const XmlElement& e, const std::string& key);
  /// From a picture, a file of MuJoCo's format, or the element. nullptr: none, which was reported.
  HeightFieldPtr heights(const XmlElement& source, const XmlElement& e);

  // ---- attributes with defaults
  /// The element with what its class, or the class of the bodies around it, says for it.
  /// `as`: the kind whose defaults these are, where it is not the element's name.
  XmlElement with_defaults(const XmlElement& e, const std::string& around,
                           const std::string& as = {});
  double angle(double value) const { return degrees_ ? value * kPi / 180.0 : value; }
  Quat orientation(const XmlElement& e);
  /// By three angles, in the order and units of the compiler.
  Quat turn(const Vec3& euler) const;
  /// In the body.
  Pose pose(const XmlElement& e);
  /// From one point to another, z along it, in the body; empty: not given, or no six numbers.
  std::optional<Pose> from_to(const XmlElement& source, const XmlElement& e, double& half);

  // ---- bodies
  /// Joints that actuators, equalities, tendons and sensors name: these keep their own axis. Geoms
  /// that pairs name.
  void note_joints(const XmlElement& e, int depth);
  void world(const XmlElement& e, const std::string& around);
  /// What is fixed to the world.
  RobotLink& ground();
  static std::string child_class(const XmlElement& e, const std::string& around);
  std::string name_of(const XmlElement& e, const char* kind);
  void body(const XmlElement& e, int parent, const std::string& around, int depth);
  void parts_of_body(const XmlElement& e, const std::string& around, BodyParts& parts);
  void part_of_body(const XmlElement& c, const std::string& around, BodyParts& parts);
  /// The bodies in a body, or in a <frame> of it.
  void bodies_in(const XmlElement& e, int parent, const std::string& around, int depth);
  /// Calls `use` with the poses of what is in a <frame>.
  template <class Use>
  void in_frame(const XmlElement& e, Use use) {
    const Pose outer = frame_;
    frame_ = pose(e);
    use();
    frame_ = outer;
  }
  RobotSensor camera(const XmlElement& source, const XmlElement& e);
  void set_total_mass();
  std::optional<RobotInertia> inertia_of(const BodyParts& parts);
  static RobotInertia sum(const std::vector<RobotInertia>& parts);
  std::optional<RobotInertia> given_inertia(const XmlElement& e);
  /// Adds the link with its joints; several joints need links between them. Returns its index.
  int attach(const XmlElement& e, RobotLink link, int parent, const Pose& X_PB,
             const std::vector<JointSource>& joints, bool is_free);
  /// Two sliders and a hinge, each perpendicular to the others, without anything else.
  bool planar(const std::vector<RobotJoint>& joints) const;
  void free_joint(const XmlElement& e, RobotLink& link);
  RobotJoint joint(const XmlElement& source, const XmlElement& e, const Pose& frame);

  // ---- geoms
  bool geom(const XmlElement& source, const XmlElement& e, const std::string& body, RobotShape& out,
            RobotInertia* inertia);
  /// Type and extents; of an ellipsoid its half axes, without points.
  bool geom_shape(const XmlElement& source, const XmlElement& e, const std::string& kind,
                  const std::string& what, RobotShape& out);
  bool geom_mesh(const XmlElement& source, const std::string* mesh, const std::string& kind,
                 const std::string& what, Geometry& g);
  void geom_appearance(const XmlElement& source, const XmlElement& e, RobotShape& out);
  /// Of a mesh of density 1 kg/m^3, in its file's axes and after its scale.
  const Result<MassProperties>& mesh_mass(const Geometry& g, const std::string& what);
  void geom_inertia(const XmlElement& source, const XmlElement& e, const RobotShape& shape,
                    RobotInertia* inertia, const std::string& what);

  // ---- surfaces
  /// The index of what a geom says of its contacts.
  int surface(const XmlElement& source, const XmlElement& e);
  int surface_index(const Surface& surface);
  void pair_surfaces();
  /// Frictions of all shapes, and of pairs that have others.
  void surfaces();
  /// Whether all contacts have the same softness, which is then the world's.
  bool same_softness(const std::vector<std::size_t>& used, bool has_ground);
  /// solref and solimp with this ending, of limits ("limit"), dry friction and equalities.
  MujocoAttributes note_softness(const XmlElement& source, const XmlElement& e, const char* about,
                                 const char* suffix);
  void write_softness();
  /// An attribute of the engine, unless it is the usual one. `differs`: what it is not right for.
  void of_mujoco(const Source& at, const std::string& what, const char* name,
                 const std::string& value, const std::string& usual, const std::string& differs);

  // ---- actuators, equalities, sensors, contacts
  void section(const XmlElement& e);
  void actuator(const XmlElement& source);
  void ball_motor(const XmlElement& source, const XmlElement& e, int joint, const ActuatorLaw& law);
  double inertia_on(int joint) const;
  /// Of the ball joints that motors drive.
  void make_gimbals();
  /// Empty: no drive has such a law, which was reported.
  std::optional<ActuatorLaw> actuator_law(const XmlElement& source, const XmlElement& e);
  /// What it acts on. Empty: it acts on no joints, which was reported.
  std::optional<Transmission> actuator_joints(const XmlElement& source, const XmlElement& e);
  /// The i-th number of an attribute.
  double parameter(const XmlElement& e, const char* name, std::size_t i, double otherwise);
  /// The range of "force" or "ctrl"; infinite where it bounds nothing.
  std::pair<double, double> bounds(const XmlElement& e, const std::string& of);
  std::pair<double, double> control_range(const XmlElement& e, const Transmission& acts);
  void bound_target(const Control& u, RobotDrive& drive) const;
  std::optional<Pose> relpose(const XmlElement& source, const XmlElement& e);
  void equality(const XmlElement& source);
  std::vector<double> polynomial(const XmlElement& source, const XmlElement& e);
  /// What of it a coupling does not have; empty: nothing.
  static std::string beyond_linear(const std::vector<double>& poly);
  void sensor(const XmlElement& e);
  struct SensorPlace {
    int link = -1;
    std::string name;
    Pose X;  ///< in the link
  };
  /// Empty: `why`.
  std::optional<SensorPlace> sensor_place(const XmlElement& e, std::string& why);
  void contact(const XmlElement& e);

  // ---- keyframes
  void keyframes(const XmlElement& root);
  void start_at(const XmlElement& key);
  /// Free bodies that a weld holds away from where they are start where it holds them.
  void start_at_welds();
  Pose start_of(int link) const;

  // ---- tendons
  void tendon(const XmlElement& source);
  /// `springlength`: one number or two; empty: not given.
  std::vector<double> spring_lengths(const XmlElement& e);
  void spatial_tendon(const XmlElement& source, const XmlElement& e);
  void tendon_equality(const XmlElement& source, const XmlElement& e,
                       const MujocoAttributes& softness);
  /// Spring, damping, friction and limits of a fixed tendon.
  void tendon_passive(Tendon& t);
  /// The sum without joints that follow others. Empty: they form a cycle, or are nested too deep.
  std::optional<Transmission> without_followers(const std::vector<std::pair<int, double>>& joints);
  /// Whether a joint or tendon has limits.
  bool is_limited(const XmlElement& e) const;
  bool leads_to(int from, int to);
  int joint_index(const std::string& name);
  double ref(int joint) const { return ref_of(joint_at(joint)); }
  double ref_of(const RobotJoint& joint) const;
  RobotJoint& joint_at(int index) { return robot_.joints[index]; }
  const RobotJoint& joint_at(int index) const { return robot_.joints[index]; }

  Context& context_;
  RobotModel robot_;
  std::map<std::string, Defaults> classes_;
  std::map<std::string, Mesh> meshes_;
  HeightFiles height_files_;
  std::map<std::string, Geometry> height_fields_;
  std::map<std::string, Result<MassProperties>> mesh_masses_;
  std::map<std::string, Color> materials_;
  std::map<std::string, std::pair<std::string, Pose>> sites_;  // link and pose
  std::set<std::string> encoders_, at_site_, used_joints_;
  std::map<std::string, double> refs_;  ///< of joints whose zero is another than MuJoCo's
  std::map<std::string, int> joint_indices_;
  std::vector<Tendon> tendons_;  ///< fixed ones
  std::vector<Weld> welds_;      ///< with a pose of their own
  std::map<std::string, std::size_t> tendon_indices_;
  std::size_t steps_left_ = 1'000'000;  ///< of searches among couplings
  std::vector<Coordinates> coordinates_;
  std::vector<std::vector<Control>> controls_;  ///< of each actuator
  std::set<std::string> read_geoms_;            ///< with a name
  std::set<std::string> paired_geoms_;          ///< of <pair>, which touch whatever their bits
  std::vector<XmlElement> pairs_;               ///< with their defaults
  std::map<int, std::vector<Vec3>> ball_axes_;  ///< of motors, by joint
  std::vector<Surface> surfaces_;
  std::map<std::pair<int, int>, Frictions> own_pairs_;  ///< by two surfaces
  std::map<std::string, Softness> softness_;            ///< by the engine's attribute
  std::set<std::string> disabled_;                      ///< flags
  bool degrees_ = true, auto_limits_ = true, exact_meshes_ = false, strip_path_ = false;
  std::string euler_ = "xyz", mesh_dir_, from_geoms_ = "auto";
  std::string touching_by_ = "all";  ///< which geoms touch: by their bits, by <pair>, or by both
  Pose frame_;                       ///< of the <frame>s around what is read, in the body
  std::size_t copies_ = 0;           ///< elements that <replicate> made
  double bound_mass_ = 0.0, bound_inertia_ = 0.0, total_mass_ = -1.0;
  double first_group_ = 0.0, last_group_ = 5.0;
  int unnamed_ = 0;
};

}  // namespace cogrsim::dsl::import
