#include <algorithm>

#include "sensing/instrument.h"

namespace cogrsim::instruments {

namespace {

/// Touch: what presses on a body, or on all bodies of the assembly it stands in (what touches
/// within the assembly is left out then). A point counts when it carries force or the surfaces
/// overlap; engines also list points that are about to touch. Values: how many points and how many
/// other bodies, and the sum of the forces on what is felt, in the sensor's axes, mean over the
/// last step. Reading::contacts has the points themselves, with body_b as what is felt. Noise is on
/// the force, which then saturates.
class ContactSense final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters& parameters) override {
    sensor_ = sensor;
    max_force_ = number(parameters, "max-force");
    felt_.clear();
    if (boolean(parameters, "whole-assembly")) {
      if (sensor.assembly < 0) {
        return fail("it stands in no assembly that it could feel as a whole");
      }
      felt_ = bodies_of(model, sensor.assembly);
      std::sort(felt_.begin(), felt_.end());
    } else if (sensor.body != kWorld) {
      felt_ = {sensor.body};
    }
    if (felt_.empty()) return fail("it is mounted on no body", "", "name one: on=\"…\"");
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
  Result<> read(Sensing& sensing, Reading& reading) override {
    const Frame& frame = sensing.frame();
    Vec3 total = Vec3::Zero();
    others_.clear();
    for (const Contact& contact : frame.contacts) {
      const bool a = feels(contact.body_a), b = feels(contact.body_b);
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
    const bool heard = apply_noise(noise, channels_, period, random, walk, reading.values);
    saturate(reading.values, 2, 5, max_force_);
    return heard;
  }

 private:
  static Contact turned(Contact contact) {
    std::swap(contact.body_a, contact.body_b);
    std::swap(contact.shape_a, contact.shape_b);
    contact.normal = -contact.normal;
    contact.force = -contact.force;
    return contact;
  }
  bool feels(int body) const { return std::binary_search(felt_.begin(), felt_.end(), body); }

  SensorModel sensor_;
  std::vector<Channel> channels_;
  std::vector<int> felt_;    // sorted
  std::vector<int> others_;  // scratch
  double max_force_ = 0.0;
};

}  // namespace

PluginDescriptor contact() {
  return describe<ContactSense>(
      "contact", "what touches a body: points, bodies, and the total force in the sensor's axes",
      {parameter("whole-assembly", false,
                 "feels all bodies of the assembly it stands in, not only its own"),
       parameter("max-force", 0.0, "N", "largest component it reads; 0: no limit")
           .range(0.0, kInfinity)});
}

}  // namespace cogrsim::instruments
