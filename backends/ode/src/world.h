// A running world on ODE.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "body_state.h"
#include "collider.h"
#include "engine.h"
#include "joint_rows.h"
#include "rows.h"

#include "cogrsim/physics/world.h"

namespace cogrsim::ode {

const ParameterTable& world_option_table();

class OdeWorld final : public World, public JointReactions, public KinematicDrive {
 public:
  static Result<std::unique_ptr<World>> create(const SceneModelPtr& model);
  ~OdeWorld() override = default;

  const SceneModelPtr& model() const override { return model_; }
  double time() const override { return time_; }
  StepResult step(double dt, const std::vector<Drive>& drives) override;
  void get_state(WorldState& out) const override;
  Result<> set_state(const WorldState& state) override;
  void get_contacts(std::vector<Contact>& out) const override { out = contacts_; }
  Result<> add(const SceneModelPtr& next) override;
  Result<> remove(const SceneModelPtr& next) override;
  Result<> change(const SceneModelPtr& next) override;
  SnapshotPtr save() const override;
  Result<> restore(const SnapshotPtr& snapshot) override;
  Result<> reset() override;
  void* extension(std::string_view id) override;
  void get_joint_reactions(std::vector<Wrench>& out) const override { out = reactions_; }
  Result<> set_kinematic_twist(int body, const Twist& twist) override;

 private:
  struct Snapshot;
  /// A contact point while it is solved.
  struct Point {
    TouchPoint touch;
    Rows::Touch row;
    int handle = -1;
    double friction = 0.0;      ///< coefficient
    double vn = 0.0;            ///< speed of separation in the free motion [m/s]
    double cap = -1.0;          ///< bound by the load found last [N]
    double aside = 1.0;         ///< part of it that holds across `along`
    Vec3 along = Vec3::Zero();  ///< direction of the friction found last
  };

  OdeWorld() = default;
  /// From the scene's own start; everything that was is gone, unless it fails.
  Result<> build(const SceneModelPtr& model, const std::vector<BodyState>* bodies = nullptr);
  /// Makes ODE's bodies those of the model.
  void make_bodies();
  void adopt(const SceneModelPtr& next);
  void place_trees(const WorldState& state);
  void place_across(const Joint& joint, bool forward, const WorldState& state);
  /// Joints that are there all of a sudden take away at once what they forbid.
  void join(const std::vector<int>& sudden);

  /// `row_bodies_` as the bodies are, none of them to be solved for.
  void begin_rows();
  void begin_joints(double h, const std::vector<Drive>& drives);
  void predict(double h);
  void find_touches(double h);
  void mark_solved(const TouchPoint& touch);
  void find_loops();
  void find_islands();
  double softness_of(const Joint& joint) const;
  bool enable(int kind);
  void solve(double h);
  bool bound_friction();
  void put_bodies(double h);
  void ask_rows(double h);
  void move(double h);
  int find_wild() const;
  int find_diverged() const;
  void report(double h);

  RowBody& row_body(int body) {
    return body == kWorld ? ground_ : row_bodies_[static_cast<std::size_t>(body)];
  }
  Pose pose_of(int body) const {
    return body == kWorld ? Pose() : bodies_[static_cast<std::size_t>(body)].pose();
  }
  Twist twist_of(int body) const {
    return body == kWorld ? Twist() : bodies_[static_cast<std::size_t>(body)].twist();
  }
  Pose end_of(int body) const {
    return body == kWorld ? Pose() : ends_[static_cast<std::size_t>(body)];
  }

  SceneModelPtr initial_, model_;
  double time_ = 0.0;
  std::string solver_ = "auto";
  int iterations_ = 100;

  std::unique_ptr<Engine> engine_;
  std::vector<dBodyID> ids_;  ///< null: not moved by forces
  std::unique_ptr<Collider> collider_;
  std::optional<Rows> rows_;

  // State, complete with what was reported last.
  std::vector<BodyState> bodies_;
  std::vector<double> q_;
  std::vector<double> last_u_;  ///< speeds of joints when one was removed last
  std::vector<double> joint_efforts_, motor_efforts_;
  std::vector<Wrench> reactions_;
  std::vector<Contact> contacts_;

  // Of one step.
  std::vector<BodyState> before_;  ///< in case it fails
  RowBody ground_;
  std::vector<RowBody> row_bodies_;  ///< with the speeds of free motion
  std::vector<Vec3> momentum_;       ///< angular, before the rows
  std::vector<Pose> ends_;           ///< where free motion would lead
  std::vector<char> solved_;         ///< 0: it flies; 1, 2: ODE moves it, exactly or by sweeps
  std::vector<int> island_;          ///< by body, another of its island or itself
  std::vector<int> island_rows_;     ///< by body that stands for its island
  int largest_ = 0;                  ///< rows of the largest island that is solved exactly
  std::vector<char> in_loop_;        ///< by body
  std::vector<JointStep> joints_;
  std::vector<std::vector<int>> motors_of_;  ///< by joint
  std::vector<TouchPoint> touches_;
  std::vector<Point> points_;
  std::vector<Wrench> loads_;  ///< known efforts, about the centres of mass
};

}  // namespace cogrsim::ode
