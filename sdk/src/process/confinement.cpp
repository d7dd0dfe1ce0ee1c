#include "process/confinement.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <sstream>

namespace cogrsim {

namespace {

constexpr std::uint64_t kRead =
    LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kOfVersion1 = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
// Of later versions, which a header may lack: to rename between folders, and to cut files off.
constexpr std::uint64_t kRefer = kOfVersion1 + 1, kTruncate = kRefer << 1;
/// What a rule for a file may have; the others are of folders.
constexpr std::uint64_t kOfFiles =
    LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE;

void allow(int rules, const std::string& path, std::uint64_t access) {
  landlock_path_beneath_attr rule{};
  rule.parent_fd = ::open(path.c_str(), O_PATH | O_CLOEXEC);
  if (rule.parent_fd < 0) return;
  struct stat about {};
  const bool folder = ::fstat(rule.parent_fd, &about) == 0 && S_ISDIR(about.st_mode);
  rule.allowed_access = folder ? access : access & (kOfFiles | kTruncate);
  ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
  ::close(rule.parent_fd);
}

void confine_files(const Confinement& to) {
  const long version =
      ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return;
  landlock_ruleset_attr all{};
  all.handled_access_fs =
      kOfVersion1 | (version >= 2 ? kRefer : 0) | (version >= 3 ? kTruncate : 0);
  const int rules = static_cast<int>(
      ::syscall(SYS_landlock_create_ruleset, &all, sizeof all.handled_access_fs, 0));
  if (rules < 0) return;
  for (const std::string& path : to.reads) allow(rules, path, kRead);
  for (const std::string& path : to.writes) allow(rules, path, all.handled_access_fs);
  ::syscall(SYS_landlock_restrict_self, rules, 0);
  ::close(rules);
}

/// No socket can be made: neither of the network nor of a service of this computer. io_uring, which
/// could make one past this filter, is not there either.
void confine_sockets() {
#if defined(__x86_64__)
  constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
  constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
  return;
#endif
#if defined(__x86_64__) || defined(__aarch64__)
  constexpr auto load = [](std::size_t at) {
    return sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(at));
  };
  constexpr auto answer = [](std::uint32_t error) {
    return sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | error);
  };
  sock_filter program[] = {
      load(offsetof(seccomp_data, arch)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0),
      answer(EACCES),  // calls of 32-bit programs have other numbers
      load(offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_socket, 0, 1),
      answer(EACCES),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_io_uring_setup, 0, 1),
      answer(ENOSYS),
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, 0x40000000, 0, 1),  // those of x32
      answer(ENOSYS),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(std::size(program)), program};
  ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter);
#endif
}

}  // namespace

std::string Confinement::text() const {
  std::string out;
  for (const std::string& path : reads) out += "r" + path + "\n";
  for (const std::string& path : writes) out += "w" + path + "\n";
  return out;
}

Confinement Confinement::from(const std::string& text) {
  Confinement out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.size() > 1) (line[0] == 'w' ? out.writes : out.reads).push_back(line.substr(1));
  return out;
}

void confine(const Confinement& to) {
  // Without it neither is allowed: no program that is started gets more rights than this one.
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  confine_files(to);
  confine_sockets();
}

}  // namespace cogrsim
