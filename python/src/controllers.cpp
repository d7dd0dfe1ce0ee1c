// Controllers in Python.
#include "cogrsim/control/controller.h"

#include <stdexcept>

#include "python_plugins.h"

namespace cogrsim::python {

namespace {

Slots& slots() {
  static Slots all;
  return all;
}

class PyController final : public Controller {
 public:
  explicit PyController(PluginClassPtr cls) : class_(std::move(cls)) {
    call_python(*gate_, [&] { instance_ = hold((*class_->type)()); });
  }
  void configure(Assembly& robot) override {
    if (!instance_) throw std::runtime_error(kInterrupted);
    call_python(*gate_, [&] {
      gate_->configuring = true;
      instance_->attr("configure")(PyAssembly{robot, gate_, class_->table});
    });
  }
  void update(const Tick& tick) override { call("update", tick); }
  std::optional<std::string> save() const override {
    std::optional<std::string> memory;
    if (!instance_) return memory;
    call_python(*gate_, [&] { memory = memory_of(instance_->attr("save")()); });
    return memory;
  }
  void restore(const std::string& memory) override { call("restore", memory); }

 private:
  static constexpr const char* kInterrupted =
      "it was interrupted while it was made; restart the run";

  template <class Argument>
  void call(const char* method, Argument&& argument) {
    if (!instance_) throw std::runtime_error(kInterrupted);
    call_python(*gate_, [&] { instance_->attr(method)(std::forward<Argument>(argument)); });
  }

  PluginClassPtr class_;
  GatePtr gate_ = std::make_shared<Gate>();
  Held instance_;
};

template <std::size_t I>
struct MakeController {
  static ControllerEntry entry() {
    return {
        [](Controller*& out) {
          return detail::guarded([&] { out = new PyController(slots().get(I)); });
        },
        [](Controller* c) { detail::guarded([&] { delete c; }); },
        [](Controller& c, Assembly& robot) { return detail::guarded([&] { c.configure(robot); }); },
        [](Controller& c, const Tick& tick) { return detail::guarded([&] { c.update(tick); }); },
        [](const Controller& c, std::optional<std::string>& memory) {
          return detail::guarded([&] { memory = c.save(); });
        },
        [](Controller& c, const std::string& memory) {
          return detail::guarded([&] { c.restore(memory); });
        }};
  }
};

}  // namespace

const void* controller_factory(const PluginClassPtr& cls) {
  static const auto all =
      entries<ControllerEntry, MakeController>(std::make_index_sequence<kSlots>());
  const auto slot = slots().take(cls);
  return slot ? &all[*slot] : nullptr;
}

std::optional<std::string> memory_of(const py::object& memory) {
  if (memory.is_none()) return std::nullopt;
  if (!py::isinstance<py::str>(memory)) {
    throw py::cast_error("save() returned " +
                         py::type::handle_of(memory).attr("__name__").cast<std::string>() +
                         ", expected str or None");
  }
  return memory.cast<std::string>();
}

}  // namespace cogrsim::python
