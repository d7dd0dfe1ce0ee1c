// Runs targets without libFuzzer: over stored files, and for some seconds over random changes of
// them. Needs no special compiler, so that every build can do it:
//
//     cogrsim_fuzz_replay TARGET [--seconds N] [--seed N] [--keep FOLDER] FILE|FOLDER…
//
// An input that ends the program is saved as `crash-TARGET`, in the current folder or in that of
// --keep.
#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

#include "target_table.h"
#include "targets.h"

namespace {

namespace fs = std::filesystem;
using Target = void (*)(std::string_view);

struct Named {
  const char* name;
  Target run;
};
constexpr Named kTargets[] = {
#define COGRSIM_FUZZ_NAMED(name) {#name, cogrsim::fuzz::name},
    COGRSIM_FUZZ_TARGETS(COGRSIM_FUZZ_NAMED)
#undef COGRSIM_FUZZ_NAMED
};

// State for the signal handler.
std::string current_input;
char crash_file[4096];

void keep_input(int signal) {
  const int file = ::open(crash_file, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0 && ::write(file, current_input.data(), current_input.size()) >= 0) {
    constexpr char kSaid[] = "the input is saved in ";
    static_cast<void>(!::write(2, kSaid, sizeof kSaid - 1));
    static_cast<void>(!::write(2, crash_file, std::strlen(crash_file)));
    static_cast<void>(!::write(2, "\n", 1));
  }
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

std::string read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> inputs_at(const std::vector<std::string>& paths) {
  std::vector<fs::path> files;
  for (const std::string& path : paths) {
    if (!fs::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(path)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> inputs;
  for (const fs::path& file : files) inputs.push_back(read_file(file));
  return inputs;
}

// A few random changes: bits, bytes, parts doubled, cut out, or taken from another input.
std::string changed(const std::vector<std::string>& inputs, std::mt19937_64& random) {
  const auto below = [&](std::size_t end) {
    return static_cast<std::size_t>(random() % std::max<std::size_t>(end, 1));
  };
  std::string text = inputs[below(inputs.size())];
  for (std::size_t i = 0, count = 1 + below(6); i < count; ++i) {
    const std::size_t at = below(text.size());
    const std::size_t length = std::min(text.size() - at, 1 + below(24));
    switch (below(6)) {
      case 0:
        if (!text.empty()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        break;
      case 1:
        if (!text.empty()) text[at] = static_cast<char>(below(256));
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(at, text.substr(at, length));
        break;
      case 4: {
        const std::string& other = inputs[below(inputs.size())];
        text.insert(at, other.substr(below(other.size()), 1 + below(24)));
        break;
      }
      default:
        for (std::size_t j = at; j < at + length; ++j) text[j] = static_cast<char>(below(2) * 255);
    }
  }
  return text;
}

int usage() {
  std::fputs(
      "usage: cogrsim_fuzz_replay TARGET [--seconds N] [--seed N] [--keep FOLDER] FILE|FOLDER...\n"
      "targets:",
      stderr);
  for (const Named& target : kTargets) std::fprintf(stderr, " %s", target.name);
  std::fputs("\n", stderr);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return usage();
  const Named* target = nullptr;
  for (const Named& one : kTargets) {
    if (std::strcmp(one.name, argv[1]) == 0) target = &one;
  }
  if (!target) return usage();
  double seconds = 0.0;
  unsigned long long seed = 1;
  std::string keep = ".";
  std::vector<std::string> paths;
  for (int i = 2; i < argc; ++i) {
    const bool more = i + 1 < argc;
    if (std::strcmp(argv[i], "--seconds") == 0 && more) {
      seconds = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--seed") == 0 && more) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (std::strcmp(argv[i], "--keep") == 0 && more) {
      keep = argv[++i];
    } else if (!fs::exists(argv[i])) {
      std::fprintf(stderr, "there is no '%s'\n", argv[i]);
      return 2;
    } else {
      paths.push_back(argv[i]);
    }
  }
  const std::vector<std::string> inputs = inputs_at(paths);
  if (inputs.empty()) {
    std::fputs("there is nothing to run\n", stderr);
    return 2;
  }

  std::snprintf(crash_file, sizeof crash_file, "%s/crash-%s", keep.c_str(), target->name);
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    ::signal(signal, keep_input);
  }
  for (const std::string& input : inputs) {
    current_input = input;
    target->run(current_input);
  }
  std::printf("%s: %zu inputs", target->name, inputs.size());
  if (seconds > 0.0) {
    std::mt19937_64 random(seed);
    const auto begin = std::chrono::steady_clock::now();
    std::size_t count = 0;
    while (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() <
           seconds) {
      current_input = changed(inputs, random);
      target->run(current_input);
      ++count;
    }
    std::printf(", %zu changed ones", count);
  }
  std::printf("\n");
  return 0;
}
