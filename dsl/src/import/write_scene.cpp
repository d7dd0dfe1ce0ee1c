// A robot as a scene, as a person would write it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <unordered_map>

#include "assets/mesh_file.h"
#include "cogrsim/geometry/convex_parts.h"
#include "import/robot_start.h"
#include "import/scene_parts.h"
#include "import/scene_text.h"
#include "syntax/text.h"

namespace cogrsim::dsl::import {

namespace fs = std::filesystem;

namespace {

// Steps of finding convex parts, each some 6 ns: 0.3 s for a model, and 2 s for 100 kB of its meshes.
constexpr std::size_t kStepsOfModel = 50'000'000, kStepsOfByte = 3000;

class SceneWriter {
 public:
  SceneWriter(Context& context, const RobotModel& robot)
      : context_(context), robot_(robot), start_(context, robot) {}

  void write() {
    std::string body, scenery;
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      body_ = robot_.links[i].is_scenery ? &scenery : &body;
      link(i);
    }
    body_ = &body;
    if (extent_.empty()) extent_ = seen_;
    if (context_.options.floor && !context_.options.prototype_only && !robot_.has_ground &&
        !extent_.empty() && std::isfinite(extent_.low[2]))
      lift_ = std::ceil(-extent_.low[2] * 1e4) / 1e4;
    for (const RobotJoint& j : robot_.joints) joint(j);
    for (const RobotJoint& j : robot_.loops)
      if (start_.closes(j)) joint(j);
    couplings();
    drives();
    springs();
    forces();
    for (const RobotLight& l : robot_.lights) body += light_text(l);
    for (const RobotLink& l : robot_.links)
      for (const RobotSensor& s : l.sensors) sensor(l, s);
    std::string apart;  // pairs of the robot and what stands around it
    for (const auto& [a, b] : robot_.no_contact) {
      if (is_scenery(a) == is_scenery(b))
        (is_scenery(a) ? scenery : body) +=
            fmt::format("    <collide between=\"{} {}\" with=\"false\"/>\n", a, b);
      else
        apart += fmt::format("  <collide between=\"{} {}\" with=\"false\"/>\n", in_scene(a),
                             in_scene(b));
    }

    const std::string name = scene_name(robot_.name);
    std::string type = name;
    if (type.front() >= 'a' && type.front() <= 'z')
      type.front() = static_cast<char>(type.front() - 'a' + 'A');
    if (type == name) type += "_model";

    std::string out = fmt::format("<scene name=\"{}\" version=\"1\">\n", escaped(name));
    out += fmt::format("  <!-- Written by cogrsim import from {}, {}. -->\n",
                       context_.result.format, comment(context_.shown(context_.path_of(0))));
    if (context_.options.prototype_only) {
      if (!apart.empty())
        context_.left_out({}, robot_.contact_rule,
                          "pairs of the robot and what stands around it belong into the scene that "
                          "has both:" +
                              apart);
      out += materials_text(robot_);
      if (!scenery.empty())
        out += fmt::format("  <prototype name=\"{}_scenery\">\n{}  </prototype>\n", type, scenery);
      out += fmt::format("  <prototype name=\"{}\">\n{}  </prototype>\n</scene>\n", type, body);
      context_.result.scene = std::move(out);
      return;
    }
    out += physics_text(robot_) + materials_text(robot_);
    if (robot_.wind && *robot_.wind != Vec3::Zero())
      out += fmt::format("  <wind velocity=\"{}\"/>\n", list(*robot_.wind));
    if (!scenery.empty())
      out += fmt::format("  <prototype name=\"{}_scenery\">\n{}  </prototype>\n", type, scenery);
    out += fmt::format("  <prototype name=\"{}\">\n{}  </prototype>\n", type, body);
    if (context_.options.floor && !robot_.has_ground)
      out += "  <plane name=\"floor\" color=\"#d8d8d8\"/>\n";
    for (const char* part : {"_scenery", ""}) {
      if (*part != '\0' && scenery.empty()) continue;
      out += fmt::format("  <instance of=\"{}{}\" name=\"{}{}\"", type, part, name, part);
      if (lift_ != 0.0) out += fmt::format(" xyz=\"0 0 {}\"", lift_);
      out += "/>\n";
    }
    out += apart;
    if (robot_.only_contact) {
      out += fmt::format("  <collide between=\"{0} {0}\" with=\"false\"/>\n", name);
      if (!scenery.empty())
        out += fmt::format("  <collide between=\"{0} {0}_scenery\" with=\"false\"/>\n", name);
      for (const auto& [a, b] : *robot_.only_contact)
        out += fmt::format("  <collide between=\"{} {}\"/>\n", in_scene(a), in_scene(b));
    }
    out += "</scene>\n";
    context_.result.scene = std::move(out);
  }

 private:
  bool is_scenery(const std::string& link) const {
    const int found = robot_.link(link);
    return found >= 0 && robot_.links[static_cast<std::size_t>(found)].is_scenery;
  }
  /// The name of a body outside of the prototypes.
  std::string in_scene(const std::string& link) const {
    return fmt::format("{}{}.{}", scene_name(robot_.name), is_scenery(link) ? "_scenery" : "",
                       link);
  }

  void link(std::size_t index) {
    const RobotLink& l = robot_.links[index];
    std::string& out = *body_;
    out += fmt::format("    <body name=\"{}\"", l.name);
    const RobotJoint* by = nullptr;
    for (const RobotJoint& j : robot_.joints)
      if (j.child == static_cast<int>(index)) by = &j;
    if (by != nullptr) {
      if (by->parent >= 0) out += fmt::format(" frame=\"{}\"", robot_.links[by->parent].name);
      out += pose_text(by->X_PC);
    } else {
      out += pose_text(l.X);
    }
    if (l.is_static) out += " static=\"true\"";
    if (!l.is_static && l.gravity_scale != 1.0)
      out += fmt::format(" gravity-scale=\"{}\"", l.gravity_scale);
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
        const RobotShape& seen = s.visible ? l.shapes[i] : o;
        if (!s.collides) s = o;  // whose surface it has
        if (!l.shapes[i].name.empty()) s.name = l.shapes[i].name;
        s.visible = s.collides = true;
        if (seen.color) s.color = seen.color;
        if (!seen.texture.empty()) s.texture = seen.texture;
        break;
      }
      if (s.geometry.type == Geometry::Type::mesh) look(l, s);
      inner += shape(l, s, start_.poses()[index]);
    }
    for (const RobotFrame& f : l.frames)
      inner += fmt::format("      <frame name=\"{}\"{}/>\n", f.name, pose_text(f.X));
    out += inner.empty() ? "/>\n" : ">\n" + inner + "    </body>\n";
  }

  /// Takes the colour that a mesh brings along, and reports how else it looks.
  void look(const RobotLink& l, RobotShape& s) {
    const std::string& file = s.geometry.mesh;
    if (!context_.mesh_bounds(file)) return;
    const MeshLook& look = context_.mesh_look(file);
    std::string differs;
    if (look.is_gltf && context_.result.format == "SDF")
      differs = "its y axis points up, as glTF and Drake have it; Gazebo does not turn it";
    if (s.visible && !s.color) {
      s.color = look.color;
      if (!look.differs.empty()) add_to(differs, look.differs);
    }
    if (!differs.empty())
      context_.approximate(
          s.at, fmt::format("mesh '{}' of '{}'", fs::path(file).filename().string(), l.name),
          differs);
  }

  static bool same(const RobotShape& a, const RobotShape& b) {
    const Geometry &x = a.geometry, &y = b.geometry;
    return x.type == y.type && x.type != Geometry::Type::mesh && x.points == y.points &&
           x.heights == y.heights && x.size == y.size && x.radius == y.radius &&
           x.length == y.length && a.X.p == b.X.p && a.X.q.coeffs() == b.X.q.coeffs();
  }

  std::string shape(const RobotLink& l, const RobotShape& s, const Pose& X_RL) {
    std::string out;
    for (const std::string& file : parts(l, s, X_RL * s.X))
      out += element(l, s, {"mesh", mesh_attributes(s, file) + " convex=\"true\""});
    return out.empty() ? element(l, s, geometry(l, s, X_RL * s.X)) : out;
  }

  struct ShapeText {
    std::string tag, attributes;
  };
  std::string element(const RobotLink& l, const RobotShape& s, const ShapeText& text) {
    if (text.tag.empty()) return "";
    std::string out = "      <" + text.tag + shape_name(l, s) + text.attributes + pose_text(s.X);
    if (s.color) out += color_text(*s.color);
    if (s.collides) out += surface_text(robot_, s);
    if (!s.collides) out += " collide=\"false\"";
    if (!s.visible) out += " visible=\"false\"";
    return out + "/>\n";
  }

  /// The geometry as an element of the scene; without a tag it is left out. `X`: pose of the shape in
  /// the robot, whose extent grows by what collides.
  ShapeText geometry(const RobotLink& l, const RobotShape& s, const Pose& X) {
    const Geometry& g = s.geometry;
    switch (g.type) {
      case Geometry::Type::box: {
        Bounds b;
        b.add(0.5 * g.size);
        b.add(-0.5 * g.size);
        extend(s, X, b);
        return {"box", fmt::format(" size=\"{}\"", list(g.size))};
      }
      case Geometry::Type::sphere:
        extend_about(s, X.p, Vec3::Constant(g.radius));  // not its box: that grows where it turns
        return {"sphere", fmt::format(" radius=\"{}\"", g.radius)};
      case Geometry::Type::cylinder:
      case Geometry::Type::capsule: {
        const bool capsule = g.type == Geometry::Type::capsule;
        // Extent along an axis e of a disc of radius r with the normal n: r sqrt(1 - (n e)²).
        const Vec3 n = X.q * Vec3::UnitZ();
        Vec3 half = 0.5 * g.length * n.cwiseAbs();
        for (int i = 0; i < 3; ++i)
          half[i] += capsule ? g.radius : g.radius * std::sqrt(std::max(0.0, 1.0 - n[i] * n[i]));
        extend_about(s, X.p, half);
        return {capsule ? "capsule" : "cylinder",
                fmt::format(" radius=\"{}\" length=\"{}\"", g.radius, g.length)};
      }
      case Geometry::Type::plane:
        return {"plane", ""};
      case Geometry::Type::ellipsoid: {
        // Half extent along an axis e of axes a_i n_i: the length of (a_i n_i . e).
        const Mat3 axes = X.q.toRotationMatrix() * g.size.asDiagonal();
        extend_about(s, X.p, axes.rowwise().norm());
        return {"ellipsoid", fmt::format(" radii=\"{}\"", list(g.size))};
      }
      case Geometry::Type::cone: {
        Bounds b;
        b.add(Vec3(g.radius, g.radius, 0.5 * g.length));
        b.add(Vec3(-g.radius, -g.radius, -0.5 * g.length));
        extend(s, X, b);
        return {"cone", fmt::format(" radius=\"{}\" length=\"{}\"", g.radius, g.length)};
      }
      case Geometry::Type::prism:
        return prism(s, X);
      case Geometry::Type::mesh:
        return mesh(l, s, X);
      case Geometry::Type::heightmap:
        return heightmap(l, s);
    }
    return {};
  }

  ShapeText prism(const RobotShape& s, const Pose& X) {
    std::string text;
    Bounds b;
    const Vec3 half(0.0, 0.0, 0.5 * s.geometry.length);
    for (const Vec3& p : s.geometry.points) {
      b.add(p + half);
      b.add(p - half);
      text += fmt::format("{}{} {}", text.empty() ? "" : " ", tidy(p[0]), tidy(p[1]));
    }
    extend(s, X, b);
    return {"prism", fmt::format(" outline=\"{}\" length=\"{}\"", text, s.geometry.length)};
  }

  /// The files of a mesh's convex parts. None: it is to be one mesh, or is one hull in any case.
  std::vector<std::string> parts(const RobotLink& l, const RobotShape& s, const Pose& X) {
    const ImportOptions& options = context_.options;
    if (options.convex_parts <= 0 || s.geometry.type != Geometry::Type::mesh || !s.collides ||
        l.is_static || context_.result.format == "MJCF")
      return {};
    const auto& bounds = context_.mesh_bounds(s.geometry.mesh);
    if (!bounds) return {};
    const auto [known, is_new] = parts_.try_emplace(s.geometry.mesh);
    Parts& parts = known->second;
    if (is_new) {
      const fs::path path = s.geometry.mesh;
      const auto mesh = context_.mesh(path, path.filename().string());
      if (!mesh) return {};
      if (options.decomposing) options.decomposing(path.filename().string());
      geometry::ConvexPartsOptions how;
      how.most = options.convex_parts;
      // A small file does not keep a machine busy; a large one may take longer.
      std::error_code fault;
      const std::uintmax_t bytes = fs::file_size(path, fault);
      steps_left_ += fault ? 0 : kStepsOfByte * static_cast<std::size_t>(bytes);
      how.steps = steps_left_;
      geometry::ConvexParts found = geometry::convex_parts(mesh->mesh, how);
      parts.excess = found.excess;
      parts.excess_of_hull = found.excess_of_hull;
      parts.cut_short = found.cut_short;
      steps_left_ -= std::min(steps_left_, found.steps);
      if (found.hulls.size() > 1)
        for (std::size_t i = 0; i < found.hulls.size(); ++i)
          parts.files.push_back(add_file(fmt::format("{}_part{}.obj", path.stem().string(), i + 1),
                                         "# CogRSim convex part\n" + obj_text(found.hulls[i])));
    }
    if (parts.files.empty()) return {};
    extend(s, X, bounds->scaled(s.geometry.scale));
    context_.approximate(
        s.at, fmt::format("collision mesh of '{}'", l.name),
        fmt::format("collides as {} convex parts, which cover {:.2g} % too much; its hull would "
                    "cover {:.2g} %{}",
                    parts.files.size(), 100.0 * parts.excess, 100.0 * parts.excess_of_hull,
                    parts.cut_short ? "; better ones take too long to find" : ""));
    return parts.files;
  }

  ShapeText mesh(const RobotLink& l, const RobotShape& s, const Pose& X) {
    const std::string file = mesh_file(l, s, X);
    if (file.empty()) return {};
    std::string attributes = mesh_attributes(s, file);
    // MuJoCo's meshes collide as their hulls, also of static bodies.
    const bool is_hull = s.collides && context_.result.format == "MJCF";
    const bool convex = !l.is_static || is_hull;
    if (convex) attributes += " convex=\"true\"";
    if (s.collides && convex && !is_hull)
      context_.approximate(s.at, fmt::format("collision mesh of '{}'", l.name),
                           "collides as its convex hull");
    return {"mesh", attributes};
  }

  ShapeText heightmap(const RobotLink& l, const RobotShape& s) {
    if (!l.is_static) {
      context_.left_out(s.at, fmt::format("height field of '{}'", l.name),
                        "moves, and a heightmap never does");
      return {};
    }
    constexpr std::size_t kMostInScene = 400;
    const Geometry& g = s.geometry;
    const HeightField& field = *g.heights;
    std::string attributes = fmt::format(" size=\"{} {}\"", g.size[0], g.size[1]), text;
    auto pay = [&, paid = std::size_t{0}]() mutable {
      context_.spend(20 + 4 * (text.size() - paid), s.at);
      paid = text.size();
    };
    // Rows of a scene begin at the lowest y, those of a file at the highest.
    if (field.samples.size() <= kMostInScene || context_.options.prototype_only) {
      for (int r = field.rows - 1; r >= 0; --r)
        for (int c = 0; c < field.columns; ++c, pay())
          text += fmt::format("{}{}", text.empty() ? "" : " ",
                              g.size[2] * field.samples[r * field.columns + c]);
      return {"heightmap",
              attributes + fmt::format(" columns=\"{}\" heights=\"{}\"", field.columns, text)};
    }
    auto& file = hills_[g.heights.get()];
    if (file.empty()) {
      for (std::size_t i = 0; i < field.samples.size(); ++i, pay())
        text += fmt::format("{}{}", field.samples[i],
                            (i + 1) % static_cast<std::size_t>(field.columns) == 0 ? "\n" : " ");
      file = add_file("heights.txt", std::move(text));
    }
    return {"heightmap", attributes + fmt::format(" file=\"{}\" height=\"{} m\"", file, g.size[2])};
  }

  /// The attribute `name`, where the source's name is one that a scene takes and is not taken yet.
  std::string shape_name(const RobotLink& l, const RobotShape& s) {
    if (s.name.empty()) return "";
    std::string name = s.name;
    for (char& c : name)
      if (!is_letter(c) && !is_digit(c) && c != '-') c = '_';
    const bool is_new = is_letter(name.front()) &&
                        shape_names_.insert(l.name + "." + name).second &&
                        std::none_of(l.frames.begin(), l.frames.end(),
                                     [&](const RobotFrame& f) { return f.name == name; });
    return is_new ? fmt::format(" name=\"{}\"", name) : "";
  }

  /// Bounds in the shape's frame.
  void extend(const RobotShape& s, const Pose& X, const Bounds& b) {
    Bounds& of_all = s.collides ? extent_ : seen_;
    for (int i = 0; i < 8 && !b.empty(); ++i)
      of_all.add(X * Vec3(i & 1 ? b.high[0] : b.low[0], i & 2 ? b.high[1] : b.low[1],
                          i & 4 ? b.high[2] : b.low[2]));
  }

  /// Half extents along the robot's axes.
  void extend_about(const RobotShape& s, const Vec3& centre, const Vec3& half) {
    Bounds& of_all = s.collides ? extent_ : seen_;
    of_all.add(centre + half);
    of_all.add(centre - half);
  }

  std::string add_file(const std::string& wanted, std::string bytes) {
    const std::string folder =
        context_.options.copy_meshes.empty() ? "meshes" : context_.options.copy_meshes;
    std::string name;
    for (const char c : wanted)
      name += is_letter(c) || is_digit(c) || c == '.' || c == '-' ? c : '_';
    if (name.empty() || name.front() == '.') name.insert(0, "_");
    const std::string stem = fs::path(name).stem().string();
    const std::string tail = fs::path(name).extension().string();
    std::string full = folder + "/" + name;
    for (int i = 2;; ++i) {
      if (const auto known = written_.find(full); known != written_.end()) {
        if (context_.result.files[known->second].bytes == bytes) return full;
      } else if (is_free(full, bytes)) {
        break;
      }
      full = fmt::format("{}/{}_{}{}", folder, stem, i, tail);
    }
    written_.emplace(full, context_.result.files.size());
    context_.result.files.push_back({full, std::move(bytes)});
    return full;
  }

  /// Whether no other file of this name is beside the scene: another robot may have put it there.
  bool is_free(const std::string& name, const std::string& bytes) const {
    const ImportOptions& options = context_.options;
    const fs::path path =
        fs::path(options.scene_folder.empty() ? context_.folder() : options.scene_folder) / name;
    std::error_code fault;
    if (!fs::exists(path, fault)) return true;
    return fs::is_regular_file(path, fault) && fs::file_size(path, fault) == bytes.size() &&
           read_whole_file(path.string(), bytes.size()).value_or("") == bytes;
  }

  /// The file's name for the scene; empty: left out.
  std::string mesh_file(const RobotLink& l, const RobotShape& s, const Pose& X) {
    const Geometry& g = s.geometry;
    const auto& bounds = context_.mesh_bounds(g.mesh);
    const auto [known, is_new] = meshes_.try_emplace(g.mesh);
    if (is_new && bounds) known->second = refer(g.mesh);
    if (known->second.empty()) {
      context_.left_out(
          s.at, fmt::format("mesh '{}' of '{}'", fs::path(g.mesh).filename().string(), l.name),
          bounds ? "its name has characters that a scene does not take" : bounds.error().message);
      return "";
    }
    extend(s, X, bounds->scaled(g.scale));
    return known->second;
  }

  /// Refers to a file below the scene's folder, or copies it. Empty: neither is possible.
  std::string refer(const std::string& path) {
    const ImportOptions& options = context_.options;
    const std::string folder =
        options.scene_folder.empty() ? context_.folder() : options.scene_folder;
    const fs::path relative = fs::path(path).lexically_relative(folder);
    const std::string text = relative.string();
    const bool inside = !relative.empty() && (options.refer || *relative.begin() != fs::path(".."));
    const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
      return is_letter(c) || is_digit(c) || std::strchr("-_./ +", c) != nullptr;
    });
    if (options.copy_meshes.empty() && inside && plain) return text;
    if (options.refer) return "";
    const fs::path name = fs::path(path).filename();
    if (!context_.mesh_look(path).is_of_several)
      return add_file(name.string(),
                      read_whole_file(path, options.limits.asset_bytes).value_or(""));
    const auto whole = context_.mesh(path, name.string());
    return whole ? add_file(name.stem().string() + ".obj", obj_text(whole->mesh)) : "";
  }

  /// The two numbers of each law of a universal joint, where one of them says something.
  void two_axes(const RobotJoint& j, std::string& out) {
    const auto both = [&](const char* name, double one, double two, double nothing,
                          const char* unit) {
      const auto text = [&](double v) {
        return std::isfinite(v) ? fmt::format("{}{}", v, unit) : "none";
      };
      if (one != nothing || two != nothing)
        out += fmt::format(" {}=\"{} {}\"", name, text(one), text(two));
    };
    const AxisLaw &a = j, &b = j.second, none;
    both("lower", a.lower, b.lower, none.lower, " rad");
    both("upper", a.upper, b.upper, none.upper, " rad");
    both("damping", a.damping, b.damping, 0.0, " N*m*s/rad");
    both("friction", a.friction, b.friction, 0.0, " N*m");
    both("stiffness", a.stiffness, b.stiffness, 0.0, " N*m/rad");
    both("rest", a.rest, b.rest, 0.0, " rad");
    both("max-effort", a.max_effort, b.max_effort, none.max_effort, " N*m");
    both("max-speed", a.max_speed, b.max_speed, none.max_speed, " rad/s");
    const double q1 = std::clamp(0.0, a.lower, a.upper), q2 = std::clamp(0.0, b.lower, b.upper);
    both("position", q1, q2, 0.0, " rad");
    if (q1 != 0.0 || q2 != 0.0)
      context_.approximate(
          j.at, fmt::format("joint '{}'", j.name),
          fmt::format("zero lies beyond its limits: it starts at {} and {}", q1, q2));
  }

  void joint(const RobotJoint& j) {
    using Type = RobotJoint::Type;
    std::string& out = *body_;
    if (j.type == Type::free) return;  // as every body of a scene
    const char* tag = "";
    switch (j.type) {
      case Type::fixed:
        tag = "fixed";
        break;
      case Type::hinge:
        tag = "hinge";
        break;
      case Type::slider:
        tag = "slider";
        break;
      case Type::ball:
        tag = "ball";
        break;
      case Type::planar:
        tag = "planar";
        break;
      case Type::free:
        break;
      case Type::universal:
        tag = "universal";
        break;
      case Type::screw:
        tag = "screw";
        break;
      case Type::gimbal:
        tag = "gimbal";
        break;
    }
    out += fmt::format("    <{} name=\"{}\"", tag, j.name);
    if (j.parent >= 0) out += fmt::format(" parent=\"{}\"", robot_.links[j.parent].name);
    out += fmt::format(" child=\"{}\"", robot_.links[j.child].name);
    if (j.anchor != Vec3::Zero())
      out +=
          fmt::format(" frame=\"{}\" xyz=\"{}\"", robot_.links[j.child].name, list(tidy(j.anchor)));
    const bool turns = j.type == Type::hinge || j.type == Type::screw;
    const bool slides = j.type == Type::slider;
    if ((turns || slides || j.type == Type::planar || j.type == Type::universal) &&
        tidy(j.axis) != Vec3::UnitZ())
      out += fmt::format(" axis=\"{}\"", list(tidy(j.axis)));
    if (j.type == Type::gimbal) out += fmt::format(" axis=\"{}\"", list(tidy(j.axis)));
    if (j.type == Type::universal || j.type == Type::gimbal)
      out += fmt::format(" axis2=\"{}\"", list(tidy(j.axis2)));
    if (j.type == Type::screw) out += fmt::format(" pitch=\"{} m\"", j.pitch);
    if (turns || slides) {
      const char* unit = turns ? "rad" : "m";
      const char* effort = turns ? "N*m" : "N";
      if (std::isfinite(j.lower)) out += fmt::format(" lower=\"{} {}\"", j.lower, unit);
      if (std::isfinite(j.upper)) out += fmt::format(" upper=\"{} {}\"", j.upper, unit);
      out += passive_text(j);
      if (std::isfinite(j.max_effort))
        out += fmt::format(" max-effort=\"{} {}\"", j.max_effort, effort);
      if (std::isfinite(j.max_speed))
        out += fmt::format(" max-speed=\"{} {}/s\"", j.max_speed, unit);
      // A joint that follows others starts where they put it; a zero beyond its limits is an error.
      const bool follows = start_.follows(j);
      const double start = std::clamp(start_.position(j), j.lower, j.upper);
      if (follows ? j.lower > 0.0 || j.upper < 0.0 : start != 0.0)
        out += fmt::format(" position=\"{} {}\"", start, unit);
      if (!follows && start != j.position)
        context_.approximate(
            j.at, fmt::format("joint '{}'", j.name),
            fmt::format("{} lies beyond its limits: it starts at {}",
                        j.position == 0.0 ? "zero" : fmt::format("its start {}", j.position),
                        start));
    } else if (j.type == Type::universal) {
      two_axes(j, out);
    } else if (j.type == Type::gimbal) {
      out += gimbal_text(j);
    } else if (j.type == Type::ball) {
      if (std::isfinite(j.upper)) out += fmt::format(" upper=\"{} rad\"", j.upper);
      out += passive_text(j);
      if (j.turn.vec().norm() > 0.0)
        out += fmt::format(" position=\"{} {} {} {}\"", j.turn.w(), j.turn.x(), j.turn.y(),
                           j.turn.z());
    }
    if (j.rotor_inertia > 0.0 && (turns || slides || j.type == Type::ball))
      out += fmt::format(" rotor-inertia=\"{} {}\"", j.rotor_inertia, slides ? "kg" : "kg*m^2");
    out += end_text(tag, j.of_mujoco);
    if (j.rotor_inertia > 0.0 && !turns && !slides && j.type != Type::ball &&
        j.type != Type::gimbal)
      context_.left_out(j.at, fmt::format("rotor inertia of joint '{}'", j.name),
                        fmt::format("a {} joint has none here", tag));
  }

  static std::string leaders(const RobotCoupling& coupling, const char* between) {
    std::string out;
    for (const RobotCoupling::Term& t : coupling.terms) add_to(out, t.joint, between);
    return out;
  }

  void couplings() {
    for (const RobotJoint& j : robot_.joints) {
      const auto why = start_.uncoupled().find(&j);
      if (why == start_.uncoupled().end()) continue;
      context_.left_out(
          j.at, fmt::format("coupling of joint '{}' to '{}'", j.name, leaders(*j.coupling, "', '")),
          why->second + ": the joint moves freely");
    }
    for (const RobotJoint* j : start_.coupled()) {
      const RobotCoupling& coupling = *j->coupling;
      *body_ += fmt::format("    <couple joint=\"{}\" to=\"{}\"", j->name, leaders(coupling, " "));
      std::string ratios;
      bool plain = true;
      for (const RobotCoupling::Term& t : coupling.terms) {
        add_to(ratios, fmt::format("{}", t.ratio), " ");
        plain = plain && t.ratio == 1.0;
      }
      if (!plain || coupling.terms.size() > 1) *body_ += fmt::format(" ratio=\"{}\"", ratios);
      if (tidy(coupling.offset) != 0.0)
        *body_ += fmt::format(" offset=\"{} {}\"", coupling.offset,
                              j->type == RobotJoint::Type::slider ? "m" : "rad");
      *body_ += end_text("couple", coupling.of_mujoco);
    }
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
      const char* unit = d.mode == RobotDrive::Mode::position   ? (turns ? "rad" : "m")
                         : d.mode == RobotDrive::Mode::velocity ? (turns ? "rad/s" : "m/s")
                         : turns                                ? "N*m"
                                                                : "N";
      std::string target;
      if (std::isfinite(d.min_target))
        target += fmt::format(" min-target=\"{} {}\"", d.min_target, unit);
      if (std::isfinite(d.max_target))
        target += fmt::format(" max-target=\"{} {}\"", d.max_target, unit);
      // A servo holds its joint where it starts.
      const double start = std::clamp(start_.position(j), j.lower, j.upper);
      if (d.target && (d.mode != RobotDrive::Mode::position || *d.target != start))
        target += fmt::format(" target=\"{} {}\"", *d.target, unit);
      if (d.mode == RobotDrive::Mode::position && d.kp > 0.0) {
        out += fmt::format("    <servo name=\"{}\" joint=\"{}\" kp=\"{} {}\"", d.name, d.joint,
                           d.kp, turns ? "N*m/rad" : "N/m");
        if (d.ki > 0.0)
          out += fmt::format(" ki=\"{} {}\"", d.ki, turns ? "N*m/(rad*s)" : "N/(m*s)");
        if (d.kd > 0.0) out += fmt::format(" kd=\"{} {}\"", d.kd, turns ? "N*m*s/rad" : "N*s/m");
        out += bound;
        out += target + "/>\n";
        return;
      }
      const char* mode = d.mode == RobotDrive::Mode::position   ? "position"
                         : d.mode == RobotDrive::Mode::velocity ? "velocity"
                                                                : "torque";
      out +=
          fmt::format("    <motor name=\"{}\" joint=\"{}\"{} mode=\"{}\"{}{}/>\n", d.name, d.joint,
                      d.axis > 1 ? fmt::format(" axis=\"{}\"", d.axis) : "", mode, bound, target);
    };
    std::set<std::string> moved;
    for (const RobotJoint* j : start_.coupled()) moved.insert(j->name);
    for (const RobotDrive& d : robot_.drives) {
      const int j = robot_.joint(d.joint);
      if (j < 0) continue;
      const RobotJoint& joint = robot_.joints[j];
      for (const std::string& follower : d.followers)
        if (moved.count(follower) == 0)
          context_.approximate(
              d.at, fmt::format("drive '{}'", d.name),
              fmt::format("does not move joint '{}', whose coupling is left out", follower));
      if (joint.type == RobotJoint::Type::hinge || joint.type == RobotJoint::Type::slider ||
          joint.type == RobotJoint::Type::gimbal)
        one(d, joint);
      else
        context_.left_out(d.at, fmt::format("drive '{}'", d.name),
                          "a motor drives a hinge or a slider, and its joint is neither");
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

  void springs() {
    if (robot_.springs.empty()) return;
    std::unordered_map<std::string, std::pair<std::size_t, const RobotFrame*>> frames;
    for (std::size_t i = 0; i < robot_.links.size(); ++i)
      for (const RobotFrame& f : robot_.links[i].frames) frames[f.name] = {i, &f};
    const std::vector<Pose> rest = start_.poses_at_rest();
    for (const RobotSpring& s : robot_.springs) {
      const auto& [a, at_a] = frames.at(s.ends[0]);
      const auto& [b, at_b] = frames.at(s.ends[1]);
      if (a == b || (robot_.links[a].is_static && robot_.links[b].is_static)) {
        context_.left_out(s.at, fmt::format("spring '{}'", s.name), "joins what does not move");
        continue;
      }
      const double length = s.length.value_or((rest[a] * at_a->X.p - rest[b] * at_b->X.p).norm());
      *body_ += fmt::format("    <spring name=\"{}\" between=\"{}.{} {}.{}\" stiffness=\"{} N/m\"",
                            s.name, robot_.links[a].name, s.ends[0], robot_.links[b].name,
                            s.ends[1], s.stiffness);
      if (s.damping > 0.0) *body_ += fmt::format(" damping=\"{} N*s/m\"", s.damping);
      *body_ +=
          fmt::format(" length=\"{} m\"{}/>\n", length, s.pulls_only ? " cable=\"true\"" : "");
    }
  }

  void forces() {
    for (const RobotLink& l : robot_.links) {
      if (l.is_static) continue;
      if (l.drag > 0.0 && l.inertia)
        *body_ += fmt::format("    <drag on=\"{}\" xyz=\"{}\" linear=\"{} N*s/m\"/>\n", l.name,
                              list(tidy(l.inertia->com)), l.drag);
      if (l.free_damping > 0.0)
        *body_ +=
            fmt::format("    <drag on=\"{}\" linear=\"{} N*s/m\" angular=\"{} N*m*s/rad\"/>\n",
                        l.name, l.free_damping, l.free_damping);
      if (l.fluid && std::any_of(l.shapes.begin(), l.shapes.end(),
                                 [](const RobotShape& s) { return s.collides; }))
        *body_ += fmt::format("    <buoyancy on=\"{}\" level=\"{} m\" density=\"{} kg/m^3\"/>\n",
                              l.name, l.fluid->level + lift_, l.fluid->density);
    }
  }

  /// Whether a point lies in a visible shape at the start, but for those of one link; of meshes it is
  /// not known.
  bool is_inside(const Vec3& p, std::size_t but) const {
    using Type = Geometry::Type;
    for (std::size_t i = 0; i < robot_.links.size(); ++i)
      for (const RobotShape& s : robot_.links[i].shapes) {
        if (i == but || !s.visible) continue;
        const Geometry& g = s.geometry;
        const Vec3 x = (start_.poses()[i] * s.X).inverse() * p;
        const double r = std::hypot(x[0], x[1]), h = std::abs(x[2]);
        if (g.type == Type::sphere && x.norm() < g.radius) return true;
        if (g.type == Type::plane && x[2] < 0.0) return true;
        if (g.type == Type::box && (x.cwiseAbs().array() < 0.5 * g.size.array()).all()) return true;
        if (g.type == Type::cylinder && r < g.radius && h < 0.5 * g.length) return true;
        if (g.type == Type::capsule && std::hypot(r, std::max(0.0, h - 0.5 * g.length)) < g.radius)
          return true;
      }
    return false;
  }

  void sensor(const RobotLink& l, const RobotSensor& s) {
    const Context::Aside reads(context_);
    std::string& out = *body_;
    const auto own = static_cast<std::size_t>(&l - robot_.links.data());
    const Vec3 p = start_.poses()[own] * s.X.p;
    const bool below_floor =
        context_.options.floor && !robot_.has_ground && !extent_.empty() && p[2] < extent_.low[2];
    if (s.element == "camera" && (below_floor || is_inside(p, own))) {
      context_.left_out(s.at, fmt::format("camera '{}'", s.name),
                        below_floor ? "lies below the floor, where it would see nothing"
                                    : "lies inside another body, where it would see nothing");
      return;
    }
    out += fmt::format("    <{} name=\"{}\"", s.element, s.name);
    if (!s.joint.empty())
      out += fmt::format(" joint=\"{}\"", s.joint);
    else
      out += fmt::format(" on=\"{}\"{}", l.name, pose_text(s.X));
    for (const auto& [key, value] : s.attributes)
      out += fmt::format(" {}=\"{}\"", key, escaped(value));
    out += "/>\n";
  }

  Context& context_;
  const RobotModel& robot_;
  RobotStart start_;
  std::string* body_ = nullptr;
  Bounds extent_, seen_;  // of what touches something, and of what is only seen
  double lift_ = 0.0;  // of the model onto its floor [m]
  struct Parts {
    std::vector<std::string> files;
    double excess = 0.0, excess_of_hull = 0.0;
    bool cut_short = false;
  };
  std::map<std::string, Parts> parts_;         // path → its convex parts
  std::size_t steps_left_ = kStepsOfModel;     // of finding them
  std::map<std::string, std::string> meshes_;  // path → the scene's name for it; empty: left out
  std::map<const HeightField*, std::string> hills_;  // file of each
  std::map<std::string, std::size_t> written_;       // file of the result by its name
  std::set<std::string> shape_names_;
};

}  // namespace

void write_scene(Context& context, const RobotModel& robot) { SceneWriter(context, robot).write(); }

}  // namespace cogrsim::dsl::import
