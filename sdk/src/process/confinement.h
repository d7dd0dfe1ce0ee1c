// What a program may reach of the system: some files, and no network.
#pragma once

#include <string>
#include <vector>

namespace cogrsim {

struct Confinement {
  std::vector<std::string> reads;   ///< files and folders; read, and programs started
  std::vector<std::string> writes;  ///< read and written, too

  /// As one argument of a program, and back.
  std::string text() const;
  static Confinement from(const std::string& text);
};

/// Takes all other files, and all sockets but those that are open, from this process and all that it starts:
/// for a process with one thread that becomes another program. A kernel without Landlock (before 5.13)
/// leaves files as they are; what does not exist is passed over.
void confine(const Confinement& to);

}  // namespace cogrsim
