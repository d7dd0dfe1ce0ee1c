// Descriptor of a plugin library. Authors of plugins use the macros at the end of
// control/controller.h, control/supervisor.h, sensing/sensor.h and physics/backend_plugin.h.
//
// A library exports two symbols. The *name* of the first contains the ABI version and a build tag;
// the loader searches the file for it before loading, so that no code of an incompatible library
// runs. The second, `cogrsim_plugin`, returns the descriptor below.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/parameter.h"

/// Incremented whenever an interface that plugins use changes its layout or meaning.
#define COGRSIM_ABI_VERSION 9

#if defined(__clang__)
#define COGRSIM_COMPILER_TAG clang
#define COGRSIM_COMPILER_MAJOR __clang_major__
#else
#define COGRSIM_COMPILER_TAG gcc
#define COGRSIM_COMPILER_MAJOR __GNUC__
#endif

#define COGRSIM_CONCAT_(a, b, c, d, e, f) a##b##_##c##d##_cxx##e##f
#define COGRSIM_CONCAT(a, b, c, d, e, f) COGRSIM_CONCAT_(a, b, c, d, e, f)
/// e.g. cogrsim_abi_1_gcc12_cxx11
#define COGRSIM_ABI_SYMBOL                                                                        \
  COGRSIM_CONCAT(cogrsim_abi_, COGRSIM_ABI_VERSION, COGRSIM_COMPILER_TAG, COGRSIM_COMPILER_MAJOR, \
                 1, _GLIBCXX_USE_CXX11_ABI)
#define COGRSIM_STRING_(x) #x
#define COGRSIM_STRING(x) COGRSIM_STRING_(x)

namespace cogrsim {

enum class PluginKind { backend, controller, supervisor, sensor, renderer, algorithm };

/// "backend", "controller", "supervisor", "sensor", "renderer", "algorithm".
COGRSIM_API const char* to_string(PluginKind kind);

/// Declaration of a number that a controller publishes, see Assembly::publish(). It is part of
/// every frame, so that it can be recorded, plotted and tested as the signal
/// `robot.CONTROLLER.NAME`.
struct PluginOutput {
  std::string name;
  std::string unit;  ///< as in the scene language; "1": none
  std::string description;
};

/// Description of a plugin. `factory` points to the factory table of its kind (ControllerEntry,
/// SupervisorEntry, SensorEntry, BackendEntry, RendererEntry, AlgorithmEntry).
struct PluginDescriptor {
  PluginKind kind = PluginKind::controller;
  std::string name;
  std::string version = "0.0.0";
  std::string author;
  std::string summary;
  ParameterTable parameters;
  std::vector<PluginOutput> outputs;  ///< of controllers and supervisors
  const void* factory = nullptr;
};

/// Arguments of the export macros in addition to parameter(): output("plans", "1", "number of
/// plans"), version("1.2.0"), author("…"), summary("…").
struct PluginVersion {
  std::string text;
};
struct PluginAuthor {
  std::string text;
};
struct PluginSummary {
  std::string text;
};
inline PluginOutput output(std::string name, std::string unit, std::string description) {
  return {std::move(name), std::move(unit), std::move(description)};
}
inline PluginVersion version(std::string text) { return {std::move(text)}; }
inline PluginAuthor author(std::string text) { return {std::move(text)}; }
inline PluginSummary summary(std::string text) { return {std::move(text)}; }

namespace detail {
inline void add_item(PluginDescriptor& d, PluginVersion item) { d.version = std::move(item.text); }
inline void add_item(PluginDescriptor& d, PluginAuthor item) { d.author = std::move(item.text); }
inline void add_item(PluginDescriptor& d, PluginSummary item) { d.summary = std::move(item.text); }
inline void add_item(PluginDescriptor& d, ParameterSpec item) {
  d.parameters.push_back(std::move(item));
}
inline void add_item(PluginDescriptor& d, PluginOutput item) {
  d.outputs.push_back(std::move(item));
}
template <class... Items>
PluginDescriptor describe(PluginKind kind, const char* name, const void* factory,
                          Items&&... items) {
  PluginDescriptor d;
  d.kind = kind;
  d.name = name;
  d.factory = factory;
  (add_item(d, std::forward<Items>(items)), ...);
  return d;
}
}  // namespace detail

}  // namespace cogrsim

/// Used by the macros of each kind: exports the ABI symbol and the descriptor function.
#define COGRSIM_EXPORT_PLUGIN(kind, name, factory, ...)                                        \
  extern "C" COGRSIM_API const char COGRSIM_ABI_SYMBOL[] = COGRSIM_STRING(COGRSIM_ABI_SYMBOL); \
  extern "C" COGRSIM_API const ::cogrsim::PluginDescriptor* cogrsim_plugin() {                 \
    using namespace ::cogrsim; /* parameter(), version(), … without prefix */                \
    static const ::cogrsim::PluginDescriptor descriptor =                                      \
        ::cogrsim::detail::describe(kind, name, factory, ##__VA_ARGS__);                       \
    return &descriptor;                                                                        \
  }
