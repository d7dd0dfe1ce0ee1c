// What all readers of foreign formats share: files, packages, findings, and the report.
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "assets/mesh_file.h"
#include "cogrsim/core/result.h"
#include "cogrsim/core/types.h"
#include "cogrsim/dsl/import_model.h"
#include "import/xml_tree.h"
#include "syntax/work.h"

namespace cogrsim::dsl::import {

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool empty() const { return !(low[0] <= high[0]); }
  /// Of what these bound, scaled along each axis.
  Bounds scaled(const Vec3& by) const {
    Bounds out;
    out.add(low.cwiseProduct(by));
    out.add(high.cwiseProduct(by));
    return out;
  }
};

/// What a mesh brings along beside its triangles.
struct MeshLook {
  std::optional<Color> color;
  std::string differs;         ///< what of its appearance is not read
  bool is_of_several = false;  ///< it was read from further files
  bool is_gltf = false;
};

/// Thrown where reading cannot continue; the finding has been reported.
struct Refused {};

/// One import. Not for several threads.
class Context {
 public:
  Context(const std::string& path, const ImportOptions& options);

  const ImportOptions& options;

  // ---- files

  /// An XML file, parsed once. Throws Refused.
  const XmlElement& parsed(const std::string& path, const Source& from);
  /// A copy of a parsed file, to be changed. Throws Refused.
  std::unique_ptr<XmlElement> parse(const std::string& path, const Source& from);
  /// The folder of a package. Errors: not found, with where it was looked for.
  Result<std::string> package(const std::string& name);
  /// A file that the model names: relative to `from`'s file, package://, model:// or file://.
  /// It must lie below an allowed folder. Errors: it does not, or there is none.
  Result<std::string> locate(const std::string& href, const Source& from);
  /// A mesh that locate() found. What it has beyond the size of its file is work. Throws Refused.
  /// Errors: the file is not a mesh; they begin with `name`.
  Result<LoadedMesh> mesh(const std::string& path, const std::string& name);
  /// The extent of a mesh that locate() found, read once. Errors: the file is not a mesh.
  const Result<Bounds>& mesh_bounds(const std::string& path);
  /// What else mesh_bounds() read of the mesh.
  const MeshLook& mesh_look(const std::string& path) { return looks_[path]; }
  /// Whether a canonical path lies below the model's folder or a package.
  bool allowed(const std::string& path) const;
  /// As the user would name it.
  std::string shown(const std::string& path) const;
  const std::string& path_of(int file) const { return files_[file]; }
  const std::string& folder() const { return folder_; }

  // ---- work

  /// Takes work, in the units of kMostWork. Refuses the model at `at` when none is left.
  void spend(std::size_t work, const Source& at);
  /// A copy of an element, which is work.
  std::unique_ptr<XmlElement> copy(const XmlElement& element);
  /// nearest_name() among `known`; empty also where it would take too long.
  std::string near(const std::string& name, const std::vector<std::string>& known);

  // ---- findings

  void exact(const Source& at, std::string element, std::string message = {});
  void approximate(const Source& at, std::string element, std::string message);
  /// Approximate where something `differs`, else exact; with the message in both cases.
  void exact_unless(const Source& at, std::string element, std::string differs,
                    const std::string& message = {});
  void left_out(const Source& at, std::string element, std::string message);
  /// Left out, since the file `href` of a `kind` such as "mesh" cannot be read, and the way out.
  void not_read(const Source& at, const std::string& kind, const std::string& href,
                const Error& why);
  /// Left out, and the model moves as before.
  void left_aside(const Source& at, std::string element, std::string message) {
    const Aside aside(*this);
    left_out(at, std::move(element), std::move(message));
  }
  /// While it lives, findings change no motion: sensors, looks, what other programs use.
  class Aside {
   public:
    explicit Aside(Context& context) : context_(context) { ++context_.asides_; }
    ~Aside() { --context_.asides_; }
    Aside(const Aside&) = delete;
    Aside& operator=(const Aside&) = delete;

   private:
    Context& context_;
  };
  /// An error of the source; reading continues, but no scene is made.
  void error(const Source& at, std::string code, std::string message, std::string help = {});
  /// An error after which nothing can be read.
  [[noreturn]] void refuse(const Source& at, std::string code, std::string message,
                           std::string help = {});
  bool failed() const { return failed_; }

  // ---- values

  /// `count` finite numbers. Reports and returns nothing where they are none.
  std::optional<std::vector<double>> numbers(const XmlElement& element, const std::string& text,
                                             std::size_t least, std::size_t most,
                                             const std::string& what);
  /// The attribute's number; `otherwise` where it is not written or none, which is reported.
  double number(const XmlElement& element, const char* attribute, double otherwise);
  std::optional<double> number(const XmlElement& element, const char* attribute);
  Vec3 vec3(const XmlElement& element, const char* attribute, const Vec3& otherwise);

  ImportResult result;

 private:
  /// Whether `options.only_below` permits a folder.
  bool may_read(const std::string& folder) const;
  void note_read(const std::string& path);
  void add(Fidelity fidelity, const Source& at, std::string element, std::string message);
  std::string folder_;                ///< of the model, canonical
  std::vector<std::string> allowed_;  ///< canonical folders
  std::vector<std::string> files_;    ///< by Source::file, canonical
  std::set<std::string> read_;        ///< those of result.files_read
  std::map<std::string, std::string> packages_;
  std::map<std::string, std::unique_ptr<XmlElement>> trees_;  ///< of parsed files
  std::map<std::string, Result<Bounds>> bounds_;
  std::map<std::string, int> mesh_reads_;
  std::map<std::string, MeshLook> looks_;
  std::size_t bytes_ = 0, mesh_bytes_ = 0;  ///< read so far
  std::size_t own_work_ = kMostWork;
  std::size_t* work_;                    ///< own_work_, or that of the scene that imports this
  std::size_t near_left_ = 200'000'000;  ///< steps of comparing names
  std::size_t entries_left_ = 100000;
  int asides_ = 0;
  bool failed_ = false;
};

/// The work of holding an element without its children, in the units of kMostWork.
std::size_t work_of(const XmlElement& element);

/// Adds an entry to a list in a text.
void add_to(std::string& list, std::string_view entry, std::string_view between = "; ");

/// Elements a reader knows and others, which are left out with their names.
std::string quoted_name(const XmlElement& element);

}  // namespace cogrsim::dsl::import
