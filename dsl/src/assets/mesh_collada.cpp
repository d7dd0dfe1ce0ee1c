// COLLADA 1.4 (Khronos, ISO/PAS 17506) as one triangle mesh: geometries, placed by the nodes of the
// visual scene. Lengths are multiplied by <unit meter>. The up axis is not applied, as in ROS, whose
// models it would turn over. Materials, textures, animation, skins and lights are not read.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include <map>
#include <set>

#include "assets/mesh_file.h"
#include "assets/mesh_text.h"
#include "report/diagnostics.h"
#include "syntax/node.h"

namespace cogrsim::dsl {

namespace {

using Transform = Eigen::Affine3d;

const Node* child(const Node& node, std::string_view name) {
  for (const Node* c : node.children)
    if (c->name == name) return c;
  return nullptr;
}

std::string_view value(const Node& node, std::string_view attribute) {
  const Attribute* a = node.find(attribute);
  return a == nullptr ? std::string_view() : a->value;
}

/// "#id" without its sign.
std::string_view target(std::string_view url) {
  if (!url.empty() && url.front() == '#') url.remove_prefix(1);
  return url;
}

std::vector<double> floats(std::string_view text, std::size_t most) {
  std::vector<double> out;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const auto number = to_number(word);
    if (!number) throw BrokenMesh{"'" + std::string(word.substr(0, 40)) + "' is not a number"};
    if (out.size() >= most) throw BrokenMesh{"more numbers than are read of a mesh"};
    out.push_back(*number);
  }
  return out;
}

std::vector<std::size_t> indices(std::string_view text, std::size_t most) {
  std::vector<std::size_t> out;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const auto number = to_integer(word);
    if (!number || *number < 0)
      throw BrokenMesh{"'" + std::string(word.substr(0, 40)) + "' is not an index"};
    if (out.size() >= most) throw BrokenMesh{"more indices than are read of a mesh"};
    out.push_back(static_cast<std::size_t>(*number));
  }
  return out;
}

class ColladaReader {
 public:
  explicit ColladaReader(const Node& root) : root_(root) {}

  TriangleMesh read() {
    if (root_.name != "COLLADA") throw BrokenMesh{"is not a COLLADA file"};
    collect(root_, 0);
    double unit = 1.0;
    if (const Node* asset = child(root_, "asset"))
      if (const Node* u = child(*asset, "unit")) {
        const auto meter = to_number(value(*u, "meter"));
        if (meter && *meter > 0.0) unit = *meter;
      }
    Transform top = Transform::Identity();
    top.scale(unit);
    const Node* scene = child(root_, "scene");
    const Node* of = scene == nullptr ? nullptr : child(*scene, "instance_visual_scene");
    const Node* visual = of == nullptr ? nullptr : find(target(value(*of, "url")));
    if (visual == nullptr)
      if (const Node* library = child(root_, "library_visual_scenes"))
        visual = child(*library, "visual_scene");
    if (visual != nullptr) {
      for (const Node* c : visual->children)
        if (c->name == "node") node(*c, top, 0);
    } else if (const Node* library = child(root_, "library_geometries")) {
      for (const Node* g : library->children)
        if (g->name == "geometry") geometry(*g, top);
    }
    if (out_.triangles.empty()) throw BrokenMesh{"has no triangle"};
    return std::move(out_);
  }

 private:
  void collect(const Node& node, int depth) {
    const std::string_view id = value(node, "id");
    if (!id.empty()) by_id_.emplace(id, &node);
    if (depth < 64)
      for (const Node* c : node.children) collect(*c, depth + 1);
  }

  const Node* find(std::string_view id) const {
    const auto it = by_id_.find(id);
    return it == by_id_.end() ? nullptr : it->second;
  }

  void node(const Node& n, const Transform& parent, int depth) {
    if (depth > 64)
      throw BrokenMesh{"nodes refer to each other in a cycle, or are nested too deep"};
    if (++nodes_ > 100000) throw BrokenMesh{"has more than 100000 nodes"};
    Transform X = parent;
    for (const Node* c : n.children) {
      if (c->name == "translate") {
        const auto v = floats(c->text, 3);
        if (v.size() == 3) X.translate(Vec3(v[0], v[1], v[2]));
      } else if (c->name == "rotate") {
        const auto v = floats(c->text, 4);
        if (v.size() == 4 && Vec3(v[0], v[1], v[2]).norm() > 0.0)
          X.rotate(Eigen::AngleAxisd(v[3] * 3.14159265358979323846 / 180.0,
                                     Vec3(v[0], v[1], v[2]).normalized()));
      } else if (c->name == "scale") {
        const auto v = floats(c->text, 3);
        if (v.size() == 3) X.scale(Vec3(v[0], v[1], v[2]));
      } else if (c->name == "matrix") {
        const auto v = floats(c->text, 16);
        if (v.size() != 16) throw BrokenMesh{"a <matrix> has not 16 numbers"};
        Eigen::Matrix4d m;
        for (int i = 0; i < 16; ++i) m(i / 4, i % 4) = v[i];
        X = X * Transform(m);
      }
    }
    for (const Node* c : n.children) {
      if (c->name == "node") {
        node(*c, X, depth + 1);
      } else if (c->name == "instance_node") {
        if (const Node* of = find(target(value(*c, "url")))) node(*of, X, depth + 1);
      } else if (c->name == "instance_geometry") {
        if (const Node* of = find(target(value(*c, "url")))) geometry(*of, X);
      } else if (c->name == "instance_controller") {
        // A skin in its bind pose: the geometry it deforms.
        const Node* controller = find(target(value(*c, "url")));
        const Node* skin = controller == nullptr ? nullptr : child(*controller, "skin");
        if (skin != nullptr)
          if (const Node* of = find(target(value(*skin, "source")))) geometry(*of, X);
      }
    }
  }

  /// Of a geometry, in its own axes.
  struct Surface {
    std::vector<Vec3> points;
    std::vector<Eigen::Vector3i> triangles;
  };

  std::vector<Vec3> positions(const Node& mesh) const {
    const Node* vertices = child(mesh, "vertices");
    if (vertices == nullptr) throw BrokenMesh{"a <mesh> has no <vertices>"};
    const Node* source = nullptr;
    for (const Node* input : vertices->children)
      if (input->name == "input" && value(*input, "semantic") == "POSITION")
        source = find(target(value(*input, "source")));
    const Node* array = source == nullptr ? nullptr : child(*source, "float_array");
    if (array == nullptr) throw BrokenMesh{"a <mesh> has no positions"};
    std::size_t stride = 3, offset = 0;
    if (const Node* technique = child(*source, "technique_common"))
      if (const Node* accessor = child(*technique, "accessor")) {
        stride = static_cast<std::size_t>(
            std::clamp<long long>(to_integer(value(*accessor, "stride")).value_or(3), 3, 64));
        offset = static_cast<std::size_t>(
            std::max<long long>(0, to_integer(value(*accessor, "offset")).value_or(0)));
      }
    const auto v = floats(array->text, 3 * kMaxMeshVertices);
    std::vector<Vec3> out;
    for (std::size_t i = offset; i + 2 < v.size(); i += stride)
      out.emplace_back(v[i], v[i + 1], v[i + 2]);
    return out;
  }

  void geometry(const Node& g, const Transform& X) {
    const Node* mesh = child(g, "mesh");
    if (mesh == nullptr) return;
    const auto [known, is_new] = surfaces_.try_emplace(mesh);  // many nodes may show one geometry
    if (is_new) known->second = surface(*mesh);
    const auto& [points, triangles] = known->second;
    if (out_.vertices.size() + points.size() > kMaxMeshVertices)
      throw BrokenMesh{"has too many corners"};
    if (out_.triangles.size() + triangles.size() > kMaxMeshTriangles)
      throw BrokenMesh{"has too many triangles"};
    const Eigen::Vector3i base = Eigen::Vector3i::Constant(static_cast<int>(out_.vertices.size()));
    for (const Vec3& p : points) out_.vertices.push_back(X * p);
    const bool mirrored = X.linear().determinant() < 0.0;
    for (const Eigen::Vector3i& t : triangles)
      out_.triangles.push_back(base + (mirrored ? Eigen::Vector3i(t[0], t[2], t[1]) : t));
  }

  Surface surface(const Node& mesh) const {
    Surface out;
    out.points = positions(mesh);
    for (const Node* c : mesh.children) {
      if (c->name != "triangles" && c->name != "polylist" && c->name != "polygons" &&
          c->name != "tristrips" && c->name != "trifans")
        continue;
      std::size_t stride = 1, offset = 0;
      for (const Node* input : c->children) {
        if (input->name != "input") continue;
        const auto at = static_cast<std::size_t>(
            std::clamp<long long>(to_integer(value(*input, "offset")).value_or(0), 0, 63));
        stride = std::max(stride, at + 1);
        if (value(*input, "semantic") == "VERTEX") offset = at;
      }
      std::vector<std::size_t> counts;
      if (const Node* vcount = child(*c, "vcount"))
        counts = indices(vcount->text, kMaxMeshTriangles);
      std::size_t next = 0;
      for (const Node* p : c->children) {
        if (p->name != "p") continue;
        const auto raw = indices(p->text, 3 * 64 * std::size_t{1000000});
        std::vector<int> corners;
        for (std::size_t i = offset; i < raw.size(); i += stride) {
          if (raw[i] >= out.points.size()) throw BrokenMesh{"an index is beyond the corners"};
          corners.push_back(static_cast<int>(raw[i]));
        }
        const auto triangle = [&](int a, int b, int d) {
          if (out.triangles.size() >= kMaxMeshTriangles) throw BrokenMesh{"has too many triangles"};
          if (a != b && b != d && a != d) out.triangles.emplace_back(a, b, d);
        };
        const auto fan = [&](std::size_t first, std::size_t count) {
          for (std::size_t k = 1; k + 1 < count; ++k)
            triangle(corners[first], corners[first + k], corners[first + k + 1]);
        };
        if (c->name == "triangles") {
          for (std::size_t i = 0; i + 2 < corners.size(); i += 3) fan(i, 3);
        } else if (c->name == "tristrips") {
          for (std::size_t i = 0; i + 2 < corners.size(); ++i)
            triangle(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
        } else if (c->name == "polylist") {
          std::size_t at = 0;
          for (; next < counts.size() && at + counts[next] <= corners.size(); ++next) {
            fan(at, counts[next]);
            at += counts[next];
          }
        } else {
          fan(0, corners.size());
        }
      }
    }
    return out;
  }

  const Node& root_;
  std::map<std::string_view, const Node*> by_id_;
  std::map<const Node*, Surface> surfaces_;  ///< by <mesh>
  std::size_t nodes_ = 0;
  TriangleMesh out_;
};

}  // namespace

Result<TriangleMesh> parse_collada(const std::string& bytes) {
  CompileOptions compile;
  compile.limits.file_bytes = compile.limits.asset_bytes;
  DiagnosticSink sink(compile.limits);
  SourceFiles sources(compile, sink);
  const Document* document = sources.open_plain_text(bytes, "mesh.dae");
  if (document == nullptr || document->root == nullptr) {
    const auto found = sink.take();
    return fail(found.empty()
                    ? "cannot be read"
                    : fmt::format("line {}: {}", found.front().line, found.front().message));
  }
  try {
    return ColladaReader(*document->root).read();
  } catch (const BrokenMesh& broken) {
    return fail(broken.message);
  }
}

}  // namespace cogrsim::dsl
