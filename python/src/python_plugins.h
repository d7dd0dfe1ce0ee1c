// Controllers, supervisors and sensors that are Python classes.
#pragma once

#include <array>
#include <mutex>
#include <utility>

#include "cogrsim/plugin/descriptor.h"
#include "handles.h"

namespace cogrsim::python {

/// The class behind a factory, with what it declares.
struct PluginClass {
  Held type;
  TablePtr table;
};
using PluginClassPtr = std::shared_ptr<const PluginClass>;

/// The factory tables of plugins are plain functions, so each class in use has a number, which a
/// function of its own knows.
constexpr std::size_t kSlots = 128;

/// The classes in use, by number, of one kind of plugin.
class Slots {
 public:
  /// The number of a class, which it keeps as long as the pointer exists; nullopt: all are in use.
  std::optional<std::size_t> take(const PluginClassPtr& cls) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < kSlots; ++i) {
      if (!all_[i].expired()) continue;
      all_[i] = cls;
      return i;
    }
    return std::nullopt;
  }
  PluginClassPtr get(std::size_t i) const {
    const std::lock_guard lock(mutex_);
    return all_[i].lock();
  }

 private:
  mutable std::mutex mutex_;
  std::array<std::weak_ptr<const PluginClass>, kSlots> all_;
};

template <class Entry, template <std::size_t> class Make, std::size_t... I>
std::array<Entry, sizeof...(I)> entries(std::index_sequence<I...>) {
  return {Make<I>::entry()...};
}

/// The factory table of a class, or nullptr if too many classes are in use.
const void* controller_factory(const PluginClassPtr& cls);
const void* supervisor_factory(const PluginClassPtr& cls);
const void* sensor_factory(const PluginClassPtr& cls);

/// The result of save(): text or None. Errors: a cast_error for another type.
std::optional<std::string> memory_of(const py::object& memory);

}  // namespace cogrsim::python
