// The plugin that stands for an adapter.
#pragma once

#include <memory>
#include <mutex>

#include "cogrsim/physics/backend_plugin.h"
#include "plugin/adapter_manifest.h"

namespace cogrsim {

/// Its factory table has no function: the backend is made by backend().
struct AdapterEntry : BackendEntry {
  explicit AdapterEntry(AdapterManifest file) : BackendEntry{nullptr}, manifest(std::move(file)) {}
  /// Made once; a failure is tried again. Errors: see make_adapter_backend().
  Result<std::shared_ptr<const Backend>> backend() const;

  AdapterManifest manifest;

 private:
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Backend> made_;
};

}  // namespace cogrsim
