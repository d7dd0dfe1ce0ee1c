// Hostile files end in a coded error, within bounded memory and time.
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "../support/sanitizers.h"
#include "../support/temporary_folder.h"
#include "cogrsim/dsl/compiler.h"
#include "language/vocabulary.h"

namespace fs = std::filesystem;
using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

std::string codes(const CompileResult& result) {
  std::string out;
  for (const Diagnostic& d : result.diagnostics) out += (out.empty() ? "" : " ") + d.code;
  return out;
}

/// Limits of a case in addition to the program's own use: beyond them an allocation fails, or
/// SIGXCPU ends the program. Processor time, because wall-clock time depends on the machine; the
/// longest case takes a twentieth of it.
class Bounded {
 public:
  Bounded() {
    // Sanitizers reserve terabytes, and take ten times as long.
    if (!test::kSanitized) REQUIRE(limit(RLIMIT_AS, size_now() + 500'000'000));
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto seconds = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
    REQUIRE(limit(RLIMIT_CPU, seconds + (test::kSanitized ? 200 : 20)));
  }
  ~Bounded() {
    limit(RLIMIT_AS, RLIM_INFINITY);
    limit(RLIMIT_CPU, RLIM_INFINITY);
  }
  Bounded(const Bounded&) = delete;
  Bounded& operator=(const Bounded&) = delete;

 private:
  static bool limit(__rlimit_resource_t what, rlim_t value) {
    rlimit now{};
    if (::getrlimit(what, &now) != 0) return false;
    now.rlim_cur = std::min(value, now.rlim_max);
    return ::setrlimit(what, &now) == 0;
  }
  /// Of this process's memory [byte].
  static rlim_t size_now() {
    rlim_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
  }
};

using Folder = test::TemporaryFolder;

std::string repeated(const std::string& piece, int times) {
  std::string out;
  out.reserve(piece.size() * static_cast<std::size_t>(times));
  for (int i = 0; i < times; ++i) out += piece;
  return out;
}

}  // namespace

TEST_CASE_METHOD(Bounded, "a file of 100 MB is refused by its size", "[hostile]") {
  const Folder folder;
  const std::string path = folder.write("big.scene.xml", "<scene>");
  fs::resize_file(path, 100'000'000);  // sparse: nothing is written
  const auto result = compile_file(path);
  CHECK(codes(result) == "CG0108");
  CHECK(codes(compile_text(std::string((16u << 20) + 1, ' '), "big")) == "CG0108");
}

TEST_CASE_METHOD(Bounded, "text and lists that double are bounded, one by one and in sum",
                 "[hostile]") {
  const auto doubling = [](const std::string& first, const std::string& next, int times) {
    std::string text =
        "<scene name=\"a\" version=\"1\">\n<param name=\"p0\" default=\"" + first + "\"/>\n";
    for (int i = 0; i < times; ++i) {
      std::string step = next;
      for (std::size_t at; (at = step.find('@')) != std::string::npos;)
        step.replace(at, 1, "p" + std::to_string(i));
      text += "<param name=\"p" + std::to_string(i + 1) + "\" default=\"${" + step + "}\"/>\n";
    }
    return text + "<box name=\"b\" size=\"1 1 1\" mass=\"1 kg\" color=\"${p" +
           std::to_string(times) + "}\"/></scene>";
  };
  CHECK(codes(compile_text(doubling("abcd", "@ + @", 40), "text")).substr(0, 6) == "CG0513");
  CHECK(codes(compile_text(doubling("${[1, 2]}", "@ + @", 40), "list")).substr(0, 6) == "CG0513");
  CHECK(codes(compile_text(doubling("${[1, 2]}", "[@, @]", 40), "nested")).substr(0, 6) ==
        "CG0511");
  // Each below its own bound, too much together.
  std::string sum = "<scene name=\"a\" version=\"1\">\n<param name=\"p\" default=\"" +
                    std::string(30000, 'a') + "\"/>\n";
  for (int i = 0; i < 2000; ++i)
    sum += "<param name=\"q" + std::to_string(i) + "\" default=\"${p + p}\"/>\n";
  CHECK(codes(compile_text(sum + "</scene>", "sum")).find("CG0511") != std::string::npos);
}

TEST_CASE_METHOD(Bounded, "one long line is as good as many short ones", "[hostile]") {
  // Found when each value's line was scanned to its end: 56 s for this file.
  const std::string text = "<scene name=\"a\" version=\"1\">" +
                           repeated("<contact between=\"a b\" friction=\"0.5\"/>", 20000) +
                           "</scene>";
  CHECK_FALSE(codes(compile_text(text, "line")).empty());
  std::string params = "<scene name=\"a\" version=\"1\">";
  for (int i = 0; i < 5000; ++i)
    params += "<param name=\"p" + std::to_string(i) + "\" default=\"1\"/>";
  CHECK(codes(compile_text(params + "</scene>", "params")).substr(0, 6) == "CG2003");
}

TEST_CASE_METHOD(Bounded, "billion laughs, external entities and other DOCTYPEs are refused",
                 "[hostile]") {
  CHECK(codes(compile_text("<!DOCTYPE a [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><scene "
                           "name=\"&x;\"/>",
                           "x")) == "CG0107");
}

TEST_CASE_METHOD(Bounded, "10,000 nested elements are refused", "[hostile]") {
  const std::string text =
      "<scene>" + repeated("<assembly>", 10000) + repeated("</assembly>", 10000) + "</scene>";
  CHECK(codes(compile_text(text, "deep")) == "CG0109");
  CHECK(codes(compile_text(repeated("<a>", 1000000), "deep")) == "CG0109");
}

TEST_CASE_METHOD(Bounded, "floods of elements, attributes and errors are cut off", "[hostile]") {
  CHECK(codes(compile_text("<scene>" + repeated("<a/>", 500001) + "</scene>", "many")) == "CG0110");
  std::string attributes = "<scene";
  for (int i = 0; i < 100000; ++i) attributes += " a" + std::to_string(i) + "=''";
  CHECK(codes(compile_text(attributes + "/>", "many")) == "CG0110");
  CHECK(codes(compile_text("<scene name='" + std::string(70000, 'x') + "'/>", "long")) == "CG0111");
  const auto errors = compile_text("<scene>" + repeated("<a/>", 100000) + "</scene>", "errors");
  CHECK(errors.diagnostics.size() == 100);
  const auto references =
      compile_text("<scene name='" + repeated("&", 60000) + "'/>", "references");
  CHECK(references.diagnostics.size() <= 20);
  // One line of 8 MB with a mistake at its end.
  CHECK(codes(compile_text("<scene>" + repeated("<frame name='f'/>", 400000) + "<</scene>",
                           "line")) != "");
}

TEST_CASE_METHOD(Bounded, "expressions cannot run away", "[hostile]") {
  const auto deep =
      compile_text("<scene><view xyz='${" + repeated("(", 50000) + "} 0 0'/></scene>", "deep");
  CHECK(codes(deep) == "CG0511");
  const auto doubling = [](int times) {
    std::string text = "<scene><param name='p0' default='${[1]}'/>";
    for (int i = 1; i <= times; ++i) {
      const std::string before = "p" + std::to_string(i - 1);
      text +=
          "<param name='p" + std::to_string(i) + "' default='${" + before + " + " + before + "}'/>";
    }
    return text + "</scene>";
  };
  const auto result = compile_text(doubling(60), "lists");
  CHECK_FALSE(result.ok());
}

TEST_CASE_METHOD(Bounded, "files that import each other are refused", "[hostile]") {
  const Folder folder;
  const std::string a = folder.write("a.scene.xml", "<scene><import href='b.scene.xml'/></scene>");
  folder.write("b.scene.xml", "<scene><import href='a.scene.xml'/></scene>");
  CHECK(codes(compile_file(a)).find("CG0302") != std::string::npos);
}

TEST_CASE_METHOD(Bounded, "files that import the next one twice are given up soon", "[hostile]") {
  const Folder folder;
  const auto name = [](int i) { return "f" + std::to_string(i) + ".scene.xml"; };
  for (int i = 0; i < 25; ++i) {
    folder.write(name(i), "<scene><import href='" + name(i + 1) + "' as='a'/><import href='" +
                              name(i + 1) + "' as='b'/></scene>");
  }
  folder.write(name(25), "<scene/>");
  CHECK(codes(compile_file((folder.path / name(0)).string())) == "CG0306");
}

TEST_CASE_METHOD(Bounded, "nothing is read from outside of the scene's folder", "[hostile]") {
  const Folder folder;
  folder.write("secret.scene.xml", "<scene/>");
  const std::string inside =
      folder.write("scenes/a.scene.xml", "<scene><import href='../secret.scene.xml'/></scene>");
  CHECK(codes(compile_file(inside)) == "CG0303");
  const std::string absolute =
      folder.write("scenes/b.scene.xml", "<scene><import href='/etc/passwd'/></scene>");
  CHECK(codes(compile_file(absolute)) == "CG0303");
  fs::create_symlink(folder.path / "secret.scene.xml", folder.path / "scenes" / "link.scene.xml");
  const std::string link =
      folder.write("scenes/c.scene.xml", "<scene><import href='link.scene.xml'/></scene>");
  CHECK(codes(compile_file(link)) == "CG0303");
  // A library folder gives access to the files below it.
  CompileOptions options;
  options.library_folders = {folder.path.string()};
  const std::string library =
      folder.write("scenes/d.scene.xml", "<scene><import href='secret.scene.xml'/></scene>");
  CHECK(codes(compile_file(library, options)) == "");
}

TEST_CASE_METHOD(Bounded, "no attribute that names a file reads one outside of the scene's folder",
                 "[hostile]") {
  const Folder folder;
  const std::string parts = std::string(COGRSIM_DSL_TEST_SCENES) + "/bad/parts/";
  const auto copy = [&](const std::string& from, const std::string& name) {
    fs::create_directories((folder.path / name).parent_path());
    fs::copy_file(from, folder.path / name, fs::copy_options::overwrite_existing);
  };
  const auto scene = [](const ElementSpec& element, const std::string& attributes) {
    std::string one = "<" + std::string(element.name);
    for (const AttributeSpec& a : element.attributes) {
      // A height field without heights needs a file.
      const bool other_file = a.kind == Kind::file && a.name == "file";
      if (!a.required && !other_file) continue;
      if (attributes.find(" " + std::string(a.name) + "=") == 0) continue;
      const std::string value = a.kind == Kind::name     ? "n"
                                : element.name == "mesh" ? "own.obj"
                                : a.kind == Kind::file   ? "own.pgm"
                                : a.min_count == 6       ? "0 0 1 0 0 1"
                                : a.min_count == 3       ? "1 1 1"
                                : a.min_count == 2       ? "1 1"
                                                         : "1";
      one += " " + std::string(a.name) + "=\"" + value + "\"";
    }
    one += attributes + ">" + (element.name == "maze" ? "\n+-+\n| |\n+-+\n" : "") + "</" +
           std::string(element.name) + ">";
    return "<scene name=\"a\" version=\"1\">" + one + "</scene>";
  };
  copy(parts + "tetrahedron.obj", "scenes/own.obj");
  folder.write("scenes/own.pgm", "P2 2 2 9 0 1 2 3\n");
  std::size_t attributes = 0;
  for (const ElementSpec& element : vocabulary()) {
    for (const AttributeSpec& a : element.attributes) {
      if (a.kind != Kind::file) continue;
      ++attributes;
      INFO("<" << element.name << " " << a.name << "=…>");
      const std::string kind = a.name == "texture"           ? "png"
                               : element.name == "mesh"      ? "obj"
                               : element.name == "heightmap" ? "pgm"
                                                             : "xml";
      const std::string good = "good." + kind, outside = (folder.path / "secret" / good).string();
      const auto content = [&](const std::string& name) {
        if (kind == "png") copy(COGRSIM_EXAMPLES "/045_eyes/textures/tiles.png", name);
        if (kind == "obj") copy(parts + "tetrahedron.obj", name);
        if (kind == "pgm") folder.write(name, "P2 2 2 9 0 1 2 3\n");
        if (kind == "xml") folder.write(name, "<scene name=\"b\" version=\"1\"/>");
      };
      content("scenes/" + good);
      content("secret/" + good);
      const fs::path scenes = folder.path / "scenes";
      for (const char* name : {"link", "folder_link", "zero", "pipe", "folder"})
        fs::remove_all(scenes / (name + ("." + kind)));
      fs::create_symlink(outside, scenes / ("link." + kind));
      fs::remove(scenes / "elsewhere");
      fs::create_symlink(folder.path / "secret", scenes / "elsewhere");
      fs::create_symlink("/dev/zero", scenes / ("zero." + kind));
      REQUIRE(::mkfifo((scenes / ("pipe." + kind)).c_str(), 0600) == 0);
      fs::create_directory(scenes / ("folder." + kind));
      const std::string mass = element.name == "mesh" ? " static=\"true\"" : "";
      const auto compiled = [&](const std::string& file) {
        const std::string value = " " + std::string(a.name) + "=\"" + file + "\"" + mass;
        return compile_file(folder.write("scenes/a.scene.xml", scene(element, value)));
      };
      // The refused file would be accepted beside the scene.
      const CompileResult taken = compiled(good);
      INFO(to_text(taken.diagnostics));
      CHECK(taken.ok());
      CHECK(taken.files_read.size() >= 2);
      const auto refused = [&](const std::string& file, const std::string& code) {
        const CompileResult result = compiled(file);
        INFO(file << "\n" << to_text(result.diagnostics));
        CHECK_FALSE(result.ok());
        CHECK(codes(result) == code);
        CHECK(result.files_read.size() + 1 == taken.files_read.size());
      };
      refused("../secret/" + good, "CG0303");
      refused("../../../../../../../../../../" + outside, "CG0303");
      refused("x/../../secret/" + good, "CG0303");
      refused(outside, "CG0303");
      refused("file://" + outside, "CG0303");
      refused("link." + kind, "CG0303");
      refused("elsewhere/" + good, "CG0303");
      refused("zero." + kind, "CG0303");
      refused("/dev/zero", "CG0303");
      refused("pipe." + kind, "CG0301");
      refused("folder." + kind, "CG0301");
      refused(".", "CG0301");
    }
  }
  CHECK(attributes > 10);
}
