// Reading OBJ, STL and height grids, whole and broken.
#include <catch2/catch.hpp>
#include <cstring>

#include "cogrsim/model/mass_properties.h"
#include "assets/mesh_file.h"

using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

// A tetrahedron with corners at the origin and the three unit points, wound outwards.
const char* const kObj =
    "# a corner\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\n"
    "f 1 3 2\nf 1 2 4\nf 2//1 3//1 4//1\nf -4 -1 -2\n";

std::string binary_stl(std::size_t triangles, float corner = 1.0f) {
  std::string out(80, ' ');
  const auto count = static_cast<std::uint32_t>(triangles);
  for (int i = 0; i < 4; ++i) out += static_cast<char>(count >> (8 * i) & 0xff);
  const float tetrahedron[4][9] = {{0, 0, 0, 0, corner, 0, corner, 0, 0},
                                   {0, 0, 0, corner, 0, 0, 0, 0, corner},
                                   {corner, 0, 0, 0, corner, 0, 0, 0, corner},
                                   {0, 0, 0, 0, 0, corner, 0, corner, 0}};
  for (std::size_t t = 0; t < triangles; ++t) {
    char record[50] = {};
    std::memcpy(record + 12, tetrahedron[t % 4], 36);
    out.append(record, sizeof record);
  }
  return out;
}

double volume(TriangleMesh mesh) {
  Shape shape;
  shape.type = ShapeType::convex_mesh;
  shape.mesh = 0;
  return shape_volume(shape, {std::make_shared<const TriangleMesh>(std::move(mesh))});
}

}  // namespace

TEST_CASE("OBJ and STL give the same solid", "[dsl][mesh]") {
  const auto obj = parse_obj(kObj);
  REQUIRE(obj);
  CHECK(obj->vertices.size() == 4);
  CHECK(obj->triangles.size() == 4);
  CHECK(open_edges(*obj) == 0);
  CHECK(volume(*obj) == Approx(1.0 / 6));
  const auto stl = parse_stl(binary_stl(4));
  REQUIRE(stl);
  CHECK(stl->vertices.size() == 4);
  CHECK(volume(*stl) == Approx(1.0 / 6));
  const auto text = parse_stl(
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\n"
      "endloop\nendfacet\nendsolid a\n");
  REQUIRE(text);
  CHECK(text->triangles.size() == 1);
  CHECK(open_edges(*text) == 3);
}

TEST_CASE("polygons are cut into triangles", "[dsl][mesh]") {
  const auto quad = parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 \\\n 3 4\n");
  REQUIRE(quad);
  CHECK(quad->triangles.size() == 2);
}

TEST_CASE("texture coordinates come with the corners they are given for", "[dsl][mesh]") {
  const std::string points =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1 1\nvt .5\n";
  const auto quad = parse_obj(points + "vn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/-1/-1\n");
  REQUIRE(quad);
  REQUIRE(quad->triangles.size() == 2);
  using Points = std::vector<Eigen::Vector2d>;
  CHECK(quad->uv == Points{{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0.5, 0}});
  // Faces without have the corner, triangles without area have nothing.
  const auto part = parse_obj(points + "f 1 2 3\nf 1/3 1/2 2/2\nf 1/3 3/3 4/4\n");
  REQUIRE(part);
  REQUIRE(part->triangles.size() == 2);
  CHECK(part->uv == Points{{0, 0}, {0, 0}, {0, 0}, {1, 1}, {1, 1}, {0.5, 0}});
  const auto none = parse_obj(points + "vn 0 0 1\nf 1//1 2//1 3//1\n");
  REQUIRE(none);
  CHECK(none->uv.empty());

  const auto message = [&](const std::string& more) {
    const auto mesh = parse_obj(points + more);
    return mesh ? std::string("accepted") : mesh.error().message;
  };
  CHECK(message("f 1/5 2/2 3/3\n") ==
        "line 9: texture coordinate 5 does not exist; there are 4 so far");
  CHECK(message("f 1/0 2/2 3/3\n") ==
        "line 9: texture coordinate 0 does not exist; there are 4 so far");
  CHECK(message("f 1/1 2 3/3\n") ==
        "line 9: some corners of the face have texture coordinates, '2' has none");
  CHECK(message("f 1 2/2 3\n") ==
        "line 9: some corners of the face have texture coordinates, '2/2' has one and those before "
        "have none");
  CHECK(message("f 1//1 2//1 3//1\n") == "line 9: normal 1 does not exist; there are 0 so far");
  CHECK(message("f 1/ 2/ 3/\n") == "line 9: expected a texture coordinate number, found ''");
  CHECK(message("f 1/1/1/1 2 3\n") ==
        "line 9: a corner has at most three numbers, found '1/1/1/1'");
  CHECK(message("vt\n") == "line 9: a texture coordinate needs a number");
  CHECK(message("vt 0 x\n") == "line 9: expected a number, found 'x'");
  CHECK(message("vt 0 0 0 0\n") == "line 9: a texture coordinate has at most three numbers");
  CHECK(message("vn 0 0\n") == "line 9: a normal needs three numbers");
  CHECK(message("vn 0 0 up\n") == "line 9: expected a number, found 'up'");
}

TEST_CASE("broken meshes are refused with the position", "[dsl][mesh]") {
  const auto message = [](const Result<TriangleMesh>& mesh) {
    return mesh ? std::string("accepted") : mesh.error().message;
  };
  CHECK(message(parse_obj("v 0 0 0\nf 1 2 3\n")) ==
        "line 2: vertex 2 does not exist; there are 1 so far");
  CHECK(message(parse_obj("v 0 0 1,5\n")) == "line 1: expected a number, found '1,5'");
  CHECK(message(parse_obj("v 0 0 nan\n")) == "line 1: expected a number, found 'nan'");
  CHECK(message(parse_obj("v 0 0 0\n")) == "the file has no faces");
  CHECK(message(parse_obj("f 0 0 0\n")).find("vertex 0 does not exist") != std::string::npos);
  CHECK(message(parse_obj("cstype bezier\n")).find("free-form") != std::string::npos);
  CHECK(message(parse_stl("")).find("neither") != std::string::npos);
  CHECK(message(parse_stl(binary_stl(4).substr(0, 200))).find("284") != std::string::npos);
  CHECK(message(parse_stl(binary_stl(1, std::numeric_limits<float>::infinity())))
            .find("not finite") != std::string::npos);
  CHECK(message(parse_stl("solid x\nfacet\nvertex 0 0\n")).find("line 3") != std::string::npos);
  // a count of four thousand million triangles in a file of a hundred bytes costs nothing
  std::string huge = binary_stl(0) + std::string(20, 'x');
  std::memset(huge.data() + 80, 0xff, 4);
  CHECK(message(parse_stl(huge)).find("4294967295") != std::string::npos);
}

TEST_CASE("height grids come from text and from PGM pictures", "[dsl][mesh]") {
  const auto text = parse_heightmap("# far\n0 1 2\n3 4 5\n", 2, 1, 1.0);
  REQUIRE(text);
  CHECK(text->columns == 3);
  CHECK(text->rows == 2);
  CHECK(text->heights[0] == 3.0);  // the last line is the near one
  const auto plain = parse_heightmap("P2 # c\n2 2\n10\n0 10\n5 10\n", 2, 1, 0.5);
  REQUIRE(plain);
  CHECK(plain->heights[0] == 0.25);
  const auto raw = parse_heightmap(std::string("P5 2 2 255\n\x00\xff\x33\x00", 15), 2, 1, 1.0);
  REQUIRE(raw);
  CHECK(raw->heights[0] == Approx(0.2));
  CHECK(raw->heights[3] == 1.0);
  const auto deep =
      parse_heightmap(std::string("P5 2 2 65535\n\xff\xff\x00\x00\x80\x00\x00\x01", 21), 1, 1, 1.0);
  REQUIRE(deep);
  CHECK(deep->heights[2] == 1.0);
}

TEST_CASE("broken height grids are refused", "[dsl][mesh]") {
  for (const char* bad : {"", "1 2\n3\n", "1\n2\n", "1 2\n3 x\n", "P5 2 2 255\n\x01",
                          "P5 99999999 99999999 255\n", "P2 2 2 1\n0 0 0 2\n", "P5 2 2 0\n"})
    CHECK_FALSE(parse_heightmap(bad, 1, 1, 1));
}
