// Advances a mechanism by one step.
#pragma once

#include <memory>
#include <vector>

#include "mechanism/accelerations.h"
#include "sleep.h"

namespace cogrsim::dynamics {

enum class Scheme { automatic, midpoint };

struct StepperOptions {
  Scheme scheme = Scheme::automatic;
  int substeps = 1;
  int threads = 1;
  bool sleep = false;
  SolverOptions solver;
  std::shared_ptr<WorkerPool> pool;  ///< of `threads`; none where that is 1
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

  /// Nothing of the steps before counts, as where another state is set; all is awake.
  void forget() {
    memory.clear();
    sleep.wake_all();
  }

  StepMemory memory;
  Sleep sleep;
  EffortSums impulses;                 ///< of the last step: effort times time
  std::vector<ContactRecord> records;  ///< of the last step

 private:
  // One part of a step; where a whip is hit, its halves instead.
  void pass(double h, int halvings);
  // A mechanism of which a link turns far in a step, its kinetic energy, and the work of its loads in the step at these speeds [J].
  struct Whip {
    int component = -1;
    bool is_fast = false;
    double energy = 0.0, work = 0.0;
  };
  // h: of `parts` of the step.
  bool find_whips(double h, int parts);
  void measure_whip(double h, Whip& whip) const;
  bool must_be_halved(double h, const EffortSums& start) const;
  void move(double h);
  // The smooth motion, from q0_, u0_, qk_[0], to displaced_ and stage_; with `have_first`, k_[0],
  // udot_ and the state hold the first two stages. Sums the efforts in `untouched_` components.
  void runge_kutta(double h, bool have_first);
  // Whether the stages k_ of Runge-Kutta disagree for a component, as they do where its loops are too
  // near a singular position for accelerations to mean anything over the step; see loops.h.
  bool disagree(const Component& component, double h) const;
  // Takes the components marked in `doubtful_` by the midpoint scheme instead, from q0_, u0_,
  // qk_[0]; the state is undefined afterwards. `efforts`: sums without those of the step.
  void pass_singular(double h, const EffortSums& efforts);
  // The motion with all rows, to displaced_ and end_u_; the state is at the middle.
  void solve_rows(double h);
  // Links that joints hold inside each other would have to move far for a small gap, and those that
  // joints keep from separating would get large displacements: each is limited to that of a free body.
  void limit_displacements(double h, Island& island);
  double allowed_share(const Component& component, double h, double gained) const;
  // Those of joints, and which components anything concerns; false: none. At the middle of the step.
  bool build_rows(double h);
  // Impulses and displacements that make all rows hold, island by island: end_u_, the change of
  // the speeds until then, and displacement_.
  void solve_islands(double h);
  void solve_island(double h, std::size_t number, Island& island);
  // Conserves the momentum of free mechanisms to rounding, see README; the state is at the end.
  void conserve_momentum(double h);
  // `inertia`: computes that, too.
  void measure_momenta(bool inertia);

  // What contacts and motors of what sleeps do, as its last step left it.
  void add_sleeping();
  void set(const Values& q, const Values& u);
  // Of the components whose mark in `untouched_` is `untouched`.
  void sum_efforts(const Values& q, const Values& u, double weight, bool untouched);
  void warm_start_joints(double h);
  void remember(double h);
  void predict_udot(double h);
  // Adds the rows' impulses to `impulses` and `records`.
  void report();

  Mechanism& mechanism_;
  Contacts contacts_;
  StepperOptions options_;
  const SceneModel& model_;
  Accelerations accelerations_;
  std::vector<AxisLaw> laws_;
  const std::vector<Drive>* drives_ = nullptr;

  RowSet joints_;  ///< rows of joints
  StepContext context_;
  Partition partition_;
  std::vector<int> start_;  ///< (ncomponent): see Island::place_rows
  std::vector<Whip> whips_;
  bool has_mechanisms_ = false;  ///< some component is no free body
  std::vector<char> hit_;        ///< (ncomponent): by an impact in this step
  std::vector<char> untouched_;  ///< (ncomponent): no row concerns it in this step
  std::vector<char> doubtful_;   ///< (ncomponent): see disagree()
  struct Gain {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  };
  std::vector<FreeMomentum> momenta_, start_momenta_;
  std::vector<Gain> gained_;  ///< (ncomponent)
  Values q0_, u0_, udot_, k_[4], qk_[4], stage_, displaced_, end_u_, smooth_q_, smooth_u_,
      row_udot_;
  const Values* start_udot_ = nullptr;  ///< what led to the middle of the step
  Values
      displacement_;  ///< of the position stage, by speed; then, with the way at the speeds end_u_, of the second half
};

}  // namespace cogrsim::dynamics
