// Elements of a scene by name, for commands.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// Index of the element with this name; the error has the most similar name.
template <class Elements>
Result<int> find_named(const Elements& elements, const std::string& kind, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (elements[i].removed) continue;
    if (elements[i].name == name) return static_cast<int>(i);
    names.push_back(elements[i].name);
  }
  const std::string near = nearest_name(name, names);
  return fail("there is no " + kind + " '" + name + "'", "",
              near.empty() ? "" : "did you mean '" + near + "'?");
}

}  // namespace cogrsim
