// Writes a scene in MuJoCo's language, MJCF.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "convert.h"
#include "program.h"
#include "surfaces.h"

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/hull_faces.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/body_trees.h"

namespace cogrsim::mujoco {

namespace {

constexpr double kFarthest = 1e9;  // [m]; beyond mjMAXVAL, 1e10, MuJoCo resets

/// A kinematic body against all others together: no force moves it, or turns it by a lever [m].
constexpr double kHeavier = 1e8, kHeavierLever = 10.0;

std::string text(const Vec3& v) { return numbers(v.data(), 3); }
std::string text(const Quat& q) {
  return numbers(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()).data(), 4);
}
bool is_far(const Pose& X) { return !(X.p.cwiseAbs().maxCoeff() < kFarthest); }

/// One of MuJoCo's joints of one axis.
struct Axis {
  const char* type = "hinge";
  int coordinate = 0;  ///< of the scene's joint; of a screw both are 0
  Vec3 along;          ///< in the moved body
};

class Writer {
 public:
  explicit Writer(Program& program) : out_(program), scene_(*program.scene) {}

  Result<std::string> write();

 private:
  std::size_t size() const { return scene_.bodies.size(); }
  const Vec3& origin(int b) const { return out_.origins[b]; }
  const Body& body(int b) const { return scene_.bodies[b]; }
  const Joint& joint(int j) const { return scene_.joints[j]; }
  bool grounded(int b) const { return b == kWorld || body(b).kind != BodyKind::dynamic; }

  Result<> check_loop(const Joint& joint) const;
  void grow_trees();
  void find_exclusions();
  Result<> write_body(int b);
  Result<> write_geoms(int b, const Pose& X);
  Result<std::string> geom_form(const Shape& shape, Pose& X);
  void write_joint(int j);
  void write_equality(int j);
  void write_couplings();
  void write_actuators();
  std::string inertial(int b) const;

  Program& out_;
  const SceneModel& scene_;
  std::string assets_, bodies_, contacts_, equalities_, tendons_, actuators_;
  BodyTrees trees_;
  std::vector<char> own_mujoco_body_;  ///< by static body: MuJoCo has it as a body
  std::vector<SurfaceGeom> surface_geoms_;
};

Result<> Writer::check_loop(const Joint& joint) const {
  const bool has_type = joint.type == JointType::hinge || joint.type == JointType::ball ||
                        joint.type == JointType::fixed;
  const bool lawless = std::all_of(joint.axes.begin(), joint.axes.end(), [](const JointAxis& a) {
    return !a.has_limit() && a.damping == 0 && a.friction == 0 && a.stiffness == 0;
  });
  const bool driven = std::any_of(scene_.motors.begin(), scene_.motors.end(), [&](const Motor& m) {
    return !m.removed && &this->joint(m.joint) == &joint;
  });
  if (has_type && lawless && !driven) return {};
  return fail("joint '" + joint.name + "': " +
                  (has_type ? "it closes a loop or attaches bodies to each other: MuJoCo's "
                              "constraints for that have no limits, springs, dampers, friction or "
                              "motors"
                            : std::string("MuJoCo closes no loop with a ") + to_string(joint.type) +
                                  " joint, and attaches no bodies by one"),
              source_position(scene_, joint.origin),
              "let another joint of the loop be the last one in the file, or attach by a plain "
              "hinge, ball or fixed joint");
}

void Writer::grow_trees() {
  trees_ = grow_body_trees(scene_, [&](std::size_t j) { return out_.references[j].attached; });
  for (std::size_t b = 0; b < size(); ++b) {
    if (trees_.joint[b] < 0) continue;
    TreeJoint& in_tree = out_.joints[trees_.joint[b]];
    in_tree.body = 0;  // known when it is compiled
    in_tree.reversed = joint(trees_.joint[b]).parent == static_cast<int>(b);
  }
}

void Writer::find_exclusions() {
  const CollisionFilter filter(scene_);
  std::vector<BodyPair> pairs = scene_.no_collide;
  for (const Joint& it : scene_.joints) {
    if (it.removed || it.parent == kWorld || it.child == kWorld) continue;
    pairs.push_back(std::minmax(it.parent, it.child));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  own_mujoco_body_.assign(size(), 0);
  for (std::size_t b = 0; b < size(); ++b) own_mujoco_body_[b] = !trees_.children[b].empty();
  for (const auto& [a, b] : pairs) {
    if (body(a).removed || body(b).removed || filter.collide(a, b)) continue;
    if (grounded(a) && grounded(b)) continue;  // by contype and conaffinity
    own_mujoco_body_[a] = own_mujoco_body_[b] = 1;
    contacts_ += fmt::format("<exclude body1=\"b{}\" body2=\"b{}\"/>\n", a, b);
  }
}

std::string Writer::inertial(int b) const {
  const Body& it = body(b);
  if (it.kind == BodyKind::kinematic) {
    double mass = kHeavier;
    for (const Body& other : scene_.bodies)
      if (other.kind == BodyKind::dynamic) mass += kHeavier * other.mass;
    const Vec3 moments = Vec3::Constant(kHeavierLever * kHeavierLever * mass);
    return fmt::format("<inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"{}\"/>\n", mass,
                       text(moments));
  }
  Vec3 moments = it.inertia.diagonal();
  Quat principal(1, 0, 0, 0);
  if ((it.inertia - Mat3(moments.asDiagonal())).cwiseAbs().maxCoeff() > 0.0) {
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(it.inertia);
    Mat3 R = axes.eigenvectors();
    if (R.determinant() < 0) R.col(2) *= -1.0;
    moments = axes.eigenvalues();
    principal = Quat(R);
  }
  // A flat body's largest moment is the sum of the others, and after rounding may be a little more.
  Eigen::Index largest = 0;
  const double rest = moments.sum() - moments.maxCoeff(&largest);
  if (moments[largest] > rest) moments[largest] = rest * (1.0 - 1e-15);
  return fmt::format(
      "<inertial pos=\"{}\" {}mass=\"{}\" diaginertia=\"{}\"/>\n", text(Vec3(it.com - origin(b))),
      principal.w() == 1 ? "" : "quat=\"" + text(principal) + "\" ", it.mass, text(moments));
}

Result<std::string> Writer::geom_form(const Shape& shape, Pose& X) {
  const double r = shape.radius, half = 0.5 * shape.length;
  switch (shape.type) {
    case ShapeType::box:
      return "type=\"box\" size=\"" + text(Vec3(0.5 * shape.size)) + '"';
    case ShapeType::sphere:
      return fmt::format("type=\"sphere\" size=\"{}\"", r);
    case ShapeType::cylinder:
      return fmt::format("type=\"cylinder\" size=\"{} {}\"", r, half);
    case ShapeType::capsule:
      if (!(half > 0)) return fmt::format("type=\"sphere\" size=\"{}\"", r);
      return fmt::format("type=\"capsule\" size=\"{} {}\"", r, half);
    case ShapeType::plane:
      return std::string("type=\"plane\" size=\"0 0 1\"");
    case ShapeType::convex_mesh: {
      const HullFaces hull = hull_faces(*scene_.meshes[shape.mesh], 1000);
      if (hull.vertices.size() < 4) break;
      const Vec3 middle = hull.middle();
      // MuJoCo stores vertices as floats: relative to the middle, where they are rounded least.
      std::string vertices;
      for (const Vec3& v : hull.vertices) vertices += text(Vec3(v - middle)) + ' ';
      X = X * Pose(middle, Quat(1, 0, 0, 0));
      const std::string name = "m" + std::to_string(out_.geoms.size());
      assets_ += fmt::format("<mesh name=\"{}\" vertex=\"{}\"/>\n", name, vertices);
      return "type=\"mesh\" mesh=\"" + name + '"';
    }
    case ShapeType::heightmap: {
      const HeightGrid& grid = *scene_.heightmaps[shape.heightmap];
      const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
      const double rise = std::max(*high - *low, 1e-6), base = std::max(1.0, rise);
      X = X * Pose(Vec3(0, 0, *low), Quat(1, 0, 0, 0));
      const std::string name = "h" + std::to_string(out_.geoms.size());
      assets_ +=
          fmt::format("<hfield name=\"{}\" nrow=\"{}\" ncol=\"{}\" size=\"{} {} {} {}\"/>\n", name,
                      grid.rows, grid.columns, 0.5 * grid.size_x, 0.5 * grid.size_y, rise, base);
      return "type=\"hfield\" hfield=\"" + name + '"';
    }
    case ShapeType::mesh:
      break;
  }
  return fail("shape '" + shape.name +
                  "': MuJoCo has meshes as their convex hulls only, and this " + "one " +
                  (shape.type == ShapeType::mesh ? "is not convex" : "has no volume"),
              source_position(scene_, shape.origin), "make it of convex meshes");
}

Result<> Writer::write_geoms(int b, const Pose& X_WB) {
  const Body& it = body(b);
  const bool mobile = it.kind == BodyKind::dynamic;
  for (std::size_t s = 0; s < it.shapes.size(); ++s) {
    const Shape& shape = it.shapes[s];
    Pose X = X_WB * shape.X_BS;
    if (!shape.collides || is_far(X)) continue;
    if (it.kind != BodyKind::static_body && is_surface(shape.type))
      return fail("body '" + it.name + "': MuJoCo has a " + to_string(shape.type) +
                      " on static bodies only",
                  source_position(scene_, it.origin),
                  "make the body static, or give it another shape");
    const auto form = geom_form(shape, X);
    if (!form) return tl::unexpected(form.error());
    surface_geoms_.push_back({b, shape.material, mobile});
    // What does not move does not meet its like.
    bodies_ += fmt::format(
        "<geom name=\"g{}\" class=\"s{}\" {} pos=\"{}\" quat=\"{}\" contype=\"{}\" "
        "conaffinity=\"{}\"/>\n",
        out_.geoms.size(), shape.material, *form, text(X.p), text(X.q), mobile ? 1 : 2,
        mobile ? 3 : 1);
    out_.geoms.emplace_back(b, static_cast<int>(s));
  }
  return {};
}

void Writer::write_joint(int j) {
  const Joint& it = joint(j);
  TreeJoint& in_tree = out_.joints[j];
  const bool back = in_tree.reversed;
  // The moved body's joint frame, where all coordinates are zero that of M and of F.
  const Pose& X_BN = back ? it.X_PF : it.X_CM;
  const bool ball = it.type == JointType::ball;
  const auto along = [&](const Vec3& axis) -> Vec3 {
    return cleaned(X_BN.q * axis) * (back ? -1.0 : 1.0);
  };
  std::vector<Axis> axes;
  for (int i = 0; i < (ball ? 0 : speed_count(it.type)); ++i)
    axes.push_back(
        {axis_turns(it.type, i) ? "hinge" : "slide", i, along(axis_direction(it.type, i))});
  if (it.type == JointType::screw) axes.push_back({"slide", 0, axes[0].along});
  if (ball) axes.push_back({"ball", 0, Vec3::UnitZ()});
  // Seen from the child they come in the other order.
  if (back && (it.type == JointType::universal || it.type == JointType::gimbal))
    std::reverse(axes.begin(), axes.end());
  if (back && it.type == JointType::planar) std::rotate(axes.begin(), axes.begin() + 2, axes.end());
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Axis& axis = axes[i];
    const bool slave = it.type == JointType::screw && i == 1;
    const double slope = it.pitch / (2.0 * kPi);
    if (!slave) in_tree.axis[axis.coordinate] = static_cast<int>(i);
    bodies_ += fmt::format("<joint name=\"j{}_{}\" type=\"{}\" pos=\"{}\" ", j, i, axis.type,
                           text(X_BN.p));
    if (!ball) bodies_ += fmt::format("axis=\"{}\" ", text(axis.along));
    const JointAxis& law = it.axes[axis.coordinate];
    if (!slave) {
      bodies_ += fmt::format(
          "damping=\"{}\" frictionloss=\"{}\" stiffness=\"{}\" armature=\"{}\" {} ", law.damping,
          law.friction, law.stiffness, law.rotor_inertia, out_.options.joint(it));
      if (!ball) bodies_ += fmt::format("springref=\"{}\" ", law.rest);
      // The bounds themselves may be one number, or infinite, and are set in the compiled model.
      if (law.has_limit()) bodies_ += "limited=\"true\" range=\"0 1\" ";
    } else {
      equalities_ +=
          fmt::format("<joint joint1=\"j{0}_1\" joint2=\"j{0}_0\" polycoef=\"0 {1} 0 0 0\" {2}/>\n",
                      j, slope, out_.options.equality(it.engine_options));
    }
    bodies_ += "/>\n";
  }
}

Result<> Writer::write_body(int b) {
  const auto i = static_cast<std::size_t>(b);
  const Body& it = body(b);
  Pose X = it.kind == BodyKind::static_body ? out_.static_poses[i] : it.X_WB;
  if (trees_.joint[i] >= 0) {
    const Reference& at = out_.references[trees_.joint[i]];
    X = joint(trees_.joint[i]).child == b ? at.X_PC : at.X_PC.inverse();
    if (trees_.parent[i] != kWorld) X.p -= origin(trees_.parent[i]);
  }
  if (it.kind == BodyKind::static_body && !own_mujoco_body_[i]) return write_geoms(b, X);
  X.p += X.q * origin(b);
  if (is_far(X)) X = Pose();  // about to diverge: the step reports it
  bodies_ += fmt::format("<body name=\"b{}\" pos=\"{}\" quat=\"{}\">\n", b, text(X.p), text(X.q));
  if (trees_.joint[i] >= 0) {
    write_joint(trees_.joint[i]);
  } else if (it.kind != BodyKind::static_body) {
    bodies_ += fmt::format("<freejoint name=\"f{}\"/>\n", b);
  }
  if (it.kind != BodyKind::static_body) bodies_ += inertial(b);
  if (auto written = write_geoms(b, {Vec3(-origin(b)), Quat(1, 0, 0, 0)}); !written) return written;
  for (const int child : trees_.children[i])
    if (auto written = write_body(child); !written) return written;
  bodies_ += "</body>\n";
  return {};
}

void Writer::write_equality(int j) {
  const Joint& it = joint(j);
  const auto name = [](int b) {
    return b == kWorld ? std::string("world") : fmt::format("b{}", b);
  };
  const std::string ends = fmt::format("body1=\"{}\" body2=\"{}\" {}", name(it.parent),
                                       name(it.child), out_.options.equality(it.engine_options));
  if (it.type == JointType::fixed) {
    equalities_ += fmt::format("<weld name=\"e{}_0\" {}/>\n", j, ends);
    return;
  }
  // A hinge is held at two points of its pin, as far apart as the body is large.
  const Body& held = body(grounded(it.child) ? it.parent : it.child);
  const double half = std::sqrt(held.inertia.diagonal().maxCoeff() / held.mass);
  const Vec3 pin = half * cleaned(it.X_PF.q * Vec3::UnitZ());
  int i = 0;
  for (const double side : {1.0, -1.0}) {
    const Vec3 anchor = it.X_PF.p + (it.type == JointType::ball ? 0.0 : side) * pin -
                        (it.parent == kWorld ? Vec3(0, 0, 0) : origin(it.parent));
    equalities_ +=
        fmt::format("<connect name=\"e{}_{}\" {} anchor=\"{}\"/>\n", j, i++, ends, text(anchor));
    if (it.type == JointType::ball) break;
  }
}

// One joint that follows one other as MuJoCo has it. Else a tendon whose length is that of the joint less ratio times that of the others, held at the
// offset: MuJoCo takes off its length in the reference, where all are zero.
void Writer::write_couplings() {
  for (std::size_t k = 0; k < scene_.couplings.size(); ++k) {
    const Coupling& it = scene_.couplings[k];
    std::vector<CouplingTerm> terms{{it.joint, -1.0}};
    terms.insert(terms.end(), it.terms.begin(), it.terms.end());
    const auto held = [&](const CouplingTerm& t) { return out_.joints[t.joint].body >= 0; };
    if (it.removed || !std::all_of(terms.begin(), terms.end(), held)) continue;
    const std::string soft = out_.options.equality(it.engine_options);
    if (it.terms.size() == 1) {
      equalities_ +=
          fmt::format("<joint joint1=\"j{}_0\" joint2=\"j{}_0\" polycoef=\"{} {} 0 0 0\" {}/>\n",
                      it.joint, it.terms[0].joint, it.offset, it.terms[0].ratio, soft);
      continue;
    }
    tendons_ += fmt::format("<fixed name=\"t{}\">", k);
    for (const CouplingTerm& t : terms)
      tendons_ += fmt::format("<joint joint=\"j{}_0\" coef=\"{}\"/>", t.joint, -t.ratio);
    tendons_ += "</fixed>\n";
    equalities_ +=
        fmt::format("<tendon tendon1=\"t{}\" polycoef=\"{} 0 0 0 0\" {}/>\n", k, it.offset, soft);
  }
}

void Writer::write_actuators() {
  int count = 0;
  for (std::size_t m = 0; m < scene_.motors.size(); ++m) {
    const Motor& motor = scene_.motors[m];
    if (motor.removed || joint(motor.joint).removed) continue;
    const TreeJoint& in_tree = out_.joints[motor.joint];
    if (in_tree.body < 0) continue;  // both its bodies are part of the ground
    // Gains and bounds are given in every step.
    actuators_ += fmt::format(
        "<general joint=\"j{}_{}\" biastype=\"affine\" forcelimited=\"true\" forcerange=\"-1 "
        "1\"/>\n",
        motor.joint, in_tree.axis[motor.axis]);
    out_.actuators[m] = count++;
  }
}

Result<std::string> Writer::write() {
  out_.joints.assign(scene_.joints.size(), {});
  out_.actuators.assign(scene_.motors.size(), -1);
  grow_trees();
  out_.origins.assign(size(), Vec3::Zero());
  for (std::size_t b = 0; b < size(); ++b) {
    if (trees_.joint[b] < 0 && trees_.children[b].empty() && !grounded(static_cast<int>(b)))
      out_.origins[b] = scene_.bodies[b].com;
  }
  find_exclusions();
  for (std::size_t b = 0; b < size(); ++b) {
    const Body& it = scene_.bodies[b];
    if (it.removed) continue;
    out_.other_weights = out_.other_weights || it.gravity_scale != 1.0;
    if (trees_.parent[b] != kWorld) continue;
    if (auto written = write_body(static_cast<int>(b)); !written)
      return tl::unexpected(written.error());
    if (it.kind == BodyKind::kinematic) out_.kinematic.push_back(static_cast<int>(b));
  }
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    const Joint& it = scene_.joints[j];
    if (it.removed || out_.joints[j].body >= 0) continue;
    if (it.type == JointType::free || (grounded(it.parent) && grounded(it.child))) continue;
    if (auto fine = check_loop(it); !fine) return tl::unexpected(fine.error());
    write_equality(static_cast<int>(j));
  }
  write_couplings();
  write_actuators();
  const Surfaces surfaces = choose_surfaces(scene_, out_.options, surface_geoms_);
  // Its compiler makes a step, for which its own rule gives derivatives by the speeds too little
  // stack.
  const double stack = out_.options.implicit ? 2e4 + 120.0 * std::pow(double(size()) + 1.0, 2) : -1;
  return fmt::format(
      "<mujoco><compiler angle=\"radian\" inertiafromgeom=\"false\"/>\n"
      "<size njmax=\"0\" nconmax=\"0\" nstack=\"{:.0f}\"/>\n<option {}><flag {}/></option>\n"
      "<default>\n{}</default>\n<asset>\n{}</asset>\n<worldbody>\n{}</worldbody>\n"
      "<contact>\n{}{}</contact>\n<equality>\n{}</equality>\n<tendon>\n{}</tendon>\n"
      "<actuator>\n{}</actuator></mujoco>\n",
      stack, out_.options.option, out_.options.flag, surfaces.classes, assets_, bodies_, contacts_,
      surfaces.pairs, equalities_, tendons_, actuators_);
}

}  // namespace

Result<std::string> write_mjcf(Program& program) { return Writer(program).write(); }

}  // namespace cogrsim::mujoco
