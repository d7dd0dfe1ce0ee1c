// How far a model in MJCF or URDF and its import run apart: see scripts/measure-original.
//
//     cogrsim_original FILE [KEYFRAME] [SECONDS]
//
// Prints the largest difference, where it is, and what was compared. Exit status: 0 compared, 1
// not.
#include <cstdio>
#include <cstdlib>

#include "original_run.h"

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: cogrsim_original FILE [KEYFRAME] [SECONDS]\n");
    return 2;
  }
  const double seconds = argc > 3 ? std::atof(argv[3]) : 0.1;
  const auto run = cogrsim::test::run_beside_original(argv[1], argc > 2 ? argv[2] : "", seconds);
  if (!run) {
    std::printf("not compared: %s\n", run.error().message.c_str());
    return 1;
  }
  std::printf("%.2g (%s), base %.2g; %d joints, %d not there, %d steps, up to %d contacts\n",
              run->apart, run->furthest.empty() ? "all the same" : run->furthest.c_str(),
              run->base_apart, run->joints, run->missing, run->steps, run->touching);
  return 0;
}
