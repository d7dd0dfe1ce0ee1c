// Saving: whole or not at all, never over the changes of another program, never elsewhere.
#include <catch2/catch.hpp>

#include <sys/stat.h>

#include "build.h"
#include "document_file.h"
#include "document_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;

namespace fs = std::filesystem;

namespace {
const std::string kOne = "<scene>\n  <plane/>\n</scene>\n";
const std::string kTwo = "<scene>\n  <plane name=\"p\"/>\n</scene>\n";
const std::string kThree = "<scene>\n  <plane name=\"q\"/>\n</scene>\n";
}  // namespace

TEST_CASE("saving keeps the old content and its permissions", "[document][file]") {
  Folder folder;
  folder.write("t.scene.xml", kOne);
  REQUIRE(::chmod(folder.path("t.scene.xml").c_str(), 0640) == 0);
  RequestHandler requests(folder.path("t.scene.xml"));
  requests.get("set-text", {{"version", 1}, {"text", kTwo}});
  CHECK(requests.page.wait("document", 2)["dirty"] == true);
  const Json saved = requests.get("save");
  CHECK(saved["file"] == "t.scene.xml");
  CHECK(saved["backup"] == "t.scene.xml~");
  CHECK(folder.read("t.scene.xml") == kTwo);
  CHECK(folder.read("t.scene.xml~") == kOne);
  struct stat about {};
  REQUIRE(::stat(folder.path("t.scene.xml").c_str(), &about) == 0);
  CHECK((about.st_mode & 0777) == 0640);
  requests.get("sources");
  CHECK(requests.page.wait("document", 2)["dirty"] == false);
  // Nothing else is left behind.
  CHECK(std::distance(fs::directory_iterator(folder.folder()), fs::directory_iterator()) == 2);
  requests.get("set-text", {{"version", 2}, {"text", kThree}});
  requests.get("save");
  CHECK(folder.read("t.scene.xml~") == kTwo);
}

TEST_CASE("a file that another program changed is not overwritten", "[document][file]") {
  Folder folder;
  folder.write("t.scene.xml", kOne);
  RequestHandler requests(folder.path("t.scene.xml"));
  requests.get("set-text", {{"version", 1}, {"text", kTwo}});
  folder.write("t.scene.xml", kThree);
  const Answer refused = requests.ask("save");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message.find("another program") != std::string::npos);
  CHECK(refused.error().hint.find("revert") != std::string::npos);
  CHECK(folder.read("t.scene.xml") == kThree);
  // What the user can do.
  SECTION("under another name") {
    CHECK(requests.get("save", {{"file", "mine.scene.xml"}})["file"] == "mine.scene.xml");
    CHECK(folder.read("mine.scene.xml") == kTwo);
    CHECK(folder.read("t.scene.xml") == kThree);
  }
  SECTION("an existing file") {
    CHECK(requests.get("revert")["text"] == kThree);
    CHECK(requests.text() == kThree);
    requests.get("undo");  // one step back are one's own changes
    CHECK(requests.text() == kTwo);
    requests.get("save");
    CHECK(folder.read("t.scene.xml") == kTwo);
    CHECK(folder.read("t.scene.xml~") == kThree);
  }
}

TEST_CASE("nothing is saved outside of the folder or under other endings", "[document][file]") {
  Folder folder;
  folder.write("sub/t.scene.xml", kOne);
  folder.write("sub/other.scene.xml", kThree);
  RequestHandler requests(folder.path("sub/t.scene.xml"));
  for (const char* name :
       {"../x.scene.xml", "/tmp/x.scene.xml", "a/x.scene.xml", "x.xml", ".scene.xml",
        ".x.scene.xml", "", "..", "x.scene.xml\n", "a\\b.scene.xml", "other.scene.xml"}) {
    INFO(name);
    CHECK_FALSE(requests.ask("save", {{"file", name}}));
  }
  CHECK_FALSE(requests.ask("save", {{"file", std::string("x\0.scene.xml", 12)}}));
  CHECK_FALSE(requests.ask("save", {{"file", 7}}));
  CHECK_FALSE(folder.has("x.scene.xml"));
  CHECK(folder.read("sub/other.scene.xml") == kThree);
  CHECK(std::distance(fs::directory_iterator(folder.folder() / "sub"), fs::directory_iterator()) ==
        2);
}

TEST_CASE("a link is written through and stays a link", "[document][file]") {
  Folder folder;
  folder.write("real.scene.xml", kOne);
  fs::create_symlink("real.scene.xml", folder.path("t.scene.xml"));
  RequestHandler requests(folder.path("t.scene.xml"));
  requests.get("set-text", {{"version", 1}, {"text", kTwo}});
  requests.get("save");
  CHECK(fs::is_symlink(folder.path("t.scene.xml")));
  CHECK(folder.read("real.scene.xml") == kTwo);
}

TEST_CASE("files that are no text are not opened", "[document][file]") {
  Folder folder;
  folder.write("t.scene.xml", "<scene name=\"\xFF\"/>");
  Listener page;
  ShownRun run;
  DocumentOptions options;
  options.path = folder.path("t.scene.xml");
  auto loader = std::make_shared<PluginLoader>();
  const auto broken = Document::open(options, loader, run, page);
  REQUIRE_FALSE(broken);
  CHECK(broken.error().message.find("UTF-8") != std::string::npos);
  options.path = folder.folder().string();
  CHECK_FALSE(Document::open(options, loader, run, page));
  options.path = folder.path("nowhere/t.scene.xml");
  CHECK_FALSE(Document::open(options, loader, run, page));
  CHECK(is_utf8("\xC3\xA4 \xE2\x82\xAC \xF0\x9F\xA4\x96"));
  for (const char* bad : {"\xC0\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xE2\x82", "\x80"})
    CHECK_FALSE(is_utf8(bad));
}

TEST_CASE("sources beside the scene are listed and written", "[document][file]") {
  Folder folder;
  folder.write("t.scene.xml", kOne);
  folder.write("driver/driver.cpp", "int x;\n");
  folder.write("CMakeLists.txt", "project(x)\n");
  folder.write("build/gen.cpp", "");
  folder.write("a/b/c/d/deep.cpp", "");
  folder.write(".git/x.h", "");
  folder.write("notes.txt", "");
  fs::create_symlink("/etc/passwd", folder.path("link.cpp"));
  RequestHandler requests(folder.path("t.scene.xml"));
  const Json files = requests.get("sources")["files"];
  REQUIRE(files.size() == 2);
  CHECK(files[0]["name"] == "CMakeLists.txt");
  CHECK(files[1]["name"] == "driver/driver.cpp");
  for (const char* name : {"link.cpp", "../t.scene.xml", "/etc/passwd", "notes.txt", "t.scene.xml",
                           "driver/../driver/driver.cpp", "a/b/c/d/deep.cpp"}) {
    INFO(name);
    CHECK_FALSE(requests.ask("open-source", {{"name", name}}));
    CHECK_FALSE(requests.ask("save-source", {{"name", name}, {"text", "x"}}));
  }
  const Json opened = requests.get("open-source", {{"name", "driver/driver.cpp"}});
  CHECK(opened["text"] == "int x;\n");
  const Json saved =
      requests.get("save-source",
               {{"name", "driver/driver.cpp"},
                {"text", "int y;\n"},
                {"version", opened["version"]}});
  CHECK(folder.read("driver/driver.cpp") == "int y;\n");
  CHECK(folder.read("driver/driver.cpp~") == "int x;\n");
  CHECK(saved["version"] != opened["version"]);
  const Answer stale =
      requests.ask("save-source",
               {{"name", "driver/driver.cpp"},
                {"text", "int z;\n"},
                {"version", opened["version"]}});
  REQUIRE_FALSE(stale);
  CHECK(stale.error().code == "stale");
}

TEST_CASE("complaints of compilers are found in their log", "[document][build]") {
  const Json problems = problems_in(
      "[ 50%] Building\n"
      "/w/scene/driver.cpp:12:7: error: expected ';' before 'int'\n"
      "/w/scene/driver.cpp: In function 'f':\n"
      "/w/scene/driver.cpp:12:7: error: expected ';' before 'int'\n"
      "/usr/include/x.h:3: fatal error: no such file\n"
      "/w/scene/a.h:1:2: warning: unused\n"
      "CMake Error at CMakeLists.txt:5 (find_package):\n  Could not find\n  CogRSim\n\n-- done\n"
      ": error: \nerror: nothing\n",
      "/w/scene");
  REQUIRE(problems.size() == 4);
  CHECK(problems[0]["file"] == "driver.cpp");
  CHECK(problems[0]["line"] == 12);
  CHECK(problems[0]["column"] == 7);
  CHECK(problems[0]["message"] == "expected ';' before 'int'");
  CHECK(problems[1]["file"] == "/usr/include/x.h");
  CHECK(problems[1]["line"] == 3);
  CHECK(problems[2]["severity"] == "warning");
  CHECK(problems[3]["file"] == "CMakeLists.txt");
  CHECK(problems[3]["line"] == 5);
  CHECK(problems[3]["message"] == "Could not find   CogRSim");
}
