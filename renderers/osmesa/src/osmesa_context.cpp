// Before Mesa's own header, which otherwise claims versions whose function types it lacks.
#include "gl_context.h"

#include <GL/osmesa.h>

#include <array>

namespace cogrsim::osmesa {

struct GlContext::Handle {
  OSMesaContext context = nullptr;
  std::array<unsigned char, 4 * 4 * 4> window{};  // OSMesa wants one; we draw elsewhere
};

std::unique_ptr<GlContext> GlContext::create(std::string* problem) {
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_DEPTH_BITS,
                            0,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            3,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            3,
                            0};
  std::unique_ptr<GlContext> made(new GlContext);
  made->handle_ = std::make_unique<Handle>();
  Handle& handle = *made->handle_;
  handle.context = OSMesaCreateContextAttribs(attributes, nullptr);
  if (handle.context == nullptr) {
    *problem = "OSMesa makes no context of OpenGL 3.3 core";
    return nullptr;
  }
  if (OSMesaMakeCurrent(handle.context, handle.window.data(), GL_UNSIGNED_BYTE, 4, 4) != GL_TRUE) {
    *problem = "OSMesa does not make its context current";
    return nullptr;
  }
  const std::string missing = load_functions(made->gl_, OSMesaGetProcAddress);
  if (!missing.empty()) {
    *problem = "OSMesa lacks " + missing;
    return nullptr;
  }
  return made;
}

GlContext::~GlContext() {
  if (handle_ == nullptr || handle_->context == nullptr) return;
  OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
  OSMesaDestroyContext(handle_->context);
}

}  // namespace cogrsim::osmesa
