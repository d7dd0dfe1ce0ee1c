#include "build/start.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::dsl {
namespace {

// Rounding of a few products of poses in a scene some hundred metres wide stays well below.
constexpr double kGap = 1e-6;       // [m]
constexpr double kTurn = 1e-6;      // [rad]
constexpr double kSpeedGap = 1e-6;  // [m/s], [rad/s]

bool yields(const SceneModel& model, int body) {
  return body != kWorld && model.bodies[body].kind == BodyKind::dynamic;
}

class Start {
 public:
  Start(SceneModel& model, const StartHints& hints) : model_(model), hints_(hints) {}

  std::vector<StartProblem> settle() {
    collect();
    order_tree();
    for (const Edge& edge : order_) place(edge);
    for (const Edge& edge : order_) move(edge);
    for (std::size_t j = 0; j < model_.joints.size(); ++j)
      if (model_.joints[j].closes_loop) check_loop(static_cast<int>(j));
    std::stable_sort(problems_.begin(), problems_.end(),
                     [](const auto& a, const auto& b) { return a.joint < b.joint; });
    return std::move(problems_);
  }

 private:
  // A joint of the tree, walked from the side that is already placed.
  struct Edge {
    int joint;
    bool forward;  // from parent to child
    bool held;     // the root of the tree is static or kinematic
  };

  const Pose& pose(int body) const {
    static const Pose kIdentity;
    return body == kWorld ? kIdentity : model_.bodies[body].X_WB;
  }
  Twist twist(int body) const { return body == kWorld ? Twist{} : model_.bodies[body].V_WB; }

  // Joints of the tree around each dynamic body.
  void collect() {
    const std::size_t n = model_.bodies.size();
    start_.assign(n + 1, 0);
    for_tree([&](int, int body) { ++start_[body + 1]; });
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    around_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for_tree([&](int joint, int body) { around_[next[body]++] = joint; });
  }

  template <class Use>
  void for_tree(Use use) const {
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (joint.closes_loop) continue;
      if (yields(model_, joint.parent)) use(static_cast<int>(j), joint.parent);
      if (yields(model_, joint.child)) use(static_cast<int>(j), joint.child);
    }
  }

  void order_tree() {
    std::vector<char> is_child(model_.bodies.size(), 0), placed(model_.bodies.size(), 0);
    std::vector<char> walked(model_.joints.size(), 0);
    std::vector<int> open;
    const auto spread = [&](bool held) {
      for (std::size_t k = 0; k < open.size(); ++k) {
        const int body = open[k];
        for (std::size_t i = start_[body]; i < start_[body + 1]; ++i) {
          const int j = around_[i];
          if (walked[j] != 0) continue;
          walked[j] = 1;
          const Joint& joint = model_.joints[j];
          const bool forward = joint.parent == open[k];
          const int other = forward ? joint.child : joint.parent;
          order_.push_back({j, forward, held});
          placed[other] = 1;
          open.push_back(other);
        }
      }
      open.clear();
    };
    // Trees rooted in the world, or in a kinematic body.
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (joint.closes_loop) continue;
      is_child[joint.child] = 1;
      const bool parent_yields = yields(model_, joint.parent);
      const bool child_yields = yields(model_, joint.child);
      if (parent_yields == child_yields) continue;
      const int other = parent_yields ? joint.parent : joint.child;
      walked[j] = 1;
      // The freedom of a free joint is that of a body without one.
      order_.push_back({static_cast<int>(j), child_yields, joint.type != JointType::free});
      placed[other] = 1;
      open.push_back(other);
      spread(joint.type != JointType::free);
    }
    // Free trees.
    for (std::size_t b = 0; b < model_.bodies.size(); ++b)
      if (placed[b] == 0 && is_child[b] == 0 && start_[b] != start_[b + 1]) {
        placed[b] = 1;
        open.push_back(static_cast<int>(b));
        spread(false);
      }
  }

  void place(const Edge& edge) {
    Joint& joint = model_.joints[edge.joint];
    const int from = edge.forward ? joint.parent : joint.child;
    const int to = edge.forward ? joint.child : joint.parent;
    if (moved_.empty()) moved_.assign(model_.bodies.size(), 0);
    const bool from_moved = yields(model_, from) && moved_[from] != 0;
    const bool turned = hints_.joint_position[edge.joint] != 0;
    if (!from_moved && !turned) return;  // as written, to the last bit
    const Pose X_FM = turned ? joint_pose(joint, joint.position.data()) : Pose{};
    Pose& X_W_to = model_.bodies[to].X_WB;
    X_W_to = edge.forward ? pose(from) * joint.X_PF * X_FM * joint.X_CM.inverse()
                          : pose(from) * joint.X_CM * X_FM.inverse() * joint.X_PF.inverse();
    moved_[to] = 1;
  }

  void move(const Edge& edge) {
    Joint& joint = model_.joints[edge.joint];
    const int from = edge.forward ? joint.parent : joint.child;
    const int to = edge.forward ? joint.child : joint.parent;
    if (joint.position.empty()) joint.position = rest_position(joint.type);
    if (joint.velocity.empty()) joint.velocity.assign(speed_count(joint.type), 0.0);
    const TwistSource source = hints_.body_twist[to];
    // An assembly's twist reaches its bodies through their joints; a body joined to the world
    // cannot get it from there, so for that body it counts as its own.
    const bool own =
        source == TwistSource::itself || (source == TwistSource::assembly && edge.held);
    const bool driven = hints_.joint_velocity[edge.joint] != 0;
    if (own) {
      read_velocity(edge.joint, driven);
      return;
    }
    if (joint.type == JointType::free && !driven) {
      read_velocity(edge.joint, false);
      return;
    }
    follow(joint, from, to, edge.forward);
  }

  // Twist of `to` so that the joint runs at its speeds.
  void follow(const Joint& joint, int from, int to, bool forward) {
    const Pose X_WF = pose(joint.parent) * joint.X_PF;
    const Pose X_WM = pose(joint.child) * joint.X_CM;
    const Twist V_FM = joint_twist(joint, joint.position.data(), joint.velocity.data());
    const double sign = forward ? 1.0 : -1.0;
    const Twist V_W_from = twist(from);
    Twist at_M;  // of `to`, in world axes, at M's origin
    at_M.linear = V_W_from.at(X_WM.p - pose(from).p) + sign * (X_WF.q * V_FM.linear);
    at_M.angular = V_W_from.angular + sign * (X_WF.q * V_FM.angular);
    Twist& V_W_to = model_.bodies[to].V_WB;
    V_W_to.angular = at_M.angular;
    V_W_to.linear = at_M.at(pose(to).p - X_WM.p);
  }

  // Speeds of a joint from the twists of its bodies; reports what the joint does not allow.
  void read_velocity(int j, bool driven) {
    Joint& joint = model_.joints[j];
    const Pose X_FM = relative_pose(joint, pose(joint.parent), pose(joint.child));
    const Twist V_FM = relative_twist(joint, pose(joint.parent), twist(joint.parent),
                                      pose(joint.child), twist(joint.child));
    std::vector<double> u(speed_count(joint.type), 0.0);
    if (!u.empty()) joint_velocity(joint, X_FM, V_FM, joint.position.data(), u.data());
    if (driven) u = joint.velocity;
    const Twist allowed = joint_twist(joint, joint.position.data(), u.data());
    const double linear = (V_FM.linear - allowed.linear).norm();
    const double angular = (V_FM.angular - allowed.angular).norm();
    joint.velocity = u;
    if (linear > kSpeedGap || angular > kSpeedGap)
      problems_.push_back({StartProblem::Kind::velocity, j, linear, angular});
  }

  void check_loop(int j) {
    Joint& joint = model_.joints[j];
    const Pose X_FM = relative_pose(joint, pose(joint.parent), pose(joint.child));
    const bool given = hints_.joint_position[j] != 0;
    std::vector<double> q(position_count(joint.type), 0.0);
    if (!q.empty()) joint_position(joint, X_FM, given ? joint.position.data() : nullptr, q.data());
    const Pose X_FM_here = joint_pose(joint, q.data());
    const double gap = (X_FM.p - X_FM_here.p).norm();
    const double turn = X_FM.q.angularDistance(X_FM_here.q);
    if (gap > kGap || turn > kTurn) {
      problems_.push_back({StartProblem::Kind::gap, j, gap, turn});
      if (joint.position.empty()) joint.position = rest_position(joint.type);
      return;
    }
    if (given) {
      const Pose X_FM_said = joint_pose(joint, joint.position.data());
      const double off = (X_FM.p - X_FM_said.p).norm();
      const double off_turn = X_FM.q.angularDistance(X_FM_said.q);
      if (off > kGap || off_turn > kTurn) {
        problems_.push_back({StartProblem::Kind::position, j, off, off_turn});
        return;
      }
    }
    joint.position = q;
    read_velocity(j, hints_.joint_velocity[j] != 0);
  }

  static std::vector<double> rest_position(JointType type) {
    std::vector<double> q(position_count(type), 0.0);
    if (type == JointType::ball) q[0] = 1.0;
    if (type == JointType::free) q[3] = 1.0;
    return q;
  }

  SceneModel& model_;
  const StartHints& hints_;
  std::vector<std::size_t> start_;  // (nbody + 1) into around_
  std::vector<int> around_;
  std::vector<Edge> order_;
  std::vector<char> moved_;
  std::vector<StartProblem> problems_;
};

}  // namespace

std::vector<StartProblem> settle_start(SceneModel& model, const StartHints& hints) {
  return Start(model, hints).settle();
}

}  // namespace cogrsim::dsl
