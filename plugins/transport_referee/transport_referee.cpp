// The grippers of two robots that carry boxes, and the evaluation of their work. See README.md.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/control/supervisor.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/signals/signal.h"

namespace transport_referee {
namespace {

using cogrsim::Frame;
using cogrsim::kNaN;
using cogrsim::SceneModel;
using cogrsim::SupervisorContext;

template <class Type>
Type parameter(const SupervisorContext& context, const std::string& name) {
  return std::get<Type>(*context.parameter(name));
}

struct Robot {
  std::string name;
  std::string fork;   ///< body to which boxes are attached
  std::string joint;  ///< name of the joint with which a box is attached
  std::size_t controller = 0, output = 0;
  bool wants = false;  ///< grip requested at the last update
  int carries = -1;    ///< index of the attached body; -1: none
};

class TransportReferee final : public cogrsim::Supervisor {
 public:
  cogrsim::FrameContents needs() const override {
    cogrsim::FrameContents contents;
    contents.contacts = true;
    return contents;
  }
  void configure(SupervisorContext& context) override;
  void update(const cogrsim::Tick& tick, SupervisorContext& context) override;

 private:
  Robot find_robot(const SceneModel& model, const std::string& name, const std::string& fork) const;
  void watch_model(const cogrsim::SceneModelPtr& model);
  void work_hands(const Frame& frame, SupervisorContext& context, Robot& robot);
  void count_collisions(const Frame& frame);
  int count_delivered(const Frame& frame) const;
  void publish(const Frame& frame, SupervisorContext& context);

  std::array<Robot, 2> robots_;
  std::string boxes_name_;
  cogrsim::RegionModel zone_;
  cogrsim::Signal gap_;
  double reach_ = 0.02;
  bool end_run_ = true;

  cogrsim::SceneModelPtr model_;
  std::vector<int> boxes_;   // bodies
  std::vector<char> owner_;  // of every body: 0, 1 a robot, -1 neither
  int delivered_ = 0, collisions_ = 0;
  bool started_ = false, touching_ = false, ending_ = false;
  double nearest_ = std::numeric_limits<double>::infinity();
  double done_at_ = kNaN;
};

Robot TransportReferee::find_robot(const SceneModel& model, const std::string& name,
                                   const std::string& fork) const {
  const int assembly = cogrsim::find_assembly(model, name);
  if (assembly < 0) throw std::runtime_error("there is no assembly '" + name + "'");
  Robot robot;
  robot.name = name;
  robot.fork = name + "." + fork;
  robot.joint = name + ".held";
  if (cogrsim::find_body(model, robot.fork) < 0) {
    throw std::runtime_error("there is no body '" + robot.fork + "' to hold boxes with");
  }
  for (std::size_t i = 0; i < model.controllers.size(); ++i) {
    const auto& controller = model.controllers[i];
    if (controller.assembly != assembly) continue;
    for (std::size_t k = 0; k < controller.outputs.size(); ++k) {
      if (controller.outputs[k].name != "grip") continue;
      robot.controller = i;
      robot.output = k;
      return robot;
    }
  }
  throw std::runtime_error("no controller of '" + name + "' publishes an output 'grip'");
}

void TransportReferee::configure(SupervisorContext& context) {
  const SceneModel& model = *context.frame().model;
  std::istringstream names(parameter<std::string>(context, "robots"));
  std::string first, second, more;
  if (!(names >> first >> second) || names >> more || first == second) {
    throw std::runtime_error("'robots': expected the names of two assemblies");
  }
  const auto fork = parameter<std::string>(context, "fork");
  robots_ = {find_robot(model, first, fork), find_robot(model, second, fork)};
  boxes_name_ = parameter<std::string>(context, "boxes");
  const auto zone = parameter<std::string>(context, "zone");
  const auto region = std::find_if(model.regions.begin(), model.regions.end(),
                                   [&](const auto& r) { return r.name == zone; });
  if (region == model.regions.end()) {
    throw std::runtime_error("there is no region '" + zone + "'");
  }
  if (region->type != cogrsim::RegionModel::Type::box || region->body != cogrsim::kWorld) {
    throw std::runtime_error("region '" + zone + "' is not a static box");
  }
  zone_ = *region;
  auto gap = cogrsim::Signal::parse({model, {}, {}}, "distance(" + first + ", " + second + ")");
  if (!gap) throw std::runtime_error(gap.error().text());
  gap_ = *gap;
  reach_ = parameter<double>(context, "reach");
  end_run_ = parameter<bool>(context, "end_run");
  watch_model(context.frame().model);
  if (boxes_.empty()) throw std::runtime_error("no body is named '" + boxes_name_ + ".…'");
  publish(context.frame(), context);
}

void TransportReferee::watch_model(const cogrsim::SceneModelPtr& model) {
  if (model == model_) return;
  model_ = model;
  boxes_.clear();
  // A scatter is not an assembly: its elements are identified by the prefix of their names.
  for (std::size_t i = 0; i < model->bodies.size(); ++i) {
    const auto& body = model->bodies[i];
    if (!body.removed && body.name.rfind(boxes_name_ + ".", 0) == 0) {
      boxes_.push_back(static_cast<int>(i));
    }
  }
  owner_.assign(model->bodies.size(), -1);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    const int assembly = cogrsim::find_assembly(*model, robot.name);
    if (assembly < 0) throw std::runtime_error("'" + robot.name + "' was removed");
    for (const int body : cogrsim::bodies_of(*model, assembly)) {
      owner_[body] = static_cast<char>(i);
    }
    // A held box counts as part of the robot.
    const int joint = cogrsim::find_joint(*model, robot.joint);
    robot.carries = joint < 0 ? -1 : model->joints[joint].child;
    if (robot.carries >= 0) owner_[robot.carries] = static_cast<char>(i);
  }
}

// Attaches and detaches boxes according to the output of the robot's controller.
void TransportReferee::work_hands(const Frame& frame, SupervisorContext& context, Robot& robot) {
  const double grip = frame.controller_outputs[robot.controller][robot.output];
  const bool wants = grip > 0.5;
  if (wants == robot.wants) return;
  robot.wants = wants;
  if (!wants) {
    if (robot.carries >= 0) context.send(cogrsim::Detach{robot.joint});
    return;
  }
  const auto& poses = frame.state.poses;
  const cogrsim::Vec3 hand = poses[cogrsim::find_body(*model_, robot.fork)].p;
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const int box : boxes_) {
    const double away = (poses[box].p - hand).norm();
    if (owner_[box] < 0 && away < least) nearest = box, least = away;
  }
  if (nearest < 0) return;
  cogrsim::Attach attach;
  attach.name = robot.joint;
  attach.parent = robot.fork;
  attach.child = model_->bodies[nearest].name;
  attach.reach = reach_;
  context.send(attach);
}

void TransportReferee::count_collisions(const Frame& frame) {
  const auto owner = [&](int body) { return body < 0 ? -1 : static_cast<int>(owner_[body]); };
  const bool touching =
      std::any_of(frame.contacts.begin(), frame.contacts.end(), [&](const cogrsim::Contact& c) {
        const int a = owner(c.body_a), b = owner(c.body_b);
        return a >= 0 && b >= 0 && a != b && (c.depth >= 0.0 || c.force.norm() > 0.0);
      });
  if (touching && !touching_) ++collisions_;
  touching_ = touching;
}

int TransportReferee::count_delivered(const Frame& frame) const {
  return static_cast<int>(std::count_if(boxes_.begin(), boxes_.end(), [&](int box) {
    if (owner_[box] >= 0) return false;  // still held
    const cogrsim::Vec3 p = zone_.X_BR.inverse() * frame.state.poses[box].p;
    return (p.cwiseAbs().array() <= 0.5 * zone_.size.array()).all();
  }));
}

void TransportReferee::publish(const Frame& frame, SupervisorContext& context) {
  const double gap = gap_.evaluate(frame);
  if (gap < nearest_) nearest_ = gap;
  const bool done = delivered_ == static_cast<int>(boxes_.size());
  if (done && !(done_at_ <= frame.time)) {
    done_at_ = frame.time;
    context.report("all boxes are delivered");
  }
  context.publish("delivered", delivered_);
  context.publish("left", static_cast<double>(boxes_.size()) - delivered_);
  context.publish("collisions", collisions_);
  context.publish("gap", gap);
  context.publish("nearest", nearest_);
  context.publish("time", done_at_);
  context.publish("success", done && collisions_ == 0 ? 1.0 : 0.0);
}

void TransportReferee::update(const cogrsim::Tick&, SupervisorContext& context) {
  if (ending_) {
    // The result was published in the frame before.
    context.send(cogrsim::EndRun{"all boxes are delivered"});
    return;
  }
  const Frame& frame = context.frame();
  watch_model(frame.model);
  if (!started_) {
    // A run that is resumed from a snapshot may start with a held box.
    for (Robot& robot : robots_) robot.wants = robot.carries >= 0;
    started_ = true;
  }
  for (Robot& robot : robots_) work_hands(frame, context, robot);
  count_collisions(frame);
  delivered_ = count_delivered(frame);
  publish(frame, context);
  ending_ = end_run_ && done_at_ <= frame.time;
}

}  // namespace
}  // namespace transport_referee

COGRSIM_SUPERVISOR(
    transport_referee::TransportReferee, "transport_referee", version("1.0.0"), author("CogRSim"),
    summary("attaches boxes to two robots on request, and evaluates the transport"),
    parameter("robots", "", "the two assemblies, with a blank in between").must_be_set(),
    parameter("boxes", "boxes", "scatter or assembly that contains all boxes"),
    parameter("zone", "zone", "target region of the boxes, a static box"),
    parameter("fork", "fork", "body of each robot to which boxes are attached"),
    parameter("reach", 0.02, "m", "largest distance from the fork at which a box is attached")
        .range(0.0, 1.0),
    parameter("end_run", true, "the run ends when all boxes are delivered"),
    output("delivered", "1", "number of boxes in the zone that are not held"),
    output("left", "1", "number of other boxes"),
    output("collisions", "1", "number of contacts between the robots, including held boxes"),
    output("gap", "m", "distance between the surfaces of the robots"),
    output("nearest", "m", "smallest gap so far"),
    output("time", "s", "time at which all were delivered"),
    output("success", "1", "1 if all are delivered without a collision"))
