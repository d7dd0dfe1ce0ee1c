#include "contact.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/rendering/standard_view.h"
#include "look.h"

namespace cogrsim::osmesa {

namespace {

/// Height of the lowest horizontal floor.
std::optional<double> ground_of(const SceneModel& model) {
  std::optional<double> lowest;
  for (const Body& body : model.bodies) {
    if (body.removed || body.kind != BodyKind::static_body) continue;
    for (const Shape& shape : body.shapes) {
      if (!shape.visible || shape.type != ShapeType::plane) continue;
      const Vec3 up = body.X_WB.q * (shape.X_BS.q * Vec3::UnitZ());
      const double height = (body.X_WB * shape.X_BS.p).z();
      if (up.z() > 0.999 && (!lowest || height < *lowest)) lowest = height;
    }
  }
  return lowest;
}

/// A bell over `values`, `count` of them, each `stride` after the other.
void blur(const float* from, float* to, int count, int stride, const std::vector<float>& bell) {
  const int half = static_cast<int>(bell.size()) - 1;
  for (int i = 0; i < count; ++i) {
    float sum = 0.0F;
    for (int k = std::max(-half, -i); k <= std::min(half, count - 1 - i); ++k)
      sum += bell[static_cast<std::size_t>(std::abs(k))] * from[(i + k) * stride];
    to[i * stride] = sum;
  }
}

}  // namespace

ContactShadows::~ContactShadows() {
  if (texture_ != 0) gl_.DeleteTextures(1, &texture_);
}

void ContactShadows::take_model(const SceneModelPtr& model) {
  model_ = model;
  ground_ = ground_of(*model);
  Frame start;
  start.model = model;
  for (const Body& body : model->bodies) start.state.poses.push_back(body.X_WB);
  std::vector<double> sizes;
  for (std::size_t i = 0; i < model->bodies.size(); ++i) {
    const Body& body = model->bodies[i];
    if (body.removed || body.kind == BodyKind::static_body) continue;
    const geometry::Bounds box = visible_bounds(start, i);
    if (!box.empty()) sizes.push_back(2.0 * box.half().norm());
  }
  std::sort(sizes.begin(), sizes.end());
  usual_ = sizes.empty() ? 0.0 : sizes[sizes.size() / 2];
}

std::optional<View> ContactShadows::view_for(const std::vector<Pose>& poses) {
  width_ = 0.0;
  if (!ground_ || usual_ <= 0.0) return std::nullopt;
  Frame now;
  now.model = model_;
  now.state.poses = poses;
  const geometry::Bounds all = visible_bounds(now);
  width_ = std::max(all.high.x() - all.low.x(), all.high.y() - all.low.y()) +
           6.0 * kContactBlur * usual_;
  const double reach = kContactReach * usual_;
  // A quarter of it under the floor, for what sinks in.
  middle_ = Vec3(all.middle().x(), all.middle().y(), *ground_ - 0.25 * reach);
  View view;
  view.width = view.height = kSize;
  view.origin = middle_;
  view.clip = Eigen::Matrix4d::Identity();
  view.clip(0, 0) = view.clip(1, 1) = 2.0 / width_;
  view.clip(2, 2) = 1.0 / (1.25 * reach);
  view.planes = clip_planes(view.clip);
  return view;
}

void ContactShadows::take(const std::vector<float>& heights) {
  const auto count = std::size_t{kSize} * kSize;
  std::vector<float> dark(count), half_done(count);
  for (std::size_t i = 0; i < count; ++i)
    dark[i] = static_cast<float>(std::clamp(1.25 * (1.0 - heights[2 * i]), 0.0, 1.0));
  const double width = std::max(kContactBlur * usual_ / width_ * kSize, 0.3);  // [pixel]
  std::vector<float> bell;
  double sum = 0.0;
  for (int k = 0; k <= 2.5 * width; ++k) {
    const double value = std::exp(-0.5 * k * k / (width * width));
    bell.push_back(static_cast<float>(value));
    sum += k == 0 ? value : 2.0 * value;
  }
  for (float& value : bell) value = static_cast<float>(value / sum);
  for (int row = 0; row < kSize; ++row)
    blur(dark.data() + row * kSize, half_done.data() + row * kSize, kSize, 1, bell);
  for (int column = 0; column < kSize; ++column)
    blur(half_done.data() + column, dark.data() + column, kSize, kSize, bell);
  std::vector<std::uint8_t> texels(count);
  std::transform(dark.begin(), dark.end(), texels.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(value, 0.0F, 1.0F)));
  });
  gl_.ActiveTexture(GL_TEXTURE0 + kUnit);
  if (texture_ == 0) gl_.GenTextures(1, &texture_);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, kSize, kSize, 0, GL_RED, GL_UNSIGNED_BYTE, texels.data());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  gl_.ActiveTexture(GL_TEXTURE0);
}

void ContactShadows::set(Program& program, const View& view) const {
  const bool any = width_ > 0.0 && texture_ != 0;
  const Vec3 at = middle_ - view.origin;
  program.set("u_contact", static_cast<int>(kUnit));
  program.set("u_contact_area",
              Eigen::Vector4d(at.x(), at.y(), any ? 1.0 / width_ : 0.0, any ? kContact : 0.0)
                  .cast<float>()
                  .eval());
  program.set(
      "u_contact_ground",
      Vec3(ground_.value_or(0.0) - view.origin.z(), 0.02 * usual_, 0.0).cast<float>().eval());
  if (!any) return;
  gl_.ActiveTexture(GL_TEXTURE0 + kUnit);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
  gl_.ActiveTexture(GL_TEXTURE0);
}

}  // namespace cogrsim::osmesa
