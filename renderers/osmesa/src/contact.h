// Contact shadows of pictures for people: a floor is darker under what stands on it or hangs low
// over it.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "gl.h"
#include "shaders.h"
#include "view.h"

namespace cogrsim::osmesa {

/// The things are drawn from below, the darker the lower, and blurred; floors look that picture up.
class ContactShadows {
 public:
  static constexpr int kSize = 256;   ///< of that picture [pixel]
  static constexpr GLuint kUnit = 2;  ///< of the texture

  explicit ContactShadows(const Gl& gl) : gl_(gl) {}
  ~ContactShadows();
  ContactShadows(const ContactShadows&) = delete;
  ContactShadows& operator=(const ContactShadows&) = delete;

  /// Of another model.
  void take_model(const SceneModelPtr& model);
  /// The view from below that spans everything at these poses; none: no floor, or nothing moves.
  std::optional<View> view_for(const std::vector<Pose>& poses);
  /// `heights`: what that view sees, as shares of its depth, 1 where nothing is; two numbers a pixel.
  void take(const std::vector<float>& heights);
  /// Sets the uniforms of lit_fragment_shader() for a floor.
  void set(Program& program, const View& view) const;

 private:
  const Gl& gl_;
  GLuint texture_ = 0;
  SceneModelPtr model_;
  std::optional<double> ground_;  ///< height of the floor [m]
  double usual_ = 0.0;            ///< size of a thing that moves [m]
  Vec3 middle_ = Vec3::Zero();
  double width_ = 0.0;  ///< of the picture [m]; 0: there is none
};

}  // namespace cogrsim::osmesa
