// The benchmark scenes as programs on bare Simbody. It has no contact of its own for these shapes,
// so the programs do what such programs do: Bullet's detection, once per step and fresh, frozen in
// the bodies' frames; springs and dashpots with friction springs on top; symplectic Euler substeps.
#include <Simbody.h>
#include <btBulletCollisionCommon.h>

#include <cmath>
#include <unordered_map>

#include "bench.h"

namespace cogrsim::bench {

namespace {

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
      return static_cast<btCollisionObject*>(a->m_clientObject)->getUserIndex2() !=
             static_cast<btCollisionObject*>(b->m_clientObject)->getUserIndex2();
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
  SpeedMotor(const MobilizedBody& body, Real target) : body_(body), target_(target) {}
  void calcForce(const State& state, SimTK::Vector_<SimTK::SpatialVec>&, SimTK::Vector_<STVec3>&,
                 SimTK::Vector& mobility) const override {
    constexpr Real kGain = 0.1;  // [N m s/rad], as stiff as the substep allows
    const Real torque = SimTK::clamp(
        -robots::kMaxTorque, kGain * (target_ - body_.getOneU(state, 0)), robots::kMaxTorque);
    body_.applyOneMobilityForce(state, 0, torque, mobility);
  }
  Real calcPotentialEnergy(const State&) const override { return 0; }

 private:
  MobilizedBody body_;
  Real target_;
};

SimTK::Body::Rigid rigid(Real mass, const STVec3& moments) {
  return SimTK::Body::Rigid(SimTK::MassProperties(mass, STVec3(0), SimTK::Inertia(moments)));
}

STVec3 box_moments(Real mass, Real x, Real y, Real z) {
  return mass / 12 * STVec3(y * y + z * z, x * x + z * z, x * x + y * y);
}

const Rotation kZToY(-SimTK::Pi / 2, SimTK::XAxis);

class SimbodyRunner final : public Runner {
 public:
  explicit SimbodyRunner(Scene scene) : gravity_(forces_, matter_, STVec3(0, 0, -9.81)) {
    forces_.setNumberOfThreads(1);
    switch (scene) {
      case Scene::free_boxes:
        add_boxes();
        break;
      case Scene::pyramid:
        add_pyramid();
        break;
      case Scene::robots:
        add_robots();
        break;
      case Scene::chain:
        add_chain();
        break;
    }
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      last_[i].setQToFitTransform(state_, starts_[i]);
      if (scene == Scene::free_boxes) {
        last_[i].setUToFitAngularVelocity(state_, STVec3(0.1, boxes::kSpin, 0.1));
      }
    }
    if (scene == Scene::chain) last_.front().setOneQ(state_, 0, chain::kTilt);
    if (contact_) return;
    integrator_ = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system_);
    integrator_->setAccuracy(1e-6);
    integrator_->setMaximumStepSize(kStep);
    integrator_->initialize(state_);
  }

  void step() override {
    time_ += kStep;
    if (integrator_) {
      while (integrator_->getTime() < time_ - 1e-12) integrator_->stepTo(time_);
      return;
    }
    const Real h = kStep / substeps_;
    system_.realize(state_, SimTK::Stage::Velocity);
    contact_->detect(state_);
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

  double last_height() override {
    const State& state = integrator_ ? integrator_->getState() : state_;
    system_.realize(state, SimTK::Stage::Position);
    return (tail_.isEmptyHandle() ? last_.back() : tail_).getBodyOriginLocation(state)[2];
  }

 private:
  void use_contact(int substeps) {
    substeps_ = substeps;
    contact_ = new SpringContact(ContactLaw{}, kStep / substeps);
    SimTK::Force::Custom(forces_, contact_);  // which takes it over
  }
  template <class Shape, class... Args>
  Shape* shape(Args&&... args) {
    auto made = std::make_unique<Shape>(std::forward<Args>(args)...);
    Shape* raw = made.get();
    shapes_.push_back(std::move(made));
    return raw;
  }
  MobilizedBody free_body(const SimTK::Body& body, const STVec3& place) {
    MobilizedBody made = MobilizedBody::Free(matter_.Ground(), Transform(), body, Transform());
    last_.push_back(made);
    starts_.push_back(Transform(place));
    return made;
  }

  void add_boxes() {
    using namespace boxes;
    const auto body = rigid(kMass, box_moments(kMass, kSize, 2 * kSize, 3 * kSize));
    for (int i = 0; i < kCount; ++i) {
      free_body(body, STVec3((i % kPerRow) * kPitch, (i / kPerRow) * kPitch, 1000));
    }
  }

  void add_pyramid() {
    using namespace pyramid;
    use_contact(2);
    const Real friction = std::sqrt(kFriction);
    contact_->add(matter_.Ground(), shape<btBoxShape>(btVector3(50, 50, 1)), friction, -1);
    contact_->last_object().setWorldTransform(
        btTransform(btQuaternion::getIdentity(), btVector3(0, 0, -1)));
    auto* form = shape<btBoxShape>(btVector3(kSize / 2, kSize / 2, kSize / 2));
    int family = 0;
    for (const Vec3& c : centres()) {
      const auto body = rigid(kMass, box_moments(kMass, kSize, kSize, kSize));
      contact_->add(free_body(body, STVec3(c.x(), c.y(), c.z())), form, friction, family++);
    }
  }

  void add_robots() {
    using namespace robots;
    use_contact(1);
    contact_->add(matter_.Ground(), shape<btStaticPlaneShape>(btVector3(0, 0, 1), 0), 1, -1);
    auto* form = shape<btCompoundShape>();
    const btQuaternion straight = btQuaternion::getIdentity();
    form->addChildShape(btTransform(straight),
                        shape<btBoxShape>(btVector3(kChassisX / 2, kChassisY / 2, kChassisZ / 2)));
    form->addChildShape(btTransform(straight, btVector3(kCasterX, 0, kCasterRadius - kHeight)),
                        shape<btSphereShape>(kCasterRadius));
    auto* wheel_form =
        shape<btCylinderShapeZ>(btVector3(kWheelRadius, kWheelRadius, kWheelWidth / 2));
    const Real across =
        kWheelMass * (3 * kWheelRadius * kWheelRadius + kWheelWidth * kWheelWidth) / 12;
    const auto wheel_body =
        rigid(kWheelMass, STVec3(across, across, kWheelMass * kWheelRadius * kWheelRadius / 2));
    const auto chassis_body =
        rigid(kChassisMass, box_moments(kChassisMass, kChassisX, kChassisY, kChassisZ));
    for (int i = 0; i < kPerSide * kPerSide; ++i) {
      const STVec3 place((i / kPerSide) * kSpacing, (i % kPerSide) * kSpacing, kHeight);
      MobilizedBody chassis = free_body(chassis_body, place);
      contact_->add(chassis, form, 0, i);
      for (const int side : {1, -1}) {
        const STVec3 offset(kAxleX, side * kHalfTrack, kWheelRadius - kHeight);
        MobilizedBody wheel =
            MobilizedBody::Pin(chassis, Transform(kZToY, offset), wheel_body, Transform());
        tail_ = wheel;
        contact_->add(wheel, wheel_form, kFriction, i);
        SimTK::Force::Custom(forces_, new SpeedMotor(wheel, side > 0 ? kLeftSpeed : kRightSpeed));
      }
    }
  }

  void add_chain() {
    using namespace chain;
    const auto body = rigid(kMass, box_moments(kMass, kWidth, kWidth, kLength));
    for (int i = 0; i < kLinks; ++i) {
      MobilizedBody parent = i == 0 ? MobilizedBody(matter_.Ground()) : last_.back();
      last_.push_back(MobilizedBody::Pin(parent,
                                         Transform(kZToY, STVec3(0, 0, i == 0 ? 0 : -kLength / 2)),
                                         body, Transform(kZToY, STVec3(0, 0, kLength / 2))));
    }
  }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::Force::UniformGravity gravity_;
  SpringContact* contact_ = nullptr;  // owned by the force subsystem
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<MobilizedBody> last_;
  MobilizedBody tail_;  // the last one where it is not among those
  std::vector<Transform> starts_;
  std::unique_ptr<SimTK::Integrator> integrator_;
  State state_;
  Real time_ = 0;
  int substeps_ = 1;
};

}  // namespace

std::unique_ptr<Runner> make_raw_simbody(Scene scene) {
  return std::make_unique<SimbodyRunner>(scene);
}

}  // namespace cogrsim::bench
