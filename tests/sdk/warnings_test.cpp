#include "cogrsim/physics/warnings.h"

#include <catch2/catch.hpp>

#include "cogrsim/model/builder.h"

using namespace cogrsim;

TEST_CASE("a rotor too heavy for its link is warned of with both lines", "[physics]") {
  ModelBuilder builder;
  const Mat3 I = Mat3::Identity();
  const int base = builder.body("base", 5, I, {});
  const int hand = builder.body("hand", 0.1, 1e-6 * I, {});
  const int shelf = builder.body("shelf", 0.1, 1e-6 * I, {});
  builder.joint("wrist", JointType::hinge, base, hand, {});
  builder.joint("lift", JointType::hinge, shelf, base, {});  // the parent is the lighter one
  builder.joint("post", JointType::hinge, kWorld, base, {});
  SceneModel& model = builder.model;
  model.files = {"arm.scene.xml"};
  model.bodies[std::size_t(hand)].origin = {0, 7, 5, 1};
  model.bodies[std::size_t(shelf)].origin = {0, 8, 5, 1};
  model.joints[0].origin = {0, 12, 3, 1};

  const auto found = rotor_warnings(model, "ode", {{1e6}, {30}, {10}}, 10);
  REQUIRE(found.size() == 2);
  CHECK(found[0].file == "arm.scene.xml");
  CHECK(found[0].line == 12);
  CHECK(found[0].message.find("joint 'wrist': it is 1e+06 times") != std::string::npos);
  for (const auto& [diagnostic, link, line] :
       {std::tuple{found[0], "it turns 'hand'", 7}, {found[1], "it turns 'shelf'", 8}}) {
    REQUIRE(diagnostic.notes.size() == 1);
    CHECK(diagnostic.notes[0].message == link);
    CHECK(diagnostic.notes[0].line == line);
  }
}
