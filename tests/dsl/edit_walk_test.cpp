// A random walk of edits over whole scenes: every edit leaves a scene that compiles, or is refused.
#include <catch2/catch.hpp>

#include <fstream>
#include <random>
#include <regex>
#include <sstream>

#include "cogrsim/dsl/edit.h"

using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

class Walker {
 public:
  Walker(std::string path, unsigned seed) : path_(std::move(path)), random_(seed) {}

  EditOperation next(const OutlinedScene& scene) {
    const auto pick = [&] {
      return std::uniform_int_distribution<int>(
          0, static_cast<int>(scene.elements.size()) - 1)(random_);
    };
    const auto number = [&] { return std::uniform_real_distribution<double>(-2, 2)(random_); };
    switch (std::uniform_int_distribution<int>(0, 8)(random_)) {
      case 0:
        return SetAttribute{pick(), "xyz", "0.5 0.25 " + std::to_string(number())};
      case 1:
        return MoveElement{pick(), pick(), std::nullopt, number() > 0};
      case 2:
        return RenameElement{pick(), "n" + std::to_string(++count_)};
      case 3:
        return DuplicateElement{pick(), Vec3(number(), number(), 3 + number())};
      case 4:
        return RemoveElements{{pick()}};
      case 5: {
        // Neighbours: only these can be assembled.
        std::vector<int> parts{pick()};
        const int parent = scene.elements[parts[0]].parent;
        for (const OutlineElement& e : scene.elements)
          if (e.parent == parent && number() > 1) parts.push_back(e.id);
        if (number() > 0) return GroupElements{parts, "robot"};
        return AssembleElements{parts, "group", ""};
      }
      case 6: {
        std::vector<int> assemblies{pick()};
        for (const OutlineElement& e : scene.elements)
          if (e.tag == "assembly") assemblies.push_back(e.id);
        return DisassembleElement{assemblies[std::uniform_int_distribution<int>(
            0, static_cast<int>(assemblies.size()) - 1)(random_)]};
      }
      case 7: {
        Pose pose;
        pose.p = {number(), number(), number()};
        pose.q = Quat(number(), number(), number(), number() + 2.1).normalized();
        return PlaceElement{pick(), pose};
      }
      default:
        return InsertElement{0, "<sphere name=\"ball\" radius=\"5 cm\" xyz=\"0 0 9\"/>",
                             std::nullopt};
    }
  }

 private:
  std::string path_;
  std::mt19937 random_;
  int count_ = 0;
};

}  // namespace

TEST_CASE("a random walk of edits never leaves a broken scene", "[edit][walk]") {
  const std::string name = GENERATE("001_first_steps/first_steps", "010_two_wheels/two_wheels",
                                    "030_pendulums/pendulums", "040_servo_arm/arm");
  const std::string path = std::string(COGRSIM_EXAMPLES) + "/" + name + ".scene.xml";
  // Without plugins their parameters cannot be checked.
  std::string text = std::regex_replace(read(path), std::regex("<set [^>]*/>"), "");
  OutlinedScene scene = compile_outlined(text, path);
  REQUIRE(scene.result.ok());
  Walker walker(path, 42);
  int done = 0, refused = 0;
  for (int i = 0; i < 50; ++i) {
    const EditOperation operation = walker.next(scene);
    auto edit = edit_text(text, path, {operation});
    if (!edit) {
      ++refused;
      CHECK_FALSE(edit.error().message.empty());
      continue;
    }
    ++done;
    INFO("operation " << operation.index() << " made\n" << edit->text);
    REQUIRE(edit->scene.result.ok());
    // It compiles from the text alone, too.
    REQUIRE(compile_text(edit->text, path).ok());
    text = std::move(edit->text);
    scene = std::move(edit->scene);
  }
  // A walk that is refused all the time would test nothing.
  CHECK(done >= 12);
  CHECK(refused > 0);
}
