// Editing a scene's text: each operation with the exact text it must give.
#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "cogrsim/dsl/edit.h"
#include "cogrsim/dsl/schema.h"
#include "cogrsim/model/mass_properties.h"

using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

const char* const kScene = R"(<?xml version="1.0" encoding="UTF-8"?>
<!-- what it is about -->
<scene name="desk" version="1">
  <material name="wood" density="600 kg/m^3"/>

  <!-- the ground -->
  <plane name="floor" material="wood"/>   <!-- at 0 -->
  <box   name="crate" size="40 40 40 cm"
         xyz="0 0 20 cm" material="wood"/>
  <assembly name="arm" xyz="1 0 0">
    <box name="upper" size="0.1 0.1 0.1" xyz="0 0 1"/>
    <box name="lower" size="0.1 0.1 0.1" xyz="0 0 0.5"/>
    <hinge name="elbow" parent="upper" child="lower" axis="0 1 0"/>
    <motor name="drive" joint="elbow"/>
    <camera name="eye" on="lower"/>
  </assembly>
  <hinge name="shoulder" child="arm.upper" axis="0 1 0"/>
  <plot name="path" y="arm.lower.z - crate.z"/>
  <test name="stays">
    <always that="arm.elbow.position gt -5 rad and distance(arm.upper, crate) gt 0"/>
  </test>
</scene>
)";

int id_of(const std::string& text, const std::string& tag, const std::string& name) {
  for (const OutlineElement& e : outline_text(text, "t.scene.xml"))
    if (e.tag == tag && e.name == name) return e.id;
  FAIL("no " << tag << " " << name);
  return -1;
}

std::string edited(const std::string& text, const std::vector<EditOperation>& operations) {
  const auto made = edit_text(text, "t.scene.xml", operations);
  INFO((made ? std::string() : made.error().text()));
  REQUIRE(made);
  return made->text;
}

std::string refused(const std::string& text, const std::vector<EditOperation>& operations) {
  const auto made = edit_text(text, "t.scene.xml", operations);
  REQUIRE_FALSE(made);
  return made.error().text();
}

/// `text` with one part of it replaced.
std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  INFO(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

SceneModelPtr model_of(const std::string& text) {
  const CompileResult result = compile_text(text, "t.scene.xml");
  INFO(to_text(result.diagnostics));
  REQUIRE(result.ok());
  return result.model;
}

const Body& body(const SceneModel& model, const std::string& name) {
  const int i = find_body(model, name);
  INFO(name);
  REQUIRE(i >= 0);
  return model.bodies[i];
}

}  // namespace

TEST_CASE("an outline lists every element with its lines", "[edit]") {
  const OutlinedScene scene = compile_outlined(kScene, "t.scene.xml");
  REQUIRE(scene.result.ok());
  const auto& crate = scene.elements[static_cast<std::size_t>(id_of(kScene, "box", "crate"))];
  CHECK(crate.line == 8);
  CHECK(crate.column == 3);
  CHECK(crate.end_line == 9);
  CHECK(crate.path == "crate");
  CHECK(crate.single);
  const auto& lower = scene.elements[static_cast<std::size_t>(id_of(kScene, "box", "lower"))];
  CHECK(lower.path == "arm.lower");
  CHECK(lower.parent == id_of(kScene, "assembly", "arm"));
  const int i = find_body(*scene.result.model, "arm.lower");
  CHECK(scene.origins.bodies[i].element == lower.id);
  CHECK(scene.origins.bodies[i].own);
  CHECK(scene.origins.motors.at(0).element == id_of(kScene, "motor", "drive"));
  CHECK(scene.origins.plots.at(0).element == id_of(kScene, "plot", "path"));
}

TEST_CASE("objects of a repeat are not single", "[edit]") {
  const std::string text =
      "<scene><repeat count=\"2\" var=\"i\"><sphere name=\"s_${i}\" radius=\"1\" xyz=\"${3 m * i} "
      "0 0\"/>"
      "</repeat></scene>";
  const OutlinedScene scene = compile_outlined(text, "t.scene.xml");
  INFO(to_text(scene.result.diagnostics));
  REQUIRE(scene.result.ok());
  REQUIRE(scene.origins.bodies.size() == 2);
  CHECK(scene.origins.bodies[1].element == 2);
  CHECK_FALSE(scene.origins.bodies[1].own);
  CHECK(refused(text, {PlaceElement{2, {}}}).find("<repeat>") != std::string::npos);
}

TEST_CASE("attributes are set in place and added last", "[edit]") {
  const int crate = id_of(kScene, "box", "crate");
  CHECK(edited(kScene, {SetAttribute{crate, "size", "1 1 1"}}) ==
        with(kScene, "size=\"40 40 40 cm\"", "size=\"1 1 1\""));
  CHECK(edited(kScene, {SetAttribute{crate, "mass", "3 kg"}}) ==
        with(kScene, "0 0 20 cm\" material=\"wood\"/>",
             "0 0 20 cm\" material=\"wood\" mass=\"3 kg\"/>"));
  CHECK(edited(kScene, {SetAttribute{crate, "material", std::nullopt}}) ==
        with(kScene, "0 0 20 cm\" material=\"wood\"/>", "0 0 20 cm\"/>"));
  CHECK(refused(kScene, {SetAttribute{crate, "mas", "3 kg"}}).find("'mass'") != std::string::npos);
  CHECK(refused(kScene, {SetAttribute{crate, "mass", "-3 kg"}}).find("mass") != std::string::npos);
  // Characters reserved by XML are escaped.
  const std::string titled = edited(kScene, {SetAttribute{0, "name", "a<b & \"c\""}});
  CHECK(outline_text(titled, "t")[0].name == "a<b & \"c\"");
}

TEST_CASE("elements are inserted on lines of their own", "[edit]") {
  const int crate = id_of(kScene, "box", "crate"), arm = id_of(kScene, "assembly", "arm");
  CHECK(
      edited(kScene,
             {InsertElement{0, "<sphere name=\"crate\" radius=\"1 cm\" xyz=\"0 0 9\"/>", crate}}) ==
      with(kScene, "  <box   name=\"crate\"",
           "  <sphere name=\"crate_2\" radius=\"1 cm\" xyz=\"0 0 9\"/>\n  <box   name=\"crate\""));
  CHECK(edited(kScene, {InsertElement{arm, "<frame name=\"tip\"/>", std::nullopt}}) ==
        with(kScene, "    <camera name=\"eye\" on=\"lower\"/>\n",
             "    <camera name=\"eye\" on=\"lower\"/>\n    <frame name=\"tip\"/>\n"));
  // Several lines are indented together, an empty parent is opened.
  const std::string body = edited(kScene, {InsertElement{0,
                                                         "<body name=\"b\" xyz=\"0 0 5\">\n"
                                                         "  <box size=\"1 1 1\"/>\n</body>",
                                                         arm}});
  CHECK(body == with(kScene, "  <assembly name=\"arm\"",
                     "  <body name=\"b\" xyz=\"0 0 5\">\n    <box size=\"1 1 1\"/>\n  </body>\n"
                     "  <assembly name=\"arm\""));
  CHECK(edited("<scene/>", {InsertElement{0, "<box name=\"b\" size=\"1 1 1\"/>", {}}}) ==
        "<scene>\n  <box name=\"b\" size=\"1 1 1\"/>\n</scene>");
  CHECK(edited("<scene>\r\n\t<plane/>\r\n</scene>\r\n",
               {InsertElement{0, "<frame name=\"f\"/>", {}}}) ==
        "<scene>\r\n\t<plane/>\r\n\t<frame name=\"f\"/>\r\n</scene>\r\n");
  // Before an element means before the comment that explains it.
  CHECK(
      edited(kScene, {InsertElement{0, "<frame name=\"f\"/>", id_of(kScene, "plane", "floor")}}) ==
      with(kScene, "  <!-- the ground -->", "  <frame name=\"f\"/>\n  <!-- the ground -->"));
  CHECK(refused(kScene, {InsertElement{0, "<a/><b/>", {}}}).find("second root") !=
        std::string::npos);
  CHECK(refused(kScene, {InsertElement{0, "<motor joint=\"nope\"/>", {}}}).find("nope") !=
        std::string::npos);
}

TEST_CASE("elements that refer to a removed one are removed, too", "[edit]") {
  // Its hinge, the motor of that hinge, its camera, the plot and the expectation.
  const std::string less = edited(kScene, {RemoveElements{{id_of(kScene, "box", "lower")}}});
  std::string expected =
      with(kScene, "    <box name=\"lower\" size=\"0.1 0.1 0.1\" xyz=\"0 0 0.5\"/>\n", "");
  expected =
      with(expected,
           "    <hinge name=\"elbow\" parent=\"upper\" child=\"lower\" axis=\"0 1 0\"/>\n", "");
  expected = with(expected, "    <motor name=\"drive\" joint=\"elbow\"/>\n", "");
  expected = with(expected, "    <camera name=\"eye\" on=\"lower\"/>\n", "");
  expected = with(expected, "  <plot name=\"path\" y=\"arm.lower.z - crate.z\"/>\n", "");
  expected = with(expected,
                  "  <test name=\"stays\">\n    <always that=\"arm.elbow.position gt -5 rad and "
                  "distance(arm.upper, crate) gt 0\"/>\n  </test>\n",
                  "");
  CHECK(less == expected);
  // A comment on the same line stays, on its own.
  CHECK(edited(kScene, {RemoveElements{{id_of(kScene, "plane", "floor")}}}) ==
        with(kScene, "  <plane name=\"floor\" material=\"wood\"/>   <!-- at 0 -->",
             "  <!-- at 0 -->"));
  // Without its material an element has the default one.
  const std::string bare = edited(kScene, {RemoveElements{{id_of(kScene, "material", "wood")}}});
  CHECK(bare.find("wood") == std::string::npos);
  CHECK(model_of(bare)->bodies.size() == 4);
}

TEST_CASE("references follow a new name", "[edit]") {
  const std::string text = edited(kScene, {RenameElement{id_of(kScene, "assembly", "arm"), "leg"}});
  std::string expected = with(kScene, "name=\"arm\"", "name=\"leg\"");
  expected = with(expected, "child=\"arm.upper\"", "child=\"leg.upper\"");
  expected = with(expected, "y=\"arm.lower.z", "y=\"leg.lower.z");
  expected = with(expected, "\"arm.elbow", "\"leg.elbow");
  expected = with(expected, "distance(arm.upper", "distance(leg.upper");
  CHECK(text == expected);
  CHECK(edited(text, {RenameElement{id_of(text, "assembly", "leg"), "arm"}}) == kScene);
  const std::string part = edited(kScene, {RenameElement{id_of(kScene, "box", "upper"), "top"}});
  CHECK(part.find("upper") == std::string::npos);
  CHECK(part.find("parent=\"top\"") != std::string::npos);
  CHECK(part.find("child=\"arm.top\"") != std::string::npos);
  const std::string wood =
      edited(kScene, {RenameElement{id_of(kScene, "material", "wood"), "oak"}});
  CHECK(wood.find("\"wood\"") == std::string::npos);
  CHECK(refused(kScene, {RenameElement{id_of(kScene, "box", "upper"), "lower"}}).find("taken") !=
        std::string::npos);
  CHECK(refused(kScene, {RenameElement{id_of(kScene, "box", "upper"), "a.b"}}).find("cannot be") !=
        std::string::npos);
  // A nearer element of the new name would capture a reference.
  const std::string hidden =
      "<scene><box name=\"a\" size=\"1 1 1\"/><assembly name=\"g\" xyz=\"0 0 5\">"
      "<box name=\"b\" size=\"1 1 1\"/><camera name=\"c\" on=\"a\"/></assembly></scene>";
  CHECK(refused(hidden, {RenameElement{id_of(hidden, "box", "b"), "a"}}).find("mean something") !=
        std::string::npos);
}

TEST_CASE("names in rules regions and prototypes follow", "[edit]") {
  const std::string text = R"x(<scene>
  <prototype name="Bot">
    <assembly name="robot"><box name="deck" size="1 1 1"/><frame name="f" xyz="0 0 1"/></assembly>
    <export name="tip" of="robot.f"/>
  </prototype>
  <instance of="Bot" name="bot" xyz="0 0 3"/>
  <region name="goal" size="1 1 1" who="bot.robot bot.robot.deck"/>
  <on event="enter(goal, bot.robot)" if="bot.tip.x gt 0"><end reason="bot.robot is there"/></on>
  <plot y="distance(bot.robot, goal_post)"/>
  <box name="goal_post" size="1 1 1" xyz="9 0 0"/>
</scene>
)x";
  const std::string bot = edited(text, {RenameElement{id_of(text, "instance", "bot"), "rover"}});
  CHECK(bot.find("who=\"rover.robot rover.robot.deck\"") != std::string::npos);
  CHECK(bot.find("enter(goal, rover.robot)") != std::string::npos);
  CHECK(bot.find("if=\"rover.tip.x gt 0\"") != std::string::npos);
  CHECK(bot.find("reason=\"bot.robot is there\"") != std::string::npos);  // prose
  CHECK(bot.find("distance(rover.robot, goal_post)") != std::string::npos);
  const std::string robot =
      edited(text, {RenameElement{id_of(text, "assembly", "robot"), "body_1"}});
  CHECK(robot.find("of=\"body_1.f\"") != std::string::npos);
  CHECK(robot.find("who=\"bot.body_1 bot.body_1.deck\"") != std::string::npos);
  const std::string goal = edited(text, {RenameElement{id_of(text, "region", "goal"), "target"}});
  CHECK(goal.find("enter(target, bot.robot)") != std::string::npos);
  CHECK(goal.find("goal_post\"") != std::string::npos);
  const std::string kind = edited(text, {RenameElement{id_of(text, "prototype", "Bot"), "Rover"}});
  CHECK(kind.find("of=\"Rover\"") != std::string::npos);
  const std::string tip = edited(text, {RenameElement{id_of(text, "export", "tip"), "end"}});
  CHECK(tip.find("bot.end.x gt 0") != std::string::npos);
}

TEST_CASE("poses are written in the existing units", "[edit]") {
  const int crate = id_of(kScene, "box", "crate");
  Pose pose;
  pose.p = {0.5, -0.1234567, 0.2};
  CHECK(edited(kScene, {PlaceElement{crate, pose}}) ==
        with(kScene, "xyz=\"0 0 20 cm\"", "xyz=\"50 -12.3457 20 cm\""));
  // Inside an assembly: relative to it; a turn is written in degrees.
  const int lower = id_of(kScene, "box", "lower");
  pose.p = {1.0, 0.25, 0.5};
  pose.q = Quat(Eigen::AngleAxisd(M_PI / 6, Vec3::UnitZ()));
  CHECK(edited(kScene, {PlaceElement{lower, pose}}) ==
        with(kScene, "xyz=\"0 0 0.5\"/>", "xyz=\"0 0.25 0.5\" rpy=\"0 0 30 deg\"/>"));
  // In radians where radians are written; each entry in its own unit.
  const std::string mixed =
      "<scene><box name=\"b\" size=\"1 1 1\" xyz=\"1 m 2 cm 3 mm\" "
      "rpy=\"0 0 1 rad\"/></scene>";
  pose.p = {0.5, 0.5, 0.5};
  pose.q = Quat(Eigen::AngleAxisd(0.25, Vec3::UnitX()));
  CHECK(edited(mixed, {PlaceElement{1, pose}}) ==
        with(with(mixed, "1 m 2 cm 3 mm", "0.5 m 50 cm 500 mm"), "0 0 1 rad", "0.25 0 0 rad"));
  const std::string made =
      "<scene><param name=\"h\" default=\"1 m\"/>"
      "<box name=\"b\" size=\"1 1 1\" xyz=\"0 0 ${h}\"/></scene>";
  CHECK(refused(made, {PlaceElement{2, pose}}).find("expression") != std::string::npos);
  pose.p.x() = std::nan("");
  CHECK(refused(kScene, {PlaceElement{crate, pose}}).find("not a pose") != std::string::npos);
}

TEST_CASE("a placed element has the requested pose", "[edit]") {
  // Every notation of an orientation, in a frame that is rotated itself.
  const std::string text = R"(<scene>
  <frame name="f" xyz="1 2 3" rpy="10 20 30 deg"/>
  <box name="a" size="1 1 1" frame="f" rpy="5 5 5 deg"/>
  <box name="b" size="1 1 1" frame="f" quat="1 0 0 0" xyz="5 0 0"/>
  <light name="l" frame="f" direction="1 0 0"/>
  <view name="v" frame="f" xyz="-1 0 0" look-at="0 0 0"/>
  <assembly name="arm" xyz="9 0 0" rpy="0 0 90 deg">
    <box name="rod" size="1 1 1" xyz="0 0 -1"/>
    <hinge name="h" child="rod" axis="0 1 0" position="30 deg"/>
  </assembly>
</scene>
)";
  Pose pose;
  pose.p = {0.3, -7.0, 4.0};
  pose.q = Quat(0.8, 0.2, -0.4, 0.1).normalized();
  const auto difference = [](const Pose& a, const Pose& b) {
    return (a.p - b.p).norm() + a.q.angularDistance(b.q);
  };
  // Three coordinates and three angles, each within 5e-7.
  const double tolerance = 6 * 5e-7;
  for (const char* name : {"a", "b", "arm.rod"}) {
    const std::string tag = "box",
                      last = std::string(name).substr(std::string(name).rfind('.') + 1);
    const auto model = model_of(edited(text, {PlaceElement{id_of(text, tag, last), pose}}));
    INFO(name);
    CHECK(difference(body(*model, name).X_WB, pose) < tolerance);
  }
  const auto lit = model_of(edited(text, {PlaceElement{id_of(text, "light", "l"), pose}}));
  CHECK((lit->lights[0].X_WL.q * Vec3::UnitX() - pose.q * Vec3::UnitX()).norm() < tolerance);
  CHECK((lit->lights[0].X_WL.p - pose.p).norm() < tolerance);
  const auto seen = model_of(edited(text, {PlaceElement{id_of(text, "view", "v"), pose}}));
  CHECK(difference(seen->views[0].X_WV, pose) < tolerance);
}

TEST_CASE("moving keeps the pose and the references", "[edit]") {
  const int crate = id_of(kScene, "box", "crate"), arm = id_of(kScene, "assembly", "arm");
  const std::string text = edited(kScene, {MoveElement{crate, arm, std::nullopt, true}});
  CHECK(text == with(with(with(with(kScene,
                                    "  <box   name=\"crate\" size=\"40 40 40 cm\"\n"
                                    "         xyz=\"0 0 20 cm\" material=\"wood\"/>\n",
                                    ""),
                               "    <camera name=\"eye\" on=\"lower\"/>\n",
                               "    <camera name=\"eye\" on=\"lower\"/>\n"
                               "    <box   name=\"crate\" size=\"40 40 40 cm\"\n"
                               "           xyz=\"-100 0 20 cm\" material=\"wood\"/>\n"),
                          "- crate.z", "- arm.crate.z"),
                     "distance(arm.upper, crate)", "distance(arm.upper, arm.crate)"));
  CHECK(body(*model_of(text), "arm.crate").X_WB.p.isApprox(Vec3(0, 0, 0.2), 1e-12));
  // Without keeping its pose the written pose holds.
  const std::string loose = edited(kScene, {MoveElement{crate, arm, std::nullopt, false}});
  CHECK(body(*model_of(loose), "arm.crate").X_WB.p.isApprox(Vec3(1, 0, 0.2), 1e-12));
  CHECK(refused(kScene, {MoveElement{arm, arm, std::nullopt, true}}).find("into itself") !=
        std::string::npos);
  // Comments above move along.
  const std::string ground =
      edited(kScene, {MoveElement{id_of(kScene, "plane", "floor"), 0, arm, true}});
  CHECK(ground.find("material=\"wood\"/>\n  <!-- the ground -->\n  <plane name=\"floor\" "
                    "material=\"wood\"/>\n  <assembly") != std::string::npos);
}

TEST_CASE("a copy has its own name and its own content", "[edit]") {
  const std::string text =
      edited(kScene, {DuplicateElement{id_of(kScene, "assembly", "arm"), Vec3(0, 1, 0)}});
  CHECK(text.find("  <assembly name=\"arm_2\" xyz=\"1 1 0\">\n    <box name=\"upper\"") !=
        std::string::npos);
  const auto model = model_of(text);
  CHECK(model->bodies.size() == 6);
  const Joint& elbow = model->joints[static_cast<std::size_t>(find_joint(*model, "arm_2.elbow"))];
  CHECK(elbow.parent == find_body(*model, "arm_2.upper"));
  // References by full name refer to the copy.
  const std::string self =
      "<scene>\n  <assembly name=\"a\"><box name=\"b\" size=\"1 1 1\"/>"
      "<camera name=\"c\" on=\"a.b\" xyz=\"2 0 0\"/></assembly>\n</scene>";
  CHECK(edited(self, {DuplicateElement{1, Vec3::Zero()}})
            .find("<assembly name=\"a_2\"><box name=\"b\" size=\"1 1 1\"/>"
                  "<camera name=\"c\" on=\"a_2.b\" xyz=\"2 0 0\"/>") != std::string::npos);
}

namespace {
const char* const kTable = R"(<scene>
  <material name="oak" density="700 kg/m^3"/>
  <plane name="floor"/>
  <!-- the top -->
  <box name="top" size="80 60 4 cm" xyz="1 0 0.72" rpy="0 0 20 deg" material="oak"/>
  <box name="left" size="4 60 70 cm" xyz="0.6 0 0.35" mass="3 kg"/>
  <cylinder name="right" radius="3 cm" length="0.7" xyz="1.4 0 0.35"/>
  <camera name="eye" on="top" xyz="0 0 0.1"/>
  <hinge name="lid" parent="left" child="flap"/>
  <box name="flap" size="10 10 1 cm" xyz="0 1 0.35"/>
</scene>
)";
}

TEST_CASE("assembled parts are one body of the same mass", "[edit]") {
  const std::vector<int> parts = {id_of(kTable, "box", "top"), id_of(kTable, "box", "left"),
                                  id_of(kTable, "cylinder", "right")};
  const std::string text = edited(kTable, {AssembleElements{parts, "table", ""}});
  CHECK(text == R"(<scene>
  <material name="oak" density="700 kg/m^3"/>
  <plane name="floor"/>
  <assembly name="table" rigid="true" xyz="1 0 0.72">
    <!-- the top -->
    <box name="top" size="80 60 4 cm" rpy="0 0 20 deg" material="oak"/>
    <box name="left" size="4 60 70 cm" xyz="-0.4 0 -0.37" mass="3 kg"/>
    <cylinder name="right" radius="3 cm" length="0.7" xyz="0.4 0 -0.37"/>
  </assembly>
  <camera name="eye" on="table.top" xyz="0 0 0.1"/>
  <hinge name="lid" parent="table.left" child="flap"/>
  <box name="flap" size="10 10 1 cm" xyz="0 1 0.35"/>
</scene>
)");
  const auto before = model_of(kTable), after = model_of(text);
  std::vector<MassProperties> bodies;
  for (const char* name : {"top", "left", "right"}) {
    const Body& b = body(*before, name);
    const Mat3 R = b.X_WB.q.toRotationMatrix();
    bodies.push_back({b.mass, b.X_WB * b.com, R * b.inertia * R.transpose()});
  }
  const MassProperties sum = combine(bodies);
  const Body& table = body(*after, "table");
  const Mat3 R = table.X_WB.q.toRotationMatrix();
  CHECK(table.mass == Approx(sum.mass).epsilon(1e-12));
  CHECK((table.X_WB * table.com - sum.com).norm() < 1e-9);
  CHECK((R * table.inertia * R.transpose() - sum.inertia).norm() < 1e-9 * sum.inertia.norm());
  for (std::size_t i = 0; i < 3; ++i) {
    const Body& b = body(*before, i == 0 ? "top" : i == 1 ? "left" : "right");
    const Pose X_WS = table.X_WB * table.shapes[i].X_BS;
    CHECK((X_WS.p - b.X_WB.p).norm() < 1e-9);
    CHECK(X_WS.q.angularDistance(b.X_WB.q) < 1e-9);
  }
  // Dissolved again: everything has its old pose.
  const std::string dissolved =
      edited(text, {DisassembleElement{id_of(text, "assembly", "table")}});
  const auto again = model_of(dissolved);
  for (const Body& b : before->bodies) {
    const Body& other = body(*again, b.name);
    CHECK((other.X_WB.p - b.X_WB.p).norm() < 1e-9);
    CHECK(other.X_WB.q.angularDistance(b.X_WB.q) < 1e-9);
    CHECK(other.mass == Approx(b.mass).epsilon(1e-12));
  }
  CHECK(dissolved.find("<!-- the top -->\n  <box name=\"top\"") != std::string::npos);
}

TEST_CASE("an assembly can share a material", "[edit]") {
  const std::string text = edited(
      kTable,
      {AssembleElements{
          {id_of(kTable, "box", "left"), id_of(kTable, "cylinder", "right")}, "legs", "oak"}});
  CHECK(text.find("mass=\"3 kg\" material=\"oak\"/>") != std::string::npos);
  CHECK(text.find("xyz=\"0.8 0 0\" material=\"oak\"/>") != std::string::npos);
}

TEST_CASE("parts that cannot be one body are refused with a remedy", "[edit]") {
  const auto two = [&](const char* a, const char* ta, const char* b, const char* tb) {
    return AssembleElements{{id_of(kTable, ta, a), id_of(kTable, tb, b)}, "x", ""};
  };
  CHECK(refused(kTable, {two("left", "box", "flap", "box")}).find("remove the joint") !=
        std::string::npos);
  CHECK(refused(kTable, {two("left", "box", "floor", "plane")}).find("ground") !=
        std::string::npos);
  CHECK(refused(kTable, {two("left", "box", "eye", "camera")}).find("cannot be a part") !=
        std::string::npos);
}

TEST_CASE("grouped elements become an assembly and keep their poses", "[edit]") {
  const auto at = [](const char* tag, const char* name) { return id_of(kScene, tag, name); };
  const std::string text = edited(
      kScene, {GroupElements{{at("hinge", "shoulder"), at("assembly", "arm"), at("box", "crate")},
                             "robot"}});
  CHECK(text.find("  <assembly name=\"robot\">\n    <box   name=\"crate\"") != std::string::npos);
  CHECK(text.find("y=\"robot.arm.lower.z - robot.crate.z\"") != std::string::npos);
  CHECK(text.find("rigid") == std::string::npos);
  const SceneModelPtr before = model_of(kScene), after = model_of(text);
  REQUIRE(after->bodies.size() == before->bodies.size());
  for (const char* name : {"arm.upper", "arm.lower", "crate"}) {
    const Pose& was = body(*before, name).X_WB;
    const Pose& is = body(*after, std::string("robot.") + name).X_WB;
    CHECK(is.p == was.p);
    CHECK(is.q.coeffs() == was.q.coeffs());
  }
  // A name that is taken gets a number; elements with different parents are refused.
  CHECK(edited(kScene, {GroupElements{{at("box", "crate")}, "arm"}}).find("name=\"arm_2\"") !=
        std::string::npos);
  CHECK(refused(kScene, {GroupElements{{at("box", "crate"), at("box", "upper")}, "x"}})
            .find("different parents") != std::string::npos);
  CHECK(refused(kScene, {GroupElements{{0}, "x"}}).find("scene itself") != std::string::npos);
  CHECK(refused(kScene, {GroupElements{{}, "x"}}).find("nothing to group") != std::string::npos);
}

TEST_CASE("the mass of an assembly is distributed to its parts", "[edit]") {
  const std::string text =
      "<scene>\n  <assembly name=\"a\" rigid=\"true\" mass=\"6 kg\" xyz=\"0 0 2\" rpy=\"90 0 0 "
      "deg\">\n"
      "    <box name=\"b\" size=\"1 1 1\"/>\n    <box name=\"c\" size=\"1 1 2\" xyz=\"0 0 2\"/>\n"
      "  </assembly>\n  <hinge name=\"h\" child=\"a\" axis=\"0 0 1\"/>\n</scene>\n";
  const std::string dissolved = edited(text, {DisassembleElement{1}});
  const auto model = model_of(dissolved);
  CHECK(body(*model, "b").mass == Approx(2.0));
  CHECK(body(*model, "c").mass == Approx(4.0));
  CHECK((body(*model, "c").X_WB.p - Vec3(0, -2, 2)).norm() < 1e-9);
  CHECK(model->joints.at(0).child == find_body(*model, "b"));
  const Pose X_WM = body(*model, "b").X_WB * model->joints[0].X_CM;
  CHECK((X_WM.p - Vec3(0, 0, 2)).norm() < 1e-9);
}

TEST_CASE("several operations are one edit", "[edit]") {
  const int crate = id_of(kScene, "box", "crate");
  const auto made = edit_text(kScene, "t.scene.xml",
                              {InsertElement{0, "<frame name=\"f\"/>", crate},
                               RenameElement{crate, "chest"}, SetAttribute{crate, "mass", "2 kg"}});
  REQUIRE(made);
  REQUIRE(made->created.size() == 1);
  CHECK(made->scene.elements[made->created[0]].name == "f");
  CHECK(made->text.find("mass=\"2 kg\"") != std::string::npos);
  CHECK_FALSE(edit_text(kScene, "t.scene.xml",
                        {RenameElement{crate, "chest"}, SetAttribute{crate, "mass", "oops"}}));
}

TEST_CASE("broken text must be corrected first", "[edit]") {
  const std::string broken = with(kScene, "</scene>", "");
  CHECK(refused(broken, {SetAttribute{0, "name", "x"}}).find("correct the text first: line 3") !=
        std::string::npos);
  // Well-formed text that does not compile can be corrected by setting attributes.
  const std::string wrong = with(kScene, "joint=\"elbow\"", "joint=\"elbwo\"");
  const int motor = id_of(wrong, "motor", "drive");
  CHECK(refused(wrong, {RenameElement{motor, "x"}}).find("correct the text first: line 14") !=
        std::string::npos);
  const auto renamed = edit_text(wrong, "t.scene.xml", {RenameElement{motor, "x"}});
  REQUIRE_FALSE(renamed);
  CHECK(renamed.error().file == "t.scene.xml");
  CHECK(renamed.error().line == 14);
  CHECK(renamed.error().length == 5);  // elbwo
  CHECK(edited(wrong, {SetAttribute{motor, "joint", "elbow"}}) == kScene);
}

TEST_CASE("hostile texts and ids are refused", "[edit]") {
  CHECK_FALSE(edit_text("", "t", {SetAttribute{0, "name", "x"}}));
  CHECK_FALSE(edit_text(std::string("<scene>\0</scene>", 16), "t", {}));
  CHECK_FALSE(edit_text("<scene name=\"\xff\"/>", "t", {}));
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  CHECK_FALSE(edit_text(deep, "t", {}));
  CHECK(outline_text(deep, "t").empty());
  const int last = 100000;
  CHECK(refused(kScene, {SetAttribute{last, "name", "x"}}).find("no element") != std::string::npos);
  CHECK(refused(kScene, {SetAttribute{-1, "name", "x"}}).find("no element") != std::string::npos);
  CHECK(refused(kScene, {SetAttribute{0, "a b", "x"}}).find("a b") != std::string::npos);
  CHECK(refused(kScene, {SetAttribute{0, "name", "a\x01"}}).find("U+0001") != std::string::npos);
  CHECK(refused(kScene, {RemoveElements{{0}}}).find("scene itself") != std::string::npos);
  CHECK(refused(kScene, {InsertElement{0, "<box", {}}}).find("new element") != std::string::npos);
}

TEST_CASE("numbers are written as short as possible", "[edit]") {
  CHECK(short_number(0.1 + 0.2, 1e-9) == "0.3");
  CHECK(short_number(-1e-9, 1e-6) == "0");
  CHECK(short_number(100.0, 1e-6) == "100");
  CHECK(short_number(1.0 / 3, 5e-7) == "0.333333");
  CHECK(short_number(-2.5, 1e-9) == "-2.5");
}

TEST_CASE("the schema lists the allowed elements and attributes", "[edit][schema]") {
  const auto schema = nlohmann::json::parse(write_schema_json());
  const auto& elements = schema["elements"];
  const auto box = std::find_if(elements.begin(), elements.end(),
                                [](const auto& e) { return e["name"] == "box"; });
  REQUIRE(box != elements.end());
  for (const auto& a : (*box)["attributes"])
    if (a["name"] == "size") {
      CHECK(a["kind"] == "numbers");
      CHECK(a["required"] == true);
      CHECK(a["min_count"] == 3);
      CHECK(a["max_count"] == 3);
      CHECK(a["units"] == nlohmann::json::array({"m"}));
      CHECK(a["above_min"] == true);
    }
  // Every dimension has its list of units.
  for (const auto& e : elements)
    for (const auto& a : e["attributes"])
      for (const auto& unit : a["units"]) {
        INFO(e["name"] << " " << a["name"] << " " << unit);
        CHECK(schema["units"].contains(unit.get<std::string>()));
      }
  CHECK(schema["units"]["rad"][0] == "deg");
  CHECK(schema["units"]["N*m"].size() >= 2);
}
