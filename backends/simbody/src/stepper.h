// Advances a mechanism by one step.
#pragma once

#include <vector>

#include "accelerations.h"
#include "collision/detector.h"
#include "solver.h"

namespace cogrsim::simbody {

enum class Scheme { automatic, midpoint };

struct StepperOptions {
  Scheme scheme = Scheme::automatic;
  int substeps = 1;
  SolverOptions solver;
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
  double gap = 0.0;             ///< [m]
  Vec3 impulse = Vec3::Zero();  ///< on b, world [N s]
};

/// What a step takes from the one before, beside the state. All of it is part of a snapshot.
struct StepMemory {
  struct WarmContact {
    int collider_a = -1, collider_b = -1;
    Vec3 place = Vec3::Zero();  ///< of the point, in body b's frame
    Vec3 force = Vec3::Zero();  ///< on b, world [N]
  };
  std::vector<WarmContact> contacts;  ///< in the order of the colliders
  std::vector<double> efforts;        ///< see RowBuilder::slot_of; empty: none
  SimTK::Vector udot;                 ///< mean over the last step, impulses included
  bool had_rows = false;              ///< `udot` and the rest are worth something
  void clear();
};

class Stepper {
 public:
  Stepper(Mechanism& mechanism, Detector& detector, const StepperOptions& options);

  /// One step of `dt` [s]. Kinematic bodies move with `twists` (nbody, of their origins). Throws
  /// what Simbody throws; the state is then anywhere.
  void advance(double dt, const std::vector<Drive>& drives, const std::vector<Twist>& twists);

  StepMemory memory;
  EffortSums impulses;                 ///< of the last step: effort times time
  std::vector<ContactRecord> records;  ///< of the last step

 private:
  // What becomes of impacts that an articulated body takes part in. They change its configuration's
  // momentum map, so they are taken at their own instant: the step is split there.
  enum class Impacts { split, drop, keep };

  // Moves on by h, or, when splitting, through the first such impact; returns how far in time.
  double move(double h, Impacts impacts);
  // Start of the step is in q0_, u0_, qdot0_; with `have_first` k_[0] and the state hold two stages.
  void runge_kutta(double h, bool have_first);
  // Impulses of an instant, at the state as it is.
  void kick();
  void detect();
  // At the middle of the step. False when no row came out of it.
  bool build_rows(double h, Impacts impacts);
  // Time within the step; negative: none.
  double first_impact() const;
  void finish_with_rows(double h);

  void set(const SimTK::Vector& q, const SimTK::Vector& u);
  void sum_efforts(const SimTK::Vector& q, const SimTK::Vector& u, double weight);
  void measure_speeds(double h);
  void warm_start(double h);
  void remember(double h);
  // Adds the rows' impulses to `impulses` and `records`.
  void report();

  Mechanism& mechanism_;
  Detector& detector_;
  StepperOptions options_;
  const SceneModel& model_;
  Accelerations accelerations_;
  std::vector<AxisLaw> laws_;
  bool has_shapes_ = false;
  const std::vector<Drive>* drives_ = nullptr;
  std::vector<SurfacePair> surfaces_;  ///< (nmaterial x nmaterial)

  RowSet set_;
  std::vector<ContactPoint> points_;
  std::vector<double> margins_;  ///< (nlink)
  SimTK::Vector q0_, u0_, qdot0_, qm_, um_, start_udot_, udot_, k_[4], qk_[4], stage_,
      displaced_, end_u_;
  std::vector<double> dv_, displacement_;  ///< over all components
};

}  // namespace cogrsim::simbody
