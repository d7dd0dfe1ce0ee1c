// Two hundred edits of all kinds, then all undone: the text is byte-equal.
#include <catch2/catch.hpp>

#include <random>
#include <set>

#include "document_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;

TEST_CASE("two hundred edits undone leave the text as it was", "[document][walk]") {
  const std::string name =
      GENERATE("001_first_steps/first_steps", "010_two_wheels/two_wheels", "040_servo_arm/arm");
  Folder folder;
  folder.write("w.scene.xml", Folder::read_file(std::string(COGRSIM_SOURCE_DIR) + "/examples/" +
                                                name + ".scene.xml"));
  for (const char* beside : {"wave.csv"}) {
    const std::string path = std::string(COGRSIM_SOURCE_DIR) + "/examples/040_servo_arm/" + beside;
    folder.write(beside, Folder::read_file(path));
  }
  const std::string first = folder.read("w.scene.xml");
  RequestHandler requests(folder.path("w.scene.xml"));
  std::mt19937 random(7);
  const auto number = [&] { return std::uniform_real_distribution<double>(-2, 2)(random); };
  std::vector<std::string> texts{requests.text()};
  std::multiset<std::string> kinds;
  for (int i = 0; i < 200; ++i) {
    const Json tree = requests.tree();
    const auto pick = [&] {
      return std::uniform_int_distribution<int>(0, static_cast<int>(tree.size()) - 1)(random);
    };
    const auto pick_tag = [&](const std::set<std::string>& tags) {
      std::vector<int> found;
      for (const Json& e : tree)
        if (tags.count(e["tag"].get<std::string>()) != 0) found.push_back(e["id"].get<int>());
      return found.empty()
                 ? 0
                 : found[std::uniform_int_distribution<std::size_t>(0, found.size() - 1)(random)];
    };
    static const std::set<std::string> kBodies = {"box", "sphere", "cylinder", "capsule"};
    Json op;
    switch (std::uniform_int_distribution<int>(0, 9)(random)) {
      case 0:
        op = {{"op", "set"},
              {"element", pick_tag(kBodies)},
              {"attribute", "mass"},
              {"value", std::to_string(2.5 + number()) + " kg"}};
        break;
      case 1:
        op = {{"op", "move"}, {"element", pick()}, {"parent", pick()}};
        break;
      case 2:
        op = {{"op", "rename"}, {"element", pick()}, {"name", "n" + std::to_string(i)}};
        break;
      case 3:
        op = {{"op", "duplicate"}, {"element", pick()}, {"offset", {number(), number(), 3}}};
        break;
      case 4:
        op = {{"op", "remove"}, {"elements", {pick()}}};
        break;
      case 5: {
        const int one = pick_tag(kBodies);
        Json all = {one};
        for (const Json& e : tree)
          if (e["parent"] == tree[one]["parent"] && e["id"] != one && number() > 1 &&
              kBodies.count(e["tag"].get<std::string>()) != 0)
            all.push_back(e["id"]);
        op = {{"op", "assemble"}, {"elements", all}, {"name", "group"}};
        break;
      }
      case 6:
        op = {{"op", "disassemble"}, {"element", pick_tag({"assembly"})}};
        break;
      case 7:
        op = {{"op", "place"},
              {"element", pick_tag(kBodies)},
              {"pose", {number(), number(), number(), 1, number(), 0, number()}}};
        break;
      case 8:
        op = {{"op", "insert"},
              {"parent", 0},
              {"xml", "<sphere name=\"ball\" radius=\"5 cm\" xyz=\"0 0 9\"/>"}};
        break;
      default:
        break;
    }
    const std::string before = requests.text();
    Answer answer = tl::unexpected(Error("typing"));
    if (op.is_null()) {
      // A comment somewhere between two elements.
      std::string text = before;
      text.insert(text.rfind("</scene>"), "<!-- " + std::to_string(i) + " -->\n");
      answer = requests.ask("set-text", {{"version", requests.version}, {"text", text}});
      REQUIRE(answer);
    } else {
      answer = requests.ask(
          "edit", {{"version", requests.version}, {"ops", Json::array({op})}, {"label", "x"}});
    }
    INFO(op);
    if (answer && requests.text() != before) {
      texts.push_back(requests.text());
      kinds.insert(op.is_null() ? "typing" : op["op"].get<std::string>());
      REQUIRE(requests.page.wait("problems", requests.version)["good"] == true);
    } else if (!answer) {
      CHECK_FALSE(answer.error().message.empty());
      CHECK(requests.text() == before);
    }
  }
  // Most kinds must have succeeded, or nothing was tested.
  INFO(texts.size() << " changes");
  CHECK(texts.size() > 60);
  for (const char* kind : {"set", "rename", "duplicate", "remove", "place", "insert", "typing"}) {
    INFO(kind);
    CHECK(kinds.count(kind) > 0);
  }
  for (std::size_t i = texts.size() - 1; i > 0; --i) {
    requests.get("undo");
    REQUIRE(requests.text() == texts[i - 1]);
  }
  CHECK(requests.text() == first);
  CHECK_FALSE(requests.ask("undo"));
  for (std::size_t i = 1; i < texts.size(); ++i) requests.get("redo");
  CHECK(requests.text() == texts.back());
}
