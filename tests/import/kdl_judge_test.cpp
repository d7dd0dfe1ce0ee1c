// Robots in URDF as urdfdom reads them and as KDL computes them, beside ours. What KDL does not have
// is not compared: `mimic`, links without mass between joints, impossible inertias, floating bases.
#include <urdf_parser/urdf_parser.h>

#include <kdl/chaindynparam.hpp>
#include <kdl/tree.hpp>
#include <kdl/treefksolverpos_recursive.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>

#include "cogrsim/dsl/export_model.h"
#include "judge_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

KDL::Vector vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
KDL::Rotation rotation(const urdf::Rotation& r) {
  return KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w);
}
KDL::Frame frame(const urdf::Pose& p) { return {rotation(p.rotation), vector(p.position)}; }

KDL::RigidBodyInertia inertia(const urdf::Link& link) {
  if (!link.inertial) return KDL::RigidBodyInertia::Zero();
  const urdf::Inertial& i = *link.inertial;
  // About the centre of mass, turned from the inertial frame to that of the link.
  const KDL::RigidBodyInertia central(
      i.mass, KDL::Vector::Zero(),
      KDL::RotationalInertia(i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz));
  return frame(i.origin) * central;
}

/// A segment per link; the root's own inertia is not part of it, as nothing moves it.
void grow(const urdf::Link& link, KDL::Tree& tree) {
  for (const urdf::JointSharedPtr& j : link.child_joints) {
    const KDL::Frame X = frame(j->parent_to_joint_origin_transform);
    const KDL::Vector axis = X.M * vector(j->axis);
    KDL::Joint joint(j->name, KDL::Joint::None);
    if (j->type == urdf::Joint::REVOLUTE || j->type == urdf::Joint::CONTINUOUS)
      joint = KDL::Joint(j->name, X.p, axis, KDL::Joint::RotAxis);
    if (j->type == urdf::Joint::PRISMATIC)
      joint = KDL::Joint(j->name, X.p, axis, KDL::Joint::TransAxis);
    const urdf::LinkConstSharedPtr child = link.child_links[std::size_t(
        std::find(link.child_joints.begin(), link.child_joints.end(), j) -
        link.child_joints.begin())];
    REQUIRE(child->name == j->child_link_name);
    REQUIRE(tree.addSegment(KDL::Segment(child->name, joint, X, inertia(*child)), link.name));
    grow(*child, tree);
  }
}

struct Judged {
  urdf::ModelInterfaceSharedPtr urdf;
  KDL::Tree tree;
  explicit Judged(const std::string& text) : urdf(urdf::parseURDF(text)) {
    REQUIRE(urdf);
    tree = KDL::Tree(urdf->getRoot()->name);
    grow(*urdf->getRoot(), tree);
  }
  /// Index of a joint among KDL's coordinates, by its name.
  int coordinate(const std::string& joint) const {
    const std::string& child = urdf->getJoint(joint)->child_link_name;
    return int(GetTreeElementQNr(tree.getSegment(child)->second));
  }
};

Vec3 vec3(const KDL::Vector& v) { return {v.x(), v.y(), v.z()}; }
Mat3 mat3(const KDL::Rotation& r) {
  Mat3 out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out(i, k) = r(i, k);
  return out;
}

/// KDL's efforts; by joint, in its order.
Eigen::VectorXd efforts(const KDL::Tree& tree, const Vec3& gravity, const Eigen::VectorXd& q,
                        const Eigen::VectorXd& u, const Eigen::VectorXd& du) {
  KDL::TreeIdSolver_RNE solver(tree, KDL::Vector(gravity[0], gravity[1], gravity[2]));
  KDL::JntArray kq(unsigned(q.size())), ku(kq), kdu(kq), out(kq);
  kq.data = q;
  ku.data = u;
  kdu.data = du;
  REQUIRE(solver.CartToJnt(kq, ku, kdu, KDL::WrenchMap(), out) == 0);
  return out.data;
}

/// Compares the robots at random states. `held`: joints that our scene holds at a coordinate.
void compare(const Imported& in, const Judged& judge, const std::map<std::string, double>& held,
             Random& random) {
  const SceneModel& model = *in.model;
  const int n = int(judge.tree.getNrOfJoints());
  REQUIRE(model.joint_speeds + int(held.size()) == n);
  REQUIRE(floating_bases(model).empty());
  // Joints by name: KDL's index of each of ours.
  std::vector<int> index(std::size_t(model.joint_speeds), -1);
  for (const Joint& j : model.joints)
    if (speed_count(j.type) == 1)
      index[std::size_t(j.speed_offset)] = judge.coordinate(tail(j.name));

  WorldState state = initial_state(model);
  KDL::TreeFkSolverPos_recursive poses(judge.tree);
  double worst_pose = 0.0, worst_effort = 0.0, worst_mass = 0.0;
  int compared = 0;
  for (int sample = 0; sample < 100; ++sample) {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(n), u = q, du = q;
    for (const auto& [joint, value] : held) q[judge.coordinate(joint)] = value;
    Eigen::VectorXd our_du(model.joint_speeds);
    for (int k = 0; k < model.joint_speeds; ++k) {
      const int at = index[std::size_t(k)];
      q[at] = state.joint_positions[std::size_t(k)] = random.uniform(-3, 3);
      u[at] = state.joint_velocities[std::size_t(k)] = random.uniform(-3, 3);
      du[at] = our_du[k] = random.uniform(-3, 3);
    }
    place_by_joints(model, state);

    KDL::JntArray kq{unsigned(n)};
    kq.data = q;
    const auto check = [&](const Pose& X, const std::string& name) {
      if (judge.tree.getSegment(name) == judge.tree.getSegments().end()) return;
      KDL::Frame there;
      REQUIRE(poses.JntToCart(kq, there, name) >= 0);
      worst_pose = std::max(worst_pose, difference(X, vec3(there.p), mat3(there.M)));
      ++compared;
    };
    for (std::size_t b = 0; b < model.bodies.size(); ++b)
      check(state.poses[b], tail(model.bodies[b].name));
    for (const NamedFrame& f : model.frames)
      check((f.body < 0 ? Pose() : state.poses[std::size_t(f.body)]) * f.X_BF, tail(f.name));

    const auto ours_of = [&](const Eigen::VectorXd& theirs) {
      Eigen::VectorXd out(model.joint_speeds);
      for (int k = 0; k < out.size(); ++k) out[k] = theirs[index[std::size_t(k)]];
      return out;
    };
    worst_effort = std::max(
        worst_effort,
        relative_difference(inverse_dynamics(model, state, our_du),
                            ours_of(efforts(judge.tree, model.physics.gravity, q, u, du))));
    const Eigen::MatrixXd M = mass_matrix(model, state);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n);
    for (int k = 0; k < model.joint_speeds; ++k)
      worst_mass = std::max(
          worst_mass,
          relative_difference(M.col(k),
                              ours_of(efforts(judge.tree, Vec3::Zero(), q, zero,
                                              Eigen::VectorXd::Unit(n, index[std::size_t(k)])))));
  }
  INFO("poses " << worst_pose << ", efforts " << worst_effort << ", mass matrix " << worst_mass);
  // Every link, the root too, is a body or a frame.
  CHECK(compared == 100 * (1 + int(judge.tree.getNrOfSegments())));
  CHECK(worst_pose < kPoseBound);
  CHECK(worst_effort < kEffortBound);
  CHECK(worst_mass < kEffortBound);
}

/// Total mass and centre of mass at the start, with the root's.
void compare_mass(const Imported& in, const Judged& judge,
                  const std::map<std::string, double>& start) {
  const urdf::Link& root = *judge.urdf->getRoot();
  KDL::RigidBodyInertia sum = inertia(root);
  KDL::TreeFkSolverPos_recursive poses(judge.tree);
  KDL::JntArray q(judge.tree.getNrOfJoints());
  for (const auto& [joint, value] : start) q(unsigned(judge.coordinate(joint))) = value;
  for (const auto& [name, element] : judge.tree.getSegments()) {
    KDL::Frame X;
    if (name == root.name) continue;
    REQUIRE(poses.JntToCart(q, X, name) >= 0);
    sum = sum + X * element.segment.getInertia();
  }
  double mass = 0.0;
  Vec3 moment = Vec3::Zero();
  const Pose X_WR = in.model->bodies[0].X_WB;
  for (const Body& b : in.model->bodies) {
    mass += b.mass;
    moment += b.mass * (X_WR.inverse() * (b.X_WB * b.com));
  }
  CHECK(mass == Approx(sum.getMass()).epsilon(1e-14));
  CHECK((moment / mass - vec3(sum.getCOG())).norm() < kPoseBound);
}

std::string inertial(Random& random) {
  const double mass = random.uniform(0.1, 3.0);
  const Mat3 R = random.orientation().toRotationMatrix();
  const Mat3 I = R * random.moments(mass).asDiagonal() * R.transpose();
  return "<inertial><origin xyz=\"" + text(random.vector(0.2)) + "\" rpy=\"" +
         text(random.vector(3.0)) + "\"/><mass value=\"" + text(mass) + "\"/><inertia ixx=\"" +
         text(I(0, 0)) + "\" iyy=\"" + text(I(1, 1)) + "\" izz=\"" + text(I(2, 2)) + "\" ixy=\"" +
         text(I(0, 1)) + "\" ixz=\"" + text(I(0, 2)) + "\" iyz=\"" + text(I(1, 2)) +
         "\"/></inertial>";
}

/// A tree of links whose joints, frames and inertias are random. Of links that a fixed joint holds
/// every other one has no mass.
std::string random_robot(Random& random) {
  static const char* const kTypes[] = {"revolute", "continuous", "prismatic", "fixed"};
  std::string out = "<robot name=\"r\">\n<link name=\"l0\">" + inertial(random) + "</link>\n";
  for (int i = 1; i < 13; ++i) {
    const std::string number = std::to_string(i), type = kTypes[random.below(4)];
    const bool massless = type == "fixed" && random.below(2) == 0;
    out += "<link name=\"l" + number + "\">" + (massless ? "" : inertial(random)) + "</link>\n";
    out += "<joint name=\"j" + number + "\" type=\"" + type + "\"><parent link=\"l" +
           std::to_string(random.below(i)) + "\"/><child link=\"l" + number + "\"/><origin xyz=\"" +
           text(random.vector(0.5)) + "\" rpy=\"" + text(random.vector(3.0)) + "\"/><axis xyz=\"" +
           text(Vec3(random.vector(2.0) + Vec3(0, 0, 3))) +
           "\"/><limit lower=\"-4\" upper=\"4\" effort=\"9\" velocity=\"9\"/></joint>\n";
  }
  return out + "</robot>";
}

}  // namespace

TEST_CASE("an arm with chains of fixed links is what KDL makes of it", "[judge]") {
  // Two branches; inertial frames that are off and turned; an axis that is not a unit vector; a root in
  // a link without mass that is off the world; limits that exclude zero, or leave no freedom.
  const std::string urdf = R"(<robot name="arm">
  <link name="ground"/>
  <link name="base"><inertial><origin xyz="0 0.01 0.05" rpy="0.1 0 0"/><mass value="2"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.015" ixy="0.001" ixz="-0.002" iyz="0.0005"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0 0 0.2" rpy="0.4 -0.3 0.2"/><mass value="1"/>
    <inertia ixx="0.03" iyy="0.02" izz="0.015" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
  <link name="flange"/>
  <link name="gauge"><inertial><origin xyz="0.02 0 0"/><mass value="0.2"/>
    <inertia ixx="0.0001" iyy="0.0002" izz="0.0002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool"><inertial><origin rpy="0 1 0"/><mass value="0.5"/>
    <inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tip"/>
  <link name="rail"><inertial><origin xyz="0.1 0 0"/><mass value="0.7"/>
    <inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="wheel"><inertial><mass value="0.3"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.0015" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="locked"><inertial><origin xyz="0 0.1 0"/><mass value="0.4"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.0015" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="stand" type="fixed"><parent link="ground"/><child link="base"/>
    <origin xyz="0.3 -0.2 0.5" rpy="0.1 0.2 0.3"/></joint>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0.1 0.1" rpy="0.1 0.2 0.3"/><axis xyz="1 2 -2"/>
    <limit lower="0.5" upper="1.5" effort="10" velocity="3"/></joint>
  <joint name="mount" type="fixed"><parent link="upper"/><child link="flange"/><origin xyz="0 0 0.4"/></joint>
  <joint name="plate" type="fixed"><parent link="flange"/><child link="gauge"/><origin xyz="0.1 0 0" rpy="0 0 1"/></joint>
  <joint name="grip" type="continuous"><parent link="gauge"/><child link="tool"/>
    <origin xyz="0.1 0 0.2" rpy="2 0 1"/><axis xyz="0 1 0"/></joint>
  <joint name="nib" type="fixed"><parent link="tool"/><child link="tip"/><origin xyz="0 0 0.1" rpy="0 -1 0"/></joint>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="rail"/>
    <origin xyz="0.1 0 0" rpy="0 0.5 0"/><axis xyz="0.5 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="spin" type="continuous"><parent link="rail"/><child link="wheel"/><axis xyz="0 0 -1"/></joint>
  <joint name="lock" type="revolute"><parent link="rail"/><child link="locked"/>
    <origin xyz="0 0.2 0" rpy="1 0 0"/><axis xyz="1 0 0"/><limit lower="0.3" upper="0.3" effort="1" velocity="1"/></joint>
</robot>)";
  Imported in;
  in.options.fixed_base = true;
  in.read(urdf);
  REQUIRE(in.model);
  Random random(1);
  const Judged judge(urdf);
  compare(in, judge, {{"lock", 0.3}}, random);
}

TEST_CASE("random trees of links are what KDL makes of them", "[judge]") {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    INFO("seed " << seed);
    Random random(seed);
    const std::string urdf = random_robot(random);
    const Judged judge(urdf);
    Imported in;
    in.read(urdf);
    REQUIRE(in.model);
    compare_mass(in, judge, {});
    in.options.fixed_base = true;
    in.read(urdf);
    REQUIRE(in.model);
    compare(in, judge, {}, random);
  }
}
