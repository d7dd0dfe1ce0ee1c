// The rule for output files: docs/guide/security.md.
#include "cogrsim/core/output_file.h"
#include "../support/temporary_folder.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <catch2/catch.hpp>

using namespace cogrsim;
using namespace std::string_literals;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

struct Folder : test::TemporaryFolder {
  std::size_t count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), {}));
  }
};

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

// Kinds whose own format is the mark; text after it changes nothing.
bool is_self_marked(OutputKind kind) {
  switch (kind) {
    case OutputKind::json:
    case OutputKind::csv:
    case OutputKind::snapshot:
    case OutputKind::figure:
    case OutputKind::script:
    case OutputKind::learner:
      return true;
    default:
      return false;
  }
}

const struct {
  OutputKind kind;
  const char* name;
  std::string bytes;
} kSamples[] = {
    {OutputKind::json, "a.json", "{\n  \"time\": 1\n}\n"},
    {OutputKind::json, "b.json", "{\"time\": 1}\n"},
    {OutputKind::json, "c.json", "{}"},
    {OutputKind::xml, "a.xml", "<testsuites/>\n"},
    {OutputKind::csv, "a.csv", "time [s],body,x [m],y [m]\n0,a,1,2\n"},
    {OutputKind::svg, "a.svg", "<svg/>"},
    {OutputKind::html, "a.html", "<html></html>\n"},
    {OutputKind::pdf, "a.pdf", "%PDF-1.5\n%%EOF\n"},
    {OutputKind::png, "a.png", "\x89PNG\r\n\x1a\n....IEND\xae\x42\x60\x82 12 bytes"},
    {OutputKind::jpeg, "a.jpg", "\xff\xd8 and more \xff\xd9"},
    {OutputKind::film, "a.gif", "GIF89a and more \x3b"},
    {OutputKind::film, "a.mp4",
     "\0\0\0\x18"
     "ftypisom and more"s},
    {OutputKind::film, "a.webm", "\x1a\x45\xdf\xa3 and more"},
    {OutputKind::snapshot, "a.snap", "{\"format\": \"cogrsim-snapshot\"}\n"},
    {OutputKind::figure, "f.json", "{\"format\": \"cogrsim-figure\"}\n"},
    {OutputKind::script, "a.gp", "# CogRSim, for gnuplot\n"},
    {OutputKind::learner, "a.table", "cogrsim-learner 1\n"},
};

}  // namespace

TEST_CASE("own files are recognised and replaced, files of others are not", "[output]") {
  const Folder folder;
  for (const auto& sample : kSamples) {
    INFO(sample.name);
    const std::string path = folder / sample.name;
    REQUIRE(write_output_file(path, sample.kind, sample.bytes));
    const std::string first = content(path);
    const auto again = write_output_file(path, sample.kind, sample.bytes);
    if (!again) INFO(again.error().text());
    REQUIRE(again);
    CHECK(content(path) == first);
    // A mark is written once.
    if (sample.kind != OutputKind::film) CHECK(marked(sample.kind, first) == first);
    for (const std::string& foreign : {"mine\n"s, sample.bytes + "\nand mine"}) {
      if (is_self_marked(sample.kind) && foreign != "mine\n") continue;
      put(path, foreign);
      const auto refused = write_output_file(path, sample.kind, sample.bytes);
      REQUIRE_FALSE(refused);
      CHECK_THAT(refused.error().text(), Contains("--overwrite"));
      CHECK(content(path) == foreign);
    }
    OutputRules rules;
    rules.overwrite = true;
    REQUIRE(write_output_file(path, sample.kind, sample.bytes, rules));
  }
  CHECK(folder.count() == std::size(kSamples));  // nothing temporary is left
  // Of another kind.
  REQUIRE(write_output_file(folder / "x.json", OutputKind::json, "{}"));
  CHECK_FALSE(write_output_file(folder / "x.json", OutputKind::csv, "a"));
}

TEST_CASE("inputs, links, devices, pipes and folders are never replaced", "[output]") {
  const Folder folder;
  OutputRules rules;
  rules.overwrite = true;
  put(folder / "in.json", "{}");
  fs::create_hard_link(folder / "in.json", folder / "same.json");
  fs::create_symlink("in.json", folder / "link.json");
  fs::create_symlink("none", folder / "broken.json");
  fs::create_directory(folder / "folder.json");
  REQUIRE(::mkfifo((folder / "pipe.json").c_str(), 0600) == 0);
  rules.inputs = {folder / "in.json"};
  const std::size_t before = folder.count();
  for (const std::string& path :
       {folder / "in.json", folder / "same.json", folder / "link.json", folder / "broken.json",
        folder / "folder.json", folder / "pipe.json", folder / "", folder / "none/a.json",
        "/dev/null"s, "/dev/full"s, ""s, std::string(5000, 'a')}) {
    INFO(path);
    const auto refused = write_output_file(path, OutputKind::json, "{}", rules);
    REQUIRE_FALSE(refused);
    CHECK_FALSE(refused.error().hint.empty());
  }
  CHECK(folder.count() == before);
  CHECK(fs::is_symlink(folder / "link.json"));
  CHECK(fs::is_fifo(folder / "pipe.json"));
  CHECK(content(folder / "in.json") == "{}");
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("a replaced file keeps its permissions, an uncommitted one leaves nothing", "[output]") {
  const Folder folder;
  const std::string path = folder / "a.json";
  REQUIRE(write_output_file(path, OutputKind::json, "{}"));
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  {
    auto file = OutputFile::create(path, OutputKind::json);
    REQUIRE(file);
    REQUIRE(file->append("{\"half\": "));
    CHECK(fs::path(file->temporary()).extension() == ".json");
  }
  CHECK(folder.count() == 1);
  REQUIRE(write_output_file(path, OutputKind::json, "{\"b\": 1}"));
  CHECK((fs::status(path).permissions() & fs::perms::all) ==
        (fs::perms::owner_read | fs::perms::owner_write));
  CHECK_THAT(content(path), Contains("\"b\": 1"));
}

TEST_CASE("files that a scene names stay in its output folder", "[output]") {
  const Folder folder;
  fs::create_directory(folder / "out");
  fs::create_directory(folder / "elsewhere");
  fs::create_directory_symlink(folder / "elsewhere", folder / "out/link");
  for (const char* name : {"", "/tmp/a.mcap", "../a.mcap", "a/../../b.mcap", "..", ".", "a/"}) {
    INFO(name);
    CHECK_FALSE(output_in(folder / "out", name));
  }
  CHECK(*output_in(folder / "out", "a.mcap") == folder / "out/a.mcap");
  CHECK(*output_in(folder / "out", "./b/a.mcap") == folder / "out/b/a.mcap");
  OutputRules rules;
  rules.folder = folder / "out";
  CHECK(check_output(folder / "out/a.mcap", OutputKind::recording, rules));
  CHECK_FALSE(check_output(folder / "out/a.sh", OutputKind::recording, rules));
  CHECK_FALSE(check_output(folder / "out/.bashrc", OutputKind::recording, rules));
  CHECK_FALSE(check_output(folder / "a.mcap", OutputKind::recording, rules));
  CHECK_FALSE(check_output(folder / "out/link/a.mcap", OutputKind::recording, rules));
  // Not even an empty file of another program.
  put(folder / "out/b.mcap", "");
  CHECK_FALSE(check_output(folder / "out/b.mcap", OutputKind::recording, rules));
}
