#include "support.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

namespace fs = std::filesystem;

namespace {

bool is_there(const std::string& program) { return !program.empty() && fs::exists(program); }

// A test without its server has tested nothing, and must say so loudly.
void require_program(const std::string& program, const std::string& what) {
  if (!is_there(program)) {
    throw std::runtime_error(what + " is not installed, and the test needs it: run scripts/test, " +
                             "which installs it, or install it and configure again");
  }
}

std::vector<char*> pointers(const std::vector<std::string>& arguments) {
  std::vector<char*> out;
  for (const std::string& argument : arguments) out.push_back(const_cast<char*>(argument.c_str()));
  out.push_back(nullptr);
  return out;
}

bool answers(int port) {
  const int s = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool good = connect(s, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0;
  close(s);
  return good;
}

int free_port() {
  const int s = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  if (bind(s, reinterpret_cast<sockaddr*>(&at), size) != 0 ||
      getsockname(s, reinterpret_cast<sockaddr*>(&at), &size) != 0) {
    throw std::runtime_error("no free port");
  }
  close(s);
  return ntohs(at.sin_port);
}

}  // namespace

Outcome run_program(const std::vector<std::string>& args, const Environment& environment) {
  static const Folder home;
  std::vector<std::string> arguments = {COGRSIM_PROGRAM}, variables;
  arguments.insert(arguments.end(), args.begin(), args.end());
  Environment all = {{"PATH", "/usr/bin:/bin"}, {"HOME", home.path}, {"TMPDIR", home.path}};
  for (const char* name : {"LD_LIBRARY_PATH", "ASAN_OPTIONS", "UBSAN_OPTIONS"}) {
    if (const char* value = std::getenv(name)) all[name] = value;
  }
  for (const auto& [name, value] : environment) all[name] = value;
  for (const auto& [name, value] : all) variables.push_back(name + "=" + value);
  int out[2], err[2];
  if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const auto argv = pointers(arguments), envp = pointers(variables);
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    execve(COGRSIM_PROGRAM, argv.data(), envp.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  Outcome outcome;
  pollfd ends[2] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  std::string* texts[2] = {&outcome.out, &outcome.err};
  for (int open_ends = 2; open_ends > 0;) {
    poll(ends, 2, -1);
    for (int i = 0; i < 2; ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t count = read(ends[i].fd, buffer, sizeof buffer);
      if (count > 0) {
        texts[i]->append(buffer, static_cast<std::size_t>(count));
        continue;
      }
      close(ends[i].fd);
      ends[i].fd = -1;
      --open_ends;
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_to(const std::string& path, const std::string& content) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << content;
}

std::map<std::string, std::string> files_below(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& item : fs::recursive_directory_iterator(folder)) {
    if (item.is_directory()) continue;
    files[item.path().lexically_relative(folder).generic_string()] =
        content_of(item.path().string());
  }
  return files;
}

Server::Server(Server&& other) noexcept
    : child_(std::exchange(other.child_, -1)),
      port_(other.port_),
      input_(std::exchange(other.input_, -1)),
      output_(std::exchange(other.output_, -1)) {}

Server::~Server() { end(); }

void Server::end() {
  if (child_ > 0) {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
    child_ = -1;
  }
  for (int* end : {&input_, &output_}) {
    if (*end >= 0) close(*end);
    *end = -1;
  }
}

void Server::start(const std::vector<std::string>& command) {
  int in[2], out[2];
  if (pipe2(in, O_CLOEXEC) != 0 || pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const auto argv = pointers(command);
  child_ = fork();
  if (child_ == 0) {
    dup2(in[0], STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(in[0]);
  close(out[1]);
  input_ = in[1];
  output_ = out[0];
}

int Server::read_port() {
  std::string line;
  pollfd end = {output_, POLLIN, 0};
  for (char c = 0; c != '\n';) {
    if (poll(&end, 1, 60'000) <= 0 || read(output_, &c, 1) != 1) {
      throw std::runtime_error("a server of the tests did not start");
    }
    line += c;
  }
  if (line.compare(0, 5, "port ") != 0) throw std::runtime_error("a server said: " + line);
  return std::stoi(line.substr(5));
}

WebdavServer::WebdavServer() {
  require_program(COGRSIM_LIGHTTPD, "lighttpd (with lighttpd-mod-webdav)");
  fs::create_directories(folder_ / "root/dav");
  fs::create_directories(folder_ / "root/open");
  fs::create_directories(folder_ / "uploads");
  write_to(folder_ / "users", "ada:engine number 1\n");
  // The port is free now, and most probably still is when the server starts.
  for (int attempt = 0; attempt < 5; ++attempt) {
    port_ = free_port();
    write_to(folder_ / "lighttpd.conf",
             "server.modules = (\"mod_auth\", \"mod_authn_file\", \"mod_webdav\")\n"
             "server.document-root = \"" +
                 (folder_ / "root") +
                 "\"\n"
                 "server.bind = \"127.0.0.1\"\nserver.port = " +
                 std::to_string(port_) +
                 "\n"
                 "server.upload-dirs = (\"" +
                 (folder_ / "uploads") +
                 "\")\n"
                 "server.stat-cache-engine = \"disable\"\nwebdav.activate = "
                 "\"enable\"\nwebdav.is-readonly = \"disable\"\n"
                 "auth.backend = \"plain\"\nauth.backend.plain.userfile = \"" +
                 (folder_ / "users") +
                 "\"\n"
                 "auth.require = (\"/dav\" => (\"method\" => \"basic\", \"realm\" => \"scenes\",\n"
                 "                            \"require\" => \"valid-user\"))\n");
    start({COGRSIM_LIGHTTPD, "-D", "-f", folder_ / "lighttpd.conf"});
    for (int wait = 0; wait < 200; ++wait) {
      if (answers(port_)) return;
      if (waitpid(child_, nullptr, WNOHANG) == child_) {
        child_ = -1;
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    end();
  }
  throw std::runtime_error("lighttpd did not start: is lighttpd-mod-webdav installed?");
}

std::string WebdavServer::url(const std::string& path) const {
  return "http://127.0.0.1:" + std::to_string(port_) + path;
}

Environment WebdavServer::user() {
  return {{"COGRSIM_STORE_USER", "ada"}, {"COGRSIM_STORE_PASSWORD", "engine number 1"}};
}

S3Server::S3Server(const std::vector<std::string>& arguments) {
  require_program(COGRSIM_NODE, "node");
  std::vector<std::string> command = {COGRSIM_NODE,
                                      std::string(COGRSIM_SERVERS) + "/s3.mjs",
                                      folder_ / "objects",
                                      "robots",
                                      "a secret of the tests/+",
                                      "eu-test-1"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  start(command);
  port_ = read_port();
}

std::string S3Server::endpoint() const { return "http://127.0.0.1:" + std::to_string(port_); }

Environment S3Server::keys() {
  return {{"AWS_ACCESS_KEY_ID", "S3RVER"},
          {"AWS_SECRET_ACCESS_KEY", "a secret of the tests/+"},
          {"AWS_REGION", "eu-test-1"}};
}

FaultyProxy::FaultyProxy(const Server& target, const std::string& fault,
                         const std::vector<std::string>& tls) {
  require_program(COGRSIM_NODE, "node");
  std::vector<std::string> command = {COGRSIM_NODE, COGRSIM_SERVERS "/faults.mjs",
                                      std::to_string(target.port()), fault};
  command.insert(command.end(), tls.begin(), tls.end());
  start(command);
  port_ = read_port();
}

std::string write_scene(const std::string& folder) {
  write_to(folder + "/arm.scene.xml", R"(<scene name="arm" version="1">
  <import href="parts/tower.scene.xml"/>
  <material name="tiles" texture="textures/tiles.png" texture-size="1 m"/>
  <plane name="floor" material="tiles"/>
  <heightmap name="hill" size="2 2" file="ground/hill.pgm" height="10 cm" xyz="5 0 0"/>
  <mesh name="rock" file="meshes/rock.obj" xyz="-5 0 1" static="true"/>
  <assembly name="arm">
    <box name="base" size="6 6 4 cm" xyz="0 0 2 cm" static="true"/>
    <box name="fore" size="2 2 20 cm" xyz="0 0 15 cm" material="wood"/>
    <hinge name="yaw" parent="base" child="fore" axis="0 0 1"/>
    <servo name="waist" joint="yaw" kp="20 N*m/rad" kd="0.6 N*m*s/rad" max-torque="4 N*m"/>
    <controller plugin="trajectory_player" rate="100 Hz"><set file="data/wave.csv"/></controller>
  </assembly>
</scene>
)");
  write_to(folder + "/parts/tower.scene.xml",
           "<scene name=\"parts\" version=\"1\"><material name=\"wood\" "
           "density=\"600 kg/m^3\"/></scene>\n");
  write_to(folder + "/textures/tiles.png",
           content_of(COGRSIM_SOURCE_DIR "/examples/045_eyes/textures/tiles.png"));
  write_to(folder + "/ground/hill.pgm", "P2\n3 3\n255\n0 0 0\n0 255 0\n0 0 0\n");
  write_to(folder + "/meshes/rock.obj",
           "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  write_to(folder + "/data/wave.csv", "time,waist\n0,0\n1,0.5\n2,0\n");
  write_to(folder + "/CMakeLists.txt", "cmake_minimum_required(VERSION 3.23)\nproject(nothing)\n");
  write_to(folder + "/driver.cpp", "// the source of a controller\n");
  write_to(folder + "/driver.h", "#pragma once\n");
  // Files that do not belong to it, and must not be packed.
  write_to(folder + "/controller.so",
           "\x7f"
           "ELF");
  write_to(folder + "/other.scene.xml", "<scene name=\"other\" version=\"1\"/>\n");
  write_to(folder + "/notes.txt", "private notes\n");
  write_to(folder + "/data/unused.csv", "1,2\n");
  return folder + "/arm.scene.xml";
}
