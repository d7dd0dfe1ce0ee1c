// The signals there are, by kind; parse.cpp finds out which one a text means.
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

/// A point and axes that move with a body: a body itself, a named frame.
struct SignalPlace {
  int body = kWorld;
  Pose X_BF;
};

/// Quantities of a place: x y z roll pitch yaw vx vy vz speed wx wy wz spin.
inline constexpr std::array<const char*, 14> kPlaceQuantities = {
    "x", "y", "z", "roll", "pitch", "yaw", "vx", "vy", "vz", "speed", "wx", "wy", "wz", "spin"};
inline constexpr std::array<const char*, 3> kJointQuantities = {"position", "velocity", "effort"};
inline constexpr std::array<const char*, 3> kEnergyQuantities = {"kinetic", "potential", "total"};

using SignalNode = std::shared_ptr<const Signal::Node>;

const char* place_unit(int quantity);
SignalNode time_term();
/// `quantity` is an index into kPlaceQuantities; `text` the whole signal.
SignalNode place_term(std::string text, const SignalPlace& place, int quantity);
/// `quantity` is an index into kJointQuantities.
SignalNode joint_term(std::string text, const Joint& joint, int index, int quantity, int entry);
SignalNode motor_term(std::string text, const SceneModel& model, int index);
/// `channel` -1: not known, always NaN.
SignalNode sensor_term(std::string text, int index, int channel, std::string name,
                       std::string unit);
SignalNode energy_term(int quantity);
/// Between two points.
SignalNode origin_distance_term(std::string text, const SignalPlace& a, const SignalPlace& b);
/// Between two surfaces.
SignalNode surface_distance_term(std::string text, geometry::SurfaceSet a, geometry::SurfaceSet b);
/// Bodies by index.
SignalNode mass_term(std::string text, std::vector<int> bodies);
/// 1 or 0. Precondition: `region` is one of the model's.
SignalNode inside_term(std::string text, const SignalPlace& place, int region);
/// 1 or 0; empty: any.
SignalNode event_term(std::string text, std::string kind, std::string source, std::string subject);
/// Of a door, 0 closed to 1 open.
SignalNode open_term(std::string text, int door);
/// Output of a controller or supervisor, looked up by name in the frame's model.
SignalNode mind_term(std::string text, bool supervisor, int mind, std::string output,
                     std::string unit);
/// Bodies by index, sorted; `b` empty: whatever they touch. `force`: else the number of points.
SignalNode contact_term(std::string text, std::vector<int> a, std::vector<int> b, bool force);

/// How many entries `quantity` of a joint has.
int joint_entries(const Joint& joint, int quantity);

}  // namespace cogrsim
