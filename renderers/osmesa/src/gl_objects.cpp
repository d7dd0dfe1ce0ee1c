#include "gl_objects.h"

#include <fmt/format.h>

#include <cstdint>
#include <stdexcept>

#include "shaders.h"

namespace cogrsim::osmesa {

namespace {
const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }
}  // namespace

Geometry::Geometry(const Gl& gl, const Triangles& triangles)
    : gl_(gl), index_count_(static_cast<GLsizei>(triangles.indices.size())) {
  gl_.GenVertexArrays(1, &array_);
  gl_.BindVertexArray(array_);
  gl_.GenBuffers(1, &vertices_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);
  gl_.BufferData(GL_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(triangles.vertices.size() * sizeof(Vertex)),
                 triangles.vertices.data(), GL_STATIC_DRAW);
  gl_.GenBuffers(1, &indices_);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  std::vector<std::uint32_t> indices = triangles.indices;
  const std::vector<std::uint32_t> edges = edges_of(triangles);
  indices.insert(indices.end(), edges.begin(), edges.end());
  edge_count_ = static_cast<GLsizei>(edges.size());
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint32_t)), indices.data(),
                 GL_STATIC_DRAW);
  const GLsizei stride = sizeof(Vertex);
  gl_.VertexAttribPointer(kPosition, 4, GL_FLOAT, GL_FALSE, stride,
                          offset(offsetof(Vertex, position)));
  gl_.VertexAttribPointer(kNormal, 3, GL_FLOAT, GL_FALSE, stride, offset(offsetof(Vertex, normal)));
  gl_.VertexAttribPointer(kTexture, 2, GL_FLOAT, GL_FALSE, stride, offset(offsetof(Vertex, uv)));
  for (const GLuint location : {kPosition, kNormal, kTexture})
    gl_.EnableVertexAttribArray(location);
  for (GLuint location = kRows; location <= kBody; ++location) {
    gl_.EnableVertexAttribArray(location);
    gl_.VertexAttribDivisor(location, 1);
  }
}

Geometry::~Geometry() {
  gl_.DeleteVertexArrays(1, &array_);
  gl_.DeleteBuffers(1, &vertices_);
  gl_.DeleteBuffers(1, &indices_);
}

Texture::Texture(const Gl& gl, const Image& image) : gl_(gl) {
  // Always four channels: what the rasteriser reads fastest.
  std::vector<std::uint8_t> texels;
  const std::size_t count =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  texels.reserve(4 * count);
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* p = image.data.data() + i * channels;
    const bool grey = channels == 1;
    texels.insert(texels.end(), {p[0], grey ? p[0] : p[1], grey ? p[0] : p[2],
                                 channels == 4 ? p[3] : std::uint8_t{255}});
  }
  gl_.GenTextures(1, &id_);
  gl_.BindTexture(GL_TEXTURE_2D, id_);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, image.width, image.height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, texels.data());
  gl_.GenerateMipmap(GL_TEXTURE_2D);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
}

Texture::~Texture() { gl_.DeleteTextures(1, &id_); }

Target::Target(const Gl& gl, Kind kind, int width, int height, int samples)
    : gl_(gl), kind_(kind), width_(width), height_(height), samples_(samples) {
  gl_.GenFramebuffers(1, &framebuffer_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  const auto attach = [&](GLuint& id, GLenum format, GLenum point) {
    gl_.GenRenderbuffers(1, &id);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, id);
    gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width,
                                       height);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, id);
  };
  attach(color_, kind == Kind::color ? GL_SRGB8_ALPHA8 : GL_RG32F, GL_COLOR_ATTACHMENT0);
  attach(depth_, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
  const GLenum status = gl_.CheckFramebufferStatus(GL_FRAMEBUFFER);
  const GLenum error = gl_.GetError();
  if (status != GL_FRAMEBUFFER_COMPLETE || error != GL_NO_ERROR) {
    throw std::runtime_error(fmt::format(
        "the graphics library has no frame of {} x {} pixels with {} samples (status {:#x}, error "
        "{:#x})",
        width, height, samples, status, error));
  }
}

Target::~Target() {
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteRenderbuffers(1, &color_);
  gl_.DeleteRenderbuffers(1, &depth_);
}

}  // namespace cogrsim::osmesa
