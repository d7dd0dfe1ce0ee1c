// The operations of edit.h on a tree, with the compiler's analysis of the scene.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/dsl/edit.h"
#include "syntax/edit_tree.h"
#include "edit/scene_outline.h"
#include "language/vocabulary.h"

namespace cogrsim::dsl {

/// Tolerance of written numbers [m, rad]: of poses chosen by hand, and of poses that must not
/// change.
inline constexpr double kHandTolerance = 5e-7;
inline constexpr double kKeepTolerance = 2e-11;

/// Begins what an operation on a text that does not compile gives.
inline constexpr const char* kCorrectFirst = "correct the text first: ";

class SceneEditor {
 public:
  static Result<SceneEditor> open(const std::string& text, const std::string& name,
                                  const CompileOptions& options);
  Result<> apply(const EditOperation& operation);
  Result<EditResult> finish();

 private:
  SceneEditor(EditTree tree, std::string name, const CompileOptions& options)
      : tree_(std::move(tree)), name_(std::move(name)), options_(&options) {}

  /// A name in the file and what it means, before an operation.
  struct Use {
    EditElement* from = nullptr;
    std::string text;
    std::vector<EditElement*> chain;  ///< nullptr: not in the file
    bool follows = false;             ///< found by the file's own nesting alone
    std::size_t anchored = 0;         ///< so many first parts of it are
    EditElement* target() const { return chain.back(); }
  };

  // ---- edit_scene.cpp
  Result<EditElement*> element(int id) const;
  /// The element before which a new one is inserted in `parent`; nullptr: at the end.
  Result<EditElement*> sibling(const std::optional<int>& before, const EditElement& parent) const;
  const Analysis::Item& item(const EditElement& element) const;
  int line_of(const EditElement& element) const;
  std::string called(const EditElement& element) const;  ///< "box 'leg'", for messages
  void refresh();
  /// An error with its line, behind `lead`.
  Result<> must_compile(const char* what, const std::string& lead = kCorrectFirst) const;
  Result<EditElement*> one_thing(int id, const char* what) const;

  Result<> run(const SetAttribute& op);
  Result<> run(const InsertElement& op);
  Result<> run(const RemoveElements& op);
  Result<> run(const MoveElement& op);
  Result<> run(const RenameElement& op);
  Result<> run(const DuplicateElement& op);
  Result<> run(const PlaceElement& op);
  Result<> run(const AssembleElements& op);
  Result<> run(const DisassembleElement& op);
  Result<> run(const GroupElements& op);

  // ---- edit_names.cpp
  std::vector<Use> uses() const;
  bool nests(const Use& use, std::size_t& anchored) const;
  std::string name_of(const EditElement& element) const;
  /// Rewrites all names that no longer lead to their elements; `successors` maps removed elements
  /// to those that replace them.
  Result<> follow(std::vector<Use> before, const std::map<EditElement*, EditElement*>& successors = {});
  Result<> rewrite(EditElement& from, const std::map<std::string, std::string>& texts,
                   const std::vector<std::string>& all);
  /// The same names must refer to the same elements as before.
  Result<> check_meaning(const std::vector<Use>& before,
                         const std::map<EditElement*, EditElement*>& successors = {});
  std::string fresh_name(const EditElement& scope, const std::string& wanted, bool material,
                         const EditElement* except = nullptr) const;
  static EditElement* scope_of(const EditElement& element);

  // ---- edit_remove.cpp
  Result<> forget(const Use& use, std::vector<EditElement*>& doomed,
                  std::vector<EditElement*>& replaced);

  // ---- edit_place.cpp
  /// Pose of what an element's own is relative to, as written; errors: it is not unique.
  Result<Pose> reference_pose(EditElement& element) const;
  /// So that the element's frame, joints at 0, is there.
  Result<> write_pose(EditElement& element, const Pose& X_W, double tolerance);
  /// As quat or rpy, whichever it has; relative to its reference pose.
  Result<> write_rotation(EditElement& element, Quat q_RE, double tolerance);

  // ---- edit_assemble.cpp
  Result<> share_motion(const std::vector<EditElement*>& parts, EditElement& whole);
  Result<> hand_out(EditElement& whole, const std::vector<EditElement*>& parts);
  Result<std::vector<EditElement*>> assembled_parts(const AssembleElements& op);
  Result<> share_mass(const std::string& whole, const std::string& mass,
                      const std::vector<EditElement*>& parts);
  bool is_part(const EditElement& element) const;

  bool alive(const EditElement& element) const { return element.is_inside(tree_.root()); }
  void retire(std::unique_ptr<EditElement> element) { retired_.push_back(std::move(element)); }

  EditTree tree_;
  std::string name_;
  const CompileOptions* options_;
  std::vector<EditElement*> by_id_;  // of the text that was opened
  std::vector<EditElement*> nodes_;  // of the text that was analysed last
  std::map<const EditElement*, int> ids_;
  Analysis analysis_;
  bool compiled_at_first_ = false;
  std::map<const EditElement*, Pose> poses_;  // written, in the world; see Analysis::Item::X_W
  std::vector<EditElement*> created_;
  std::vector<std::unique_ptr<EditElement>> retired_;  // so that pointers stay good
};

/// The vocabulary's entry for an element in its parent; nullptr: an engine's block.
const ElementSpec* spec_of(const EditElement& element);
bool is_flow(const EditElement& element);

}  // namespace cogrsim::dsl
