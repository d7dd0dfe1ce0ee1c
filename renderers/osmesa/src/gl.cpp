#include "gl.h"

namespace cogrsim::osmesa {

std::string load_functions(Gl& gl, void (*(*get_function)(const char*))()) {
#define COGRSIM_GL_LOAD(name, type)                                        \
  gl.name = reinterpret_cast<PFNGL##type##PROC>(get_function("gl" #name)); \
  if (gl.name == nullptr) return "gl" #name;
  COGRSIM_GL_FUNCTIONS(COGRSIM_GL_LOAD)
#undef COGRSIM_GL_LOAD
  return {};
}

}  // namespace cogrsim::osmesa
