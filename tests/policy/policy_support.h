// A robot with two joints, a network for it, and a card, in a folder of their own.
#pragma once

#include <fstream>
#include <random>
#include <string>

#include "../support/temporary_folder.h"
#include "onnx_writer.h"

namespace cogrsim::test {

inline constexpr const char* kRobot = R"(<scene name="arm" version="1">
  <physics step="2 ms"/>
  <plane name="floor"/>
  <assembly name="bot">
    <box name="trunk" size="40 40 20 cm" mass="5 kg" xyz="0 0 0.1"/>
    <box name="upper" size="4 4 20 cm" mass="0.5 kg" xyz="0 0 0.31"/>
    <box name="lower" size="4 4 20 cm" mass="0.3 kg" xyz="0 0 0.52"/>
    <hinge name="elbow" parent="trunk" child="upper" frame="trunk" xyz="0 0 0.1" axis="0 1 0" lower="-90 deg" upper="90 deg" damping="0.2 N*m*s/rad"/>
    <hinge name="wrist" parent="upper" child="lower" frame="upper" xyz="0 0 0.1" axis="1 0 0" lower="-90 deg" upper="90 deg" damping="0.2 N*m*s/rad"/>
    <motor name="first" joint="elbow" mode="torque" max-torque="20 N*m"/>
    <motor name="second" joint="wrist" mode="torque" max-torque="20 N*m"/>
  </assembly>
</scene>
)";

inline constexpr const char* kCard = R"(policy: 1
robot: arm.scene.xml
base: trunk
network: net.onnx
step: 2 ms
rate: 100 Hz
joints: [elbow, wrist]
default-pose: 0.1 -0.2 rad
observations:
  - base-linear-velocity: {frame: base, scale: 2}
  - base-angular-velocity: {frame: world}
  - projected-gravity
  - joint-positions: {scale: 0.5}
  - joint-velocities
  - last-action
  - command: {scale: [2, 2, 0.25]}
  - phase: {frequency: 1.25 Hz, offsets: 0.25, order: cos sin}
actions:
  {kind: position, scale: 0.5, offset: default, kp: 40, kd: 2}
command: 0.5 0 0.1
fallen: {height: 0.05 m, tilt: 30 deg}
)";

/// Two outputs of 20 inputs: w x.
inline std::vector<float> arm_weights() {
  std::mt19937 source(11);
  std::uniform_real_distribution<float> range(-0.05f, 0.05f);
  std::vector<float> out(2 * 20);
  for (float& v : out) v = range(source);
  return out;
}

inline std::string arm_network() {
  OnnxWriter writer;
  writer.input("obs", {1, 20}).output("actions", {1, 2}).constant("w", {2, 20}, arm_weights());
  return writer.node("Gemm", {"obs", "w"}, {"actions"}, {{"transB", 1}}).bytes();
}

class PolicyFolder {
 public:
  PolicyFolder() {
    write("arm.scene.xml", kRobot);
    write("net.onnx", arm_network());
    write("arm.policy.yaml", kCard);
  }
  std::string path(const std::string& name) const { return folder_ / name; }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace cogrsim::test
