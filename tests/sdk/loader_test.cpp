#include "cogrsim/plugin/loader.h"
#include "../support/temporary_folder.h"

#include <link.h>
#include <sys/stat.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <catch2/catch.hpp>

#include "cogrsim/core/random.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/source.h"
#include "plugin/elf_symbols.h"

using namespace cogrsim;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

struct Folder : test::TemporaryFolder {
  std::string file(const std::string& name) const { return *this / name; }
  void write(const std::string& name, const std::string& bytes) const {
    fs::remove(file(name));  // file systems flush when a file is truncated and rewritten
    std::ofstream(file(name), std::ios::binary) << bytes;
  }
  /// Puts one of the test libraries in.
  void put(const std::string& library) const {
    fs::copy_file(fs::path(COGRSIM_TEST_LIBRARIES) / library, file(library));
  }
};

/// Sets the environment variable that libraries/trap.h checks.
class TrapWatch {
 public:
  TrapWatch() { setenv("COGRSIM_TRAP", folder_.file("trace").c_str(), 1); }
  ~TrapWatch() { unsetenv("COGRSIM_TRAP"); }
  bool sprung() const { return fs::exists(folder_.file("trace")); }

 private:
  Folder folder_;
};

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string library(const std::string& name) {
  return (fs::path(COGRSIM_TEST_LIBRARIES) / name).string();
}

/// The error of loading a sensor by this name from the folder.
Error refusal(const Folder& folder, const std::string& name) {
  PluginLoader loader({folder.path.string()});
  const auto got = loader.load(PluginKind::sensor, name);
  REQUIRE_FALSE(got);
  return got.error();
}

}  // namespace

TEST_CASE("a plugin describes itself", "[loader]") {
  const Folder folder;
  folder.put("good.so");
  const TrapWatch watch;
  PluginLoader loader({folder.path.string()});
  const auto got = loader.load(PluginKind::sensor, "good");
  REQUIRE(got);
  CHECK(watch.sprung());  // the trap works at all
  CHECK((*got)->descriptor().version == "1.2.0");
  CHECK((*got)->descriptor().author == "A. Tester");
  CHECK((*got)->descriptor().parameters.size() == 1);
  CHECK((*got)->path() == fs::canonical(folder.file("good.so")));
  CHECK(loader.load(PluginKind::sensor, "good")->get() == got->get());  // loaded once
}

TEST_CASE("a plugin stays loaded while it is in use", "[loader]") {
  std::shared_ptr<const Backend> backend;
  {
    PluginLoader loader({COGRSIM_TEST_LIBRARIES});
    const auto got = loader.backend("tiny_engine");
    REQUIRE(got);
    backend = *got;
  }
  CHECK(std::string(backend->name()) == "tiny_engine");
  CHECK(backend->create_world(nullptr).error().message == "the tiny engine has no worlds");
}

TEST_CASE("no code of a library with another ABI runs", "[loader]") {
  const auto [name, reason] = GENERATE(table<std::string, std::string>(
      {{"foreign", "built for gcc99_cxx11, ABI 8; this CogRSim is"},
       {"unmarked", "not a CogRSim plugin"},
       {"no_descriptor", "the symbol 'cogrsim_plugin' is missing"},
       {"unresolved", "undefined symbol: cogrsim_test_missing_function"}}));
  CAPTURE(name);
  const Folder folder;
  folder.put(name + ".so");
  const TrapWatch watch;
  const Error error = refusal(folder, name);
  CHECK(error.code == "CG0902");
  CHECK_THAT(error.message, Contains(reason));
  CHECK(error.where == folder.file(name + ".so"));
  CHECK_FALSE(watch.sprung());
}

TEST_CASE("a descriptor that throws or lies is refused", "[loader]") {
  const Folder folder;
  folder.put("throwing.so");
  folder.put("misnamed.so");
  CHECK_THAT(refusal(folder, "throwing").message, Contains("no licence today"));
  CHECK_THAT(refusal(folder, "misnamed").message, Contains("calls itself 'somebody_else'"));
}

TEST_CASE("files that are no libraries are refused with the reason", "[loader]") {
  const Folder folder;
  folder.write("text.so", "this is not a library\n");
  folder.write("empty.so", "");
  folder.write("magic.so",
               "\x7f"
               "ELF");
  folder.write("windows.so", "MZ" + std::string(500, '\0'));
  fs::create_directory(folder.file("directory.so"));
  fs::create_symlink(folder.file("nowhere"), folder.file("dangling.so"));
  fs::create_symlink(folder.file("circle.so"), folder.file("circle.so"));
  REQUIRE(mkfifo(folder.file("pipe.so").c_str(), 0600) == 0);  // must not wait for a writer
  fs::copy_file("/proc/self/exe", folder.file("program.so"));
  for (const char* name : {"text", "empty", "magic", "windows", "directory", "dangling", "circle",
                           "pipe", "program"}) {
    CAPTURE(name);
    CHECK(refusal(folder, name).code == "CG0902");
  }
  CHECK_THAT(refusal(folder, "text").message, Contains("not a shared library"));
  CHECK_THAT(refusal(folder, "directory").message, Contains("not a regular file"));
}

TEST_CASE("a library that was cut off is refused", "[loader]") {
  const std::string whole = bytes_of(library("good.so"));
  REQUIRE(whole.size() > 1000);
  const Folder folder;
  for (std::size_t part = 0; part < 40; ++part) {
    folder.write("good.so", whole.substr(0, whole.size() * part / 40));
    CHECK(refusal(folder, "good").code == "CG0902");
  }
}

TEST_CASE("a segment beyond the end of the file is found before it is mapped", "[loader]") {
  std::string bytes = bytes_of(library("good.so"));
  ElfW(Ehdr) header;
  std::memcpy(&header, bytes.data(), sizeof header);
  ElfW(Phdr) segment;
  char* at = bytes.data() + header.e_phoff;  // the first segment is one to load
  std::memcpy(&segment, at, sizeof segment);
  REQUIRE(segment.p_type == PT_LOAD);
  segment.p_filesz = segment.p_memsz = 2 * bytes.size();
  std::memcpy(at, &segment, sizeof segment);
  const Folder folder;
  folder.write("good.so", bytes);
  CHECK_THAT(refusal(folder, "good").message, Contains("damaged or cut off"));
}

TEST_CASE("reading symbols survives any damage", "[loader]") {
  const std::string whole = bytes_of(library("good.so"));
  const Folder folder;
  RandomStream random(1, "damage");
  ElfW(Ehdr) header;
  std::memcpy(&header, whole.data(), sizeof header);
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = whole;
    // Most bytes are not read: target the file header and the section headers.
    const std::size_t begin = i % 2 ? 0 : static_cast<std::size_t>(header.e_shoff);
    const std::size_t length = i % 2 ? 64 : whole.size() - begin;
    for (int k = 0; k < 4; ++k) {
      bytes[begin + random.next() % length] = static_cast<char>(random.next());
    }
    folder.write("damaged", bytes);
    const auto symbols = exported_symbols(folder.file("damaged"), "cogrsim_");
    if (!symbols) CHECK_FALSE(symbols.error().message.empty());
  }
}

TEST_CASE("a stripped library still has its mark", "[loader]") {
  const auto symbols = exported_symbols(library("good_stripped.so"), "cogrsim_");
  REQUIRE(symbols);
  CHECK(std::count(symbols->begin(), symbols->end(), COGRSIM_STRING(COGRSIM_ABI_SYMBOL)) == 1);
  CHECK(std::count(symbols->begin(), symbols->end(), "cogrsim_plugin") == 1);
}

TEST_CASE("an unknown name lists the folders and the available plugins", "[loader]") {
  const Folder folder;
  folder.put("good.so");
  PluginLoader loader({folder.path.string(), folder.file("not_there")});
  const auto got = loader.load(PluginKind::sensor, "god");
  REQUIRE_FALSE(got);
  CHECK(got.error().code == "CG0901");
  CHECK_THAT(got.error().message, Contains("there is no sensor 'god'") &&
                                      Contains(folder.file("god.so") + ": no such file") &&
                                      Contains("not_there/god.so: no such folder"));
  CHECK_THAT(got.error().hint, Contains("did you mean 'good'?"));
}

TEST_CASE("a plugin of the wrong kind is reported as such", "[loader]") {
  const Folder folder;
  folder.put("good.so");
  PluginLoader loader({folder.path.string()});
  const auto got = loader.load(PluginKind::controller, "good");
  REQUIRE_FALSE(got);
  CHECK(got.error().code == "CG0903");
  CHECK(got.error().message == "plugin 'good' is a sensor, not a controller");
}

TEST_CASE("a scene cannot reach a file by its path", "[loader]") {
  const Folder folder;
  folder.put("good.so");
  fs::create_directory(folder.file("sub"));
  PluginLoader loader({folder.file("sub")});
  for (const std::string& name :
       {std::string("../good"), folder.file("good"), std::string(), std::string("..")}) {
    CAPTURE(name);
    const auto got = loader.load(PluginKind::sensor, name);
    REQUIRE_FALSE(got);
    CHECK_THAT(got.error().hint, Contains("a scene names a plugin, never a path"));
  }
}

TEST_CASE("folders come from the caller, the environment, and beside the library", "[loader]") {
  const Folder given, environment;
  environment.put("good.so");
  setenv("COGRSIM_PLUGIN_PATH", (":" + environment.path.string() + ":").c_str(), 1);
  PluginLoader loader({given.path.string()});
  unsetenv("COGRSIM_PLUGIN_PATH");
  REQUIRE(loader.folders().size() == 4);
  CHECK(loader.folders()[0] == given.path.string());
  CHECK(loader.folders()[1] == environment.path.string());
  CHECK_THAT(loader.folders()[2], Catch::Matchers::EndsWith("lib/cogrsim/backends"));
  CHECK_THAT(loader.folders()[3], Catch::Matchers::EndsWith("lib/cogrsim/plugins"));
  CHECK(loader.load(PluginKind::sensor, "good"));
}

TEST_CASE("all plugins are listed, and those refused with the reason", "[loader]") {
  const Folder folder, second;
  for (const char* name : {"good.so", "tiny_engine.so", "foreign.so"}) folder.put(name);
  folder.write("notes.txt", "not looked at");
  second.put("good.so");
  PluginLoader loader({folder.path.string(), second.path.string(), folder.path.string()});
  std::vector<RefusedPlugin> refused;
  std::vector<std::string> mine;
  for (const PluginPtr& plugin : loader.all(&refused)) {
    if (fs::path(plugin->path()).parent_path() == fs::canonical(folder.path.string())) {
      mine.push_back(plugin->descriptor().name);
    }
  }
  CHECK(mine == std::vector<std::string>{"tiny_engine", "good"});
  const auto reason = [&](const std::string& path) -> std::string {
    for (const RefusedPlugin& r : refused) {
      if (r.path == path) return r.reason;
    }
    return "not refused";
  };
  CHECK_THAT(reason(folder.file("foreign.so")), Contains("built for gcc99"));
  CHECK_THAT(reason(second.file("good.so")), Contains("hidden by"));
}

TEST_CASE("plugins of a source are no libraries") {
  int asked = 0;
  const std::vector<std::string> folders = {"/here"};
  set_plugin_source("toy:", [&](PluginKind kind, const std::string& name,
                                const std::vector<std::string>& searched)
                                -> Result<std::shared_ptr<const PluginDescriptor>> {
    ++asked;
    CHECK(searched.front() == folders.front());
    if (name != "toy:car") return fail("there is no toy '" + name + "'", "", "", "CG0901");
    auto out = std::make_shared<PluginDescriptor>();
    out->kind = kind;
    out->name = name;
    out->factory = &asked;
    return out;
  });
  PluginLoader loader(folders);
  const auto car = loader.load(PluginKind::controller, "toy:car");
  REQUIRE(car);
  CHECK((*car)->descriptor().factory == &asked);
  CHECK((*car)->path().empty());
  CHECK(*loader.load(PluginKind::controller, "toy:car") == *car);
  CHECK(asked == 1);
  // Kept by loader and kind.
  CHECK(*loader.load(PluginKind::sensor, "toy:car") != *car);
  CHECK(*PluginLoader(folders).load(PluginKind::controller, "toy:car") != *car);
  CHECK(asked == 3);
  const auto none = loader.load(PluginKind::controller, "toy:boat");
  REQUIRE_FALSE(none);
  CHECK(none.error().code == "CG0901");
  CHECK_THAT(none.error().message, Contains("toy:boat"));
  const auto copy = loader.load_fresh_copy(**car);
  REQUIRE_FALSE(copy);
  CHECK_THAT(copy.error().message, Contains("not a library"));
  set_plugin_source("toy:", {});
  CHECK_FALSE(loader.load(PluginKind::controller, "toy:car"));
}
