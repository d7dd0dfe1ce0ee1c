// Textures of materials and shapes: which file, how large, shared when equal.
#include <cstdlib>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "../support/temporary_folder.h"
#include "cogrsim/core/image.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/dsl/compiler.h"

using namespace cogrsim;
namespace fs = std::filesystem;

namespace {

/// A folder with a picture in it, removed with the object.
struct Folder : test::TemporaryFolder {
  Folder() {
    Image image;
    image.width = image.height = 2;
    image.data = {255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9};
    REQUIRE(write_output_file((path / "a.png").string(), OutputKind::png, *encode_png(image)));
    REQUIRE(write_output_file((path / "b.jpg").string(), OutputKind::jpeg, *encode_jpeg(image)));
  }
};

}  // namespace

TEST_CASE("textures and their sizes are in the model", "[dsl]") {
  const Folder folder;
  const std::string scene = (folder.path / "t.scene.xml").string();
  std::ofstream(scene) << R"(<scene name="t" version="1">
  <material name="wood" texture="a.png" texture-size="20 cm 50 cm"/>
  <box name="plain" size="1 1 1" xyz="0 0 1" material="wood"/>
  <box name="other" size="1 1 1" xyz="2 0 1" material="wood" texture-size="0.3"/>
  <box name="alike" size="1 1 1" xyz="4 0 1" material="wood" texture-size="30 cm 30 cm"/>
  <plane name="floor" texture="b.jpg"/>
  <box name="tinted" size="1 1 1" xyz="6 0 1" material="wood" color="#ff0033"/>
</scene>
)";
  const dsl::CompileResult result = dsl::compile_file(scene);
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.ok());
  const auto material = [&](int body) -> const Material& {
    const Shape& shape = result.model->bodies[body].shapes[0];
    return result.model->materials[shape.material];
  };
  const auto index = [&](const char* name) { return find_body(*result.model, name); };
  const Material& plain = material(index("plain"));
  CHECK(plain.texture == (folder.path / "a.png").string());
  REQUIRE(plain.texture_size);
  CHECK(*plain.texture_size == Eigen::Vector2d(0.2, 0.5));
  const Material& other = material(index("other"));
  CHECK(other.texture == plain.texture);
  REQUIRE(other.texture_size);
  CHECK(*other.texture_size == Eigen::Vector2d(0.3, 0.3));
  CHECK(&material(index("alike")) == &other);
  const Material& floor = material(index("floor"));
  CHECK(floor.texture == (folder.path / "b.jpg").string());
  CHECK_FALSE(floor.texture_size);
  // Shown unchanged where no color is given.
  CHECK(floor.color.r == 1.0);
  CHECK(plain.color.g == 1.0);
  CHECK(material(index("tinted")).color.b == Approx(51.0 / 255.0));
}
