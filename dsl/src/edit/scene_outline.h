// A compilation as editing sees it: by element of the scene file.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/types.h"
#include "cogrsim/dsl/edit.h"

namespace cogrsim::dsl {

struct Analysis {
  /// What one element of the file became.
  struct Item {
    int count = 0;        ///< things; 0: none
    bool single = false;  ///< one object, and not in anything that could make more
    int parent = -1;      ///< element around it, repeats and conditions left out
    int reference = -1;   ///< what its pose is relative to; -1: the world, or not in the file
    std::string name, path;
    Pose X_W, X_W_start, X_WR;  ///< see OutlineNotes; of single ones
  };
  /// A name in the file that was found. Ids; -1: not in the file.
  struct Use {
    int from = -1;
    SourceSpan span;  ///< file -1: part of a longer text
    std::string text;
    std::vector<int> chain;
  };

  CompileResult result;
  bool well_formed = false;
  std::vector<Item> items;  ///< by id
  std::vector<Use> uses;
  ModelOrigins origins;
};

Analysis analyse(const std::string& text, const std::string& name, const CompileOptions& options);

}  // namespace cogrsim::dsl
