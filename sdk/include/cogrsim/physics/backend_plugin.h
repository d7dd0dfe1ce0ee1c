// Export of a Backend from a shared library.
#pragma once

#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

/// Factory table of a backend plugin. `get` returns the single stateless backend of the library.
struct BackendEntry {
  const Backend* (*get)();
};

}  // namespace cogrsim

/// COGRSIM_BACKEND(BulletBackend, "bullet", version("1.0.0"), author("…"), summary("…"))
#define COGRSIM_BACKEND(Class, name, ...)                               \
  namespace {                                                           \
  const ::cogrsim::Backend* cogrsim_get_backend() {                     \
    static const Class backend;                                         \
    return &backend;                                                    \
  }                                                                     \
  const ::cogrsim::BackendEntry cogrsim_entry = {&cogrsim_get_backend}; \
  }                                                                     \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::backend, name, &cogrsim_entry, ##__VA_ARGS__)
