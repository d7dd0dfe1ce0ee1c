// The benchmark scenes on bare ODE, the way its manual does it.
#include <ode/ode.h>

#include <algorithm>
#include <cmath>

#include "engine_program.h"

namespace {

using namespace cogrsim::bench;

class OdeRunner final : public Runner {
 public:
  explicit OdeRunner(const Scene& scene) : scene_(scene) {
    dInitODE2(0);
    world_ = dWorldCreate();
    space_ = dHashSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    for (std::size_t i = 0; i < scene_.things.size(); ++i) add(i);
    for (const Hinge& hinge : scene_.hinges) add(hinge);
    exact_ = !scene_.hinges.empty();
    if (!scene_.eyes.empty()) {
      ray_ = dCreateRay(nullptr, scene_.eye_range);
      dGeomRaySetClosestHit(ray_, 1);
    }
  }
  ~OdeRunner() override {
    if (ray_) dGeomDestroy(ray_);
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    dCloseODE();
  }
  void step(double dt) override {
    if (!scene_.eyes.empty() && steps_++ % scene_.eye_period == 0) look();
    if (scene_.contact) dSpaceCollide(space_, this, &touch);
    if (exact_) {
      dWorldStep(world_, dt);
    } else {
      dWorldQuickStep(world_, dt);
    }
    dJointGroupEmpty(contacts_);
  }
  void get_states(std::vector<ThingState>& states) override {
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (!bodies_[i]) {
        states[i] = {scene_.things[i].place, scene_.things[i].turn};
        continue;
      }
      const dReal* p = dBodyGetPosition(bodies_[i]);
      const dReal* q = dBodyGetQuaternion(bodies_[i]);
      states[i] = {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
    }
  }
  double seen() override { return seen_; }

 private:
  const Thing& thing_of(dGeomID geom) const {
    return scene_.things[reinterpret_cast<std::size_t>(dGeomGetData(geom))];
  }

  static void touch(void* data, dGeomID a, dGeomID b) {
    static_cast<OdeRunner*>(data)->touch(a, b);
  }
  void touch(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (!body_a && !body_b) return;
    const Thing &thing_a = thing_of(a), &thing_b = thing_of(b);
    if (thing_a.family >= 0 && thing_a.family == thing_b.family) return;
    constexpr int kMost = 32;
    constexpr double kBounceThreshold = 0.05;  // [m/s]
    dContact contacts[kMost];
    const int count = dCollide(a, b, kMost, &contacts[0].geom, sizeof(dContact));
    const double bounce = std::max(thing_a.restitution, thing_b.restitution);
    for (int i = 0; i < count; ++i) {
      dSurfaceParameters& surface = contacts[i].surface;
      surface.mode = dContactApprox1;  // the friction's bound follows the load
      surface.mu = std::sqrt(thing_a.friction * thing_b.friction);
      if (bounce > 0) {
        surface.mode |= dContactBounce;
        surface.bounce = bounce;
        surface.bounce_vel = kBounceThreshold;
      }
      dJointAttach(dJointCreateContact(world_, contacts_, &contacts[i]), body_a, body_b);
    }
  }

  struct Sight {
    dGeomID ray;
    dBodyID self;
    dReal nearest;
  };
  static void see(void* data, dGeomID a, dGeomID b) {
    auto& sight = *static_cast<Sight*>(data);
    const dGeomID other = a == sight.ray ? b : a;
    if (dGeomGetBody(other) == sight.self) return;
    dContactGeom hit;
    if (dCollide(sight.ray, other, 1, &hit, sizeof hit) > 0 && hit.depth < sight.nearest) {
      sight.nearest = hit.depth;
    }
  }
  void look() {
    seen_ = 0;
    for (const Eye& eye : scene_.eyes) {
      const dBodyID body = bodies_[eye.thing];
      dVector3 from, along;
      dBodyGetRelPointPos(body, eye.at[0], eye.at[1], eye.at[2], from);
      dBodyVectorToWorld(body, eye.along[0], eye.along[1], eye.along[2], along);
      dGeomRaySet(ray_, from[0], from[1], from[2], along[0], along[1], along[2]);
      Sight sight{ray_, body, scene_.eye_range};
      dSpaceCollide2(ray_, reinterpret_cast<dGeomID>(space_), &sight, &see);
      seen_ += sight.nearest;
    }
  }

  dGeomID geom(const Part& part) {
    switch (part.form) {
      case Form::box:
        return dCreateBox(space_, part.size[0], part.size[1], part.size[2]);
      case Form::sphere:
        return dCreateSphere(space_, part.size[0]);
      case Form::cylinder:
        return dCreateCylinder(space_, part.size[0], part.size[1]);
      case Form::capsule:
        return dCreateCapsule(space_, part.size[0], part.size[1]);
      case Form::plane:
        return dCreatePlane(space_, 0, 0, 1, 0);
    }
    return nullptr;
  }

  void add(std::size_t index) {
    const Thing& thing = scene_.things[index];
    const dQuaternion turn = {thing.turn[0], thing.turn[1], thing.turn[2], thing.turn[3]};
    dBodyID body = nullptr;
    if (thing.mass > 0) {
      body = dBodyCreate(world_);
      dMass mass;
      dMassSetParameters(&mass, thing.mass, 0, 0, 0, thing.moments[0], thing.moments[1],
                         thing.moments[2], 0, 0, 0);
      dBodySetMass(body, &mass);
      dBodySetPosition(body, thing.place[0], thing.place[1], thing.place[2]);
      dBodySetQuaternion(body, turn);
      dBodySetLinearVel(body, thing.velocity[0], thing.velocity[1], thing.velocity[2]);
      dBodySetAngularVel(body, thing.spin[0], thing.spin[1], thing.spin[2]);
    }
    for (const Part& part : thing.parts) {
      const dGeomID made = geom(part);
      dGeomSetData(made, reinterpret_cast<void*>(index));
      if (body) {
        dGeomSetBody(made, body);
        if (part.at != Triple{}) {
          dGeomSetOffsetPosition(made, part.at[0], part.at[1], part.at[2]);
        }
      } else if (part.form != Form::plane) {
        dGeomSetPosition(made, thing.place[0], thing.place[1], thing.place[2]);
        dGeomSetQuaternion(made, turn);
      }
    }
    bodies_.push_back(body);
  }

  void add(const Hinge& hinge) {
    const dJointID joint = dJointCreateHinge(world_, nullptr);
    dJointAttach(joint, bodies_[hinge.child], hinge.parent < 0 ? nullptr : bodies_[hinge.parent]);
    dJointSetHingeAnchor(joint, hinge.anchor[0], hinge.anchor[1], hinge.anchor[2]);
    dJointSetHingeAxis(joint, hinge.axis[0], hinge.axis[1], hinge.axis[2]);
    if (!hinge.driven) return;
    dJointSetHingeParam(joint, dParamVel, hinge.speed);
    dJointSetHingeParam(joint, dParamFMax, hinge.max_torque);
  }

  const Scene scene_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  dGeomID ray_ = nullptr;
  std::vector<dBodyID> bodies_;
  bool exact_ = false;
  double seen_ = 0;
  int steps_ = 0;
};

class Ode final : public EngineProgram {
 public:
  std::string name() const override { return "raw-ode"; }
  std::string version() const override { return COGRSIM_ODE_VERSION; }
  std::string settings() const override {
    return "double precision; QuickStep with 20 iterations for free bodies, dWorldStep (exact LCP) "
           "where there are hinges; friction pyramid that follows the load";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    return std::make_unique<OdeRunner>(scene);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Ode ode;
  return engine_main(argc, argv, ode);
}
