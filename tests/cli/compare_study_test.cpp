// Repeated comparisons: their statistics, their shaken starts, and when chaos decides.
#include <cmath>
#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cogrsim/model/builder.h"
#include "compare/compare_study.h"
#include "process.h"
#include "compare/shake.h"

using namespace cogrsim;
using namespace cogrsim::cli;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

// Three links that begin upright: a chaotic pendulum. A box beside them falls and rests.
const char* const kTriple = R"(<scene name="triple" version="1">
  <physics step="1 ms" duration="12 s"/>
  <box name="a" size="5 5 50 cm" mass="1 kg" xyz="0 0 5.25"/>
  <box name="b" size="5 5 50 cm" mass="1 kg" xyz="0 0 5.75"/>
  <box name="c" size="5 5 50 cm" mass="1 kg" xyz="0 0 6.25"/>
  <hinge name="one" child="a" xyz="0 0 5" axis="0 1 0"/>
  <hinge name="two" parent="a" child="b" xyz="0 0 5.5" axis="0 1 0" position="30 deg"/>
  <hinge name="three" parent="b" child="c" xyz="0 0 6" axis="0 1 0" position="10 deg"/>
</scene>
)";
const char* const kBall = R"(<scene name="ball" version="1">
  <physics step="1 ms" duration="1 s"/>
  <plane name="floor"/>
  <sphere name="ball" radius="0.1" mass="1 kg" xyz="0 0 0.5"/>
</scene>
)";

/// A folder with both scenes.
struct Room {
  Room() {
    write("triple.scene.xml", kTriple);
    write("ball.scene.xml", kBall);
    write("still.scene.xml",
          "<scene name=\"still\" version=\"1\"><plane name=\"floor\"/></scene>\n");
  }
  void write(const std::string& name, const char* text) const {
    std::ofstream(folder / name) << text;
  }
  std::string read(const std::string& name) const { return read_file(folder / name); }
  /// `cogrsim compare SCENE --backends cogrsim,bullet ARGUMENTS…`
  Outcome compare(const std::string& scene, const std::string& more) const {
    std::vector<std::string> arguments = {"compare", folder / scene, "--backends",
                                          "cogrsim,bullet"};
    std::istringstream in(more);
    for (std::string argument; in >> argument;) {
      arguments.push_back(argument.rfind("out.", 0) == 0 ? folder / argument : argument);
    }
    return cogrsim_run(arguments);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("an estimate has the mean, the deviation and Student's interval", "[cli][compare]") {
  const Estimate five = estimate_of({1, 2, 3, 4, 5});
  CHECK(five.count == 5);
  CHECK(five.mean == Approx(3.0));
  CHECK(*five.deviation == Approx(std::sqrt(2.5)));
  // t for 4 degrees of freedom and 97.5 %: 2.776445 (any table).
  CHECK(*five.half_width == Approx(2.776445 * std::sqrt(2.5 / 5.0)).epsilon(1e-6));
  const Estimate one = estimate_of({7});
  CHECK(one.mean == 7.0);
  CHECK_FALSE(one.deviation);
  CHECK_FALSE(one.half_width);
  CHECK(estimate_of({}).count == 0);
}

TEST_CASE("shaking moves free mechanisms as a whole, coordinates of joints, and nothing else",
          "[cli][compare]") {
  ModelBuilder builder("shaken");
  const auto pose_at = [](double x) { return Pose(Vec3(x, 0, 1), Quat(1, 0, 0, 0)); };
  builder.plane("floor");
  const int a = builder.box("a", Vec3(1, 1, 1), 1.0, pose_at(0));
  const int b = builder.box("b", Vec3(1, 1, 1), 1.0, pose_at(2));
  builder.joint("knee", JointType::hinge, a, b, pose_at(1));
  const int c = builder.box("c", Vec3(1, 1, 1), 1.0, pose_at(9));
  builder.joint("bolt", JointType::fixed, kWorld, c, pose_at(9));
  const SceneModelPtr model = builder.build();
  WorldState start;
  for (const Body& body : model->bodies) {
    start.poses.push_back(body.X_WB);
    start.twists.push_back(body.V_WB);
  }
  start.joint_positions.assign(static_cast<std::size_t>(model->joint_positions), 0.0);
  WorldState one = start, again = start, other = start;
  CHECK(shake(*model, 0.01, 1, one) == 2);
  shake(*model, 0.01, 1, again);
  shake(*model, 0.01, 2, other);
  const auto moved = [&](const WorldState& state, const char* name) -> Vec3 {
    const auto i = static_cast<std::size_t>(find_body(*model, name));
    return state.poses[i].p - start.poses[i].p;
  };
  CHECK(moved(one, "a").norm() > 0.0);
  CHECK(moved(one, "a").norm() <= 0.01);
  CHECK((moved(one, "a") - moved(one, "b")).norm() < 1e-15);
  CHECK(moved(one, "c").norm() == 0.0);
  CHECK(moved(one, "floor").norm() == 0.0);
  CHECK(one.joint_positions[0] != 0.0);
  CHECK(std::fabs(one.joint_positions[0]) <= 0.01);
  CHECK(moved(again, "a") == moved(one, "a"));
  CHECK(moved(other, "a") != moved(one, "a"));
}

TEST_CASE("a comparison of a run with itself shows when chaos decides", "[cli][compare]") {
  const Room room;
  const Outcome chaotic = room.compare("triple.scene.xml", "--chaos --json out.json");
  INFO(chaotic.out << chaotic.err);
  REQUIRE(chaotic.status == 0);
  CHECK_THAT(chaotic.out, Contains("cogrsim, shaken by 1.00 nm"));
  const Json json = Json::parse(room.read("out.json"));
  REQUIRE(json["chaos"]["first_over"].is_number());
  // 1 nm grows to 1 cm: 16 e-foldings, which a fast pendulum of this length needs a second for at least.
  CHECK(json["chaos"]["first_over"] > 1.0);
  CHECK_THAT(chaotic.out, Contains("is chaos, not the engines"));

  const Outcome calm = room.compare("ball.scene.xml", "--chaos");
  INFO(calm.out << calm.err);
  REQUIRE(calm.status == 0);
  CHECK_THAT(calm.out, Contains("stay within") && Contains("come from the engines"));
}

TEST_CASE("repetitions have a mean, a scatter and a table for a paper", "[cli][compare]") {
  const Room room;
  const std::string command = "--seeds 1..4 --shake 1cm --json out.json --table ";
  for (const char* name : {"out.md", "out.tex"}) {
    const Outcome out = room.compare("ball.scene.xml", command + name);
    INFO(out.out << out.err);
    REQUIRE(out.status == 0);
    CHECK_THAT(out.out, Contains("4 repetitions"));
    CHECK_THAT(room.read(name), Contains("ball") && Contains("shaken by 10.0 mm") &&
                                    Contains("seeds 1 2 3 4") && Contains("Bullet"));
  }
  CHECK_THAT(room.read("out.tex"), Contains("\\begin{tabular}") && Contains("\\end{tabular}"));
  const Json study = Json::parse(room.read("out.json"))["study"];
  CHECK(study["seeds"] == Json({1, 2, 3, 4}));
  const Json row = study["bodies"][0];
  CHECK(row["name"] == "ball");
  CHECK(row["max"]["count"] == 4);
  CHECK(row["max"]["deviation"] > 0.0);
  // The same seeds, the same numbers: the tables are CogRSim's own, and are replaced.
  REQUIRE(room.compare("ball.scene.xml", command + "out.md").status == 0);
  CHECK(Json::parse(room.read("out.json"))["study"] == study);
}

TEST_CASE("repetitions that make no sense are refused", "[cli][compare]") {
  const Room room;
  const auto refused = [&](const std::string& scene, const std::string& arguments,
                           const std::string& why) {
    const Outcome out = room.compare(scene, arguments);
    INFO(arguments << "\n" << out.err);
    CHECK(out.status != 0);
    CHECK_THAT(out.err, Contains(why));
  };
  refused("ball.scene.xml", "--seeds 5..1", "5..1");
  refused("ball.scene.xml", "--seeds 1..3 --step 2ms --step 1ms", "two studies");
  refused("ball.scene.xml", "--shake 3deg", "not a length");
  refused("ball.scene.xml", "--shake 0", "not a length");
  refused("ball.scene.xml", "--table out.txt", "neither in .md nor in .tex");
  refused("still.scene.xml", "--shake 1mm", "nothing in this scene can be shaken");
}
