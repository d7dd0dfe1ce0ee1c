// The programs, made for the lights a scene has.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>

#include "gl.h"

namespace cogrsim::osmesa {

// Places of vertex attributes; those from kRows on belong to the instance.
inline constexpr GLuint kPosition = 0, kNormal = 1, kTexture = 2, kRows = 3, kScale = 6, kColor = 7,
                        kBody = 8;

class Program {
 public:
  /// Throws std::runtime_error with the compiler's text: the sources are ours.
  Program(const Gl& gl, const std::string& vertex, const std::string& fragment);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void use() const { gl_.UseProgram(id_); }
  // A uniform that the compiler found no use for is passed over, as in GL.
  void set(const char* name, int value);
  void set(const char* name, const Eigen::Vector3f& value);
  void set(const char* name, const Eigen::Vector4f& value);
  void set(const char* name, const Eigen::Matrix4f& value);

 private:
  GLint location(const char* name);
  const Gl& gl_;
  GLuint id_ = 0;
  std::map<std::string, GLint> locations_;
};

std::string instanced_vertex_shader(bool shading, bool textured);
std::string data_fragment_shader();
std::string shadow_fragment_shader();
/// Depth, 0 to 1, as data.
std::string height_fragment_shader();
/// How a surface is drawn beside its light: as a camera sees it, with a dark outline, or as a floor
/// that fades into the sky.
enum class Look { plain, outlined, floor };
/// `lights`: a letter for each, d (directional), p (point), s (spot), capital if it casts shadows.
std::string lit_fragment_shader(const std::string& lights, bool textured, Look look);
/// Dark lines along edges, in a shade of the body's colour.
std::string edge_vertex_shader();
std::string edge_fragment_shader();
std::string full_screen_vertex_shader();
std::string sky_fragment_shader();
std::string overlay_vertex_shader();
std::string overlay_fragment_shader();

}  // namespace cogrsim::osmesa
