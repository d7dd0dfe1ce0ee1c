// The same as a sensor.
#include "cogrsim/sensing/sensor.h"
#include "misdeed.h"

namespace {

[[maybe_unused]] const bool kLoaded = (misdeed::commit_at("rascal_eye.load"), true);

class Eye final : public cogrsim::Sensor {
 public:
  ~Eye() override { misdeed::commit_at("rascal_eye.unmake"); }
  cogrsim::Result<> configure(const cogrsim::SceneModel&, const cogrsim::SensorModel&,
                              const cogrsim::Parameters&) override {
    misdeed::commit_at("rascal_eye.configure");
    return {};
  }
  std::vector<cogrsim::Channel> channels() const override { return {{"seen", "1"}}; }
  cogrsim::Result<> read(cogrsim::SensorContext& context, cogrsim::Reading& reading) override {
    if (context.frame().time >= 0.1) misdeed::commit_at("rascal_eye.read");
    reading.values[0] = context.frame().time;
    return {};
  }
};

}  // namespace

COGRSIM_SENSOR(Eye, "rascal_eye", version("1.0.0"), summary("misbehaves"))
