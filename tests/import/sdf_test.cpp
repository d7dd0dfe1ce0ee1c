#include <cmath>

#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("a model of SDF with frames and joints", "[sdf]") {
  Imported in;
  in.read(R"(<sdf version="1.9"><world name="w">
    <physics type="ode"><max_step_size>0.002</max_step_size></physics>
    <plugin filename="libx.so" name="x"/>
    <model name="ground"><static>true</static><link name="l"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
    <model name="pendulum"><pose>1 2 3 0 0 1.5707963267948966</pose>
      <frame name="f"><pose>0 0 1 0 0 0</pose></frame>
      <link name="base"><inertial><mass>2</mass></inertial></link>
      <link name="arm"><pose relative_to="f">0.5 0 0 0 0 0</pose><inertial><mass>1</mass><pose>0 0 -0.5 0 0 0</pose>
        <inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.01</izz></inertia></inertial>
        <collision name="c"><geometry><cylinder><radius>0.05</radius><length>1</length></cylinder></geometry></collision></link>
      <joint name="j" type="revolute"><parent>base</parent><child>arm</child>
        <axis><xyz expressed_in="__model__">0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit><dynamics><damping>0.2</damping></dynamics></axis></joint>
    </model></world></sdf>)",
          "w.sdf");
  REQUIRE(in.model);
  CHECK(in.result.format == "SDF");
  const Body& arm = in.body("pendulum_arm");
  // Turned by a quarter about z: x of the model is y of the world.
  CHECK((arm.X_WB.p - Vec3(1, 2.5, 4)).norm() < 1e-9);
  CHECK((arm.com - Vec3(0, 0, -0.5)).norm() < 1e-12);
  const Joint& j = in.joint("pendulum_j");
  CHECK(j.axes[0].damping == 0.2);
  const Vec3 axis_W = arm.X_WB.q * (j.X_CM.q * Vec3::UnitZ());
  CHECK((axis_W - Vec3(-1, 0, 0)).norm() < 1e-9);
  CHECK(in.reports(kLeftOut, "plugin 'libx.so'"));
}

TEST_CASE("a link of SDF without a name is refused at its line", "[sdf]") {
  Imported in;
  in.read("<sdf version=\"1.9\"><model name=\"m\">\n<link/></model></sdf>", "m.sdf");
  CHECK(in.refuses("CG1404", "without a name", 2));
}

TEST_CASE("joints of SDF in a circle are a joint and a loop", "[sdf]") {
  Imported in;
  const auto circle = [](const std::string& last) {
    return "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\"/><link name=\"b\"/>\n"
           "<joint name=\"j\" type=\"ball\"><parent>a</parent><child>b</child></joint>\n"
           "<joint name=\"k\" type=\"ball\"><parent>" +
           last + "</parent><child>a</child></joint></model></sdf>";
  };
  in.read(circle("b"), "m.sdf");
  REQUIRE(in.model);
  CHECK(in.model->bodies.size() == 2);
  CHECK_FALSE(in.joint("j").closes_loop);
  CHECK(in.joint("k").closes_loop);
  in.read(circle("a"), "m.sdf");
  CHECK(in.refuses("CG1410", "to itself", 3));
}

TEST_CASE("axes of a universal joint are made perpendicular", "[sdf]") {
  Imported in;
  const auto robot = [](const std::string& second) {
    return "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\"/><link name=\"b\"/>"
           "<joint name=\"j\" type=\"universal\"><parent>a</parent><child>b</child>"
           "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>" +
           second + "</xyz></axis2></joint></model></sdf>";
  };
  in.read(robot("1 1 0"), "m.sdf");
  REQUIRE(in.model);
  CHECK(in.joint("j").type == JointType::universal);
  CHECK(in.reports(dsl::Fidelity::approximate, "axes of joint 'j'", "45 deg"));
  in.read(robot("-2 0 0"), "m.sdf");
  REQUIRE(in.model);
  CHECK(in.joint("j").type == JointType::hinge);
  CHECK(in.reports(dsl::Fidelity::left_out, "axes of joint 'j'", "are parallel"));
}

TEST_CASE("both axes of a universal joint of SDF keep their laws", "[sdf]") {
  Imported in;
  in.read(R"(<sdf version="1.9"><model name="m"><link name="a"/><link name="b"/>
<joint name="j" type="universal"><parent>a</parent><child>b</child>
<axis><xyz>1 0 0</xyz><limit><lower>-1</lower><upper>2</upper><effort>5</effort></limit>
<dynamics><damping>0.1</damping><spring_stiffness>3</spring_stiffness></dynamics></axis>
<axis2><xyz>0 1 0</xyz><limit><lower>0.25</lower></limit><dynamics><friction>0.2</friction>
<spring_reference>0.5</spring_reference></dynamics></axis2></joint></model></sdf>)",
          "m.sdf");
  REQUIRE(in.model);
  const Joint& j = in.joint("j");
  REQUIRE(j.axes.size() == 2);
  CHECK(j.axes[0].lower == -1.0);
  CHECK(j.axes[0].upper == 2.0);
  CHECK(j.axes[1].lower == 0.25);
  CHECK(std::isinf(j.axes[1].upper));
  CHECK(j.axes[0].max_effort == 5.0);
  CHECK(std::isinf(j.axes[1].max_effort));
  CHECK(j.axes[0].damping == 0.1);
  CHECK(j.axes[1].friction == 0.2);
  CHECK(j.axes[0].stiffness == 3.0);
  CHECK(j.axes[1].rest == 0.5);
  CHECK(j.position == std::vector<double>{0.0, 0.25});
  CHECK(in.reports(kApproximate, "joint 'j'", "starts at 0 and 0.25"));
}

TEST_CASE("both words for the thread of a screw are read", "[sdf]") {
  const auto pitch = [](const std::string& words) {
    Imported in;
    in.read(
        R"(<sdf version="1.9"><model name="m"><link name="a"/><link name="b"><pose>0 0 1 0 0 0</pose></link>
<joint name="fix" type="fixed"><parent>world</parent><child>a</child></joint>
<joint name="turn" type="screw"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>)" +
            words + "</joint></model></sdf>",
        "m.sdf");
    REQUIRE(in.model);
    const Joint& turn = in.joint("turn");
    return turn.type == JointType::screw ? turn.pitch : 0.0;
  };
  CHECK(pitch("<screw_thread_pitch>0.002</screw_thread_pitch>") == Approx(0.002));
  CHECK(pitch("<thread_pitch>-100</thread_pitch>") == Approx(2.0 * 3.14159265358979 / 100.0));
  CHECK(pitch("<screw_thread_pitch>0</screw_thread_pitch>") == 0.0);
  CHECK(pitch("<thread_pitch>0</thread_pitch>") == 0.0);
}

TEST_CASE("an inertia that SDF gives as zero is taken from the collisions", "[sdf]") {
  Imported in;
  in.read(R"(<sdf version="1.7"><model name="m"><link name="a"><inertial><mass>5</mass>
      <inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia></inertial>
    <collision name="c"><geometry><sphere><radius>0.5</radius></sphere></geometry></collision>
    </link></model></sdf>)",
          "m.sdf");
  REQUIRE(in.model);
  // 2 m r² / 5
  CHECK((in.body("a").inertia - 0.5 * Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(in.reports(kApproximate, "inertia of link 'a'", "is zero"));
}

TEST_CASE("joints of SDF keep their laws, couplings their reference, shapes their bounce",
          "[sdf]") {
  Imported in;
  in.read(R"(<sdf version="1.9"><model name="m">
    <link name="a"><inertial><mass>1</mass></inertial><collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry>
      <surface><bounce><restitution_coefficient>0.7</restitution_coefficient></bounce></surface></collision></link>
    <link name="b"><pose>1 0 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>
    <link name="c"><pose>2 0 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>
    <link name="d"><pose>3 0 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>
    <joint name="turn" type="screw"><parent>a</parent><child>b</child><screw_thread_pitch>0.01</screw_thread_pitch><axis><xyz>1 0 0</xyz>
      <limit><lower>-0.5</lower><upper>0.5</upper></limit><dynamics><damping>3</damping></dynamics></axis></joint>
    <joint name="follow" type="revolute"><parent>a</parent><child>c</child><axis><xyz>0 0 1</xyz>
      <mimic joint="turn"><multiplier>2</multiplier><offset>0.1</offset><reference>0.3</reference></mimic></axis></joint>
    <joint name="cross" type="universal"><parent>a</parent><child>d</child><axis><xyz>1 0 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>
      <axis2><xyz>0 1 0</xyz></axis2></joint>
  </model></sdf>)",
          "m.sdf");
  REQUIRE(in.model);
  const Joint& turn = in.named(in.model->joints, "turn");
  CHECK(turn.axes[0].lower == -0.5);
  CHECK(turn.axes[0].upper == 0.5);
  CHECK(turn.axes[0].damping == 3.0);
  REQUIRE(in.model->couplings.size() == 1);
  CHECK(in.model->couplings[0].offset == Approx(0.1 - 2.0 * 0.3).epsilon(1e-12));
  CHECK(in.result.scene.find("restitution=\"0.7\"") != std::string::npos);
  CHECK(in.joint("cross").axes[0].lower == -1.0);
}

TEST_CASE("axes of SDF are in the frame of the joint, and in old files in that of the model",
          "[sdf]") {
  // The leaf is turned by a quarter about x: its z is the model's -y.
  const auto axis = [](const std::string& version, const std::string& of_axis,
                       const std::string& element = "axis") {
    Imported in;
    in.read(
        "<sdf version=\"" + version +
            "\"><model name=\"door\"><pose>0 0 0 0 0 1.5707963267948966</pose>"
            "<link name=\"base\"/><link name=\"leaf\"><pose>0.2 0 1 1.5707963267948966 0 0"
            "</pose></link><joint name=\"j\" type=\"" +
            (element == "axis" ? "revolute" : "universal") +
            "\"><parent>base</parent><child>leaf</child>" +
            (element == "axis" ? "" : "<axis><xyz expressed_in=\"__model__\">1 0 0</xyz></axis>") +
            "<" + element + ">" + of_axis + "</" + element + "></joint></model></sdf>",
        "door.sdf");
    REQUIRE(in.model);
    const Joint& j = in.joint("j");
    const Quat q = in.body("leaf").X_WB.q * j.X_CM.q;
    // A hinge turns about the z of its frame, a universal joint about its x, then its y.
    return Vec3(q * (element == "axis" ? Vec3::UnitZ() : Vec3::UnitY()));
  };
  const Vec3 up = Vec3::UnitZ(), of_leaf(1, 0, 0);  // -y of the model, which is turned about z
  for (const char* name : {"axis", "axis2"}) {
    INFO(name);
    for (const char* old : {"1.4", "1.3", "1.0"})
      CHECK((axis(old, "<xyz>0 0 1</xyz>", name) - up).norm() < 1e-9);
    for (const char* now : {"1.5", "1.6", "1.10", "1.11"})
      CHECK((axis(now, "<xyz>0 0 1</xyz>", name) - of_leaf).norm() < 1e-9);
    CHECK((axis("1.6", "<xyz>0 0 1</xyz><use_parent_model_frame>1</use_parent_model_frame>", name) -
           up)
              .norm() < 1e-9);
    CHECK((axis("1.9", "<xyz expressed_in=\"base\">0 0 1</xyz>", name) - up).norm() < 1e-9);
  }
  CHECK((axis("1.4", "") - up).norm() < 1e-9);  // without <xyz>
}

TEST_CASE("an included SDF has the axes of its own version", "[sdf]") {
  for (const auto& [version, up] : {std::pair{"1.4", true}, std::pair{"1.5", false}}) {
    Imported in;
    in.folder.write(
        "door/model.sdf",
        std::string("<sdf version=\"") + version +
            "\"><model name=\"door\"><link name=\"base\"/><link name=\"leaf\"><pose>0.2 "
            "0 1 1.5707963267948966 0 0</pose></link><joint name=\"j\" "
            "type=\"revolute\"><parent>base</parent><child>leaf</child><axis><xyz>0 0 "
            "1</xyz></axis></joint></model></sdf>");
    in.read(
        "<sdf version=\"1.9\"><model "
        "name=\"m\"><include><uri>door</uri><name>front</name></include>"
        "</model></sdf>",
        "m.sdf");
    REQUIRE(in.model);
    const Vec3 axis = in.body("m_front_leaf").X_WB.q * in.joint("m_front_j").X_CM.q * Vec3::UnitZ();
    CHECK((axis - (up ? Vec3(0, 0, 1) : Vec3(0, -1, 0))).norm() < 1e-9);
  }
}

TEST_CASE("names of SDF reach into nested models", "[sdf]") {
  Imported in;
  in.folder.write("drive/model.sdf",
                  "<sdf version=\"1.11\"><model name=\"any\"><link name=\"stand\"/><link "
                  "name=\"wheel\"><pose>0 0.3 0 0 0 0</pose></link><frame name=\"grip\" "
                  "attached_to=\"wheel\"><pose>0 0 0.1 0 0 0</pose></frame><joint name=\"spin\" "
                  "type=\"revolute\"><parent>stand</parent><child>wheel</child><axis><xyz>0 1 "
                  "0</xyz></axis></joint></model></sdf>");
  in.read(R"(<sdf version="1.11"><model name="hand">
    <include><uri>drive</uri><name>drive</name><pose>0 0 2 0 0 0</pose><placement_frame>grip</placement_frame></include>
    <link name="tip"><pose relative_to="drive::grip">1 0 0 0 0 0</pose>
      <sensor name="eye" type="camera"><pose relative_to="drive::wheel">0 0 0.5 0 0 0</pose></sensor></link>
    <frame name="far" attached_to="drive::grip"><pose>0 0 1 0 0 0</pose></frame>
    <joint name="hold" type="fixed"><parent>far</parent><child>tip</child></joint>
    <link name="finger"/>
    <joint name="curl" type="revolute"><parent>drive::stand</parent><child>finger</child>
      <axis><xyz expressed_in="drive::grip">0 1 0</xyz><mimic joint="drive::spin"><multiplier>2</multiplier><offset>0.1</offset><reference>0</reference></mimic></axis></joint>
    <plugin filename="gz-sim-joint-controller-system" name="gz::sim::systems::JointController"><joint_name>drive::spin</joint_name></plugin>
  </model></sdf>)",
          "hand.sdf");
  INFO(in.result.scene);
  REQUIRE(in.model);
  CHECK(in.model->couplings.size() == 1);
  const Joint& curl = in.joint("curl");
  const Joint& spin = in.joint("hand_drive_spin");
  CHECK(in.model->joints[in.model->couplings[0].joint].name == curl.name);
  REQUIRE(in.model->motors.size() == 1);
  CHECK(in.model->joints[in.model->motors[0].joint].name == spin.name);
  // The grip is at (0, 0, 2): the wheel 0.1 m below it, with the tip 1 m beside it.
  const Body& wheel = in.body("hand_drive_wheel");
  CHECK((wheel.X_WB.p - Vec3(0, 0, 1.9)).norm() < 1e-9);
  CHECK((in.frame("tip").X_BF.p - Vec3(1, 0, 0.1)).norm() < 1e-9);
  REQUIRE(in.model->sensors.size() == 1);
  CHECK((wheel.X_WB * in.model->sensors[0].X_BS).p.z() == Approx(2.4));
  CHECK_FALSE(in.reports(kLeftOut, ""));
}

TEST_CASE("what an include merges is part of the model around it", "[sdf]") {
  Imported in;
  in.folder.write("arm/model.sdf",
                  "<sdf version=\"1.9\"><model name=\"arm\"><link name=\"upper\"><pose>0 0 1 0 0 0"
                  "</pose></link><link name=\"lower\"><pose relative_to=\"upper\">0 0 -0.5 0 0 0"
                  "</pose></link><joint name=\"elbow\" type=\"revolute\"><parent>upper</parent>"
                  "<child>lower</child><axis><xyz expressed_in=\"__model__\">0 1 0</xyz></axis>"
                  "</joint></model></sdf>");
  in.read(R"(<sdf version="1.9"><model name="robot"><link name="base"/>
    <include merge="true"><uri>arm</uri><pose>1 0 0 0 0 1.5707963267948966</pose></include>
    <joint name="shoulder" type="ball"><parent>base</parent><child>upper</child></joint>
  </model></sdf>)",
          "robot.sdf");
  INFO(in.result.scene);
  REQUIRE(in.model);
  CHECK(in.model->bodies.size() == 3);
  CHECK((in.body("lower").X_WB.p - Vec3(1, 0, 0.5)).norm() < 1e-9);
  const Vec3 axis = in.body("lower").X_WB.q * in.joint("elbow").X_CM.q * Vec3::UnitZ();
  CHECK((axis - Vec3(-1, 0, 0)).norm() < 1e-9);
  CHECK_FALSE(in.reports(kApproximate, "arm"));
}
