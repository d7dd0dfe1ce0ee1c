#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/random.h"
#include "cogrsim/rendering/renderer.h"
#include "cogrsim/sensing/sensor_models.h"
#include "geometry/inside_shape.h"
#include "sensing/sensor_model.h"

namespace cogrsim {

namespace sensor_models {

namespace {

bool inside_body(const SceneModel& model, int body, const Vec3& p_W) {
  const Body& b = model.bodies[body];
  const Vec3 p_B = b.X_WB.inverse() * p_W;
  return std::any_of(b.shapes.begin(), b.shapes.end(), [&](const Shape& shape) {
    return shape.visible && geometry::inside_shape(model, shape, shape.X_BS.inverse() * p_B);
  });
}

/// Adds noise to an array of numbers, term by term as apply_noise(). If `holes` is set, dropout
/// makes single entries NaN instead of dropping the whole reading.
template <class Number>
void disturb_field(const std::vector<NoiseTerm>& noise, int group, double period,
                   RandomStream& random, double& walk, bool holes, std::vector<Number>& field) {
  for (const NoiseTerm& term : noise) {
    if (term.group != group) continue;
    double offset = 0.0;
    switch (term.kind) {
      case NoiseTerm::Kind::normal:
        for (Number& v : field) v += static_cast<Number>(random.normal(term.a, term.b));
        continue;
      case NoiseTerm::Kind::uniform:
        for (Number& v : field) v += static_cast<Number>(random.uniform(term.a, term.b));
        continue;
      case NoiseTerm::Kind::dropout:
        if (!holes) continue;
        for (Number& v : field) {
          if (random.uniform() < term.a) v = std::numeric_limits<Number>::quiet_NaN();
        }
        continue;
      case NoiseTerm::Kind::quantisation:
        for (Number& v : field) v = static_cast<Number>(term.a * std::round(v / term.a));
        continue;
      case NoiseTerm::Kind::bias:
        offset = term.a;
        break;
      case NoiseTerm::Kind::bias_walk:
        walk += random.normal(0.0, term.a * std::sqrt(period));
        offset = walk;
        break;
    }
    for (Number& v : field) v += static_cast<Number>(offset);
  }
}

/// Pinhole camera with lens distortion, see Camera in cogrsim/rendering/renderer.h.
/// Reading::picture has the requested images of colour, depth and segmentation. The values are the
/// mean brightness (of all colour values, 0 to 1) and the smallest depth [m], or NaN without such
/// an image.
///
/// Noise of group 0 acts on every colour value as a number from 0 to 1, which is clamped
/// afterwards; dropout loses the whole image. Noise of group 1 acts on every depth; dropout makes
/// single pixels NaN. Bias and bias walk are the same for all pixels of an image.
class CameraInstrument final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters&) override {
    sensor_ = sensor;
    WorldState at_start;
    for (const Body& body : model.bodies) at_start.poses.push_back(body.X_WB);
    at_start.twists.resize(model.bodies.size());
    auto request = camera_request(model, sensor, at_start);
    if (!request) return tl::unexpected(request.error());
    request_ = std::move(*request);
    return {};
  }
  std::vector<Channel> channels() const override {
    return {{"brightness", "1", false, 0}, {"nearest", "m", false, 1}};
  }
  Result<> read(SensorContext& context, Reading& reading) override {
    request_.camera.X_WC = motion_of(sensor_, context.frame().state).X_WS;
    auto pictures = context.render({request_});
    if (!pictures) return tl::unexpected(pictures.error());
    fresh_ = std::make_shared<Picture>(std::move(pictures->front()));
    reading.picture = fresh_;
    finish(reading);
    return {};
  }
  bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
               std::vector<double>& walk, Reading& reading) override {
    const std::shared_ptr<Picture> picture = std::move(fresh_);
    fresh_.reset();
    if (noise.empty() || !picture || reading.picture != picture) return true;
    bool received = true;
    for (const NoiseTerm& term : noise) {
      if (term.kind != NoiseTerm::Kind::dropout || term.group != 0) continue;
      if (random.uniform() < term.a) received = false;
    }
    disturb_color(noise, period, random, walk[0], picture->color);
    disturb_field(noise, 1, period, random, walk[1], true, picture->depth);
    for (float& depth : picture->depth) depth = std::max(depth, 0.0f);  // NaN stays NaN
    finish(reading);
    if (!received) reading.picture.reset();
    return received;
  }

 private:
  static void disturb_color(const std::vector<NoiseTerm>& noise, double period,
                            RandomStream& random, double& walk, Image& image) {
    const bool any = std::any_of(noise.begin(), noise.end(), [](const NoiseTerm& term) {
      return term.group == 0 && term.kind != NoiseTerm::Kind::dropout;
    });
    if (!any) return;
    std::vector<double> field(image.data.size());
    for (std::size_t i = 0; i < field.size(); ++i) field[i] = image.data[i] / 255.0;
    disturb_field(noise, 0, period, random, walk, false, field);
    for (std::size_t i = 0; i < field.size(); ++i) {
      image.data[i] =
          static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(field[i], 0.0, 1.0)));
    }
  }

  static void finish(Reading& reading) {
    const Picture& picture = *reading.picture;
    reading.values = {kNaN, kNaN};
    if (!picture.color.data.empty()) {
      double sum = 0.0;
      for (const std::uint8_t v : picture.color.data) sum += v;
      reading.values[0] = sum / (255.0 * static_cast<double>(picture.color.data.size()));
    }
    for (const float depth : picture.depth) {
      if (!std::isnan(depth) && !(reading.values[1] <= depth)) reading.values[1] = depth;
    }
  }

  SensorModel sensor_;
  RenderRequest request_;
  std::shared_ptr<Picture> fresh_;  ///< between read() and disturb()
};

}  // namespace

bool in_own_body(const SceneModel& model, const SensorModel& sensor) {
  if (sensor.body == kWorld) return false;
  const Pose& X_WB = model.bodies[sensor.body].X_WB;
  return inside_body(model, sensor.body, X_WB * sensor.X_BS.p);
}

Result<RenderRequest> camera_settings(const Parameters& parameters) {
  RenderRequest request;
  const std::vector<double>& size = list(parameters, "resolution");
  if (size.size() != 2 || size[0] != std::floor(size[0]) || size[1] != std::floor(size[1])) {
    return fail("the resolution takes two whole numbers", "", "write resolution=\"320 240\"");
  }
  // check_camera() also rejects sizes that exceed the range of int.
  const auto pixels = [](double v) { return static_cast<int>(std::clamp(v, -1.0, 2.0e9)); };
  request.camera = make_camera({}, pixels(size[0]), pixels(size[1]), number(parameters, "fov"));
  request.camera.near = number(parameters, "near");
  request.camera.far = number(parameters, "far");
  const std::vector<double>& distortion = list(parameters, "distortion");
  if (!distortion.empty()) {
    if (distortion.size() != 5) {
      return fail("the distortion takes five numbers, k1 k2 p1 p2 k3, found " +
                  std::to_string(distortion.size()));
    }
    std::copy(distortion.begin(), distortion.end(), request.camera.distortion.begin());
  }
  const std::vector<double>& middle = list(parameters, "principal-point");
  if (!middle.empty()) {
    if (middle.size() != 2) return fail("the principal point takes two numbers, column and row");
    request.camera.cx = middle[0];
    request.camera.cy = middle[1];
  }
  request.color = boolean(parameters, "color");
  request.depth = boolean(parameters, "depth");
  request.segmentation = boolean(parameters, "segmentation");
  request.shadows = boolean(parameters, "shadows");
  request.samples = static_cast<int>(integer(parameters, "samples"));
  const int n = request.samples;
  if (n != 1 && n != 2 && n != 4 && n != 8) {
    return fail("the samples of a pixel are 1, 2, 4 or 8, found " + std::to_string(n));
  }
  if (!request.color && !request.depth && !request.segmentation) {
    return fail("it takes neither colour nor depth nor segmentation");
  }
  if (auto good = check_camera(request.camera); !good) {
    Error error = good.error();
    if (error.code.empty()) error.code = "CG0710";
    return tl::unexpected(std::move(error));
  }
  return request;
}

PluginDescriptor camera() {
  return describe<CameraInstrument>(
      "camera", "pictures: colour, depth, segmentation",
      {parameter("resolution", std::vector<double>{320, 240}, "", "columns and rows [pixel]"),
       parameter("fov", kPi / 3.0, "rad", "horizontal opening angle"),
       parameter("near", 0.01, "m", "nearer surfaces are invisible"),
       parameter("far", 100.0, "m", "farther surfaces are invisible"),
       parameter("color", true, "takes a colour picture"),
       parameter("depth", false, "takes a depth picture"),
       parameter("segmentation", false, "takes an image of the body in every pixel"),
       parameter("distortion", std::vector<double>{}, "", "of the lens: k1 k2 p1 p2 k3"),
       parameter("principal-point", std::vector<double>{}, "",
                 "column and row [pixel]; the middle if left out"),
       parameter("shadows", true, "draws shadows"),
       parameter("samples", 4, "samples of a pixel against jagged edges: 1, 2, 4 or 8").range(1, 8),
       parameter("priority", 0, "among the cameras shown: the higher, the further in front"),
       parameter("sees-own-body", true,
                 "the body it is mounted on is seen; never when the camera is inside it")});
}

}  // namespace sensor_models

std::vector<BuriedCamera> buried_cameras(const SceneModel& model) {
  std::vector<BuriedCamera> found;
  for (std::size_t s = 0; s < model.sensors.size(); ++s) {
    const SensorModel& sensor = model.sensors[s];
    if (sensor.type != "camera" || sensor.removed) continue;
    Vec3 eye = sensor.X_BS.p;
    if (sensor.body != kWorld) eye = model.bodies[sensor.body].X_WB * eye;
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      const int body = static_cast<int>(i);
      if (model.bodies[i].removed || body == sensor.body) continue;
      if (!sensor_models::inside_body(model, body, eye)) continue;
      found.push_back(
          {static_cast<int>(s),
           Error("camera '" + sensor.name + "' lies inside body '" + model.bodies[i].name + "'", "",
                 "move it out, mount it on that body, or make the shape around it "
                 "invisible with visible=\"false\"",
                 "CG0711")});
      break;
    }
  }
  return found;
}

}  // namespace cogrsim
