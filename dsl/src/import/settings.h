// Settings of a format that scenes do not have.
#pragma once

#include <initializer_list>
#include <string_view>

#include "import/context.h"

namespace cogrsim::dsl::import {

/// Settings of elements: attributes, or children with a text.
struct Settings {
  std::string_view elements;    ///< their names, with a blank between them
  std::string_view names;       ///< of the settings, likewise
  std::string_view reason;      ///< why scenes do not have them
  std::string_view plain = {};  ///< a value that changes nothing
};

/// Reports each setting of an element's name once, at its first position, with the number of elements
/// that have it: "solref of 12 <geom>".
void report_settings(Context& context, const XmlElement& root,
                     std::initializer_list<Settings> kinds);

}  // namespace cogrsim::dsl::import
