// Boxes on bare Simbody with the contact it has for them: triangle meshes as elastic foundations
// (its ContactMesh recipe), an error-controlled integrator.
#include <Simbody.h>

#include <cmath>

#include "engine_program.h"

namespace {

using namespace cogrsim::bench;
using SimTK::MobilizedBody;
using SimTK::Rotation;
using SimTK::Transform;
using STVec3 = SimTK::Vec3;

STVec3 vector(const Triple& v) { return {v[0], v[1], v[2]}; }
Triple triple(const STVec3& v) { return {v[0], v[1], v[2]}; }

class MeshRunner final : public Runner {
 public:
  explicit MeshRunner(const Scene& scene)
      : scene_(scene), gravity_(forces_, matter_, vector(scene.gravity)) {
    forces_.setNumberOfThreads(1);
    contact_.setTransitionVelocity(1e-2);
    for (const Thing& thing : scene_.things) add(thing);
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Thing& thing = scene_.things[i];
      if (thing.mass == 0) continue;
      const Turn& q = thing.turn;
      bodies_[i].setQToFitTransform(
          state_,
          Transform(Rotation(SimTK::Quaternion(q[0], q[1], q[2], q[3])), vector(thing.place)));
    }
    integrator_.setAccuracy(1e-3);
  }
  void step(double dt) override {
    if (!started_) {
      integrator_.setMaximumStepSize(dt);
      integrator_.initialize(state_);
      started_ = true;
    }
    time_ += dt;
    while (integrator_.getTime() < time_ - 1e-12) integrator_.stepTo(time_);
  }
  void get_states(std::vector<ThingState>& states) override {
    const SimTK::State& state = started_ ? integrator_.getState() : state_;
    system_.realize(state, SimTK::Stage::Velocity);
    for (std::size_t i = 0; i < states.size(); ++i) {
      states[i].place = triple(bodies_[i].getBodyOriginLocation(state));
    }
  }

 private:
  void add(const Thing& thing) {
    constexpr double kStiffness = 1e7, kDissipation = 1.0;  // [Pa/m], [s/m]
    const double mu = thing.friction;
    const SimTK::ContactMaterial material(kStiffness, kDissipation, mu, mu, 0);
    if (thing.mass == 0) {
      // A half-space is solid towards its own +x.
      matter_.Ground().updBody().addContactSurface(
          Transform(Rotation(SimTK::Pi / 2, SimTK::YAxis), STVec3(0)),
          SimTK::ContactSurface(SimTK::ContactGeometry::HalfSpace(), material));
      bodies_.push_back(matter_.Ground());
      return;
    }
    const STVec3 half = vector(thing.parts.front().size) / 2;
    const SimTK::ContactGeometry::TriangleMesh mesh(SimTK::PolygonalMesh::createBrickMesh(half, 5));
    SimTK::Body::Rigid body(
        SimTK::MassProperties(thing.mass, STVec3(0), SimTK::Inertia(vector(thing.moments))));
    body.addContactSurface(Transform(), SimTK::ContactSurface(mesh, material, 0.05));
    bodies_.push_back(MobilizedBody::Free(matter_.Ground(), Transform(), body, Transform()));
  }

  const Scene scene_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::ContactTrackerSubsystem tracker_{system_};
  SimTK::CompliantContactSubsystem contact_{system_, tracker_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::Force::UniformGravity gravity_;
  std::vector<MobilizedBody> bodies_;
  SimTK::State state_;
  SimTK::RungeKuttaMersonIntegrator integrator_{system_};
  double time_ = 0;
  bool started_ = false;
};

class SimbodyMesh final : public EngineProgram {
 public:
  std::string name() const override { return "raw-simbody-mesh"; }
  std::string version() const override {
    int major = 0, minor = 0, build = 0;
    SimTK_version_simbody(&major, &minor, &build);
    return std::to_string(major) + "." + std::to_string(minor);
  }
  std::string settings() const override {
    return "boxes as triangle meshes on elastic foundations of 1e7 Pa/m; Runge-Kutta-Merson, "
           "accuracy 1e-3";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    if (scene.name != "stack") throw Unsupported("measured on the stack of boxes alone");
    return std::make_unique<MeshRunner>(scene);
  }
};

}  // namespace

int main(int argc, char** argv) {
  SimbodyMesh simbody;
  return engine_main(argc, argv, simbody);
}
