// The benchmark scenes as programs on bare Bullet, double precision.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "bench.h"

namespace cogrsim::bench {

namespace {

btVector3 half(double x, double y, double z) { return {x / 2, y / 2, z / 2}; }

/// What every Bullet program starts with.
class BulletRunner : public Runner {
 public:
  explicit BulletRunner(bool multibody) {
    // Several points per convex-plane pair in one pass: wheels need them.
    configuration_.setPlaneConvexMultipointIterations(4, 4);
    if (multibody) {
      solver_ = std::make_unique<btMultiBodyConstraintSolver>();
      world_ = std::make_unique<btMultiBodyDynamicsWorld>(
          &dispatcher_, &broadphase_, static_cast<btMultiBodyConstraintSolver*>(solver_.get()),
          &configuration_);
    } else {
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
      world_ = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broadphase_, solver_.get(),
                                                         &configuration_);
    }
    world_->setGravity(btVector3(0, 0, -9.81));
  }
  ~BulletRunner() override {
    for (auto& c : constraints_) world_->removeConstraint(c.get());
    for (auto& b : bodies_) world_->removeRigidBody(b.get());
  }
  void step() override { world_->stepSimulation(kStep, 0); }
  double last_height() override { return bodies_.back()->getWorldTransform().getOrigin().z(); }

 protected:
  template <class Shape, class... Args>
  Shape* shape(Args&&... args) {
    auto made = std::make_unique<Shape>(std::forward<Args>(args)...);
    Shape* raw = made.get();
    raw->setMargin(1e-3);
    shapes_.push_back(std::move(made));
    return raw;
  }
  btRigidBody* body(btCollisionShape* form, double mass, const btTransform& pose, double friction,
                    const btVector3& inertia) {
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, form, inertia);
    info.m_startWorldTransform = pose;
    info.m_friction = friction;
    auto made = std::make_unique<btRigidBody>(info);
    made->setActivationState(DISABLE_DEACTIVATION);
    world_->addRigidBody(made.get());
    bodies_.push_back(std::move(made));
    return bodies_.back().get();
  }
  btRigidBody* body(btCollisionShape* form, double mass, const btTransform& pose, double friction) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) form->calculateLocalInertia(mass, inertia);
    return body(form, mass, pose, friction, inertia);
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  std::unique_ptr<btSequentialImpulseConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btTypedConstraint>> constraints_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

class Boxes final : public BulletRunner {
 public:
  Boxes() : BulletRunner(false) {
    using namespace boxes;
    auto* form = shape<btBoxShape>(half(kSize, 2 * kSize, 3 * kSize));
    for (int i = 0; i < kCount; ++i) {
      const btVector3 place((i % kPerRow) * kPitch, (i / kPerRow) * kPitch, 1000);
      body(form, kMass, btTransform(btQuaternion::getIdentity(), place), 0.5)
          ->setAngularVelocity(btVector3(0.1, kSpin, 0.1));
    }
  }
};

class Pyramid final : public BulletRunner {
 public:
  Pyramid() : BulletRunner(false) {
    using namespace pyramid;
    body(shape<btBoxShape>(half(100, 100, 2)), 0,
         btTransform(btQuaternion::getIdentity(), btVector3(0, 0, -1)), std::sqrt(kFriction));
    auto* form = shape<btBoxShape>(half(kSize, kSize, kSize));
    for (const Vec3& c : centres()) {
      body(form, kMass, btTransform(btQuaternion::getIdentity(), btVector3(c.x(), c.y(), c.z())),
           std::sqrt(kFriction));
    }
  }
};

class Robots final : public BulletRunner {
 public:
  Robots() : BulletRunner(false) {
    using namespace robots;
    body(shape<btStaticPlaneShape>(btVector3(0, 0, 1), 0), 0, btTransform::getIdentity(), 1);
    auto* chassis_form = shape<btCompoundShape>();
    auto* deck = shape<btBoxShape>(half(kChassisX, kChassisY, kChassisZ));
    const btTransform identity = btTransform::getIdentity();
    chassis_form->addChildShape(identity, deck);
    chassis_form->addChildShape(
        btTransform(btQuaternion::getIdentity(), btVector3(kCasterX, 0, kCasterRadius - kHeight)),
        shape<btSphereShape>(kCasterRadius));
    btVector3 inertia;
    deck->calculateLocalInertia(kChassisMass, inertia);
    auto* wheel_form =
        shape<btCylinderShapeZ>(btVector3(kWheelRadius, kWheelRadius, kWheelWidth / 2));
    const btQuaternion along_y(btVector3(1, 0, 0), -SIMD_HALF_PI);
    for (int i = 0; i < kPerSide * kPerSide; ++i) {
      const btVector3 place((i / kPerSide) * kSpacing, (i % kPerSide) * kSpacing, kHeight);
      btRigidBody* chassis = body(chassis_form, kChassisMass,
                                  btTransform(btQuaternion::getIdentity(), place), 0, inertia);
      for (const int side : {1, -1}) {
        const btVector3 offset(kAxleX, side * kHalfTrack, kWheelRadius - kHeight);
        btRigidBody* wheel =
            body(wheel_form, kWheelMass, btTransform(along_y, place + offset), kFriction);
        auto hinge = std::make_unique<btHingeConstraint>(
            *chassis, *wheel, btTransform(along_y, offset), identity, true);
        hinge->enableAngularMotor(true, side > 0 ? -kLeftSpeed : -kRightSpeed, kMaxTorque * kStep);
        world_->addConstraint(hinge.get(), true);
        constraints_.push_back(std::move(hinge));
      }
    }
  }
};

class Chain final : public BulletRunner {
 public:
  Chain() : BulletRunner(true) {
    using namespace chain;
    const double i_long = kMass * (kWidth * kWidth + kLength * kLength) / 12;
    const double i_axis = kMass * kWidth * kWidth / 6;
    chain_ = std::make_unique<btMultiBody>(kLinks, 0, btVector3(0, 0, 0), true, false);
    chain_->setBaseWorldTransform(btTransform::getIdentity());
    const btVector3 down(0, 0, -kLength / 2);
    for (int i = 0; i < kLinks; ++i) {
      chain_->setupRevolute(i, kMass, btVector3(i_long, i_long, i_axis), i - 1,
                            btQuaternion::getIdentity(), btVector3(0, 1, 0),
                            i == 0 ? btVector3(0, 0, 0) : down, down, true);
    }
    chain_->finalizeMultiDof();
    chain_->setLinearDamping(0);
    chain_->setAngularDamping(0);
    chain_->setJointPos(0, kTilt);
    chain_->setCanSleep(false);
    multibody_world()->addMultiBody(chain_.get());
  }
  ~Chain() override { multibody_world()->removeMultiBody(chain_.get()); }
  double last_height() override {
    return chain_->localPosToWorld(chain::kLinks - 1, btVector3(0, 0, 0)).z();
  }

 private:
  btMultiBodyDynamicsWorld* multibody_world() {
    return static_cast<btMultiBodyDynamicsWorld*>(world_.get());
  }
  std::unique_ptr<btMultiBody> chain_;
};

}  // namespace

std::unique_ptr<Runner> make_raw_bullet(Scene scene) {
  switch (scene) {
    case Scene::free_boxes:
      return std::make_unique<Boxes>();
    case Scene::pyramid:
      return std::make_unique<Pyramid>();
    case Scene::robots:
      return std::make_unique<Robots>();
    case Scene::chain:
      return std::make_unique<Chain>();
  }
  return nullptr;
}

}  // namespace cogrsim::bench
