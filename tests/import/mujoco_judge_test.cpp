// Models in MJCF as MuJoCo reads and computes them, beside ours; and our scenes as MuJoCo reads their
// export. What MuJoCo's solver makes soft (couplings, loops, limits, friction) is not compared.
#include <mujoco/mujoco.h>

#include <memory>

#include "cogrsim/dsl/export_model.h"
#include "judge_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

class Judge {
 public:
  explicit Judge(const std::string& path) {
    char error[1000] = "";
    model_.reset(mj_loadXML(path.c_str(), nullptr, error, sizeof error));
    INFO(error);
    REQUIRE(model_);
    // No contacts, limits, friction.
    model_->opt.disableflags |= mjDSBL_CONSTRAINT;
    data_.reset(mj_makeData(model_.get()));
  }
  mjModel& model() { return *model_; }
  mjData& data() { return *data_; }
  int size() const { return model_->nv; }

  void set_random(Random& random) {
    for (int i = 0; i < model_->nq; ++i) data_->qpos[i] = random.uniform(-2, 2);
    for (int i = 0; i < model_->nv; ++i) {
      data_->qvel[i] = random.uniform(-2, 2);
      data_->qacc[i] = random.uniform(-2, 2);
    }
    mj_normalizeQuat(model_.get(), data_->qpos);
    mj_inverse(model_.get(), data_.get());
  }

  /// Index of a body, or -1.
  int body(const std::string& name) const {
    return mj_name2id(model_.get(), mjOBJ_BODY, name.c_str());
  }
  Pose pose(int body) const {
    const double *p = data_->xpos + 3 * body, *q = data_->xquat + 4 * body;
    return {Vec3(p[0], p[1], p[2]), Quat(q[0], q[1], q[2], q[3])};
  }
  /// Twist of a body's origin for one unit of a speed.
  Twist column(int body, int speed) const {
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> p(3, size()), r(3, size());
    mj_jacBody(model_.get(), data_.get(), p.data(), r.data(), body);
    return {p.col(speed), r.col(speed)};
  }
  Eigen::MatrixXd mass_matrix() const {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> out(size(), size());
    mj_fullM(model_.get(), out.data(), data_->qM);
    return out;
  }
  Eigen::VectorXd efforts() const {
    return Eigen::Map<const Eigen::VectorXd>(data_->qfrc_inverse, size());
  }
  Eigen::VectorXd vector(const double* values) const {
    return Eigen::Map<const Eigen::VectorXd>(values, size());
  }

 private:
  struct Free {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
};

/// MuJoCo's inertia of a body about its centre of mass, in axes of the body.
Mat3 inertia_of(const mjModel& m, int body) {
  const double* const q = m.body_iquat + 4 * body;
  const Mat3 R = Quat(q[0], q[1], q[2], q[3]).toRotationMatrix();
  return R * Eigen::Map<const Vec3>(m.body_inertia + 3 * body).asDiagonal() * R.transpose();
}

// MuJoCo turns inertias with products, also sums over geoms, to principal axes by rotations, and ends at
// one whose cosine is within 1e-12 of 1: an angle below 1.5e-6, which turns as large a part of the
// difference of the moments into products. The last angles of these models are far smaller; reached: 2e-10.
constexpr double kPrincipalAxesBound = 1.5e-6, kDynamicsBound = 1e-8;

/// MuJoCo's name of a body of ours.
using NameOf = std::function<std::string(const Body&)>;

/// Compares masses, poses, mass matrix and inverse dynamics at 100 random states.
void compare(const SceneModel& model, Judge& judge, const NameOf& name_of, Random& random,
             double effort_bound = kEffortBound) {
  const int n = judge.size();
  const std::vector<int> bases = floating_bases(model);
  REQUIRE(model.joint_speeds + 6 * int(bases.size()) == n);
  std::vector<int> index;
  double mass = 0.0, judged_mass = 0.0;
  for (const Body& b : model.bodies) {
    index.push_back(b.kind == BodyKind::dynamic ? judge.body(name_of(b)) : 0);
    INFO("body " << b.name);
    REQUIRE(index.back() >= 0);
    if (b.kind == BodyKind::dynamic) mass += b.mass;
  }
  for (int b = 1; b < judge.model().nbody; ++b)
    if (judge.model().body_weldid[b] != 0) judged_mass += judge.model().body_mass[b];
  CHECK(mass == Approx(judged_mass).epsilon(1e-14));
  const auto body_at = [&](int b) { return b < 0 ? 0 : index[std::size_t(b)]; };

  WorldState state = initial_state(model);
  double worst_pose = 0.0, worst_effort = 0.0, worst_mass = 0.0, worst_q = 0.0, worst_com = 0.0;
  for (int sample = 0; sample < 100; ++sample) {
    judge.set_random(random);
    // Our coordinates by MuJoCo's poses; where a joint has the same name, they must be the same.
    std::vector<double> q(std::size_t(model.joint_positions));
    for (const Joint& j : model.joints) {
      const Pose X_WP = j.parent < 0 ? Pose() : judge.pose(body_at(j.parent));
      const int there = mj_name2id(&judge.model(), mjOBJ_JOINT, tail(j.name).c_str());
      double* const own = q.data() + j.position_offset;
      std::vector<double> near = j.position;
      const bool one = position_count(j.type) == 1;
      const double theirs = there < 0 ? 0.0
                                      : judge.data().qpos[judge.model().jnt_qposadr[there]] -
                                            judge.model().qpos0[judge.model().jnt_qposadr[there]];
      if (one) near[0] = theirs;
      const bool grounded =
          j.parent >= 0 && model.bodies[std::size_t(j.parent)].kind != BodyKind::dynamic;
      const Pose X_P = grounded ? model.bodies[std::size_t(j.parent)].X_WB : X_WP;
      joint_position(j, relative_pose(j, X_P, judge.pose(body_at(j.child))), near.data(), own);
      if (one && there >= 0 && j.position[0] == 0.0)
        worst_q = std::max(worst_q, std::abs(own[0] - theirs));
    }
    state.joint_positions = q;
    for (const int b : bases) state.poses[std::size_t(b)] = judge.pose(body_at(b));
    // Our speeds are T times MuJoCo's. T changes with the orientation of ball joints and floating
    // bases only, about their own angular velocity, so that the rates of the speeds have the same T.
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n, n);
    for (int k = 0; k < n; ++k) {
      for (const Joint& j : model.joints) {
        if (speed_count(j.type) == 0) continue;
        const bool grounded =
            j.parent < 0 || model.bodies[std::size_t(j.parent)].kind != BodyKind::dynamic;
        const Pose X_WP = j.parent < 0 ? Pose()
                          : grounded   ? model.bodies[std::size_t(j.parent)].X_WB
                                       : judge.pose(body_at(j.parent));
        const Pose X_WC = judge.pose(body_at(j.child));
        const Twist V_WP = grounded ? Twist() : judge.column(body_at(j.parent), k);
        const Twist V_WC = judge.column(body_at(j.child), k);
        std::array<double, 6> u{};
        joint_velocity(j, relative_pose(j, X_WP, X_WC), relative_twist(j, X_WP, V_WP, X_WC, V_WC),
                       q.data() + j.position_offset, u.data());
        for (int i = 0; i < speed_count(j.type); ++i) T(j.speed_offset + i, k) = u[std::size_t(i)];
      }
      int at = model.joint_speeds;
      for (const int b : bases) {
        const Twist V = judge.column(body_at(b), k);
        T.block<3, 1>(at, k) = V.linear;
        T.block<3, 1>(at + 3, k) = V.angular;
        at += 6;
      }
    }
    const Eigen::VectorXd u = T * judge.vector(judge.data().qvel);
    std::copy(u.data(), u.data() + model.joint_speeds, state.joint_velocities.begin());
    int at = model.joint_speeds;
    for (const int b : bases) {
      state.twists[std::size_t(b)] = {u.segment<3>(at), u.segment<3>(at + 3)};
      at += 6;
    }
    place_by_joints(model, state);

    Vec3 moment = Vec3::Zero(), judged_moment = Vec3::Zero();
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      if (model.bodies[b].kind != BodyKind::dynamic) continue;
      const Pose X = judge.pose(index[b]);
      worst_pose = std::max(worst_pose, difference(state.poses[b], X.p, X.q.toRotationMatrix()));
      moment += model.bodies[b].mass * (state.poses[b] * model.bodies[b].com);
    }
    for (int b = 1; b < judge.model().nbody; ++b)
      if (judge.model().body_weldid[b] != 0)
        judged_moment +=
            judge.model().body_mass[b] * Eigen::Map<const Vec3>(judge.data().xipos + 3 * b);
    worst_com = std::max(worst_com, (moment - judged_moment).norm() / mass);
    for (const NamedFrame& f : model.frames) {
      const int there = judge.body(tail(f.name));
      if (there <= 0 || f.body < 0) continue;
      const Pose X = judge.pose(there);
      worst_pose = std::max(worst_pose, difference(state.poses[std::size_t(f.body)] * f.X_BF, X.p,
                                                   X.q.toRotationMatrix()));
    }
    worst_mass = std::max(
        worst_mass,
        relative_difference(T.transpose() * mass_matrix(model, state) * T, judge.mass_matrix()));
    const Eigen::VectorXd du = T * judge.vector(judge.data().qacc);
    worst_effort = std::max(
        worst_effort,
        relative_difference(T.transpose() * inverse_dynamics(model, state, du), judge.efforts()));
  }
  INFO("coordinates " << worst_q << ", poses " << worst_pose << ", centre " << worst_com
                      << ", mass matrix " << worst_mass << ", efforts " << worst_effort);
  CHECK(worst_q < kPoseBound);
  CHECK(worst_pose < kPoseBound);
  CHECK(worst_com < kPoseBound);
  CHECK(worst_mass < effort_bound);
  CHECK(worst_effort < effort_bound);
}

void compare_import(const std::string& mjcf, Random& random, Imported& in,
                    double effort_bound = kEffortBound) {
  INFO(mjcf);
  in.read(mjcf, "m.xml");
  REQUIRE(in.model);
  Judge judge(in.folder / "m.xml");
  compare(
      *in.model, judge, [](const Body& b) { return tail(b.name); }, random, effort_bound);
}

}  // namespace

TEST_CASE("classes, units and geoms of MJCF are what MuJoCo makes of them", "[judge]") {
  Imported in;
  Random random(1);
  compare_import(R"(<mujoco model="m">
    <compiler angle="degree" eulerseq="ZYx"/>
    <option gravity="1 -2 -8"/>
    <default>
      <geom density="700"/><joint armature="0.02"/>
      <default class="leg"><geom type="capsule" size="0.03"/><joint axis="0 1 0.5"/>
        <default class="shin"><geom density="1500"/><joint armature="0"/></default></default>
    </default>
    <worldbody>
      <body name="stand" pos="0 0 1" euler="10 20 30">
        <geom type="box" size="0.1 0.1 0.1"/>
        <body name="beam" pos="0.2 0 0" quat="0.8 0 0.6 0">
          <joint name="turn" axis="1 1 0" pos="0.05 0.1 0" ref="20"/>
          <geom type="cylinder" size="0.05 0.2" pos="0 0 0.1" axisangle="1 0 0 40"/>
          <geom type="ellipsoid" size="0.1 0.2 0.05" mass="0.4" zaxis="1 1 0"/>
          <body name="welded" pos="0 0.1 0.3" xyaxes="0 1 0 1 0 0.5">
            <geom type="box" size="0.05 0.1 0.02" fromto="0 0 0 0.1 0.2 0.3"/>
            <body name="rail" pos="0 0 0.2">
              <joint name="push" type="slide" axis="0 1 1" ref="0.1"/>
              <geom type="sphere" size="0.1" mass="0.7" pos="0.1 0 0"/>
            </body>
          </body>
          <body name="thigh" pos="0 0.1 0" childclass="leg">
            <joint name="hip" pos="0 0 0.05"/>
            <geom fromto="0 0 0 0.1 0.05 -0.3"/>
            <body name="shin" pos="0.1 0.05 -0.3">
              <joint name="knee" class="shin"/>
              <geom class="shin" fromto="0 0 0 0 0 -0.3"/>
            </body>
          </body>
        </body>
      </body>
      <body name="kite" pos="1 0 2">
        <freejoint name="kite_free"/>
        <geom type="box" size="0.3 0.2 0.01" pos="0.1 0 0"/>
        <body name="tail" pos="-0.3 0 0">
          <joint name="knot" type="ball" pos="0 0.02 0"/>
          <inertial pos="0.1 0 -0.2" quat="1 0.5 0 0.2" mass="0.3" diaginertia="0.02 0.025 0.03"/>
        </body>
        <body name="bob" pos="0 0 -0.3">
          <joint name="swing" type="hinge" axis="0 0 1"/>
          <inertial pos="0 0.1 0" quat="0.6 0 0.8 0" mass="0.2" diaginertia="0.02 0.03 0.025"/>
        </body>
      </body>
    </worldbody>
  </mujoco>)",
                 random, in, kDynamicsBound);
}

TEST_CASE("an inertia with products is that of MuJoCo", "[judge]") {
  Imported in;
  in.read(R"(<mujoco><worldbody><body name="b"><freejoint/>
    <inertial pos="0.1 0 -0.2" mass="0.3" fullinertia="0.02 0.03 0.025 0.001 -0.002 0.003"/>
    </body></worldbody></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  Judge judge(in.folder / "m.xml");
  const Mat3 I = inertia_of(judge.model(), 1);
  CHECK((in.body("b").inertia - I).norm() < kPrincipalAxesBound * I.norm());
}

TEST_CASE("masses of meshes are those that MuJoCo finds by exactmeshinertia", "[judge]") {
  const std::string model = R"(<mujoco><compiler exactmeshinertia="true"/>
    <asset><mesh name="wedge" file="wedge.obj" scale="1 -2 1"/></asset>
    <worldbody><body name="b"><freejoint/><geom type="mesh" mesh="wedge" pos="0 0 -0.3" euler="0 0 90"/></body>
    </worldbody></mujoco>)";
  Imported in;
  in.folder.write(
      "wedge.obj",
      "v 0 0 0\nv 0.25 0 0\nv 0 0.25 0\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  in.read(model, "m.xml");
  REQUIRE(in.model);
  CHECK_FALSE(in.reports(kApproximate, "mass of body 'b'"));
  Judge judge(in.folder / "m.xml");
  // MuJoCo stores corners as floats: 24 bits, and a few operations.
  const double bound = 1e-6;
  const Body& body = in.body("b");
  const mjModel& m = judge.model();
  CHECK(body.mass == Approx(m.body_mass[1]).epsilon(bound));
  CHECK((body.com - Eigen::Map<const Vec3>(m.body_ipos + 3)).norm() < bound);
  const Mat3 I = inertia_of(m, 1);
  CHECK((body.inertia - I).norm() < bound * I.norm());
  // Without it MuJoCo's mass of this wedge is another, which the report states.
  in.read("<mujoco><compiler/>" + model.substr(model.find("<asset>")), "m.xml");
  CHECK(in.reports(kApproximate, "mass of body 'b'", "exactmeshinertia"));
}

TEST_CASE("two sliders and a hinge of MJCF are what MuJoCo makes of them", "[judge]") {
  Imported in;
  Random random(2);
  compare_import(R"(<mujoco><worldbody><body name="torso" pos="0 0 1" euler="0 0 30">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>
      <joint name="y" type="hinge" axis="0 1 0"/><geom type="box" size="0.1 0.2 0.3" pos="0.1 0.1 0"/>
      <body name="leg" pos="0 0 -0.3"><joint name="hip" axis="0 1 0"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0.1 0 -0.4"/></body>
    </body></worldbody></mujoco>)",
                 random, in);
}

TEST_CASE("random trees of MJCF are what MuJoCo makes of them", "[judge]") {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    INFO("seed " << seed);
    Random random(seed);
    // Bodies by their parents, so that children can be nested.
    constexpr int kCount = 12;
    std::vector<std::vector<int>> children(kCount);
    for (int i = 1; i < kCount; ++i) children[std::size_t(random.below(i))].push_back(i);
    const std::function<std::string(int)> body = [&](int i) {
      static const char* const kTypes[] = {"hinge", "slide", "ball", ""};
      const std::string number = std::to_string(i);
      std::string out = "<body name=\"b" + number + "\" pos=\"" + text(random.vector(0.5)) +
                        "\" quat=\"" + text(random.orientation()) + "\">";
      const std::string type = kTypes[random.below(4)];
      if (i == 0 && seed % 2 == 0)
        out += "<freejoint/>";
      else if (!type.empty() || i == 0)
        out += "<joint name=\"j" + number + "\" type=\"" + (i == 0 ? "hinge" : type) +
               "\" axis=\"" + text(Vec3(random.vector(1.0) + Vec3(0, 0, 2))) + "\" pos=\"" +
               text(random.vector(0.2)) + "\" armature=\"" +
               (type == "ball" ? "0" : text(random.uniform(0, 0.1))) + "\"/>";
      const double mass = random.uniform(0.1, 3.0);
      out += "<inertial pos=\"" + text(random.vector(0.2)) + "\" quat=\"" +
             text(random.orientation()) + "\" mass=\"" + text(mass) + "\" diaginertia=\"" +
             text(random.moments(mass)) + "\"/>";
      for (const int child : children[std::size_t(i)]) out += "\n" + body(child);
      return out + "</body>";
    };
    Imported in;
    compare_import(
        "<mujoco><compiler angle=\"radian\"/><worldbody>" + body(0) + "</worldbody></mujoco>",
        random, in);
  }
}

TEST_CASE("scenes exported as MJCF are to MuJoCo what they are to us", "[judge]") {
  const char* const scene = GENERATE(R"(
<scene name="arm" version="1">
  <assembly name="bot" xyz="0.3 -0.2 1" rpy="10 20 30 deg">
    <body name="base" mass="3 kg" com="0.01 0.02 0.03 m"><box size="0.4 0.3 0.2 m"/></body>
    <body name="upper" xyz="0.1 0.2 0.3" rpy="0 0 40 deg" mass="1.5 kg">
      <capsule radius="4 cm" length="0.3 m" rpy="0 90 0 deg"/></body>
    <body name="hand" xyz="0.5 0.3 0.4" mass="0.2 kg" com="0 0.01 0">
      <cylinder radius="3 cm" length="0.1 m"/></body>
    <hinge name="shoulder" parent="base" child="upper" xyz="0.05 0.1 0.2" axis="1 2 3"
           position="20 deg" rotor-inertia="0.1"/>
    <slider name="wrist" parent="upper" child="hand" axis="0 1 1"/>
  </assembly>
</scene>)",
                                     R"(
<scene name="joints" version="1">
  <physics gravity="0 1 -5"/>
  <assembly name="bot">
    <body name="a" static="true"><box size="1 1 1 m"/></body>
    <body name="b" xyz="2 0 0" rpy="20 0 10 deg" mass="2 kg"><box size="1 0.5 0.2 m"/></body>
    <body name="c" xyz="4 0 0" mass="3 kg" com="0.1 0.2 0"><box size="0.1 1 1 m"/></body>
    <body name="d" xyz="4 2 0" mass="1 kg"><sphere radius="0.2 m" xyz="0.1 0 0"/></body>
    <body name="e" xyz="4 2 2" mass="1 kg"><box size="0.1 0.2 0.3 m"/></body>
    <body name="f" xyz="4 2 3" mass="1 kg"><box size="0.3 0.2 0.3 m"/></body>
    <universal name="cross" parent="a" child="b" xyz="1 0 0"/>
    <cylindrical name="pin" parent="b" child="c" xyz="3 0 0" axis="1 0 1"/>
    <ball name="socket" parent="c" child="d" xyz="4 1 0"/>
    <planar name="table" parent="d" child="e" xyz="4 2 1"/>
    <hinge name="reversed" parent="f" child="e" axis="0 1 1"/>
  </assembly>
  <body name="free" xyz="5 0 3" rpy="0 30 0 deg" mass="2 kg" com="0.1 0 0"><box size="0.3 0.2 0.1 m"/></body>
</scene>)");
  const dsl::CompileResult result = dsl::compile_text(scene, "s.scene.xml");
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.ok());
  dsl::ExportOptions options;
  options.format = dsl::ExportFormat::mjcf;
  const auto out = dsl::export_model(*result.model, options);
  REQUIRE(out);
  INFO(out->text);
  TemporaryFolder folder;
  Judge judge(folder.write("s.xml", out->text));
  Random random(3);
  compare(
      *result.model, judge,
      [](const Body& b) {
        std::string name = b.name;
        std::replace(name.begin(), name.end(), '.', '_');
        return name;
      },
      random);
}
