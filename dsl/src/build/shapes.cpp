// Geometry of shapes, and the files it comes from.
#include <filesystem>

#include "assets/mesh_file.h"
#include "build/build_scene.h"

namespace cogrsim::dsl {
namespace {

std::string number_key(const Vec3& v) {
  return number_text(v.x()) + " " + number_text(v.y()) + " " + number_text(v.z());
}

void scale_mesh(TriangleMesh& mesh, const Vec3& factor) {
  for (Vec3& vertex : mesh.vertices) vertex = vertex.cwiseProduct(factor);
  if (factor.prod() < 0.0) {  // a mirrored surface is turned inside out
    for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
    for (std::size_t i = 0; i + 2 < mesh.uv.size(); i += 3)
      std::swap(mesh.uv[i + 1], mesh.uv[i + 2]);
  }
}

}  // namespace

/// The path of a file that the scene names; empty: not found, and reported.
std::string Builder::asset(const std::string& file, const SourceSpan& at, const Trail* trail) {
  std::string path = context_.files.resolve_asset(file, at);
  if (path.empty()) dsl::spend(context_, 20000, at, trail);  // it was looked for in all folders
  return path;
}

/// The result of a file is bounded by its size; building it again costs work.
bool Builder::copied(const std::string& path, std::size_t work, const SourceSpan& at,
                     const Trail* trail) {
  return asset_files_.insert(path).second || dsl::spend(context_, work, at, trail);
}

bool Builder::mesh(const Element& element, Shape& shape) {
  Reader r = reader(element);
  const auto convex = r.boolean("convex");
  const auto scale = r.numbers("scale");
  shape.type = *convex ? ShapeType::convex_mesh : ShapeType::mesh;
  if (r.has("file") == r.has("points")) {
    fault("CG0608", element, r.has("file") ? "points" : "name",
          r.has("file") ? "'file' and 'points' exclude each other"
                        : "a mesh needs its file, or points")
        .help("write file=\"hook.stl\", or points=\"0 0 0 1 0 0 0 1 0 0 0 1 m\" convex=\"true\"");
    return false;
  }
  if (r.has("points")) return hull_of_points(element, r, shape);
  const auto file = r.text("file");
  Vec3 factor = Vec3::Ones();
  if (scale.given()) {
    const std::vector<double>& s = *scale;
    if (s.size() == 2) {
      fault("CG0506", element, "scale", "expected one factor or three, found 2");
      return false;
    }
    factor = s.size() == 1 ? Vec3::Constant(s[0]) : Vec3(s[0], s[1], s[2]);
    if (factor.cwiseAbs().minCoeff() == 0.0) {
      fault("CG0507", element, "scale", "a factor of zero leaves nothing of the mesh");
      return false;
    }
  }
  if (convex.failed() || scale.failed() || !file.given()) return false;
  const SourceSpan& at = element.find("file")->value_span;
  const std::string path = asset(*file, at, element.trail);
  if (path.empty()) return false;
  const std::string key = path + "|" + number_key(factor);
  const auto [known, is_new] = mesh_indices_.try_emplace(key, -1);
  if (is_new) {
    MeshPtr& loaded = context_.meshes[key + "|" + *file];
    if (loaded == nullptr) {
      auto read = read_mesh(path, *file, context_.options.limits.asset_bytes);
      if (!read) {
        sink()
            .report("CG0706", at, element.trail, read.error().message)
            .help(
                "meshes are read from OBJ and STL files, in metres, and from COLLADA and glTF "
                "files");
        return false;
      }
      context_.files.add_read(read->files);
      std::size_t bytes = 0;
      read->files.push_back(path);
      for (const std::string& part : read->files) {
        std::error_code fault;
        const std::uintmax_t size = std::filesystem::file_size(part, fault);
        bytes += fault ? 0 : static_cast<std::size_t>(size);
      }
      if (!dsl::spend(context_, work_beyond(read->mesh, bytes), at, element.trail)) return false;
      scale_mesh(read->mesh, factor);
      loaded = std::make_shared<const TriangleMesh>(std::move(read->mesh));
    }
    if (!copied(path, 128 * (loaded->vertices.size() + loaded->triangles.size()), at,
                element.trail))
      return false;
    known->second = static_cast<int>(model_.meshes.size());
    mesh_open_edges_.push_back(open_edges(*loaded));
    model_.meshes.push_back(loaded);
  }
  shape.mesh = known->second;
  return shape.mesh >= 0;
}

bool Builder::hull_of_points(const Element& element, Reader& r, Shape& shape) {
  const auto points = r.numbers("points");
  if (shape.type != ShapeType::convex_mesh || r.has("scale")) {
    fault("CG0608", element, "points",
          r.has("scale") ? "'scale' belongs to a file: points are written in their size"
                         : "points are the corners of a convex hull")
        .help(r.has("scale") ? "" : "add convex=\"true\"");
    return false;
  }
  if (!points.given()) return false;
  const std::vector<double>& p = *points;
  if (p.size() % 3 != 0) {
    fault("CG0506", element, "points",
          std::to_string(p.size()) + " numbers are not points of three");
    return false;
  }
  std::vector<Vec3> corners;
  for (std::size_t i = 0; i < p.size(); i += 3) corners.emplace_back(p[i], p[i + 1], p[i + 2]);
  return add_hull(element, "points", std::move(corners), shape);
}

bool Builder::heightmap(const Element& element, Shape& shape) {
  Reader r = reader(element);
  shape.type = ShapeType::heightmap;
  const auto size = r.numbers("size");
  if (r.has("mass") || r.has("density"))
    fault("CG0709", element, r.has("mass") ? "mass" : "density",
          "a heightmap never moves and has no mass");
  if (r.has("file") == r.has("heights")) {
    fault("CG0608", element, r.has("file") ? "heights" : "name",
          r.has("file") ? "'file' and 'heights' exclude each other"
                        : "a heightmap needs its heights, or a file")
        .help("write file=\"hill.pgm\", or columns=\"3\" heights=\"0 0 0 0 10 0 0 0 0 cm\"");
    return false;
  }
  if (!size.given()) return false;
  const double size_x = (*size)[0], size_y = (*size)[1];
  HeightGrid grid;
  if (r.has("file")) {
    const auto file = r.text("file");
    const auto height = r.number("height");
    if (r.has("columns"))
      fault("CG0608", element, "columns", "a heightmap file defines its own number of columns");
    if (!file.given() || height.failed()) return false;
    const SourceSpan& at = element.find("file")->value_span;
    const std::string path = asset(*file, at, element.trail);
    if (path.empty()) return false;
    auto loaded =
        load_heightmap(path, *file, size_x, size_y, *height, context_.options.limits.asset_bytes);
    if (!loaded) {
      sink()
          .report("CG0706", at, element.trail, loaded.error().message)
          .help("heightmaps are read from PGM pictures and from lines of numbers");
      return false;
    }
    if (!copied(path, 16 * loaded->heights.size(), at, element.trail)) return false;
    grid = std::move(*loaded);
  } else {
    const auto heights = r.numbers("heights");
    const auto columns = r.integer("columns");
    if (r.has("height"))
      fault("CG0608", element, "height", "'height' scales a file; 'heights' are heights already");
    if (!columns.given() && !columns.failed())
      fault("CG0204", element, "'heights' need 'columns': the number of heights in a row");
    if (!heights.given() || !columns.given()) return false;
    const auto count = static_cast<std::int64_t>((*heights).size());
    const std::int64_t rows = count / *columns;
    if (rows * *columns != count || rows < 2 || *columns < 2) {
      fault("CG0506", element, "heights",
            std::to_string(count) + " heights do not fill rows of " + std::to_string(*columns) +
                ", at least 2 by 2")
          .help("the number of heights must be a multiple of 'columns'");
      return false;
    }
    grid.columns = static_cast<int>(*columns);
    grid.rows = static_cast<int>(rows);
    grid.size_x = size_x;
    grid.size_y = size_y;
    grid.heights = *heights;
  }
  shape.heightmap = static_cast<int>(model_.heightmaps.size());
  model_.heightmaps.push_back(std::make_shared<const HeightGrid>(std::move(grid)));
  return true;
}

// False: something of it failed and was reported.
bool Builder::geometry(const Element& element, Shape& shape) {
  Reader r = reader(element);
  const std::string_view tag = element.tag();
  bool good = true;
  const auto take = [&](std::string_view attribute, double& value) {
    const auto given = r.number(attribute);
    good = good && given.given();
    if (given.given()) value = *given;
  };
  if (tag == "box") {
    shape.type = ShapeType::box;
    const auto size = r.vec3("size");
    good = size.given();
    if (good) shape.size = *size;
  } else if (tag == "sphere") {
    shape.type = ShapeType::sphere;
    take("radius", shape.radius);
  } else if (tag == "cylinder" || tag == "capsule") {
    shape.type = tag == "cylinder" ? ShapeType::cylinder : ShapeType::capsule;
    take("radius", shape.radius);
    take("length", shape.length);
  } else if (tag == "ellipsoid") {
    good = ellipsoid(element, shape);
  } else if (tag == "cone") {
    good = cone(element, shape);
  } else if (tag == "prism") {
    good = prism(element, shape);
  } else if (tag == "plane") {
    shape.type = ShapeType::plane;
  } else if (tag == "mesh") {
    good = mesh(element, shape);
  } else {
    good = heightmap(element, shape);
  }
  return good;
}

void Builder::shapes() {
  for (std::size_t b = 0; b < body_shapes_.size(); ++b) {
    const Note& whole = note(*body_elements_[b]);
    const Pose X_BW = whole.X_W.inverse();
    Body& body = model_.bodies[b];
    body.X_WB = whole.X_W;
    const bool moves = body.kind != BodyKind::static_body;
    for (const ShapeJob& job : body_shapes_[b]) {
      const Element& element = *job.element;
      Shape shape;
      shape.name = element.path;
      shape.origin = element.span();
      // The pose of a single shape in its body is exactly the identity.
      if (&element != body_elements_[b]) shape.X_BS = X_BW * note(element).X_W;
      const bool good = geometry(element, shape);
      if (!good || job.material_failed) note(element).faulty = true;
      shape.material = shape_material(job);
      Reader r = reader(element);
      if (const auto velocity = r.vec3("surface-velocity"); velocity.given())
        shape.surface_velocity = *velocity;
      shape.collides = *r.boolean("collide");
      shape.visible = *r.boolean("visible");
      const bool ground = shape.type == ShapeType::plane || shape.type == ShapeType::heightmap ||
                          shape.type == ShapeType::mesh;
      if (ground && moves && good) {
        note(element).faulty = true;
        auto report = fault("CG0705", element,
                            "'" + element.path + "' is a " + std::string(element.tag()) +
                                (shape.type == ShapeType::mesh ? " that is not convex" : "") +
                                " and cannot move");
        report.help(shape.type == ShapeType::mesh
                        ? "write convex=\"true\" to let it move as its convex hull, or "
                          "static=\"true\" if it never moves"
                        : "move it out of the body, or make the whole body static=\"true\"");
      }
      shape_indices_[&element] = {static_cast<int>(b), static_cast<int>(body.shapes.size())};
      body.shapes.push_back(std::move(shape));
    }
  }
}

}  // namespace cogrsim::dsl
