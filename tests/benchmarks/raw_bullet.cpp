// The benchmark scenes on bare Bullet in double precision, the way its manual does it: rigid bodies
// with constraints, Bullet's own margins, solver and defaults.
#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "engine_program.h"

namespace {

using namespace cogrsim::bench;

btVector3 vector(const Triple& v) { return {v[0], v[1], v[2]}; }
btQuaternion quaternion(const Turn& q) { return {q[1], q[2], q[3], q[0]}; }
Triple triple(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
Turn turn(const btQuaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

class Rigid final : public Runner {
 public:
  explicit Rigid(const Scene& scene) : scene_(scene) {
    // Several points per convex-plane pair in one pass: wheels need them.
    configuration_.setPlaneConvexMultipointIterations(4, 4);
    // Runs repeat: pairs in order of their bodies, not of addresses.
    world_.getDispatchInfo().m_deterministicOverlappingPairs = true;
    world_.getSolverInfo().m_restitutionVelocityThreshold = 0.05;
    gCalculateCombinedFrictionCallback = [](const btCollisionObject* a,
                                            const btCollisionObject* b) {
      return std::sqrt(a->getFriction() * b->getFriction());
    };
    gCalculateCombinedRestitutionCallback = [](const btCollisionObject* a,
                                               const btCollisionObject* b) {
      return std::max(a->getRestitution(), b->getRestitution());
    };
    world_.setGravity(vector(scene.gravity));
    for (const Thing& thing : scene_.things) add(thing);
    for (const Hinge& hinge : scene_.hinges) add(hinge);
  }
  ~Rigid() override {
    for (auto& constraint : constraints_) world_.removeConstraint(constraint.get());
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  void step(double dt) override {
    if (!scene_.eyes.empty() && steps_ % scene_.eye_period == 0) look();
    world_.stepSimulation(dt, 0);
    ++steps_;
  }
  void get_states(std::vector<ThingState>& states) override {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const btRigidBody& body = *bodies_[i];
      states[i] = {triple(body.getWorldTransform().getOrigin()),
                   turn(body.getWorldTransform().getRotation())};
    }
  }
  double seen() override { return seen_; }

 private:
  /// The nearest hit that is not on the body the eye is mounted on.
  struct NotItself final : btCollisionWorld::ClosestRayResultCallback {
    NotItself(const btVector3& from, const btVector3& to, const btCollisionObject* own)
        : ClosestRayResultCallback(from, to), self(own) {}
    bool needsCollision(btBroadphaseProxy* proxy) const override {
      return proxy->m_clientObject != self && ClosestRayResultCallback::needsCollision(proxy);
    }
    const btCollisionObject* self;
  };

  void look() {
    seen_ = 0;
    for (const Eye& eye : scene_.eyes) {
      const btRigidBody& body = *bodies_[eye.thing];
      const btTransform& X = body.getWorldTransform();
      const btVector3 from = X * vector(eye.at);
      const btVector3 to = from + X.getBasis() * vector(eye.along) * scene_.eye_range;
      NotItself result(from, to, &body);
      world_.rayTest(from, to, result);
      seen_ += scene_.eye_range * (result.hasHit() ? result.m_closestHitFraction : 1.0);
    }
  }

  btCollisionShape* shape(const Part& part) {
    std::unique_ptr<btCollisionShape> made;
    switch (part.form) {
      case Form::box:
        made = std::make_unique<btBoxShape>(vector(part.size) / 2);
        break;
      case Form::sphere:
        made = std::make_unique<btSphereShape>(part.size[0]);
        break;
      case Form::cylinder:
        made = std::make_unique<btCylinderShapeZ>(
            btVector3(part.size[0], part.size[0], part.size[1] / 2));
        break;
      case Form::capsule:
        made = std::make_unique<btCapsuleShapeZ>(part.size[0], part.size[1]);
        break;
      case Form::plane:
        made = std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0);
        break;
    }
    shapes_.push_back(std::move(made));
    return shapes_.back().get();
  }

  btCollisionShape* shape(const Thing& thing) {
    // One shape for all things that look alike.
    for (std::size_t i = 0; i < made_.size(); ++i) {
      if (made_[i].first->parts.size() == thing.parts.size() &&
          std::equal(thing.parts.begin(), thing.parts.end(), made_[i].first->parts.begin(),
                     [](const Part& a, const Part& b) {
                       return a.form == b.form && a.size == b.size && a.at == b.at;
                     })) {
        return made_[i].second;
      }
    }
    btCollisionShape* form = nullptr;
    if (thing.parts.size() == 1) {
      form = shape(thing.parts.front());
    } else {
      auto compound = std::make_unique<btCompoundShape>();
      for (const Part& part : thing.parts) {
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), vector(part.at)),
                                shape(part));
      }
      form = compound.get();
      shapes_.push_back(std::move(compound));
    }
    made_.emplace_back(&thing, form);
    return form;
  }

  void add(const Thing& thing) {
    btRigidBody::btRigidBodyConstructionInfo info(thing.mass, nullptr, shape(thing),
                                                  vector(thing.moments));
    info.m_startWorldTransform = btTransform(quaternion(thing.turn), vector(thing.place));
    info.m_friction = thing.friction;
    info.m_restitution = thing.restitution;
    auto body = std::make_unique<btRigidBody>(info);
    body->setActivationState(DISABLE_DEACTIVATION);
    body->setLinearVelocity(vector(thing.velocity));
    body->setAngularVelocity(vector(thing.spin));
    if (scene_.contact) {
      world_.addRigidBody(body.get());
    } else {
      world_.addRigidBody(body.get(), 0, 0);
    }
    for (std::size_t i = 0; thing.family >= 0 && i < bodies_.size(); ++i) {
      if (scene_.things[i].family != thing.family) continue;
      bodies_[i]->setIgnoreCollisionCheck(body.get(), true);
      body->setIgnoreCollisionCheck(bodies_[i].get(), true);
    }
    bodies_.push_back(std::move(body));
  }

  const Thing& thing(int index) const { return scene_.things[index]; }

  /// The frame whose z is the hinge's axis, in a body's own axes; numbers that a user of Bullet
  /// would bring along. Eigen's rounding is that of the project's models, which hold such frames,
  /// too: computed by btTransform, they differ by 1e-16.
  static btTransform frame_in(const Thing& thing, const Hinge& hinge) {
    using Eigen::Quaterniond, Eigen::Vector3d;
    const Vector3d axis = Vector3d(hinge.axis.data()).normalized();
    const Quaterniond z_to_axis = Quaterniond(1 + axis.z(), -axis.y(), axis.x(), 0).normalized();
    const Quaterniond to_body =
        Quaterniond(thing.turn[0], thing.turn[1], thing.turn[2], thing.turn[3]).conjugate();
    const Vector3d p =
        -(to_body * Vector3d(thing.place.data())) + to_body * Vector3d(hinge.anchor.data());
    const Quaterniond q = (to_body * z_to_axis).normalized();
    return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), btVector3(p.x(), p.y(), p.z()));
  }

  /// Both bodies hold the same frame.
  void add(const Hinge& hinge) {
    btRigidBody& parent =
        hinge.parent < 0 ? btTypedConstraint::getFixedBody() : *bodies_[hinge.parent];
    btRigidBody& child = *bodies_[hinge.child];
    auto made = std::make_unique<btHingeConstraint>(
        parent, child,
        hinge.parent < 0 ? frame_in(Thing(), hinge) : frame_in(thing(hinge.parent), hinge),
        frame_in(thing(hinge.child), hinge), true);
    // Of the child against the parent; the bound is an impulse.
    if (hinge.driven) made->enableAngularMotor(true, hinge.speed, hinge.max_torque * scene_.step);
    world_.addConstraint(made.get(), true);
    constraints_.push_back(std::move(made));
  }

  const Scene scene_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::pair<const Thing*, btCollisionShape*>> made_;
  std::vector<std::unique_ptr<btTypedConstraint>> constraints_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  double seen_ = 0;
  int steps_ = 0;
};

class Bullet final : public EngineProgram {
 public:
  std::string name() const override { return "raw-bullet"; }
  std::string version() const override {
    const int version = btGetVersion();
    return std::to_string(version / 100) + "." + std::to_string(version % 100);
  }
  std::string settings() const override {
    return "double precision; sequential impulses, 10 iterations; hinges are constraints";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    return std::make_unique<Rigid>(scene);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Bullet bullet;
  return engine_main(argc, argv, bullet);
}
