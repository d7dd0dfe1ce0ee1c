#include <array>

#include "mesh_file.h"
#include "mesh_text.h"

namespace cogrsim::dsl {
namespace {

constexpr std::array<std::string_view, 13> kHarmless = {
    "vn", "vt", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p", "mg", "lod", "shadow_obj"};

class ObjParser {
 public:
  explicit ObjParser(std::string_view text) : lines_(text) {}

  Result<TriangleMesh> parse() {
    std::string_view line;
    std::string joined;
    while (lines_.next(line)) {
      // A backslash at the end carries a statement over to the next line.
      if (!line.empty() && line.back() == '\\') {
        joined.assign(line.substr(0, line.size() - 1));
        while (lines_.next(line)) {
          const bool more = !line.empty() && line.back() == '\\';
          joined.append(" ").append(more ? line.substr(0, line.size() - 1) : line);
          if (!more) break;
        }
        line = joined;
      }
      line = line.substr(0, line.find('#'));
      if (auto done = statement(line); !done) return tl::unexpected(done.error());
    }
    if (mesh_.triangles.empty()) return fail("the file has no faces");
    return std::move(mesh_);
  }

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return fail("line " + std::to_string(lines_.number()) + ": " + what);
  }

  Result<> statement(std::string_view line) {
    const std::string_view key = next_word(line);
    if (key.empty()) return {};
    if (key == "v") return vertex(line);
    if (key == "f" || key == "fo") return face(line);
    for (const std::string_view harmless : kHarmless)
      if (key == harmless) return {};
    return wrong("unknown statement " + quoted(key) +
                 "; only polygons are read, no free-form surfaces");
  }

  Result<> vertex(std::string_view line) {
    Vec3 p;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = next_word(line);
      const auto value = to_number(word);
      if (!value)
        return wrong(word.empty() ? "a vertex needs three numbers"
                                  : "expected a number, found " + quoted(word));
      p[i] = *value;
    }
    // What may follow is a weight or a colour; both only need to be numbers.
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
      if (!to_number(word)) return wrong("expected a number, found " + quoted(word));
    if (mesh_.vertices.size() >= kMaxMeshVertices)
      return wrong("more than " + std::to_string(kMaxMeshVertices) + " vertices");
    mesh_.vertices.push_back(p);
    return {};
  }

  Result<int> index(std::string_view word) const {
    const std::string_view first = word.substr(0, word.find('/'));
    const auto value = to_integer(first);
    const auto count = static_cast<long long>(mesh_.vertices.size());
    if (!value) return wrong("expected a vertex number, found " + quoted(word));
    const long long i = *value < 0 ? count + *value : *value - 1;
    if (*value == 0 || i < 0 || i >= count)
      return wrong("vertex " + std::to_string(*value) + " does not exist; there are " +
                   std::to_string(count) + " so far");
    return static_cast<int>(i);
  }

  Result<> face(std::string_view line) {
    std::array<int, 3> corner{};
    int count = 0;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const Result<int> i = index(word);
      if (!i) return tl::unexpected(i.error());
      corner[static_cast<std::size_t>(std::min(count, 2))] = *i;
      ++count;
      if (count < 3) continue;
      if (mesh_.triangles.size() >= kMaxMeshTriangles)
        return wrong("more than " + std::to_string(kMaxMeshTriangles) + " triangles");
      // A triangle that uses a corner twice has no area and no say in anything.
      if (corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0])
        mesh_.triangles.emplace_back(corner[0], corner[1], corner[2]);
      corner[1] = corner[2];
    }
    if (count < 3) return wrong("a face needs at least three corners");
    return {};
  }

  LineReader lines_;
  TriangleMesh mesh_;
};

}  // namespace

Result<TriangleMesh> parse_obj(std::string_view text) { return ObjParser(text).parse(); }

}  // namespace cogrsim::dsl
