// A robot as a scene, as a person would write it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "assets/mesh_file.h"
#include "assets/mesh_text.h"
#include "import/robot.h"
#include "syntax/text.h"

namespace cogrsim::dsl::import {

namespace fs = std::filesystem;

namespace {

constexpr double kPi = 3.14159265358979323846;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

std::string list(const Vec3& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }

/// -0 becomes 0, and what is zero but for rounding too.
double tidy(double x) { return std::abs(x) < 1e-15 ? 0.0 : x; }
Vec3 tidy(const Vec3& v) { return {tidy(v[0]), tidy(v[1]), tidy(v[2])}; }

std::string read_bytes(const std::string& path, std::size_t limit) {
  std::ifstream in(path, std::ios::binary);
  std::string out;
  std::string block(std::size_t{1} << 16, '\0');
  while (in && out.size() <= limit) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    out.append(block, 0, static_cast<std::size_t>(in.gcount()));
  }
  return out;
}

std::string ending(const std::string& path) {
  return small_letters(fs::path(path).extension().string());
}

std::string as_obj(const TriangleMesh& mesh) {
  std::string out = "# Written by cogrsim import\n";
  for (const Vec3& v : mesh.vertices) out += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
  for (const Eigen::Vector3i& t : mesh.triangles)
    out += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return out;
}

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool empty() const { return !(low[0] <= high[0]); }
};

/// Of the corners in a mesh file, without building the mesh: binary STL and OBJ.
Bounds bounds_of(const std::string& path, const std::string& bytes) {
  Bounds out;
  if (ending(path) == ".stl" && bytes.size() >= 84) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, 4);
    if (bytes.size() == 84 + std::size_t{50} * count) {
      for (std::size_t i = 0; i < count; ++i) {
        float v[9];
        std::memcpy(v, bytes.data() + 84 + 50 * i + 12, sizeof v);
        for (int k = 0; k < 3; ++k) out.add(Vec3(v[3 * k], v[3 * k + 1], v[3 * k + 2]));
      }
      return out;
    }
  }
  LineReader lines(bytes);
  std::string_view line;
  while (lines.next(line)) {
    const std::string_view word = next_word(line);
    if (word != "v" && word != "vertex") continue;
    Vec3 p = Vec3::Zero();
    for (int k = 0; k < 3; ++k) p[k] = to_number(next_word(line)).value_or(0.0);
    out.add(p);
  }
  return out;
}

class SceneWriter {
 public:
  SceneWriter(Context& context, const RobotModel& robot) : context_(context), robot_(robot) {}

  void write() {
    find_poses();
    std::string body;
    body_ = &body;
    for (std::size_t i = 0; i < robot_.links.size(); ++i) link(i);
    for (const RobotJoint& j : robot_.joints) joint(j);
    for (const RobotJoint& j : robot_.loops) joint(j);
    drives();
    for (const RobotLink& l : robot_.links)
      for (const RobotSensor& s : l.sensors) sensor(l, s);
    for (const auto& [a, b] : robot_.no_contact)
      body += fmt::format("    <collide between=\"{} {}\" with=\"false\"/>\n", a, b);

    std::string name = robot_.name.empty() ? "robot" : robot_.name;
    for (char& c : name)
      if (!is_letter(c) && !is_digit(c) && c != '-') c = '_';
    if (!is_letter(name.front())) name.insert(0, "_");
    name.resize(std::min<std::size_t>(name.size(), 60));
    std::string type = name;
    if (type.front() >= 'a' && type.front() <= 'z')
      type.front() = static_cast<char>(type.front() - 'a' + 'A');
    if (type == name) type += "_model";

    std::string out = fmt::format("<scene name=\"{}\" version=\"1\">\n", escaped(name));
    out += fmt::format("  <!-- Written by cogrsim import from {}, {}. -->\n", context_.result.format,
                       comment(context_.shown(context_.path_of(0))));
    if (robot_.step || robot_.gravity) {
      out += "  <physics";
      if (robot_.step) out += fmt::format(" step=\"{} s\"", *robot_.step);
      if (robot_.gravity) out += fmt::format(" gravity=\"{}\"", list(*robot_.gravity));
      out += "/>\n";
    }
    out += fmt::format("  <prototype name=\"{}\">\n{}  </prototype>\n", type, body);
    if (context_.options.floor && !robot_.has_ground) out += "  <plane name=\"floor\" color=\"#d8d8d8\"/>\n";
    out += fmt::format("  <instance of=\"{}\" name=\"{}\"", type, name);
    const double lift = context_.options.floor && !robot_.has_ground && !extent_.empty() &&
                                std::isfinite(extent_.low[2])
                            ? std::ceil(-extent_.low[2] * 1e4) / 1e4
                            : 0.0;
    if (lift != 0.0) out += fmt::format(" xyz=\"0 0 {}\"", lift);
    out += "/>\n</scene>\n";
    context_.result.scene = std::move(out);
  }

 private:
  static std::string comment(std::string text) {
    for (std::size_t i; (i = text.find("--")) != std::string::npos;) text.replace(i, 2, "- -");
    return escaped(text);
  }

  // Poses of all links at the start, in the robot's frame.
  void find_poses() {
    for (const RobotLink& l : robot_.links) poses_.push_back(l.X);
    std::vector<bool> known(robot_.links.size(), true);
    for (const RobotJoint& j : robot_.joints) known[static_cast<std::size_t>(j.child)] = false;
    bool moved = true;
    while (moved) {
      moved = false;
      for (const RobotJoint& j : robot_.joints) {
        const auto child = static_cast<std::size_t>(j.child);
        if (known[child] || (j.parent >= 0 && !known[static_cast<std::size_t>(j.parent)])) continue;
        const Pose parent = j.parent < 0 ? Pose() : poses_[static_cast<std::size_t>(j.parent)];
        poses_[child] = parent * j.X_PC * travel(j, start_of(j));
        known[child] = true;
        moved = true;
      }
    }
  }

  static Pose travel(const RobotJoint& j, double q) {
    using Type = RobotJoint::Type;
    if (j.type == Type::hinge) {
      const Quat turn(Eigen::AngleAxisd(q, j.axis));
      return {j.anchor - turn * j.anchor, turn};
    }
    if (j.type == Type::slider) return {q * j.axis, Quat::Identity()};
    return {};
  }

  /// Where it starts: zero, or the limit nearest to it.
  static double start_of(const RobotJoint& j) { return std::clamp(j.position, j.lower, j.upper); }

  static std::string placed(const Pose& X) {
    std::string out;
    const Vec3 p = tidy(X.p);
    if (p != Vec3::Zero()) out += fmt::format(" xyz=\"{}\"", list(p));
    const Quat q = X.q.w() < 0 ? Quat(-X.q.w(), -X.q.x(), -X.q.y(), -X.q.z()) : X.q;
    if (q.vec().norm() < 1e-15) return out;
    // Angles that a person would write are written in degrees.
    const Mat3 R = q.toRotationMatrix();
    const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
    Vec3 rpy;
    if (std::abs(R(2, 0)) < 1.0 - 1e-12)
      rpy = Vec3(std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0)));
    else
      rpy = Vec3(0.0, pitch, std::atan2(-R(0, 1), R(1, 1)));
    Vec3 degrees = rpy * (180.0 / kPi);
    const Vec3 round = degrees.array().round();
    // To 1e-13 rad: what is written differs from what was read by less than rounding of the poses.
    if (from_rpy(round * (kPi / 180.0)).angularDistance(q) < 1e-13)
      return out + fmt::format(" rpy=\"{} {} {} deg\"", tidy(round[0]), tidy(round[1]), tidy(round[2]));
    return out + fmt::format(" quat=\"{} {} {} {}\"", tidy(q.w()), tidy(q.x()), tidy(q.y()), tidy(q.z()));
  }

  void link(std::size_t index) {
    const RobotLink& l = robot_.links[index];
    std::string& out = *body_;
    out += fmt::format("    <body name=\"{}\"", l.name);
    const RobotJoint* by = nullptr;
    for (const RobotJoint& j : robot_.joints)
      if (j.child == static_cast<int>(index)) by = &j;
    if (by != nullptr) {
      if (by->parent >= 0)
        out += fmt::format(" frame=\"{}\"", robot_.links[static_cast<std::size_t>(by->parent)].name);
      out += placed(by->X_PC);
    } else {
      out += placed(l.X);
    }
    if (l.is_static) out += " static=\"true\"";
    if (l.inertia && !l.is_static) {
      const RobotInertia& i = *l.inertia;
      out += fmt::format(" mass=\"{} kg\" com=\"{}\" inertia=\"{} {} {} {} {} {}\"", i.mass,
                         list(tidy(i.com)), i.I(0, 0), i.I(1, 1), i.I(2, 2), tidy(i.I(0, 1)),
                         tidy(i.I(0, 2)), tidy(i.I(1, 2)));
    }
    std::string inner;
    std::vector<bool> drawn(l.shapes.size(), false);
    for (std::size_t i = 0; i < l.shapes.size(); ++i) {
      if (drawn[i]) continue;
      RobotShape s = l.shapes[i];
      // One shape where what is seen and what is touched are the same.
      for (std::size_t k = i + 1; k < l.shapes.size(); ++k) {
        const RobotShape& o = l.shapes[k];
        if (drawn[k] || o.visible == s.visible || !same(s, o)) continue;
        drawn[k] = true;
        s.visible = s.collides = true;
        if (!s.color) s.color = o.color;
        if (s.texture.empty()) s.texture = o.texture;
        if (!s.friction) s.friction = o.friction;
        break;
      }
      inner += shape(l, s, poses_[index]);
    }
    for (const RobotFrame& f : l.frames)
      inner += fmt::format("      <frame name=\"{}\"{}/>\n", f.name, placed(f.X));
    out += inner.empty() ? "/>\n" : ">\n" + inner + "    </body>\n";
  }

  static bool same(const RobotShape& a, const RobotShape& b) {
    const Geometry &x = a.geometry, &y = b.geometry;
    return x.type == y.type && x.type != Geometry::Type::mesh && x.size == y.size &&
           x.radius == y.radius && x.length == y.length && a.X.p == b.X.p &&
           a.X.q.coeffs() == b.X.q.coeffs();
  }

  std::string shape(const RobotLink& l, const RobotShape& s, const Pose& X_RL) {
    const Geometry& g = s.geometry;
    std::string tag, attributes;
    const Pose X = X_RL * s.X;
    const auto extend = [&](const Bounds& b) {
      if (!s.collides || b.empty()) return;
      for (int i = 0; i < 8; ++i)
        extent_.add(X * Vec3(i & 1 ? b.high[0] : b.low[0], i & 2 ? b.high[1] : b.low[1],
                             i & 4 ? b.high[2] : b.low[2]));
    };
    const auto box = [&](const Vec3& half) {
      Bounds b;
      b.add(half);
      b.add(-half);
      extend(b);
    };
    switch (g.type) {
      case Geometry::Type::box:
        tag = "box";
        attributes = fmt::format(" size=\"{}\"", list(g.size));
        box(0.5 * g.size);
        break;
      case Geometry::Type::sphere:
        tag = "sphere";
        attributes = fmt::format(" radius=\"{}\"", g.radius);
        if (s.collides) {  // not its box: a ball does not grow where it turns
          extent_.add(X.p + Vec3::Constant(g.radius));
          extent_.add(X.p - Vec3::Constant(g.radius));
        }
        break;
      case Geometry::Type::cylinder:
      case Geometry::Type::capsule: {
        const bool round = g.type == Geometry::Type::capsule;
        tag = round ? "capsule" : "cylinder";
        attributes = fmt::format(" radius=\"{}\" length=\"{}\"", g.radius, g.length);
        if (s.collides) {
          // Extent along an axis e of a disc of radius r with the normal n: r sqrt(1 - (n e)²).
          const Vec3 n = X.q * Vec3::UnitZ();
          Vec3 half = 0.5 * g.length * n.cwiseAbs();
          for (int i = 0; i < 3; ++i)
            half[i] += round ? g.radius : g.radius * std::sqrt(std::max(0.0, 1.0 - n[i] * n[i]));
          extent_.add(X.p + half);
          extent_.add(X.p - half);
        }
        break;
      }
      case Geometry::Type::plane:
        tag = "plane";
        break;
      case Geometry::Type::ellipsoid:
        return ellipsoid(l, s);
      case Geometry::Type::mesh: {
        const std::string file = mesh_file(l, s, extend);
        if (file.empty()) return "";
        tag = "mesh";
        attributes = fmt::format(" file=\"{}\"", escaped(file));
        const Vec3 scale = scale_left_;
        if (scale != Vec3::Ones())
          attributes += scale[0] == scale[1] && scale[1] == scale[2]
                            ? fmt::format(" scale=\"{}\"", scale[0])
                            : fmt::format(" scale=\"{}\"", list(scale));
        if (!l.is_static) attributes += " convex=\"true\"";
        if (s.collides && !l.is_static)
          context_.approximate(s.at, fmt::format("collision mesh of '{}'", l.name),
                               "collides as its convex hull");
        break;
      }
    }
    std::string out = "      <" + tag;
    if (!s.name.empty()) {
      std::string name = s.name;
      for (char& c : name)
        if (!is_letter(c) && !is_digit(c) && c != '-') c = '_';
      if (is_letter(name.front()) && shape_names_.insert(l.name + "." + name).second &&
          std::none_of(l.frames.begin(), l.frames.end(),
                       [&](const RobotFrame& f) { return f.name == name; }))
        out += fmt::format(" name=\"{}\"", name);
    }
    out += attributes + placed(s.X);
    if (s.color)
      out += fmt::format(" color=\"#{:02x}{:02x}{:02x}{}\"", byte(s.color->r), byte(s.color->g),
                         byte(s.color->b),
                         s.color->a < 1.0 ? fmt::format("{:02x}", byte(s.color->a)) : "");
    if (s.friction && s.collides) out += fmt::format(" friction=\"{}\"", *s.friction);
    if (!s.collides) out += " collide=\"false\"";
    if (!s.visible) out += " visible=\"false\"";
    return out + "/>\n";
  }

  static int byte(double x) { return static_cast<int>(std::lround(255.0 * std::clamp(x, 0.0, 1.0))); }

  /// The language has no ellipsoid: a mesh of 512 triangles, which touches as its hull.
  std::string ellipsoid(const RobotLink& l, const RobotShape& s) {
    constexpr int kRings = 16, kSectors = 16;
    TriangleMesh mesh;
    const Vec3 h = s.geometry.size;
    const auto at = [&](int ring, int sector) {
      const double a = kPi * ring / kRings, b = 2.0 * kPi * (sector % kSectors) / kSectors;
      return Vec3(h[0] * std::sin(a) * std::cos(b), h[1] * std::sin(a) * std::sin(b),
                  h[2] * std::cos(a));
    };
    mesh.vertices.push_back(at(0, 0));
    for (int r = 1; r < kRings; ++r)
      for (int c = 0; c < kSectors; ++c) mesh.vertices.push_back(at(r, c));
    mesh.vertices.push_back(at(kRings, 0));
    const auto index = [&](int r, int c) {
      if (r == 0) return 0;
      if (r == kRings) return static_cast<int>(mesh.vertices.size()) - 1;
      return 1 + (r - 1) * kSectors + c % kSectors;
    };
    for (int r = 0; r < kRings; ++r)
      for (int c = 0; c < kSectors; ++c) {
        if (r > 0) mesh.triangles.emplace_back(index(r, c), index(r + 1, c), index(r, c + 1));
        if (r < kRings - 1)
          mesh.triangles.emplace_back(index(r, c + 1), index(r + 1, c), index(r + 1, c + 1));
      }
    context_.approximate(s.at, fmt::format("ellipsoid of '{}'", l.name),
                         "is a mesh of 480 triangles, whose surface lies up to 2 % inside");
    const std::string file = add_file(fmt::format("{}_ellipsoid.obj", l.name), as_obj(mesh));
    std::string out = fmt::format("      <mesh file=\"{}\" convex=\"true\"{}", escaped(file), placed(s.X));
    if (s.color)
      out += fmt::format(" color=\"#{:02x}{:02x}{:02x}\"", byte(s.color->r), byte(s.color->g),
                         byte(s.color->b));
    if (s.friction && s.collides) out += fmt::format(" friction=\"{}\"", *s.friction);
    if (!s.collides) out += " collide=\"false\"";
    if (!s.visible) out += " visible=\"false\"";
    return out + "/>\n";
  }

  std::string add_file(const std::string& wanted, std::string bytes) {
    const std::string folder =
        context_.options.copy_meshes.empty() ? "meshes" : context_.options.copy_meshes;
    std::string name;
    for (const char c : wanted) name += is_letter(c) || is_digit(c) || c == '.' || c == '-' ? c : '_';
    if (name.empty() || name.front() == '.') name.insert(0, "_");
    const std::string stem = fs::path(name).stem().string();
    const std::string tail = fs::path(name).extension().string();
    std::string full = folder + "/" + name;
    for (int i = 2; !file_names_.insert(full).second; ++i)
      full = fmt::format("{}/{}_{}{}", folder, stem, i, tail);
    context_.result.files.push_back({full, std::move(bytes)});
    return full;
  }

  /// The file's name for the scene; empty: left out. `scale_left_` is what the scene applies to it.
  template <class Extend>
  std::string mesh_file(const RobotLink& l, const RobotShape& s, const Extend& extend) {
    const Geometry& g = s.geometry;
    const std::string kind = ending(g.mesh);
    const std::string what = fmt::format("mesh '{}' of '{}'", fs::path(g.mesh).filename().string(), l.name);
    scale_left_ = g.scale;
    const auto known = meshes_.find(g.mesh);
    if (known == meshes_.end()) {
      Mesh mesh;
      std::string bytes = read_bytes(g.mesh, context_.options.limits.asset_bytes);
      if (bytes.size() > context_.options.limits.asset_bytes) {
        context_.left_out(s.at, what, "is larger than is read of a mesh");
      } else if (kind == ".stl" || kind == ".obj") {
        mesh.bounds = bounds_of(g.mesh, bytes);
        if (mesh.bounds.empty())
          context_.left_out(s.at, what, "has no corner");
        else
          mesh.name = refer(g.mesh, bytes);
      } else if (kind == ".dae") {
        auto read = read_collada(bytes, what);
        if (!read) {
          context_.left_out(s.at, what, read.error().message);
        } else {
          for (const Vec3& v : read->vertices) mesh.bounds.add(v);
          mesh.name = add_file(fs::path(g.mesh).stem().string() + ".obj", as_obj(*read));
        }
      } else {
        context_.left_out(s.at, what,
                          fmt::format("'{}' files are not read: STL, OBJ and COLLADA are", kind));
      }
      meshes_.emplace(g.mesh, mesh);
    }
    const Mesh& mesh = meshes_[g.mesh];
    if (mesh.name.empty()) return "";
    Bounds scaled;
    scaled.add(mesh.bounds.low.cwiseProduct(g.scale));
    scaled.add(mesh.bounds.high.cwiseProduct(g.scale));
    extend(scaled);
    return mesh.name;
  }

  /// Refers to a file below the scene's folder, or copies it.
  std::string refer(const std::string& path, const std::string& bytes) {
    const std::string folder = context_.options.scene_folder.empty() ? context_.folder()
                                                                     : context_.options.scene_folder;
    const fs::path relative = fs::path(path).lexically_relative(folder);
    const std::string text = relative.string();
    const bool inside = !relative.empty() && *relative.begin() != fs::path("..");
    const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
      return is_letter(c) || is_digit(c) || std::strchr("-_./ +", c) != nullptr;
    });
    if (context_.options.copy_meshes.empty() && inside && plain) return text;
    return add_file(fs::path(path).filename().string(), bytes);
  }

  void joint(const RobotJoint& j) {
    using Type = RobotJoint::Type;
    std::string& out = *body_;
    if (j.type == Type::free && j.parent < 0) return;  // as every body of a scene
    const char* tag = "";
    switch (j.type) {
      case Type::fixed: tag = "fixed"; break;
      case Type::hinge: tag = "hinge"; break;
      case Type::slider: tag = "slider"; break;
      case Type::ball: tag = "ball"; break;
      case Type::planar: tag = "planar"; break;
      case Type::free: tag = "free"; break;
      case Type::universal: tag = "universal"; break;
      case Type::screw: tag = "screw"; break;
    }
    out += fmt::format("    <{} name=\"{}\"", tag, j.name);
    if (j.parent >= 0)
      out += fmt::format(" parent=\"{}\"", robot_.links[static_cast<std::size_t>(j.parent)].name);
    out += fmt::format(" child=\"{}\"", robot_.links[static_cast<std::size_t>(j.child)].name);
    if (j.anchor != Vec3::Zero())
      out += fmt::format(" frame=\"{}\" xyz=\"{}\"",
                         robot_.links[static_cast<std::size_t>(j.child)].name, list(tidy(j.anchor)));
    const bool turns = j.type == Type::hinge || j.type == Type::screw;
    const bool slides = j.type == Type::slider;
    if ((turns || slides || j.type == Type::planar || j.type == Type::universal) &&
        tidy(j.axis) != Vec3::UnitZ())
      out += fmt::format(" axis=\"{}\"", list(tidy(j.axis)));
    if (j.type == Type::universal) out += fmt::format(" axis2=\"{}\"", list(tidy(j.axis2)));
    if (j.type == Type::screw) out += fmt::format(" pitch=\"{} m\"", j.pitch);
    if (turns || slides) {
      const char* unit = turns ? "rad" : "m";
      const char* effort = turns ? "N*m" : "N";
      if (std::isfinite(j.lower)) out += fmt::format(" lower=\"{} {}\"", j.lower, unit);
      if (std::isfinite(j.upper)) out += fmt::format(" upper=\"{} {}\"", j.upper, unit);
      if (j.damping > 0.0)
        out += fmt::format(" damping=\"{} {}\"", j.damping, turns ? "N*m*s/rad" : "N*s/m");
      if (j.friction > 0.0) out += fmt::format(" friction=\"{} {}\"", j.friction, effort);
      if (j.stiffness > 0.0) {
        out += fmt::format(" stiffness=\"{} {}\"", j.stiffness, turns ? "N*m/rad" : "N/m");
        if (j.rest != 0.0) out += fmt::format(" rest=\"{} {}\"", j.rest, unit);
      }
      if (std::isfinite(j.max_effort)) out += fmt::format(" max-effort=\"{} {}\"", j.max_effort, effort);
      if (std::isfinite(j.max_speed)) out += fmt::format(" max-speed=\"{} {}/s\"", j.max_speed, unit);
      const double start = start_of(j);
      if (start != 0.0) {
        out += fmt::format(" position=\"{} {}\"", start, unit);
        if (j.position == 0.0)
          context_.approximate(j.at, fmt::format("joint '{}'", j.name),
                               fmt::format("zero lies beyond its limits: it starts at {}", start));
      }
    } else if (j.damping > 0.0 && j.type == Type::ball) {
      out += fmt::format(" damping=\"{} N*m*s/rad\"", j.damping);
    }
    out += "/>\n";
    if (j.rotor_inertia > 0.0)
      context_.left_out(j.at, fmt::format("rotor inertia of joint '{}'", j.name),
                        fmt::format("{} kg m^2: the scene language has no word for it",
                                    j.rotor_inertia));
    if (j.coupling)
      context_.left_out(j.at, fmt::format("coupling of joint '{}' to '{}'", j.name, j.coupling->joint),
                        "the scene language has no word for it: the joint moves freely");
  }

  void drives() {
    std::string& out = *body_;
    const auto one = [&](const RobotDrive& d, const RobotJoint& j) {
      const bool turns = j.type != RobotJoint::Type::slider;
      const std::string bound =
          std::isfinite(d.max_effort)
              ? fmt::format(" {}=\"{} {}\"", turns ? "max-torque" : "max-force", d.max_effort,
                            turns ? "N*m" : "N")
              : std::string();
      if (d.mode == RobotDrive::Mode::position && d.kp > 0.0) {
        out += fmt::format("    <servo name=\"{}\" joint=\"{}\" kp=\"{} {}\"", d.name, d.joint, d.kp,
                           turns ? "N*m/rad" : "N/m");
        if (d.kd > 0.0) out += fmt::format(" kd=\"{} {}\"", d.kd, turns ? "N*m*s/rad" : "N*s/m");
        out += bound;
        if (d.target) out += fmt::format(" target=\"{} {}\"", *d.target, turns ? "rad" : "m");
        out += "/>\n";
        return;
      }
      const char* mode = d.mode == RobotDrive::Mode::position   ? "position"
                         : d.mode == RobotDrive::Mode::velocity ? "velocity"
                                                                : "torque";
      out += fmt::format("    <motor name=\"{}\" joint=\"{}\" mode=\"{}\"{}/>\n", d.name, d.joint,
                         mode, bound);
    };
    for (const RobotDrive& d : robot_.drives) {
      const int j = robot_.joint(d.joint);
      if (j >= 0) one(d, robot_.joints[static_cast<std::size_t>(j)]);
    }
    if (context_.options.drives == ImportDrives::none || !robot_.drives.empty()) return;
    for (const RobotJoint& j : robot_.joints) {
      if (j.type != RobotJoint::Type::hinge && j.type != RobotJoint::Type::slider) continue;
      if (j.coupling) continue;
      RobotDrive d;
      d.joint = j.name;
      d.name = j.name + "_motor";
      for (int i = 2; robot_.joint(d.name) >= 0 || robot_.link(d.name) >= 0; ++i)
        d.name = fmt::format("{}_motor{}", j.name, i);
      d.max_effort = j.max_effort;
      d.mode = context_.options.drives == ImportDrives::position   ? RobotDrive::Mode::position
               : context_.options.drives == ImportDrives::velocity ? RobotDrive::Mode::velocity
                                                                   : RobotDrive::Mode::torque;
      one(d, j);
    }
  }

  void sensor(const RobotLink& l, const RobotSensor& s) {
    std::string& out = *body_;
    out += fmt::format("    <{} name=\"{}\"", s.element, s.name);
    if (!s.joint.empty())
      out += fmt::format(" joint=\"{}\"", s.joint);
    else
      out += fmt::format(" on=\"{}\"{}", l.name, placed(s.X));
    for (const auto& [key, value] : s.attributes) out += fmt::format(" {}=\"{}\"", key, escaped(value));
    out += "/>\n";
  }

  struct Mesh {
    std::string name;
    Bounds bounds;
  };

  Context& context_;
  const RobotModel& robot_;
  std::string* body_ = nullptr;
  std::vector<Pose> poses_;
  Bounds extent_;
  Vec3 scale_left_ = Vec3::Ones();
  std::map<std::string, Mesh> meshes_;
  std::set<std::string> file_names_, shape_names_;
};

}  // namespace

void write_scene(Context& context, const RobotModel& robot) { SceneWriter(context, robot).write(); }

}  // namespace cogrsim::dsl::import
