// One scene in ODE: its world, space, bodies, geoms and joints. Another is made when the scene
// changes.
#pragma once

#include <ode/ode.h>

#include <deque>
#include <memory>
#include <vector>

#include "body.h"
#include "cogrsim/physics/surface_table.h"
#include "geometry.h"
#include "joints.h"

namespace cogrsim::ode {

class Engine final : public SceneEngine {
 public:
  static constexpr const char *kName = "ode", *kTitle = "ODE";
  static constexpr bool kLacksCouplings = true;
  static constexpr StateBounds kBounds = ode::kBounds;
  /// By ODE's own names and with its own defaults.
  static const ParameterTable& options();

  /// The scene at its start, but for static bodies, which are where `begin` has them. Errors: a body,
  /// shape or joint that ODE does not take, with its source position.
  static Result<std::unique_ptr<Engine>> make(const SceneModelPtr& model, const Parameters& options,
                                              const WorldState& begin, const Engine* old);
  void take_over(const Engine& old, const WorldState& begin, const SceneChange& change);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// ODE's step of what is a number: it would end in an assertion otherwise.
  void step(const StepInput& input);
  int find_lost() const;
  /// What ODE was broken off in is lost: save() has the start of the step.
  bool undo();

  Pose pose(int body) const { return bodies_[body].pose(); }
  Twist twist(int body) const { return bodies_[body].twist(); }
  double fastest_spin() const;
  void write(const WorldState& state);
  void move_kinematic(int body, const Twist& twist) { bodies_[body].set_twist(twist); }
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  void read_reactions(std::vector<Wrench>& out) const;
  void read_contacts(std::vector<Contact>& out) const;
  std::shared_ptr<const HostedMemory> save() const;
  void restore(const HostedMemory& memory);
  /// Rotors that the sweeps of dWorldQuickStep do not hold.
  std::vector<Diagnostic> warnings() const;

 private:
  struct Memory;
  /// A contact joint of the last step.
  struct Touch {
    Vec3 point, normal;  ///< ODE's: into the first body
    double depth = 0.0;
    const Geom *first = nullptr, *second = nullptr;
    dJointFeedback feedback{};
  };

  Engine(const SceneModelPtr& model, const Parameters& options, const Engine* old);
  void add_body(std::size_t b);
  void add_joint(std::size_t j, const std::vector<Pose>& poses);
  Result<> add_geoms(std::size_t b, const Pose& pose);
  std::vector<Motion> motions() const;
  void set_motions(const std::vector<Motion>& motions);
  static void near(void* self, dGeomID a, dGeomID b);
  void near(const Geom& a, const Geom& b);
  static void set_motion(dContact& contact, const Geom& a, const Geom& b);
  /// Of a contact in a step of h_.
  dSurfaceParameters surface(const Geom& a, const Geom& b) const;
  Touch& touch(std::size_t i) const { return touches_[i / kBlock][i % kBlock]; }

  SceneModelPtr model_;
  const Parameters options_;
  bool quick_ = false;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  dThreadingImplementationID threading_ = nullptr;
  bool broken_off_ = false;  ///< an exception left a step
  bool undone_ = false;      ///< what counts is before_
  unsigned long seed_ = 0;
  std::vector<Motion> before_;  ///< the last step
  std::shared_ptr<ShapeData> shapes_;
  std::vector<BodyLink> bodies_;
  std::vector<std::pair<dBodyID, Vec3>> lifts_;  ///< to weights other than the world's [N]
  std::deque<Geom> geoms_;
  std::deque<JointLink> joints_;
  CollisionFilter filter_;
  SurfaceTable surfaces_;
  bool pyramid_ = true;
  double h_ = 0.0;                           ///< of the last step, 0: none
  static constexpr std::size_t kBlock = 64;  // in blocks, as ODE keeps pointers to the feedbacks
  std::vector<std::unique_ptr<Touch[]>> touches_;
  std::size_t touched_ = 0;
};

}  // namespace cogrsim::ode
