// Default classes, assets, and attributes that many elements of MJCF have.
#include "import/mjcf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace cogrsim::dsl::import {

void MjcfReader::override_by(const XmlElement& e, Attributes& all) {
  // An orientation has five spellings: one that is written takes the place of any other.
  constexpr const char* kOrientations[] = {"quat", "axisangle", "euler", "xyaxes", "zaxis"};
  if (std::any_of(std::begin(kOrientations), std::end(kOrientations),
                  [&](const char* name) { return e.find(name) != nullptr; }))
    for (const char* name : kOrientations) all.erase(name);
  for (const auto& [key, value] : e.attributes) {
    if (value.empty())
      all.erase(key);
    else
      all[key] = value;
  }
}

void MjcfReader::default_class(const XmlElement& e, const std::string& parent, bool top) {
  std::string name = parent;
  if (const std::string* own = e.find("class")) name = *own;
  if (!top || name != "main") classes_[name] = classes_[parent];
  Defaults& d = classes_[name];
  for (const auto& c : e.children)
    if (c->name != "default") override_by(*c, d[c->name]);
  for (const auto& c : e.children)
    if (c->name == "default") default_class(*c, name, false);
}

void MjcfReader::assets(const XmlElement& e) {
  for (const auto& c : e.children) {
    XmlElement a = with_defaults(*c, "");
    if (strip_path_)
      for (auto& [attribute, value] : a.attributes)
        if (attribute == "file") value = std::filesystem::path(value).filename().string();
    const std::string* file = a.find("file");
    const std::string* name = a.find("name");
    std::string key = name != nullptr ? *name : "";
    if (key.empty() && file != nullptr) key = std::filesystem::path(*file).stem().string();
    if (c->name == "mesh") {
      Mesh mesh;
      mesh.at = c->at;
      mesh.scale = context_.vec3(a, "scale", Vec3::Ones());
      if (a.find("refpos") != nullptr || a.find("refquat") != nullptr)
        context_.approximate(c->at, quoted_name(*c), "its reference pose is not applied");
      if (file == nullptr) {
        context_.left_out(c->at, quoted_name(*c), "has no file");
        continue;
      }
      const std::string href = mesh_dir_.empty() ? *file : mesh_dir_ + "/" + *file;
      auto path = context_.locate(href, c->at);
      if (!path) {
        context_.not_read(c->at, "mesh", href, path.error());
        continue;
      }
      mesh.path = *path;
      meshes_[key] = mesh;
      context_.exact(c->at, quoted_name(*c));
    } else if (c->name == "hfield") {
      height_field(*c, a, key);
    } else if (c->name == "material") {
      if (const std::string* rgba = a.find("rgba")) {
        const auto v = context_.numbers(*c, *rgba, 3, 4, "'rgba'");
        if (v) materials_[key] = Color{(*v)[0], (*v)[1], (*v)[2], v->size() > 3 ? (*v)[3] : 1.0};
      }
      context_.exact(c->at, quoted_name(*c), "its colour, without texture and gloss");
    } else if (c->name == "texture" || c->name == "skin") {
      context_.left_aside(c->at, quoted_name(*c), "concerns appearance only");
    } else {
      context_.left_out(c->at, quoted_name(*c), fmt::format("<{}> is not read", c->name));
    }
  }
}

XmlElement MjcfReader::with_defaults(const XmlElement& e, const std::string& around,
                                     const std::string& as) {
  XmlElement out;
  out.name = e.name;
  out.at = e.at;
  std::string name = around.empty() ? "main" : around;
  if (const std::string* own = e.find("class")) name = *own;
  auto known = classes_.find(name);
  if (known == classes_.end()) {
    std::vector<std::string> names;
    for (const auto& [n, d] : classes_) names.push_back(n);
    const std::string near = context_.near(name, names);
    context_.error(e.at, "CG1408", fmt::format("there is no default class '{}'", name),
                   near.empty() ? "" : fmt::format("did you mean '{}'?", near));
    known = classes_.find("main");
  }
  Attributes all;
  if (const auto of = known->second.find(as.empty() ? e.name : as); of != known->second.end())
    all = of->second;
  override_by(e, all);
  for (auto& [key, value] : all) out.attributes.emplace_back(key, value);
  return out;
}

Pose MjcfReader::pose(const XmlElement& e) {
  double half = 0.0;
  if (e.name == "site")
    if (const auto between = from_to(e, e, half)) return *between;
  return frame_ * Pose(context_.vec3(e, "pos", Vec3::Zero()), orientation(e));
}

std::optional<Pose> MjcfReader::from_to(const XmlElement& source, const XmlElement& e,
                                        double& half) {
  const std::string* text = e.find("fromto");
  const auto v = text == nullptr ? std::nullopt : context_.numbers(source, *text, 6, 6, "'fromto'");
  if (!v) return std::nullopt;
  const Vec3 a((*v)[0], (*v)[1], (*v)[2]), b((*v)[3], (*v)[4], (*v)[5]);
  half = 0.5 * (b - a).norm();
  Pose X(0.5 * (a + b), Quat::Identity());
  if (half > 1e-12) X.q = Quat::FromTwoVectors(Vec3::UnitZ(), a - b).normalized();
  return frame_ * X;
}

Quat MjcfReader::turn(const Vec3& euler) const {
  Quat out = Quat::Identity();
  for (int i = 0; i < 3; ++i) {
    const char c = euler_[static_cast<std::size_t>(i)];
    const Vec3 axis = c == 'x' || c == 'X'   ? Vec3::UnitX()
                      : c == 'y' || c == 'Y' ? Vec3::UnitY()
                                             : Vec3::UnitZ();
    const Quat part(Eigen::AngleAxisd(angle(euler[i]), axis));
    out = c >= 'a' ? out * part : part * out;  // small letters: about the moving axes
  }
  return out.normalized();
}

Quat MjcfReader::orientation(const XmlElement& e) {
  if (const std::string* q = e.find("quat")) {
    const auto v = context_.numbers(e, *q, 4, 4, "'quat'");
    if (v) {
      const Quat out((*v)[0], (*v)[1], (*v)[2], (*v)[3]);
      if (out.norm() > 1e-9) return out.normalized();
    }
  } else if (const std::string* a = e.find("axisangle")) {
    const auto v = context_.numbers(e, *a, 4, 4, "'axisangle'");
    if (v && Vec3((*v)[0], (*v)[1], (*v)[2]).norm() > 1e-12)
      return Quat(Eigen::AngleAxisd(angle((*v)[3]), Vec3((*v)[0], (*v)[1], (*v)[2]).normalized()));
  } else if (const std::string* u = e.find("euler")) {
    const auto v = context_.numbers(e, *u, 3, 3, "'euler'");
    if (v) return turn(Vec3((*v)[0], (*v)[1], (*v)[2]));
  } else if (const std::string* xy = e.find("xyaxes")) {
    const auto v = context_.numbers(e, *xy, 6, 6, "'xyaxes'");
    if (v) {
      Vec3 x((*v)[0], (*v)[1], (*v)[2]), y((*v)[3], (*v)[4], (*v)[5]);
      if (x.norm() > 1e-12) {
        x.normalize();
        y -= x * x.dot(y);
        if (y.norm() > 1e-12) {
          y.normalize();
          Mat3 R;
          R << x, y, x.cross(y);
          return Quat(R).normalized();
        }
      }
    }
  } else if (const std::string* z = e.find("zaxis")) {
    const auto v = context_.numbers(e, *z, 3, 3, "'zaxis'");
    if (v && Vec3((*v)[0], (*v)[1], (*v)[2]).norm() > 1e-12)
      return Quat::FromTwoVectors(Vec3::UnitZ(), Vec3((*v)[0], (*v)[1], (*v)[2])).normalized();
  }
  return Quat::Identity();
}

}  // namespace cogrsim::dsl::import
