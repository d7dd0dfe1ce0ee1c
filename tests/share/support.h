// Programs, servers and folders for the tests of sharing.
#pragma once

#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

#include "../support/temporary_folder.h"

/// The end of a program and its output.
struct Outcome {
  int status = -1;  ///< exit status; 128 + n: killed by signal n
  std::string out, err;
};

using Environment = std::map<std::string, std::string>;

/// Runs the program under test with nothing in its environment but PATH, HOME (a folder without
/// .netrc) and what is given.
Outcome run_program(const std::vector<std::string>& args, const Environment& environment = {});

using Folder = cogrsim::test::TemporaryFolder;

std::string content_of(const std::string& path);
void write_to(const std::string& path, const std::string& content);
/// All files below a folder, by path.
std::map<std::string, std::string> files_below(const std::string& folder);

/// A server of its own process; ended at the end of the scope.
class Server {
 public:
  ~Server();
  Server(Server&& other) noexcept;
  Server& operator=(Server&&) = delete;
  int port() const { return port_; }
  void end();

 protected:
  Server() = default;
  void start(const std::vector<std::string>& command);
  /// The first line that the server prints.
  int read_port();
  pid_t child_ = -1;
  int port_ = 0, input_ = -1, output_ = -1;
};

/// lighttpd with a folder /dav behind a password, and /open without one.
class WebdavServer : public Server {
 public:
  WebdavServer();
  std::string url(const std::string& path) const;
  /// The folder that a client sees as /dav.
  std::string folder() const { return folder_ / "root/dav"; }
  static Environment user();

 private:
  Folder folder_;
};

/// s3rver behind a judge of signatures, with the bucket "robots".
class S3Server : public Server {
 public:
  explicit S3Server(const std::vector<std::string>& arguments = {});
  std::string endpoint() const;
  static Environment keys();

 private:
  Folder folder_;
};

/// See servers/faults.mjs.
class FaultyProxy : public Server {
 public:
  FaultyProxy(const Server& target, const std::string& fault,
              const std::vector<std::string>& tls = {});
};

/// A scene with an import, a texture in a folder, a mesh, a heightmap, the file of a controller and
/// the sources of a plugin, and beside them files that do not belong to it. Returns the scene.
std::string write_scene(const std::string& folder);
