// A backend whose engine is in processes of its own, one for each world.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/physics/backend.h"
#include "physics/adapter/adapter_about.h"
#include "physics/adapter/adapter_process.h"

namespace cogrsim {

/// Processes of one adapter. One that a world has left waits for the next world, as loading an engine
/// takes up to a second.
class AdapterPool {
 public:
  explicit AdapterPool(AdapterManifest manifest)
      : manifest_(std::make_shared<const AdapterManifest>(std::move(manifest))) {}

  /// One that has introduced itself. Errors (CG0910): those of the system, its introduction is wrong, or
  /// differs from that of the first one.
  Result<std::unique_ptr<AdapterProcess>> take();
  void give_back(std::unique_ptr<AdapterProcess> process);
  /// Valid after take().
  const AdapterAbout& about() const { return *about_; }
  const AdapterManifest& manifest() const { return *manifest_; }
  /// An error in the adapter's file.
  Error error(const std::string& what, const std::string& hint = "") const {
    return Error(what, manifest_->path, hint, "CG0910");
  }

 private:
  Result<std::unique_ptr<AdapterProcess>> start();

  std::shared_ptr<const AdapterManifest> manifest_;
  std::mutex mutex_;  ///< protects the following members
  std::vector<std::unique_ptr<AdapterProcess>> idle_;
  std::optional<AdapterAbout> about_;
  std::string introduction_;
};

/// Starts one process to learn what the adapter says. Errors: see AdapterPool::take().
Result<std::shared_ptr<const Backend>> make_adapter_backend(const AdapterManifest& manifest);

/// Builds the world of `model`. Errors name the adapter's file, or the element.
Result<std::unique_ptr<World>> make_adapter_world(std::shared_ptr<AdapterPool> pool,
                                                  const SceneModelPtr& model);

}  // namespace cogrsim
