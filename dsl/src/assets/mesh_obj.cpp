#include <fmt/format.h>

#include <array>

#include "assets/mesh_file.h"
#include "assets/mesh_text.h"

namespace cogrsim::dsl {
namespace {

constexpr std::array<std::string_view, 11> kHarmless = {
    "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p", "mg", "lod", "shadow_obj"};

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
    if (!textured_) mesh_.uv.clear();
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
    if (key == "vt") return texture_point(line);
    if (key == "vn") return normal(line);
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

  // u, and where they are given v and a depth that pictures do not have.
  Result<> texture_point(std::string_view line) {
    double values[3] = {0.0, 0.0, 0.0};
    int count = 0;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const auto value = to_number(word);
      if (!value) return wrong("expected a number, found " + quoted(word));
      if (count == 3) return wrong("a texture coordinate has at most three numbers");
      values[count++] = *value;
    }
    if (count == 0) return wrong("a texture coordinate needs a number");
    if (texture_points_.size() >= kMaxMeshVertices)
      return wrong("more than " + std::to_string(kMaxMeshVertices) + " texture coordinates");
    texture_points_.emplace_back(values[0], values[1]);
    return {};
  }

  // Only counted: the orientation of a surface follows from its corners.
  Result<> normal(std::string_view line) {
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = next_word(line);
      if (!to_number(word))
        return wrong(word.empty() ? "a normal needs three numbers"
                                  : "expected a number, found " + quoted(word));
    }
    ++normals_;
    return {};
  }

  /// Counted from 1, or backwards from -1; to an index from 0.
  Result<int> index(std::string_view word, std::size_t known, const char* what) const {
    const auto value = to_integer(word);
    const auto count = static_cast<long long>(known);
    if (!value) return wrong("expected a " + std::string(what) + " number, found " + quoted(word));
    const long long i = *value < 0 ? count + *value : *value - 1;
    if (*value == 0 || i < 0 || i >= count)
      return wrong(what + (" " + std::to_string(*value)) + " does not exist; there are " +
                   std::to_string(count) + " so far");
    return static_cast<int>(i);
  }

  struct Corner {
    int vertex = 0, texture = -1;
  };

  /// "7", "7/3", "7/3/2" or "7//2": vertex, texture coordinate, normal.
  Result<Corner> corner(std::string_view word) const {
    std::array<std::string_view, 3> parts;
    std::size_t count = 0;
    for (std::string_view rest = word;; ++count) {
      if (count == 3) return wrong("a corner has at most three numbers, found " + quoted(word));
      const std::size_t slash = rest.find('/');
      parts[count] = rest.substr(0, slash);
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
    }
    Corner out;
    const auto vertex = index(parts[0], mesh_.vertices.size(), "vertex");
    if (!vertex) return tl::unexpected(vertex.error());
    out.vertex = *vertex;
    // Between two slashes there may be nothing.
    if (count == 1 || (count == 2 && !parts[1].empty())) {
      const auto texture = index(parts[1], texture_points_.size(), "texture coordinate");
      if (!texture) return tl::unexpected(texture.error());
      out.texture = *texture;
    }
    if (count == 2) {
      const auto turned = index(parts[2], normals_, "normal");
      if (!turned) return tl::unexpected(turned.error());
    }
    return out;
  }

  Result<> face(std::string_view line) {
    std::array<Corner, 3> corners{};
    int count = 0;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const Result<Corner> next = corner(word);
      if (!next) return tl::unexpected(next.error());
      if (count > 0 && (next->texture < 0) != (corners[0].texture < 0))
        return wrong("some corners of the face have texture coordinates, " + quoted(word) +
                     (next->texture < 0 ? " has none" : " has one and those before have none"));
      corners[std::min(count, 2)] = *next;
      ++count;
      if (count < 3) continue;
      if (mesh_.triangles.size() >= kMaxMeshTriangles)
        return wrong("more than " + std::to_string(kMaxMeshTriangles) + " triangles");
      add_triangle(corners);
      corners[1] = corners[2];
    }
    if (count < 3) return wrong("a face needs at least three corners");
    return {};
  }

  void add_triangle(const std::array<Corner, 3>& corners) {
    const Eigen::Vector3i triangle(corners[0].vertex, corners[1].vertex, corners[2].vertex);
    // A triangle that uses a corner twice has no area and no effect.
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
      return;
    mesh_.triangles.push_back(triangle);
    textured_ = textured_ || corners[0].texture >= 0;
    for (const Corner& c : corners) {
      if (c.texture >= 0) {
        mesh_.uv.push_back(texture_points_[c.texture]);
      } else {
        mesh_.uv.emplace_back(0.0, 0.0);
      }
    }
  }

  std::vector<Eigen::Vector2d> texture_points_;
  std::size_t normals_ = 0;
  bool textured_ = false;  // some face has texture coordinates
  LineReader lines_;
  TriangleMesh mesh_;
};

}  // namespace

Result<TriangleMesh> parse_obj(std::string_view text) { return ObjParser(text).parse(); }

std::string obj_text(const TriangleMesh& mesh) {
  std::string out = "# Written by cogrsim; metres.\n";
  for (const Vec3& v : mesh.vertices) out += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
  for (const Eigen::Vector3i& t : mesh.triangles)
    out += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return out;
}

}  // namespace cogrsim::dsl
