// Hostile files end in a coded error, within bounded memory and time.
#include <sys/resource.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "../support/sanitizers.h"
#include "../support/temporary_folder.h"
#include "cogrsim/dsl/compiler.h"

namespace fs = std::filesystem;
using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

std::string codes(const CompileResult& result) {
  std::string out;
  for (const Diagnostic& d : result.diagnostics) out += (out.empty() ? "" : " ") + d.code;
  return out;
}

/// What a case may take beside what the program takes: beyond it an allocation fails, or SIGXCPU ends the program. The
/// processor's time, as that of the clock is the machine's affair; the longest case takes a twentieth of it.
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

struct Folder : test::TemporaryFolder {
  std::string write(const std::string& name, const std::string& text) const {
    const fs::path file = path / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file.string();
  }
};

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
  // Found by looking at each value's line to its end: 56 s for this file.
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
  // One line of 8 MB with a slip at its end.
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
  // A library folder opens what lies below it.
  CompileOptions options;
  options.library_folders = {folder.path.string()};
  const std::string library =
      folder.write("scenes/d.scene.xml", "<scene><import href='secret.scene.xml'/></scene>");
  CHECK(codes(compile_file(library, options)) == "");
}
