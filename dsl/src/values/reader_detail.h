// Shared by the reader_*.cpp files.
#pragma once

#include "values/reader.h"

namespace cogrsim::dsl::detail {

/// The vocabulary's entry; it is our bug if there is none.
const AttributeSpec& spec_of(const Element& element, std::string_view attribute);

AttributeText text_of(CompileContext& context, const Element& element, const Attribute& a);

}  // namespace cogrsim::dsl::detail
