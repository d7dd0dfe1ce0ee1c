// Signals: numbers of a run by name, for figures, tests and tables. `robot.chassis.speed` is read
// from a frame, wherever the frame comes from: a run going on, or a recording.
//
// | text                                | value                                       | unit        |
// |-------------------------------------|---------------------------------------------|-------------|
// | time                                | of the frame                                | s           |
// | PLACE.x y z                         | of its origin, in the world                 | m           |
// | PLACE.roll pitch yaw                | about the world's x, y, z, in that order    | rad         |
// | PLACE.vx vy vz, .speed              | of its origin, world axes; their length     | m/s         |
// | PLACE.wx wy wz, .spin               | angular velocity, world axes; its length    | rad/s       |
// | JOINT.position velocity effort      | [i] where the joint has several, from 0     | by the axis |
// | MOTOR.effort                        | mean over the last step                     | N*m or N    |
// | SENSOR.CHANNEL, SENSOR[i]           | latest reading, by channel name or number   | the channel |
// | energy.kinetic potential total      | see energy_of()                             | J           |
// | MIND.OUTPUT                         | what a controller or supervisor publishes   | the output  |
// | distance(THING, THING)              | between the surfaces, 0 when they touch     | m           |
// | origin_distance(PLACE, PLACE)       | between the two origins                     | m           |
// | mass(BODIES)                        | sum of theirs                               | kg          |
// | contacts(BODIES), (BODIES, BODIES)  | points at which they touch (each other)     | 1           |
// | force(BODIES), (BODIES, BODIES)     | length of the sum of the contact forces     | N           |
//
// | inside(PLACE, REGION)               | 1: its origin is in the region, else 0      | 1           |
// | event(KIND[, SOURCE[, SUBJECT]])    | 1 in frames where it happens, else 0        | 1           |
// | open(DOOR)                          | from 0, closed, to 1, open                  | 1           |
//
// PLACE is a body, a named frame or an assembly, which stands for its base: the body it is, if it
// is rigid, else its first body. BODIES is a body, or an assembly with all that is in it. THING is
// BODIES, of which the shapes that collide count, or a named frame, which is a point; a mesh that is
// not convex and a heightmap count as surfaces without an inside. KIND of an event and what SOURCE
// and SUBJECT are: see Event in cogrsim/physics/frame.h.
//
// Signals are added and subtracted (with blanks around + and -), multiplied and divided, with numbers,
// brackets and abs(): `bot.ir.distance - bot.ideal.distance`, `abs(bot.roll)`. What is added must have
// the same dimension; numbers may have units, `bot.x - 20 cm`, and take the other's if they have none.
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

/// Channels of a sensor by index; nullptr: not known here (a plugin's, where no plugin is loaded).
/// The pointer stays valid until the next call.
using ChannelLookup = std::function<const std::vector<Channel>*(int sensor)>;

/// Channels of the SDK's own sensors, which need no run: made by configuring one. `model` must
/// outlive the lookup.
COGRSIM_API ChannelLookup built_in_channels(const SceneModel& model);

/// Where a signal's names are looked up.
struct SignalScope {
  const SceneModel& model;
  ChannelLookup channels;  ///< empty: as if no channel were known
  /// From a name as written to the dotted name in the model, "" for none; empty: names are the
  /// model's own. Lets names be relative to the element they stand in.
  std::function<std::string(const std::string&)> resolve;
  /// Whether something of this name (as written) may be added during the run. Its signals are then
  /// looked up by name in every model the run has, and are NaN as long as there is none.
  /// Empty: what is not in the model is an error.
  std::function<bool(const std::string&)> may_come = {};
};

/// One number of every frame. Copies are cheap and share what they are made of; from several
/// threads at once it may be evaluated, not assigned.
class COGRSIM_API Signal {
 public:
  struct Node;  ///< what a signal is made of; an operator is a node with others inside

  /// Is NaN everywhere.
  Signal();
  explicit Signal(std::shared_ptr<const Node> node);

  /// Errors: bad grammar; a name, quantity or channel that is not there, with the nearest that is.
  /// The channel of a sensor whose channels are not known is taken on trust and is NaN.
  static Result<Signal> parse(const SignalScope& scope, const std::string& text);

  /// With the model's names in full: "robot.chassis.x", "distance(robot, wall)".
  const std::string& text() const;
  /// As in the scene language: "m/s", "N*m"; "1" for a pure number, "" where it is not known.
  const std::string& unit() const;
  /// The quantity without its owner: "x", "speed", "distance".
  const std::string& quantity() const;
  /// What frames must contain for it.
  FrameContents needs() const;

  /// NaN where there is no value: no valid reading yet, an element that is not (or no longer)
  /// there.
  double evaluate(const Frame& frame) const;

  /// Changes whenever there may be a new value: with every step; of a sensor with every reading.
  /// Whoever does statistics over readings must not count one twice.
  std::uint64_t revision(const Frame& frame) const;

 private:
  std::shared_ptr<const Node> node_;
};

}  // namespace cogrsim
