// The signals there are, by kind; parse.cpp finds out which one a text means.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/signals/signal.h"

namespace cogrsim {

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
SignalNode distance_term(std::string text, const SignalPlace& a, const SignalPlace& b);
/// Bodies by index, sorted; `b` empty: whatever they touch. `force`: else the number of points.
SignalNode contact_term(std::string text, std::vector<int> a, std::vector<int> b, bool force);

/// How many entries `quantity` of a joint has.
int joint_entries(const Joint& joint, int quantity);

}  // namespace cogrsim
