#include "engine.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "cogrsim/core/constants.h"

namespace cogrsim::ode {

// A rotor's inertia over that of the bodies it turns, up to which QuickStep's 20 sweeps hold it: with
// 100 times a double pendulum is 75 mrad off after 3 s.
constexpr double kMostRotor = 10.0;

const ParameterTable& Engine::options() {
  static const ParameterTable table = {
      parameter("solver", "auto",
                "step: dWorldStep, Dantzig's method, which costs the cube of a connected group of "
                "bodies; "
                "quick: dWorldQuickStep, sweeps; auto: step where the scene has joints, else quick")
          .one_of({"auto", "step", "quick"}),
      parameter("iterations", 20, "sweeps of QuickStep (dWorldSetQuickStepNumIterations)")
          .range(1, 10000),
      parameter("sor", 1.3, "over-relaxation of QuickStep (dWorldSetQuickStepW)").range(0.01, 2.0),
      parameter("erp", 0.2, "part of an error of joints and contacts that a step takes away")
          .range(0.0, 1.0),
      parameter("cfm", 1e-10, "constraint force mixing of joints and contacts").range(0.0, 1.0),
      parameter("contact-max-correcting-velocity", 0.0, "m/s",
                "fastest that contacts push bodies apart that overlap; 0: no bound, as in ODE")
          .range(0.0, 1e6),
      parameter("contact-surface-layer", 0.0, "m", "depth to which contacts let bodies sink in")
          .range(0.0, 1.0),
      parameter("friction", "pyramid",
                "pyramid: bound by the load along each of two directions (dContactApprox1); box: "
                "the coefficient is the largest force [N] along each, whatever the load, as in ODE")
          .one_of({"pyramid", "box"}),
  };
  return table;
}

Engine::Engine(const SceneModelPtr& model, const Parameters& options, const Engine* old)
    : model_(model),
      options_(options),
      shapes_(old ? old->shapes_ : std::make_shared<ShapeData>()),
      filter_(*model),
      surfaces_(model) {
  const auto number = [&](const char* name) { return value_of<double>(options_, name); };
  prepare_thread();
  world_ = dWorldCreate();
  space_ = dHashSpaceCreate(nullptr);
  dSpaceSetCleanup(space_, 0);
  contacts_ = dJointGroupCreate(0);
  // The default one is shared by all worlds of the process without a lock.
  threading_ = dThreadingAllocateSelfThreadedImplementation();
  dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_),
                                       threading_);
  const Vec3& g = model->physics.gravity;
  dWorldSetGravity(world_, g.x(), g.y(), g.z());
  dWorldSetERP(world_, number("erp"));
  dWorldSetCFM(world_, number("cfm"));
  dWorldSetQuickStepNumIterations(world_,
                                  static_cast<int>(value_of<std::int64_t>(options_, "iterations")));
  dWorldSetQuickStepW(world_, number("sor"));
  if (const double most = number("contact-max-correcting-velocity"); most > 0.0)
    dWorldSetContactMaxCorrectingVel(world_, most);
  dWorldSetContactSurfaceLayer(world_, number("contact-surface-layer"));
  dWorldSetAutoDisableFlag(world_, 0);
  const bool jointed = std::any_of(
      model->joints.begin(), model->joints.end(),
      [](const Joint& joint) { return !joint.removed && joint.type != JointType::free; });
  const std::string& solver = value_of<std::string>(options_, "solver");
  quick_ = solver == "quick" || (solver == "auto" && !jointed);
  bodies_.resize(model->bodies.size());
  pyramid_ = value_of<std::string>(options_, "friction") == "pyramid";
}

Engine::~Engine() {
  // ODE refuses to take anything out of a space in use, and would complain of jobs that are left:
  // what an exception broke off is lost memory.
  if (broken_off_) return;
  for (const Geom& geom : geoms_) {
    if (geom.id) dGeomDestroy(geom.id);
  }
  dSpaceDestroy(space_);
  dJointGroupDestroy(contacts_);
  dWorldSetStepThreadingImplementation(world_, nullptr, nullptr);
  dWorldDestroy(world_);
  dThreadingFreeImplementation(threading_);
}

Result<std::unique_ptr<Engine>> Engine::make(const SceneModelPtr& model, const Parameters& options,
                                             const WorldState& begin, const Engine* old) {
  std::unique_ptr<Engine> out(new Engine(model, options, old));
  for (std::size_t b = 0; b < model->bodies.size(); ++b) out->add_body(b);
  for (std::size_t j = 0; j < model->joints.size(); ++j) out->add_joint(j, begin.poses);
  for (std::size_t b = 0; b < model->bodies.size(); ++b) {
    out->bodies_[b].set_pose(model->bodies[b].X_WB);
    if (auto added = out->add_geoms(b, begin.poses[b]); !added)
      return tl::unexpected(added.error());
  }
  return out;
}

void Engine::add_body(std::size_t b) {
  const Body& body = model_->bodies[b];
  if (body.removed || body.kind == BodyKind::static_body) return;
  bodies_[b].create(world_, body);
  if (body.kind == BodyKind::dynamic && body.gravity_scale != 1.0) {
    lifts_.emplace_back(bodies_[b].id(),
                        (body.gravity_scale - 1.0) * body.mass * model_->physics.gravity);
  }
}

// From where the scene has the bodies: what a joint is must not depend on when it is made.
void Engine::add_joint(std::size_t j, const std::vector<Pose>& poses) {
  const Joint& joint = model_->joints[j];
  const auto end = [&](int b) {
    JointEnd made;
    if (b == kWorld || joint.removed) return made;
    bodies_[b].set_pose(model_->bodies[b].X_WB);
    if (bodies_[b].exists()) made.body = &bodies_[b];
    made.start = made.body ? model_->bodies[b].X_WB : poses[b];
    return made;
  };
  joints_.emplace_back(world_, *model_, static_cast<int>(j), end(joint.parent), end(joint.child),
                       value_of<double>(options_, "cfm"));
}

Result<> Engine::add_geoms(std::size_t b, const Pose& pose) {
  const Body& body = model_->bodies[b];
  if (body.removed) return {};
  for (std::size_t s = 0; s < body.shapes.size(); ++s) {
    const Shape& shape = body.shapes[s];
    // ODE's space counts cells of 1/8 m and more in an int: what nothing gets to is left out.
    const bool out_of_reach = !bodies_[b].exists() && shape.type != ShapeType::plane &&
                              pose.p.norm() > 10.0 * kBounds.distance;
    if (!shape.collides || out_of_reach) continue;
    Geom& geom = geoms_.emplace_back();
    geom.body = static_cast<int>(b);
    geom.shape = static_cast<int>(s);
    geom.index = static_cast<int>(geoms_.size()) - 1;
    if (shape.type == ShapeType::plane && bodies_[b].exists())
      return fail("shape '" + shape.name + "': a plane cannot be moved",
                  source_position(*model_, shape.origin), "make its body static, or use a box");
    if (auto made = make_geom(space_, *model_, shape, *shapes_, geom); !made) return made;
    geom.surface_velocity = shape.X_BS.q * shape.surface_velocity;
    if (!bodies_[b].exists()) geom.surface_velocity = pose.q * geom.surface_velocity;
    dGeomSetData(geom.id, &geom);
    if (!bodies_[b].exists()) {
      place_geom(geom, shape.type, pose);
      continue;
    }
    geom.holder = bodies_[b].id();
    dGeomSetBody(geom.id, geom.holder);
    Pose X = geom.X_BG;
    if (body.kind == BodyKind::dynamic && !body.com.isZero(0.0)) X.p -= body.com;
    if (!X.p.isZero(0.0)) dGeomSetOffsetPosition(geom.id, X.p.x(), X.p.y(), X.p.z());
    if (!X.q.vec().isZero(0.0)) {
      const dQuaternion q = {X.q.w(), X.q.x(), X.q.y(), X.q.z()};
      dGeomSetOffsetQuaternion(geom.id, q);
    }
  }
  return {};
}

dSurfaceParameters Engine::surface(const Geom& a, const Geom& b) const {
  const SurfacePair pair = surfaces_(a.material, b.material);
  const double e = pair.restitution;
  dSurfaceParameters out{};
  out.mode = pyramid_ ? dContactApprox1 : dContactApprox0;
  out.mu = pair.friction;
  if (pair.rolling_friction > 0.0 || pair.spinning_friction > 0.0) {
    out.mode |= dContactRolling | dContactAxisDep;
    out.mu2 = pair.friction;
    out.rho = out.rho2 = pair.rolling_friction;
    out.rhoN = pair.spinning_friction;
  }
  if (pair.stiffness && *pair.stiffness > 0.0) {
    // ODE's spring k and damper d: erp = h k / (h k + d), cfm = 1 / (h k + d).
    const double ratio = e > 0.0 ? -std::log(e) / std::hypot(kPi, std::log(e)) : 1.0;
    double mobility = 0.0;  // [1/kg]
    for (const dBodyID body : {a.holder, b.holder}) {
      dMass mass{};
      if (body) dBodyGetMass(body, &mass);
      if (body && !dBodyIsKinematic(body)) mobility += 1.0 / mass.mass;
    }
    const double k = *pair.stiffness, d = 2.0 * ratio * std::sqrt(k / mobility);
    out.mode |= dContactSoftERP | dContactSoftCFM;
    out.soft_erp = h_ * k / (h_ * k + d);
    out.soft_cfm = 1.0 / (h_ * k + d);
  } else if (e > 0.0) {
    out.mode |= dContactBounce;
    out.bounce = e;
    out.bounce_vel = model_->physics.bounce_threshold;
  }
  return out;
}

// Directions of friction along and across what the surfaces move; ODE aims at a velocity of the body
// that it calls its first, the second where the first geom has none.
void Engine::set_motion(dContact& contact, const Geom& a, const Geom& b) {
  const auto world = [](const Geom& geom) -> Vec3 {
    if (!geom.holder || geom.surface_velocity.isZero(0.0)) return geom.surface_velocity;
    return to_mat(dBodyGetRotation(geom.holder)) * geom.surface_velocity;
  };
  Vec3 along = a.holder ? Vec3(world(b) - world(a)) : Vec3(world(a) - world(b));
  const Vec3 n = to_vec(contact.geom.normal);
  along -= n.dot(along) * n;
  const double speed = along.norm();
  if (speed == 0.0) return;
  contact.surface.mode |= dContactFDir1 | dContactMotion1;
  contact.surface.motion1 = speed;
  for (int k = 0; k < 3; ++k) contact.fdir1[k] = along[k] / speed;
}

void Engine::near(void* self, dGeomID a, dGeomID b) {
  static_cast<Engine*>(self)->near(*static_cast<const Geom*>(dGeomGetData(a)),
                                   *static_cast<const Geom*>(dGeomGetData(b)));
}

void Engine::near(const Geom& a, const Geom& b) {
  if (!filter_.collide(a.body, b.body)) return;
  constexpr int kMost = 32;
  dContact found[kMost];
  const int count = dCollide(a.id, b.id, kMost, &found[0].geom, static_cast<int>(sizeof(dContact)));
  const dSurfaceParameters of_pair = count > 0 ? surface(a, b) : dSurfaceParameters();
  for (int i = 0; i < count; ++i) {
    dContact& contact = found[i];
    // Without a direction no contact can be made: libccd gives none where two just touch.
    if (contact.geom.normal[0] == 0 && contact.geom.normal[1] == 0 && contact.geom.normal[2] == 0)
      continue;
    contact.surface = of_pair;
    set_motion(contact, a, b);
    const dJointID joint = dJointCreateContact(world_, contacts_, &contact);
    dJointAttach(joint, a.holder, b.holder);
    if (touched_ == touches_.size() * kBlock) touches_.push_back(std::make_unique<Touch[]>(kBlock));
    Touch& made = touch(touched_++);
    made.point = to_vec(contact.geom.pos);
    made.normal = to_vec(contact.geom.normal);
    made.depth = contact.geom.depth;
    made.first = &a;
    made.second = &b;
    dJointSetFeedback(joint, &made.feedback);
  }
}

void Engine::step(const StepInput& input) {
  prepare_thread();
  before_ = motions();
  if (find_lost() >= 0) return;
  for (JointLink& link : joints_) link.drive(input);
  for (std::size_t b = 0; b < input.external.size(); ++b) bodies_[b].push(input.external[b]);
  h_ = input.dt;
  touched_ = 0;
  broken_off_ = true;
  for (const auto& [body, force] : lifts_) dBodyAddForce(body, force.x(), force.y(), force.z());
  dSpaceCollide(space_, this, &Engine::near);
  if (quick_) {
    quick_step(world_, h_, seed_);
  } else {
    dWorldStep(world_, h_);
  }
  dJointGroupEmpty(contacts_);
  broken_off_ = false;
}

int Engine::find_lost() const {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (!bodies_[b].is_within_bounds()) return static_cast<int>(b);
  return -1;
}

void Engine::read_contacts(std::vector<Contact>& out) const {
  for (std::size_t i = 0; i < touched_; ++i) {
    const Touch& found = touch(i);
    const Geom &first = *found.first, &second = *found.second;
    // ODE's normal points into its first geom; the force is on the body that it calls its first,
    // the second where the first geom has none.
    const Vec3 force = to_vec(found.feedback.f1);
    out.push_back({second.body, first.body, second.shape, first.shape, found.point, found.normal,
                   found.depth, first.holder ? force : Vec3(-force)});
  }
}

void Engine::read_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  Wrench unused;
  for (const JointLink& link : joints_)
    link.report(h_, {joints.data() + link.joint().speed_offset, motors.data(), &unused});
}

void Engine::read_reactions(std::vector<Wrench>& out) const {
  std::vector<double> joints(model_->joint_speeds), motors(model_->motors.size());
  for (const JointLink& link : joints_)
    link.report(h_, {joints.data() + link.joint().speed_offset, motors.data(), &out[link.index()]});
}

double Engine::fastest_spin() const {
  double square = 0.0;
  for (const BodyLink& body : bodies_) square = std::max(square, body.spin_squared());
  return std::sqrt(square);
}

void Engine::write(const WorldState& state) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].set_pose(state.poses[b]);
    bodies_[b].set_twist(state.twists[b]);
  }
  touched_ = 0;
}

std::vector<Motion> Engine::motions() const {
  std::vector<Motion> out;
  for (const BodyLink& body : bodies_) out.push_back(body.motion());
  return out;
}

void Engine::set_motions(const std::vector<Motion>& motions) {
  for (std::size_t b = 0; b < motions.size(); ++b) bodies_[b].set_motion(motions[b]);
}

void Engine::take_over(const Engine& old, const WorldState& begin, const SceneChange& change) {
  set_motions(old.motions());
  for (const int b : change.kinds) {
    bodies_[b].set_pose(begin.poses[b]);
    bodies_[b].set_twist({});
  }
  seed_ = old.seed_;
}

/// `order`: of geoms in ODE's space, which decides the order of contacts and with it the last digits;
/// none where ODE was broken off.
struct Engine::Memory final : HostedMemory {
  unsigned long seed = 0;
  std::vector<Motion> motions;
  double h = 0.0;
  std::vector<int> order;
};

bool Engine::undo() {
  undone_ = true;
  return false;
}

std::shared_ptr<const HostedMemory> Engine::save() const {
  auto out = std::make_shared<Memory>();
  out->seed = seed_;
  out->h = h_;
  out->motions = undone_ ? before_ : motions();
  for (int i = 0; !undone_ && i < dSpaceGetNumGeoms(space_); ++i)
    out->order.push_back(static_cast<const Geom*>(dGeomGetData(dSpaceGetGeom(space_, i)))->index);
  return out;
}

void Engine::restore(const HostedMemory& memory) {
  const auto& saved = static_cast<const Memory&>(memory);
  seed_ = saved.seed;
  h_ = saved.h;
  set_motions(saved.motions);
  touched_ = 0;
  // ODE puts what is added in front.
  for (const int i : saved.order) dSpaceRemove(space_, geoms_[i].id);
  for (auto i = saved.order.rbegin(); i != saved.order.rend(); ++i)
    dSpaceAdd(space_, geoms_[*i].id);
}

std::vector<Diagnostic> Engine::warnings() const {
  if (!quick_) return {};
  std::vector<std::vector<double>> ratios;
  for (const JointLink& link : joints_) ratios.push_back(link.rotor_ratios());
  return rotor_warnings(*model_, kName, ratios, kMostRotor);
}

}  // namespace cogrsim::ode
