// What everyone reads: the world at one time.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

struct Picture;

/// One number of a reading.
struct Channel {
  std::string name;   ///< "position"
  std::string unit;   ///< "rad"
  bool noisy = true;  ///< the scene's noise terms apply to it
  int group = 0;      ///< which terms: those with this NoiseTerm::group
};
/// What each sensor reads, by SceneModel::sensors, in the order of Reading::values.
using SensorChannels = std::vector<std::shared_ptr<const std::vector<Channel>>>;

/// What a sensor saw, as numbers; what they mean is said by the sensor's type
/// (Sensor::channels()). Cameras add a picture, touch sensors the contacts they feel.
struct Reading {
  int sensor = -1;             ///< SceneModel::sensors
  double time = 0.0;           ///< of the frame that was read [s]
  std::uint64_t sequence = 0;  ///< readings of this sensor so far; 0: none yet
  bool valid = false;          ///< false: none yet, switched off, or dropped out
  std::vector<double> values;
  std::shared_ptr<const Picture> picture;  ///< of a camera, see cogrsim/rendering/renderer.h
  std::vector<Contact> contacts;  ///< of a contact sensor, turned so that body_b is what is felt
  bool enabled = true;            ///< the sensor is switched on
};

/// What a name in an event stands for.
enum class EventParty {
  none,
  name,  ///< of the event's own
  region,
  door,
  joint,
  thing,       ///< assembly or body
  place,       ///< assembly, body or frame
  a_template,  ///< what an assembly is made from
  controller,  ///< or supervisor
};

struct EventKind {
  const char* name;
  EventParty source = EventParty::none, subject = EventParty::none;
  bool last = false;  ///< the run is over with it: no rule can act on it
};

/// Every kind of event there is.
inline constexpr EventKind kEventKinds[] = {
    {"enter", EventParty::region, EventParty::place},
    {"leave", EventParty::region, EventParty::place},
    {"opening", EventParty::door},
    {"opened", EventParty::door},
    {"closing", EventParty::door},
    {"closed", EventParty::door},
    {"added", EventParty::thing, EventParty::a_template},
    {"removed", EventParty::thing},
    {"attached", EventParty::joint, EventParty::thing},  // the child body
    {"detached", EventParty::joint, EventParty::thing},
    {"frozen", EventParty::thing},  // made static
    {"freed", EventParty::thing},
    {"raised", EventParty::name},
    {"fault", EventParty::controller},
    {"refused"},
    {"restarted"},
    {"ended", EventParty::none, EventParty::none, true},
};

/// Something that happened during the step: a controller's fault, an added assembly.
struct Event {
  double time = 0.0;
  std::string kind;    ///< of kEventKinds
  std::string source;  ///< dotted name
  std::string message;
  std::string subject;  ///< dotted name of who or what took part; "" for none
};

/// Immutable once handed out. What nobody asked for is left empty: see FrameContents.
struct Frame {
  SceneModelPtr model;
  std::uint64_t step = 0;  ///< steps since the start
  double time = 0.0;       ///< [s]
  double dt = 0.0;         ///< length of the step that led here [s]; 0 at the start
  WorldState state;
  /// Mean acceleration of every body frame's origin and mean angular acceleration over the last
  /// step, world axes [m/s^2], [rad/s^2] (nbody): differences of twists, the same for any engine.
  std::vector<Twist> accelerations;
  std::vector<Contact> contacts;
  std::vector<Wrench> joint_reactions;             ///< see JointReactions
  std::vector<Reading> readings;                   ///< latest of every sensor (nsensor)
  std::shared_ptr<const SensorChannels> channels;  ///< of the readings; nullptr: not known
  std::vector<Event> events;                       ///< of this step
  /// What minds publish, latest values, in the order of their `outputs`; NaN: not yet.
  std::vector<std::vector<double>> controller_outputs;  ///< by SceneModel::controllers
  std::vector<std::vector<double>> supervisor_outputs;  ///< by SceneModel::supervisors
};
using FramePtr = std::shared_ptr<const Frame>;

/// What a consumer wants in its frames beside the state.
struct FrameContents {
  bool contacts = false;
  bool joint_reactions = false;
  bool accelerations = false;
  /// Also whatever the run's sensors read, as long as they are switched on: with it, readings can
  /// be computed again from the frames.
  bool for_sensors = false;
};
/// Contents of either.
COGRSIM_API FrameContents operator|(const FrameContents& a, const FrameContents& b);

/// Kinetic and potential energy [J]: bodies' motion; gravity with zero at the world's origin, and
/// the joints' springs. Formed from model and state, not by the engine.
struct Energy {
  double kinetic = 0.0;
  double potential = 0.0;
};
COGRSIM_API Energy energy_of(const SceneModel& model, const WorldState& state);

/// Linear momentum [kg m/s] and angular momentum about the world's origin [kg m^2/s] of all
/// dynamic bodies.
struct Momentum {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
};
COGRSIM_API Momentum momentum_of(const SceneModel& model, const WorldState& state);

/// FNV-1a over the bits of all poses, twists, joint positions and velocities: equal hashes mean
/// equal states for every practical purpose.
COGRSIM_API std::uint64_t state_hash(const WorldState& state);

}  // namespace cogrsim
