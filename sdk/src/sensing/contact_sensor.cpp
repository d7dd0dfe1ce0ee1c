#include <algorithm>

#include "sensing/sensor_model.h"

namespace cogrsim::sensor_models {

namespace {

/// Contact sensor: the contacts of a body, or of all bodies of its assembly (without the contacts
/// inside the assembly). A contact point counts if it carries a force or if the surfaces overlap;
/// engines also list points that are about to touch. The values are the number of points, the
/// number of other bodies, and the total force on the sensing bodies, in the axes of the sensor,
/// mean over the last step. Reading::contacts has the points, with the sensing body as body_b.
/// Noise acts on the force, which is then saturated.
class ContactSense final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters& parameters) override {
    sensor_ = sensor;
    max_force_ = number(parameters, "max-force");
    own_bodies_.clear();
    if (boolean(parameters, "whole-assembly")) {
      if (sensor.assembly < 0) {
        return fail("it does not belong to an assembly, so it cannot sense a whole one");
      }
      own_bodies_ = bodies_of(model, sensor.assembly);
      std::sort(own_bodies_.begin(), own_bodies_.end());
    } else if (sensor.body != kWorld) {
      own_bodies_ = {sensor.body};
    }
    if (own_bodies_.empty()) return fail("it is mounted on no body", "", "name one: on=\"…\"");
    channels_ = {{"points", "1", false}, {"bodies", "1", false}};
    for (const char* axis : {"fx", "fy", "fz"}) channels_.push_back({axis, "N", true});
    return {};
  }
  std::vector<Channel> channels() const override { return channels_; }
  FrameContents needs() const override {
    FrameContents contents;
    contents.contacts = true;
    return contents;
  }
  Result<> read(SensorContext& context, Reading& reading) override {
    const Frame& frame = context.frame();
    Vec3 total = Vec3::Zero();
    others_.clear();
    for (const Contact& contact : frame.contacts) {
      const bool a = is_own(contact.body_a), b = is_own(contact.body_b);
      if (a == b || (contact.depth < 0.0 && contact.force.isZero(0.0))) continue;
      reading.contacts.push_back(b ? contact : turned(contact));
      total += reading.contacts.back().force;
      others_.push_back(reading.contacts.back().body_a);
    }
    std::sort(others_.begin(), others_.end());
    const auto bodies = std::unique(others_.begin(), others_.end()) - others_.begin();
    reading.values[0] = static_cast<double>(reading.contacts.size());
    reading.values[1] = static_cast<double>(bodies);
    put(reading.values, 2, motion_of(sensor_, frame.state).X_WS.q.conjugate() * total);
    return {};
  }
  bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
               std::vector<double>& walk, Reading& reading) override {
    const bool received = apply_noise(noise, channels_, period, random, walk, reading.values);
    saturate(reading.values, 2, 5, max_force_);
    return received;
  }

 private:
  static Contact turned(Contact contact) {
    std::swap(contact.body_a, contact.body_b);
    std::swap(contact.shape_a, contact.shape_b);
    contact.normal = -contact.normal;
    contact.force = -contact.force;
    return contact;
  }
  bool is_own(int body) const {
    return std::binary_search(own_bodies_.begin(), own_bodies_.end(), body);
  }

  SensorModel sensor_;
  std::vector<Channel> channels_;
  std::vector<int> own_bodies_;    // sorted
  std::vector<int> others_;  // scratch
  double max_force_ = 0.0;
};

}  // namespace

PluginDescriptor contact() {
  return describe<ContactSense>(
      "contact", "what touches a body: points, bodies, and the total force in the sensor's axes",
      {parameter("whole-assembly", false,
                 "senses all bodies of its assembly, not only its own"),
       parameter("max-force", 0.0, "N", "largest component it reads; 0: no limit")
           .range(0.0, kInfinity)});
}

}  // namespace cogrsim::sensor_models
