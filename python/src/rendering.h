// Images as arrays.
#pragma once

#include "cogrsim/rendering/renderer.h"
#include "common.h"

namespace cogrsim::python {

using PicturePtr = std::shared_ptr<const Picture>;
py::object color_of(const PicturePtr& picture);
py::object depth_of(const PicturePtr& picture);
py::object labels_of(const PicturePtr& picture);

}  // namespace cogrsim::python
