// All data of a run that the page needs, as the data of its bundle.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/dsl/edit.h"
#include "cogrsim/physics/provenance.h"
#include "run_samples.h"
#include "talk.h"

namespace cogrsim::studio {

/// The scene's text, and its elements.
struct BundleText {
  std::string file;  ///< as the page names it
  std::string text;
  std::vector<dsl::OutlineElement> elements;
  std::vector<Diagnostic> problems;
};

/// The data of the run beside its frames.
struct BundleAbout {
  std::string file;  ///< path of the scene or recording
  std::string backend, engine_version;
  std::optional<Provenance> provenance;
  std::string ending;  ///< how it ended, with the reason
  double step = 0.0;   ///< [s]
  std::vector<RunMessage> messages;
  std::optional<BundleText> text;
};

/// Compressed; see payload.h and ../web/src/bundle/unpack.ts. What did not fit is added to
/// `left_out`, a sentence each.
std::string bundle_data(const BundleAbout& about, RunSamples& samples,
                        std::vector<std::string>& left_out);

/// Of a text whose scene was compiled elsewhere: which of its elements made what of `model`, as far
/// as dotted names show it. Fills in the elements' paths.
Origins origins_by_name(std::vector<dsl::OutlineElement>& elements, const SceneModel& model);

}  // namespace cogrsim::studio
