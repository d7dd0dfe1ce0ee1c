#include <cstdint>

#include "assets/mesh_file.h"
#include "assets/mesh_text.h"
#include "assets/mesh_welder.h"

namespace cogrsim::dsl {
namespace {

constexpr std::size_t kHeaderBytes = 84;    // 80 of free text, then the number of triangles
constexpr std::size_t kTriangleBytes = 50;  // normal, three corners, two bytes of attributes

Result<TriangleMesh> parse_binary(std::string_view bytes) {
  const std::size_t count = (bytes.size() - kHeaderBytes) / kTriangleBytes;
  MeshWelder welder;
  for (std::size_t t = 0; t < count; ++t) {
    const char* record = bytes.data() + kHeaderBytes + t * kTriangleBytes + 12;
    Vec3 corners[3];
    for (int i = 0; i < 9; ++i) corners[i / 3][i % 3] = read_little<float>(record + 4 * i);
    for (const Vec3& p : corners)
      if (!p.allFinite())
        return fail("triangle " + std::to_string(t + 1) + " has a corner that is not finite");
    if (auto done = welder.add(corners); !done) return tl::unexpected(done.error());
  }
  return welder.finish();
}

Result<TriangleMesh> parse_ascii(std::string_view text) {
  LineReader lines(text);
  const auto wrong = [&](const std::string& what) {
    return fail("line " + std::to_string(lines.number()) + ": " + what);
  };
  MeshWelder welder;
  Vec3 corners[3];
  int corner = 0;
  bool in_facet = false;
  std::string_view line;
  while (lines.next(line)) {
    const std::string_view key = next_word(line);
    if (key == "facet") {
      if (in_facet) return wrong("'facet' inside a facet");
      in_facet = true;
      corner = 0;
    } else if (key == "vertex") {
      if (!in_facet) return wrong("'vertex' outside a facet");
      if (corner == 3) return wrong("a facet with more than three corners");
      for (int i = 0; i < 3; ++i) {
        const std::string_view word = next_word(line);
        const auto value = to_number(word);
        if (!value) return wrong("expected a number, found " + quoted(word));
        corners[corner][i] = *value;
      }
      ++corner;
    } else if (key == "endfacet") {
      if (!in_facet || corner != 3) return wrong("a facet with fewer than three corners");
      in_facet = false;
      if (auto done = welder.add(corners); !done) return wrong(done.error().message);
    } else if (!key.empty() && key != "solid" && key != "endsolid" && key != "outer" &&
               key != "endloop") {
      return wrong("unknown word " + quoted(key));
    }
  }
  if (in_facet) return wrong("the file ends inside a facet");
  return welder.finish();
}

}  // namespace

Result<TriangleMesh> parse_stl(std::string_view bytes) {
  if (bytes.size() >= kHeaderBytes) {
    const std::size_t count = read_little<std::uint32_t>(bytes.data() + 80);
    if (bytes.size() == kHeaderBytes + count * kTriangleBytes) return parse_binary(bytes);
    if (bytes.substr(0, 5) != "solid")
      return fail("a binary STL of " + std::to_string(count) + " triangles is " +
                  std::to_string(kHeaderBytes + count * kTriangleBytes) + " bytes long, this is " +
                  std::to_string(bytes.size()));
  }
  if (bytes.substr(0, 5) != "solid")
    return fail("neither an ASCII STL (it would begin with 'solid') nor a binary one");
  return parse_ascii(bytes);
}

}  // namespace cogrsim::dsl
