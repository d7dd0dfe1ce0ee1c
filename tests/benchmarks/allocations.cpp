#include "allocations.h"

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "../support/libc_memory.h"

namespace {

constexpr int kDepth = 24;
constexpr std::size_t kCallPaths = 8192;

/// A chain of return addresses and how often it came. Fixed memory: counting must not allocate.
struct CallPath {
  std::uint64_t hash = 0;  // 0: free
  int depth = 0;
  std::array<void*, kDepth> frames{};
  std::uint64_t count = 0, bytes = 0;
};

std::array<CallPath, kCallPaths> call_paths;
std::uint64_t lost = 0;
std::atomic<bool> armed{false};
std::atomic_flag busy = ATOMIC_FLAG_INIT;
thread_local bool inside = false;  // the unwinder may allocate itself

std::uint64_t hash_of(void* const* frames, int depth) {
  std::uint64_t hash = 1469598103934665603u;
  for (int i = 0; i < depth; ++i) {
    hash = (hash ^ reinterpret_cast<std::uintptr_t>(frames[i])) * 1099511628211u;
  }
  return hash | 1u;
}

// A frame of its own, so that stop_counting_allocations() knows how many to skip.
[[gnu::noinline]] void note(std::size_t bytes) {
  if (!armed.load(std::memory_order_relaxed) || inside) return;
  inside = true;
  std::array<void*, kDepth> frames{};
  const int depth = backtrace(frames.data(), kDepth);
  const std::uint64_t hash = hash_of(frames.data(), depth);
  while (busy.test_and_set(std::memory_order_acquire)) {
  }
  bool found = false;
  for (std::size_t probe = 0; probe < 64 && !found; ++probe) {
    CallPath& path = call_paths[(hash + probe) % kCallPaths];
    if (path.hash != 0 && path.hash != hash) continue;
    if (path.hash == 0) {
      path.hash = hash;
      path.depth = depth;
      path.frames = frames;
    }
    ++path.count;
    path.bytes += bytes;
    found = true;
  }
  if (!found) ++lost;
  busy.clear(std::memory_order_release);
  inside = false;
}

std::string base_name(const char* path) {
  const char* slash = std::strrchr(path, '/');
  return slash ? slash + 1 : path;
}

bool starts_with(const std::string& text, const char* head) { return text.rfind(head, 0) == 0; }

/// Of the C and C++ runtime, or an engine's wrapper around malloc: whoever called it is meant.
bool is_allocator(const std::string& library) {
  for (const char* head :
       {"libc.so", "libstdc++", "libgcc_s", "libm.so", "ld-linux", "linux-vdso", "libLinearMath"}) {
    if (starts_with(library, head)) return true;
  }
  return false;
}

std::string text_of(const Dl_info& info, void* address) {
  char offset[32];
  std::snprintf(
      offset, sizeof offset, "+0x%zx",
      static_cast<std::size_t>(static_cast<char*>(address) - static_cast<char*>(info.dli_fbase)));
  std::string text = base_name(info.dli_fname) + offset;
  if (info.dli_sname) {
    int status = 0;
    char* plain = abi::__cxa_demangle(info.dli_sname, nullptr, nullptr, &status);
    text += std::string(" ") + (plain ? plain : info.dli_sname);
    std::free(plain);
  }
  return text;
}

}  // namespace

#define COGRSIM_REPLACES extern "C" __attribute__((visibility("default"), noinline))

COGRSIM_REPLACES void* malloc(std::size_t size) {
  note(size);
  return __libc_malloc(size);
}
COGRSIM_REPLACES void* calloc(std::size_t count, std::size_t size) {
  note(count * size);
  return __libc_calloc(count, size);
}
COGRSIM_REPLACES void* realloc(void* old, std::size_t size) {
  note(size);
  return __libc_realloc(old, size);
}
COGRSIM_REPLACES void* memalign(std::size_t alignment, std::size_t size) {
  note(size);
  return __libc_memalign(alignment, size);
}
COGRSIM_REPLACES void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note(size);
  return __libc_memalign(alignment, size);
}
COGRSIM_REPLACES int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  note(size);
  *out = __libc_memalign(alignment, size);
  return *out || size == 0 ? 0 : ENOMEM;
}

namespace cogrsim::bench {

void start_counting_allocations() {
  void* first[2];
  backtrace(first, 2);  // loads the unwinder, which allocates
  call_paths.fill(CallPath{});
  lost = 0;
  armed = true;
}

AllocationReport stop_counting_allocations() {
  armed = false;
  AllocationReport report;
  report.lost = lost;
  Dl_info self;
  dladdr(reinterpret_cast<void*>(&start_counting_allocations), &self);
  for (const CallPath& path : call_paths) {
    if (path.hash == 0) continue;
    AllocationSite site;
    site.count = path.count;
    site.bytes = path.bytes;
    bool judged = false;
    // The first two frames are note() and the function that calls it.
    for (int i = 2; i < path.depth; ++i) {
      void* const address = path.frames[i];
      Dl_info info;
      if (!dladdr(address, &info) || !info.dli_fname) continue;
      const std::string library = base_name(info.dli_fname);
      if (!judged && is_allocator(library)) continue;
      if (!judged) {
        judged = true;
        site.ours = starts_with(library, "libcogrsim") || info.dli_fbase == self.dli_fbase ||
                    std::strstr(info.dli_fname, "/cogrsim/") != nullptr;
      }
      site.frames.push_back(text_of(info, address));
    }
    (site.ours ? report.ours : report.engine) += site.count;
    (site.ours ? report.ours_bytes : report.engine_bytes) += site.bytes;
    report.sites.push_back(std::move(site));
  }
  std::sort(report.sites.begin(), report.sites.end(),
            [](const AllocationSite& a, const AllocationSite& b) { return a.count > b.count; });
  return report;
}

}  // namespace cogrsim::bench
