// A frame: the observable state of a simulation at one time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

struct Picture;

/// Description of one number of a sensor reading.
struct Channel {
  std::string name;   ///< "position"
  std::string unit;   ///< "rad"
  bool noisy = true;  ///< the noise terms of the scene apply to it
  int group = 0;      ///< the NoiseTerm::group of those terms
};
/// The channels of each sensor, indexed as SceneModel::sensors, in the order of Reading::values.
using SensorChannels = std::vector<std::shared_ptr<const std::vector<Channel>>>;

/// One measurement of a sensor. The meaning of the values depends on the type of the sensor, see
/// Sensor::channels(). A camera adds an image, a contact sensor the detected contacts.
struct Reading {
  int sensor = -1;             ///< index into SceneModel::sensors
  double time = 0.0;           ///< time of the measured frame [s]
  std::uint64_t sequence = 0;  ///< number of its delivered measurements; 0: none yet
  bool valid = false;          ///< false: no measurement yet, switched off, or dropped out
  std::vector<double> values;  ///< in the order and units of Sensor::channels()
  std::shared_ptr<const Picture> picture;  ///< of a camera, see cogrsim/rendering/renderer.h
  std::vector<Contact> contacts;           ///< of a contact sensor; body_b is the sensing body
  bool enabled = true;                     ///< the sensor is switched on
  /// Pose X_WS of the sensor in the measured frame, which is older than the frame with this reading;
  /// empty before the first measurement, and in recordings of version 0.2.0 and older.
  std::optional<Pose> pose;
};

/// The kind of element that a name in an event refers to.
enum class EventParty {
  none,
  name,  ///< a name that the event defines itself
  region,
  door,
  joint,
  thing,       ///< assembly or body
  posed,       ///< assembly, body or frame
  a_template,  ///< the template of an assembly
  controller,  ///< controller or supervisor
};

/// Description of one kind of event.
struct EventKind {
  const char* name;
  EventParty source = EventParty::none, subject = EventParty::none;
  bool last = false;  ///< the event ends the run, so that no rule can react to it
};

/// All kinds of events.
inline constexpr EventKind kEventKinds[] = {
    {"enter", EventParty::region, EventParty::posed},
    {"leave", EventParty::region, EventParty::posed},
    {"opening", EventParty::door},
    {"opened", EventParty::door},
    {"closing", EventParty::door},
    {"closed", EventParty::door},
    {"added", EventParty::thing, EventParty::a_template},
    {"removed", EventParty::thing},
    {"attached", EventParty::joint, EventParty::thing},  // the child body
    {"detached", EventParty::joint, EventParty::thing},
    {"made-static", EventParty::thing},
    {"made-dynamic", EventParty::thing},
    {"raised", EventParty::name},
    {"fault", EventParty::controller},
    {"refused"},
    {"restarted"},
    {"ended", EventParty::none, EventParty::none, true},
};

/// An event that occurred during the step, for example a fault of a controller or an added
/// assembly.
struct Event {
  double time = 0.0;    ///< [s]
  std::string kind;     ///< name of an entry of kEventKinds
  std::string source;   ///< dotted name of the element that caused the event
  std::string message;  ///< for the user
  std::string subject;  ///< dotted name of the affected element; "": none
};

/// The optional contents that a consumer needs in its frames in addition to the state.
struct FrameContents {
  bool contacts = false;
  bool joint_reactions = false;
  bool accelerations = false;
  /// Also the contents that the enabled sensors of the run need, so that readings can be recomputed
  /// from the frames.
  bool for_sensors = false;
};
/// The union of two requests.
COGRSIM_API FrameContents operator|(const FrameContents& a, const FrameContents& b);

/// Whether all that is wanted is there. `for_sensors` is not considered.
COGRSIM_API bool covers(const FrameContents& has, const FrameContents& wanted);

/// The observable state at one time. A published frame is immutable and may be read in any thread.
/// Optional contents that were not requested are empty, see `contents`.
struct Frame {
  SceneModelPtr model;
  std::uint64_t step = 0;  ///< number of steps since the start
  double time = 0.0;       ///< simulated time [s]
  double dt = 0.0;         ///< duration of the last step [s]; 0 at the start
  WorldState state;
  /// Which of the optional contents this frame has: an empty list of contacts means that there are
  /// none only with `contents.contacts`.
  FrameContents contents;
  /// Mean linear acceleration of the origin [m/s^2] and mean angular acceleration [rad/s^2] of
  /// every body over the last step, in world axes (nbody). They are differences of twists, defined
  /// in the same way for all engines.
  std::vector<Twist> accelerations;
  std::vector<Contact> contacts;
  std::vector<Wrench> joint_reactions;  ///< (njoint), see JointReactions
  std::vector<Reading> readings;        ///< latest measurement of every sensor (nsensor)
  /// Target of every motor that acted in the last step, as old as its delay, in its unit (nmotor);
  /// empty in older recordings.
  std::vector<double> motor_targets;
  std::shared_ptr<const SensorChannels> channels;  ///< of the readings; nullptr: unknown
  std::vector<Event> events;                       ///< of this step
  /// Latest values that the controllers published, in the order of their `outputs`; NaN: none yet.
  std::vector<std::vector<double>> controller_outputs;  ///< indexed as SceneModel::controllers
  std::vector<std::vector<double>> supervisor_outputs;  ///< indexed as SceneModel::supervisors
};
using FramePtr = std::shared_ptr<const Frame>;

/// Kinetic energy of the bodies, and potential energy of gravity (zero at the world origin) and of
/// the joint springs [J]. Computed from model and state, not by the engine.
struct Energy {
  double kinetic = 0.0;
  double potential = 0.0;
};
COGRSIM_API Energy energy_of(const SceneModel& model, const WorldState& state);

/// Linear momentum [kg m/s] and angular momentum about the world origin [kg m^2/s] of all dynamic
/// bodies, in world axes.
struct Momentum {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
};
COGRSIM_API Momentum momentum_of(const SceneModel& model, const WorldState& state);

/// FNV-1a hash of the bits of all poses, twists, joint positions and joint velocities. For all
/// practical purposes equal hashes mean equal states.
COGRSIM_API std::uint64_t state_hash(const WorldState& state);

}  // namespace cogrsim
