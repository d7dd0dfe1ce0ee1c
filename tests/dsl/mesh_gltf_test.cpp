// Reading glTF 2.0, as GLB and as text, whole and broken.
#include <catch2/catch.hpp>
#include <cstring>

#include "../support/temporary_folder.h"
#include "assets/mesh_file.h"
#include "cogrsim/dsl/compiler.h"

using namespace cogrsim;
using namespace cogrsim::dsl;
using cogrsim::test::TemporaryFolder;

namespace {

constexpr std::size_t kMost = std::size_t{1} << 20;

template <class Number>
std::string bytes_of(std::initializer_list<Number> numbers) {
  std::string out(numbers.size() * sizeof(Number), '\0');
  std::memcpy(out.data(), numbers.begin(), out.size());
  return out;
}

/// A tetrahedron with corners at the origin and the three unit points, wound outwards: 48 bytes of
/// positions, then 12 indices.
std::string tetrahedron() {
  return bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         bytes_of<std::uint8_t>({0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2});
}

const char* const kViews =
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
    "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],";
const char* const kAccessors =
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
    "{\"bufferView\":1,\"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"}],";
const char* const kMeshes =
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],";
const char* const kNodes = "\"nodes\":[{\"mesh\":0}]";

std::string json(const std::string& nodes = kNodes, const std::string& meshes = kMeshes,
                 const std::string& accessors = kAccessors, const std::string& views = kViews,
                 const std::string& buffer = "{\"byteLength\":60}") {
  return "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[" + buffer + "]," + views + accessors +
         meshes + nodes + "}";
}

std::string number(std::size_t value) {
  return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(value)});
}

std::string glb(std::string text, std::string data = tetrahedron()) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  data.resize((data.size() + 3) / 4 * 4, '\0');
  return "glTF" + number(2) + number(28 + text.size() + data.size()) + number(text.size()) +
         "JSON" + text + number(data.size()) + std::string("BIN\0", 4) + data;
}

LoadedMesh read(const std::string& bytes, const std::string& folder = {}) {
  auto mesh = parse_gltf(bytes, folder, kMost);
  if (!mesh) FAIL(mesh.error().message);
  return std::move(*mesh);
}

std::string refusal(const std::string& bytes, const std::string& folder = {}) {
  const auto mesh = parse_gltf(bytes, folder, kMost);
  return mesh ? "accepted" : mesh.error().message;
}

/// Six times the volume; positive: the surface is wound outwards.
double volume(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles)
    sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return sum;
}

bool has(const TriangleMesh& mesh, const Vec3& point) {
  return std::any_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [&](const Vec3& v) { return (v - point).norm() < 1e-6; });
}

}  // namespace

TEST_CASE("a GLB is a closed solid, with its y axis up", "[dsl][mesh][gltf]") {
  const LoadedMesh loaded = read(glb(json()));
  CHECK(loaded.mesh.vertices.size() == 4);
  CHECK(loaded.mesh.triangles.size() == 4);
  CHECK(open_edges(loaded.mesh) == 0);
  CHECK(volume(loaded.mesh) == Approx(1.0));
  CHECK(has(loaded.mesh, Vec3(1, 0, 0)));
  CHECK(has(loaded.mesh, Vec3(0, 0, 1)));   // was y
  CHECK(has(loaded.mesh, Vec3(0, -1, 0)));  // was z
  CHECK_FALSE(loaded.color);
  CHECK(loaded.files.empty());
}

TEST_CASE("buffers of glTF are in the text or in files below its folder", "[dsl][mesh][gltf]") {
  TemporaryFolder folder;
  // Base64 of three positions (0 0 0), (1 0 0), (0 1 0).
  const char* const kTriangle =
      "{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}";
  const std::string view = "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],";
  const std::string accessor =
      "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],";
  const std::string meshes = "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],";
  CHECK(has(read(json(kNodes, meshes, accessor, view, kTriangle)).mesh, Vec3(0, 0, 1)));

  const auto in_file = [&](const std::string& uri) {
    return json(kNodes, kMeshes, kAccessors, kViews, "{\"byteLength\":60,\"uri\":\"" + uri + "\"}");
  };
  folder.write("meshes/data/my body.bin", tetrahedron());
  folder.write("outside.bin", tetrahedron());
  folder.write("meshes/.hidden.bin", tetrahedron());
  const LoadedMesh loaded = read(in_file("data/my%20body.bin"), folder / "meshes");
  CHECK(volume(loaded.mesh) == Approx(1.0));
  CHECK(loaded.files == std::vector<std::string>{folder / "meshes/data/my body.bin"});
  std::filesystem::create_symlink(folder / "outside.bin", folder / "meshes/link.bin");
  for (const char* uri : {"../outside.bin", "%2e%2e/outside.bin", "link.bin", ".hidden.bin",
                          "/etc/passwd", "file:///etc/passwd", "http://example.org/a.bin"}) {
    INFO(uri);
    CHECK(refusal(in_file(uri), folder / "meshes").find("does not lie in its folder") !=
          std::string::npos);
  }
  CHECK(refusal(in_file("none.bin"), folder / "meshes") == "its buffer 'none.bin' is not there");
  CHECK(refusal(in_file("data"), folder / "meshes") == "its buffer 'data' is not there");
  CHECK(refusal(in_file("data/my%20body.bin")).find("does not lie") != std::string::npos);
  // The file and its buffers together are bounded.
  const auto large = parse_gltf(in_file("data/my%20body.bin"), folder / "meshes",
                                in_file("data/my%20body.bin").size() + 59);
  CHECK_FALSE(large);
  // A scene names what it read, for those who pack it.
  folder.write("meshes/body.gltf", in_file("data/my%20body.bin"));
  const CompileResult scene =
      compile_text("<scene version=\"1\"><mesh file=\"meshes/body.gltf\" static=\"true\"/></scene>",
                   folder / "scene.scene.xml");
  INFO(to_text(scene.diagnostics));
  REQUIRE(scene.ok());
  CHECK(std::count(scene.files_read.begin(), scene.files_read.end(),
                   folder / "meshes/data/my body.bin") == 1);
}

TEST_CASE("nodes of glTF place their meshes", "[dsl][mesh][gltf]") {
  const auto placed = [](const std::string& nodes) { return read(glb(json(nodes))).mesh; };
  // Translated after it was turned by a quarter about z of the file and scaled: x goes to y, which is up.
  const TriangleMesh turned = placed(
      "\"scene\":0,\"scenes\":[{\"nodes\":[1]}],\"nodes\":[{\"mesh\":0,\"translation\":[10,0,0],"
      "\"rotation\":[0,0,0.7071067811865476,0.7071067811865476],\"scale\":[2,1,1]},"
      "{\"children\":[0],\"translation\":[0,5,0]}]");
  CHECK(turned.triangles.size() == 4);
  CHECK(has(turned, Vec3(10, 0, 5)));
  CHECK(has(turned, Vec3(10, 0, 7)));
  CHECK(has(turned, Vec3(9, 0, 5)));
  CHECK(volume(turned) == Approx(2.0));
  // A mirror turns the surface; it stays wound outwards.
  const TriangleMesh mirrored =
      placed("\"nodes\":[{\"mesh\":0,\"matrix\":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 3,0,0,1]}]");
  CHECK(has(mirrored, Vec3(2, 0, 0)));
  CHECK(volume(mirrored) == Approx(1.0));
  // Without a scene every node that is in no other; a mesh may be used twice.
  CHECK(placed("\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[3,0,0]}]").triangles.size() ==
        8);
}

TEST_CASE("strips, fans, sparse and packed positions of glTF", "[dsl][mesh][gltf]") {
  const std::string square = bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  const auto with = [&](const std::string& indices, int mode, const std::string& more = {}) {
    return glb(json(kNodes,
                    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
                    "\"mode\":" +
                        std::to_string(mode) + more + "}]}],",
                    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":"
                    "\"VEC3\"},{\"bufferView\":1,\"componentType\":5123,\"count\":4,\"type\":"
                    "\"SCALAR\"}],",
                    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
                    "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":8}],",
                    "{\"byteLength\":56}"),
               square + indices);
  };
  // Both triangles of the square look the same way, the front of glTF: to -y.
  for (const auto& [indices, mode] : {std::pair{bytes_of<std::uint16_t>({0, 1, 3, 2}), 5},
                                      std::pair{bytes_of<std::uint16_t>({0, 1, 2, 3}), 6}}) {
    const TriangleMesh mesh = read(with(indices, mode)).mesh;
    REQUIRE(mesh.triangles.size() == 2);
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Vec3 normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                              .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
      CHECK((normal - Vec3(0, -1, 0)).norm() < 1e-12);
    }
  }
  CHECK(refusal(with(bytes_of<std::uint16_t>({0, 1, 2, 3}), 4)) ==
        "4 corners are not triangles of three");
  CHECK(refusal(with(bytes_of<std::uint16_t>({0, 1, 2, 4}), 6)) ==
        "index 4 is beyond the 4 positions");
  CHECK(refusal(with(bytes_of<std::uint16_t>({0, 1, 2, 3}), 1)) == "the file has no triangles");
  CHECK(refusal(with(bytes_of<std::uint16_t>({0, 1, 2, 3}), 7)) ==
        "there are no primitives of mode 7");

  // Zeros but for one position; and bytes that stand for -1 to 1.
  const std::string sparse = glb(
      json(kNodes, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],",
           "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
           "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,\"componentType\":5121},"
           "\"values\":{\"bufferView\":2}}}],",
           "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,"
           "\"byteLength\":1},{\"buffer\":0,\"byteOffset\":40,\"byteLength\":12}],",
           "{\"byteLength\":52}"),
      bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 0, 0}) + bytes_of<std::uint32_t>({2}) +
          bytes_of<float>({0, 3, 0}));
  CHECK(has(read(sparse).mesh, Vec3(0, 0, 3)));
  const std::string packed = glb(
      json(
          kNodes, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],",
          "\"accessors\":[{\"bufferView\":0,\"componentType\":5120,\"normalized\":true,\"count\":3,"
          "\"type\":\"VEC3\"}],",
          "\"extensionsRequired\":[\"KHR_mesh_quantization\"],"
          "\"bufferViews\":[{\"buffer\":0,\"byteLength\":12,\"byteStride\":4}],",
          "{\"byteLength\":12}"),
      bytes_of<std::int8_t>({0, 0, 0, 9, 127, 0, 0, 9, 0, -127, 0, 9}));
  CHECK(has(read(packed).mesh, Vec3(1, 0, 0)));
  CHECK(has(read(packed).mesh, Vec3(0, 0, -1)));
}

TEST_CASE("the look of a glTF: its colour and its place in a picture", "[dsl][mesh][gltf]") {
  const std::string uv = bytes_of<float>({0, 0, 1, 0, 1, 1, 0.25f, 0.75f});
  const auto looks = [&](const std::string& primitive, const std::string& materials) {
    return read(glb(
        json(kNodes,
             "\"materials\":[" + materials +
                 "],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0" + primitive +
                 "},\"indices\":1,\"material\":0}]}],",
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":"
             "\"VEC3\"},{\"bufferView\":1,\"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"},"
             "{\"bufferView\":2,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"}],",
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
             "\"byteLength\":12},{\"buffer\":0,\"byteOffset\":60,\"byteLength\":32}],",
             "{\"byteLength\":92}"),
        tetrahedron() + uv));
  };
  const LoadedMesh orange =
      looks("", "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.21404114,0,0.5]}}");
  REQUIRE(orange.color);
  CHECK(orange.color->r == Approx(1.0));
  CHECK(orange.color->g == Approx(0.5).epsilon(1e-6));  // 0.5 of a screen is 0.214 of the light
  CHECK(orange.color->b == 0.0);
  CHECK(orange.color->a == 1.0);  // it blends only where the material says so
  CHECK(orange.differs.empty());
  CHECK(orange.mesh.uv.empty());
  const LoadedMesh pictured =
      looks(",\"TEXCOORD_0\":2",
            "{\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},"
            "\"baseColorFactor\":[1,1,1,0.5]}}");
  CHECK(pictured.color->a == 0.5);
  CHECK(pictured.differs == "is shown without its textures");
  REQUIRE(pictured.mesh.uv.size() == 12);
  // The first triangle is 0 2 1; v runs up here.
  CHECK((pictured.mesh.uv[1] - Eigen::Vector2d(1, 0)).norm() < 1e-6);
  CHECK((pictured.mesh.uv[2] - Eigen::Vector2d(1, 1)).norm() < 1e-6);
}

TEST_CASE("a glTF that is broken or asks for too much is refused", "[dsl][mesh][gltf]") {
  CHECK(refusal("") == "byte 1: is not JSON");
  CHECK(refusal("{\"asset\":{}") == "byte 12: is not JSON");
  CHECK(refusal("[1e999]") == "has a number beyond all numbers");
  CHECK(refusal("{}") == "is not a glTF file: it has no version");
  CHECK(refusal("{\"asset\":{\"version\":\"1.0\"}}") == "is glTF '1.0'; save it as glTF 2.0");
  CHECK(refusal("{\"asset\":{\"version\":\"2.0\"}}") == "has no nodes");
  CHECK(refusal(std::string(1000, '[') + std::string(1000, ']')) ==
        "its values are nested too deep");
  std::string many = "[0";
  for (int i = 0; i < 1'100'000; ++i) many += ",0";
  CHECK(refusal(many + "]") == "has more than 1000000 values");
  const std::string good = glb(json());
  CHECK(refusal(good.substr(0, 10)) == "the file is cut short");
  CHECK(refusal(good + "x").find("a GLB of") == 0);
  for (std::size_t length = 12; length < good.size(); length += 7)
    CHECK(refusal(good.substr(0, length)) != "accepted");
  const auto needs = [&](const std::string& extension) {
    return refusal(glb(json(kNodes, kMeshes, kAccessors,
                            "\"extensionsRequired\":[\"" + extension + "\"]," + kViews)));
  };
  CHECK(needs("KHR_draco_mesh_compression") ==
        "its triangles are compressed by KHR_draco_mesh_compression; save it without compression");
  CHECK(needs("EXT_meshopt_compression").find("compressed by EXT_meshopt") != std::string::npos);
  CHECK(needs("ACME_cubes") == "needs the extension 'ACME_cubes', which is not read");
  CHECK(needs("KHR_materials_unlit") == "accepted");

  const auto accessor = [&](const std::string& text) {
    return refusal(glb(json(kNodes, kMeshes, "\"accessors\":[" + text + "],")));
  };
  const std::string indices =
      ",{\"bufferView\":1,\"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"}";
  const auto positions = [&](const std::string& view, const std::string& count,
                             const std::string& type = "5126") {
    return accessor("{\"bufferView\":" + view + ",\"componentType\":" + type +
                    ",\"count\":" + count + ",\"type\":\"VEC3\"}" + indices);
  };
  CHECK(positions("0", "5") == "an accessor of 5 elements ends beyond its view 0");
  CHECK(positions("0", "4000000000") == "has more numbers than are read of a mesh");
  CHECK(positions("0", "18446744073709551615") == "'count' is no number from 0 on");
  CHECK(positions("0", "-1") == "'count' is no number from 0 on");
  CHECK(positions("0", "0") == "an accessor has no elements");
  CHECK(positions("7", "4") == "there is no 7 of 'bufferViews'");
  CHECK(positions("0", "4", "5130") == "accessor 0 is 'VEC3' of type 5130, which is no use here");
  CHECK(accessor("{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}" + indices) ==
        "accessor 0 has no data; is the file compressed?");
  const auto view = [&](const std::string& text) {
    return refusal(glb(json(
        kNodes, kMeshes, kAccessors,
        "\"bufferViews\":[" + text + ",{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],")));
  };
  CHECK(view("{\"buffer\":0,\"byteLength\":61}") == "view 0 ends beyond its buffer");
  CHECK(view("{\"buffer\":0,\"byteOffset\":9000000000000000,\"byteLength\":48}") ==
        "view 0 ends beyond its buffer");
  CHECK(view("{\"buffer\":0,\"byteLength\":48,\"byteStride\":9000000000000000}") ==
        "an accessor of 4 elements ends beyond its view 0");
  CHECK(view("{\"buffer\":1,\"byteLength\":48}") == "there is no 1 of 'buffers'");
  CHECK(refusal(glb(json(kNodes, kMeshes, kAccessors, kViews, "{\"byteLength\":100}"))) ==
        "buffer 0 has 60 bytes, not 100");
  CHECK(refusal(glb(json(), bytes_of<float>({0, 0, 0, 1, 0, 0, 0, std::nanf(""), 0, 0, 0, 1}) +
                                tetrahedron().substr(48))) == "has a corner that is not finite");

  const auto nodes = [&](const std::string& text) {
    return refusal(glb(json("\"nodes\":" + text)));
  };
  CHECK(nodes("[{\"mesh\":3}]") == "there is no 3 of 'meshes'");
  CHECK(nodes("[{\"children\":[1]},{\"children\":[1],\"mesh\":0}]").find("in a cycle") !=
        std::string::npos);
  // Forty nodes, each twice in the next one, are a million million nodes.
  std::string doubling = "[{\"mesh\":0}";
  for (int i = 0; i < 40; ++i)
    doubling += ",{\"children\":[" + std::to_string(i) + "," + std::to_string(i) + "]}";
  CHECK(nodes(doubling + "]") == "has more than 100000 nodes");
  CHECK(nodes("[{\"mesh\":0,\"rotation\":[0,0,0,0]}]") == "a rotation is no unit quaternion");
  CHECK(nodes("[{\"mesh\":0,\"matrix\":[1,2]}]") == "'matrix' is not 16 numbers");
  CHECK(nodes("[{\"mesh\":0,\"weights\":[0.5]}]").find("morph targets") != std::string::npos);
}
