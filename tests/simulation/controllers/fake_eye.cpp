// A fake renderer: grey pictures, 2 m deep, whose labels count the pictures made so far.
#include "cogrsim/rendering/renderer.h"

namespace {

class FakeEye final : public cogrsim::Renderer {
 public:
  const char* name() const override { return "osmesa"; }
  cogrsim::Result<std::vector<cogrsim::Picture>> render(
      const cogrsim::Frame&, const std::vector<cogrsim::RenderRequest>& requests) override {
    std::vector<cogrsim::Picture> pictures;
    for (const cogrsim::RenderRequest& request : requests) {
      ++count_;
      cogrsim::Picture picture;
      picture.width = request.camera.width;
      picture.height = request.camera.height;
      const auto pixels = static_cast<std::size_t>(picture.width * picture.height);
      if (request.color) {
        picture.color = {picture.width, picture.height, 3,
                         std::vector<std::uint8_t>(3 * pixels, 102)};
      }
      if (request.depth) picture.depth.assign(pixels, 2.0f);
      picture.bodies.assign(pixels, count_);
      pictures.push_back(std::move(picture));
    }
    return pictures;
  }

 private:
  std::int32_t count_ = 0;
};

cogrsim::Renderer* make(std::string*) { return new FakeEye; }
void destroy(cogrsim::Renderer* renderer) { delete renderer; }

}  // namespace

COGRSIM_RENDERER(make, destroy, "osmesa", version("1.0.0"), summary("counts pictures"))
