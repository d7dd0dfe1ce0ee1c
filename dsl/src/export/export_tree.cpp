#include "export/export_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "assets/mesh_file.h"
#include "syntax/text.h"

namespace cogrsim::dsl::exporting {

XmlWriter::XmlWriter(const std::string& comment) : printer_(nullptr, false) {
  printer_.PushHeader(false, true);
  printer_.PushComment((" " + comment + " ").c_str());
}
XmlWriter& XmlWriter::begin(const char* name) {
  printer_.OpenElement(name);
  return *this;
}
XmlWriter& XmlWriter::with(const char* name, const std::string& value) {
  printer_.PushAttribute(name, value.c_str());
  return *this;
}
XmlWriter& XmlWriter::with(const char* name, double value) { return with(name, number(value)); }
XmlWriter& XmlWriter::with(const char* name, const Vec3& value) {
  return with(name, numbers(value));
}
void XmlWriter::end() { printer_.CloseElement(); }
void XmlWriter::raw(const std::string& value) { printer_.PushText(value.c_str()); }
void XmlWriter::text(const char* name, const std::string& value) {
  begin(name);
  raw(value);
  end();
}
void XmlWriter::text(const char* name, double value) { text(name, number(value)); }
std::string XmlWriter::str() const { return printer_.CStr(); }

std::string number(double value) {
  return fmt::format("{}", std::abs(value) < 1e-15 ? 0.0 : value);
}
std::string numbers(const Vec3& v) {
  return fmt::format("{} {} {}", number(v[0]), number(v[1]), number(v[2]));
}

std::string lost_of(const Material& m, const SurfaceWritten& written) {
  const Material usual;
  std::string lost;
  const auto lose = [&](bool is_written, const char* name, double value, double otherwise) {
    if (!is_written && value != otherwise)
      lost += fmt::format("{}its {} {}", lost.empty() ? "" : ", ", name, number(value));
  };
  lose(written.friction, "friction", m.friction, usual.friction);
  lose(written.rolling, "rolling friction", m.rolling_friction, 0.0);
  lose(written.rolling, "spinning friction", m.spinning_friction, 0.0);
  lose(written.restitution, "restitution", m.restitution, 0.0);
  lose(written.stiffness, "stiffness", m.stiffness.value_or(0.0), 0.0);
  if (!lost.empty()) lost += lost.find(',') == std::string::npos ? " is left out" : " are left out";
  return lost;
}

std::vector<AxisStep> axis_steps(JointType type) {
  const AxisStep turn{true, false, Vec3::UnitZ()}, slide{false, true, Vec3::UnitZ()};
  switch (type) {
    case JointType::hinge:
      return {turn};
    case JointType::slider:
      return {slide};
    case JointType::screw:
    case JointType::cylindrical:
      return {turn, slide};
    case JointType::universal:
      return {{true, true, Vec3::UnitX()}, {true, false, Vec3::UnitY()}};
    case JointType::gimbal:
      return {{true, true, Vec3::UnitX()}, {true, false, Vec3::UnitY()}, turn};
    case JointType::planar:
      return {{false, true, Vec3::UnitX()}, {false, true, Vec3::UnitY()}, turn};
    default:
      return {};
  }
}

ExportTree::ExportTree(const SceneModel& m, const ExportOptions& o) : model(m), options(o) {
  select();
  build();
}

void ExportTree::report_pairs(const char* how, CombineRule rule) {
  std::set<int> used;
  for (const Body& b : model.bodies) {
    if (b.removed || !selected(b.assembly)) continue;
    for (const Shape& s : b.shapes)
      if (s.collides) used.insert(s.material);
  }
  std::size_t count = 0;
  double worst = 0.0;
  std::string example;
  const auto name = [&](const Material& m) {
    return m.name.empty() ? "friction " + number(m.friction) : "'" + m.name + "'";
  };
  for (auto a = used.begin(); a != used.end(); ++a)
    for (auto b = a; b != used.end(); ++b) {
      const Material &one = model.materials[index(*a)], &two = model.materials[index(*b)];
      const double here = surface_pair(model, *a, *b).friction;
      const double there = combine(rule, one.friction, two.friction);
      const double off = std::abs(here - there);
      if (off <= 1e-12 * std::max(here, there)) continue;
      ++count;
      if (off <= worst) continue;
      worst = off;
      example = fmt::format("{} and {} have {:.4g} here, {:.4g} there", name(one), name(two), here,
                            there);
    }
  if (count == 0) return;
  approximate({}, "friction of pairs",
              fmt::format("{}: {} of materials differ; {}", how,
                          count == 1 ? "a pair" : fmt::format("{} pairs", count), example));
}

bool ExportTree::selected(int assembly) const {
  return options.assembly.empty() || (assembly >= 0 && chosen_[index(assembly)]);
}

void ExportTree::select() {
  chosen_.assign(model.assemblies.size(), false);
  const int root = options.assembly.empty() ? -1 : find_assembly(model, options.assembly);
  for (std::size_t a = 0; a < model.assemblies.size(); ++a)
    for (int up = static_cast<int>(a); up >= 0; up = model.assemblies[index(up)].parent)
      if (up == root) chosen_[a] = true;
}

std::string ExportTree::unique_name(const std::string& kind, const std::string& dotted) {
  // The assembly's own name is that of the robot.
  std::string name = dotted;
  if (!options.assembly.empty() && name.rfind(options.assembly + ".", 0) == 0)
    name.erase(0, options.assembly.size() + 1);
  for (char& c : name)
    if (!is_letter(c) && !is_digit(c) && c != '_' && c != '-') c = '_';
  if (name.empty()) name = kind;
  std::set<std::string>& taken = names_[kind];
  std::string out = name;
  for (int i = 2; !taken.insert(out).second; ++i) out = fmt::format("{}_{}", name, i);
  return out;
}

std::string ExportTree::title() const {
  std::string name = options.assembly.empty() ? model.name : options.assembly;
  for (char& c : name)
    if (!is_letter(c) && !is_digit(c) && c != '_' && c != '-') c = '_';
  return name.empty() ? "scene" : name;
}

int ExportTree::link_of(int body) const { return body < 0 ? -1 : link_of_[index(body)]; }

/// The frames of the joint to the parent in the tree, which is the joint's child if `reversed`.
static void set_frames(Link& link, const Joint& j, bool reversed) {
  link.X_PF = j.X_PF;
  link.X_CM = j.X_CM;
  if (!reversed) return;
  // Half a turn about x reverses z, so that the coordinate keeps its sign.
  const Pose half(Vec3::Zero(), Quat(0, 1, 0, 0));
  link.X_PF = j.X_CM * half;
  link.X_CM = j.X_PF * half;
}

std::vector<std::vector<int>> ExportTree::find_joints(std::vector<bool>& wanted) {
  names_["body"].insert("world");
  body_names_.resize(model.bodies.size());
  joint_names_.resize(model.joints.size());
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    wanted[b] = !body.removed && selected(body.assembly);
    if (wanted[b]) body_names_[b] = unique_name("body", body.name);
  }
  const auto is_ground = [&](int body) {
    return body < 0 || model.bodies[index(body)].kind != BodyKind::dynamic;
  };
  std::vector<std::vector<int>> at(model.bodies.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed) continue;
    const bool parent = joint.parent >= 0 && wanted[index(joint.parent)];
    const bool child = joint.child >= 0 && wanted[index(joint.child)];
    if (!parent && !child) continue;
    if ((!parent && !is_ground(joint.parent)) || (!child && !is_ground(joint.child))) {
      left_out(joint.origin, "joint '" + joint.name + "'",
               "its other body is not in assembly '" + options.assembly + "'");
      continue;
    }
    joint_names_[j] = unique_name("joint", joint.name);
    if (joint.closes_loop) {
      loops.push_back(static_cast<int>(j));
      continue;
    }
    if (parent) at[index(joint.parent)].push_back(static_cast<int>(j));
    if (child) at[index(joint.child)].push_back(static_cast<int>(j));
  }
  return at;
}

void ExportTree::build() {
  std::vector<bool> wanted(model.bodies.size(), false);
  const std::vector<std::vector<int>> at = find_joints(wanted);
  link_of_.assign(model.bodies.size(), -1);
  std::set<int> used;
  std::deque<int> open;
  const auto take = [&](int body, int parent, int joint, bool reversed, bool grounded) {
    Link link;
    link.body = body;
    link.parent = parent;
    link.joint = joint;
    link.grounded = grounded;
    if (joint >= 0) {
      set_frames(link, model.joints[index(joint)], reversed);
      used.insert(joint);
    }
    link_of_[index(body)] = static_cast<int>(links.size());
    links.push_back(link);
    open.push_back(body);
  };
  const auto grow = [&] {
    while (!open.empty()) {
      const int body = open.front();
      open.pop_front();
      const int link = link_of_[index(body)];
      for (const int j : at[index(body)]) {
        if (used.count(j) != 0) continue;
        const Joint& joint = model.joints[index(j)];
        const bool reversed = joint.child == body;
        const int other = reversed ? joint.parent : joint.child;
        if (other < 0 || !wanted[index(other)] || link_of_[index(other)] >= 0) continue;
        if (reversed && (joint.type == JointType::universal || joint.type == JointType::gimbal ||
                         joint.type == JointType::planar)) {
          used.insert(j);
          left_out(joint.origin, "joint '" + joint.name + "'",
                   "its child would be the parent in the tree, which its axes do not allow");
          continue;
        }
        take(other, link, j, reversed, links[index(link)].grounded);
      }
    }
  };
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (wanted[b] && model.bodies[b].kind != BodyKind::dynamic)
      take(static_cast<int>(b), -1, -1, false, true);
  // Bodies held by the world itself, or by static bodies that are not selected.
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint_names_[j].empty() || joint.closes_loop || used.count(static_cast<int>(j)) != 0)
      continue;
    const bool parent_out = joint.parent < 0 || !wanted[index(joint.parent)];
    const bool child_out = joint.child < 0 || !wanted[index(joint.child)];
    const int body = parent_out ? joint.child : joint.parent;
    if ((!parent_out && !child_out) || link_of(body) >= 0) continue;
    take(body, -1, static_cast<int>(j), child_out, true);
    // F becomes a frame of the world.
    const int other = parent_out ? joint.parent : joint.child;
    if (other >= 0) links.back().X_PF = model.bodies[index(other)].X_WB * links.back().X_PF;
  }
  grow();
  // The base of what is free: a body that is not a joint's child, if there is one.
  for (const bool any : {false, true})
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      if (!wanted[b] || link_of_[b] >= 0) continue;
      const bool child = std::any_of(at[b].begin(), at[b].end(), [&](int j) {
        return model.joints[index(j)].child == static_cast<int>(b);
      });
      if (child && !any) continue;
      take(static_cast<int>(b), -1, -1, false, false);
      grow();
    }
  // Joints between bodies that the ground holds already.
  for (std::size_t j = 0; j < model.joints.size(); ++j)
    if (!joint_names_[j].empty() && !model.joints[j].closes_loop &&
        used.count(static_cast<int>(j)) == 0)
      loops.push_back(static_cast<int>(j));
}

std::string ExportTree::mesh_file(int mesh) {
  if (const auto known = mesh_files_.find(mesh); known != mesh_files_.end()) return known->second;
  const TriangleMesh& m = *model.meshes[index(mesh)];
  const std::size_t slash = m.name.find_last_of("/\\");
  std::string stem = slash == std::string::npos ? m.name : m.name.substr(slash + 1);
  stem = stem.substr(0, stem.rfind('.'));
  const std::string file =
      options.mesh_folder + "/" + unique_name("mesh", stem.empty() ? "mesh" : stem) + ".obj";
  result.files.push_back({file, obj_text(m)});
  return mesh_files_.emplace(mesh, file).first->second;
}

void ExportTree::add(Fidelity fidelity, const SourceSpan& at, const std::string& element,
                     const std::string& message) {
  static const std::set<std::string> kStill = {"light", "view", "maze",   "record",
                                               "plot",  "test", "measure"};
  const std::string kind = element.substr(0, element.find(' '));
  const bool reads = std::any_of(model.sensors.begin(), model.sensors.end(),
                                 [&](const SensorModel& s) { return s.type == kind; });
  const bool moves = !reads && kStill.count(kind) == 0;
  result.entries.push_back({source_position(model, at), fidelity, element, message, moves});
}
void ExportTree::exact(const SourceSpan& at, const std::string& element,
                       const std::string& message) {
  add(Fidelity::exact, at, element, message);
}
void ExportTree::approximate(const SourceSpan& at, const std::string& element,
                             const std::string& message) {
  add(Fidelity::approximate, at, element, message);
}
void ExportTree::left_out(const SourceSpan& at, const std::string& element,
                          const std::string& message) {
  add(Fidelity::left_out, at, element, message);
}

template <class List>
void ExportTree::report_list(const List& list, const char* kind, const char* reason) {
  for (const auto& e : list) left_out(e.origin, fmt::format("{} '{}'", kind, e.name), reason);
}

void ExportTree::report_rest() {
  const auto of_selection = [&](const auto& list, const char* kind, const char* reason) {
    for (const auto& e : list)
      if (!e.removed && selected(e.assembly))
        left_out(e.origin, fmt::format("{} '{}'", kind, e.name), reason);
  };
  of_selection(model.controllers, "controller", "is a plugin of CogRSim");
  of_selection(model.regions, "region", "the format has no such element");
  of_selection(model.doors, "door", "its bodies, joint and motor are written, its events are not");
  if (!options.assembly.empty()) return;
  report_list(model.supervisors, "supervisor", "is a plugin of CogRSim");
  report_list(model.mazes, "maze", "its walls are written, its plan is not");
  report_list(model.templates, "template", "the format has no such element");
  report_list(model.rules, "rule", "the format has no such element");
  report_list(model.plots, "plot", "the format has no such element");
  report_list(model.measures, "measure", "the format has no such element");
  report_list(model.tests, "test", "the format has no such element");
  if (model.record) left_out(model.record->origin, "record", "the format has no such element");
}

}  // namespace cogrsim::dsl::exporting

namespace cogrsim::dsl {

const char* format_name(ExportFormat format) {
  switch (format) {
    case ExportFormat::urdf:
      return "URDF";
    case ExportFormat::sdf:
      return "SDF";
    case ExportFormat::mjcf:
      return "MJCF";
  }
  return "";
}

Result<ExportResult> export_model(const SceneModel& model, const ExportOptions& options) {
  if (!options.assembly.empty() && find_assembly(model, options.assembly) < 0) {
    std::vector<std::string> names;
    for (const AssemblyInfo& a : model.assemblies)
      if (!a.removed) names.push_back(a.name);
    const std::string near = nearest_name(options.assembly, names);
    return fail("the scene has no assembly '" + options.assembly + "'", "",
                !near.empty()   ? "did you mean '" + near + "'?"
                : names.empty() ? "it has none; export the whole scene"
                                : fmt::format("it has {}", fmt::join(names, ", ")));
  }
  exporting::ExportTree tree(model, options);
  if (tree.links.empty()) return fail("there are no bodies to write", "", "add a body");
  switch (options.format) {
    case ExportFormat::urdf:
      tree.result.text = write_urdf(tree);
      break;
    case ExportFormat::sdf:
      tree.result.text = write_sdf(tree);
      break;
    case ExportFormat::mjcf:
      tree.result.text = write_mjcf(tree);
      break;
  }
  tree.report_rest();
  return std::move(tree.result);
}

}  // namespace cogrsim::dsl
