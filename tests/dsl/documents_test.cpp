// The schema and the reference page are generated from the tables, and good scenes obey the schema.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "../support/temporary_folder.h"
#include "cogrsim/dsl/compiler.h"
#include "cogrsim/physics/frame.h"
#include "fake_catalog.h"
#include "language/vocabulary.h"

namespace fs = std::filesystem;
using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

}  // namespace

TEST_CASE("the reference page is up to date", "[documents]") {
  const fs::path page = fs::path(COGRSIM_DOCS) / "scene-reference.md";
  if (std::getenv("COGRSIM_RENEW_EXPECTED")) std::ofstream(page) << write_reference_markdown();
  CHECK(read(page) == write_reference_markdown());
}

TEST_CASE("the pages describe every kind of event", "[documents]") {
  const std::string page = read(fs::path(COGRSIM_DOCS) / "changing-world.md");
  for (const EventKind& kind : kEventKinds) {
    INFO(kind.name);
    CHECK(page.find("`" + std::string(kind.name) + "`") != std::string::npos);
  }
}

TEST_CASE("the vocabulary is consistent", "[documents]") {
  for (const ElementSpec& e : vocabulary()) {
    INFO(e.name);
    CHECK((find_element(e.name) == &e || &contact_sensor() == &e));
    CHECK_FALSE(e.doc.empty());
    for (const auto child : e.children) {
      INFO(child);
      CHECK(find_element(child));
      CHECK(std::count(e.children.begin(), e.children.end(), child) == 1);
    }
    for (const AttributeSpec& a : e.attributes) {
      INFO(a.name);
      CHECK(e.find(a.name) == &a);  // no name twice
      CHECK_FALSE(a.doc.empty());
      CHECK_FALSE((a.required && !a.default_text.empty()));
      CHECK((a.kind == Kind::choice) == !a.choices.empty());
      if (a.kind == Kind::number || a.kind == Kind::numbers) CHECK_FALSE(a.dimensions.empty());
    }
    bool somewhere = e.name == "scene" || e.flow;
    for (const ElementSpec& p : vocabulary()) {
      for (const auto child : p.children) somewhere = somewhere || child == e.name;
    }
    CHECK(somewhere);
  }
}

TEST_CASE("good scenes compile and obey the schema", "[documents]") {
  dsl_test::FakeCatalog catalog;
  const test::TemporaryFolder folder;
  const fs::path schema = folder.path / "scene.xsd";
  std::ofstream(schema) << write_xsd(&catalog);
  int scenes = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(COGRSIM_DSL_TEST_SCENES) / "good")) {
    if (entry.path().extension() != ".xml") continue;
    ++scenes;
    INFO(entry.path());
    CompileOptions options;
    options.plugins = &catalog;
    const auto result = compile_file(entry.path().string(), options);
    CHECK(to_text(result.diagnostics) == "");
    CHECK(result.ok());
#ifdef COGRSIM_XMLLINT
    const std::string command = std::string(COGRSIM_XMLLINT) + " --noout --schema " +
                                schema.string() + " " + entry.path().string() + " > /dev/null 2>&1";
    CHECK(std::system(command.c_str()) == 0);
#endif
  }
  CHECK(scenes >= 2);
#ifdef COGRSIM_XMLLINT
  // The schema also refuses.
  for (const char* bad : {"CG0201_unknown_element", "CG0203_unknown_attribute",
                          "CG0204_missing_attribute", "CG0508_not_a_choice"}) {
    INFO(bad);
    const fs::path scene =
        fs::path(COGRSIM_DSL_TEST_SCENES) / "bad" / (std::string(bad) + ".scene.xml");
    const std::string command = std::string(COGRSIM_XMLLINT) + " --noout --schema " +
                                schema.string() + " " + scene.string() + " > /dev/null 2>&1";
    CHECK(std::system(command.c_str()) != 0);
  }
  // Without a catalog it is a valid schema, too.
  std::ofstream(schema) << write_xsd();
  const fs::path first = fs::path(COGRSIM_DSL_TEST_SCENES) / "good" / "first_steps.scene.xml";
  const std::string command = std::string(COGRSIM_XMLLINT) + " --noout --schema " +
                              schema.string() + " " + first.string() + " > /dev/null 2>&1";
  CHECK(std::system(command.c_str()) == 0);
#endif
}
