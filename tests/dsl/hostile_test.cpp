// Hostile files end in a coded error, within bounded memory and time.
#include <unistd.h>

#include <catch2/catch.hpp>

#include <cstdio>
#include <filesystem>
#include <fstream>

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

/// A folder of its own that goes away.
struct Folder {
  // Cases run side by side, in processes of their own.
  fs::path path = fs::temp_directory_path() / ("cogrsim-hostile-" + std::to_string(::getpid()));
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
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

TEST_CASE("a file of 100 MB is refused by its size", "[hostile]") {
  const Folder folder;
  const std::string path = folder.write("big.scene.xml", "<scene>");
  fs::resize_file(path, 100'000'000);  // sparse: nothing is written
  const auto result = compile_file(path);
  CHECK(codes(result) == "CG0108");
  CHECK(codes(compile_text(std::string((16u << 20) + 1, ' '), "big")) == "CG0108");
}

TEST_CASE("text and lists that double are bounded, one by one and in sum", "[hostile]") {
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

TEST_CASE("one long line is as good as many short ones", "[hostile]") {
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

TEST_CASE("billion laughs, external entities and other DOCTYPEs are refused", "[hostile]") {
  CHECK(codes(compile_text("<!DOCTYPE a [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><scene "
                           "name=\"&x;\"/>",
                           "x")) == "CG0107");
}

TEST_CASE("10,000 nested elements are refused", "[hostile]") {
  const std::string text =
      "<scene>" + repeated("<assembly>", 10000) + repeated("</assembly>", 10000) + "</scene>";
  CHECK(codes(compile_text(text, "deep")) == "CG0109");
  CHECK(codes(compile_text(repeated("<a>", 1000000), "deep")) == "CG0109");
}

TEST_CASE("floods of elements, attributes and errors are cut off", "[hostile]") {
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

TEST_CASE("expressions cannot run away", "[hostile]") {
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

TEST_CASE("files that import each other are refused", "[hostile]") {
  const Folder folder;
  const std::string a = folder.write("a.scene.xml", "<scene><import href='b.scene.xml'/></scene>");
  folder.write("b.scene.xml", "<scene><import href='a.scene.xml'/></scene>");
  CHECK(codes(compile_file(a)).find("CG0302") != std::string::npos);
}

TEST_CASE("files that import the next one twice are given up soon", "[hostile]") {
  const Folder folder;
  const auto name = [](int i) { return "f" + std::to_string(i) + ".scene.xml"; };
  for (int i = 0; i < 25; ++i) {
    folder.write(name(i), "<scene><import href='" + name(i + 1) + "' as='a'/><import href='" +
                              name(i + 1) + "' as='b'/></scene>");
  }
  folder.write(name(25), "<scene/>");
  CHECK(codes(compile_file((folder.path / name(0)).string())) == "CG0306");
}

TEST_CASE("nothing is read from outside of the scene's folder", "[hostile]") {
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
