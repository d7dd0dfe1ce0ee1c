// The parsed file: an immutable tree in which every name and value has its position in the source.
//
// Strings are views into memory the Document keeps; a Node is never copied. Expansion makes
// Elements (element.h) that point to Nodes.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/dsl/compiler.h"
#include "syntax/work.h"

namespace cogrsim::dsl {

struct ElementSpec;
class DiagnosticSink;

/// One attribute as written.
struct Attribute {
  std::string_view name;
  std::string_view value;  ///< decoded: entities replaced, white space normalised to blanks
  SourceSpan name_span;
  SourceSpan value_span;        ///< between the quotes
  std::uint32_t raw_begin = 0;  ///< byte offset of the value in the file's text
  std::uint32_t raw_length = 0;
};

/// One element as written.
struct Node {
  std::string_view name;
  SourceSpan span;                    ///< the element's name, in its start tag
  const ElementSpec* spec = nullptr;  ///< vocabulary entry; nullptr: an engine block or unknown
  const Node* parent = nullptr;
  std::vector<Attribute> attributes;
  std::vector<const Node*> children;
  /// Byte offsets in the file's text: of "<", behind the start tag, of "</", and behind the end tag.
  /// The last three are the same for an element that ends with "/>".
  std::uint32_t begin = 0, content_begin = 0, content_end = 0, end = 0;
  std::string_view text;  ///< character data, of elements that take text
  SourceSpan text_span;

  /// nullptr when it is not written.
  const Attribute* find(std::string_view attribute) const;
};

/// A file's text, kept for excerpts.
struct SourceFile {
  std::string name;  ///< as the user named it, or relative to the scene's folder
  std::string path;  ///< canonical; for compile_text the name given
  std::string text;
  std::vector<std::uint32_t> line_starts;

  std::string_view line(int number) const;  ///< from 1, without its end; "" beyond
};

/// A parsed file; owns its nodes and their strings.
struct Document {
  Document();
  ~Document();
  int file = -1;
  /// Robots of others often have "--" in comments, and blanks before their declaration.
  bool lenient = false;
  const Node* root = nullptr;  ///< nullptr: not well-formed, and reported
  std::deque<Node> nodes;
  struct Storage;
  std::unique_ptr<Storage> storage;  ///< of decoded strings
};

/// All files of one compilation. Checks that they come from allowed folders.
class SourceFiles {
 public:
  /// What may still be read and computed, see kMostWork.
  std::size_t work = kMostWork;

  SourceFiles(const CompileOptions& options, DiagnosticSink& sink);
  ~SourceFiles();

  /// The scene itself; it fixes the folder below which everything else must lie.
  /// nullptr: reported.
  const Document* open_scene(const std::string& path);
  const Document* open_scene_text(const std::string& text, const std::string& name);

  /// A file that is not a scene: nothing but its XML is checked. To be called first and once.
  const Document* open_plain(const std::string& path, bool lenient = false);
  const Document* open_plain_text(const std::string& text, const std::string& name);

  /// An import. `href` is relative to its own file, or to a library folder; `keyframe` is as in
  /// ImportOptions. Files are parsed and checked against the vocabulary once for each keyframe;
  /// nullptr: reported, at `at`. Cycles are the caller's to find (compare Document pointers).
  const Document* open_import(std::string_view href, const std::string& keyframe,
                              const SourceSpan& at);

  /// Absolute path of a mesh, heightmap or texture, checked to exist, to be an ordinary file below
  /// the scene's folder or a library folder, and within limits. Empty: reported, at `at`.
  std::string resolve_asset(std::string_view href, const SourceSpan& at);

  /// Files that others brought along.
  void add_read(const std::vector<std::string>& paths) { read_.insert(paths.begin(), paths.end()); }

  const SourceFile& file(int index) const { return *files_[index]; }
  int size() const { return static_cast<int>(files_.size()); }

  /// Absolute paths of everything that was opened or located so far, sorted.
  std::vector<std::string> read() const { return {read_.begin(), read_.end()}; }

  /// Engine names that are allowed as elements in `<physics>` and `<assembly>`.
  const std::vector<std::string>& engine_blocks() const;

  /// Why the engine of this name, which is there, cannot be used: refused, or without what it needs.
  std::optional<Error> engine_fault(const std::string& name) const;

  /// Span of `length` bytes from `begin` in a decoded attribute value (column-exact even when
  /// the value holds entities or line breaks).
  SourceSpan span_in_value(const Attribute& attribute, std::size_t begin, std::size_t length) const;

 private:
  const Document* add(std::string name, std::string path, std::string text,
                      const std::string& keyframe = {});
  /// Replaces the text of a URDF, MJCF or SDF file by that of a scene with its prototype. False: it
  /// cannot be imported, and that is reported at `at`.
  bool convert_model(const std::string& path, std::string_view href, const std::string& keyframe,
                     const SourceSpan& at, std::string& text);
  std::string locate(std::string_view href, const SourceSpan& at, const char* what);

  const CompileOptions& options_;
  DiagnosticSink& sink_;
  bool plain_ = false, lenient_ = false;
  std::vector<std::unique_ptr<SourceFile>> files_;
  std::vector<std::unique_ptr<Document>> documents_;
  std::map<std::pair<std::string, std::string>, std::size_t> by_path_;  ///< and by keyframe
  std::string installed_;           // canonical folder of the installed library, or empty
  std::vector<std::string> roots_;  // canonical folders that files may lie below
  std::set<std::string> read_;      // absolute paths
  /// Where span_in_value() stood in the value that begins at `start`.
  struct Cursor {
    SourceSpan start, span;
    std::size_t at = 0, decoded = 0;  ///< bytes of the file, bytes of the value
  };
  mutable Cursor cursor_;
  mutable std::optional<std::vector<std::string>> engine_blocks_;  ///< on first use
};

}  // namespace cogrsim::dsl
