// A model in MJCF that MuJoCo runs from its file, beside its import on the mujoco backend.
#include "../support/temporary_folder.h"
#include "original_run.h"

#include <catch2/catch.hpp>

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

// A trunk on two legs and a slider as a tail, whose feet are on the ground in the keyframe
// "crouch", far from where the model is drawn.
const char* const kModel = R"(<mujoco model="strider">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.002"/>
  <default>
    <geom friction="0.8 0.005 0.0001"/>
    <default class="leg">
      <joint axis="0 1 0" damping="0.3" armature="0.012" frictionloss="0.15"/>
      <position kp="60" forcerange="-25 25"/>
      <geom type="capsule" size="0.02"/>
    </default>
    <default class="foot"><geom type="sphere" size="0.03" mass="0.05"/></default>
  </default>
  <worldbody>
    <geom name="ground" type="plane" size="5 5 0.1"/>
    <body name="trunk" pos="0 0 0.62">
      <freejoint name="root"/>
      <inertial pos="0.02 -0.01 0.03" mass="4" diaginertia="0.03 0.05 0.06"/>
      <geom type="box" size="0.15 0.08 0.05"/>
      <body name="left_thigh" pos="0 0.1 0" childclass="leg">
        <inertial pos="0 0 -0.14" quat="0.99 0.1 0 0.1" mass="0.9" diaginertia="0.007 0.006 0.001"/>
        <joint name="left_hip" range="-1.6 1.2"/>
        <geom fromto="0 0 0 0 0 -0.28"/>
        <body name="left_shank" pos="0 0 -0.3">
          <inertial pos="0 0 -0.13" mass="0.4" diaginertia="0.003 0.003 0.0004"/>
          <joint name="left_knee" range="0 2.4" damping="0.5"/>
          <geom fromto="0 0 0 0 0 -0.25"/>
          <geom name="left_foot" class="foot" pos="0.01 0 -0.28"/>
        </body>
      </body>
      <body name="right_thigh" pos="0 -0.1 0" childclass="leg">
        <inertial pos="0 0 -0.14" mass="0.9" diaginertia="0.007 0.006 0.001"/>
        <joint name="right_hip" range="-1.6 1.2"/>
        <geom fromto="0 0 0 0 0 -0.28"/>
        <body name="right_shank" pos="0 0 -0.3">
          <inertial pos="0 0 -0.13" mass="0.4" diaginertia="0.003 0.003 0.0004"/>
          <joint name="right_knee" range="0 2.4"/>
          <geom fromto="0 0 0 0 0 -0.25"/>
          <geom name="right_foot" class="foot" pos="0.01 0 -0.28"/>
        </body>
      </body>
      <body name="tail" pos="-0.2 0 0">
        <inertial pos="-0.1 0 0" mass="0.3" diaginertia="0.0005 0.001 0.001"/>
        <joint name="reach" type="slide" axis="-1 0 0.2" range="0 0.2" damping="4" armature="0.1"/>
        <geom type="cylinder" size="0.02 0.05" pos="-0.1 0 0" quat="0.7071 0 0.7071 0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position class="leg" name="left_hip" joint="left_hip"/>
    <position class="leg" name="left_knee" joint="left_knee" kp="80"/>
    <position class="leg" name="right_hip" joint="right_hip"/>
    <position class="leg" name="right_knee" joint="right_knee" kp="80"/>
    <position name="reach" joint="reach" kp="200" forcerange="-15 15"/>
  </actuator>
  <keyframe>
    <key name="crouch" qpos="0.3 -0.2 0.53 1 0 0 0 -0.6 1.1 -0.5 1.0 0.05"
      ctrl="-0.7 1.2 -0.3 0.9 0.12"/>
  </keyframe>
</mujoco>)";

// A carriage with feet of two kinds on a floor and a block of other kinds, stops and dry friction each
// with a softness of its own, and fingers that are coupled softly. In `cone` the option.
const char* const kSoft = R"(<mujoco model="soft">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.002" cone="CONE"/>
  <default><geom friction="0.7 0.005 0.0001" solref="0.015 1"/></default>
  <worldbody>
    <geom name="ground" type="plane" size="5 5 0.1" friction="0.9" solimp="0.8 0.95 0.002"/>
    <geom name="block" type="box" pos="0.3 0 0.02" size="0.1 0.3 0.02" solref="-4000 -90"/>
    <body name="carriage" pos="0 0 0.1">
      <freejoint/>
      <geom name="hull" type="box" size="0.3 0.2 0.03" mass="3" margin="0.002"/>
      <geom name="hard" type="sphere" size="0.05" pos="0.25 0.15 -0.045" priority="1"
        friction="1.2 0.01 0.001" condim="6" solref="0.006 1" solimp="0.9 0.99 0.001"/>
      <geom name="gapped" type="sphere" size="0.05" pos="0.25 -0.15 -0.045" margin="0.01" gap="0.008"
        solmix="3"/>
      <geom name="soft" type="sphere" size="0.05" pos="-0.25 0 -0.04" solref="0.04 0.7"
        friction="0.3 0.005 0.0001"/>
      <body name="arm" pos="0 0 0.05">
        <joint name="lift" axis="0 1 0" range="-0.4 0.3" solreflimit="0.01 1" frictionloss="0.2"
          solreffriction="0.03 1" damping="0.05"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.4" contype="0" conaffinity="0"/>
        <body name="left" pos="0.3 0.05 0">
          <joint name="left" type="slide" axis="0 1 0" range="0 0.05" solimplimit="0 0.99 0.003"/>
          <geom type="box" size="0.02 0.01 0.04" mass="0.05"/>
        </body>
        <body name="right" pos="0.3 -0.05 0">
          <joint name="right" type="slide" axis="0 -1 0" range="0 0.05" armature="0.02"/>
          <geom type="box" size="0.02 0.01 0.04" mass="0.06"/>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="right" joint2="left" solref="0.005 1" solimp="0.95 0.99 0.001"/></equality>
  <actuator><motor joint="left" ctrlrange="-5 5"/><motor joint="lift"/></actuator>
  <keyframe><key name="tilted" qpos="0 0 0.11 0.9995 0.0316 0 0 0.2 0.02 0.02" ctrl="0.3 1.5"/></keyframe>
</mujoco>)";

}  // namespace

// As below; what MuJoCo mixes of two geoms it mixes in both, in the same order. Contacts that come and
// go grow differences faster, and in half a second by less than 1e6.
TEST_CASE("softness of geoms, stops, friction and couplings is the file's", "[import][mjcf]") {
  const std::string cone = GENERATE("elliptic", "pyramidal");
  const TemporaryFolder folder;
  std::string text = kSoft;
  text.replace(text.find("CONE"), 4, cone);
  const auto run = run_beside_original(folder.write("soft.xml", text), "tilted", 0.5);
  INFO((run ? "" : run.error().message));
  REQUIRE(run);
  INFO(run->furthest);
  CHECK(run->joints == 3);
  CHECK(run->touching >= 3);
  CHECK(run->apart < 1e-10);
  CHECK(run->base_apart < 1e-10);
}

// Both read one text and take the same steps; what differs is the rounding of a few products of
// poses and of principal axes, 1e-16. What stands on its feet forgets it or grows it slowly: in
// half a second, with both feet in contact from the first step, by far less than the factor 1e7
// that the bound leaves.
TEST_CASE("a model runs on the mujoco backend as its file does in MuJoCo", "[import][mjcf]") {
  const std::string start = GENERATE("", "crouch");
  const TemporaryFolder folder;
  const auto run = run_beside_original(folder.write("strider.xml", kModel), start, 0.5);
  INFO((run ? "" : run.error().message));
  REQUIRE(run);
  INFO(run->furthest);
  CHECK(run->joints == 5);
  CHECK(run->missing == 0);
  CHECK(run->touching >= 2);
  CHECK(run->apart < 1e-9);
  CHECK(run->base_apart < 1e-9);
}

// MuJoCo's reader finds principal axes to some 1e-6 rad: a second's swing is off by less than that.
TEST_CASE("a URDF runs on the mujoco backend as MuJoCo's own reader has it", "[import][urdf]") {
  const TemporaryFolder folder;
  const auto run = run_beside_original(folder.write("arm.urdf", R"(<robot name="arm">
    <link name="base"/>
    <link name="upper"><inertial><origin xyz="0.03 -0.02 0.2" rpy="0.3 -0.5 1.1"/><mass value="1.4"/>
      <inertia ixx="0.03" ixy="0.004" ixz="-0.002" iyy="0.025" iyz="0.003" izz="0.01"/></inertial></link>
    <link name="lower"><inertial><origin xyz="0 0.01 0.15"/><mass value="0.7"/>
      <inertia ixx="0.01" ixy="0" ixz="0.001" iyy="0.011" iyz="0" izz="0.002"/></inertial></link>
    <link name="tool"><inertial><mass value="0.2"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
    <link name="finger"><inertial><origin xyz="0 0 0.02"/><mass value="0.05"/>
      <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
    <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
      <origin xyz="0 0.1 0.3" rpy="0.2 0 0.4"/><axis xyz="0 0.6 0.8"/>
      <limit lower="0.3" upper="1.2" effort="10" velocity="3"/><dynamics damping="0.05"/></joint>
    <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
      <origin xyz="0 0 0.4" rpy="0 0.7 0"/><axis xyz="1 0 0"/></joint>
    <joint name="mount" type="fixed"><parent link="lower"/><child link="tool"/>
      <origin xyz="0 0 0.3" rpy="0.1 0.2 0.3"/></joint>
    <joint name="grip" type="prismatic"><parent link="tool"/><child link="finger"/>
      <origin xyz="0.02 0 0"/><axis xyz="1 0 0"/>
      <limit lower="-0.01" upper="0.03" effort="10" velocity="1"/><dynamics damping="2" friction="0.05"/></joint>
  </robot>)"),
                                       "", 1.0);
  INFO((run ? "" : run.error().message));
  REQUIRE(run);
  INFO(run->furthest);
  CHECK(run->joints == 3);
  CHECK(run->missing == 0);
  CHECK(run->apart < 1e-6);
}
