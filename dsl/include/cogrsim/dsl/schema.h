// The scene language as data: what forms, completion and help are generated from.
#pragma once

#include <string>

#include "cogrsim/core/export.h"
#include "cogrsim/dsl/compiler.h"

namespace cogrsim::dsl {

/// A JSON object:
///
/// | key | |
/// |---|---|
/// | `version` | of the scene language, a number |
/// | `elements` | in the order of the reference page: `name`, `group`, `doc`, `example`, `children` [names of the allowed children], `attributes`, `flow` (repeat, for, if: allowed inside anything that has children, with the same content), `open_attributes` (takes any), `engine_blocks` (takes engines' blocks), `text` (takes text), `when` ("on": this `contact` is the sensor) |
/// | `units` | by SI unit: what one would write of that dimension, the usual first |
///
/// An attribute has `name`, `kind` ("name", "reference", "references", "text", "boolean", "choice",
/// "integer", "number", "numbers", "range", "color", "file", "noise", "expression",
/// "value"), `doc`,
/// `default` (as one would write it, "": none), `required`, `units` [SI; "": a plain number; several:
/// alternatives, or entry by entry with `per_entry`], and where they mean something `min_count`,
/// `max_count`, `min`, `max` (SI; absent: none), `above_min`, `none_allowed`, `choices`, `wants` (of a
/// reference: "place", "joint", "material", "prototype", "door", "template", "motor", "sensor",
/// "any").
///
/// With a catalog also `backends` [names], `plugins`: `controllers`, `supervisors` and `sensors`
/// [{`name`, `parameters` [attributes]}], and `blocks`: by backend, `world` and `assembly`
/// [attributes].
COGRSIM_API std::string write_schema_json(PluginCatalog* plugins = nullptr);

}  // namespace cogrsim::dsl
