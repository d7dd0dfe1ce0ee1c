// The colours of pictures and maps, where the scene names none.
#pragma once

#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Whether somebody chose how it looks: it has a texture, or another colour than the default one.
COGRSIM_API bool has_looks(const Material& material);

/// The colour (sRGB) in which a shape of the body with the index `body` is shown: its material's.
/// Where nobody chose one, planes and height fields are light, other fixed bodies grey, and the rest
/// has one of eight quiet colours by its index.
COGRSIM_API Color shown_color(const SceneModel& model, int body, const Shape& shape);

}  // namespace cogrsim
