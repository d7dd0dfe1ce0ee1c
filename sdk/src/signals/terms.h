// All kinds of signals; parse.cpp selects the one that a text denotes.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/signals/signal.h"

namespace cogrsim {

namespace geometry {
class SurfaceSet;  // geometry/surface_distance.h
}

/// A frame that is fixed to a body: the body frame itself, or a named frame.
struct SignalPose {
  int body = kWorld;
  Pose X_BF;
};

/// Quantities of a pose: x y z roll pitch yaw vx vy vz speed wx wy wz spin.
inline constexpr std::array<const char*, 14> kPoseQuantities = {
    "x", "y", "z", "roll", "pitch", "yaw", "vx", "vy", "vz", "speed", "wx", "wy", "wz", "spin"};
inline constexpr std::array<const char*, 3> kJointQuantities = {"position", "velocity", "effort"};
inline constexpr std::array<const char*, 3> kEnergyQuantities = {"kinetic", "potential", "total"};

using SignalNode = std::shared_ptr<const Signal::Node>;

const char* pose_unit(int quantity);
SignalNode time_term();
/// `quantity` is an index into kPoseQuantities; `text` is the whole signal.
SignalNode pose_term(std::string text, const SignalPose& pose, int quantity);
/// `quantity` is an index into kJointQuantities.
SignalNode joint_term(std::string text, const Joint& joint, int index, int quantity, int entry);
/// `target`: the one that acted; else the effort.
SignalNode motor_term(std::string text, const SceneModel& model, int index, bool target);
/// `channel` -1: unknown, always NaN.
SignalNode sensor_term(std::string text, int index, int channel, std::string name,
                       std::string unit);
SignalNode energy_term(int quantity);
/// Distance between two origins.
SignalNode origin_distance_term(std::string text, const SignalPose& a, const SignalPose& b);
/// Distance between the surfaces of two objects.
SignalNode surface_distance_term(std::string text, geometry::SurfaceSet a, geometry::SurfaceSet b);
/// Total mass of the bodies with these indices.
SignalNode mass_term(std::string text, std::vector<int> bodies);
/// Whether an origin is inside a region (1 or 0). Precondition: `region` belongs to the model.
SignalNode inside_term(std::string text, const SignalPose& pose, int region);
/// Whether an event occurs (1 or 0); an empty name matches any.
SignalNode event_term(std::string text, std::string kind, std::string source, std::string subject);
/// Opening of a door, from 0 (closed) to 1 (open).
SignalNode open_term(std::string text, int door);
/// Output of a controller or supervisor, resolved by name in the model of the frame.
SignalNode controller_term(std::string text, bool supervisor, int controller, std::string output,
                           std::string unit);
/// Contacts of the bodies `a` with the bodies `b`, or with all other bodies if `b` is empty; both
/// are sorted indices. The value is the norm of the force if `force` is set, else the number of
/// points.
SignalNode contact_term(std::string text, std::vector<int> a, std::vector<int> b, bool force);

/// Number of entries of the `quantity` of a joint.
int joint_entries(const Joint& joint, int quantity);

}  // namespace cogrsim
