// Geoms of MJCF: shapes, masses and appearance.
#include "import/mjcf_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "assets/mesh_file.h"

namespace cogrsim::dsl::import {

bool MjcfReader::geom(const XmlElement& source, const XmlElement& e, const std::string& body,
                      RobotShape& out, RobotInertia* inertia) {
  out.at = source.at;
  if (const std::string* name = source.find("name")) out.name = *name;
  const std::string* type = e.find("type");
  const std::string kind = type != nullptr ? *type : e.find("mesh") != nullptr ? "mesh" : "sphere";
  const std::string what = !out.name.empty() ? fmt::format("geom '{}'", out.name)
                           : body.empty()    ? fmt::format("geom of type {}", kind)
                                          : fmt::format("geom of type {} of body '{}'", kind, body);
  out.X = pose(e);
  if (!geom_shape(source, e, kind, what, out)) return false;
  geom_inertia(source, e, out, inertia, what);
  if (out.geometry.type == Geometry::Type::ellipsoid)
    context_.approximate(source.at, what,
                         "touches as a hull of 720 triangles, within 0.6 %; its mass is exact");
  const bool by_bits = touching_by_ != "predefined";
  out.contact_type = by_bits ? static_cast<unsigned>(context_.number(e, "contype", 1.0)) : 0;
  out.contact_affinity =
      by_bits ? static_cast<unsigned>(context_.number(e, "conaffinity", 1.0)) : 0;
  out.collides = disabled_.count("contact") == 0 &&
                 (out.contact_type != 0 || out.contact_affinity != 0 ||
                  (!out.name.empty() && paired_geoms_.count(out.name) != 0));
  if (!out.name.empty()) read_geoms_.insert(out.name);
  geom_appearance(source, e, out);
  if (!out.visible && !out.collides) return false;
  out.material = surface(source, e);
  context_.exact(source.at, what);
  return true;
}

bool MjcfReader::geom_shape(const XmlElement& source, const XmlElement& e, const std::string& kind,
                            const std::string& what, RobotShape& out) {
  const std::string* mesh = e.find("mesh");
  std::vector<double> size;
  if (const std::string* text = e.find("size"))
    size = context_.numbers(source, *text, 1, 3, "'size'").value_or(std::vector<double>());
  const auto s = [&](std::size_t i) { return i < size.size() ? size[i] : 0.0; };
  double half = s(1);
  if (e.find("fromto") != nullptr) {
    const auto between = from_to(source, e, half);
    if (!between) return false;
    out.X = *between;
  }
  Geometry& g = out.geometry;
  bool has_size = true;
  if (kind == "plane") {
    g.type = Geometry::Type::plane;
  } else if (kind == "hfield") {
    const std::string* name = e.find("hfield");
    const auto known = name == nullptr ? height_fields_.end() : height_fields_.find(*name);
    if (known == height_fields_.end()) {
      context_.left_out(source.at, what, "its height field could not be read");
      return false;
    }
    g = known->second;
  } else if (kind == "mesh" || mesh != nullptr) {
    return geom_mesh(source, mesh, kind, what, g);
  } else if (kind == "sphere") {
    g.type = Geometry::Type::sphere;
    g.radius = s(0);
    has_size = g.radius > 0.0;
  } else if (kind == "capsule" || kind == "cylinder") {
    g.type = kind == "capsule" ? Geometry::Type::capsule : Geometry::Type::cylinder;
    g.radius = s(0);
    g.length = 2.0 * half;
    has_size = g.radius > 0.0 && g.length > 0.0;
  } else if (kind == "box" || kind == "ellipsoid") {
    Vec3 h(s(0), s(1), s(2));
    if (e.find("fromto") != nullptr) h = Vec3(s(0), s(0), half);
    g.type = kind == "box" ? Geometry::Type::box : Geometry::Type::ellipsoid;
    g.size = kind == "box" ? Vec3(2.0 * h) : h;
    has_size = g.size.minCoeff() > 0.0;
  } else {
    context_.left_out(source.at, what, fmt::format("there is no shape '{}'", kind));
    return false;
  }
  if (!has_size) context_.error(source.at, "CG1404", fmt::format("{} has no size", what));
  return has_size;
}

bool MjcfReader::geom_mesh(const XmlElement& source, const std::string* mesh,
                           const std::string& kind, const std::string& what, Geometry& g) {
  if (kind != "mesh")
    context_.approximate(source.at, what,
                         fmt::format("is the mesh itself, where MuJoCo fits a {} to it", kind));
  g.type = Geometry::Type::mesh;
  const auto known = mesh == nullptr ? meshes_.end() : meshes_.find(*mesh);
  if (known == meshes_.end()) {
    context_.left_out(source.at, what, "its mesh could not be read");
    return false;
  }
  g.mesh = known->second.path;
  g.scale = known->second.scale;
  if (g.scale.cwiseAbs().minCoeff() > 0.0) return true;
  context_.left_out(source.at, what, "the scale of its mesh leaves no volume");
  return false;
}

void MjcfReader::geom_appearance(const XmlElement& source, const XmlElement& e, RobotShape& out) {
  out.visible = true;
  if (const std::string* rgba = e.find("rgba")) {
    const auto v = context_.numbers(source, *rgba, 3, 4, "'rgba'");
    if (v) out.color = Color{(*v)[0], (*v)[1], (*v)[2], v->size() > 3 ? (*v)[3] : 1.0};
  } else if (const std::string* material = e.find("material")) {
    if (const auto known = materials_.find(*material); known != materials_.end())
      out.color = known->second;
  }
  if (out.color && out.color->a == 0.0) {
    out.visible = false;
    out.color.reset();
  }
  // By convention group 3 and above are collision shapes that are not drawn.
  if (context_.number(e, "group", 0.0) >= 3.0) out.visible = false;
}

const Result<MassProperties>& MjcfReader::mesh_mass(const Geometry& g, const std::string& what) {
  const std::string key = fmt::format("{}|{} {} {}", g.mesh, g.scale[0], g.scale[1], g.scale[2]);
  const auto known = mesh_masses_.find(key);
  if (known != mesh_masses_.end()) return known->second;
  const auto compute = [&]() -> Result<MassProperties> {
    auto mesh = context_.mesh(g.mesh, what);
    if (!mesh) return tl::unexpected(mesh.error());
    for (Vec3& v : mesh->mesh.vertices) v = v.cwiseProduct(g.scale);
    if (g.scale.prod() < 0.0)
      for (Eigen::Vector3i& t : mesh->mesh.triangles) std::swap(t[1], t[2]);
    Shape s;
    s.type = ShapeType::mesh;
    s.mesh = 0;
    const std::vector<MeshPtr> meshes = {std::make_shared<const TriangleMesh>(std::move(mesh->mesh))};
    return shape_mass(s, meshes, shape_volume(s, meshes));
  };
  return mesh_masses_.emplace(key, compute()).first->second;
}

void MjcfReader::geom_inertia(const XmlElement& source, const XmlElement& e,
                              const RobotShape& shape, RobotInertia* inertia,
                              const std::string& what) {
  if (inertia == nullptr || shape.geometry.type == Geometry::Type::plane ||
      shape.geometry.type == Geometry::Type::heightmap)
    return;
  const double group = context_.number(e, "group", 0.0);
  if (group < first_group_ || group > last_group_) return;
  const std::optional<double> given = context_.number(e, "mass");
  const double density = context_.number(e, "density", 1000.0);
  const Geometry& g = shape.geometry;
  std::optional<MassProperties> m;
  if (g.type == Geometry::Type::mesh) {
    const auto& unit = mesh_mass(g, what);
    if (!unit) {
      context_.left_out(source.at, fmt::format("mass of {}", what), unit.error().message);
      return;
    }
    const double factor = given ? *given / unit->mass : density;
    m = *unit;
    m->mass *= factor;
    m->inertia *= factor;
    if (!(m->mass > 0.0)) return;
  } else {
    m = solid_mass(g, given, density);
  }
  if (!m) return;
  const Mat3 R = shape.X.q.toRotationMatrix();
  *inertia = {m->mass, shape.X * m->com, R * m->inertia * R.transpose()};
}

}  // namespace cogrsim::dsl::import
