// Contact as a force that is a function of the state: for engines that integrate forces and have no
// contact of their own between shapes of all kinds.
#pragma once

#include <vector>

#include "collision/detector.h"

#include "cogrsim/physics/state.h"

namespace cogrsim::dynamics {

/// Hunt and Crossley's dissipation c [s/m] of a linear spring, f = k x (1 + c xdot), from which a body
/// that comes with `speed` [m/s] leaves with `restitution` of it. Restitutions below 0.04 count as
/// 0.04, c = 25 s/m at 1 m/s: overlap is taken back at 1 / c at most.
double dissipation_of(double restitution, double speed);

struct CompliantLaw {
  double stiffness = 0.0;     ///< of a point where the material has none [N/m]; 0: by frequency
  double frequency = 400.0;   ///< of the pair's reduced mass on one point [rad/s]
  double dissipation = 0.0;   ///< c [s/m]; 0: what gives the restitution at impact_speed
  double impact_speed = 1.0;  ///< [m/s]
  double transition_velocity = 0.01;  ///< v_t [m/s], and as much [rad/s] of spin
};

/// Normal force of Hunt and Crossley, f = k x (1 + c xdot) >= 0, x the depth. Friction of Hollars,
/// mu f min(v / v_t, 1) against the slip v; rolling and spinning friction likewise. Points are found
/// again in each evaluation.
class CompliantContact {
 public:
  /// `still` has the poses of static bodies.
  CompliantContact(const SceneModel& model, const CompliantLaw& law,
                   const std::vector<Pose>& still);

  bool has_shapes(int body) const { return detector_.bounding_radius(body) > 0.0; }
  /// A body's place and motion, world, about its origin.
  void set_body(int body, const Placement& X, const Twist& V);
  void find();
  /// What touches, with the forces.
  const std::vector<Contact>& contacts() const { return contacts_; }
  /// Of a contact's rolling and spinning friction on body_b, world [N m].
  const Vec3& torque(std::size_t contact) const { return torques_[contact]; }
  const Vec3& place(int body) const { return motions_[std::size_t(body)].p; }

 private:
  struct Motion {
    Vec3 p = Vec3::Zero();
    Twist V;
  };
  struct Surface {
    double mu = 0.0, rolling = 0.0, spinning = 0.0, c = 0.0, k = 0.0;
    bool known = false;
  };

  const Surface& surface(int material_a, int material_b);
  double stiffness(const Surface& surface, int body_a, int body_b) const;
  void push(const ContactPoint& point);

  const SceneModel& model_;
  const CompliantLaw law_;
  Detector detector_;
  std::vector<ContactPoint> points_;
  std::vector<Motion> motions_;  ///< by body
  std::vector<Contact> contacts_;
  std::vector<Vec3> torques_;      ///< by contact
  std::vector<Surface> surfaces_;  ///< nmaterial x nmaterial
};

/// Contacts of a step that an integrator takes in several of its own: means by the trapezoidal rule.
/// Points of one pair of shapes that are nearer to each other than 2 cm are the same.
class ContactMeans {
 public:
  void start(const std::vector<Contact>& now) { last_ = now, sums_.clear(); }
  void add(const std::vector<Contact>& now, double h);
  std::vector<Contact> get(double dt) const;

 private:
  std::vector<Contact> last_;  ///< forces [N]
  std::vector<Contact> sums_;  ///< impulses [N s], in the order of bodies and shapes
};

}  // namespace cogrsim::dynamics
