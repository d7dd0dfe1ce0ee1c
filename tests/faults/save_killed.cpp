// A studio that is killed while it saves: the file is the old one or the new one, never partial,
// and so is the backup beside it.
//
//     cogrsim_save_killed FOLDER [ROUNDS]
#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include "document_file.h"

using namespace cogrsim::studio;

namespace {

constexpr std::size_t kMost = 16u << 20;

/// A scene of about 1 MB, so that writing it takes a while.
std::string scene(char letter) { return "<scene>" + std::string(1u << 20, letter) + "</scene>\n"; }

/// Saves one and the other until it is killed; reports on `started` when it has begun.
[[noreturn]] void save_for_ever(const std::string& path, const std::string& a, const std::string& b,
                                int started) {
  auto file = SceneFile::open(path, kMost);
  if (!file) ::_exit(3);
  for (bool first = true;; first = !first) {
    if (!file->save(first ? a : b)) ::_exit(4);
    if (started >= 0 && ::write(started, "", 1) != 1) ::_exit(5);
    started = -1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: cogrsim_save_killed FOLDER [ROUNDS]\n");
    return 2;
  }
  namespace fs = std::filesystem;
  const fs::path folder = argv[1];
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 60;
  fs::remove_all(folder);
  fs::create_directories(folder);
  const std::string path = (folder / "t.scene.xml").string();
  const std::string a = scene('a'), b = scene('b');
  if (!write_text_file(path, a)) return 2;

  std::mt19937 random(1);
  int in_the_middle = 0;
  for (int k = 0; k < rounds; ++k) {
    int ends[2];
    if (::pipe(ends) != 0) return 2;
    const pid_t child = ::fork();
    if (child == 0) save_for_ever(path, a, b, ends[1]);
    ::close(ends[1]);
    // On any machine, however slow: the kill occurs while it saves, not while it starts.
    char ignored = 0;
    const bool saves = ::read(ends[0], &ignored, 1) == 1;
    ::close(ends[0]);
    if (saves) {
      ::usleep(static_cast<useconds_t>(random() % 20000));
      ::kill(child, SIGKILL);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (!WIFSIGNALED(status)) {
      std::fprintf(stderr, "saving failed: exit status %d\n", WEXITSTATUS(status));
      return 1;
    }
    for (const std::string& name : {path, path + "~"}) {
      if (!fs::exists(name)) continue;  // nothing was saved yet, so there is no backup
      const auto text = read_text_file(name, kMost);
      if (!text || (*text != a && *text != b)) {
        std::fprintf(stderr, "round %d: '%s' is neither the old text nor the new one\n", k,
                     name.c_str());
        return 1;
      }
    }
    // The file that was being written at the kill lies beside it, and does no harm.
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name == "t.scene.xml" || name == "t.scene.xml~") continue;
      ++in_the_middle;
      fs::remove(entry.path());
    }
  }
  std::printf("killed %d times, %d times in the middle of writing\n", rounds, in_the_middle);
  if (in_the_middle == 0) {
    std::fprintf(stderr, "no kill came while it wrote: this shows nothing\n");
    return 1;
  }
  return 0;
}
