// Scenes, runs and comparisons for the tests of recordings.
#pragma once

#include <catch2/catch.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "../support/temporary_folder.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/recording/recording.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::test {

using Folder = TemporaryFolder;

std::string read_all(const std::string& path);
void write_all(const std::string& path, const std::string& bytes);

std::shared_ptr<PluginLoader> loader();

/// Boxes that fall on a plane, a driven flywheel, a mesh, a heightmap; sensors of the kinds that
/// have noise, rates, contacts and many values. "robot" is an assembly.
ModelBuilder busy_scene();
/// A body with a sensor, to be added while running.
SceneModelPtr visitor();

std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     std::uint64_t seed = 7);

/// Steps `steps` times while recording to `path`; returns the frames as they were.
/// `before_step` is called with the number of the coming step.
std::vector<FramePtr> record(Simulation& simulation, RecorderOptions options, int steps,
                             const std::function<void(int)>& before_step = {});

/// The first thing in which two frames differ in any bit; empty: none. Models are compared by
/// their elements' names and their text.
std::string difference(const Frame& a, const Frame& b);

std::unique_ptr<Recording> opened(const std::string& path);

}  // namespace cogrsim::test
