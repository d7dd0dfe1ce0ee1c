// What is at rest, and is not computed until something concerns it.
#pragma once

#include <vector>

#include "contacts.h"
#include "solver/partition.h"
#include "step_memory.h"

namespace cogrsim::dynamics {

/// All of it is part of a snapshot.
struct SleepState {
  std::vector<double> still;  ///< (ncomponent) for how long it has been at rest [s]
  Values start_q;             ///< coordinates when that began
  std::vector<int> group;     ///< (ncomponent) the first of those it sleeps with; -1: awake
  // Of what sleeps, as its last step left them:
  std::vector<WarmContact> contacts;
  std::vector<ContactRecord> records;
  EffortSums impulses;  ///< 0 of what is awake
  // When each was last another one:
  std::vector<Drive> drives;
  std::vector<Wrench> loads;  ///< (nlink)
};

/// Components that contact couples fall asleep together, where no coordinate of theirs left its place by
/// kInPlace for kStillTime, and wake together: by contact with what is awake or moved, a motor with
/// another command, another force, a body they hang on that is moved. A motor that is to turn and a surface
/// that moves keep them awake, as does having neither contact, nor a limit, nor a motor that holds: what
/// swings is slow at times. Each is compared with what it was when they were last disturbed.
class Sleep {
 public:
  static constexpr double kInPlace = 1e-4;   // [m], [rad]; of quaternions half of that
  static constexpr double kStillTime = 0.5;  // [s]

  Sleep(Mechanism& mechanism, Detector& detector);

  const SleepState& state() const { return state_; }
  void set_state(const SleepState& state);
  /// All is awake, and has been.
  void wake_all() { set_state(awake_); }

  /// Before a step: wakes what is disturbed; false: all sleeps, there is nothing to do.
  bool begin(const std::vector<Drive>& drives, StepMemory& memory);
  /// Wakes what something awake touches; whether there was any.
  bool wake_touched(const std::vector<Manifold>& manifolds, StepMemory& memory);
  /// After a step of `dt` [s]: puts to sleep what has been at rest.
  void end(double dt, const Contacts& contacts, Partition& partition, StepMemory& memory,
           const std::vector<ContactRecord>& records, const EffortSums& impulses);
  /// Contacts of all, in the order of the colliders.
  std::vector<WarmContact> all_contacts(const StepMemory& memory) const;

 private:
  void disturb(int component, StepMemory& memory);
  void wake(int group, StepMemory& memory);
  void put_to_sleep(StepMemory& memory, const std::vector<ContactRecord>& records,
                    const EffortSums& impulses);
  void mark(std::size_t component);
  bool is_kept_moving(std::size_t kinematic) const;
  bool sleeps(int collider) const;
  bool stays_in_place(const Component& component) const;
  void start_again(const Component& component);
  int component_of(int body) const;

  Mechanism& mechanism_;
  Detector& detector_;
  SleepState state_, awake_;
  std::vector<int> by_speed_, by_motor_;  ///< components of the model's joint speeds and motors
  struct Tie {
    int link = -1, component = -1;
  };
  std::vector<Tie> ties_;       ///< of components that joints hold on kinematic links
  std::vector<int> kinematic_;  ///< links
};

}  // namespace cogrsim::dynamics
