// The renderer against MuJoCo's own on the same OSMesa: interleaved rounds, medians, ratios.
//
//     cogrsim_camera_bench [--rounds 7] [--width 640] [--json] [--pictures FOLDER]
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "camera_bench.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim::bench {

Pose viewpoint() {
  const double down = 0.35;  // [rad]
  return {Vec3(-5.0, 0.0, 2.6), Quat(Eigen::AngleAxisd(down, Vec3::UnitY()))};
}

Vec3 place_of(int shape, int shapes) {
  const int columns = static_cast<int>(std::ceil(std::sqrt(shapes)));
  // The same patch of floor however many there are, near to far.
  const double step = 8.0 / columns;
  return {-2.5 + step * (shape / columns), step * (shape % columns - 0.5 * (columns - 1)), 0.4};
}

double height_at(int shape, int frame) { return 0.1 * std::sin(0.1 * frame + shape); }

namespace {

class OurCamera final : public CameraRunner {
 public:
  OurCamera(std::shared_ptr<Renderer> renderer, const CameraScene& scene)
      : renderer_(std::move(renderer)), scene_(scene) {
    ModelBuilder builder("camera benchmark");
    const auto color = [&](double r, double g, double b) {
      const int material =
          builder.material(fmt::format("m{}", builder.model.materials.size()), 0.5);
      builder.model.materials[material].color = {r, g, b, 1.0};
      return material;
    };
    for (int i = 0; i < scene.shapes; ++i) {
      const Pose X_WB(place_of(i, scene.shapes), Quat(1, 0, 0, 0));
      const std::string name = fmt::format("shape{}", i);
      const int material = color(0.2 + 0.15 * (i % 5), 0.5, 0.8 - 0.1 * (i % 7));
      if (i % 4 == 0) builder.box(name, Vec3(0.4, 0.3, 0.3), 1.0, X_WB, material);
      if (i % 4 == 1) builder.sphere(name, 0.2, 1.0, X_WB, material);
      if (i % 4 == 2) builder.cylinder(name, 0.15, 0.4, 1.0, X_WB, material);
      if (i % 4 == 3) builder.capsule(name, 0.12, 0.3, 1.0, X_WB, material);
    }
    builder.plane("floor", {}, color(0.6, 0.6, 0.6));
    LightModel sun;
    sun.name = "sun";
    sun.X_WL.q = Quat::FromTwoVectors(Vec3::UnitX(), Vec3(0.45, 0.3, -1.0));
    builder.model.lights.push_back(sun);
    frame_.model = builder.build();
    for (const Body& body : frame_.model->bodies) frame_.state.poses.push_back(body.X_WB);
    const double focal = 0.5 * scene.height / std::tan(0.5 * kVerticalField);
    request_.camera = make_camera(viewpoint(), scene.width, scene.height,
                                  2.0 * std::atan(0.5 * scene.width / focal));
    request_.shadows = scene.shadows;
    request_.samples = scene.samples;
    request_.background.kind = Background::Kind::plain;
    request_.background.color = {0, 0, 0, 1};
  }

  void take(int frame) override {
    for (int i = 0; i < scene_.shapes; ++i) {
      frame_.state.poses[i].p.z() = place_of(i, scene_.shapes).z() + height_at(i, frame);
    }
    Result<std::vector<Picture>> taken = renderer_->render(frame_, {request_});
    if (!taken) {
      fmt::print(stderr, "{}\n", taken.error().text());
      std::exit(1);
    }
    picture_ = std::move(taken->front());
  }
  std::vector<std::uint8_t> picture() const override { return picture_.color.data; }

 private:
  std::shared_ptr<Renderer> renderer_;
  CameraScene scene_;
  Frame frame_;
  RenderRequest request_;
  Picture picture_;
};

struct Cost {
  double wall = 0.0, cpu = 0.0;  ///< per picture [ms]
};

Cost measure(CameraRunner& runner, int pictures, int* frame) {
  const auto cpu = [] {
    std::timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  };
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start = cpu();
  for (int i = 0; i < pictures; ++i) runner.take((*frame)++);
  const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
  return {passed.count() / pictures, (cpu() - cpu_start) / pictures};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void keep_picture(const std::string& path, const CameraScene& scene, const CameraRunner& runner) {
  const Image image{scene.width, scene.height, 3, runner.picture()};
  if (const Result<std::string> png = encode_png(image))
    (void)write_output_file(path, OutputKind::png, *png);
}

struct Options {
  int rounds = 7;
  int width = 0;  ///< of the only size to measure; 0: all
  bool json = false;
  std::string pictures;
};

Options read_options(int argc, char** argv) {
  Options out;
  for (int i = 1; i < argc; ++i) {
    const bool more = i + 1 < argc;
    if (std::strcmp(argv[i], "--json") == 0) {
      out.json = true;
    } else if (std::strcmp(argv[i], "--rounds") == 0 && more && std::atoi(argv[i + 1]) > 0) {
      out.rounds = std::atoi(argv[++i]);
    } else if (std::strcmp(argv[i], "--width") == 0 && more) {
      out.width = std::atoi(argv[++i]);
    } else if (std::strcmp(argv[i], "--pictures") == 0 && more) {
      out.pictures = argv[++i];
    } else {
      fmt::print(stderr,
                 "usage: {} [--rounds N] [--width 160|320|640] [--json] [--pictures FOLDER]\n",
                 argv[0]);
      std::exit(2);
    }
  }
  return out;
}

int run(const Options& options) {
  PluginLoader loader;
  const Result<std::shared_ptr<Renderer>> renderer = load_renderer(loader);
  if (!renderer) {
    fmt::print(stderr, "{}\n", renderer.error().text());
    return 1;
  }
  nlohmann::json rows = nlohmann::json::array();
  if (!options.json) {
    fmt::print("{:>9} {:>6} {:>7} {:>7} | {:>10} {:>10} {:>6} | {:>10} {:>10} {:>6}\n", "size",
               "shapes", "shadows", "samples", "ours fps", "MuJoCo fps", "ratio", "ours ms CPU",
               "MuJoCo ms", "ratio");
  }
  const int sizes[][2] = {{160, 120}, {320, 240}, {640, 480}};
  for (const auto& [width, height] : sizes) {
    if (options.width != 0 && options.width != width) continue;
    for (const int shapes : {20, 100, 400}) {
      for (const bool shadows : {false, true}) {
        for (const int samples : {1, 4}) {
          const CameraScene scene{width, height, shapes, shadows, samples};
          OurCamera ours(*renderer, scene);
          const std::unique_ptr<CameraRunner> theirs = make_mujoco_camera(scene);
          int our_frame = 0, their_frame = 0;
          const Cost first = measure(ours, 3, &our_frame);
          measure(*theirs, 3, &their_frame);
          (void)first;
          const int pictures = std::clamp(640 * 480 / (width * height), 2, 8);
          std::vector<double> our_wall, their_wall, wall, our_cpu, their_cpu, cpu;
          for (int round = 0; round < options.rounds; ++round) {
            const Cost a = measure(ours, pictures, &our_frame);
            const Cost b = measure(*theirs, pictures, &their_frame);
            our_wall.push_back(1e3 / a.wall);
            their_wall.push_back(1e3 / b.wall);
            wall.push_back(b.wall / a.wall);
            our_cpu.push_back(a.cpu);
            their_cpu.push_back(b.cpu);
            cpu.push_back(b.cpu / a.cpu);
          }
          if (!options.pictures.empty()) {
            const std::string stem =
                fmt::format("{}/{}x{}_{}_{}_{}", options.pictures, width, height, shapes,
                            shadows ? "shadows" : "plain", samples);
            keep_picture(stem + "_ours.png", scene, ours);
            keep_picture(stem + "_mujoco.png", scene, *theirs);
          }
          if (options.json) {
            rows.push_back({{"width", width},
                            {"height", height},
                            {"shapes", shapes},
                            {"shadows", shadows},
                            {"samples", samples},
                            {"frames_per_second", median(our_wall)},
                            {"mujoco_frames_per_second", median(their_wall)},
                            {"ratio", median(wall)},
                            {"cpu_ms", median(our_cpu)},
                            {"mujoco_cpu_ms", median(their_cpu)},
                            {"cpu_ratio", median(cpu)}});
          } else {
            fmt::print(
                "{:>9} {:>6} {:>7} {:>7} | {:>10.1f} {:>10.1f} {:>6.2f} | {:>10.2f} "
                "{:>10.2f} {:>6.2f}\n",
                fmt::format("{}x{}", width, height), shapes, shadows ? "yes" : "no", samples,
                median(our_wall), median(their_wall), median(wall), median(our_cpu),
                median(their_cpu), median(cpu));
            std::fflush(stdout);
          }
        }
      }
    }
  }
  if (options.json) fmt::print("{}\n", rows.dump(2));
  return 0;
}

}  // namespace
}  // namespace cogrsim::bench

int main(int argc, char** argv) {
  return cogrsim::bench::run(cogrsim::bench::read_options(argc, argv));
}
