// Sensors from the scene: their mounting, their bodies, parameters and noise.
#include <algorithm>
#include <cmath>

#include "build_support.h"
#include "cogrsim/sensing/sensor.h"
#include "fake_catalog.h"
#include "language/vocabulary.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const SensorModel& sensor(const SceneModel& model, const std::string& name) {
  const auto found = std::find_if(model.sensors.begin(), model.sensors.end(),
                                  [&](const SensorModel& s) { return s.name == name; });
  INFO("sensor " << name);
  REQUIRE(found != model.sensors.end());
  return *found;
}

const char* const kArm =
    "<box name='base' size='1 1 1' static='true'/>"
    "<box name='arm' size='1 1 1' mass='1' xyz='2 0 0'/>"
    "<hinge name='elbow' parent='base' child='arm' axis='0 1 0' xyz='-1 0 0' frame='arm'/>";

}  // namespace

TEST_CASE("attributes become the parameters of the SDK's sensors", "[sensors]") {
  const auto model = compile_scene(
      std::string(kArm) +
      "<infrared name='ir' on='arm' range='2 .. 80 cm' beam='10 deg' rays='20' reading='mean' "
      "response='GP2Y0A21' sees-own-body='true' xyz='50 0 0 cm' rpy='0 0 90 deg'/>"
      "<camera name='eye' on='arm' resolution='160 120' fov='90 deg' near='2 cm' depth='true' "
      "distortion='0.1 0 0 0 0' priority='3' show='true'/>"
      "<force-torque name='wrist' joint='elbow'/>"
      "<encoder name='ticks' joint='elbow' resolution='0.5 deg'/>");
  const SensorModel& ir = sensor(*model, "ir");
  CHECK(ir.parameters.at("range") == ParameterValue(std::vector<double>{0.02, 0.8}));
  CHECK(std::get<double>(ir.parameters.at("beam")) == Approx(M_PI / 18.0));
  CHECK(ir.parameters.at("rays") == ParameterValue(std::int64_t{20}));
  CHECK(ir.parameters.at("reading") == ParameterValue(std::string("mean")));
  CHECK(ir.parameters.at("response") == ParameterValue(std::string("GP2Y0A21")));
  CHECK(ir.parameters.at("sees-own-body") == ParameterValue(true));
  CHECK(ir.body == find_body(*model, "arm"));
  CHECK(near(ir.X_BS.p, Vec3(0.5, 0, 0)));
  CHECK(near(ir.X_BS.q * Vec3::UnitX(), Vec3::UnitY()));
  const SensorModel& eye = sensor(*model, "eye");
  CHECK(eye.parameters.at("resolution") == ParameterValue(std::vector<double>{160, 120}));
  CHECK(std::get<double>(eye.parameters.at("fov")) == Approx(M_PI / 2.0));
  CHECK(eye.parameters.at("depth") == ParameterValue(true));
  CHECK(eye.parameters.at("priority") == ParameterValue(std::int64_t{3}));
  CHECK(eye.show);
  const SensorModel& wrist = sensor(*model, "wrist");
  CHECK(wrist.joint == find_joint(*model, "elbow"));
  CHECK(near(wrist.X_BS.p, Vec3(-1, 0, 0)));
  CHECK(std::get<double>(sensor(*model, "ticks").parameters.at("resolution")) ==
        Approx(M_PI / 360.0));
}

TEST_CASE("a contact with on is a sensor and with between a rule", "[sensors]") {
  const auto model = compile_scene(
      "<material name='ice'/> <material name='rubber'/>"
      "<contact between='ice rubber' friction='0.1'/>"
      "<box name='b' size='1 1 1' mass='1' material='ice'/> <contact name='touch' on='b'/>");
  CHECK(model->material_pairs.size() == 1);
  REQUIRE(model->sensors.size() == 1);
  CHECK(model->sensors[0].type == "contact");
  CHECK(model->sensors[0].name == "touch");
}

TEST_CASE("a second kind of noise disturbs the second quantity", "[sensors]") {
  const auto model = compile_scene(
      "<box name='b' size='1 1 1' mass='1'/>"
      "<imu name='imu' on='b' noise='normal(0, 0.1 m/s^2)' gyro-noise='bias-walk(2 deg/s)'/>");
  const std::vector<NoiseTerm>& noise = model->sensors[0].noise;
  REQUIRE(noise.size() == 2);
  CHECK(noise[0].group == 0);
  CHECK(noise[0].b == Approx(0.1));
  CHECK(noise[1].group == 1);
  CHECK(noise[1].kind == NoiseTerm::Kind::bias_walk);
  CHECK(noise[1].a == Approx(2.0 * M_PI / 180.0));
}

TEST_CASE("attributes that are left out have the defaults of the SDK's sensors", "[sensors]") {
  const auto model = compile_scene(
      std::string(kArm) +
      "<camera name='camera' on='arm'/> <contact name='contact' on='arm'/>"
      "<encoder name='encoder' joint='elbow'/> <force-torque name='ft' joint='elbow'/>"
      "<imu name='imu' on='arm'/> <infrared name='infrared' on='arm'/>"
      "<lidar name='lidar' on='arm'/> <pose name='pose' on='arm'/>");
  REQUIRE(model->sensors.size() == built_in_sensors().size());
  for (const PluginDescriptor& d : built_in_sensors()) {
    INFO(d.name);
    const dsl::ElementSpec* element =
        d.name == "contact" ? &dsl::contact_sensor() : dsl::find_element(d.name);
    REQUIRE(element);
    for (const ParameterSpec& p : d.parameters) {
      INFO(p.name);
      CHECK(element->find(p.name));  // every parameter can be set in a scene
    }
    const auto made = std::find_if(model->sensors.begin(), model->sensors.end(),
                                   [&](const SensorModel& s) { return s.type == d.name; });
    REQUIRE(made != model->sensors.end());
    const auto bare = complete_parameters(d.parameters, {});
    const auto from_scene = complete_parameters(d.parameters, made->parameters);
    REQUIRE(bare);
    REQUIRE(from_scene);
    for (const auto& [name, value] : *bare) {
      INFO(name);
      if (const double* number = std::get_if<double>(&value)) {
        CHECK(std::get<double>(from_scene->at(name)) == Approx(*number).epsilon(1e-14));
      } else {
        CHECK(from_scene->at(name) == value);
      }
    }
  }
}

TEST_CASE("signals of a plugin's sensor have its channels and units", "[sensors]") {
  dsl_test::FakeCatalog catalog;
  dsl::CompileOptions options;
  options.plugins = &catalog;
  std::string set = "<set reach='2 m'/>";
  const auto codes = [&](const std::string& condition) {
    return codes_of("<box name='b' size='1 1 1'/><sensor plugin='sonar' name='s' on='b'>" + set +
                        "</sensor><test name='t' duration='1 s'><expect that='" + condition +
                        "'/></test><on when='" + condition + "'><end/></on>",
                    options);
  };
  CHECK(codes("s.distance lt 20 cm").empty());
  CHECK(codes("s.distance lt 20 deg") == "CG1102 CG1308");
  CHECK(codes("s.distnace lt 20 cm") == "CG1102 CG1308");
  // Without a catalog they are accepted unchecked, and parameters are refused.
  options.plugins = nullptr;
  CHECK(codes("s.distance lt 20 cm") == "CG0909");
  set.clear();
  CHECK(codes("s.distnace lt 20 cm").empty());
}

TEST_CASE("a sensor of the SDK can be used as a plugin, too", "[sensors]") {
  const auto model =
      compile_scene("<box name='b' size='1 1 1' mass='1'/> <sensor plugin='camera' on='b'/>");
  REQUIRE(model->sensors.size() == 1);
  CHECK(model->sensors[0].type == "camera");
}

TEST_CASE("frames in the bodies of an instance are named with dots", "[sensors][names]") {
  const auto model = compile_scene(
      "<prototype name='Dog'><body name='trunk'><box size='1 1 1' mass='1'/>"
      "<frame name='imu' xyz='0 0 0.5'/></body><export name='nose' of='trunk.imu'/></prototype>"
      "<instance of='Dog' name='dog' xyz='0 0 3'/>"
      "<assembly name='pack'><instance of='Dog' name='second' xyz='5 0 0'/>"
      "<pose name='inner' on='second.trunk.imu'/></assembly>"
      "<pose name='a' on='dog.trunk.imu'/><pose name='b' on='dog.nose' xyz='1 0 0'/>"
      "<pose name='c' on='pack.second.trunk.imu'/>"
      "<box name='beside' size='1 1 1' static='true' frame='dog.trunk.imu' xyz='0 9 0'/>"
      "<instance of='Dog' name='rider' at='dog.trunk.imu' xyz='0 0 7'/>"
      "<frame name='tip' frame='dog.nose'/>"
      "<measure name='height' signal='dog.trunk.imu.z - dog.trunk.z'/>");
  const int trunk = find_body(*model, "dog.trunk");
  CHECK(sensor(*model, "a").body == trunk);
  CHECK(near(sensor(*model, "a").X_BS.p, Vec3(0, 0, 0.5)));
  CHECK(sensor(*model, "b").body == trunk);
  CHECK(near(sensor(*model, "b").X_BS.p, Vec3(1, 0, 0.5)));
  CHECK(sensor(*model, "c").body == find_body(*model, "pack.second.trunk"));
  CHECK(sensor(*model, "pack.inner").body == find_body(*model, "pack.second.trunk"));
  CHECK(near(model->bodies[find_body(*model, "beside")].X_WB.p, Vec3(0, 9, 3.5)));
  CHECK(near(model->bodies[find_body(*model, "rider.trunk")].X_WB.p, Vec3(0, 0, 10.5)));
  const auto tip = std::find_if(model->frames.begin(), model->frames.end(),
                                [](const NamedFrame& f) { return f.name == "tip"; });
  REQUIRE(tip != model->frames.end());
  CHECK(tip->body == trunk);  // it moves with the body that its frame is in
}
