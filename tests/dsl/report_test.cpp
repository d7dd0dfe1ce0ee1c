// Diagnostics as text with a caret, JSON and SARIF; counted rather than repeated.
#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "cogrsim/dsl/compiler.h"

using namespace cogrsim;
using namespace cogrsim::dsl;

TEST_CASE("the text points at the source position, with trail and help", "[report]") {
  Diagnostic d;
  d.code = "CG0502";
  d.message = "expected an angle, found a length";
  d.file = "maze.scene.xml";
  d.line = 27;
  d.column = 39;
  d.length = 5;
  d.source_line = "    <camera name=\"eye\" on=\"mast\" fov=\"60 cm\"/>";
  d.notes.emplace_back("in instance 'bot' of prototype 'DiffBot'",
                       SourcePosition{"maze.scene.xml", 52, 5});
  d.help = "did you mean \"60 deg\"?";
  CHECK(to_text(d) ==
        "error[CG0502]: expected an angle, found a length\n"
        "  --> maze.scene.xml:27:39\n"
        "   |\n"
        "27 |     <camera name=\"eye\" on=\"mast\" fov=\"60 cm\"/>\n"
        "   |                                       ^^^^^\n"
        "   = in instance 'bot' of prototype 'DiffBot', maze.scene.xml:52:5\n"
        "help: did you mean \"60 deg\"?\n");
  CHECK(to_text(d, true).find("\x1b[1;31m") != std::string::npos);
}

TEST_CASE("the caret is right below tabs, umlauts and in long lines", "[report]") {
  Diagnostic d;
  d.code = "CG0501";
  d.message = "m";
  d.file = "f";
  d.line = 3;
  d.column = 4;
  d.length = 2;
  d.source_line = "\t\xC3\xA4\xC3\xA4xy";
  CHECK(to_text(d).find("\n3 | \t\xC3\xA4\xC3\xA4xy\n  | \t  ^^\n") != std::string::npos);
  d.source_line = std::string(1000, 'a');
  d.column = 500;
  CHECK(to_text(d).size() < 500);
}

TEST_CASE("a mistake in a prototype is reported once and counted", "[report]") {
  const auto result = compile_text(R"(<scene>
  <prototype name="P">
    <repeat count="4" var="i"> <box name="b_${i}" size="1 1 kg" mass="1" xyz="${9*i} 0 0"/> </repeat>
  </prototype>
  <instance of="P" name="one"/>
</scene>)",
                                   "t.scene.xml");
  REQUIRE(result.diagnostics.size() == 1);
  const Diagnostic& d = result.diagnostics[0];
  CHECK(d.line == 3);
  REQUIRE(d.notes.size() >= 2);
  CHECK(d.notes.back().message == "and 3 more");
}

TEST_CASE("JSON and SARIF can be read back", "[report]") {
  const auto result =
      compile_text("<scene>\n<link/>\n<sphere radius='1 kg'/><sphere radius='\xC3\xA4'/></scene>",
                   "a b/\xC3\xA4.scene.xml");
  REQUIRE(result.diagnostics.size() == 3);
  const auto json = nlohmann::json::parse(to_json(result.diagnostics));
  REQUIRE(json.size() == 3);
  CHECK(json[0]["code"] == "CG0201");
  CHECK(json[0]["severity"] == "error");
  CHECK(json[0]["line"] == 2);
  CHECK(json[0]["column"] == 2);
  CHECK(json[0]["help"] == "use <body>");
  const auto sarif = nlohmann::json::parse(to_sarif(result.diagnostics));
  CHECK(sarif["version"] == "2.1.0");
  const auto& run = sarif["runs"][0];
  CHECK(run["tool"]["driver"]["name"] == "cogrsim");
  REQUIRE(run["results"].size() == 3);
  for (const auto& r : run["results"]) {
    CHECK(run["tool"]["driver"]["rules"][r["ruleIndex"].get<int>()]["id"] == r["ruleId"]);
  }
  const auto& location = run["results"][0]["locations"][0]["physicalLocation"];
  CHECK(location["artifactLocation"]["uri"] == "a%20b/%C3%A4.scene.xml");
  CHECK(location["region"]["startLine"] == 2);
  CHECK(location["region"]["endColumn"] == 6);
  CHECK(nlohmann::json::parse(to_json({})).empty());
  CHECK(nlohmann::json::parse(to_sarif({}))["runs"][0]["results"].empty());
  // Bytes that are no UTF-8, as in a strange file name, are replaced.
  Diagnostic strange;
  strange.code = "CG0101";
  strange.file = "\xFF";
  CHECK_NOTHROW(nlohmann::json::parse(to_json({strange})));
}
