// The benchmark scenes as programs on bare Simbody. It has no contact of its own for these shapes,
// so the programs do what such programs do: Bullet's detection, once per step and fresh, frozen in
// the bodies' frames; springs and dashpots with friction springs on top; symplectic Euler substeps.
#include <Simbody.h>
#include <btBulletCollisionCommon.h>

#include <cmath>
#include <unordered_map>

#include "engine_program.h"

namespace {

using namespace cogrsim::bench;

using SimTK::MobilizedBody;
using SimTK::Real;
using SimTK::Rotation;
using SimTK::State;
using SimTK::Transform;
using STVec3 = SimTK::Vec3;

STVec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// Stiffness and damping of every contact point, and of its friction spring.
struct ContactLaw {
  Real stiffness = 1e5, damping_ratio = 0.1, tangential = 0.3;
};

class SpringContact final : public SimTK::Force::Custom::Implementation {
 public:
  SpringContact(const ContactLaw& law, Real substep) : law_(law), substep_(substep) {
    configuration_.setPlaneConvexMultipointIterations(4, 4);
    world_.getPairCache()->setOverlapFilterCallback(&families_);
  }

  /// Objects of one family do not collide with each other.
  void add(const MobilizedBody& body, btCollisionShape* shape, Real friction, int family) {
    auto object = std::make_unique<btCollisionObject>();
    object->setCollisionShape(shape);
    object->setUserIndex(static_cast<int>(bodies_.size()));
    object->setUserIndex2(family);
    if (body.isGround()) object->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
    world_.addCollisionObject(object.get());
    bodies_.push_back({body, friction,
                       body.isGround() ? 0.0 : 1.0 / body.getDefaultMassProperties().getMass(),
                       std::move(object)});
  }
  btCollisionObject& last_object() { return *bodies_.back().object; }

  /// Distance to the nearest object but that of index `self` along a ray [m], at most `range`.
  /// Uses the places of the last detection.
  Real look(std::size_t self, const btVector3& from, const btVector3& along, Real range) {
    struct NotItself final : btCollisionWorld::ClosestRayResultCallback {
      using ClosestRayResultCallback::ClosestRayResultCallback;
      bool needsCollision(btBroadphaseProxy* proxy) const override {
        return proxy->m_clientObject != self && ClosestRayResultCallback::needsCollision(proxy);
      }
      const void* self = nullptr;
    } result(from, from + along * range);
    result.self = bodies_[self].object.get();
    world_.rayTest(from, from + along * range, result);
    return range * (result.hasHit() ? result.m_closestHitFraction : 1.0);
  }

  void detect(const State& state) {
    for (Body& b : bodies_) {
      if (b.body.isGround()) continue;
      const Transform& X = b.body.getBodyTransform(state);
      const Rotation& R = X.R();
      b.object->setWorldTransform(
          btTransform(btMatrix3x3(R[0][0], R[0][1], R[0][2], R[1][0], R[1][1], R[1][2], R[2][0],
                                  R[2][1], R[2][2]),
                      btVector3(X.p()[0], X.p()[1], X.p()[2])));
    }
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      dispatcher_.getManifoldByIndexInternal(i)->clearManifold();
    }
    world_.performDiscreteCollisionDetection();
    old_.clear();
    for (const Point& p : points_) old_.emplace(key(p), p);
    points_.clear();
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      take(state, *dispatcher_.getManifoldByIndexInternal(i));
    }
  }

  void calcForce(const State& state, SimTK::Vector_<SimTK::SpatialVec>& forces,
                 SimTK::Vector_<STVec3>&, SimTK::Vector&) const override {
    for (Point& p : points_) {
      const MobilizedBody& a = bodies_[p.a].body;
      const MobilizedBody& b = bodies_[p.b].body;
      const STVec3 ra = a.getBodyRotation(state) * p.on_a, rb = b.getBodyRotation(state) * p.on_b;
      const STVec3 n = b.getBodyRotation(state) * p.normal;
      const STVec3 gap = a.getBodyOriginLocation(state) + ra - b.getBodyOriginLocation(state) - rb;
      const Real depth = -SimTK::dot(gap, n);
      if (depth <= 0) {
        p.stretch = STVec3(0);
        continue;
      }
      const SimTK::SpatialVec &Va = a.getBodyVelocity(state), &Vb = b.getBodyVelocity(state);
      const STVec3 v = Va[1] + Va[0] % ra - Vb[1] - Vb[0] % rb;
      const Real approach = SimTK::dot(v, n);
      const Real push = law_.stiffness * depth - p.damping * approach;
      if (push <= 0) continue;
      const STVec3 force = push * n + friction(p, v - approach * n, n, push);
      forces[a.getMobilizedBodyIndex()] += SimTK::SpatialVec(ra % force, force);
      forces[b.getMobilizedBodyIndex()] -= SimTK::SpatialVec(rb % force, force);
    }
  }
  Real calcPotentialEnergy(const State&) const override { return 0; }

 private:
  struct Body {
    MobilizedBody body;
    Real friction, inverse_mass;
    std::unique_ptr<btCollisionObject> object;
  };
  struct Point {
    std::size_t a, b;
    STVec3 on_a, on_b, normal;  // in the bodies' frames; the normal in b's
    STVec3 stretch{0};
    Real friction, damping;
  };
  struct Families : btOverlapFilterCallback {
    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
      const int first = static_cast<btCollisionObject*>(a->m_clientObject)->getUserIndex2();
      const int second = static_cast<btCollisionObject*>(b->m_clientObject)->getUserIndex2();
      return first < 0 || first != second;
    }
  };

  static std::size_t key(const Point& p) { return p.a * 1000003 + p.b; }

  void take(const State& state, const btPersistentManifold& manifold) {
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& m = manifold.getContactPoint(j);
      if (m.getDistance() > 2e-3) continue;
      Point p;
      p.a = static_cast<std::size_t>(manifold.getBody0()->getUserIndex());
      p.b = static_cast<std::size_t>(manifold.getBody1()->getUserIndex());
      const Body &a = bodies_[p.a], &b = bodies_[p.b];
      p.on_a = ~a.body.getBodyTransform(state) * from_bullet(m.getPositionWorldOnA());
      p.on_b = ~b.body.getBodyTransform(state) * from_bullet(m.getPositionWorldOnB());
      p.normal = ~b.body.getBodyRotation(state) * from_bullet(m.m_normalWorldOnB);
      p.friction = a.friction * b.friction;
      p.damping =
          2 * law_.damping_ratio * std::sqrt(law_.stiffness / (a.inverse_mass + b.inverse_mass));
      // The friction spring's stretch is that of the nearest old point of the pair.
      Real nearest = 0.02;
      const auto range = old_.equal_range(key(p));
      for (auto it = range.first; it != range.second; ++it) {
        const Real distance = (it->second.on_b - p.on_b).norm();
        if (distance < nearest) {
          nearest = distance;
          p.stretch = it->second.stretch;
        }
      }
      points_.push_back(p);
    }
  }

  STVec3 friction(Point& p, const STVec3& slip, const STVec3& n, Real push) const {
    if (p.friction <= 0) return STVec3(0);
    p.stretch += substep_ * slip;
    p.stretch -= SimTK::dot(p.stretch, n) * n;
    const Real k = law_.tangential * law_.stiffness, cap = p.friction * push;
    STVec3 force = -k * p.stretch - p.damping * slip;
    if (force.norm() > cap) {
      force *= cap / force.norm();
      p.stretch = -(force + p.damping * slip) / k;
    }
    return force;
  }

  ContactLaw law_;
  Real substep_;
  Families families_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  std::vector<Body> bodies_;
  mutable std::vector<Point> points_;
  std::unordered_multimap<std::size_t, Point> old_;
};

/// Velocity motor with a torque limit on a pin joint.
class SpeedMotor final : public SimTK::Force::Custom::Implementation {
 public:
  SpeedMotor(const MobilizedBody& body, const Hinge& hinge)
      : body_(body), target_(hinge.speed), bound_(hinge.max_torque) {}
  void calcForce(const State& state, SimTK::Vector_<SimTK::SpatialVec>&, SimTK::Vector_<STVec3>&,
                 SimTK::Vector& mobility) const override {
    constexpr Real kGain = 0.1;  // [N m s/rad], as stiff as the substep allows
    const Real torque = SimTK::clamp(-bound_, kGain * (target_ - body_.getOneU(state, 0)), bound_);
    body_.applyOneMobilityForce(state, 0, torque, mobility);
  }
  Real calcPotentialEnergy(const State&) const override { return 0; }

 private:
  MobilizedBody body_;
  Real target_, bound_;
};

STVec3 vector(const Triple& v) { return {v[0], v[1], v[2]}; }
btVector3 bullet(const Triple& v) { return {v[0], v[1], v[2]}; }
Triple triple(const STVec3& v) { return {v[0], v[1], v[2]}; }
Rotation rotation(const Turn& q) { return Rotation(SimTK::Quaternion(q[0], q[1], q[2], q[3])); }

/// As stiff as the loads want, so that nothing sinks in far; the frequency of the whole heap times
/// the substep stays well below 1.
ContactLaw law_of(const Scene& scene) {
  ContactLaw law;
  if (scene.name == "spheres") law.stiffness = 1e6;  // ten times the mass of the others
  return law;
}
int substeps_of(const Scene& scene) { return scene.hinges.empty() ? 2 : 1; }

class SimbodyRunner final : public Runner {
 public:
  explicit SimbodyRunner(const Scene& scene)
      : scene_(scene), gravity_(forces_, matter_, vector(scene.gravity)) {
    forces_.setNumberOfThreads(1);
    if (scene.contact) {
      substeps_ = substeps_of(scene);
      contact_ = new SpringContact(law_of(scene), scene.step / substeps_);
      SimTK::Force::Custom(forces_, contact_);  // which takes it over
    }
    for (std::size_t i = 0; i < scene_.things.size(); ++i) add(static_cast<int>(i));
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    for (std::size_t i = 0; i < scene_.things.size(); ++i) {
      const Thing& thing = scene_.things[i];
      if (thing.mass == 0 || hinged_[i]) continue;
      bodies_[i].setQToFitTransform(state_, Transform(rotation(thing.turn), vector(thing.place)));
      bodies_[i].setUToFitAngularVelocity(state_, vector(thing.spin));
    }
    if (contact_) return;
    integrator_ = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system_);
    integrator_->setAccuracy(1e-6);
  }

  void step(double dt) override {
    time_ += dt;
    if (integrator_) {
      if (!started_) {
        integrator_->setMaximumStepSize(dt);
        integrator_->initialize(state_);
        started_ = true;
      }
      while (integrator_->getTime() < time_ - 1e-12) integrator_->stepTo(time_);
      return;
    }
    const Real h = dt / substeps_;
    system_.realize(state_, SimTK::Stage::Velocity);
    contact_->detect(state_);
    if (!scene_.eyes.empty() && steps_++ % scene_.eye_period == 0) look();
    for (int i = 0; i < substeps_; ++i) {
      system_.realize(state_, SimTK::Stage::Acceleration);
      const SimTK::Vector acceleration = state_.getUDot();
      state_.updU() += h * acceleration;
      system_.realize(state_, SimTK::Stage::Velocity);
      const SimTK::Vector rate = state_.getQDot();
      state_.updQ() += h * rate;
      state_.updTime() += h;
      system_.realize(state_, SimTK::Stage::Time);
      matter_.normalizeQuaternions(state_);
    }
  }

  void get_states(std::vector<ThingState>& states) override {
    const State& state = integrator_ && started_ ? integrator_->getState() : state_;
    system_.realize(state, SimTK::Stage::Position);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const MobilizedBody& body = bodies_[i];
      if (scene_.things[i].mass == 0) {
        states[i].place = scene_.things[i].place;
        continue;
      }
      const SimTK::Quaternion q = body.getBodyRotation(state).convertRotationToQuaternion();
      states[i] = {triple(body.getBodyOriginLocation(state)), {q[0], q[1], q[2], q[3]}};
    }
  }
  double seen() override { return seen_; }

 private:
  void look() {
    seen_ = 0;
    for (const Eye& eye : scene_.eyes) {
      const MobilizedBody& body = bodies_[static_cast<std::size_t>(eye.thing)];
      const STVec3 from = body.findStationLocationInGround(state_, vector(eye.at));
      const STVec3 along = body.getBodyRotation(state_) * vector(eye.along);
      seen_ +=
          contact_->look(static_cast<std::size_t>(eye.thing), btVector3(from[0], from[1], from[2]),
                         btVector3(along[0], along[1], along[2]), scene_.eye_range);
    }
  }

  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape) {
    shapes_.push_back(std::move(shape));
    return shapes_.back().get();
  }
  btCollisionShape* shape(const Part& part) {
    switch (part.form) {
      case Form::box:
        return keep(std::make_unique<btBoxShape>(bullet(part.size) / 2));
      case Form::sphere:
        return keep(std::make_unique<btSphereShape>(part.size[0]));
      case Form::cylinder:
        return keep(std::make_unique<btCylinderShapeZ>(
            btVector3(part.size[0], part.size[0], part.size[1] / 2)));
      case Form::plane:
        return keep(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0));
    }
    return nullptr;
  }
  btCollisionShape* shape(const Thing& thing) {
    if (thing.parts.size() == 1) return shape(thing.parts.front());
    auto compound = std::make_unique<btCompoundShape>();
    for (const Part& part : thing.parts) {
      compound->addChildShape(btTransform(btQuaternion::getIdentity(), bullet(part.at)),
                              shape(part));
    }
    return keep(std::move(compound));
  }

  /// A hinge is a pin mobilizer: the tree has no constraints.
  void add(int index) {
    const Thing& thing = scene_.things[static_cast<std::size_t>(index)];
    const Transform here(rotation(thing.turn), vector(thing.place));
    MobilizedBody made = matter_.Ground();
    bool hinged = false;
    if (thing.mass > 0) {
      const SimTK::Body::Rigid body(
          SimTK::MassProperties(thing.mass, STVec3(0), SimTK::Inertia(vector(thing.moments))));
      for (const Hinge& hinge : scene_.hinges) {
        if (hinge.child != index) continue;
        hinged = true;
        const Transform frame(Rotation(SimTK::UnitVec3(vector(hinge.axis)), SimTK::ZAxis),
                              vector(hinge.anchor));
        MobilizedBody parent = matter_.Ground();
        Transform above;
        if (hinge.parent >= 0) {
          const Thing& of = scene_.things[static_cast<std::size_t>(hinge.parent)];
          parent = bodies_[static_cast<std::size_t>(hinge.parent)];
          above = Transform(rotation(of.turn), vector(of.place));
        }
        made = MobilizedBody::Pin(parent, ~above * frame, body, ~here * frame);
        if (hinge.driven) SimTK::Force::Custom(forces_, new SpeedMotor(made, hinge));
      }
      if (!hinged) made = MobilizedBody::Free(matter_.Ground(), Transform(), body, Transform());
    }
    bodies_.push_back(made);
    hinged_.push_back(hinged);
    if (!contact_) return;
    contact_->add(made, shape(thing), std::sqrt(thing.friction), thing.family);
    if (thing.mass > 0) return;
    const Turn& q = thing.turn;
    contact_->last_object().setWorldTransform(
        btTransform(btQuaternion(q[1], q[2], q[3], q[0]), bullet(thing.place)));
  }

  const Scene scene_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::Force::UniformGravity gravity_;
  SpringContact* contact_ = nullptr;  // owned by the force subsystem
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<MobilizedBody> bodies_;
  std::vector<bool> hinged_;
  std::unique_ptr<SimTK::Integrator> integrator_;
  State state_;
  Real time_ = 0;
  double seen_ = 0;
  int substeps_ = 1, steps_ = 0;
  bool started_ = false;
};

class Simbody final : public EngineProgram {
 public:
  std::string name() const override { return "raw-simbody"; }
  std::string version() const override {
    int major = 0, minor = 0, build = 0;
    SimTK_version_simbody(&major, &minor, &build);
    return std::to_string(major) + "." + std::to_string(minor);
  }
  std::string settings() const override {
    return "trees of mobilizers; without contact Runge-Kutta-Merson, accuracy 1e-6, steps no "
           "longer "
           "than asked for; with contact springs of 1e5 N/m (spheres of 10 kg: 1e6) at points from "
           "Bullet's narrowphase, symplectic Euler, 1 substep for robots, else 2";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    return std::make_unique<SimbodyRunner>(scene);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Simbody simbody;
  return engine_main(argc, argv, simbody);
}
