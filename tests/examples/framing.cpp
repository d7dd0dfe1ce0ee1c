// Whether everything that moves stays in the picture of a film, as `cogrsim render` makes it:
//
//   cogrsim_examples_framing SCENE [SECONDS]
//
// Runs the scene for its duration, at most so long (20 s), and projects the corners of the boxes
// around all visible shapes that can move into each frame, 20 a second, in every standard view.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/geometry/convex.h"
#include "cogrsim/rendering/framing.h"
#include "cogrsim/rendering/standard_view.h"
#include "cogrsim/simulation/simulation.h"

using namespace cogrsim;

namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kEvery = 0.05;  // [s]

[[noreturn]] void give_up(const std::vector<Diagnostic>& why) {
  std::fputs(dsl::to_text(why).c_str(), stderr);
  std::exit(1);
}

bool in_picture(const Camera& camera, const Vec3& point) {
  const Vec3 p = camera.X_WC.q.conjugate() * (point - camera.X_WC.p);
  if (p.x() < camera.near || p.x() > camera.far) return false;
  const double column = camera.cx - camera.fx * p.y() / p.x();
  const double row = camera.cy - camera.fy * p.z() / p.x();
  return column >= 0.0 && column <= kWidth && row >= 0.0 && row <= kHeight;
}

/// Name of a body that can move and is not wholly in the picture; empty: none.
std::string missing(const Frame& frame, const Camera& camera) {
  const SceneModel& model = *frame.model;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (body.removed || body.kind == BodyKind::static_body) continue;
    for (const Shape& shape : body.shapes) {
      if (!shape.visible || shape.type == ShapeType::plane) continue;
      const geometry::Bounds local = geometry::local_bounds(model, shape);
      for (int k = 0; k < 8; ++k) {
        if (!in_picture(camera, frame.state.poses[i] * (shape.X_BS * local.corner(k))))
          return body.name;
      }
    }
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fputs("usage: cogrsim_examples_framing SCENE [SECONDS]\n", stderr);
    return 2;
  }
  const auto loader = std::make_shared<PluginLoader>();
  dsl::LoaderCatalog catalog(loader);
  dsl::CompileOptions options;
  options.plugins = &catalog;
  const dsl::CompileResult scene = dsl::compile_file(argv[1], options);
  if (!scene.ok()) give_up(scene.diagnostics);
  auto simulation = Simulation::create(scene.model, {}, loader);
  if (!simulation) give_up(simulation.error());
  const double most = argc > 2 ? std::atof(argv[2]) : 20.0;
  const double end = std::min(most, scene.model->physics.duration.value_or(most));

  int frames = 0, whole = 0;
  std::vector<Framing> framings(standard_view_names().size(), Framing(*(*simulation)->frame()));
  for (double time = 0.0; time <= end + 1e-9; time += kEvery) {
    if ((*simulation)->run_until(time) != RunStatus::completed) break;
    const FramePtr frame = (*simulation)->frame();
    for (std::size_t i = 0; i < framings.size(); ++i) {
      const auto view = static_cast<StandardView>(i);
      const std::string out =
          missing(*frame, standard_camera(view, framings[i].follow(*frame), kWidth, kHeight));
      ++frames;
      whole += out.empty() ? 1 : 0;
      if (!out.empty() && frames - whole <= 10)
        std::printf("%6.2f s, %s: %s is not in the picture\n", time, to_string(view), out.c_str());
    }
  }
  std::printf("%d of %d frames have everything that moves in view\n", whole, frames);
  return frames > 0 && whole == frames ? 0 : 1;
}
