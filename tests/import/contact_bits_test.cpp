// Contact bits and pairs of MJCF.
#include <set>

#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

std::string ball(const std::string& name, const std::string& geoms, int place) {
  return "<body name=\"" + name + "\" pos=\"" + std::to_string(place) + " 0 1\"><freejoint/>" +
         geoms + "</body>";
}

std::string geom(const std::string& bits, const std::string& name = {}) {
  return "<geom size=\"0.1\" " + bits + (name.empty() ? "" : " name=\"" + name + "\"") + "/>";
}

/// Names of the bodies that do not touch, without the robot's.
std::set<std::pair<std::string, std::string>> separated(const SceneModel& model) {
  std::set<std::pair<std::string, std::string>> out;
  const auto name = [&](int body) {
    const std::string& full = model.bodies[body].name;
    return full.substr(full.rfind('.') + 1);
  };
  for (const auto& [a, b] : model.no_collide) out.insert(std::minmax(name(a), name(b)));
  return out;
}

using Pairs = std::set<std::pair<std::string, std::string>>;

}  // namespace

TEST_CASE("bodies of which no geoms may touch are pairs that do not collide", "[mjcf][contact]") {
  Imported in;
  const std::string one = geom(R"(contype="1" conaffinity="0")");
  in.read("<mujoco><worldbody><geom type=\"plane\" size=\"1 1 1\"/>" + ball("a", one, 0) +
              ball("b", one, 1) + ball("c", geom(""), 2) + "</worldbody></mujoco>",
          "m.xml");
  REQUIRE(in.model);
  // a and b have a type and no affinity; the plane and c have both.
  CHECK(separated(*in.model) == Pairs{{"a", "b"}});
  CHECK(in.reports(kExact, "contype and conaffinity", "1 pairs of bodies do not touch"));
}

TEST_CASE("equal bits need no pairs", "[mjcf][contact]") {
  Imported in;
  const std::string two = geom(R"(contype="2" conaffinity="2")");
  in.read("<mujoco><worldbody>" + ball("a", two, 0) + ball("b", two, 1) + "</worldbody></mujoco>",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.model->no_collide.empty());
  CHECK(!in.reports(kExact, "contype"));
}

TEST_CASE("a geom that may touch nothing does not collide", "[mjcf][contact]") {
  Imported in;
  in.read("<mujoco><worldbody>" + ball("a", geom(R"(contype="4" conaffinity="8")"), 0) +
              ball("b", geom(""), 1) + "</worldbody></mujoco>",
          "m.xml");
  REQUIRE(in.model);
  CHECK(!in.body("a").shapes.at(0).collides);
  CHECK(in.body("b").shapes.at(0).collides);
}

TEST_CASE("bodies of which some geoms may touch are approximate", "[mjcf][contact]") {
  Imported in;
  in.read("<mujoco><worldbody>" +
              ball("a", geom("") + geom(R"(contype="1" conaffinity="0" pos="0 0 1")"), 0) +
              ball("b", geom(R"(contype="1" conaffinity="0")"), 1) + "</worldbody></mujoco>",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.model->no_collide.empty());
  CHECK(in.reports(kApproximate, "contype and conaffinity", "in 1 pairs that do"));
}

TEST_CASE("what is not for the ground stays off it where its body's other geoms touch it",
          "[mjcf][contact]") {
  // A foot that stands on a ball, with a box around it for the other foot alone.
  const auto foot = [](const std::string& name, const std::string& ball_bits) {
    return "<body name=\"" + name + "\"><joint/>" + geom(ball_bits) +
           R"(<geom type="box" size="1 1 1" contype="4" conaffinity="4"/></body>)";
  };
  const std::string plane = R"(<geom type="plane" size="1 1 1" conaffinity="2"/>)";
  const auto read = [&](const std::string& ball_bits, const std::string& around) {
    Imported in;
    in.read("<mujoco><worldbody>" + around +
                ball("hip", geom("") + foot("a", ball_bits) + foot("b", ball_bits), 0) +
                "</worldbody></mujoco>",
            "m.xml");
    REQUIRE(in.model);
    const auto& shapes = in.body("a").shapes;
    REQUIRE(shapes.size() == 2);
    CHECK(shapes[1].collides == !in.reports(kApproximate, "contact of a shape of 'a'", "ground"));
    return std::pair(shapes[0].collides, shapes[1].collides);
  };
  const std::string lands = R"(contype="2" conaffinity="1")",
                    box = R"(contype="4" conaffinity="4")";
  CHECK(read(lands, plane) == std::pair(true, false));
  // Without a ground of its own it stands on that of a scene, which has the usual bits.
  CHECK(read(lands, "") == std::pair(true, false));
  // Nothing of the foot is for the ground: the pairs of bodies say all.
  CHECK(read(box, plane) == std::pair(true, true));
  // The boxes are for something beside the robot, too, which they shall push.
  CHECK(read(lands, plane + ball("cube", geom(box), 3)) == std::pair(true, true));
}

TEST_CASE("few iterations of a later MuJoCo are the usual number", "[mjcf][option]") {
  const auto read = [](const std::string& option) {
    Imported in;
    in.options.scene_folder = in.folder.path.string();
    in.result = dsl::import_model(
        in.folder.write("m.xml", "<mujoco><option " + option +
                                     R"(/><worldbody><body><freejoint/><geom size="1"/></body>
      </worldbody></mujoco>)"),
        in.options);
    const bool written = in.result.scene.find("iterations=\"3\"") != std::string::npos;
    CHECK(in.reports(kApproximate, "option iterations", "is 100 here: 3 are for") == !written);
    return written;
  };
  CHECK(read(R"(iterations="3")"));
  CHECK(!read(R"(iterations="3" ls_iterations="5")"));
  CHECK(!read(R"(ls_iterations="5" iterations="3")"));
}

TEST_CASE("pairs of geoms touch whatever their bits", "[mjcf][contact]") {
  Imported in;
  const std::string none = R"(contype="0" conaffinity="0")";
  in.read("<mujoco><worldbody><geom name=\"floor\" type=\"plane\" size=\"1 1 1\"/>" +
              ball("a", geom(none, "ga"), 0) + ball("b", geom(none, "gb"), 1) +
              ball("c", geom(none, "gc"), 2) +
              R"(</worldbody><contact><pair geom1="ga" geom2="floor"/>
      <pair geom1="gb" geom2="ga" friction="1 0.9 0.1 0.1 0.1"/><pair geom1="ga" geom2="nowhere"/></contact></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.body("a").shapes.at(0).collides);
  CHECK(in.body("b").shapes.at(0).collides);
  CHECK(!in.body("c").shapes.at(0).collides);
  CHECK(separated(*in.model) == Pairs{{"b", "world_link"}});
  CHECK(in.reports(kExact, "contact of 'ga' and 'floor'"));
  CHECK(in.reports(kApproximate, "contact of 'gb' and 'ga'", "the first of two frictions"));
  CHECK(in.reports(kLeftOut, "contact of 'ga' and 'nowhere'", "no geom 'nowhere'"));
}

TEST_CASE("a robot without self-collision has one line for it", "[mjcf][contact]") {
  Imported in;
  std::string bodies;
  for (int i = 0; i < 40; ++i)
    bodies += ball("b" + std::to_string(i), geom(R"(contype="1" conaffinity="0")"), i);
  const std::string text = "<mujoco model=\"m\"><worldbody><geom type=\"plane\" size=\"1 1 1\"/>" +
                           bodies + "</worldbody></mujoco>";
  in.read(text, "m.xml");
  REQUIRE(in.model);
  CHECK(in.result.scene.find("<collide between=\"m m\" with=\"false\"/>") != std::string::npos);
  const Pairs pairs = separated(*in.model);
  CHECK(pairs.size() == 40 * 39 / 2);
  CHECK(pairs.count({"b0", "world_link"}) == 0);
  CHECK(in.reports(kExact, "contype and conaffinity", "40 pairs of bodies touch"));
}

TEST_CASE("the bits of thousands of bodies are decided in bounded space", "[mjcf][hostile]") {
  Imported in;
  std::string bodies;
  for (int i = 0; i < 3000; ++i)
    bodies +=
        ball("b" + std::to_string(i), geom(i % 2 == 0 ? R"(contype="1" conaffinity="0")" : ""), i);
  in.options.scene_folder = in.folder.path.string();
  in.result = dsl::import_model(
      in.folder.write("m.xml", "<mujoco><worldbody>" + bodies + "</worldbody></mujoco>"),
      in.options);
  CHECK(in.result.scene.find("<collide") == std::string::npos);
  CHECK(in.reports(kApproximate, "contype and conaffinity", "more than 1000 pairs"));
}

TEST_CASE("a base that MuJoCo lets touch its first link is reported", "[mjcf][contact]") {
  const auto read = [](const std::string& rest) {
    Imported in;
    in.read(
        R"(<mujoco><worldbody><body name="base"><geom size="0.1"/><body name="arm"><joint name="j"/>
      <geom size="0.1" pos="1 0 0"/><body name="hand"><joint/><geom size="0.1" pos="2 0 0"/></body></body></body>
      </worldbody>)" +
            rest + "</mujoco>",
        "m.xml");
    REQUIRE(in.model);
    return std::count_if(in.result.entries.begin(), in.result.entries.end(), [](const auto& e) {
      return e.fidelity == kApproximate && e.element.find("contact of ") == 0;
    });
  };
  CHECK(read("") == 1);
  CHECK(read(R"(<contact><exclude body1="base" body2="arm"/></contact>)") == 0);
}
