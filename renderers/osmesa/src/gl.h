// The part of OpenGL 3.3 core that is used here, as a table of functions. Nothing is linked by
// name: libOSMesa exports the same names as libGL, and both may be in one process.
#pragma once

#include <GL/glcorearb.h>

#include <string>

namespace cogrsim::osmesa {

// Name and the word in the name of its type.
#define COGRSIM_GL_FUNCTIONS(X)                                     \
  X(ActiveTexture, ACTIVETEXTURE)                                   \
  X(AttachShader, ATTACHSHADER)                                     \
  X(BindBuffer, BINDBUFFER)                                         \
  X(BindFramebuffer, BINDFRAMEBUFFER)                               \
  X(BindRenderbuffer, BINDRENDERBUFFER)                             \
  X(BindTexture, BINDTEXTURE)                                       \
  X(BindVertexArray, BINDVERTEXARRAY)                               \
  X(BlendFunc, BLENDFUNC)                                           \
  X(BlitFramebuffer, BLITFRAMEBUFFER)                               \
  X(BufferData, BUFFERDATA)                                         \
  X(CheckFramebufferStatus, CHECKFRAMEBUFFERSTATUS)                 \
  X(ClearBufferfv, CLEARBUFFERFV)                                   \
  X(ClipControl, CLIPCONTROL)                                       \
  X(ColorMask, COLORMASK)                                           \
  X(CompileShader, COMPILESHADER)                                   \
  X(CreateProgram, CREATEPROGRAM)                                   \
  X(CreateShader, CREATESHADER)                                     \
  X(CullFace, CULLFACE)                                             \
  X(DeleteBuffers, DELETEBUFFERS)                                   \
  X(DeleteFramebuffers, DELETEFRAMEBUFFERS)                         \
  X(DeleteProgram, DELETEPROGRAM)                                   \
  X(DeleteRenderbuffers, DELETERENDERBUFFERS)                       \
  X(DeleteShader, DELETESHADER)                                     \
  X(DeleteTextures, DELETETEXTURES)                                 \
  X(DeleteVertexArrays, DELETEVERTEXARRAYS)                         \
  X(DepthFunc, DEPTHFUNC)                                           \
  X(DepthMask, DEPTHMASK)                                           \
  X(Disable, DISABLE)                                               \
  X(DrawArrays, DRAWARRAYS)                                         \
  X(DrawBuffers, DRAWBUFFERS)                                       \
  X(DrawElementsInstanced, DRAWELEMENTSINSTANCED)                   \
  X(Enable, ENABLE)                                                 \
  X(EnableVertexAttribArray, ENABLEVERTEXATTRIBARRAY)               \
  X(FramebufferRenderbuffer, FRAMEBUFFERRENDERBUFFER)               \
  X(FramebufferTexture2D, FRAMEBUFFERTEXTURE2D)                     \
  X(FramebufferTextureLayer, FRAMEBUFFERTEXTURELAYER)               \
  X(FrontFace, FRONTFACE)                                           \
  X(GenBuffers, GENBUFFERS)                                         \
  X(GenFramebuffers, GENFRAMEBUFFERS)                               \
  X(GenRenderbuffers, GENRENDERBUFFERS)                             \
  X(GenTextures, GENTEXTURES)                                       \
  X(GenVertexArrays, GENVERTEXARRAYS)                               \
  X(GenerateMipmap, GENERATEMIPMAP)                                 \
  X(GetError, GETERROR)                                             \
  X(GetIntegerv, GETINTEGERV)                                       \
  X(GetProgramInfoLog, GETPROGRAMINFOLOG)                           \
  X(GetProgramiv, GETPROGRAMIV)                                     \
  X(GetShaderInfoLog, GETSHADERINFOLOG)                             \
  X(GetShaderiv, GETSHADERIV)                                       \
  X(GetUniformLocation, GETUNIFORMLOCATION)                         \
  X(LinkProgram, LINKPROGRAM)                                       \
  X(PixelStorei, PIXELSTOREI)                                       \
  X(PolygonOffset, POLYGONOFFSET)                                   \
  X(ReadBuffer, READBUFFER)                                         \
  X(ReadPixels, READPIXELS)                                         \
  X(RenderbufferStorageMultisample, RENDERBUFFERSTORAGEMULTISAMPLE) \
  X(ShaderSource, SHADERSOURCE)                                     \
  X(TexImage2D, TEXIMAGE2D)                                         \
  X(TexImage3D, TEXIMAGE3D)                                         \
  X(TexParameterfv, TEXPARAMETERFV)                                 \
  X(TexParameteri, TEXPARAMETERI)                                   \
  X(Uniform1i, UNIFORM1I)                                           \
  X(Uniform3fv, UNIFORM3FV)                                         \
  X(Uniform4fv, UNIFORM4FV)                                         \
  X(UniformMatrix4fv, UNIFORMMATRIX4FV)                             \
  X(UseProgram, USEPROGRAM)                                         \
  X(VertexAttribDivisor, VERTEXATTRIBDIVISOR)                       \
  X(VertexAttribPointer, VERTEXATTRIBPOINTER)                       \
  X(Viewport, VIEWPORT)

/// `gl.DrawArrays(…)` is glDrawArrays.
struct Gl {
#define COGRSIM_GL_MEMBER(name, type) PFNGL##type##PROC name = nullptr;
  COGRSIM_GL_FUNCTIONS(COGRSIM_GL_MEMBER)
#undef COGRSIM_GL_MEMBER
};

/// Fills the table for the context that is current. The name of the first function that is
/// missing, or empty.
std::string load_functions(Gl& gl, void (*(*get_function)(const char*))());

}  // namespace cogrsim::osmesa
