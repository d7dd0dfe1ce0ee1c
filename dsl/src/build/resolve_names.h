// From a name in an attribute to the element it means.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "report/diagnostics.h"
#include "syntax/element.h"
#include "values/reader.h"

namespace cogrsim::dsl {

/// What an attribute may refer to.
enum class Wanted {
  posed,   ///< anything with a pose: bodies, shapes, assemblies, instances, frames
  matter,  ///< bodies, shapes, assemblies, instances
  joint,
  material,
  any  ///< any named element except a material
};

/// A name is looked up in its own scope, then in the enclosing scopes. Its dotted parts lead
/// inwards, through assemblies, bodies, instances and imports. An instance hides nothing: its
/// prototype may refer to its own content, to the file it was imported from, or to the scopes
/// around the instance.
class Names {
 public:
  Names(CompileContext& context, const Element& root);

  /// What `word` means as written in `from`; nullptr: reported (CG0402, CG0404), or silent when it
  /// is the fault of something that failed before.
  const Element* find(const Element& from, const Word& word, Wanted wanted);

  /// The same for a word in something larger, where a miss may be no mistake: nothing is reported.
  struct Found {
    const Element* element = nullptr;  ///< nullptr: none
    bool lost = false;                 ///< the name could be one that failed: stay silent
  };
  Found peek(const Element& from, std::string_view name) const;

 private:
  using Scope = std::unordered_map<std::string_view, const Element*>;
  struct Walk {
    const Element* found = nullptr;
    bool lost = false;  ///< the name could be one that failed
  };
  /// What the dotted parts of a name mean; an export is itself.
  using Chain = std::vector<const Element*>;

  void index(const Element& element);
  const Element* child(const Element& scope, std::string_view name, bool materials) const;
  Walk walk(const Element& scope, std::string_view dotted, bool materials, int depth,
            Chain* chain = nullptr) const;
  void note_use(const Element& from, const SourceSpan& span, std::string_view text,
                const Element& scope, bool materials) const;
  bool may_be_lost(const Element& scope, std::string_view name) const;
  std::vector<std::string> known(const Element& from, Wanted wanted) const;
  std::string deeper(const Element& from, std::string_view name, Wanted wanted) const;

  CompileContext& context_;
  std::unordered_map<const Element*, Scope> things_, materials_;
  std::vector<const Element*> all_;
  std::set<std::tuple<const Element*, int, int>> failed_;  ///< element, line, column: reported once
};

/// "a body", "a material", "an assembly", …: for "'x' is a hinge, expected a body".
std::string kind_of(const Element& element);

}  // namespace cogrsim::dsl
