// What the writers of foreign formats share: the selected bodies as a tree of links, legal names,
// meshes as files, and the report.
#pragma once

#include <tinyxml2.h>

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/dsl/export_model.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::dsl::exporting {

/// XML with two blanks of indentation.
class XmlWriter {
 public:
  explicit XmlWriter(const std::string& comment);
  /// Opens an element with attributes; end() closes it.
  XmlWriter& begin(const char* name);
  XmlWriter& with(const char* name, const std::string& value);
  XmlWriter& with(const char* name, double value);
  XmlWriter& with(const char* name, const Vec3& value);
  void end();
  /// The text of the open element.
  void raw(const std::string& value);
  /// An element that holds only a text.
  void text(const char* name, const std::string& value);
  void text(const char* name, double value);
  std::string str() const;

 private:
  tinyxml2::XMLPrinter printer_;
};

/// The shortest text that reads as the same number; -0 and rounding beside 0 become 0.
std::string number(double value);
std::string numbers(const Vec3& value);

/// A body in the tree. Parents precede their children.
struct Link {
  int body = -1;
  int parent = -1;        ///< index of the link, or -1: the world
  int joint = -1;         ///< index of the model's joint to the parent; -1: none
  Pose X_PF, X_CM;        ///< of that joint, from the parent in the tree to this body
  bool grounded = false;  ///< static, or held by the world through joints
};

/// One axis of a joint, outermost first. Its direction is fixed in F (the parent) if `in_parent`,
/// otherwise in M.
struct AxisStep {
  bool turns = true;
  bool in_parent = false;
  Vec3 direction = Vec3::UnitZ();
};
/// The axes of a joint whose coordinates are numbers; empty for fixed, ball and free joints. A screw
/// has two: its angle and its travel.
std::vector<AxisStep> axis_steps(JointType type);

/// What of a material a format lacks that writes the friction, the restitution, the stiffness and the
/// frictions of rolling and spinning, as "its restitution 0.5 is left out"; empty: nothing.
struct SurfaceWritten {
  bool friction = false, restitution = false, stiffness = false, rolling = false;
};
std::string lost_of(const Material& m, const SurfaceWritten& written);

class ExportTree {
 public:
  ExportTree(const SceneModel& model, const ExportOptions& options);

  const SceneModel& model;
  const ExportOptions& options;
  ExportResult result;
  std::vector<Link> links;
  std::vector<int> loops;  ///< joints that are not in the tree

  bool selected(int assembly) const;
  /// Index of the link of a body; -1: the world or not selected.
  int link_of(int body) const;
  const std::string& body_name(int body) const { return body_names_[index(body)]; }
  const std::string& joint_name(int joint) const { return joint_names_[index(joint)]; }
  /// A legal name that nothing of this kind has yet.
  std::string unique_name(const std::string& kind, const std::string& dotted);
  /// The name of the robot or world.
  std::string title() const;
  /// File of a mesh, relative to the written file; the file is added to the result.
  std::string mesh_file(int mesh);

  void exact(const SourceSpan& at, const std::string& element, const std::string& message = {});
  void approximate(const SourceSpan& at, const std::string& element, const std::string& message);
  void left_out(const SourceSpan& at, const std::string& element, const std::string& message);
  /// Reports pairs of materials in use that another program, which has one rule for all, combines to
  /// another friction.
  void report_pairs(const char* how, CombineRule rule);
  /// Reports the elements that no foreign format has, and those of `also`.
  void report_rest();

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

 private:
  void select();
  /// Names what is exported: `wanted` bodies, and the joints at each of them, which it returns by
  /// body; loops are separate.
  std::vector<std::vector<int>> find_joints(std::vector<bool>& wanted);
  void build();
  void add(Fidelity fidelity, const SourceSpan& at, const std::string& element,
           const std::string& message);
  template <class List>
  void report_list(const List& list, const char* kind, const char* reason);

  std::vector<bool> chosen_;  ///< by assembly
  std::vector<int> link_of_;  ///< by body
  std::vector<std::string> body_names_, joint_names_;
  std::map<std::string, std::set<std::string>> names_;  ///< by kind
  std::map<int, std::string> mesh_files_;
};

std::string write_urdf(ExportTree& tree);
std::string write_sdf(ExportTree& tree);
std::string write_mjcf(ExportTree& tree);

}  // namespace cogrsim::dsl::exporting
