// Height fields of MJCF.
#include <cstring>

#include "cogrsim/core/image.h"
#include "cogrsim/dsl/export_model.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

std::string terrain(const std::string& asset) {
  return R"(<mujoco><asset><hfield name="hill" )" + asset +
         R"( size="2 3 0.5 0.1"/></asset><worldbody>
      <geom type="hfield" hfield="hill" pos="0 0 -1"/>
      <body name="ball" pos="0 0 1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>)";
}

const HeightGrid& grid(const Imported& in) {
  REQUIRE(in.model);
  REQUIRE(in.model->heightmaps.size() == 1);
  return *in.model->heightmaps[0];
}

}  // namespace

TEST_CASE("elevations of MJCF are a heightmap", "[mjcf][heights]") {
  Imported in;
  // From 1 to 5: heights (h - 1) / 4 * 0.5 m; the first row is the one with the largest y.
  in.read(terrain(R"(nrow="2" ncol="3" elevation="1 2 3  5 4 1")"), "m.xml");
  const HeightGrid& g = grid(in);
  CHECK(g.columns == 3);
  CHECK(g.rows == 2);
  CHECK(g.size_x == 4.0);
  CHECK(g.size_y == 6.0);
  CHECK(g.heights == std::vector<double>{0.5, 0.375, 0.0, 0.0, 0.125, 0.25});
  CHECK(in.reports(kExact, "hfield 'hill'"));
  CHECK(in.result.scene.find("name=\"floor\"") == std::string::npos);
}

TEST_CASE("a picture of heights becomes a file beside the scene", "[mjcf][heights]") {
  Imported in;
  Image image;
  image.width = image.height = 32;
  image.channels = 1;
  for (int i = 0; i < 32 * 32; ++i)
    image.data.push_back(static_cast<std::uint8_t>(i < 32 ? 210 : 10));
  in.folder.write("hill.png", encode_png(image).value());
  in.read(terrain(R"(file="hill.png")"), "m.xml");
  const HeightGrid& g = grid(in);
  CHECK(g.columns == 32);
  // The picture's first row, which is the brightest, has the largest y.
  CHECK(g.heights.back() == 0.5);
  CHECK(g.heights.front() == 0.0);
  REQUIRE(in.result.files.size() == 1);
  CHECK(in.result.files[0].name == "meshes/heights.txt");
}

TEST_CASE("height fields that cannot be read are left out or refused", "[mjcf][heights]") {
  Imported in;
  in.read(terrain(R"(file="none.png")"), "m.xml");
  CHECK(in.reports(kLeftOut, "hfield 'hill'", "no file"));
  CHECK(in.reports(kLeftOut, "geom of type hfield", "could not be read"));
  in.folder.write("short.bin", std::string("\2\0\0\0\3\0\0\0abcd", 12));
  in.read(terrain(R"(file="short.bin")"), "m.xml");
  CHECK(in.reports(kLeftOut, "hfield 'hill'", "neither a PNG"));
  in.read(terrain(R"(nrow="100000" ncol="100000")"), "m.xml");
  CHECK(in.reports(kLeftOut, "hfield 'hill'", "2 by 2 to 4000000"));
  in.read(terrain(R"(nrow="2" ncol="2" elevation="1 2 3")"), "m.xml");
  CHECK(in.refuses("CG1403", "has 3 numbers, 4 are expected"));
  in.read(terrain(R"(nrow="20" ncol="30")"), "m.xml");
  CHECK(in.reports(kApproximate, "hfield 'hill'", "flat"));
  CHECK(grid(in).heights == std::vector<double>(4, 0.0));
}

TEST_CASE("a heightmap comes back from MJCF", "[mjcf][heights]") {
  const dsl::CompileResult scene = dsl::compile_text(R"(
<scene name="hills" version="1">
  <heightmap name="hill" size="2 4" columns="3" heights="0 25 0 0 100 50 12.5 0 0 cm" xyz="0 0 0.25"/>
  <sphere name="ball" radius="0.1 m" xyz="0 0 2"/>
</scene>)",
                                                     "hills.scene.xml");
  INFO(dsl::to_text(scene.diagnostics));
  REQUIRE(scene.ok());
  dsl::ExportOptions options;
  options.format = dsl::ExportFormat::mjcf;
  const auto out = dsl::export_model(*scene.model, options);
  REQUIRE(out);
  Imported back;
  for (const dsl::ImportedFile& file : out->files) back.folder.write(file.name, file.bytes);
  back.read(out->text, "hills.xml");
  const HeightGrid& g = grid(back);
  CHECK(g.size_x == 2.0);
  CHECK(g.size_y == 4.0);
  // All are numbers that a float has exactly.
  CHECK(g.heights == scene.model->heightmaps[0]->heights);
}
