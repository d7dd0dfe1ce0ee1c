// MJCF. Bodies have their poses at time 0, and each joint's `ref` is its initial coordinate, so that
// coordinates are those of the scene and limits, springs and couplings need no shift.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/model/joint_kinematics.h"
#include "export/export_tree.h"

namespace cogrsim::dsl::exporting {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class MjcfWriter {
 public:
  explicit MjcfWriter(ExportTree& tree)
      : tree_(tree), xml_("Written by cogrsim export from " + tree.model.name + ".") {}

  std::string write() {
    const SceneModel& m = tree_.model;
    children_.resize(tree_.links.size());
    for (std::size_t i = 0; i < tree_.links.size(); ++i)
      if (tree_.links[i].parent >= 0)
        children_[ExportTree::index(tree_.links[i].parent)].push_back(i);
    xml_.begin("mujoco").with("model", tree_.title());
    xml_.begin("compiler").with("angle", "radian").with("inertiafromgeom", "false").end();
    xml_.begin("option").with("timestep", m.physics.step).with("gravity", m.physics.gravity).end();
    tree_.exact(m.physics.origin, "physics", "step and gravity");
    assets();
    xml_.begin("worldbody");
    if (tree_.options.assembly.empty()) {
      for (const LightModel& l : m.lights) light(l);
      for (const ViewModel& v : m.views) {
        camera(tree_.unique_name("camera", v.name), v.X_WV, v.fov, 16.0 / 9.0);
        tree_.exact(v.origin, "view '" + v.name + "'", "is a camera of the world");
      }
    }
    for (std::size_t i = 0; i < tree_.links.size(); ++i)
      if (tree_.links[i].parent < 0) body(i);
    for (const ForceModel& f : m.forces)
      if (is_spring(f)) {
        if (tree_.link_of(f.body) < 0) site(site_name(f, 1), end_of(f.body, f.X_BE.p));
        if (tree_.link_of(f.other) < 0) site(site_name(f, 2), end_of(f.other, f.other_point));
      }
    xml_.end();
    excluded_pairs();
    equalities();
    tendons();
    actuators();
    sensors();
    keyframe();
    xml_.end();
    rest();
    return xml_.str();
  }

 private:
  const Body& body_of(const Link& l) const { return tree_.model.bodies[ExportTree::index(l.body)]; }

  void with_pose(const Pose& X) {
    if (!X.p.isZero()) xml_.with("pos", X.p);
    if (std::abs(X.q.w()) < 1.0)
      xml_.with("quat", fmt::format("{} {}", number(X.q.w()), numbers(X.q.vec())));
  }

  // ---- assets

  void assets() {
    xml_.begin("asset");
    std::set<int> meshes, grids;
    for (const Link& l : tree_.links)
      for (const Shape& s : body_of(l).shapes) {
        const bool mesh = s.type == ShapeType::mesh || s.type == ShapeType::convex_mesh;
        if (mesh && meshes.insert(s.mesh).second)
          xml_.begin("mesh")
              .with("name", fmt::format("mesh_{}", s.mesh))
              .with("file", tree_.mesh_file(s.mesh))
              .end();
        if (s.type == ShapeType::heightmap && grids.insert(s.heightmap).second) height_field(s);
      }
    xml_.end();
  }

  /// MuJoCo's file of heights: numbers of rows and columns, then floats, which it scales to 0 … 1.
  void height_field(const Shape& s) {
    const HeightGrid& g = *tree_.model.heightmaps[ExportTree::index(s.heightmap)];
    std::string bytes;
    const auto put = [&](const auto& value) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    put(std::int32_t{g.rows});
    put(std::int32_t{g.columns});
    for (const double h : g.heights) put(static_cast<float>(h));
    const std::string file =
        fmt::format("{}/heights_{}.bin", tree_.options.mesh_folder, s.heightmap);
    tree_.result.files.push_back({file, std::move(bytes)});
    const auto [low, high] = range_of(g);
    xml_.begin("hfield")
        .with("name", fmt::format("heights_{}", s.heightmap))
        .with("file", file)
        .with("size", fmt::format("{} {} {} {}", number(0.5 * g.size_x), number(0.5 * g.size_y),
                                  number(std::max(high - low, 1e-6)), number(kBelow)))
        .end();
  }
  static constexpr double kBelow = 0.1;  ///< thickness of a height field below its lowest point [m]
  static std::pair<double, double> range_of(const HeightGrid& g) {
    const auto [low, high] = std::minmax_element(g.heights.begin(), g.heights.end());
    return {*low, *high};
  }

  // ---- bodies

  void body(std::size_t i) {
    const Link& l = tree_.links[i];
    const Body& b = body_of(l);
    Pose X = b.X_WB;
    if (l.parent >= 0) X = body_of(tree_.links[ExportTree::index(l.parent)]).X_WB.inverse() * X;
    xml_.begin("body").with("name", tree_.body_name(l.body));
    with_pose(X);
    if (b.gravity_scale != 1.0) xml_.with("gravcomp", 1.0 - b.gravity_scale);
    if (b.kind == BodyKind::dynamic) {
      if (l.joint >= 0)
        joints(l);
      else
        free_joint(b, tree_.unique_name("joint", tree_.body_name(l.body) + "_free"));
      const Mat3& I = b.inertia;
      xml_.begin("inertial")
          .with("pos", b.com)
          .with("mass", b.mass)
          .with("fullinertia",
                numbers(I.diagonal()) + " " + numbers(Vec3(I(0, 1), I(0, 2), I(1, 2))))
          .end();
    }
    for (const Shape& s : b.shapes) geom(b, s);
    for (const NamedFrame& f : tree_.model.frames)
      if (!f.removed && f.body == l.body) {
        site(tree_.unique_name("site", f.name), f.X_BF);
        tree_.exact(f.origin, "frame '" + f.name + "'", "is a site");
      }
    for (std::size_t s = 0; s < tree_.model.sensors.size(); ++s) place_sensor(s, l.body);
    for (const ForceModel& f : tree_.model.forces)
      if (is_spring(f)) {
        if (f.body == l.body) site(site_name(f, 1), Pose(f.X_BE.p, Quat(1, 0, 0, 0)));
        if (f.other == l.body) site(site_name(f, 2), Pose(f.other_point, Quat(1, 0, 0, 0)));
      }
    for (const std::size_t child : children_[i]) body(child);
    xml_.end();
    const std::string element = "body '" + b.name + "'";
    if (b.kind == BodyKind::kinematic)
      tree_.approximate(b.origin, element, "is static; its prescribed motion is left out");
    else
      tree_.exact(b.origin, element);
  }

  void free_joint(const Body& b, const std::string& name) {
    xml_.begin("freejoint").with("name", name).end();
    add_q(b.X_WB.p);
    add_q({b.X_WB.q.w(), b.X_WB.q.x(), b.X_WB.q.y(), b.X_WB.q.z()});
    // MuJoCo's speeds of a free body: linear in world axes, angular in the body's.
    add_u(b.V_WB.linear);
    add_u(Vec3(b.X_WB.q.conjugate() * b.V_WB.angular));
  }
  void add_q(const Vec3& v) { q_.insert(q_.end(), v.data(), v.data() + 3); }
  void add_q(std::initializer_list<double> v) { q_.insert(q_.end(), v); }
  void add_u(const Vec3& v) { u_.insert(u_.end(), v.data(), v.data() + 3); }

  void joints(const Link& l) {
    const Joint& j = tree_.model.joints[ExportTree::index(l.joint)];
    const std::string element = "joint '" + j.name + "'";
    const std::string name = tree_.joint_name(l.joint);
    if (j.type == JointType::free) {
      if (l.parent >= 0) {
        tree_.left_out(j.origin, element, "MuJoCo's free joints are relative to the world only");
        return;
      }
      free_joint(body_of(l), name);
      tree_.exact(j.origin, element);
      return;
    }
    if (j.type == JointType::ball) {
      ball(l, j, name);
      return;
    }
    const std::vector<AxisStep> steps = axis_steps(j.type);
    // F's axes seen from M at time 0, for what stands in F.
    const Pose X_FM = joint_pose(j, j.position.data());
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const AxisStep& step = steps[i];
      Vec3 direction = step.direction;
      if (step.in_parent) direction = X_FM.q.conjugate() * direction;
      if (j.type == JointType::gimbal && i == 1)  // before the third axis turns it
        direction = Quat(Eigen::AngleAxisd(-j.position[2], Vec3::UnitZ())) * direction;
      const bool travel = j.type == JointType::screw && i == 1;
      const double ref = travel ? j.pitch / (2.0 * M_PI) * j.position[0]
                                : (i < j.position.size() ? j.position[i] : 0.0);
      const std::string own =
          i == 0 ? name : tree_.unique_name("joint", fmt::format("{}_{}", name, i + 1));
      names_[{l.joint, static_cast<int>(i)}] = own;
      xml_.begin("joint")
          .with("name", own)
          .with("type", step.turns ? "hinge" : "slide")
          .with("pos", l.X_CM.p)
          .with("axis", Vec3(l.X_CM.q * direction));
      if (ref != 0.0) xml_.with("ref", ref);
      if (!travel && i < j.axes.size()) axis_attributes(j.axes[i]);
      xml_.end();
      q_.push_back(ref);
      u_.push_back(travel ? j.pitch / (2.0 * M_PI) * j.velocity[0]
                          : (i < j.velocity.size() ? j.velocity[i] : 0.0));
    }
    if (j.type == JointType::screw) {
      screws_.push_back(l.joint);
      tree_.approximate(j.origin, element, "the coupling of angle and travel is soft in MuJoCo");
    } else {
      tree_.exact(j.origin, element,
                  steps.size() > 1 ? fmt::format("{} joints of the body", steps.size()) : "");
    }
  }

  void axis_attributes(const JointAxis& a) {
    if (a.has_limit())
      xml_.with("limited", "true")
          .with("range", fmt::format("{} {}", number(std::max(a.lower, -1e10)),
                                     number(std::min(a.upper, 1e10))));
    if (a.damping > 0.0) xml_.with("damping", a.damping);
    if (a.friction > 0.0) xml_.with("frictionloss", a.friction);
    if (a.stiffness > 0.0) xml_.with("stiffness", a.stiffness).with("springref", a.rest);
    if (a.rotor_inertia > 0.0) xml_.with("armature", a.rotor_inertia);
  }

  void ball(const Link& l, const Joint& j, const std::string& name) {
    const bool turned = j.position.size() == 4 && std::abs(j.position[0]) < 1.0 - 1e-12;
    xml_.begin("joint").with("name", name).with("type", "ball").with("pos", l.X_CM.p);
    std::string note;
    if (!j.axes.empty()) {
      JointAxis a = j.axes[0];
      if (turned && (a.has_limit() || a.stiffness > 0.0)) {
        note = "its limit and spring are left out: it does not start at its zero";
        a.upper = kInfinity;
        a.lower = -kInfinity;
        a.stiffness = 0.0;
      }
      a.lower = a.has_limit() ? 0.0 : a.lower;
      a.rest = 0.0;
      axis_attributes(a);
    }
    xml_.end();
    add_q({1.0, 0.0, 0.0, 0.0});
    const Vec3 w(j.velocity[0], j.velocity[1], j.velocity[2]);
    // From F to the body's axes.
    const Pose X_FM = joint_pose(j, j.position.data());
    add_u(Vec3(l.X_CM.q * (X_FM.q.conjugate() * w)));
    if (turned && note.empty())
      tree_.exact(j.origin, "joint '" + j.name + "'", "its zero is the initial orientation");
    else if (note.empty())
      tree_.exact(j.origin, "joint '" + j.name + "'");
    else
      tree_.approximate(j.origin, "joint '" + j.name + "'", note);
  }

  void geom(const Body& b, const Shape& s) {
    const std::string element = fmt::format("{} of body '{}'", to_string(s.type), b.name);
    const Material& m = tree_.model.materials[ExportTree::index(s.material)];
    SurfaceWritten written;
    written.friction = written.rolling = true;
    const std::string lost = s.collides && m.name.empty() ? lost_of(m, written) : "";
    Pose X = s.X_BS;
    xml_.begin("geom");
    switch (s.type) {
      case ShapeType::box:
        xml_.with("type", "box").with("size", Vec3(0.5 * s.size));
        break;
      case ShapeType::sphere:
        xml_.with("type", "sphere").with("size", s.radius);
        break;
      case ShapeType::cylinder:
      case ShapeType::capsule:
        xml_.with("type", to_string(s.type))
            .with("size", number(s.radius) + " " + number(0.5 * s.length));
        break;
      case ShapeType::plane:
        xml_.with("type", "plane").with("size", "0 0 1");
        break;
      case ShapeType::heightmap: {
        X = X * Pose(Vec3(0, 0,
                          range_of(*tree_.model.heightmaps[ExportTree::index(s.heightmap)]).first),
                     Quat(1, 0, 0, 0));
        xml_.with("type", "hfield").with("hfield", fmt::format("heights_{}", s.heightmap));
        break;
      }
      default:
        xml_.with("type", "mesh").with("mesh", fmt::format("mesh_{}", s.mesh));
    }
    with_pose(X);
    if (!s.collides)
      xml_.with("contype", "0").with("conaffinity", "0");
    else
      surface(m);
    if (!s.visible) xml_.with("group", "3");
    xml_.with("rgba", fmt::format("{} {} {} {}", number(m.color.r), number(m.color.g),
                                  number(m.color.b), number(m.color.a)));
    xml_.end();
    if (s.type == ShapeType::mesh && s.collides)
      tree_.approximate(s.origin, element, "MuJoCo collides with its convex hull");
    else if (s.type == ShapeType::heightmap)
      tree_.approximate(s.origin, element, "heights are rounded to floats, and it has a bottom");
    else if (!lost.empty())
      tree_.approximate(s.origin, element, lost);
    else
      tree_.exact(s.origin, element);
  }

  /// Contacts of MuJoCo have 3 dimensions with sliding friction, 4 with spinning, 6 with rolling too.
  void surface(const Material& m) {
    if (m.rolling_friction > 0.0 || m.spinning_friction > 0.0)
      xml_.with("condim", m.rolling_friction > 0.0 ? 6.0 : 4.0)
          .with("friction", numbers(Vec3(m.friction, m.spinning_friction, m.rolling_friction)));
    else
      xml_.with("friction", numbers(Vec3(m.friction, 0.005, 0.0001)));
  }

  void site(const std::string& name, const Pose& X) {
    xml_.begin("site").with("name", name);
    with_pose(X);
    xml_.end();
  }

  /// A camera of MuJoCo looks along -z with y up; ours along x with z up.
  void camera(const std::string& name, const Pose& X, double fov, double aspect) {
    Mat3 R;
    R.col(0) = -Vec3::UnitY();
    R.col(1) = Vec3::UnitZ();
    R.col(2) = -Vec3::UnitX();
    xml_.begin("camera").with("name", name);
    with_pose(Pose(X.p, (X.q * Quat(R)).normalized()));
    xml_.with("fovy", 2.0 * std::atan(std::tan(0.5 * fov) / aspect) * 180.0 / M_PI).end();
  }

  void light(const LightModel& l) {
    xml_.begin("light")
        .with("name", tree_.unique_name("light", l.name))
        .with("pos", l.X_WL.p)
        .with("dir", Vec3(l.X_WL.q * Vec3::UnitX()))
        .with("directional", l.type == LightModel::Type::directional ? "true" : "false")
        .with("castshadow", l.shadows ? "true" : "false")
        .with("diffuse", Vec3((l.intensity * Vec3(l.color.r, l.color.g, l.color.b)).cwiseMin(1.0)));
    if (l.type == LightModel::Type::point) xml_.with("cutoff", 180.0);
    if (l.type == LightModel::Type::spot) xml_.with("cutoff", l.cone * 180.0 / M_PI);
    xml_.end();
    tree_.approximate(l.origin, "light '" + l.name + "'", "MuJoCo's lights have other brightness");
  }

  // ---- what follows the bodies

  void excluded_pairs() {
    std::set<std::pair<int, int>> pairs;
    for (const auto& [a, b] : tree_.model.no_collide)
      if (tree_.link_of(a) >= 0 && tree_.link_of(b) >= 0) pairs.insert({a, b});
    for (std::size_t j = 0; j < tree_.model.joints.size(); ++j) {
      const Joint& joint = tree_.model.joints[j];
      if (tree_.joint_name(static_cast<int>(j)).empty()) continue;
      if (joint.bodies_collide)
        tree_.approximate(joint.origin, "bodies-collide of joint '" + joint.name + "'",
                          "MuJoCo never collides a body with its parent");
      else if (tree_.link_of(joint.parent) >= 0 && tree_.link_of(joint.child) >= 0)
        pairs.insert(std::minmax(joint.parent, joint.child));
    }
    if (pairs.empty()) return;
    xml_.begin("contact");
    for (const auto& [a, b] : pairs)
      xml_.begin("exclude")
          .with("body1", tree_.body_name(a))
          .with("body2", tree_.body_name(b))
          .end();
    xml_.end();
  }

  double ref(int joint) const {
    const Joint& j = tree_.model.joints[ExportTree::index(joint)];
    return j.position.empty() ? 0.0 : j.position[0];
  }
  bool has_joint(int joint) const { return names_.count({joint, 0}) != 0; }

  void equalities() {
    xml_.begin("equality");
    for (const int s : screws_)
      xml_.begin("joint")
          .with("joint1", names_.at({s, 1}))
          .with("joint2", names_.at({s, 0}))
          .with("polycoef",
                "0 " + number(tree_.model.joints[ExportTree::index(s)].pitch / (2.0 * M_PI)) +
                    " 0 0 0")
          .end();
    for (const Coupling& c : tree_.model.couplings) coupling(c);
    for (const int l : tree_.loops) loop(l);
    xml_.end();
  }

  /// MuJoCo's law has differences from the references: q - r = a0 + a1 (p - s).
  void coupling(const Coupling& c) {
    if (c.removed || !tree_.selected(c.assembly)) return;
    const std::string element = "coupling '" + c.name + "'";
    const bool whole = has_joint(c.joint) &&
                       std::all_of(c.terms.begin(), c.terms.end(),
                                   [&](const CouplingTerm& t) { return has_joint(t.joint); });
    if (!whole) {
      tree_.left_out(c.origin, element, "one of its joints is not written");
      return;
    }
    double offset = c.offset - ref(c.joint);
    for (const CouplingTerm& t : c.terms) offset += t.ratio * ref(t.joint);
    if (c.terms.size() == 1) {
      xml_.begin("joint")
          .with("joint1", names_.at({c.joint, 0}))
          .with("joint2", names_.at({c.terms[0].joint, 0}))
          .with("polycoef", number(offset) + " " + number(c.terms[0].ratio) + " 0 0 0")
          .end();
    } else {
      const std::string name = tree_.unique_name("tendon", c.name);
      xml_.begin("tendon")
          .with("tendon1", name)
          .with("polycoef", number(offset) + " 0 0 0 0")
          .end();
      couplings_.emplace_back(name, &c);
    }
    tree_.approximate(c.origin, element,
                      c.max_effort < kInfinity ? "is soft in MuJoCo, and its effort is not bounded"
                                               : "is soft in MuJoCo");
  }

  void loop(int index) {
    const Joint& j = tree_.model.joints[ExportTree::index(index)];
    const std::string element = "joint '" + j.name + "'";
    if (j.type != JointType::ball && j.type != JointType::hinge && j.type != JointType::fixed) {
      tree_.left_out(j.origin, element,
                     "closes a loop, and MuJoCo closes loops with points and welds only");
      return;
    }
    const bool swap = tree_.link_of(j.child) < 0;
    const int one = swap ? j.parent : j.child, two = swap ? j.child : j.parent;
    const Pose& X = swap ? j.X_PF : j.X_CM;
    if (tree_.link_of(one) < 0) return;
    const auto connect = [&](const char* kind, const Vec3& anchor) {
      xml_.begin(kind).with("body1", tree_.body_name(one));
      if (tree_.link_of(two) >= 0) xml_.with("body2", tree_.body_name(two));
      if (std::string(kind) == "connect") xml_.with("anchor", anchor);
      xml_.end();
    };
    if (j.type == JointType::fixed) {
      connect("weld", Vec3::Zero());
    } else {
      connect("connect", X.p);
      // Two points of the axis make a hinge.
      if (j.type == JointType::hinge) connect("connect", X * Vec3(0, 0, kAxisPoint));
    }
    const bool more = j.type == JointType::hinge && !j.axes.empty() &&
                      (j.axes[0].has_limit() || j.axes[0].damping > 0.0 ||
                       j.axes[0].friction > 0.0 || j.axes[0].stiffness > 0.0);
    tree_.approximate(
        j.origin, element,
        more ? "is soft in MuJoCo; its limit, damping, friction and spring are left out"
             : "is soft in MuJoCo");
  }
  static constexpr double kAxisPoint = 0.1;  ///< distance of the second point on a hinge's axis [m]

  static std::string site_name(const ForceModel& f, int end) {
    return fmt::format("{}_end_{}", f.name, end);
  }
  bool is_spring(const ForceModel& f) const {
    return f.kind == ForceModel::Kind::spring && !f.removed && tree_.selected(f.assembly);
  }
  /// A point of a body that is not written, or of the world, in the world at time 0.
  Pose end_of(int body, const Vec3& point) const {
    const Vec3 p = body < 0 ? point : tree_.model.bodies[ExportTree::index(body)].X_WB * point;
    return {p, Quat(1, 0, 0, 0)};
  }

  void tendons() {
    xml_.begin("tendon");
    for (const auto& [name, c] : couplings_) {
      xml_.begin("fixed").with("name", name);
      xml_.begin("joint").with("joint", names_.at({c->joint, 0})).with("coef", 1.0).end();
      for (const CouplingTerm& t : c->terms)
        xml_.begin("joint").with("joint", names_.at({t.joint, 0})).with("coef", -t.ratio).end();
      xml_.end();
    }
    for (const ForceModel& f : tree_.model.forces) {
      if (!is_spring(f)) continue;
      xml_.begin("spatial")
          .with("name", tree_.unique_name("tendon", f.name))
          .with("stiffness", f.stiffness)
          .with("damping", f.damping)
          .with("springlength", f.cable ? "0 " + number(f.length) : number(f.length));
      xml_.begin("site").with("site", site_name(f, 1)).end();
      xml_.begin("site").with("site", site_name(f, 2)).end();
      xml_.end();
      if (f.cable && f.damping > 0.0)
        tree_.approximate(f.origin, "spring '" + f.name + "'", "damps also where it is slack");
      else
        tree_.exact(f.origin, "spring '" + f.name + "'", "is a spatial tendon");
    }
    xml_.end();
  }

  void actuators() {
    xml_.begin("actuator");
    for (const Motor& m : tree_.model.motors)
      if (!m.removed && tree_.selected(m.assembly)) actuator(m);
    xml_.end();
  }

  void bound(const char* flag, const char* range, double most) {
    if (most < kInfinity) xml_.with(flag, "true").with(range, number(-most) + " " + number(most));
  }

  void actuator(const Motor& m) {
    const std::string element = "motor '" + m.name + "'";
    const auto joint = names_.find({m.joint, m.axis});
    if (joint == names_.end()) {
      tree_.left_out(m.origin, element, "its joint is not written");
      return;
    }
    const Joint& j = tree_.model.joints[ExportTree::index(m.joint)];
    const double q0 = j.position[ExportTree::index(m.axis)];
    const double effort = std::min(m.max_effort, j.axes[ExportTree::index(m.axis)].max_effort);
    double target = m.target.value_or(0.0);
    if (!m.target_signal.empty())
      tree_.left_out(m.origin, "target-signal of " + element, "MJCF has no targets over time");
    if (m.stall_effort < kInfinity)
      tree_.left_out(m.origin, "curve of " + element, "MJCF limits efforts at all speeds alike");
    if (m.delay > 0.0) tree_.left_out(m.origin, "delay of " + element, "it is not written");
    const std::string name = tree_.unique_name("actuator", m.name);
    // effort = gain * control + b1 q + b2 u.
    const auto general = [&](double gain, double b1, double b2) {
      xml_.begin("general")
          .with("name", name)
          .with("joint", joint->second)
          .with("gainprm", gain)
          .with("biastype", "affine")
          .with("biasprm", numbers(Vec3(0.0, b1, b2)));
    };
    switch (m.mode) {
      case MotorMode::torque:
        xml_.begin("motor").with("name", name).with("joint", joint->second);
        bound("forcelimited", "forcerange", effort);
        tree_.exact(m.origin, element);
        break;
      case MotorMode::velocity: {
        // An ideal speed source has no gain; the servo's time constant is five steps.
        const double kv = inertia_on(j, m.axis) / (5.0 * tree_.model.physics.step);
        general(kv, 0.0, -kv);
        bound("forcelimited", "forcerange", effort);
        tree_.approximate(m.origin, element,
                          fmt::format("is a speed servo with the gain {}", number(kv)));
        break;
      }
      case MotorMode::position: {
        const double inertia = inertia_on(j, m.axis);
        const double kp = inertia / (m.response * m.response), kd = 2.0 * inertia / m.response;
        general(kp, -kp, -kd);
        bound("forcelimited", "forcerange", effort);
        target = m.target.value_or(q0);
        tree_.approximate(
            m.origin, element,
            fmt::format("is a servo with the gains {} and {}", number(kp), number(kd)));
        break;
      }
      case MotorMode::servo:
        general(m.kp, -m.kp, -m.kd);
        bound("forcelimited", "forcerange", effort);
        target = m.target.value_or(q0);
        if (m.ki != 0.0)
          tree_.approximate(m.origin, element, "its integral gain is left out");
        else
          tree_.exact(m.origin, element);
        break;
      case MotorMode::dc: {
        const double gain = m.gear * m.kt / m.resistance;
        general(gain, 0.0, -gain * m.ke * m.gear);
        bound("ctrllimited", "ctrlrange", m.max_voltage);
        bound("forcelimited", "forcerange", std::min(effort, m.gear * m.kt * m.max_current));
        tree_.exact(m.origin, element);
        break;
      }
    }
    // A range has two ends; what is beyond all numbers bounds nothing.
    const auto end = [](double v) { return number(std::clamp(v, -1e9, 1e9)); };
    if (m.mode != MotorMode::dc && (m.min_target > -kInfinity || m.max_target < kInfinity))
      xml_.with("ctrllimited", "true")
          .with("ctrlrange", end(m.min_target) + " " + end(m.max_target));
    xml_.end();
    controls_.push_back(target);
  }

  /// Inertia of the joint's child about its axis [kg m^2], or its mass [kg].
  double inertia_on(const Joint& j, int axis) const {
    const Body& b = tree_.model.bodies[ExportTree::index(
        j.child >= 0 && tree_.model.bodies[ExportTree::index(j.child)].kind == BodyKind::dynamic
            ? j.child
            : j.parent)];
    const JointAxis& a = j.axes[ExportTree::index(axis)];
    if (!axis_turns(j.type, axis)) return b.mass + a.rotor_inertia;
    const Pose& X =
        &b == &tree_.model.bodies[ExportTree::index(std::max(j.child, 0))] ? j.X_CM : j.X_PF;
    const Vec3 z = X.q * Vec3::UnitZ(), r = b.com - X.p;
    return z.dot(b.inertia * z) + b.mass * r.cross(z).squaredNorm() + a.rotor_inertia;
  }

  // ---- sensors

  void place_sensor(std::size_t index, int body) {
    const SensorModel& s = tree_.model.sensors[index];
    if (s.removed || !tree_.selected(s.assembly)) return;
    if (s.type == "force-torque") {
      if (s.joint < 0) return;
      const Joint& j = tree_.model.joints[ExportTree::index(s.joint)];
      if (j.child != body) return;
      site(sensor_site(index), j.X_CM);
      placed_.insert(index);
      return;
    }
    if (s.body != body) return;
    if (s.type == "camera") {
      double columns = 320.0, rows = 240.0, fov = M_PI / 3.0;
      if (const auto r = s.parameters.find("resolution"); r != s.parameters.end())
        if (const auto* v = std::get_if<std::vector<double>>(&r->second); v && v->size() == 2)
          columns = (*v)[0], rows = (*v)[1];
      if (const auto f = s.parameters.find("fov"); f != s.parameters.end())
        if (const auto* v = std::get_if<double>(&f->second)) fov = *v;
      camera(tree_.unique_name("camera", s.name), s.X_BS, fov, columns / rows);
      tree_.approximate(s.origin, "camera '" + s.name + "'",
                        "has its pose and opening angle; resolution, rate, noise and lens are "
                        "those of the program that draws");
      written_.insert(index);
    } else if (s.type == "imu" || s.type == "pose") {
      site(sensor_site(index), s.X_BS);
      placed_.insert(index);
    }
  }
  static std::string sensor_site(std::size_t index) { return fmt::format("sensor_{}", index + 1); }

  void sensors() {
    xml_.begin("sensor");
    for (std::size_t i = 0; i < tree_.model.sensors.size(); ++i) {
      const SensorModel& s = tree_.model.sensors[i];
      if (s.removed || !tree_.selected(s.assembly)) continue;
      const auto part = [&](const char* kind, const char* suffix) {
        xml_.begin(kind).with("name", tree_.unique_name("sensor", s.name + suffix));
      };
      const auto at_site = [&](const char* kind, const char* suffix) {
        part(kind, suffix);
        xml_.with("site", sensor_site(i)).end();
      };
      if (placed_.count(i) != 0 && s.type == "imu") {
        at_site("accelerometer", "_acceleration");
        at_site("gyro", "_gyro");
      } else if (placed_.count(i) != 0 && s.type == "force-torque") {
        at_site("force", "_force");
        at_site("torque", "_torque");
      } else if (placed_.count(i) != 0 && s.type == "pose") {
        for (const auto& [kind, suffix] :
             {std::pair{"framepos", "_position"}, std::pair{"framequat", "_orientation"}}) {
          part(kind, suffix);
          xml_.with("objtype", "site").with("objname", sensor_site(i)).end();
        }
      } else if (s.type == "encoder" && s.joint >= 0) {
        int axis = 0;
        if (const auto a = s.parameters.find("axis"); a != s.parameters.end())
          if (const auto* n = std::get_if<std::int64_t>(&a->second))
            axis = static_cast<int>(*n) - 1;
        const auto joint = names_.find({s.joint, axis});
        if (joint == names_.end()) continue;
        part("jointpos", "_position");
        xml_.with("joint", joint->second).end();
        part("jointvel", "_speed");
        xml_.with("joint", joint->second).end();
      } else {
        continue;
      }
      written_.insert(i);
      const std::string element = fmt::format("{} '{}'", s.type, s.name);
      if (s.noise.empty() && s.rate == 0.0 && s.latency == 0.0)
        tree_.exact(s.origin, element);
      else
        tree_.approximate(s.origin, element, "its rate, latency and noise are left out");
    }
    xml_.end();
  }

  void keyframe() {
    std::string q, u, c;
    for (const double x : q_) q += (q.empty() ? "" : " ") + number(x);
    for (const double x : u_) u += (u.empty() ? "" : " ") + number(x);
    for (const double x : controls_) c += (c.empty() ? "" : " ") + number(x);
    if (q.empty()) return;
    xml_.begin("keyframe");
    xml_.begin("key").with("name", "start").with("qpos", q).with("qvel", u);
    if (!c.empty()) xml_.with("ctrl", c);
    xml_.end();
    xml_.end();
  }

  void rest() {
    const SceneModel& m = tree_.model;
    for (std::size_t i = 0; i < m.sensors.size(); ++i)
      if (!m.sensors[i].removed && tree_.selected(m.sensors[i].assembly) && written_.count(i) == 0)
        tree_.left_out(m.sensors[i].origin,
                       fmt::format("{} '{}'", m.sensors[i].type, m.sensors[i].name),
                       "MuJoCo has no such sensor");
    for (const ForceModel& f : m.forces)
      if (!f.removed && tree_.selected(f.assembly) && f.kind != ForceModel::Kind::spring)
        tree_.left_out(f.origin, "force '" + f.name + "'",
                       "MuJoCo has no such element; a program sets xfrc_applied");
    for (const Material& material : m.materials) {
      if (material.name.empty()) continue;
      std::string lost = material.restitution > 0.0 ? "its restitution is left out" : "";
      if (!material.texture.empty())
        lost += lost.empty() ? "its texture is left out" : "; its texture is left out";
      if (lost.empty())
        tree_.exact(material.origin, "material '" + material.name + "'");
      else
        tree_.approximate(material.origin, "material '" + material.name + "'", lost);
    }
    tree_.report_pairs("MuJoCo takes the larger of two", CombineRule::max);
    for (const MaterialPair& pair : m.material_pairs)
      tree_.left_out(pair.origin, "contact between materials",
                     "MuJoCo has pairs of shapes, not of materials");
  }

  ExportTree& tree_;
  XmlWriter xml_;
  std::vector<std::vector<std::size_t>> children_;                  ///< links by link
  std::map<std::pair<int, int>, std::string> names_;                ///< by joint and axis
  std::vector<int> screws_;                                         ///< joints
  std::vector<std::pair<std::string, const Coupling*>> couplings_;  ///< those that are tendons
  std::set<std::size_t> placed_, written_;                          ///< sensors
  std::vector<double> q_, u_, controls_;                            ///< of the keyframe
};

}  // namespace

std::string write_mjcf(ExportTree& tree) { return MjcfWriter(tree).write(); }

}  // namespace cogrsim::dsl::exporting
