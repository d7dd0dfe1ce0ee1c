// Addresses that stay the same over a restart, and the files of tokens that are trusted.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <sys/stat.h>

#include "../support/environment.h"
#include "document_support.h"
#include "server/kept_tokens.h"
#include "server_client.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using Catch::Matchers::Contains;
using cogrsim::studio::testing::Folder;
using cogrsim::test::EnvironmentVariable;
namespace fs = std::filesystem;

namespace {

const std::string kName = "127.0.0.1_8642";

mode_t mode_of(const std::string& path) {
  struct stat about {};
  REQUIRE(::lstat(path.c_str(), &about) == 0);
  return about.st_mode & 07777;
}

void set_age(const std::string& path, std::time_t seconds) {
  const timespec then{std::time(nullptr) - seconds, 0};
  const timespec both[2] = {then, then};
  REQUIRE(::utimensat(AT_FDCWD, path.c_str(), both, 0) == 0);
}

KeptTokens tokens(const Folder& folder, const std::string& name = kName) {
  auto found = kept_tokens(folder.folder().string(), name);
  INFO((found ? std::string() : found.error().text()));
  REQUIRE(found);
  CHECK(found->operator_token.size() == 32);
  CHECK(found->viewer_token.size() == 32);
  CHECK(found->operator_token != found->viewer_token);
  return *found;
}

}  // namespace

TEST_CASE("tokens are kept for a day in a file for this user alone", "[studio][token]") {
  const Folder folder;
  const std::string file = folder.path("cogrsim/studio/" + kName);
  const mode_t before = ::umask(0);
  const KeptTokens first = tokens(folder);
  ::umask(before);
  CHECK(mode_of(folder.path("cogrsim")) == 0700);
  CHECK(mode_of(folder.path("cogrsim/studio")) == 0700);
  CHECK(mode_of(file) == 0600);
  CHECK(tokens(folder).operator_token == first.operator_token);
  CHECK(tokens(folder).viewer_token == first.viewer_token);
  CHECK(tokens(folder, "127.0.0.1_8643").operator_token != first.operator_token);

  // A start restarts the day; so does the end of a server that ran for long.
  set_age(file, 23 * 3600);
  CHECK(tokens(folder).operator_token == first.operator_token);
  set_age(file, 0);
  set_age(file, 48 * 3600);
  keep_tokens(folder.folder().string(), kName);
  CHECK(tokens(folder).operator_token == first.operator_token);
  set_age(file, 25 * 3600);
  const KeptTokens second = tokens(folder);
  CHECK(second.operator_token != first.operator_token);
  CHECK(second.viewer_token != first.viewer_token);
  // A clock that was set back says nothing about its age.
  set_age(file, -3600);
  CHECK(tokens(folder).operator_token != second.operator_token);

  const KeptTokens third = tokens(folder);
  REQUIRE(forget_tokens(folder.folder().string(), kName));
  CHECK(tokens(folder).operator_token != third.operator_token);
  CHECK(forget_tokens(folder.folder().string(), "never_kept"));
}

TEST_CASE("a file of tokens that others could know is not believed", "[studio][token]") {
  const Folder folder;
  const std::string file = folder.path("cogrsim/studio/" + kName);
  const KeptTokens first = tokens(folder);
  const std::string content = Folder::read_file(file);
  SECTION("open to the group") { fs::permissions(file, fs::perms(0640)); }
  SECTION("open to all") { fs::permissions(file, fs::perms(0602)); }
  SECTION("under a second name") { fs::create_hard_link(file, folder.path("copy")); }
  SECTION("a link to it") {
    fs::rename(file, folder.path("elsewhere"));
    fs::create_symlink(folder.path("elsewhere"), file);
  }
  SECTION("a pipe") {
    fs::remove(file);
    REQUIRE(::mkfifo(file.c_str(), 0600) == 0);
  }
  SECTION("cut short") { fs::resize_file(file, content.size() - 1); }
  SECTION("empty") { fs::resize_file(file, 0); }
  SECTION("longer") { std::ofstream(file, std::ios::app) << "x"; }
  SECTION("other characters") {
    std::ofstream(file) << std::string(32, 'g') << "\n" << std::string(32, '0') << "\n";
  }
  SECTION("one token for both") {
    std::ofstream(file) << std::string(32, '1') << "\n" << std::string(32, '1') << "\n";
  }
  const KeptTokens second = tokens(folder);
  CHECK(second.operator_token != first.operator_token);
  CHECK(second.operator_token.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(second.operator_token != std::string(32, '1'));
  CHECK(mode_of(file) == 0600);
  CHECK(tokens(folder).operator_token == second.operator_token);
  // The target of the link is unchanged.
  if (folder.has("elsewhere")) CHECK(folder.read("elsewhere") == content);
}

TEST_CASE("folders that lead elsewhere keep no tokens", "[studio][token]") {
  const Folder folder;
  const std::string base = folder.folder().string();
  fs::create_directory(folder.path("other"));
  SECTION("a link") { fs::create_symlink("other", folder.path("cogrsim")); }
  SECTION("a file") { folder.write("cogrsim", "x"); }
  SECTION("a link below") {
    fs::create_directory(folder.path("cogrsim"));
    fs::create_symlink("../other", folder.path("cogrsim/studio"));
  }
  const auto found = kept_tokens(base, kName);
  REQUIRE(!found);
  CHECK_THAT(found.error().where, Contains(base + "/cogrsim"));
  CHECK(fs::is_empty(folder.path("other")));
}

TEST_CASE("a folder of tokens that others look into is closed", "[studio][token]") {
  const Folder folder;
  fs::create_directories(folder.path("cogrsim/studio"));
  fs::permissions(folder.path("cogrsim"), fs::perms(0777));
  fs::permissions(folder.path("cogrsim/studio"), fs::perms(0755));
  tokens(folder);
  CHECK(mode_of(folder.path("cogrsim")) == 0700);
  CHECK(mode_of(folder.path("cogrsim/studio")) == 0700);
}

TEST_CASE("a server restarted at its port takes the previous tokens", "[studio][server]") {
  const Folder folder;
  ServerOptions options;
  options.port = own_port();
  options.tokens = folder.folder().string();
  std::string token, viewer;
  {
    Served first(options);
    token = first.operator_token;
    viewer = first.viewer_token;
    CHECK(SocketClient(first.port, token).status() == 101);
  }
  {
    Served second(options);
    CHECK(second.operator_token == token);
    CHECK(SocketClient(second.port, token).status() == 101);
    CHECK(SocketClient(second.port, viewer).status() == 101);
    CHECK(second.inbox.wait_joined(2)[0].second == Role::operator_);
    CHECK(second.inbox.wait_joined(2)[1].second == Role::viewer);
    // The address for one visit is another one at every start.
    CHECK(second.server().launch_address() != second.server().address(Role::operator_));
  }
  {
    ServerOptions none = options;
    none.tokens.clear();
    Served third(none);
    CHECK(SocketClient(third.port, token).status() == 403);
  }
  options.new_tokens = true;
  Served fourth(options);
  CHECK(SocketClient(fourth.port, token).status() == 403);
  CHECK(SocketClient(fourth.port, viewer).status() == 403);
  CHECK(SocketClient(fourth.port, fourth.operator_token).status() == 101);
}

TEST_CASE("a server that cannot keep its tokens has new ones", "[studio][server]") {
  const Folder folder;
  folder.write("cogrsim", "in the way");
  ServerOptions options;
  options.port = own_port();
  options.tokens = folder.folder().string();
  std::string token;
  {
    Served first(options);
    token = first.operator_token;
    CHECK(SocketClient(first.port, token).status() == 101);
  }
  Served second(options);
  CHECK(second.operator_token != token);
  CHECK(SocketClient(second.port, second.operator_token).status() == 101);
}

TEST_CASE("the first free port of those preferred is taken", "[studio][server]") {
  Served taken, other;
  ServerOptions options;
  options.preferred = {taken.port, other.port};
  {
    const Served third(options);
    CHECK(third.port != taken.port);
    CHECK(third.port != other.port);
  }
  {
    Served gone;
    options.preferred[1] = gone.port;
  }
  const Served fourth(options);
  CHECK(fourth.port == options.preferred[1]);
  ServerOptions asked = options;
  asked.port = taken.port;
  CHECK_FALSE(Server::listen(asked));
}

TEST_CASE("tokens are kept in the system's state folder", "[studio][token]") {
  const EnvironmentVariable runtime("XDG_RUNTIME_DIR"), state("XDG_STATE_HOME"), home("HOME");
  ::setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
  ::setenv("XDG_STATE_HOME", "/state", 1);
  ::setenv("HOME", "/home/me", 1);
  CHECK(kept_tokens_base() == "/run/user/7");
  ::setenv("XDG_RUNTIME_DIR", "run", 1);
  CHECK(kept_tokens_base() == "/state");
  ::unsetenv("XDG_STATE_HOME");
  CHECK(kept_tokens_base() == "/home/me/.local/state");
  ::setenv("HOME", "", 1);
  CHECK(kept_tokens_base().empty());
}
