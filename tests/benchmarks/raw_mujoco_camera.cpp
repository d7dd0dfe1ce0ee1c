// The camera benchmark's scene as a program on bare MuJoCo: its own renderer on OSMesa.
#include <GL/osmesa.h>
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "camera_bench.h"

namespace cogrsim::bench {

namespace {

std::string describe(const CameraScene& scene) {
  std::string out = fmt::format(
      R"(<mujoco><visual><global offwidth="{}" offheight="{}" fovy="{}"/>
<quality shadowsize="{}" offsamples="{}"/><headlight active="0"/><map znear="0.001" zfar="10"/></visual>
<worldbody><light directional="true" castshadow="true" dir="0.45 0.3 -1" pos="0 0 20"
 ambient="0.2 0.2 0.2" diffuse="0.8 0.8 0.8" specular="0 0 0"/>
<geom type="plane" size="0 0 1" rgba="0.6 0.6 0.6 1"/>)",
      scene.width, scene.height, kVerticalField * 180.0 / 3.14159265358979323846, kShadowMapSize,
      scene.samples > 1 ? scene.samples : 0);
  const char* const kinds[] = {R"(type="box" size="0.2 0.15 0.15")", R"(type="sphere" size="0.2")",
                               R"(type="cylinder" size="0.15 0.2")",
                               R"(type="capsule" size="0.12 0.15")"};
  for (int i = 0; i < scene.shapes; ++i) {
    const Vec3 p = place_of(i, scene.shapes);
    out += fmt::format("<geom {} pos=\"{} {} {}\" rgba=\"{} 0.5 {} 1\"/>\n", kinds[i % 4], p.x(),
                       p.y(), p.z(), 0.2 + 0.15 * (i % 5), 0.8 - 0.1 * (i % 7));
  }
  return out + "</worldbody></mujoco>\n";
}

class MujocoCamera final : public CameraRunner {
 public:
  explicit MujocoCamera(const CameraScene& scene) : scene_(scene) {
    const std::string text = describe(scene);
    mjVFS* files = static_cast<mjVFS*>(std::malloc(sizeof(mjVFS)));
    mj_defaultVFS(files);
    mj_makeEmptyFileVFS(files, "scene.xml", static_cast<int>(text.size()));
    std::copy(text.begin(), text.end(), static_cast<char*>(files->filedata[0]));
    char problem[1000] = "";
    model_ = mj_loadXML("scene.xml", files, problem, sizeof problem);
    std::free(files);
    if (model_ == nullptr) fail(problem);
    data_ = mj_makeData(model_);
    mj_forward(model_, data_);
    context_ = OSMesaCreateContextExt(GL_RGBA, 24, 8, 8, nullptr);
    use();
    mjv_defaultOption(&options_);
    mjv_defaultScene(&drawn_);
    mjr_defaultContext(&graphics_);
    mjv_makeScene(model_, &drawn_, scene.shapes + 10);
    mjr_makeContext(model_, &graphics_, mjFONTSCALE_100);
    mjr_setBuffer(mjFB_OFFSCREEN, &graphics_);
    if (graphics_.currentBuffer != mjFB_OFFSCREEN) fail("MuJoCo has no offscreen buffer");
    if (graphics_.offSamples != (scene.samples > 1 ? scene.samples : 0)) {
      fail("MuJoCo did not get the samples asked for");
    }
    // The free camera: at a distance from the point it looks at.
    const Pose X_WC = viewpoint();
    const Vec3 ahead = X_WC.q * Vec3::UnitX();
    mjv_defaultFreeCamera(model_, &camera_);
    camera_.type = mjCAMERA_FREE;
    camera_.distance = 1.0;
    for (int i = 0; i < 3; ++i) camera_.lookat[i] = X_WC.p[i] + ahead[i];
    camera_.azimuth = std::atan2(ahead.y(), ahead.x()) * 180.0 / mjPI;
    camera_.elevation = std::asin(ahead.z()) * 180.0 / mjPI;
    picture_.resize(3 * static_cast<std::size_t>(scene.width * scene.height));
  }
  ~MujocoCamera() override {
    use();
    mjr_freeContext(&graphics_);
    mjv_freeScene(&drawn_);
    mj_deleteData(data_);
    mj_deleteModel(model_);
    OSMesaDestroyContext(context_);
  }

  void take(int frame) override {
    use();
    for (int i = 0; i < scene_.shapes; ++i) {
      data_->geom_xpos[3 * (i + 1) + 2] = place_of(i, scene_.shapes).z() + height_at(i, frame);
    }
    mjv_updateScene(model_, data_, &options_, nullptr, &camera_, mjCAT_ALL, &drawn_);
    for (int i = 0; i < mjNRNDFLAG; ++i) drawn_.flags[i] = 0;
    drawn_.flags[mjRND_CULL_FACE] = 1;
    drawn_.flags[mjRND_SHADOW] = scene_.shadows ? 1 : 0;
    const mjrRect all = {0, 0, scene_.width, scene_.height};
    mjr_render(all, &drawn_, &graphics_);
    mjr_readPixels(picture_.data(), nullptr, all, &graphics_);
  }
  std::vector<std::uint8_t> picture() const override {
    // Its rows come from the bottom up.
    std::vector<std::uint8_t> out;
    const auto row = static_cast<std::ptrdiff_t>(3 * scene_.width);
    for (auto end = picture_.end(); end != picture_.begin(); end -= row) {
      out.insert(out.end(), end - row, end);
    }
    return out;
  }

 private:
  [[noreturn]] static void fail(const char* what) {
    fmt::print(stderr, "MuJoCo: {}\n", what);
    std::exit(1);
  }
  void use() {
    if (OSMesaMakeCurrent(context_, window_.data(), GL_UNSIGNED_BYTE, 8, 8) != GL_TRUE) {
      fail("OSMesa does not make its context current");
    }
  }

  CameraScene scene_;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, 8 * 8 * 4> window_{};
  mjvScene drawn_;
  mjvOption options_;
  mjvCamera camera_;
  mjrContext graphics_;
  std::vector<std::uint8_t> picture_;
};

}  // namespace

std::unique_ptr<CameraRunner> make_mujoco_camera(const CameraScene& scene) {
  return std::make_unique<MujocoCamera>(scene);
}

}  // namespace cogrsim::bench
