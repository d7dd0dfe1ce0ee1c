// Text that XML 1.0 refuses is refused, and text that it allows is read, with exact positions.
#include <catch2/catch.hpp>

#include "report/diagnostics.h"
#include "syntax/element.h"
#include "syntax/node.h"
#include "values/reader.h"

using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

struct Parsed {
  CompileOptions options;
  DiagnosticSink sink{options.limits};
  SourceFiles files{options, sink};
  const Document* document = nullptr;
  explicit Parsed(const std::string& text) {
    document = files.open_scene_text(text, "t.scene.xml");
  }
};

std::string first_code(const std::string& text) {
  Parsed p(text);
  const auto found = p.sink.take();
  return found.empty() ? "" : found.front().code;
}

}  // namespace

TEST_CASE("well-formed documents are read", "[xml]") {
  for (const char* good :
       {"<scene/>", "<scene></scene>", "\xEF\xBB\xBF<scene/>",
        "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone='yes' ?>\n<scene/>\n",
        "<?xml version='1.0' encoding='utf-8'?><scene/>",
        "<!-- a --><?pi data?><scene  name = 'a&lt;b' ><!-- b --></scene ><!-- c -->\n",
        "<scene name=\"&#x41;&#66;&quot;\"/>", "<scene name='two\nlines'/>",
        "<scene xmlns:xsi='x' xsi:noNamespaceSchemaLocation='scene.xsd'/>",
        "<scene name='\xC3\xA4\xE2\x82\xAC\xF0\x9F\xA4\x96'/>", "<scene>\r\n  \r\n</scene>"}) {
    INFO(good);
    Parsed p(good);
    CHECK(to_text(p.sink.take()) == "");
    CHECK(p.document != nullptr);
  }
}

TEST_CASE("text that is not XML is refused", "[xml]") {
  const std::pair<const char*, const char*> cases[] = {
      {"", "CG0112"},
      {"   ", "CG0112"},
      {"hello", "CG0112"},
      {"<scene>", "CG0104"},
      {"<scene", "CG0104"},
      {"<scene/><scene/>", "CG0112"},
      {"<scene/>x", "CG0112"},
      {"x<scene/>", "CG0112"},
      {"<scene/><![CDATA[x]]>", "CG0112"},
      {"</scene>", "CG0104"},
      {"<scene></Scene>", "CG0104"},
      {"<scene a></scene>", "CG0103"},
      {"<scene a=1></scene>", "CG0103"},
      {"<scene a='1'b='2'/>", "CG0103"},
      {"<scene a='1' a='2'/>", "CG0105"},
      {"<scene a='<'/>", "CG0103"},
      {"<scene a='&'/>", "CG0103"},
      {"<scene a='&foo;'/>", "CG0106"},
      {"<scene a='&#0;'/>", "CG0106"},
      {"<scene a='&#xD800;'/>", "CG0106"},
      {"<scene a='&#x110000;'/>", "CG0106"},
      {"<scene a='&#;'/>", "CG0106"},
      {"<scene a='&#x;'/>", "CG0106"},
      {"<scene a='1/>", "CG0103"},
      {"<scene 1a='1'/>", "CG0103"},
      {"<1scene/>", "CG0103"},
      {"< scene/>", "CG0103"},
      {"<scene><!-- a -- b --></scene>", "CG0103"},
      {"<scene><!-- a</scene>", "CG0103"},
      {"<scene>]]></scene>", "CG0103"},
      {"<scene><![CDATA[</scene>", "CG0103"},
      {"<scene>& b</scene>", "CG0103"},
      {"<scene><?xml version='1.0'?></scene>", "CG0103"},
      {" <?xml version='1.0'?><scene/>", "CG0103"},
      {"<?xml?><scene/>", "CG0103"},
      {"<?xml encoding='UTF-8'?><scene/>", "CG0103"},
      {"<?xml version='1.1'?><scene/>", "CG0113"},
      {"<?xml version='1.0' encoding='UTF-16'?><scene/>", "CG0113"},
      {"<?xml version='1.0'", "CG0103"},
      {"<?pi", "CG0103"},
      {"<!DOCTYPE scene><scene/>", "CG0107"},
      {"<scene><!ENTITY a 'b'></scene>", "CG0107"},
      {"<scene a='\xFF'/>", "CG0102"},
      {"<scene a='\xC0\xAF'/>", "CG0102"},
      {"<scene a='\xED\xA0\x80'/>", "CG0102"},
      {"<scene a='\xF4\x90\x80\x80'/>", "CG0102"},
      {"<scene a='\x01'/>", "CG0102"},
      {"<scene a='\xEF\xBF\xBE'/>", "CG0102"},
      {"<scene a='\xE2\x82", "CG0102"},
      {"<scene></scene", "CG0103"},
      {"<scene><a/ ></scene>", "CG0103"}};
  for (const auto& [text, code] : cases) {
    INFO(text);
    CHECK(first_code(text) == code);
  }
  // A zero byte, which ends C's strings but not ours.
  CHECK(first_code(std::string("<scene/>\0<x/>", 13)) == "CG0102");
}

TEST_CASE("every beginning of a good scene is refused without a crash", "[xml]") {
  const std::string text =
      "<?xml version=\"1.0\"?><!-- c --><scene name='a &amp; b'><box name=\"\xC3\xA4\" "
      "size='1 1 1'/><![CDATA[ ]]></scene>";
  CHECK(first_code(text) == "");
  for (std::size_t n = 0; n + 1 < text.size(); ++n) {
    INFO(n);
    CHECK(first_code(text.substr(0, n)) != "");
  }
}

TEST_CASE("positions count code points, entities and line breaks included", "[xml]") {
  Parsed p(
      "<scene>\n  <!-- \xC3\xA4\xC3\xA4 --><view name='\xC3\xA4' xyz=\"0 &#48;\n 1\"/>\n</scene>");
  REQUIRE(p.document);
  const Node& view = *p.document->root->children.at(0);
  CHECK(view.span.line == 2);
  CHECK(view.span.column == 15);
  CHECK(view.span.length == 4);
  const Attribute& xyz = *view.find("xyz");
  CHECK(xyz.name_span.column == 29);
  CHECK(xyz.value_span.column == 34);
  CHECK(xyz.value == "0 0\n 1");
  const SourceSpan entity = p.files.span_in_value(xyz, 2, 1);
  CHECK(entity.line == 2);
  CHECK(entity.column == 36);
  CHECK(entity.length == 5);
  const SourceSpan next_line = p.files.span_in_value(xyz, 5, 1);
  CHECK(next_line.line == 3);
  CHECK(next_line.column == 2);
}

TEST_CASE("a file that cannot be read is a diagnostic", "[xml]") {
  const auto missing = compile_file("no/such/file.scene.xml");
  CHECK_FALSE(missing.ok());
  REQUIRE(missing.diagnostics.size() == 1);
  CHECK(missing.diagnostics[0].code == "CG0101");
  CHECK(missing.diagnostics[0].file == "no/such/file.scene.xml");
  const auto folder = compile_file(".");
  REQUIRE(folder.diagnostics.size() == 1);
  CHECK(folder.diagnostics[0].code == "CG0101");
}
