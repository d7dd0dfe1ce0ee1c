// What an adapter says about itself when it is started.
#pragma once

#include <map>
#include <string>

#include "cogrsim/physics/capabilities.h"
#include "cogrsim/physics/provenance.h"
#include "plugin/adapter_manifest.h"

namespace cogrsim {

struct AdapterAbout {
  std::string version;  ///< of the engine
  Capabilities capabilities;
  ParameterTable options;
  std::map<std::string, ParameterTable, std::less<>> element_options;
  /// The engine has bodies alone: the coordinates of joints are found from their motions.
  bool coordinates_from_bodies = false;
  bool lacks_couplings = false;  ///< the host finds the efforts of couplings
  double evaluation_time = 0.0;  ///< see ExternalForces
};

/// Reads the answer to the call hello. Errors: it is no such JSON; a feature, an option or a support is
/// unknown; a note is missing.
Result<AdapterAbout> read_about(const std::string& text);

/// Reads the answer to the call provenance. Errors: a stage, or who computes it, is unknown.
Result<Provenance> read_adapter_provenance(const std::string& text);

/// All features of scenes, see Capabilities.
const std::vector<std::string>& all_features();

}  // namespace cogrsim
