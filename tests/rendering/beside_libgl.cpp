// Draws in a program that has libGL in front of everything, as one with a window would.
#include <dlfcn.h>

#include <cmath>
#include <cstdio>

#include "support.h"

extern "C" unsigned glGetError();  // libGL's own, linked by name

int main() {
  using namespace cogrsim;
  using namespace cogrsim::test;
  // So that the library is not dropped as unused, and its names are those a search finds.
  void* const found = dlsym(RTLD_DEFAULT, "glClear");
  Dl_info library{};
  if (found == nullptr || dladdr(found, &library) == 0) {
    std::puts("libGL is not in the process");
    return 1;
  }
  std::printf("glClear is in %s; glGetError() says %u\n", library.dli_fname, glGetError());
  ModelBuilder builder;
  const int ball = builder.sphere("ball", 0.5, 1.0, at(2, 0, 0), colored(builder, 1, 1, 1));
  const Picture picture = take(builder.build(), request_of(make_camera(Pose(), 64, 64, 1.0)));
  const bool good = body_at(picture, 32, 32) == ball && body_at(picture, 0, 0) == -1 &&
                    std::abs(depth_at(picture, 32, 32) - 1.5F) < 2e-3F &&
                    pixel(picture, 32, 32).r > 60 && pixel(picture, 0, 0).r == 0;
  std::puts(good ? "the picture is right" : "the picture is wrong");
  return good ? 0 : 1;
}
