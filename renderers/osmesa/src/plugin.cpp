// The renderer "osmesa": checks what it is asked and hands it to the thread that may draw.
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>

#include "cogrsim/rendering/renderer.h"
#include "gl_context.h"
#include "scene_renderer.h"
#include "worker.h"

namespace cogrsim::osmesa {

namespace {

Result<> check_request(const RenderRequest& request) {
  if (Result<> checked = check_camera(request.camera); !checked) return checked;
  const int known[] = {1, 2, 4, 8};
  if (std::find(std::begin(known), std::end(known), request.samples) == std::end(known)) {
    return fail(fmt::format("{} samples per pixel, expected 1, 2, 4 or 8", request.samples));
  }
  return {};
}

class OsmesaRenderer final : public Renderer {
 public:
  /// Empty, or why it does not work.
  std::string start() {
    std::string problem;
    try {
      worker_.run([&] {
        context_ = GlContext::create(&problem);
        if (context_ != nullptr) scene_ = std::make_unique<SceneRenderer>(context_->gl());
      });
    } catch (const std::exception& e) {
      problem = message_of(e);
    }
    return problem;
  }

  ~OsmesaRenderer() override {
    worker_.run([this] {
      scene_.reset();
      context_.reset();
    });
  }

  const char* name() const override { return "osmesa"; }

  Result<std::vector<Picture>> render(const Frame& frame,
                                      const std::vector<RenderRequest>& requests) override {
    if (frame.model == nullptr) return fail("a frame without a model cannot be drawn");
    if (frame.state.poses.size() != frame.model->bodies.size()) {
      return fail(fmt::format("the frame has poses of {} bodies, its model has {} bodies",
                              frame.state.poses.size(), frame.model->bodies.size()));
    }
    for (std::size_t i = 0; i < requests.size(); ++i) {
      if (Result<> checked = check_request(requests[i]); !checked) {
        Error error = checked.error();
        if (requests.size() > 1) error.message = fmt::format("request {}: {}", i, error.message);
        return tl::unexpected<Error>(std::move(error));
      }
    }
    try {
      Result<std::vector<Picture>> out = std::vector<Picture>();
      worker_.run([&] { out = scene_->render(frame, requests); });
      return out;
    } catch (const std::bad_alloc&) {
      return fail("not enough memory for the pictures", "", "ask for smaller or fewer ones");
    } catch (const std::exception& e) {
      return fail(fmt::format("drawing failed: {}", e.what()));
    }
  }

 private:
  std::unique_ptr<GlContext> context_;
  std::unique_ptr<SceneRenderer> scene_;
  Worker worker_;  // last: ends before what it uses
};

Renderer* create(std::string* problem) {
  try {
    auto made = std::make_unique<OsmesaRenderer>();
    *problem = made->start();
    return problem->empty() ? made.release() : nullptr;
  } catch (const std::exception& e) {
    *problem = message_of(e);
    return nullptr;
  }
}

void destroy(Renderer* renderer) { delete renderer; }

}  // namespace

}  // namespace cogrsim::osmesa

COGRSIM_RENDERER(cogrsim::osmesa::create, cogrsim::osmesa::destroy, "osmesa", version("1.0.0"),
                 summary("Pictures by software: OpenGL 3.3 on OSMesa, no display needed"))
