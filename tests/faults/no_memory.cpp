// Every single allocation of making a world and stepping it fails, one after the other: the result
// is an error about memory or std::bad_alloc, and never the end of the process.
//
//     cogrsim_no_memory BACKEND [--only-steps]
//
// --only-steps: not while the world is made. Each failure is tested in a separate process. Exit
// status 1: some ended otherwise.
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "../support/libc_memory.h"
#include "cogrsim/dsl/compiler.h"
#include "cogrsim/simulation/simulation.h"

namespace {

long seen = 0;      // allocations since the count began
long refused = -1;  // the number of the one that fails; -1: none
bool counts = false;

bool fails() {
  if (!counts || seen++ != refused) return false;
  errno = ENOMEM;
  return true;
}

}  // namespace

extern "C" void* malloc(std::size_t size) { return fails() ? nullptr : __libc_malloc(size); }
extern "C" void* calloc(std::size_t count, std::size_t size) {
  return fails() ? nullptr : __libc_calloc(count, size);
}
extern "C" void* realloc(void* old, std::size_t size) {
  return fails() ? nullptr : __libc_realloc(old, size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return fails() ? nullptr : __libc_memalign(alignment, size);
}
extern "C" int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  if (fails()) return ENOMEM;
  *out = __libc_memalign(alignment, size);
  return *out == nullptr ? ENOMEM : 0;
}

namespace {

using namespace cogrsim;

constexpr const char* kScene = R"(
<scene name="much in little" version="1">
  <physics step="2 ms"/>
  <plane name="floor"/>
  <repeat count="6" var="i">
    <box name="b${i}" size="10 10 10 cm" xyz="${0.09 * i} 0 0.05"/>
  </repeat>
  <sphere name="ball" radius="5 cm" xyz="0 0.5 0.05"/>
  <cylinder name="can" radius="5 cm" length="10 cm" xyz="0.3 0.5 0.05"/>
  <repeat count="3" var="i">
    <box name="link${i}" size="20 2 2 cm" xyz="${0.2 * i} 1 1" mass="100 g"/>
  </repeat>
  <hinge name="h0" child="link0" xyz="-10 cm 0 0" axis="0 1 0"/>
  <hinge name="h1" parent="link0" child="link1" xyz="-10 cm 0 0" axis="0 1 0"/>
  <ball name="h2" parent="link1" child="link2" xyz="-10 cm 0 0"/>
  <motor name="m" joint="h1" mode="velocity" max-torque="1 N*m"/>
</scene>
)";

/// Whether the message is about memory.
bool of_memory(const std::string& text) { return text.find("memory") != std::string::npos; }

/// A world, ten steps of it, a snapshot and its return. 0: nothing failed, 1: it reports that the
/// memory ran out, 2: it reports something else, which is printed.
int live(const SceneModelPtr& model, const std::string& backend,
         const std::shared_ptr<PluginLoader>& loader, bool only_steps) {
  const auto odd = [](const std::string& what) {
    std::printf("  says: %s\n", what.c_str());
    return 2;
  };
  try {
    SimulationOptions options;
    options.backend = backend;
    counts = !only_steps;
    auto run = Simulation::create(model, options, loader);
    if (!run) {
      counts = false;
      const std::string& why = run.error().front().message;
      return of_memory(why) ? 1 : odd(why);
    }
    counts = true;
    for (int k = 0; k < 10; ++k) (*run)->step();
    const SimulationSnapshotPtr snapshot = (*run)->save();
    (*run)->step();
    const auto restored = (*run)->restore(snapshot);
    counts = false;
    if (!restored && !of_memory(restored.error().message)) return odd(restored.error().message);
    if ((*run)->status() != RunStatus::running) return odd((*run)->messages().back().message);
    return restored ? 0 : 1;
  } catch (const std::bad_alloc&) {
    counts = false;
    return 1;
  } catch (const std::exception& e) {
    counts = false;
    return odd(e.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool only_steps = argc == 3 && std::strcmp(argv[2], "--only-steps") == 0;
  if (argc != 2 && !only_steps) {
    std::fprintf(stderr, "usage: cogrsim_no_memory BACKEND [--only-steps]\n");
    return 2;
  }
  const std::string backend = argv[1];
  const auto scene = dsl::compile_text(kScene, "much.scene.xml");
  if (!scene.ok()) {
    std::fprintf(stderr, "the scene does not compile: %s\n",
                 scene.diagnostics.front().message.c_str());
    return 2;
  }
  const auto loader = std::make_shared<PluginLoader>();
  // Once with all memory: it loads the engine, which keeps the data it shares between worlds.
  for (int k = 0; k < 2; ++k) {
    seen = 0;
    if (live(scene.model, backend, loader, only_steps) != 0) return 2;
  }
  const long all = seen;
  long reported = 0, wrong = 0;
  std::fflush(stdout);
  for (long k = 0; k < all; ++k) {
    const pid_t child = ::fork();
    if (child == 0) {
      // Messages of libraries at an abort; the signal is enough.
      if (std::freopen("/dev/null", "w", stderr) == nullptr) ::_exit(3);
      seen = 0;
      refused = k;
      const int how = live(scene.model, backend, loader, only_steps);
      std::fflush(stdout);
      ::_exit(how);
    }
    int status = 0;
    if (child < 0 || ::waitpid(child, &status, 0) != child) return 2;
    const bool ended = WIFEXITED(status);
    if (ended && WEXITSTATUS(status) == 1) ++reported;
    if (ended && WEXITSTATUS(status) <= 1) continue;
    ++wrong;
    std::printf("WRONG: allocation %ld of %ld: %s %d\n", k, all, ended ? "exit status" : "signal",
                ended ? WEXITSTATUS(status) : WTERMSIG(status));
    std::fflush(stdout);
  }
  std::printf("%s: %ld allocations failed, %ld were reported, %ld went wrong\n", backend.c_str(), all,
              reported, wrong);
  // Hardly any allocation is unneeded: if no failure is noticed, this test tests nothing.
  if (reported == 0) std::printf("WRONG: nothing was noticed\n");
  return wrong > 0 || reported == 0 ? 1 : 0;
}
