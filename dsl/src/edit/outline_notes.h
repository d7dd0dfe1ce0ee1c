// Notes of a compilation for editing: what each element became, its poses, and the element that
// every name refers to.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/types.h"
#include "syntax/element.h"

namespace cogrsim::dsl {

struct OutlineNotes {
  struct ElementPoses {
    const Element* element = nullptr;
    const Element* reference = nullptr;  ///< what its pose is written relative to
    Pose X_W;                            ///< as written, all joints at 0
    Pose X_W_start;                      ///< once the joints have their initial positions
    Pose X_WR;                           ///< of the reference, as written
  };
  /// A name that was looked up, and found.
  struct Use {
    const Element* from = nullptr;
    SourceSpan span;  ///< of the name; file -1: it is part of a longer text
    std::string text;
    std::vector<const Element*> chain;  ///< what each of its dotted parts means
  };
  std::vector<ElementPoses> poses;
  std::vector<Use> uses;
};

}  // namespace cogrsim::dsl
