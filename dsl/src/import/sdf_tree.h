// An SDF and the files that it includes as one tree.
#pragma once

#include <memory>

#include "import/context.h"

namespace cogrsim::dsl::import {

/// A copy in which models stand in the place of each <include>, and axes that are in the model's frame
/// say so by `expressed_in`: those with <use_parent_model_frame>, and all of SDF 1.4 and older.
std::unique_ptr<XmlElement> sdf_tree(Context& context, const XmlElement& root);

}  // namespace cogrsim::dsl::import
