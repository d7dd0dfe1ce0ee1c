// Signals: named quantities of a run, for figures, tests and tables. A signal such as
// `robot.chassis.speed` is evaluated on a frame of a running simulation or of a recording.
//
// | text                               | value                                     | unit        |
// |------------------------------------|-------------------------------------------|-------------|
// | time                               | time of the frame                         | s           |
// | POSE.x y z                         | position of the origin, in the world      | m           |
// | POSE.roll pitch yaw                | about the world x, y, z, in that order    | rad         |
// | POSE.vx vy vz, .speed              | velocity of the origin, world axes; norm  | m/s         |
// | POSE.wx wy wz, .spin               | angular velocity, world axes; norm        | rad/s       |
// | JOINT.position velocity effort     | with [i] from 0 if it has several axes    | by the axis |
// | MOTOR.effort                       | mean over the last step                   | N*m or N    |
// | SENSOR.CHANNEL, SENSOR[i]          | latest reading, by channel name or number | the channel |
// | energy.kinetic potential total     | see energy_of()                           | J           |
// | CONTROLLER.OUTPUT                  | output of a controller or supervisor      | the output  |
// | distance(OBJECT, OBJECT)           | between the surfaces, 0 if they touch     | m           |
// | origin_distance(POSE, POSE)        | between the two origins                   | m           |
// | mass(BODIES)                       | total mass                                | kg          |
// | contacts(BODIES), (BODIES, BODIES) | number of contact points                  | 1           |
// | force(BODIES), (BODIES, BODIES)    | norm of the sum of the contact forces     | N           |
// | inside(POSE, REGION)               | 1 if the origin is in the region, else 0  | 1           |
// | event(KIND[, SOURCE[, SUBJECT]])   | 1 in frames where it occurs, else 0       | 1           |
// | open(DOOR)                         | from 0 (closed) to 1 (open)               | 1           |
//
// POSE is a body, a named frame or an assembly; an assembly is represented by its base, which is
// the rigid body of the assembly or else its first body. BODIES is a body, or an assembly with all
// its bodies. OBJECT is BODIES, whose colliding shapes count, or a named frame, which is a point;
// meshes that are not convex and heightmaps are surfaces without an interior. Event in
// cogrsim/physics/frame.h describes KIND, SOURCE and SUBJECT.
//
// Signals can be added and subtracted (with blanks around + and -), multiplied and divided, with
// numbers, pi, brackets and the functions abs, sin, cos and exp:
// `bot.ir.distance - bot.ideal.distance`, `abs(bot.roll)`, `sin(2 rad/s * time)`. The terms of a sum
// must have the same dimension. A number may have a unit, `bot.x - 20 cm`; otherwise it
// has the unit of the other term.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim {

/// Returns the channels of a sensor by its index, or nullptr if they are unknown (for a plugin that
/// is not loaded). The pointer stays valid until the next call.
using ChannelLookup = std::function<const std::vector<Channel>*(int sensor)>;

/// Channels of the built-in sensors, which are known without a run. `model` must outlive the
/// lookup.
COGRSIM_API ChannelLookup built_in_channels(const SceneModel& model);

/// The names that a signal may refer to.
struct SignalScope {
  const SceneModel& model;
  ChannelLookup channels;  ///< empty: all channels are unknown
  /// Converts a name of the text to the dotted name in the model ("" if there is none), so that
  /// names can be relative to an element. Empty: names are those of the model.
  std::function<std::string(const std::string&)> resolve;
  /// Whether an element of this name (as in the text) may be added during the run. Its signals are
  /// then resolved by name in every model of the run, and are NaN while the element does not exist.
  /// Empty: a name that is not in the model is an error.
  std::function<bool(const std::string&)> may_come = {};
};

/// A quantity that has one value in every frame. Copies are cheap and share their data. Several
/// threads may evaluate a signal at the same time, but not while it is assigned.
class COGRSIM_API Signal {
 public:
  struct Node;  ///< node of the expression tree

  /// A signal that is NaN in every frame.
  Signal();
  explicit Signal(std::shared_ptr<const Node> node);

  /// Parses a signal. Errors: the grammar, or an unknown name, quantity or channel, with the most
  /// similar known one. A channel of a sensor with unknown channels is accepted and is NaN.
  static Result<Signal> parse(const SignalScope& scope, const std::string& text);

  /// The signal with the full names of the model: "robot.chassis.x", "distance(robot, wall)".
  const std::string& text() const;
  /// The unit as in the scene language: "m/s", "N*m"; "1" for a dimensionless number, "" if
  /// unknown.
  const std::string& unit() const;
  /// The quantity without the element: "x", "speed", "distance".
  const std::string& quantity() const;
  /// The frame contents that evaluate() needs.
  FrameContents needs() const;

  /// The value in a frame, in unit(). NaN if there is no value: no valid reading yet, or an element
  /// that does not exist (any more).
  double evaluate(const Frame& frame) const;

  /// A number that changes whenever the value may be new: with every step, and for a sensor with
  /// every reading. Statistics over readings must not count a reading twice.
  std::uint64_t revision(const Frame& frame) const;

 private:
  std::shared_ptr<const Node> node_;
};

}  // namespace cogrsim
