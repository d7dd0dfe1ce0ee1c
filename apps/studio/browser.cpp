#include "browser.h"

#include <cstdlib>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cogrsim::studio {

void open_browser(const std::string& address) {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value && *value;
  };
  if (!set("DISPLAY") && !set("WAYLAND_DISPLAY")) return;
  const char* text = address.c_str();
  const pid_t child = fork();
  if (child == 0) {
    // Other threads may hold any lock: only system calls from here on. A grandchild need not be
    // waited for, and in a session of its own Ctrl-C does not reach it.
    setsid();
    if (fork() == 0) {
      const int nothing = open("/dev/null", O_RDWR);
      for (int stream = 0; stream < 3; ++stream) dup2(nothing, stream);
      execlp("xdg-open", "xdg-open", text, static_cast<char*>(nullptr));
    }
    _exit(0);
  }
  if (child > 0) waitpid(child, nullptr, 0);
}

}  // namespace cogrsim::studio
