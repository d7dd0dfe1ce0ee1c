// Default colours in images and maps for materials without a colour.
#pragma once

#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Whether the scene sets the appearance of a material: it has a texture, or its colour differs
/// from the default.
COGRSIM_API bool has_looks(const Material& material);

/// The colour (sRGB) in which a shape of the body with the index `body` is drawn. It is the colour
/// of the material if the scene sets one. Otherwise planes and heightmaps are light, other static
/// bodies are grey, and the remaining bodies have one of eight muted colours depending on the
/// index.
COGRSIM_API Color shown_color(const SceneModel& model, int body, const Shape& shape);

/// The colour (sRGB) of a plane in pictures for people: shown_color(), or where a shape that is
/// neither plane nor heightmap has nearly the same, a paler or darker one that none has.
COGRSIM_API Color floor_color(const SceneModel& model, int body, const Shape& plane);

}  // namespace cogrsim
