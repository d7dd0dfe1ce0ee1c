// Advances a mechanism by one step.
#pragma once

#include <memory>
#include <vector>

#include "collision/detector.h"
#include "mechanism/accelerations.h"
#include "solver/solver.h"

namespace cogrsim::dynamics {

enum class Scheme { automatic, midpoint };

struct StepperOptions {
  Scheme scheme = Scheme::automatic;
  int substeps = 1;
  int threads = 1;
  SolverOptions solver;
  std::shared_ptr<WorkerPool> pool;  ///< of `threads`; none where that is 1
};

/// Sums of effort times time; one entry per speed and per motor of the model.
struct EffortSums {
  std::vector<double> joints;
  std::vector<double> motors;
};

/// Impulse of one contact point over the step. By colliders, see Detector.
struct ContactRecord {
  int collider_a = -1, collider_b = -1;
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();  ///< world
  double gap = 0.0;                                   ///< [m]
  Wrench impulse;                                     ///< on b, at the point, world [N s], [N m s]
};

/// What a step takes from the one before, beside the state. All of it is part of a snapshot.
struct StepMemory {
  struct WarmContact {
    int collider_a = -1, collider_b = -1;
    Vec3 point_B = Vec3::Zero();           ///< of the point, in body b's frame
    Wrench wrench;                         ///< on b, at the point, world
    Vec3 position_impulse = Vec3::Zero();  ///< multipliers of the position stage, likewise [N s^2]
  };
  std::vector<WarmContact> contacts;  ///< in the order of the colliders
  std::vector<double> efforts;        ///< see RowBuilder::slot_of; empty: none
  Values udot;       ///< what leads to the next middle of a step, impulses of contacts included
  Values mean_udot;  ///< over the last step, impulses included; empty: unknown
  bool had_rows = false;  ///< `udot` and the rest are valid
  void clear();
};

/// Momentum of an articulated component that no joint ties to the world.
struct FreeMomentum {
  int component = -1;
  double mass = 0.0;
  Vec3 com = Vec3::Zero();
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();      ///< about the world's origin
  Vec3 load = Vec3::Zero();         ///< weights and external forces [N]
  Vec3 load_moment = Vec3::Zero();  ///< about the world's origin [N m]
  Mat3 inertia = Mat3::Zero();      ///< of all together, about com
};

class Stepper {
 public:
  Stepper(Mechanism& mechanism, Detector& detector, const StepperOptions& options);

  /// One step of `dt` [s]. Kinematic bodies move with `twists` (nbody, of their origins). Throws
  /// where loops cannot be closed; the state is then undefined.
  void advance(double dt, const std::vector<Drive>& drives, const std::vector<Twist>& twists);

  StepMemory memory;
  EffortSums impulses;                 ///< of the last step: effort times time
  std::vector<ContactRecord> records;  ///< of the last step

 private:
  void move(double h);
  // The smooth motion, from q0_, u0_, qdot0_, to displaced_ and stage_; with `have_first`, k_[0],
  // udot_ and the state hold the first two stages. Sums the efforts in `untouched_` components.
  void runge_kutta(double h, bool have_first);
  // Whether the stages k_ of Runge-Kutta disagree for a component, as they do where its loops are too
  // near a singular position for accelerations to mean anything over the step; see loops.h.
  bool disagree(const Component& component, double h) const;
  // Takes the components marked in `doubtful_` by the midpoint scheme instead, from q0_, u0_,
  // qdot0_; the state is undefined afterwards. `efforts`: sums without those of the step.
  void pass_singular(double h, const EffortSums& efforts);
  // The motion with all rows, to displaced_ and stage_; the state is at the middle.
  void solve_rows(double h);
  // Where the bodies are at the middle of the step, of length h; a body that
  // would have moved by more than its own thickness is tested where it started: it may be beyond a
  // wall by then.
  void detect(double h);
  // Links that joints hold inside each other would have to move far for a small gap, and those that
  // joints keep from separating would get large displacements: each is limited to that of a free body.
  void limit_displacements(double h);
  double allowed_share(const Component& component, double h, double gained) const;
  // At the middle of the step. False when no row came out of it.
  bool build_rows(double h);
  // All of them at once on several threads; false: joints hold some of the bodies.
  bool add_free_contacts(const StepContext& context);
  void add_contact(const StepContext& context, std::size_t index, RowBuilder& builder) const;
  const SurfacePair& surface_of(const ContactPoint& point) const;
  // Rate of the velocity of b's surface against a's, along the normal and the tangents, at a point of points_,
  // that the speeds make as they are: J' u [m/s^2].
  Vec3 turning_of(std::size_t index, double h) const;
  // Of a link's point where it is now, while the mechanism's speeds stay.
  Vec3 convective_acceleration(int link, const Vec3& point) const;
  // Calls work(number, first, end) for chunks of contacts on all threads; none ends within a pair.
  // Returns their number, the same for any number of threads.
  static constexpr std::size_t kChunk = 128;
  template <class Work>
  std::size_t for_contact_chunks(const Work& work);
  // Whether points_ has a point there, of the same pair of colliders.
  bool same_pair(std::size_t index, std::size_t other) const;
  // The line, if any, that a point of points_ is an end of: of a cylinder or capsule on its side.
  RowBuilder::ContactLine find_contact_line(std::size_t index) const;
  // Conserves the momentum of free mechanisms to rounding, see README; the state is at the end.
  void conserve_momentum(double h);
  // `inertia`: computes that, too.
  void measure_momenta(bool inertia);

  void set(const Values& q, const Values& u);
  // Of the components whose mark in `untouched_` is `untouched`.
  void sum_efforts(const Values& q, const Values& u, double weight, bool untouched);
  void measure_speeds(double h);
  // From the order of the state to that over all components.
  void flatten(const Values& by_speed, std::vector<double>& out) const;
  Wrench impulse_of(const ContactRows& contact) const;  ///< on b, at the point
  Vec3 friction_impulse_of(const ContactRows& contact) const;
  // What the position stage found for a contact, its friction's only where that is of the point.
  Vec3 position_impulse_of(const ContactRows& contact) const;
  void warm_start(double h);
  void warm_start_contacts(double h, std::size_t first, std::size_t end);
  void share_warm_friction(std::size_t first, std::size_t end);
  // Distributes the load of a resting pair over its points: each yields a little to its load beyond the
  // mean of the last step. Without it rigid contact leaves the distribution to chance, and a wheel
  // rolls on one of its rims.
  void balance_pairs(double h, std::size_t first, std::size_t end);
  void remember(double h);
  void predict_udot(double h);
  struct ContactChunk;
  void remember_contact(double h, std::size_t index, ContactChunk& out) const;
  // Adds the rows' impulses to `impulses` and `records`.
  void report();

  Mechanism& mechanism_;
  Detector& detector_;
  StepperOptions options_;
  const SceneModel& model_;
  Accelerations accelerations_;
  Solver solver_;
  std::vector<AxisLaw> laws_;
  bool has_shapes_ = false;
  const std::vector<Drive>* drives_ = nullptr;
  std::vector<SurfacePair> surfaces_;  ///< (nmaterial x nmaterial)

  RowSet set_;
  std::vector<char> untouched_;  ///< (ncomponent): no row concerns it in this step
  std::vector<char> doubtful_;   ///< (ncomponent): see disagree()
  struct Gain {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  };
  std::vector<FreeMomentum> momenta_, start_momenta_;
  std::vector<Gain> gained_;  ///< (ncomponent)
  std::vector<Vec3> warm_;    ///< impulses to start from, by contact
  std::vector<char> taken_;   ///< (StepMemory::contacts): a contact starts from it
  /// What chunks of contacts leave, by chunk.
  struct ContactChunk {
    std::vector<StepMemory::WarmContact> contacts;
    std::vector<int> hits;  ///< rows
  };
  std::vector<ContactChunk> chunks_;
  std::vector<RowEnds> begins_;  ///< of the rows of each point
  std::vector<ContactPoint> points_;
  std::vector<double> margins_;  ///< (nlink)
  /// (nbody) from where a body is tested for contact to the middle [m]; empty: no body is fast.
  std::vector<Vec3> offsets_;
  Values q0_, u0_, qdot0_, qm_, um_, start_udot_, udot_, k_[4], qk_[4], stage_, displaced_, end_u_,
      mean_, smooth_q_, smooth_u_;
  std::vector<double> dv_, displacement_;             ///< over all components
  std::vector<double> row_u_, row_start_, row_udot_;  ///< likewise: what rows are made from
  std::vector<Wrench> contact_impulses_;              ///< on b, by contact
};

template <class Work>
std::size_t Stepper::for_contact_chunks(const Work& work) {
  const std::vector<ContactRows>& contacts = set_.contacts;
  const std::size_t count = (contacts.size() + kChunk - 1) / kChunk;
  // The first contact of a pair from `i` on.
  const auto begin_of = [&](std::size_t i) {
    const auto same = [&](const ContactPoint& a, const ContactPoint& b) {
      return a.collider_a == b.collider_a && a.collider_b == b.collider_b;
    };
    while (i > 0 && i < contacts.size() && same(contacts[i - 1].point, contacts[i].point)) ++i;
    return std::min(i, contacts.size());
  };
  const auto one = [&](std::size_t number) {
    work(number, begin_of(number * kChunk), begin_of((number + 1) * kChunk));
  };
  if (options_.pool && count > 1) {
    options_.pool->run(count, one);
  } else {
    for (std::size_t i = 0; i < count; ++i) one(i);
  }
  return count;
}

}  // namespace cogrsim::dynamics
