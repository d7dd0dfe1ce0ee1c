// Owners of what lives in the graphics library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "cogrsim/core/image.h"
#include "geometry.h"
#include "gl.h"

namespace cogrsim::osmesa {

/// Vertices and indices in buffers of their own: triangles, then lines along the edges.
class Geometry {
 public:
  Geometry(const Gl& gl, const Triangles& triangles);
  ~Geometry();
  Geometry(const Geometry&) = delete;
  Geometry& operator=(const Geometry&) = delete;

  GLuint array() const { return array_; }
  GLsizei index_count() const { return index_count_; }
  GLsizei edge_count() const { return edge_count_; }

 private:
  const Gl& gl_;
  GLuint array_ = 0, vertices_ = 0, indices_ = 0;
  GLsizei index_count_ = 0, edge_count_ = 0;
};

/// A picture with its mip-maps, sRGB to linear light when read; repeats.
class Texture {
 public:
  Texture(const Gl& gl, const Image& image);
  ~Texture();
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;
  GLuint id() const { return id_; }

 private:
  const Gl& gl_;
  GLuint id_ = 0;
};

/// Somewhere to draw to, colour (sRGB) or data (depth and body as floats).
class Target {
 public:
  enum class Kind { color, data };
  /// `samples` 1: none. Throws std::runtime_error if the library has no memory for it.
  Target(const Gl& gl, Kind kind, int width, int height, int samples);
  ~Target();
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  GLuint framebuffer() const { return framebuffer_; }
  bool is(Kind kind, int width, int height, int samples) const {
    return kind_ == kind && width_ == width && height_ == height && samples_ == samples;
  }
  std::int64_t sample_count() const { return std::int64_t{width_} * height_ * samples_; }

 private:
  const Gl& gl_;
  Kind kind_;
  int width_, height_, samples_;
  GLuint framebuffer_ = 0, color_ = 0, depth_ = 0;
};

}  // namespace cogrsim::osmesa
