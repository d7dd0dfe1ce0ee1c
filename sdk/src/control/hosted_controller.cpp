#include "control/hosted_controller.h"

#include "cogrsim/plugin/crash_report.h"

namespace cogrsim {

std::optional<HostFailure> thrown_failure(std::optional<std::string> thrown) {
  if (!thrown) return std::nullopt;
  return HostFailure{HostFailure::Kind::thrown, std::move(*thrown)};
}

std::string phrase(const HostFailure& failure, const std::string& doing) {
  std::string out = failure.what;
  if (failure.kind == HostFailure::Kind::thrown) out = "threw " + doing + ": " + failure.what;
  if (failure.kind == HostFailure::Kind::process) out += " " + doing;
  if (!failure.more.empty()) out += "; " + failure.more;
  return out;
}

std::string shape_of(const PluginDescriptor& plugin) {
  std::string out;
  for (const ParameterSpec& parameter : plugin.parameters) {
    out += parameter.name + " " + to_string(parameter.type()) + " " + parameter.unit + "\n";
  }
  out += "->\n";
  for (const PluginOutput& output : plugin.outputs) out += output.name + " " + output.unit + "\n";
  return out;
}

namespace {

class InProcessController final : public HostedController {
 public:
  InProcessController(PluginPtr plugin, std::shared_ptr<AssemblyAccess> access)
      : plugin_(std::move(plugin)),
        entry_(*static_cast<const ControllerEntry*>(plugin_->descriptor().factory)),
        access_(access),
        robot_(std::move(access)),
        controller_(nullptr, entry_.destroy) {}
  ~InProcessController() override {
    const PluginCall call = calling("while it was destroyed");
    controller_.reset();
  }

  std::optional<HostFailure> configure() override {
    const PluginCall call = calling("while being configured");
    Controller* made = nullptr;
    auto thrown = entry_.create(made);
    controller_.reset(made);
    if (made) thrown = entry_.configure(*made, robot_);
    access_->configured = true;
    return thrown_failure(std::move(thrown));
  }
  std::optional<HostFailure> update(const Tick& tick) override {
    const PluginCall call = calling("in update");
    return thrown_failure(entry_.update(*controller_, tick));
  }
  std::optional<HostFailure> save(std::optional<std::string>& memory) override {
    if (!controller_) return std::nullopt;
    const PluginCall call = calling("while its state was saved");
    return thrown_failure(entry_.save(*controller_, memory));
  }
  std::optional<HostFailure> restore(const std::string& memory) override {
    if (!controller_) return std::nullopt;
    const PluginCall call = calling("while its state was restored");
    return thrown_failure(entry_.restore(*controller_, memory));
  }

 private:
  PluginCall calling(const char* doing) const {
    return {"controller",
            access_->controller.c_str(),
            access_->name.c_str(),
            access_->plugin.c_str(),
            doing,
            access_->port->time()};
  }

  PluginPtr plugin_;
  const ControllerEntry& entry_;
  std::shared_ptr<AssemblyAccess> access_;
  Assembly robot_;  // outlives the controller
  std::unique_ptr<Controller, void (*)(Controller*)> controller_;
};

}  // namespace

std::unique_ptr<HostedController> make_in_process_controller(
    PluginPtr plugin, std::shared_ptr<AssemblyAccess> access) {
  return std::make_unique<InProcessController>(std::move(plugin), std::move(access));
}

}  // namespace cogrsim
