// Regions, templates and rules in the compiled model.
#include "build_support.h"
#include "fake_catalog.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("regions have a pose, a shape and a list of bodies", "[events]") {
  const auto model = compile_scene(R"xml(
    <assembly name="bot" xyz="1 0 0"> <box name="hull" size="1 1 1" mass="1"/>
      <region name="near" radius="2 m" xyz="0 1 0" frame="hull"/> </assembly>
    <box name="crate" size="1 1 1" mass="1" xyz="0 0 5"/>
    <region name="goal" xyz="1 2 3" size="1 2 3" who="bot crate"/>
  )xml");
  REQUIRE(model->regions.size() == 2);
  const RegionModel& near_bot = model->regions[0];
  CHECK(near_bot.name == "bot.near");
  CHECK(near_bot.type == RegionModel::Type::sphere);
  CHECK(near_bot.radius == 2.0);
  CHECK(near_bot.body == 0);
  CHECK(near(near_bot.X_BR.p, Vec3(0, 1, 0)));
  CHECK(near_bot.who.empty());
  const RegionModel& goal = model->regions[1];
  CHECK(goal.body == kWorld);
  CHECK(near(goal.X_BR.p, Vec3(1, 2, 3)));
  CHECK(near(goal.size, Vec3(1, 2, 3)));
  CHECK(goal.who == std::vector<std::string>{"bot", "crate"});
}

TEST_CASE("a template is a scene of its own that can use the scene's materials", "[events]") {
  const auto model = compile_scene(R"xml(
    <material name="ice" friction="0.1"/>
    <box name="ball" size="1 1 1" mass="1" material="ice"/>
    <template name="Pair"> <material name="own" friction="0.9"/>
      <sphere name="ball" radius="5 cm" material="ice" xyz="0 0 1"/>
      <sphere name="other" radius="5 cm" material="own"/>
      <hinge name="knee" parent="ball" child="other"/> </template>
  )xml");
  CHECK(model->bodies.size() == 1);
  REQUIRE(model->templates.size() == 1);
  CHECK(model->templates[0].name == "Pair");
  const SceneModel& inside = *model->templates[0].fragment;
  REQUIRE(inside.bodies.size() == 2);
  CHECK(inside.bodies[0].name == "ball");
  CHECK(near(inside.bodies[0].X_WB.p, Vec3(0, 0, 1)));
  CHECK(inside.joints.size() == 1);
  const auto material = [&](int body) {
    const Shape& shape = inside.bodies[body].shapes[0];
    return inside.materials[shape.material];
  };
  CHECK(material(0).name == "ice");
  CHECK(material(0).friction == 0.1);
  CHECK(material(1).friction == 0.9);
}

TEST_CASE("rules and their actions are read with names in full", "[events]") {
  const auto model = compile_scene(R"xml(
    <assembly name="bot" xyz="0 0 1"> <box name="hull" size="1 1 1" mass="1"/>
      <box name="arm" size="1 1 1" mass="1" xyz="3 0 0"/>
      <slider name="lift" parent="hull" child="arm"/> <motor name="m" joint="lift"/>
      <encoder name="e" joint="lift"/> </assembly>
    <region name="goal" size="1 1 1"/>
    <frame name="here" xyz="1 2 3"/>
    <template name="Ball"> <sphere name="ball" radius="5 cm"/> </template>
    <on event="enter( goal , bot )" if="bot.arm.x gt 10 cm" after="500 ms" limit="1">
      <spawn of="Ball" at="here" xyz="0 0 5 cm" clearance="2 cm" lifetime="3 s"/>
      <spawn of="Ball" name="late" in="here bot.hull"/>
      <remove name="late"/> <remove name="Ball_1"/>
      <attach name="grip" parent="bot.arm" child="late.ball" type="hinge" axis="0 1 0"
        point="1 0 0" reach="2 cm"/>
      <detach joint="grip"/>
      <limit joint="bot.lift" lower="none" upper="80 cm"/>
      <make-static name="bot"/> <make-dynamic name="bot.arm"/>
      <drive motor="bot.m" target="20 cm/s"/>
      <switch sensor="bot.e" on="false"/>
      <raise event="ready"/> <log message="hello"/> <end reason="done"/>
    </on>
    <on name="clock" time="1 s" every="2 s"> <raise event="tick" message="tock"/> </on>
    <on event="raised(anything)"> <log message="x"/> </on>
    <on when="late.ball.x gt 0 m"> <log message="y"/> </on>
  )xml");
  REQUIRE(model->rules.size() == 4);
  const RuleModel& rule = model->rules[0];
  CHECK(rule.kind == "enter");
  CHECK(rule.source == "goal");
  CHECK(rule.subject == "bot");
  CHECK(rule.after == 0.5);
  CHECK(rule.limit == 1);
  CHECK_FALSE(rule.time);
  CHECK(rule.when.find("bot.arm.x") != std::string::npos);
  REQUIRE(rule.actions.size() == 14);
  const auto& spawn = std::get<Spawn>(rule.actions[0]);
  CHECK(spawn.of == "Ball");
  CHECK(spawn.name.empty());
  CHECK(near(spawn.pose.p, Vec3(1, 2, 3.05)));
  CHECK(spawn.clearance == 0.02);
  CHECK(spawn.lifetime == 3.0);
  const auto& among = std::get<Spawn>(rule.actions[1]);
  REQUIRE(among.candidate_poses.size() == 2);
  CHECK(near(among.candidate_poses[1].p, Vec3(0, 0, 1)));
  CHECK(near(among.pose.p, Vec3::Zero()));
  const auto& attach = std::get<Attach>(rule.actions[4]);
  CHECK(attach.child == "late.ball");
  CHECK(attach.type == Attach::Type::hinge);
  CHECK(near(*attach.point, Vec3(1, 0, 0)));
  CHECK(attach.reach == 0.02);
  const auto& limits = std::get<SetJointLimits>(rule.actions[6]);
  CHECK(std::isinf(*limits.lower));
  CHECK(*limits.upper == 0.8);
  CHECK(std::get<SetStatic>(rule.actions[7]).on);
  CHECK_FALSE(std::get<SetStatic>(rule.actions[8]).on);
  CHECK(std::get<SetMotor>(rule.actions[9]).target == 0.2);
  CHECK_FALSE(std::get<EnableSensor>(rule.actions[10]).on);
  CHECK(model->rules[1].name == "clock");
  CHECK(*model->rules[1].time == 1.0);
  CHECK(*model->rules[1].every == 2.0);
  // Names of objects that do not exist yet are left as written.
  CHECK(model->rules[3].when == "late.ball.x gt 0 m");
}

TEST_CASE("a rule opens a maze's door and spawns into its free cells", "[events]") {
  const auto model = compile_scene(R"xml(
    <maze name="walls" cell="50 cm" thickness="2 cm" height="30 cm" xyz="1 0 0">
      +--+--+
      |S  T1|
      +--+AA+
      |    G|
      +--+--+
    </maze>
    <plane name="floor"/>
    <sphere name="bot" radius="5 cm" xyz="1.25 0.75 0.05"/>
    <template name="Ball"> <sphere radius="5 cm" xyz="0 0 5 cm"/> </template>
    <on event="enter(walls.T1, bot)"> <open door="walls.A"/> </on>
    <on every="1 s"> <spawn of="Ball" in="walls.free"/> <spawn of="Ball" in="walls walls.G"/> </on>
  )xml");
  REQUIRE(model->rules.size() == 2);
  CHECK(model->rules[0].source == "walls.T1");
  CHECK(std::get<MoveDoor>(model->rules[0].actions[0]).door == "walls.A");
  const auto& free = std::get<Spawn>(model->rules[1].actions[0]);
  REQUIRE(free.candidate_poses.size() == 1);  // the cell in the south-west
  CHECK(near(free.candidate_poses[0].p, Vec3(1.25, 0.25, 0)));
  const auto& all = std::get<Spawn>(model->rules[1].actions[1]);
  REQUIRE(all.candidate_poses.size() == 5);
  CHECK(near(all.candidate_poses[4].p, Vec3(1.75, 0.25, 0)));
}

TEST_CASE("rules in a prototype refer to the elements beside them", "[events]") {
  const auto model = compile_scene(R"xml(
    <prototype name="Trap"> <box name="lid" size="1 1 1" mass="1"/>
      <region name="zone" size="1 1 1"/>
      <on name="snap" event="enter(zone)"> <make-static name="lid"/> </on> </prototype>
    <instance of="Trap" name="a"/> <instance of="Trap" name="b" xyz="5 0 0"/>
  )xml");
  REQUIRE(model->rules.size() == 2);
  CHECK(model->rules[1].name == "b.snap");
  CHECK(model->rules[1].source == "b.zone");
  CHECK(std::get<SetStatic>(model->rules[1].actions[0]).body == "b.lid");
}

TEST_CASE("with a supervisor in the scene unknown names are allowed", "[events]") {
  CHECK(codes_of("<box name=\"a\" size=\"1 1 1\" mass=\"1\"/>"
                 "<on event=\"added(guest)\"> <make-static name=\"guest\"/> </on>") ==
        "CG1302 CG1302");
  CHECK(codes_of("<box name=\"a\" size=\"1 1 1\" mass=\"1\"/> <supervisor plugin=\"referee\"/>"
                 "<on event=\"added(guest)\"> <make-static name=\"guest\"/> </on>") ==
        "CG2030 CG2030");
  // A warning, so that it runs; announced names give none.
  const std::string with =
      "<box name=\"a\" size=\"1 1 1\" mass=\"1\"/> "
      "<supervisor plugin=\"referee\"/>";
  const auto model = compile_scene(with +
                                   "<on event=\"added(guest)\" if=\"guest.z gt 1 m\"> "
                                   "<make-static name=\"guest.arm\"/> </on>");
  REQUIRE(model->rules.size() == 1);
  CHECK(model->rules[0].source == "guest");
  CHECK(model->rules[0].when == "guest.z gt 1 m");
  CHECK(codes_of(with + "<region name=\"goal\" radius=\"1 m\" who=\"guest\" added=\"guest\"/>"
                        "<on added=\"box guest\" event=\"added(guest)\" if=\"guest.z gt 1 m\"> "
                        "<make-static name=\"guest.arm\"/> </on>") == "");
  CHECK(codes_of(with +
                 "<on added=\"guest\" when=\"gest.z gt 1 m\"> <make-static name=\"guests\"/> "
                 "</on>") == "CG2030 CG2030");
  // Bad grammar stays an error, and so does something of another kind.
  CHECK(codes_of(with + "<on when=\"a.z gt\"> <make-static name=\"a\"/> </on>") == "CG1308");
  CHECK(codes_of(with + "<on time=\"1 s\"> <drive motor=\"a\" target=\"1\"/> </on>") == "CG1302");
}
