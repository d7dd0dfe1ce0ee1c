// Diagnostics about elements of a model, with the source location of the element.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Fills in the source location if it is known.
inline void locate(Diagnostic& d, const SceneModel& model, const SourceSpan& origin) {
  const SourcePosition position = source_position(model, origin);
  if (!position.file.empty()) d.locate(position);
}

inline Diagnostic diagnose(const SceneModel& model, const SourceSpan& origin,
                           const std::string& message, const std::string& code,
                           const std::string& help = {}) {
  Diagnostic d;
  d.code = code;
  d.message = message;
  d.help = help;
  locate(d, model, origin);
  return d;
}

/// The messages in one line, separated by semicolons.
inline std::string joined(const std::vector<Diagnostic>& found) {
  std::string out;
  for (const Diagnostic& d : found) {
    if (!out.empty()) out += "; ";
    out += d.message;
  }
  return out;
}

}  // namespace cogrsim
