// The recording of a run of a scene file.
#pragma once

#include <string>

#include "cogrsim/recording/recording.h"
#include "common/options.h"

namespace cogrsim::cli {

/// Whether the run is to be recorded: `--record`, or `<record>` in the scene.
bool wants_recording(const SceneModel& model, const RunOptions& options);

/// The recorder's options: file (that of `<record>`, or by the scene's name, lies in the output folder) and choices from `--record` and `<record>`, the scene's files as
/// they are on disk, `--set`. Files that went away since they were compiled are left out. Errors: the
/// scene names a file outside its folder.
Result<RecorderOptions> recorder_options(const SceneModel& model, const RunOptions& options);

}  // namespace cogrsim::cli
