#include "cogrsim/signals/signal.h"

#include <limits>
#include <map>

#include "node.h"

namespace cogrsim {
namespace {

struct Nothing final : Signal::Node {
  double value(const Frame&) const override { return std::numeric_limits<double>::quiet_NaN(); }
};

}  // namespace

Signal::Signal() {
  static const auto nothing = std::make_shared<const Nothing>();
  node_ = nothing;
}

Signal::Signal(std::shared_ptr<const Node> node) : node_(std::move(node)) {}

const std::string& Signal::text() const { return node_->text; }
const std::string& Signal::unit() const { return node_->unit; }
const std::string& Signal::quantity() const { return node_->quantity; }
FrameContents Signal::needs() const { return node_->needs; }
double Signal::evaluate(const Frame& frame) const { return node_->value(frame); }
std::uint64_t Signal::revision(const Frame& frame) const { return node_->revision(frame); }

ChannelLookup built_in_channels(const SceneModel& model) {
  auto known = std::make_shared<std::map<int, std::vector<Channel>>>();
  return [&model, known](int sensor) -> const std::vector<Channel>* {
    if (const auto it = known->find(sensor); it != known->end())
      return it->second.empty() ? nullptr : &it->second;
    std::vector<Channel>& channels = (*known)[sensor];
    const SensorModel& given = model.sensors[sensor];
    for (const PluginDescriptor& descriptor : built_in_sensors()) {
      if (descriptor.name != given.type) continue;
      const auto parameters = complete_parameters(descriptor.parameters, given.parameters);
      const SensorEntry* entry = built_in_sensor(given.type);
      if (!parameters || entry == nullptr) break;
      const std::unique_ptr<Sensor, void (*)(Sensor*)> probe(entry->create(), entry->destroy);
      if (probe->configure(model, given, *parameters)) channels = probe->channels();
    }
    return channels.empty() ? nullptr : &channels;
  };
}

}  // namespace cogrsim
