// One scene in ODE: its world, space, bodies, geoms and joints. Another is made when the scene
// changes.
#pragma once

#include <ode/ode.h>

#include <deque>
#include <memory>
#include <vector>

#include "body.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"
#include "geometry.h"
#include "joints.h"
#include "library.h"
#include "options.h"

namespace cogrsim::ode {

class Engine {
 public:
  /// The scene at its start, but for static bodies, which are where `poses` has them. Errors: a
  /// body, shape or joint that ODE does not take, with its source position. Throws EngineError.
  static Result<std::unique_ptr<Engine>> make(const SceneModelPtr& model,
                                              const std::vector<Pose>& poses, ShapeData& shapes);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  BodyLink& body(std::size_t b) { return bodies_[b]; }
  const BodyLink& body(std::size_t b) const { return bodies_[b]; }
  std::deque<JointLink>& joints() { return joints_; }
  const std::deque<JointLink>& joints() const { return joints_; }

  /// ODE's step: looks for contacts and solves. Throws EngineError and std::bad_alloc, after which
  /// only the destructor may be called.
  void step(double h, unsigned long& seed);

  /// dWorldQuickStep, else dWorldStep.
  bool is_iterative() const { return quick_; }

  /// Contacts of the last step.
  void report(std::vector<Contact>& out) const;
  void forget_contacts() { touched_ = 0; }

  /// Geoms in the order in which ODE's space goes through them, which decides the order of contacts
  /// and with it the last digits. (ngeom)
  std::vector<int> order() const;
  void set_order(const std::vector<int>& order);

 private:
  /// A contact joint of the last step.
  struct Touch {
    Vec3 point, normal;  ///< ODE's: into the first body
    double depth = 0.0;
    const Geom *first = nullptr, *second = nullptr;
    dJointFeedback feedback{};
  };

  Engine(const SceneModelPtr& model, const Parameters& options);
  void add_body(std::size_t b);
  Result<> add_geoms(std::size_t b, const Pose& pose, ShapeData& shapes);
  void add_surfaces();
  static void near(void* self, dGeomID a, dGeomID b);
  void near(const Geom& a, const Geom& b);
  static void set_motion(dContact& contact, const Geom& a, const Geom& b);
  void soften(dSurfaceParameters& surface, std::size_t pair, const Geom& a, const Geom& b) const;
  Touch& touch(std::size_t i) const { return touches_[i / kBlock][i % kBlock]; }

  SceneModelPtr model_;
  const Parameters options_;
  bool quick_ = false;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  dThreadingImplementationID threading_ = nullptr;
  bool broken_off_ = false;  ///< an exception left a step
  std::vector<BodyLink> bodies_;
  std::vector<std::pair<dBodyID, Vec3>> lifts_;  ///< to weights other than the world's [N]
  std::deque<Geom> geoms_;
  std::deque<JointLink> joints_;
  CollisionFilter filter_;
  std::vector<dSurfaceParameters> surfaces_;  ///< of two materials (nmaterial x nmaterial)
  std::vector<double> stiffness_, damping_;  ///< likewise [N/m]; 0: none; ratio to the critical one
  double h_ = 0.0;                           ///< of the present step
  static constexpr std::size_t kBlock = 64;  // in blocks, as ODE keeps pointers to the feedbacks
  std::vector<std::unique_ptr<Touch[]>> touches_;
  std::size_t touched_ = 0;
};

}  // namespace cogrsim::ode
