// What Gazebo reads in models and worlds: sensors, plugins, lights, wind, water, terrain.
#include "cogrsim/core/image.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const std::string kInertial =
    "<inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>";

std::string world(const std::string& content) {
  return "<sdf version=\"1.9\"><world name=\"w\">" + content + "</world></sdf>";
}

/// Two links and the hinge 'j' between them, with more in the second link, joint and model.
std::string arm(const std::string& in_link, const std::string& in_joint = "",
                const std::string& in_model = "") {
  return "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\">" + kInertial +
         "</link><link name=\"b\"><pose>0 0 1 0 0 0</pose>" + kInertial + in_link +
         "</link><joint name=\"j\" type=\"revolute\"><parent>a</parent><child>b</child>"
         "<axis><xyz>0 1 0</xyz></axis>" +
         in_joint + "</joint>" + in_model + "</model></sdf>";
}

std::string in_urdf(const std::string& in_link) {
  return R"(<robot name="r"><link name="b"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <gazebo reference="b">)" +
         in_link + "</gazebo></robot>";
}

const char* const kLidar = R"(<sensor name="scan" type="gpu_lidar">
  <pose>0.1 0 0.2 0 0 0</pose><update_rate>10</update_rate>
  <lidar><scan>
      <horizontal><samples>90</samples><resolution>2</resolution><min_angle>-0.5</min_angle><max_angle>1.5</max_angle></horizontal>
      <vertical><samples>4</samples><min_angle>-0.3</min_angle><max_angle>0.3</max_angle></vertical></scan>
    <range><min>0.2</min><max>8</max></range>
    <noise><type>gaussian</type><mean>0.01</mean><stddev>0.02</stddev></noise></lidar></sensor>)";

}  // namespace

TEST_CASE("a lidar of Gazebo is the same in SDF and in URDF", "[sdf][urdf][gazebo]") {
  Imported in;
  if (GENERATE(true, false))
    in.read(arm(kLidar), "m.sdf");
  else
    in.read(in_urdf(kLidar));
  REQUIRE(in.model);
  REQUIRE(in.model->sensors.size() == 1);
  const SensorModel& s = in.model->sensors[0];
  CHECK(s.type == "lidar");
  CHECK(s.rate == 10.0);
  CHECK(parameter(s, "rays") == 180.0);
  CHECK(parameter(s, "fov") == 2.0);
  CHECK(parameter(s, "rings") == 4.0);
  CHECK(parameter(s, "vertical-fov") == 0.6);
  CHECK(parameter(s, "range", 0) == 0.2);
  CHECK(parameter(s, "range", 1) == 8.0);
  REQUIRE(s.noise.size() == 1);
  CHECK(s.noise[0].a == 0.01);
  CHECK(s.noise[0].b == 0.02);
  // Its rays are about their middle, 0.5 rad to the left.
  CHECK((s.X_BS.p - Vec3(0.1, 0.0, 0.2)).norm() < 1e-15);
  CHECK(s.X_BS.q.angularDistance(Quat(Eigen::AngleAxisd(0.5, Vec3::UnitZ()))) < 1e-15);
  CHECK(in.reports(kExact, "sensor 'scan'"));
}

TEST_CASE("cameras of SDF have their picture, clipping and noise", "[sdf][gazebo]") {
  Imported in;
  const std::string type = GENERATE("camera", "depth_camera", "rgbd_camera");
  in.read(arm("<sensor name=\"eye\" type=\"" + type + R"("><camera>
      <horizontal_fov>1.2</horizontal_fov><image><width>64</width><height>48</height></image>
      <clip><near>0.2</near><far>30</far></clip>
      <noise><type>gaussian</type><mean>0</mean><stddev>0.007</stddev></noise>
    </camera></sensor>)"),
          "m.sdf");
  REQUIRE(in.model);
  REQUIRE(in.model->sensors.size() == 1);
  const SensorModel& s = in.model->sensors[0];
  CHECK(s.type == "camera");
  CHECK(parameter(s, "fov") == 1.2);
  CHECK(parameter(s, "resolution", 0) == 64.0);
  CHECK(parameter(s, "resolution", 1) == 48.0);
  CHECK(parameter(s, "near") == 0.2);
  CHECK(parameter(s, "far") == 30.0);
  REQUIRE(s.noise.size() == 1);
  CHECK(s.noise[0].b == 0.007);
  CHECK(s.noise[0].group == (type == "depth_camera" ? 1 : 0));
  CHECK((in.result.scene.find("depth=\"true\"") != std::string::npos) == (type != "camera"));
  CHECK(in.reports(kExact, "sensor 'eye'"));
}

TEST_CASE("an imu of SDF has noise of both quantities, and no orientation", "[sdf][gazebo]") {
  Imported in;
  const std::string z = GENERATE("0.1", "0.3");
  const auto axes = [](const std::string& x, const std::string& last) {
    const auto one = [](const std::string& axis, const std::string& sigma) {
      return "<" + axis + "><noise type=\"gaussian\"><mean>0</mean><stddev>" + sigma +
             "</stddev></noise></" + axis + ">";
    };
    return one("x", x) + one("y", x) + one("z", last);
  };
  in.read(arm("<sensor name=\"imu\" type=\"imu\"><imu><linear_acceleration>" + axes("0.1", z) +
              "</linear_acceleration><angular_velocity>" + axes("0.2", "0.2") +
              "</angular_velocity></imu></sensor>"),
          "m.sdf");
  REQUIRE(in.model);
  REQUIRE(in.model->sensors.size() == 1);
  const auto& noise = in.model->sensors[0].noise;
  REQUIRE(noise.size() == 2);
  CHECK(noise[0].b == 0.1);
  CHECK(noise[0].group == 0);
  CHECK(noise[1].b == 0.2);
  CHECK(noise[1].group == 1);
  CHECK(in.reports(kApproximate, "sensor 'imu'", "without orientation"));
  CHECK(in.reports(kApproximate, "sensor 'imu'", "of all axes is that of x") == (z == "0.3"));
}

TEST_CASE("a sensor of force and torque measures its joint, also a fixed one", "[sdf][gazebo]") {
  Imported in;
  const std::string type = GENERATE("revolute", "fixed");
  const std::string direction = GENERATE("parent_to_child", "child_to_parent");
  std::string text = arm("",
                         "<sensor name=\"ft\" type=\"force_torque\"><force_torque>"
                         "<frame>child</frame><measure_direction>" +
                             direction + "</measure_direction></force_torque></sensor>");
  text.replace(text.find("revolute"), 8, type);
  in.read(text, "m.sdf");
  REQUIRE(in.model);
  CHECK(in.model->bodies.size() == 2);
  REQUIRE(in.model->sensors.size() == 1);
  CHECK(in.model->sensors[0].type == "force-torque");
  CHECK(in.model->sensors[0].joint == 0);
  if (direction == "parent_to_child")
    CHECK(in.reports(kExact, "sensor 'ft'"));
  else
    CHECK(in.reports(kApproximate, "sensor 'ft'", "opposite sign"));
}

TEST_CASE("sensors that a scene does not have are left out with what is like them",
          "[sdf][gazebo]") {
  Imported in;
  in.read(arm("<sensor name=\"s1\" type=\"altimeter\"/><sensor name=\"s2\" type=\"force_torque\"/>"
              "<sensor name=\"s3\" type=\"contact\"/>",
              "<sensor name=\"s4\" type=\"imu\"/>"),
          "m.sdf");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "sensor 's1'", "a <pose> sensor has the height"));
  CHECK(in.reports(kLeftOut, "sensor 's2'", "measures a joint"));
  CHECK(in.reports(kExact, "sensor 's3'"));
  CHECK(in.reports(kLeftOut, "sensor 's4'", "of a joint"));
}

TEST_CASE("a camera inside of its own body stays, one inside another is left out",
          "[sdf][gazebo]") {
  Imported in;
  const std::string box =
      "<visual name=\"v\"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></visual>";
  in.read("<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\">" + kInertial + box +
              "</link><link name=\"b\"><pose>0 0 1 0 0 0</pose>" + kInertial + box +
              "<sensor name=\"own\" type=\"camera\"/><sensor name=\"other\" type=\"camera\">"
              "<pose relative_to=\"a\">0 0 0.05 0 0 0</pose></sensor></link></model></sdf>",
          "m.sdf");
  REQUIRE(in.model);
  REQUIRE(in.model->sensors.size() == 1);
  CHECK(in.model->sensors[0].name.find("own") != std::string::npos);
  CHECK(in.reports(kLeftOut, "camera 'other'", "inside another body"));
}

TEST_CASE("a position controller of Gazebo is a servo, in SDF and in URDF", "[sdf][urdf][gazebo]") {
  Imported in;
  const std::string plugin = R"(<plugin filename="gz-sim-joint-position-controller-system"
      name="gz::sim::systems::JointPositionController"><joint_name>j</joint_name>
    <p_gain>20</p_gain><i_gain>0</i_gain><d_gain>0.5</d_gain><cmd_max>7</cmd_max><cmd_min>-7</cmd_min>
    <initial_position>0.4</initial_position></plugin>)";
  if (GENERATE(true, false))
    in.read(arm("", "", plugin), "m.sdf");
  else
    in.read(R"(<robot name="r"><link name="a"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="b"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
      <gazebo>)" +
            plugin + "</gazebo></robot>");
  REQUIRE(in.model);
  REQUIRE(in.model->motors.size() == 1);
  CHECK(in.result.scene.find("<servo name=\"j_servo\" joint=\"j\" kp=\"20 N*m/rad\" "
                             "kd=\"0.5 N*m*s/rad\" max-torque=\"7 N*m\" target=\"0.4 rad\"/>") !=
        std::string::npos);
  CHECK(in.reports(kExact, "plugin 'gz-sim-joint-position-controller-system'", "is 'j_servo'"));
}

TEST_CASE("plugins that drive joints are motors", "[sdf][gazebo]") {
  Imported in;
  struct Case {
    const char *plugin, *motor;
    dsl::Fidelity fidelity;
    const char* message;
  };
  const Case c = GENERATE(
      Case{"name=\"gz::sim::systems::JointController\"><joint_name>j</joint_name>"
           "<initial_velocity>2</initial_velocity>",
           "mode=\"velocity\" target=\"2 rad/s\"", kExact, "is 'j_motor'"},
      Case{"name=\"ignition::gazebo::systems::ApplyJointForce\"><joint_name>j</joint_name>",
           "mode=\"torque\"", kExact, "is 'j_motor'"},
      Case{"name=\"drive\" filename=\"libgazebo_ros_diff_drive.so\"><left_joint>j</left_joint>"
           "<wheel_separation>0.4</wheel_separation><wheel_radius>0.05</wheel_radius>",
           "mode=\"velocity\"", kApproximate, "track=\"0.4 m\" wheel_radius=\"0.05 m\""},
      Case{"name=\"gz::sim::systems::JointPositionController\"><joint_name>j</joint_name>"
           "<use_velocity_commands>true</use_velocity_commands>"
           "<initial_position>0.1</initial_position>",
           "mode=\"position\" target=\"0.1 rad\"", kApproximate, "50 ms"});
  INFO(c.plugin);
  in.read(arm("", "", std::string("<plugin ") + c.plugin + "</plugin>"), "m.sdf");
  REQUIRE(in.model);
  CHECK(in.result.scene.find(std::string("<motor name=\"j_motor\" joint=\"j\" ") + c.motor) !=
        std::string::npos);
  CHECK(in.reports(c.fidelity, "plugin", c.message));
}

TEST_CASE("what plugins do is reported with what a scene has for it", "[sdf][gazebo]") {
  Imported in;
  in.read(arm("", "", R"(<plugin name="gz::sim::systems::LiftDrag" filename="a"/>
    <plugin name="x" filename="gz-sim-thruster-system"/>
    <plugin name="x" filename="libgazebo_ros_camera.so"/>
    <plugin name="gz::sim::systems::JointController" filename="b"><joint_name>k</joint_name></plugin>
    <plugin name="my::Own" filename="own"/>)"),
          "m.sdf");
  REQUIRE(in.model);
  CHECK(in.reports(kLeftOut, "plugin 'a'", "<drag>"));
  CHECK(in.reports(kLeftOut, "plugin 'gz-sim-thruster-system'", "<force"));
  CHECK(in.reports(kExact, "plugin 'libgazebo_ros_camera.so'"));
  CHECK(in.reports(kLeftOut, "plugin 'b'", "there is no joint 'k'"));
  CHECK(in.reports(kLeftOut, "plugin 'own'", "is not known"));
}

TEST_CASE("lights of a world shine where they did", "[sdf][gazebo]") {
  Imported in;
  in.read(
      world(R"(<light name="sun" type="directional"><pose>0 0 9 0 0 1.5707963267948966</pose>
      <direction>1 0 -1</direction><diffuse>1 0.5 0 1</diffuse><cast_shadows>true</cast_shadows></light>
    <light name="lamp" type="spot"><pose>1 2 3 0 0 0</pose><intensity>0.5</intensity>
      <spot><outer_angle>0.8</outer_angle></spot></light>
    <light name="odd" type="area"/>
    <model name="m"><pose>0 0 5 0 0 0</pose><link name="l">)" +
            kInertial +
            R"(<light name="head" type="point"><pose>1 0 0 0 0 0</pose></light></link></model>)"),
      "w.sdf");
  REQUIRE(in.model);
  REQUIRE(in.model->lights.size() == 3);
  const auto light = [&](const char* name) {
    return *std::find_if(
        in.model->lights.begin(), in.model->lights.end(),
        [&](const LightModel& l) { return l.name.find(name) != std::string::npos; });
  };
  const LightModel sun = light("sun"), lamp = light("lamp"), head = light("head");
  CHECK(sun.type == LightModel::Type::directional);
  CHECK(sun.shadows);
  // The direction is in the axes of the light, which are turned by a quarter.
  CHECK((sun.X_WL.q * Vec3::UnitX() - Vec3(0, 1, -1).normalized()).norm() < 1e-12);
  CHECK(sun.color.g == Approx(0.5).margin(0.5 / 255.0));
  CHECK(lamp.type == LightModel::Type::spot);
  CHECK(lamp.X_WL.p == Vec3(1, 2, 3));
  CHECK(lamp.intensity == 0.5);
  CHECK(lamp.cone == 0.4);
  CHECK_FALSE(lamp.shadows);
  CHECK(head.X_WL.p == Vec3(1, 0, 5));
  CHECK(in.reports(kApproximate, "light 'head'", "stays where it is"));
  CHECK(in.reports(kLeftOut, "light 'odd'"));
}

TEST_CASE("wind of a world pushes the links that are in it", "[sdf][gazebo]") {
  Imported in;
  in.read(
      world("<wind><linear_velocity>3 0 0</linear_velocity></wind>"
            "<plugin filename=\"w\" name=\"gz::sim::systems::WindEffects\">"
            "<force_approximation_scaling_factor>0.25</force_approximation_scaling_factor></plugin>"
            "<model name=\"in\"><enable_wind>true</enable_wind><link name=\"l\">" +
            kInertial + "</link></model><model name=\"out\"><link name=\"l\">" + kInertial +
            "</link></model>"),
      "w.sdf");
  REQUIRE(in.model);
  CHECK(in.model->physics.gravity == Vec3(0, 0, -9.8));  // SDF's default
  REQUIRE(in.model->forces.size() == 2);
  for (const ForceModel& f : in.model->forces) {
    if (f.kind == ForceModel::Kind::wind) {
      CHECK(f.wind == Vec3(3, 0, 0));
    } else {
      CHECK(f.kind == ForceModel::Kind::drag);
      CHECK(f.linear == 0.5);  // 0.25 / s times 2 kg
      CHECK(&in.model->bodies.at(f.body) == &in.body("l"));
    }
  }
}

TEST_CASE("buoyancy of a world lifts what is enabled", "[sdf][gazebo]") {
  Imported in;
  const bool graded = GENERATE(false, true);
  const std::string ball =
      "<collision "
      "name=\"c\"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>";
  in.read(
      world("<plugin filename=\"b\" name=\"gz::sim::systems::Buoyancy\">" +
            std::string(graded ? "<graded_buoyancy><default_density>900</default_density>"
                                 "<density_change><above_depth>-2</above_depth><density>1</density>"
                                 "</density_change></graded_buoyancy>"
                               : "<uniform_fluid_density>900</uniform_fluid_density>") +
            "<enable>x</enable></plugin><model name=\"x\"><link name=\"l\">" + kInertial + ball +
            "</link></model><model name=\"xy\"><link name=\"l\">" + kInertial + ball +
            "</link></model>"),
      "w.sdf");
  REQUIRE(in.model);
  REQUIRE(in.model->forces.size() == 1);
  const ForceModel& f = in.model->forces[0];
  CHECK(f.kind == ForceModel::Kind::buoyancy);
  CHECK(&in.model->bodies.at(f.body) == &in.body("l"));
  CHECK(f.density == 900.0);
  CHECK(f.level == (graded ? -2.0 : 10000.0));
}

TEST_CASE("a picture of heights of SDF is a heightmap", "[sdf][gazebo]") {
  Imported in;
  Image image;
  image.width = image.height = 3;
  image.channels = 1;
  image.data = {100, 0, 0, 0, 50, 0, 0, 0, 0};  // the first row is that of the largest y
  in.folder.write("hill.png", encode_png(image).value());
  const std::string shape =
      "<geometry><heightmap><uri>hill.png</uri><size>4 6 2</size><pos>0 0 "
      "1</pos></heightmap></geometry>";
  in.read(world("<model name=\"m\"><static>true</static><link name=\"l\"><collision name=\"c\">" +
                shape + "</collision><visual name=\"v\">" + shape +
                "<material><ambient>1 0 0 1</ambient></material></visual></link></model>"),
          "w.sdf");
  REQUIRE(in.model);
  REQUIRE(in.model->heightmaps.size() == 1);
  const HeightGrid& g = *in.model->heightmaps[0];
  CHECK(g.size_x == 4.0);
  CHECK(g.size_y == 6.0);
  // The brightest point is as high as the size has it.
  CHECK(g.heights == std::vector<double>{0, 0, 0, 0, 1, 0, 2, 0, 0});
  CHECK(in.result.scene.find("color=\"#ff0000\"") != std::string::npos);
  in.read(
      world("<model name=\"m\"><static>true</static><link name=\"l\"><visual name=\"v\"><geometry>"
            "<heightmap/></geometry></visual></link></model>"),
      "w.sdf");
  CHECK(in.reports(kLeftOut, "visual 'v'", "names no picture"));
}

TEST_CASE("names in models reach into models inside of them", "[sdf]") {
  Imported in;
  const std::string inner =
      "<link name=\"hand\"><pose>0 0 1 0 0 0</pose>" + kInertial +
      "</link><frame name=\"grip\" attached_to=\"hand\"><pose>0 0 0.5 0 0 0</pose>"
      "</frame>";
  const std::string child = GENERATE("arm", "arm::hand", "arm::grip", "place");
  in.read(
      world("<model name=\"first\"><link name=\"l\">" + kInertial +
            "</link></model>"
            "<model name=\"robot\"><pose>0 0 10 0 0 0</pose><link name=\"base\">" +
            kInertial + "</link><model name=\"arm\"><pose>1 0 0 0 0 0</pose>" + inner +
            "</model>"
            "<frame name=\"place\" attached_to=\"arm::hand\"/>"
            "<joint name=\"j\" type=\"revolute\"><pose "
            "relative_to=\"arm::grip\"/><parent>base</parent><child>" +
            child +
            "</child><axis><xyz>0 1 0</xyz></axis></joint>"
            "<plugin filename=\"p\" name=\"gz::sim::systems::ApplyJointForce\">"
            "<joint_name>j</joint_name></plugin></model>"
            "<frame name=\"mark\" attached_to=\"robot::arm::hand\"/>"
            "<model name=\"last\"><pose relative_to=\"mark\">0 0 1 0 0 0</pose><link name=\"l\">" +
            kInertial +
            "</link></model>"
            "<joint name=\"tie\" type=\"ball\"><parent>first</parent><child>last</child></joint>"),
      "w.sdf");
  REQUIRE(in.model);
  const Body& hand = in.body("robot_arm_hand");
  CHECK((hand.X_WB.p - Vec3(1, 0, 11)).norm() < 1e-12);
  const Joint& j = in.joint("robot_j");
  CHECK(&in.model->bodies.at(j.child) == &hand);
  CHECK((j.X_CM.p - Vec3(0, 0, 0.5)).norm() < 1e-12);
  CHECK((in.body("last_l").X_WB.p - Vec3(1, 0, 12)).norm() < 1e-12);
  CHECK(in.joint("tie").type == JointType::ball);
  CHECK(in.model->motors.size() == 1);
}

TEST_CASE("a model is included from a folder beside it or a package, and placed", "[sdf]") {
  Imported in;
  const std::string ball =
      "<sdf version=\"1.9\"><model name=\"ball\"><pose>9 9 9 0 0 0</pose>"
      "<frame name=\"top\"><pose>0 0 0.5 0 0 0</pose></frame>"
      "<link name=\"l\">" +
      kInertial + "</link></model></sdf>";
  in.folder.write("models/ball/model.sdf", ball);
  const std::string uri = GENERATE("models/ball", "models/ball/model.sdf", "model://ball");
  in.options.packages["ball"] = in.folder / "models/ball";
  in.read(world("<include><uri>" + uri +
                "</uri><name>one</name><pose>1 0 0 0 0 0</pose></include>"
                "<include><uri>" +
                uri +
                "</uri><name>two</name><pose>2 0 0 0 0 0</pose>"
                "<placement_frame>top</placement_frame><static>true</static></include>"),
          "w.sdf");
  REQUIRE(in.model);
  CHECK((in.body("l").X_WB.p - Vec3(1, 0, 0)).norm() < 1e-12);
  CHECK((in.body("two_l").X_WB.p - Vec3(2, 0, -0.5)).norm() < 1e-12);
  CHECK(in.body("two_l").kind == BodyKind::static_body);
}

TEST_CASE("a joint between links that stand is left out", "[sdf]") {
  Imported in;
  in.read(
      R"(<sdf version="1.9"><model name="m"><static>true</static><link name="a"/><link name="b"/>
<joint name="turn" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></sdf>)",
      "m.sdf");
  REQUIRE(in.model);
  CHECK(in.model->joints.empty());
  CHECK(in.reports(dsl::Fidelity::left_out, "turn", "does not move"));
}
