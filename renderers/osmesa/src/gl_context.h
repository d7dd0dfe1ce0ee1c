// An OpenGL context without a window. The one thing in this folder that knows where contexts come
// from: a twin on EGL replaces osmesa_context.cpp.
#pragma once

#include <memory>
#include <string>

#include "gl.h"

namespace cogrsim::osmesa {

class GlContext {
 public:
  /// Makes a context, current to the calling thread, which alone may use it and must destroy it.
  /// nullptr: `problem` says why.
  static std::unique_ptr<GlContext> create(std::string* problem);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  const Gl& gl() const { return gl_; }

 private:
  GlContext() = default;
  struct Handle;
  std::unique_ptr<Handle> handle_;
  Gl gl_;
};

}  // namespace cogrsim::osmesa
