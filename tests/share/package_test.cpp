// Packages as files: equal content is an equal file, and hostile ones are refused with nothing left.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "support.h"
#include "zip.h"
#include "zip_maker.h"

using namespace cogrsim::share;
namespace fs = std::filesystem;

namespace {

constexpr const char* kScene = "<scene name=\"evil\" version=\"1\"/>\n";

std::vector<TestFile> good_files() {
  return {{"a.scene.xml", kScene, Role::scene}, {"data/b.csv", "1,2,3\n", Role::data}};
}

// Pulls a package made of these bytes, and returns the output.
struct Pulled {
  Outcome outcome;
  std::map<std::string, std::string> files;
};
Pulled pull(const std::string& bytes) {
  Folder folder;
  write_to(folder / "evil-1.0.0.cogrsim.zip", bytes);
  fs::create_directory(folder / "into");
  Pulled pulled;
  pulled.outcome =
      run_program({"pull", folder / "evil-1.0.0.cogrsim.zip", "--into", folder / "into"});
  pulled.files = files_below(folder / "into");
  // Nothing beside it either.
  CHECK(files_below(folder.path).size() == 1 + pulled.files.size());
  CHECK(std::distance(fs::directory_iterator(folder.path), {}) == 2);
  CHECK(std::distance(fs::directory_iterator(folder / "into"), {}) ==
        (pulled.outcome.status == 0 ? 1 : 0));
  return pulled;
}

void check_refused(const std::string& bytes, const std::string& reason) {
  const Pulled pulled = pull(bytes);
  CAPTURE(pulled.outcome.err, reason);
  CHECK(pulled.outcome.status == 1);
  CHECK(pulled.outcome.err.find(reason) != std::string::npos);
  CHECK(pulled.files.empty());
}

// A member that the manifest does not know, beside a good package.
std::string with_member(const ZipMember& member) {
  auto members = members_for(good_files());
  members.push_back(member);
  return make_zip(members);
}

// A manifest that vouches for a file of this path, which is in the package, too.
std::string vouched(const std::string& path, Role role, const std::string& content = "1\n") {
  auto files = good_files();
  files.push_back({path, content, role});
  return make_zip(members_for(files));
}

}  // namespace

TEST_CASE("a scene is packed with all that it uses and nothing else", "[share]") {
  Folder home;
  const std::string scene = write_scene(home / "arm");
  const Outcome packed =
      run_program({"push", scene, "-o", home.path, "--author", "Ada", "--licence", "CC0",
                   "--description", "an arm", "--version", "1.2"});
  CAPTURE(packed.err);
  REQUIRE(packed.status == 0);
  const auto manifest = read_package(home / "arm-1.2.cogrsim.zip");
  REQUIRE(manifest);
  std::map<std::string, std::string> roles;
  for (const PackagedFile& file : manifest->files) roles[file.path] = role_name(file.role);
  CHECK(roles == std::map<std::string, std::string>{{"CMakeLists.txt", "source"},
                                                    {"arm.scene.xml", "scene"},
                                                    {"data/wave.csv", "data"},
                                                    {"ground/hill.pgm", "heightmap"},
                                                    {"meshes/rock.obj", "mesh"},
                                                    {"driver.cpp", "source"},
                                                    {"driver.h", "source"},
                                                    {"parts/tower.scene.xml", "import"},
                                                    {"textures/tiles.png", "texture"}});
  CHECK(manifest->author == "Ada");
  CHECK(manifest->licence == "CC0");
  CHECK(manifest->description == "an arm");
  CHECK(manifest->scene == "arm.scene.xml");

  const Outcome pulled =
      run_program({"pull", home / "arm-1.2.cogrsim.zip", "--into", home / "there"});
  CAPTURE(pulled.err);
  REQUIRE(pulled.status == 0);
  for (const auto& [path, content] : files_below(home / "there/arm-1.2")) {
    CAPTURE(path);
    if (path != "manifest.json") CHECK(content == content_of(home / ("arm/" + path)));
    struct stat state {};
    REQUIRE(stat((home / ("there/arm-1.2/" + path)).c_str(), &state) == 0);
    CHECK((state.st_mode & 0111) == 0);
  }
  CHECK(files_below(home / "there/arm-1.2").size() == roles.size() + 1);
  // The commands for the sources are printed, and none was run.
  CHECK(pulled.out.find("--plugin-path") != std::string::npos);
  CHECK(pulled.out.find("Nothing of them was built or run") != std::string::npos);
  CHECK(run_program({"check", home / "there/arm-1.2/arm.scene.xml"}).status == 0);

  // A folder that is there stays as it is.
  write_to(home / "there/arm-1.2/mine.txt", "mine");
  const Outcome again =
      run_program({"pull", home / "arm-1.2.cogrsim.zip", "--into", home / "there"});
  CHECK(again.status == 1);
  CHECK(again.err.find("is there already") != std::string::npos);
  CHECK(content_of(home / "there/arm-1.2/mine.txt") == "mine");
}

TEST_CASE("equal content gives an equal package: elsewhere and later", "[share]") {
  Folder one, two;
  for (const Folder* folder : {&one, &two}) write_scene(*folder / "arm");
  for (const auto& item : fs::recursive_directory_iterator(two.path)) {
    fs::last_write_time(item.path(), fs::file_time_type::clock::now() - std::chrono::hours(9999));
    if (item.is_regular_file()) fs::permissions(item.path(), fs::perms(0700));
  }
  REQUIRE(run_program({"push", one / "arm/arm.scene.xml", "-o", one.path}).status == 0);
  REQUIRE(run_program({"push", two / "arm/arm.scene.xml", "-o", two.path},
                      {{"TZ", "Pacific/Kiritimati"}, {"LC_ALL", "C.UTF-8"}})
              .status == 0);
  const std::string bytes = content_of(one / "arm-1.0.0.cogrsim.zip");
  CHECK(bytes.size() > 1000);
  CHECK(bytes == content_of(two / "arm-1.0.0.cogrsim.zip"));
  write_to(two / "arm/driver.h", "#pragma twice\n");
  REQUIRE(run_program({"push", two / "arm/arm.scene.xml", "-o", two.path, "--force"}).status == 0);
  CHECK(bytes != content_of(two / "arm-1.0.0.cogrsim.zip"));
}

TEST_CASE("an existing file is replaced only with --force, dry runs write nothing", "[share]") {
  Folder home;
  const std::string scene = write_scene(home / "arm");
  const std::string file = home / "arm.zip";
  write_to(file, "mine");
  CHECK(run_program({"push", scene, "-o", file}).status == 1);
  CHECK(content_of(file) == "mine");
  CHECK(run_program({"push", scene, "-o", file, "--force", "--dry-run"}).status == 0);
  CHECK(content_of(file) == "mine");
  CHECK(run_program({"push", scene, "-o", file, "--force"}).status == 0);
  REQUIRE(read_package(file));
  const Outcome dry = run_program({"pull", file, "--into", home / "into", "--dry-run"});
  CHECK(dry.status == 0);
  CHECK(dry.out.find("nothing was written") != std::string::npos);
  CHECK_FALSE(fs::exists(home / "into"));
}

TEST_CASE("what cannot be packed is reported", "[share]") {
  Folder home;
  const std::string scene = write_scene(home / "arm");
  const auto refused = [&](std::vector<std::string> more, const std::string& reason) {
    std::vector<std::string> arguments = {"push", scene, "-o", home.path};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run_program(arguments);
    CAPTURE(outcome.err, reason);
    CHECK(outcome.status == 1);
    CHECK(outcome.err.find(reason) != std::string::npos);
    CHECK_FALSE(fs::exists(home / "arm-1.0.0.cogrsim.zip"));
  };
  refused({"--version", "1.0-beta"}, "is not a version");
  refused({"--name", "A/B"}, "is not a name of a package");
  refused({"--author", "a\x1b[2J"}, "control character");
  refused({"--include", home / "arm/controller.so"}, "nothing that packages hold");
  write_to(home / "elsewhere.csv", "1\n");
  refused({"--include", home / "elsewhere.csv"}, "not below the scene's folder");
  write_to(home / "arm/program.csv",
           "\x7f"
           "ELF");
  refused({"--include", home / "arm/program.csv"}, "ELF");
  write_to(home / "fake.mcap", "none");
  refused({"--include", home / "fake.mcap"}, "not a recording");
  write_to(scene, "<scene name=\"arm\" version=\"1\"><mystery/></scene>");
  refused({}, "mystery");
}

TEST_CASE("a good package made by hand is taken", "[share]") {
  // The rest of the tests would prove nothing if this were refused, too.
  const Pulled pulled = pull(make_zip(members_for(good_files())));
  CAPTURE(pulled.outcome.err);
  CHECK(pulled.outcome.status == 0);
  CHECK(pulled.files.at("evil-1.0.0/data/b.csv") == "1,2,3\n");
  auto members = members_for(good_files());
  for (ZipMember& member : members) {
    member.deflated = true;
    member.mode = 0100777;
  }
  CHECK(pull(make_zip(members)).outcome.status == 0);
}

TEST_CASE("paths that lead out of the folder are refused", "[share][hostile]") {
  for (const char* path : {"../evil.csv", "/tmp/evil.csv", "data/../../evil.csv", "..\\evil.csv",
                           "C:\\evil.csv", "data//evil.csv", "./evil.csv"}) {
    CAPTURE(path);
    check_refused(with_member({path, "1\n"}), "");
    check_refused(vouched(path, Role::data), "");
  }
  check_refused(vouched("../evil.csv", Role::data), "leads out of its folder");
  check_refused(vouched("/tmp/evil.csv", Role::data), "is absolute");
  check_refused(with_member({"../evil.csv", "1\n"}), "leads out of its folder");
}

TEST_CASE("links and devices are refused", "[share][hostile]") {
  auto members = members_for(good_files());
  members[2].content = "/etc/passwd";
  members[2].mode = 0120777;
  check_refused(make_zip(members), "is a link");
  for (const std::uint32_t type : {0020000u, 0060000u, 0140000u, 0040000u}) {
    CAPTURE(type);
    auto others = members_for(good_files());
    others[2].mode = type | 0644;
    check_refused(make_zip(others), "");
  }
  check_refused(with_member({"folder/", "", 0040755}), "");
  // libarchive takes a pipe for an ordinary file, so an ordinary file is written at most.
  members = members_for(good_files());
  members[2].mode = 0010644;
  Folder folder;
  write_to(folder / "a.zip", make_zip(members));
  fs::create_directory(folder / "into");
  if (read_package(folder / "a.zip", folder / "into")) {
    CHECK(fs::is_regular_file(fs::symlink_status(folder / "into/data/b.csv")));
  }
}

TEST_CASE("names that are there twice, or differ in capitals, are refused", "[share][hostile]") {
  check_refused(with_member({"data/b.csv", "1,2,3\n"}), "is there twice");
  check_refused(with_member({"manifest.json", "{}"}), "the manifest is there twice");
  check_refused(vouched("data/B.csv", Role::data), "differ in capitals only");
  check_refused(vouched("DATA/c.csv", Role::data), "differ in capitals only");
  check_refused(vouched("data/b.csv/c.csv", Role::data), "is a folder of the other");
  check_refused(vouched("Manifest.json", Role::data), "differ in capitals only");
  check_refused(vouched("data/b.csv", Role::data, "4\n"), "is there twice");
}

TEST_CASE("names of devices, hidden files and control characters are refused", "[share][hostile]") {
  check_refused(vouched("NUL.csv", Role::data), "is the name of a device");
  check_refused(vouched("data/com1.csv", Role::data), "is the name of a device");
  check_refused(vouched(".hidden.csv", Role::data), "is hidden");
  check_refused(vouched("a\nb.csv", Role::data), "control character");
  check_refused(vouched("a\x1b[2Jb.csv", Role::data), "control character");
  check_refused(vouched("b.csv ", Role::data), "ends in a point or a space");
}

TEST_CASE("programs are refused, by name and by content", "[share][hostile]") {
  check_refused(vouched("controller.so", Role::source), "is not an allowed file extension");
  check_refused(vouched("controller.so", Role::data), "is not an allowed file extension");
  check_refused(vouched("run.sh", Role::data, "reboot\n"), "is not an allowed file extension");
  check_refused(vouched("driver.csv", Role::data,
                        "\x7f"
                        "ELF\x02"),
                "program or library (ELF)");
  check_refused(vouched("t.png", Role::texture, "MZ\x90"), "program or library (PE)");
  check_refused(vouched("t.png", Role::texture, "GIF89a"), "is not a PNG picture");
  check_refused(vouched("driver.h", Role::source, std::string("a\0b", 3)), "is not a text");
  check_refused(
      "\x7f"
      "ELF" +
          make_zip(members_for(good_files())),
      "this is not a zip file");
}

TEST_CASE("files that the manifest does not list are refused", "[share][hostile]") {
  check_refused(with_member({"more.csv", "1\n"}), "'more.csv' is not in the manifest");
  auto members = members_for(good_files());
  members.pop_back();
  check_refused(make_zip(members), "'data/b.csv' is in the manifest, but not in the package");
  members = members_for(good_files());
  members[2].content = "1,2,4\n";
  check_refused(make_zip(members), "its hash is another");
  members[2].content = "1,2\n";
  check_refused(make_zip(members), "has 4 bytes instead of 6");
  members[2].content = "1,2,3,4,5\n";
  check_refused(make_zip(members), "has more than the 6 bytes");
  members.erase(members.begin());
  check_refused(make_zip(members), "does not begin with its manifest");
  check_refused(make_zip({{"manifest.json", "{}"}}), "not a manifest of a CogRSim package");
}

TEST_CASE("damaged and disguised archives are refused", "[share][hostile]") {
  const std::string good = make_zip(members_for(good_files()));
  check_refused("", "this is not a zip file");
  check_refused("PK\x03\x04", "");
  check_refused(good.substr(0, good.size() / 2), "");
  check_refused(good.substr(0, good.size() - 30), "");
  std::string changed = good;
  changed[changed.find("1,2,3")] = '7';
  check_refused(changed, "data/b.csv");
  auto members = members_for(good_files());
  members[2].flags = 1;
  check_refused(make_zip(members), "");
  // Every byte of a small package changed: never accepted with other content, never a crash.
  for (std::size_t i = 0; i < good.size(); i += 7) {
    Folder folder;
    changed = good;
    changed[i] = static_cast<char>(changed[i] ^ 0x15);
    write_to(folder / "a.zip", changed);
    fs::create_directory(folder / "into");
    if (const auto read = read_package(folder / "a.zip", folder / "into")) {
      for (const PackagedFile& file : read->files) {
        const std::string content = content_of(folder / ("into/" + file.path));
        CHECK((content == kScene || content == "1,2,3\n"));
      }
    }
  }
}

TEST_CASE("archive bombs are refused before they fill the disk", "[share][hostile]") {
  // 64 MiB of zeros shrink about a thousandfold: within each file's size, far beyond the ratio.
  auto files = good_files();
  files.push_back({"zeros.stl", std::string(64u << 20, '\0'), Role::mesh});
  auto members = members_for(files);
  members.back().deflated = true;
  check_refused(make_zip(members), "times its size");
  // The manifest names 1 byte.
  files.back().content = "0";
  auto liar = members_for(files);
  liar.back().content = std::string(64u << 20, '\0');
  liar.back().deflated = true;
  check_refused(make_zip(liar), "has more than the 1 bytes");
  // The manifest itself.
  ZipMember manifest{"manifest.json", std::string(8u << 20, ' ')};
  manifest.deflated = true;
  check_refused(make_zip({manifest}), "has more than the");
  PackageLimits limits;
  limits.package_bytes = 100;
  Folder folder;
  write_to(folder / "a.zip", make_zip(members_for(good_files())));
  const auto read = read_package(folder / "a.zip", "", limits);
  REQUIRE_FALSE(read);
  CHECK(read.error().message.find("at most 100") != std::string::npos);
}
