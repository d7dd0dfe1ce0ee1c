#include "mechanism.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/scene_state.h"

namespace cogrsim::simbody {

namespace {

// To MultibodyGraphMaker's names: "free" and "weld" are its own.
std::string graph_type(JointType type) { return std::string("joint ") + to_string(type); }

// One of the parts that a body is cut into. A kinematic body has 1 kg, without effect.
SimTK::Body::Rigid rigid_body(const Body& body, double share) {
  if (body.kind == BodyKind::kinematic)
    return SimTK::Body::Rigid(SimTK::MassProperties(1, SimTK::Vec3(0), SimTK::UnitInertia(1)));
  const Mat3 I = share * body.inertia;
  const double mass = share * body.mass;
  const SimTK::Vec3 c = to_simtk(body.com);
  const SimTK::Inertia central(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return SimTK::Body::Rigid(SimTK::MassProperties(mass, c, central.shiftFromMassCenter(c, mass)));
}

// A joint as a mobilizer. `anchor`: pose of the body that it is fixed to where `inboard` is the ground in
// its place; else null.
void mobilize(const Joint& joint, SimTK::MobilizedBody inboard, const Pose* anchor,
              const SimTK::Body::Rigid& rigid, Link& link) {
  using SimTK::MobilizedBody;
  SimTK::Transform inner = to_simtk(link.reversed ? joint.X_CM : joint.X_PF);
  SimTK::Transform outer = to_simtk(link.reversed ? joint.X_PF : joint.X_CM);
  if (anchor) inner = to_simtk(*anchor) * inner;
  const auto direction = link.reversed ? MobilizedBody::Reverse : MobilizedBody::Forward;
  const auto make = [&](auto type, auto... more) {
    link.mobod = decltype(type)(inboard, inner, rigid, outer, more..., direction);
  };
  switch (joint.type) {
    case JointType::fixed:
      link.mobod = MobilizedBody::Weld(inboard, inner, rigid, outer);
      return;
    case JointType::hinge:
      return make(MobilizedBody::Pin());
    case JointType::slider: {
      // Simbody slides along x where the scene language slides along z.
      const SimTK::Rotation x_to_z(-SimTK::Pi / 2, SimTK::YAxis);
      inner.updR() = inner.R() * x_to_z;
      outer.updR() = outer.R() * x_to_z;
      return make(MobilizedBody::Slider());
    }
    case JointType::screw:
      return make(MobilizedBody::Screw(), joint.pitch / (2 * SimTK::Pi));
    case JointType::cylindrical:
      return make(MobilizedBody::Cylinder());
    case JointType::universal:
      return make(MobilizedBody::Universal());
    case JointType::gimbal:
      return make(MobilizedBody::Gimbal());
    case JointType::planar:
      link.q_map = {1, 2, 0};
      link.u_map = {1, 2, 0};
      return make(MobilizedBody::Planar());
    case JointType::ball:
      return make(MobilizedBody::Ball());
    case JointType::free:
      link.q_map = {4, 5, 6, 0, 1, 2, 3};
      link.u_map = {3, 4, 5, 0, 1, 2};
      return make(MobilizedBody::Free());
  }
}

}  // namespace

bool Mechanism::is_ground(int body) const {
  return body == kWorld || model_->bodies[body].kind == BodyKind::static_body;
}
bool Mechanism::is_dynamic(int body) const {
  return body != kWorld && model_->bodies[body].kind == BodyKind::dynamic;
}

const SimTK::MobilizedBody& Mechanism::mobod(int body) const {
  const int link = body_link(body);
  return link < 0 ? static_cast<const SimTK::MobilizedBody&>(matter.getGround())
                  : links_[link].mobod;
}

Mechanism::Mechanism(SceneModelPtr model, std::vector<Pose> static_poses, const Options& options)
    : model_(std::move(model)),
      static_poses_(std::move(static_poses)),
      options_(options),
      body_links_(model_->bodies.size(), -1),
      joint_links_(model_->joints.size(), -1) {
  matter.setShowDefaultGeometry(false);
  forces.setNumberOfThreads(1);
  plan();
  add_rotors();
  add_couplings();
  SimTK::Force::Gravity gravity(forces, matter, to_simtk(model_->physics.gravity));
  for (const Link& link : links_) {
    const double scale = link.kinematic ? 0.0 : model_->bodies[link.body].gravity_scale;
    if (scale == 1.0) continue;
    gravity.setDefaultBodyIsExcluded(link.mobod, true);
    const SimTK::MassProperties& mass = link.mobod.getDefaultMassProperties();
    SimTK::Force::ConstantForce(forces, link.mobod, mass.getMassCenter(),
                                scale * mass.getMass() * to_simtk(model_->physics.gravity));
  }
}

void Mechanism::set_external(SimTK::State& state, const std::vector<Wrench>& given) const {
  external_.clearAllBodyForces(state);
  for (const Link& link : links_) {
    if (given.empty() || link.kinematic) continue;
    const SimTK::MassProperties& mass = link.mobod.getBodyMassProperties(state);
    // A body that was cut to open a loop shares them as it shares its mass.
    const double share = mass.getMass() / model_->bodies[link.body].mass;
    const SimTK::Vec3 force = share * to_simtk(given[link.body].force);
    const SimTK::Vec3 arm = link.mobod.getBodyRotation(state) * mass.getMassCenter();
    const SimTK::Vec3 torque = share * to_simtk(given[link.body].torque);
    external_.setOneBodyForce(state, link.mobod, SimTK::SpatialVec(torque + arm % force, force));
  }
}

int Mechanism::inboard(int link) const {
  // Simbody numbers bodies as they are made, the ground first.
  const SimTK::MobilizedBody& mobod = links_[link].mobod;
  return int(mobod.getParentMobilizedBody().getMobilizedBodyIndex()) - 1;
}

void Mechanism::plan() {
  SimTK::MultibodyGraphMaker graph;
  for (const JointType type : kJointTypes) graph.addJointType(graph_type(type), speed_count(type));
  const auto body_name = [](int b) { return b < 0 ? std::string("ground") : std::to_string(b); };
  graph.addBody("ground", 0.0, false);

  // Of a connected set of bodies without a joint to the ground, the first one moves freely.
  const std::vector<int> bases = joint_trees(*model_).floating;
  const int count = int(model_->bodies.size());
  for (int b = 0; b < count; ++b) {
    const Body& body = model_->bodies[b];
    if (body.removed || body.kind == BodyKind::static_body) continue;
    const bool base =
        body.kind == BodyKind::kinematic || std::find(bases.begin(), bases.end(), b) != bases.end();
    graph.addBody(body_name(b), base && body.kind == BodyKind::kinematic ? 1.0 : body.mass, base,
                  const_cast<Body*>(&body));
  }
  const auto cut_parent = [&](const Joint& j) { return j.closes_loop && !is_dynamic(j.child); };
  for (const Joint& joint : model_->joints) {
    // Between bodies that no force moves a joint holds nothing.
    if (joint.removed || (!is_dynamic(joint.parent) && !is_dynamic(joint.child))) continue;
    // It is the child that is cut in two to open a loop.
    const bool turned = cut_parent(joint);
    const int parent = turned ? joint.child : joint.parent;
    const int child = turned ? joint.parent : joint.child;
    graph.addJoint(std::to_string(&joint - model_->joints.data()), graph_type(joint.type),
                   body_name(is_ground(parent) ? kWorld : parent),
                   body_name(is_ground(child) ? kWorld : child), joint.closes_loop,
                   const_cast<Joint*>(&joint));
  }
  graph.generateGraph();

  links_.reserve(std::size_t(graph.getNumMobilizers()));
  for (int m = 0; m < graph.getNumMobilizers(); ++m) {
    const auto& mobilizer = graph.getMobilizer(m);
    if (mobilizer.getLevel() <= 0) continue;  // the ground, where it is counted
    const auto* const body = static_cast<const Body*>(mobilizer.getOutboardMasterBodyRef());
    const auto* const inboard = static_cast<const Body*>(mobilizer.getInboardBodyRef());
    Link link;
    link.body = int(body - model_->bodies.data());
    link.slave = mobilizer.isSlaveMobilizer();
    link.kinematic = body->kind == BodyKind::kinematic;
    int anchor = kWorld;
    if (!mobilizer.isAddedBaseMobilizer()) {
      const auto* const joint = static_cast<const Joint*>(mobilizer.getJointRef());
      link.joint = int(joint - model_->joints.data());
      link.reversed = mobilizer.isReversedFromJoint() != cut_parent(*joint);
      anchor = link.reversed ? joint->child : joint->parent;
    }
    add_link(link, inboard ? body_links_[inboard - model_->bodies.data()] : -1, anchor,
             mobilizer.getNumFragments());
  }
  weld_slaves();
}

void Mechanism::join_trees(int one, int other) {
  for (Link& each : links_)
    if (each.tree == std::max(one, other)) each.tree = std::min(one, other);
}

void Mechanism::weld_slaves() {
  // What fixed joints hold together already needs no weld, and Simbody has none without freedom.
  const auto held_by = [&](int i) {
    while (i >= 0 && SimTK::MobilizedBody::Weld::isInstanceOf(links_[i].mobod)) i = inboard(i);
    return i;
  };
  for (const Link& link : links_) {
    if (!link.slave) continue;
    const int whole = body_link(link.body);
    join_trees(link.tree, links_[whole].tree);
    if (held_by(whole) == held_by(int(&link - links_.data()))) continue;
    SimTK::MobilizedBody master = links_[whole].mobod, slave = link.mobod;
    has_loops_ = true;
    SimTK::Constraint::Weld(master, slave);
  }
}

void Mechanism::add_link(Link link, int inboard_link, int anchor, int fragments) {
  using SimTK::MobilizedBody;
  const Body& body = model_->bodies[link.body];
  const SimTK::Body::Rigid rigid = rigid_body(body, 1.0 / fragments);
  const int index = int(links_.size());
  link.tree = index;
  if (inboard_link >= 0 && !links_[inboard_link].kinematic) link.tree = links_[inboard_link].tree;
  if (!link.slave) body_links_[link.body] = index;
  if (link.joint < 0) {
    const SimTK::Vec3 at = link.kinematic ? SimTK::Vec3(0) : to_simtk(body.com);
    link.mobod = MobilizedBody::Free(matter.Ground(), SimTK::Transform(), rigid, at);
    if (link.kinematic) link.motion = SimTK::Motion::Steady(link.mobod, SimTK::Vec6(0));
    links_.push_back(link);
    return;
  }
  joint_links_[link.joint] = index;
  const Joint& joint = model_->joints[link.joint];
  const bool on_ground = inboard_link < 0;
  const MobilizedBody inboard =
      on_ground ? MobilizedBody(matter.Ground()) : links_[inboard_link].mobod;
  const Pose* const place = on_ground && anchor >= 0 ? &static_poses_[anchor] : nullptr;
  mobilize(joint, inboard, place, rigid, link);
  add_axes(joint, link);
  links_.push_back(link);
}

SimTK::Constraint Mechanism::keep(std::unique_ptr<LinearRows> rows) {
  if (rows->empty()) return {};
  has_loops_ = true;
  rows_.push_back(rows.get());
  return rows_constraints_.emplace_back(SimTK::Constraint::Custom(rows.release()));
}

void Mechanism::add_rotors() {
  auto rows = std::make_unique<LinearRows>(matter);
  for (std::size_t l = 0; l < links_.size(); ++l) {
    if (links_[l].joint < 0) continue;
    const Joint& joint = model_->joints[links_[l].joint];
    for (int i = 0; i < speed_count(joint.type) && !joint.axes.empty(); ++i) {
      Rotor rotor;
      rotor.link = int(l);
      rotor.axis = i;
      rotor.inertia = axis_of_speed(joint, i).rotor_inertia;
      if (rotor.inertia <= 0.0) continue;
      const SimTK::Body::Rigid body(
          SimTK::MassProperties(1, SimTK::Vec3(0), SimTK::Inertia(rotor.inertia)));
      rotor.pin = SimTK::MobilizedBody::Pin(matter.Ground(), body);
      rows->add_speeds({{&links_[l].mobod, links_[l].u_map[i], 1.0}, {&rotor.pin, 0, -1.0}});
      rotors_.push_back(rotor);
    }
  }
  keep(std::move(rows));
}

void Mechanism::add_couplings() {
  auto rows = std::make_unique<LinearRows>(matter);
  for (const Coupling& coupling : model_->couplings) {
    if (coupling.removed) continue;
    std::vector<LinearRows::Term> terms;
    double still = -coupling.offset;  // what does not move is where it begins
    int first = -1;
    const auto add = [&](int joint, double factor) {
      const int index = joint_link(joint);
      if (index < 0) {
        still += factor * model_->joints[joint].position.at(0);
        return;
      }
      const Link& link = links_[index];
      if (first < 0) first = index;
      join_trees(link.tree, links_[first].tree);
      terms.push_back({&link.mobod, link.q_map[0], factor});
    };
    add(coupling.joint, 1.0);
    for (const CouplingTerm& term : coupling.terms) add(term.joint, -term.ratio);
    if (terms.empty()) continue;
    rows->add_coordinates(terms, still);
    coupled_.push_back(int(&coupling - model_->couplings.data()));
  }
  couplers_ = keep(std::move(rows));
}

void Mechanism::add_coupling_efforts(const SimTK::State& state, std::vector<double>& joints) const {
  if (coupled_.empty()) return;
  system.realize(state, SimTK::Stage::Acceleration);
  const SimTK::Vector multipliers = couplers_.getMultipliersAsVector(state);
  for (std::size_t i = 0; i < coupled_.size(); ++i) {
    const Coupling& coupling = model_->couplings[coupled_[i]];
    const double effort = -multipliers[int(i)];
    joints[model_->joints[coupling.joint].speed_offset] += effort;
    for (const CouplingTerm& term : coupling.terms)
      joints[model_->joints[term.joint].speed_offset] -= term.ratio * effort;
  }
}

void Mechanism::set_rotors(SimTK::State& state) const {
  for (const Rotor& rotor : rotors_) {
    const Link& link = links_[rotor.link];
    state.updU()[rotor.u] = state.getU()[link.u + link.u_map[rotor.axis]];
  }
}

void Mechanism::add_axes(const Joint& joint, const Link& link) {
  const bool ball = joint.type == JointType::ball;
  if (joint.axes.empty()) return;
  if (ball && (joint.axes[0].has_limit() || joint.axes[0].stiffness > 0.0))
    throw std::runtime_error("it has no stop or spring for the ball joint '" + joint.name + "'");
  for (int i = 0; i < speed_count(joint.type); ++i) {
    const JointAxis& axis = axis_of_speed(joint, i);
    AxisForces made;
    made.joint = link.joint;
    made.effort = joint.speed_offset + i;
    made.axis = axis;
    made.rotor = axis.rotor_inertia;
    const SimTK::MobilizerUIndex u(link.u_map[i]);
    const SimTK::MobilizerQIndex q(link.q_map[i]);
    made.u = u;
    made.q = q;
    if (axis.damping > 0.0)
      made.damper = SimTK::Force::MobilityLinearDamper(forces, link.mobod, u, axis.damping);
    if (axis.stiffness > 0.0)
      SimTK::Force::MobilityLinearSpring(forces, link.mobod, q, axis.stiffness, axis.rest);
    made.stops = axis.has_limit();
    if (made.stops)
      made.stop =
          SimTK::Force::MobilityLinearStop(forces, link.mobod, q, 0.0, 0.0, axis.lower, axis.upper);
    if (made.stops || axis.damping > 0.0 || axis.stiffness > 0.0) axes_.push_back(made);
  }
}

SimTK::State Mechanism::realize_topology() {
  SimTK::State state = system.realizeTopology();
  state.updTime() = 0.0;  // which is not a number otherwise
  system.realizeModel(state);
  for (Link& link : links_) {
    link.q = int(link.mobod.getFirstQIndex(state));
    link.u = int(link.mobod.getFirstUIndex(state));
    link.nq = link.mobod.getNumQ(state);
    link.nu = link.mobod.getNumU(state);
  }
  system.realize(state, SimTK::Stage::Instance);
  for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i]->locate(state, rows_constraints_[i]);
  for (Rotor& rotor : rotors_) rotor.u = int(rotor.pin.getFirstUIndex(state));
  for (AxisForces& axis : axes_) {
    const Link& link = links_[joint_link(axis.joint)];
    axis.q += link.q;
    axis.u += link.u;
  }
  set_axes(state);
  set_all(state, initial_state(*model_));
  return state;
}

double Mechanism::stiff_damping(int effort) const {
  for (const AxisForces& axis : axes_)
    if (axis.effort == effort && axis.is_stiff) return axis.axis.damping;
  return 0.0;
}

// Stops are as stiff as the axis is heavy where all coordinates are zero: whatever else is there, and
// wherever it is, changes nothing. So is what counts as a stiff damper.
void Mechanism::set_axes(SimTK::State& state) {
  constexpr double kStable = 3.0;  // of the step over the time constant: Runge and Kutta's limit
  SimTK::Vector unit(state.getNU(), 0.0), column;
  system.realize(state, SimTK::Stage::Position);
  for (AxisForces& axis : axes_) {
    unit[axis.u] = 1.0;
    matter.multiplyByMInv(state, unit, column);
    unit[axis.u] = 0.0;
    const double inertia = 1.0 / std::max(column[axis.u], 1e-12) + axis.rotor;
    axis.is_stiff = axis.axis.damping * model_->physics.step > kStable * inertia;
    axis.stop_stiffness = options_.contact.frequency * options_.contact.frequency * inertia;
  }
  for (const AxisForces& axis : axes_) {
    if (axis.stops)
      axis.stop.setMaterialProperties(state, axis.stop_stiffness, options_.stop_dissipation);
    if (axis.is_stiff) axis.damper.disable(state);
  }
  system.realizeModel(state);
}

Pose Mechanism::pose(const SimTK::State& state, int body) const {
  if (body == kWorld) return {};
  const int link = body_link(body);
  if (link < 0) return static_poses_[body];
  return from_simtk(links_[link].mobod.getBodyTransform(state));
}

Twist Mechanism::twist(const SimTK::State& state, int body) const {
  const int link = body_link(body);
  if (link < 0) return {};
  const SimTK::SpatialVec& V = links_[link].mobod.getBodyVelocity(state);
  return {from_simtk(V[1]), from_simtk(V[0])};
}

void Mechanism::set_base(SimTK::State& state, const Link& link, const Pose& X_WB,
                         const Twist& V_WB) const {
  SimTK::Vector &q = state.updQ(), &u = state.updU();
  const Vec3 r = link.kinematic ? Vec3::Zero() : Vec3(X_WB.q * model_->bodies[link.body].com);
  const Vec3 p = X_WB.p + r, v = V_WB.at(r);
  q[link.q] = X_WB.q.w();
  for (int k = 0; k < 3; ++k) {
    q[link.q + 1 + k] = X_WB.q.vec()[k];
    q[link.q + 4 + k] = p[k];
    u[link.u + k] = V_WB.angular[k];
    u[link.u + 3 + k] = v[k];
  }
}

void Mechanism::set_joint(SimTK::State& state, const Link& link, const double* q,
                          const double* u) const {
  SimTK::Vector &all_q = state.updQ(), &all_u = state.updU();
  for (int k = 0; k < link.nq; ++k) all_q[link.q + link.q_map[k]] = q[k];
  for (int k = 0; k < link.nu; ++k) all_u[link.u + link.u_map[k]] = u[k];
}

void Mechanism::get_joint(const SimTK::State& state, const Link& link, double* q, double* u) const {
  const SimTK::Vector &all_q = state.getQ(), &all_u = state.getU();
  for (int k = 0; k < link.nq; ++k) q[k] = all_q[link.q + link.q_map[k]];
  for (int k = 0; k < link.nu; ++k) u[k] = all_u[link.u + link.u_map[k]];
}

void Mechanism::set_all(SimTK::State& state, const WorldState& from) const {
  for (const Link& link : links_) {
    if (link.joint < 0) {
      set_base(state, link, from.poses[link.body], from.twists[link.body]);
      continue;
    }
    const Joint& joint = model_->joints[link.joint];
    set_joint(state, link, from.joint_positions.data() + joint.position_offset,
              from.joint_velocities.data() + joint.speed_offset);
  }
  set_rates(state);
  set_rotors(state);
  project(state);
}

void Mechanism::set_rates(SimTK::State& state) const {
  const SimTK::Vector u = state.getU();
  for (const Link& link : links_)
    for (int k = 0; link.kinematic && k < 6; ++k)
      link.motion.setOneRate(state, SimTK::MobilizerUIndex(k), u[link.u + k]);
}

void Mechanism::project(SimTK::State& state) const {
  constexpr double kTolerance = 1e-10;  // [m], [rad], of loops
  system.realize(state, SimTK::Stage::Time);
  matter.normalizeQuaternions(state);
  system.project(state, kTolerance);
  system.realize(state, SimTK::Stage::Velocity);
}

}  // namespace cogrsim::simbody
