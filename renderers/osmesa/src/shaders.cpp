#include "shaders.h"

#include <fmt/format.h>

#include <stdexcept>

#include "look.h"

namespace cogrsim::osmesa {

namespace {

constexpr const char* kVersion = "#version 330 core\n";

GLuint compile(const Gl& gl, GLenum kind, const std::string& source) {
  const GLuint id = gl.CreateShader(kind);
  const char* text = source.c_str();
  gl.ShaderSource(id, 1, &text, nullptr);
  gl.CompileShader(id);
  GLint ok = 0;
  gl.GetShaderiv(id, GL_COMPILE_STATUS, &ok);
  if (ok == 0) {
    char log[2000] = "";
    gl.GetShaderInfoLog(id, sizeof log, nullptr, log);
    throw std::runtime_error(fmt::format("a shader does not compile: {}\n{}", log, source));
  }
  return id;
}

// Shadow maps are layers of one array. A lit point is moved off its surface by about a texel before
// it is compared, which keeps surfaces from shading themselves; each look-up is the mean of 2 x 2
// comparisons weighted by position, four of them make a soft edge two texels wide.
constexpr const char* kShadowFunctions = R"(
uniform sampler2DArrayShadow u_shadows;
float shadow_at(vec3 position, float layer) {
  vec4 where = vec4(position.xy, layer, min(position.z, 1.0));  // behind all that casts: lit
  vec2 step = 0.5 / vec2(textureSize(u_shadows, 0).xy);
  float sum = texture(u_shadows, where + vec4(step.x, step.y, 0.0, 0.0));
  sum += texture(u_shadows, where + vec4(-step.x, step.y, 0.0, 0.0));
  sum += texture(u_shadows, where + vec4(step.x, -step.y, 0.0, 0.0));
  sum += texture(u_shadows, where + vec4(-step.x, -step.y, 0.0, 0.0));
  return 0.25 * sum;
}
// One of six layers around a point light: those of +x, -x, +y, -y, +z, -z.
float shadow_around(vec3 d, float layer, vec2 depth) {
  vec3 a = abs(d);
  bool x = a.x >= a.y && a.x >= a.z;
  bool y = !x && a.y >= a.z;
  float along = x ? d.x : (y ? d.y : d.z);
  vec2 across = x ? d.yz : (y ? d.xz : d.xy);
  float w = abs(along);
  layer += (x ? 0.0 : (y ? 2.0 : 4.0)) + (along > 0.0 ? 0.0 : 1.0);
  return shadow_at(vec3(0.5 + 0.5 * across / w, depth.x - depth.y / w), layer);
}
)";

/// Light from a direction where nothing is.
constexpr const char* kSkyFunction = R"(
uniform vec3 u_zenith;
uniform vec3 u_horizon;
uniform vec3 u_nadir;
vec3 sky(vec3 ray) {
  float up = ray.z * inversesqrt(dot(ray, ray));
  // Fast near the horizon, slow above: 1 - (1 - up)^3; below, the haze ends within a few degrees.
  float a = 1.0 - clamp(up, 0.0, 1.0);
  vec3 above = mix(u_horizon, u_zenith, 1.0 - a * a * a);
  return mix(above, u_nadir, clamp(-8.0 * up, 0.0, 1.0));
}
)";

constexpr const char* kFloorUniforms = R"(
uniform vec3 u_fade;
uniform sampler2D u_contact;
uniform vec4 u_contact_area;    // its middle, 1 / its width, how much light is lost
uniform vec3 u_contact_ground;  // height, how far from it a plane is still the floor
)";
constexpr const char* kContactLoss = R"(
  vec2 at = 0.5 + (v_position.xy - u_contact_area.xy) * u_contact_area.z;
  float lost = u_contact_area.w * texture(u_contact, at).r;
  o_color.rgb *= 1.0 - lost * step(abs(v_position.z - u_contact_ground.x), u_contact_ground.y);
)";

/// What is brighter than the knee approaches white ever more slowly, and keeps its hue.
std::string tone_mapping() {
  return fmt::format(R"(
  float most = max(o_color.r, max(o_color.g, o_color.b));
  if (most > {0:.3f})
    o_color.rgb *= ({0:.3f} + {1:.3f} * (1.0 - exp(({0:.3f} - most) / {1:.3f}))) / most;
)",
                     kKnee, 1.0 - kKnee);
}

}  // namespace

Program::Program(const Gl& gl, const std::string& vertex, const std::string& fragment) : gl_(gl) {
  const GLuint v = compile(gl, GL_VERTEX_SHADER, vertex);
  const GLuint f = compile(gl, GL_FRAGMENT_SHADER, fragment);
  id_ = gl.CreateProgram();
  gl.AttachShader(id_, v);
  gl.AttachShader(id_, f);
  gl.LinkProgram(id_);
  gl.DeleteShader(v);
  gl.DeleteShader(f);
  GLint ok = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &ok);
  if (ok == 0) {
    char log[2000] = "";
    gl.GetProgramInfoLog(id_, sizeof log, nullptr, log);
    throw std::runtime_error(fmt::format("shaders do not link: {}", log));
  }
}

Program::~Program() { gl_.DeleteProgram(id_); }

GLint Program::location(const char* name) {
  const auto [it, is_new] = locations_.try_emplace(name, -1);
  if (is_new) it->second = gl_.GetUniformLocation(id_, name);
  return it->second;
}

void Program::set(const char* name, int value) { gl_.Uniform1i(location(name), value); }
void Program::set(const char* name, const Eigen::Vector3f& value) {
  gl_.Uniform3fv(location(name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Vector4f& value) {
  gl_.Uniform4fv(location(name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Matrix4f& value) {
  gl_.UniformMatrix4fv(location(name), 1, GL_FALSE, value.data());
}

std::string instanced_vertex_shader(bool shading, bool textured) {
  std::string out = kVersion;
  out += R"(
layout(location = 0) in vec4 a_position;
layout(location = 3) in vec4 i_row_x;
layout(location = 4) in vec4 i_row_y;
layout(location = 5) in vec4 i_row_z;
layout(location = 6) in vec4 i_scale;
layout(location = 8) in float i_body;
uniform mat4 u_clip;
)";
  if (shading) {
    out += R"(
layout(location = 1) in vec3 a_normal;
layout(location = 7) in vec4 i_color;
out vec3 v_position;
out vec3 v_normal;
flat out vec4 v_color;
)";
  } else {
    out += "flat out float v_body;\n";
  }
  if (textured) out += "layout(location = 2) in vec2 a_uv;\nout vec2 v_uv;\n";
  out += R"(
void main() {
  vec4 p = vec4(a_position.xyz * i_scale.xyz, 1.0);
  p.z += a_position.w * i_scale.w;
  vec4 w = vec4(dot(i_row_x, p), dot(i_row_y, p), dot(i_row_z, p), 1.0);
  gl_Position = u_clip * w;
)";
  if (shading) {
    out += R"(
  vec3 n = a_normal / i_scale.xyz;
  v_position = w.xyz;
  v_normal = vec3(dot(i_row_x.xyz, n), dot(i_row_y.xyz, n), dot(i_row_z.xyz, n));
  v_color = i_color;
)";
  } else {
    out += "  v_body = i_body;\n";
  }
  if (textured) out += "  v_uv = a_uv;\n";
  return out + "}\n";
}

std::string data_fragment_shader() {
  // 1 / w as it was interpolated: w is the distance along the camera's x.
  return std::string(kVersion) + R"(
flat in float v_body;
out vec2 o_data;
void main() { o_data = vec2(1.0 / gl_FragCoord.w, v_body); }
)";
}

std::string height_fragment_shader() {
  return std::string(kVersion) + R"(
out vec2 o_data;
void main() { o_data = vec2(gl_FragCoord.z, 0.0); }
)";
}

std::string shadow_fragment_shader() { return std::string(kVersion) + "void main() {}\n"; }

std::string lit_fragment_shader(const std::string& lights, bool textured, Look look) {
  std::string out = kVersion;
  out += R"(
in vec3 v_position;
in vec3 v_normal;
flat in vec4 v_color;
out vec4 o_color;
uniform vec3 u_ambient_middle;
uniform vec3 u_ambient_toward;
)";
  if (textured) out += "in vec2 v_uv;\nuniform sampler2D u_texture;\n";
  bool shadows = false;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    out += fmt::format("uniform vec3 u_light{0}_color;\nuniform vec3 u_light{0}_position;\n", i);
    if (lights[i] != 'd' && lights[i] != 'D')
      out += fmt::format("uniform vec4 u_light{}_range;\n", i);
    if (lights[i] == 's' || lights[i] == 'S')
      out += fmt::format("uniform vec3 u_light{}_axis;\n", i);
    if (lights[i] < 'a') {
      shadows = true;
      out += fmt::format("uniform vec4 u_light{}_shadow;\n", i);
      if (lights[i] != 'P') out += fmt::format("uniform mat4 u_light{}_map;\n", i);
    }
  }
  if (shadows) out += kShadowFunctions;
  if (look == Look::floor) out += std::string(kSkyFunction) + kFloorUniforms;
  if (look != Look::plain) out += "uniform vec3 u_ambient_half;\n";
  out += "void main() {\n  vec3 n = normalize(gl_FrontFacing ? v_normal : -v_normal);\n";
  out += look == Look::plain
             ? "  vec3 light = u_ambient_middle + vec3(dot(n, u_ambient_toward));\n"
             : "  vec3 light = u_ambient_middle + dot(n, u_ambient_toward) * u_ambient_half;\n";
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const char kind = static_cast<char>(lights[i] | 0x20);
    const bool casts = lights[i] < 'a';
    out += "  {\n";
    if (kind == 'd') {
      out += fmt::format("    float s = max(dot(n, u_light{}_position), 0.0);\n", i);
      if (casts) {
        // u_light_shadow: layer, offset along the normal [m]
        out += fmt::format(
            "    vec4 m = u_light{0}_map * vec4(v_position + u_light{0}_shadow.y * n, 1.0);\n"
            "    s *= shadow_at(m.xyz, u_light{0}_shadow.x);\n",
            i);
      }
    } else {
      // u_light_range: 1 / range^2, cosines at which a spot ends and is full
      out += fmt::format(
          "    vec3 d = v_position - u_light{0}_position;\n"
          "    float r2 = dot(d, d);\n"
          "    float r = sqrt(r2);\n"
          "    float s = max(-dot(n, d), 0.0) / (r * (1.0 + r2 * u_light{0}_range.x));\n",
          i);
      if (kind == 's') {
        out += fmt::format(
            "    s *= smoothstep(u_light{0}_range.y, u_light{0}_range.z, "
            "dot(d, u_light{0}_axis) / r);\n",
            i);
      }
      // u_light_shadow: layer, offset along the normal per distance, depth = z - w / distance
      if (casts && kind == 's') {
        out += fmt::format(
            "    vec4 m = u_light{0}_map * vec4(v_position + r * u_light{0}_shadow.y * n, 1.0);\n"
            "    s *= m.w > 0.0 ? shadow_at(m.xyz / m.w, u_light{0}_shadow.x) : 0.0;\n",
            i);
      } else if (casts) {
        out += fmt::format(
            "    s *= shadow_around(d + r * u_light{0}_shadow.y * n, u_light{0}_shadow.x, "
            "u_light{0}_shadow.zw);\n",
            i);
      }
    }
    out += fmt::format("    light += s * u_light{}_color;\n  }}\n", i);
  }
  out += textured ? "  vec4 color = v_color * texture(u_texture, v_uv);\n"
                  : "  vec4 color = v_color;\n";
  out += "  o_color = vec4(color.rgb * light, color.a);\n";
  if (look == Look::floor) out += kContactLoss;
  if (look != Look::plain) out += tone_mapping();
  if (look == Look::outlined) {
    // On a round surface the cosine of the view angle falls with the root of the distance to the
    // outline; divided by twice its change from pixel to pixel it is that distance [pixel].
    out +=
        "  float facing = abs(dot(n, normalize(v_position)));\n"
        "  float inside = facing / max(2.0 * fwidth(facing), 1e-6);\n"
        "  o_color.rgb *= mix(0.3, 1.0, smoothstep(0.3, 1.3, inside));\n";
  } else if (look == Look::floor) {
    // u_fade: distances at which it begins and ends [m]
    out +=
        "  float far = smoothstep(u_fade.x, u_fade.y, length(v_position));\n"
        "  o_color.rgb = mix(o_color.rgb, sky(v_position), far);\n";
  }
  return out + "}\n";
}

std::string edge_vertex_shader() {
  // Lines lie a little nearer than they are, so that they are seen on their own surface.
  return std::string(kVersion) + R"(
layout(location = 0) in vec4 a_position;
layout(location = 3) in vec4 i_row_x;
layout(location = 4) in vec4 i_row_y;
layout(location = 5) in vec4 i_row_z;
layout(location = 6) in vec4 i_scale;
layout(location = 7) in vec4 i_color;
uniform mat4 u_clip;
flat out vec4 v_color;
void main() {
  vec4 p = vec4(a_position.xyz * i_scale.xyz, 1.0);
  p.z += a_position.w * i_scale.w;
  gl_Position = u_clip * vec4(dot(i_row_x, p), dot(i_row_y, p), dot(i_row_z, p), 1.0);
  gl_Position.z = min(1.001 * gl_Position.z, gl_Position.w);
  v_color = i_color;
}
)";
}

std::string edge_fragment_shader() {
  return std::string(kVersion) + R"(
flat in vec4 v_color;
out vec4 o_color;
void main() {
  // The edges of what is nearly black are lighter than it.
  float bright = dot(v_color.rgb, vec3(0.2126, 0.7152, 0.0722));
  vec3 shade = bright > 0.03 ? 0.2 * v_color.rgb : v_color.rgb + vec3(0.1);
  o_color = vec4(shade, 0.85 * v_color.a);
}
)";
}

std::string full_screen_vertex_shader() {
  // One triangle over the whole screen, at the far end of a reversed depth buffer.
  return std::string(kVersion) + R"(
uniform vec3 u_corner;
uniform vec3 u_right;
uniform vec3 u_down;
out vec3 v_ray;
void main() {
  vec2 p = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
  v_ray = u_corner + p.x * u_right + p.y * u_down;
  gl_Position = vec4(2.0 * p - 1.0, 0.0, 1.0);
}
)";
}

std::string sky_fragment_shader() {
  return std::string(kVersion) + kSkyFunction + R"(
in vec3 v_ray;
out vec4 o_color;
void main() { o_color = vec4(sky(v_ray), 1.0); }
)";
}

std::string overlay_vertex_shader() {
  return std::string(kVersion) + R"(
layout(location = 0) in vec4 a_clip;
layout(location = 1) in vec4 a_color;
flat out vec4 v_color;
void main() {
  v_color = a_color;
  gl_Position = a_clip;
}
)";
}

std::string overlay_fragment_shader() {
  return std::string(kVersion) + R"(
flat in vec4 v_color;
out vec4 o_color;
void main() { o_color = v_color; }
)";
}

}  // namespace cogrsim::osmesa
