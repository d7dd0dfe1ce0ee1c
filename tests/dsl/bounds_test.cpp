// Any file of 100 kB is compiled or refused within 500 MB and 5 s of processor time. Each construct
// of the language is used as much as such a file allows: as often as it fits, in a repeat as often
// as the language allows, and with the longest allowed values.
// COGRSIM_COSTS_OF="lidar" in the environment shows the costs of those with that word, "" of all.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "../support/cost.h"
#include "../support/temporary_folder.h"
#include "cogrsim/dsl/compiler.h"
#include "fake_catalog.h"
#include "language/vocabulary.h"

using namespace cogrsim;
using namespace cogrsim::dsl;

namespace {

constexpr std::size_t kFileBytes = 100'000;

void check_cost(const std::string& construct, const std::string& text,
                const std::string& name = "bounds.scene.xml") {
  CHECK(text.size() < kFileBytes + 2000);
  cogrsim::test::check_cost(construct, [&] {
    dsl_test::FakeCatalog catalog;
    CompileOptions options;
    options.plugins = &catalog;
    const CompileResult result = compile_text(text, name, options);
    if (std::getenv("COGRSIM_COSTS_OF") != nullptr)
      std::printf("%-8s ", result.diagnostics.empty() ? "" : result.diagnostics[0].code.c_str());
    return result.ok() || !result.diagnostics.empty();
  });
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

/// `unit` until the file is full, "@" being the number of the repetition.
std::string filled(const std::string& unit, std::size_t bytes = kFileBytes) {
  std::string out;
  for (int i = 0; out.size() + unit.size() + 8 < bytes; ++i)
    out += replaced(unit, "@", std::to_string(i));
  return out;
}

std::string scene(const std::string& inside) {
  return "<scene name=\"b\" version=\"1\">" + inside + "</scene>";
}

// ---- from the language's own tables

/// Elements that others refer to.
const char* const kStage =
    "<material name=\"steel\"/><material name=\"wood\"/>"
    "<sphere name=\"base\" radius=\"1 cm\"/><sphere name=\"ball\" radius=\"1 cm\" xyz=\"1 0 0\"/>"
    "<hinge name=\"j\" parent=\"base\" child=\"ball\"/><motor name=\"m\" joint=\"j\"/>"
    "<pose name=\"p\" on=\"ball\"/><frame name=\"place\"/>"
    "<prototype name=\"P\"><sphere radius=\"1 cm\"/></prototype>"
    "<template name=\"T\"><sphere name=\"b\" radius=\"1 cm\"/></template>"
    "<door name=\"d\" size=\"1 0.1 1\" xyz=\"9 0 9\"/>";

/// A value that is valid on that stage.
std::string plain_value(const ElementSpec& element, const AttributeSpec& a) {
  const std::string_view name = a.name;
  if (name == "between") return element.name == "collide" ? "base ball" : "steel wood";
  if (name == "on" || name == "child") return "ball";
  if (name == "parent") return "base";
  if (name == "joint") return "j";
  if (name == "motor") return "m";
  if (name == "sensor") return "p";
  if (name == "door") return "d";
  if (name == "of")
    return element.name == "instance" ? "P" : element.name == "spawn" ? "T" : "ball";
  if (name == "at" || name == "frame") return "place";
  if (name == "plugin")
    return element.name == "sensor" ? "sonar" : element.name == "supervisor" ? "referee" : "walker";
  if (name == "that" || name == "when" || name == "if") return "ball.x gt 1 m";
  if (name == "signal" || name == "x" || name == "y") return "ball.x";
  if (name == "event") return element.name == "on" ? "start" : "n";
  if (name == "material" || name == "door-material") return "steel";
  if (name == "var") return "k";
  if (name == "test") return "1 gt 0";
  if (name == "seeds") return "1 .. 5";
  if (name == "in") return element.name == "for" ? "[1]" : "place";
  if (name == "name" &&
      (element.name == "remove" || element.name == "make-static" || element.name == "make-dynamic"))
    return "ball";
  if (!a.default_text.empty()) return std::string(a.default_text);
  switch (a.kind) {
    case Kind::name:
    case Kind::text:
      return "n_@";
    case Kind::reference:
    case Kind::references:
      return "ball";
    case Kind::boolean:
      return "true";
    case Kind::choice:
      return std::string(a.choices.front());
    case Kind::color:
      return "red";
    case Kind::file:
      return "none.obj";
    case Kind::range:
      return "1 .. 2 m";
    case Kind::noise:
      return "normal(0, 1)";
    case Kind::expression:
    case Kind::value:
    case Kind::integer:
      return "3";
    case Kind::number:
    case Kind::numbers: {
      std::string out;
      for (int i = 0; i < a.min_count; ++i) out += "0.5 ";
      const std::string unit = a.dimensions.empty() || a.per_entry ? "" : unit_of(a.dimensions[0]);
      return out + unit;
    }
  }
  return "1";
}

/// An element with its required attributes, and a name.
std::string opened(const ElementSpec& element, const std::string& more = {}) {
  std::string out = "<" + std::string(element.name);
  for (const AttributeSpec& a : element.attributes) {
    const bool named = a.name == "name" && a.kind == Kind::name;
    if ((!a.required && !named) || more.find(" " + std::string(a.name) + "=\"") == 0) continue;
    out += " " + std::string(a.name) + "=\"" + plain_value(element, a) + "\"";
  }
  return out + more + ">";
}

/// The elements around it, from the scene inwards.
std::vector<const ElementSpec*> path_to(const ElementSpec& element) {
  if (element.flow) return {};
  std::vector<std::vector<const ElementSpec*>> paths = {{find_element("scene")}};
  for (std::size_t i = 0; i < paths.size(); ++i) {
    for (const std::string_view child : paths[i].back()->children) {
      std::vector<const ElementSpec*> next = paths[i];
      if (child == element.name) {
        next.erase(next.begin());
        return next;
      }
      const ElementSpec* spec = find_element(child);
      if (spec == nullptr || next.size() > 3) continue;
      next.push_back(spec);
      paths.push_back(std::move(next));
    }
  }
  FAIL("no path to <" << element.name << ">");
  return {};
}

std::string inside_of(const std::vector<const ElementSpec*>& path, const std::string& content) {
  std::string before = kStage, after;
  for (const ElementSpec* around : path) {
    before += replaced(opened(*around), "@", "around");
    after = "</" + std::string(around->name) + ">" + after;
  }
  return scene(before + content + after);
}

std::string closed(const ElementSpec& element) { return "</" + std::string(element.name) + ">"; }

/// Texts of the longest kind, for any attribute.
std::vector<std::pair<std::string, std::string>> long_values(std::size_t bytes) {
  const auto of = [&](const std::string& begin, const std::string& unit, const std::string& end) {
    return begin + filled(unit, bytes) + end;
  };
  return {{"one word", std::string(bytes, 'a')},
          {"words", of("", "a ", "")},
          {"dotted", of("", "a.", "a")},
          {"numbers", of("", "1 ", "")},
          {"digits", std::string(bytes, '7')},
          {"units", of("", "1 m ", "")},
          {"a unit without end", of("1 ", "m*", "m")},
          {"entities", of("", "&amp;", "")},
          {"numbered characters", of("", "&#65;", "")},
          {"a sum", of("${", "1+", "1}")},
          {"many expressions", of("", "${1} ", "")},
          {"a list", of("${[", "1,", "1]}")},
          {"a text", "${'" + std::string(bytes, 'a') + "'}"},
          {"calls", of("", "normal(0, 1) ", "")},
          {"conditions", of("", "ball.x gt 1 m and ", "ball.x gt 1 m")},
          {"brackets", of("", "(", "1")},
          {"seeds", of("", "1 .. 99999 ", "")},
          {"blanks", std::string(bytes, ' ')}};
}

std::string tag(const ElementSpec& element) { return "<" + std::string(element.name) + ">"; }

}  // namespace

TEST_CASE("each element repeated in 100 kB is cheap", "[bounds]") {
  std::size_t tried = 0;
  for (const ElementSpec& element : vocabulary()) {
    if (element.name == "scene") continue;
    const auto path = path_to(element);
    const std::size_t space = kFileBytes - inside_of(path, "").size();
    check_cost(tag(element) + " one after the other",
               inside_of(path, filled(opened(element) + closed(element), space)));
    ++tried;
  }
  CHECK(tried > 70);
}

TEST_CASE("each element in a long repeat is cheap", "[bounds]") {
  check_cost("a repeat that is too long",
             scene("<repeat count=\"1000000\"><frame name=\"f${i}\"/></repeat>"));
  for (const ElementSpec& element : vocabulary()) {
    if (element.name == "scene") continue;
    const std::string one = replaced(opened(element) + closed(element), "@", "${i}");
    check_cost(tag(element) + " in a repeat",
               inside_of(path_to(element), "<repeat count=\"31000\">" + one + "</repeat>"));
    if (!element.children.empty())
      check_cost(tag(element) + " around a repeat",
                 inside_of(path_to(element),
                           replaced(opened(element), "@", "0") +
                               "<repeat count=\"31000\"><frame name=\"f${i}\"/></repeat>" +
                               closed(element)));
  }
}

TEST_CASE("each kind of attribute with the longest values is cheap", "[bounds]") {
  // The kind of an attribute determines how its value is read.
  std::set<Kind> done;
  for (const ElementSpec& element : vocabulary()) {
    for (const AttributeSpec& a : element.attributes) {
      if (element.name == "scene" || !done.insert(a.kind).second) continue;
      for (const auto& [what, value] : long_values(60'000)) {
        const std::string text = opened(element, " " + std::string(a.name) + "=\"" + value + "\"");
        check_cost(tag(element) + " " + std::string(a.name) + "= " + what,
                   inside_of(path_to(element), replaced(text, "@", "0") + closed(element)));
      }
    }
  }
  CHECK(done.size() >= 15);
}

TEST_CASE("each element whose values are long is cheap, once and in a repeat", "[bounds]") {
  for (const ElementSpec& element : vocabulary()) {
    if (element.name == "scene" || element.attributes.empty()) continue;
    const std::size_t space = 60'000 / element.attributes.size();
    const auto texts = long_values(space);
    std::string more;
    for (const AttributeSpec& a : element.attributes) {
      const char* what = a.kind == Kind::name || a.kind == Kind::reference   ? "one word"
                         : a.kind == Kind::references                        ? "words"
                         : a.kind == Kind::noise                             ? "calls"
                         : a.kind == Kind::text                              ? "conditions"
                         : a.kind == Kind::numbers || a.kind == Kind::number ? "numbers"
                                                                             : "a sum";
      const auto value = std::find_if(texts.begin(), texts.end(),
                                      [&](const auto& text) { return text.first == what; });
      more += " " + std::string(a.name) + "=\"" + value->second + "\"";
    }
    const std::string one = "<" + std::string(element.name) + more + ">" + closed(element);
    check_cost(tag(element) + " with long values", inside_of(path_to(element), one));
    check_cost(tag(element) + " with long values, again and again",
               inside_of(path_to(element), "<repeat count=\"31000\">" + one + "</repeat>"));
  }
}

TEST_CASE("scenes that multiply elements are bounded", "[bounds]") {
  const auto repeat = [](int count, const std::string& inside) {
    return "<repeat count=\"" + std::to_string(count) + "\">" + inside + "</repeat>";
  };
  const std::string long_name(60'000, 'n');
  const std::string sum = "1" + filled("+1", 60'000);
  std::string deep = "<box size=\"1 1 1\"/>", groups = "<box name=\"b\" size=\"1 1 1\"/>";
  for (int i = 0; i < 80; ++i) deep = repeat(3, deep);
  for (int i = 0; i < 85; ++i)
    groups = "<assembly name=\"" + std::string(1000, 'g') + "\">" + groups + "</assembly>";
  std::string chain = "<sphere name=\"b0\" radius=\"1 cm\"/>";
  for (int i = 1; chain.size() < kFileBytes - 200; ++i) {
    const std::string n = std::to_string(i), before = std::to_string(i - 1);
    chain += "<sphere name=\"b" + n + "\" radius=\"1 cm\"/><hinge parent=\"b" + before +
             "\" child=\"b" + n + "\"/>";
  }
  std::string frames = "<frame name=\"f0\"/>", params = "<param name=\"p0\" default=\"1\"/>";
  for (int i = 1; frames.size() < kFileBytes - 200; ++i)
    frames += "<frame name=\"f" + std::to_string(i) + "\" frame=\"f" + std::to_string(i - 1) +
              "\" xyz=\"1 0 0\"/>";
  for (int i = 1; params.size() < kFileBytes - 200; ++i)
    params += "<param name=\"p" + std::to_string(i) + "\" default=\"${p" + std::to_string(i - 1) +
              " + 1}\"/>";
  std::string list = "<param name=\"l0\" default=\"${[1]}\"/>";
  for (int i = 1; i <= 16; ++i)
    list += replaced("<param name=\"l" + std::to_string(i) + "\" default=\"${@ + @}\"/>", "@",
                     "l" + std::to_string(i - 1));
  // 180 x 80 cells; `side` and `floor` are one cell's, with the post or wall of the next.
  const auto maze = [](const std::string& side, const std::string& floor) {
    const auto row = [](const std::string& cell, char last) {
      std::string out;
      for (int i = 0; i < 180; ++i) out += cell;
      return out + last + "\n";
    };
    const std::string outline = row("+--", '+');
    std::string out = outline;
    for (int i = 0; i < 80; ++i) {
      std::string walls = row(side, '|');
      walls[0] = '|';
      out += walls + (i < 79 ? row(floor, '+') : outline);
    }
    return out;
  };
  const std::string named = filled("n_@ ", 60'000);
  const std::vector<std::pair<std::string, std::string>> constructs = {
      {"nested repeats", deep},
      {"nested assemblies with long names", groups},
      {"a long name again and again", repeat(124000, "<frame name=\"" + long_name + "_${i}\"/>")},
      {"names as long as are taken",
       repeat(124000, "<frame name=\"" + std::string(200, 'n') + "_${i}\"/>")},
      {"a long name around many", "<assembly name=\"" + long_name + "\">" +
                                      repeat(124000, "<frame name=\"f${i}\"/>") + "</assembly>"},
      {"a long expression again and again",
       repeat(124000, "<frame name=\"f${i}\" xyz=\"${" + sum + "} 0 0\"/>")},
      {"expressions as long as are taken",
       repeat(100000, "<frame name=\"f${i}\" xyz=\"${1" + filled("+1", 120) + "} 0 ${1" +
                          filled("+1", 120) + "}\"/>")},
      {"a long condition again and again",
       repeat(1000000, "<if test=\"" + sum + " lt 0\"><frame name=\"f\"/></if>")},
      {"many conditions in a round",
       repeat(124000, filled("<if test=\"false\"><frame/></if>", 60'000))},
      {"many parameters in a round",
       repeat(100000, "<assembly name=\"a${i}\">" +
                          filled("<param name=\"p@\" default=\"1\"/>", 60'000) + "</assembly>")},
      {"many prototypes in a round", repeat(100000, filled("<prototype name=\"P@\"/>", 60'000))},
      {"a long list made again and again",
       list + repeat(124000, "<frame name=\"f${i}\" xyz=\"${if(true, 1, l16 + l0)} 0 0\"/>")},
      {"a long list asked for again and again",
       list + repeat(124000, "<frame name=\"f${i}\" xyz=\"${if(true, 1, l16)} 0 0\"/>")},
      {"a long list as a value again and again",
       list + repeat(124000, "<box name=\"b${i}\" size=\"${l16}\"/>")},
      {"a long list for plugins",
       list + repeat(40000,
                     "<assembly name=\"a${i}\"><sphere radius=\"1\" xyz=\"${3 * i} 0 0\"/>"
                     "<controller plugin=\"walker\"><set path=\"${l16}\"/></controller>"
                     "</assembly>")},
      {"a long list as a text again and again",
       list + repeat(124000, "<box name=\"b${i}\" color=\"${l16}\" size=\"1 1 1\"/>")},
      {"a long text again and again",
       "<param name=\"t\" default=\"" + std::string(60'000, 't') + "\"/>" +
           repeat(124000, "<box name=\"b${i}\" color=\"${t}\" size=\"1 1 1\"/>")},
      {"a loop over a long list, nested", list +
                                              "<for var=\"a\" in=\"l16\"><for var=\"b\" in=\"l16\">"
                                              "<frame name=\"f_${a}_${b}\"/></for></for>"},
      {"a loop over a long list of nothing, nested",
       list + "<for var=\"a\" in=\"l16\"><for var=\"b\" in=\"l16\"></for></for>"},
      {"a long list given to many",
       list + "<prototype name=\"P\"><param name=\"p\"/><frame name=\"f\"/></prototype>" +
           repeat(80000, "<instance of=\"P\" name=\"i${i}\" p=\"${l16}\"/>")},
      {"empty repeats", repeat(1000000, repeat(1000000, ""))},
      {"untrue conditions", repeat(1000000, "<if test=\"false\"><frame name=\"f\"/></if>")},
      {"heights again and again",
       repeat(124000,
              "<heightmap name=\"h${i}\" size=\"1 1\" columns=\"2\" xyz=\"${2 * i} 0 0\" "
              "heights=\"" +
                  filled("1 ", 60'000) + "\"/>")},
      {"as many heights as are taken",
       repeat(400,
              "<heightmap name=\"h${i}\" size=\"1 1\" columns=\"2\" xyz=\"${2 * i} 0 0\" "
              "heights=\"" +
                  filled("1 ", 60'000) + "\"/>")},
      {"parameters that need each other", params},
      {"parameters with long values",
       filled("<param name=\"p@\" default=\"" + std::string(1000, 'x') + "\"/>")},
      {"unused parameters", filled("<param name=\"p@\" default=\"1\"/>")},
      {"expressions of many names among many",
       filled("<param name=\"p@\" default=\"1\"/>", 40'000) +
           repeat(124000,
                  "<frame name=\"f${i}\" xyz=\"${1" + filled("+p1000", 50'000) + "} 0 0\"/>")},
      {"expressions that miss a name among many",
       filled("<param name=\"p@\" default=\"1\"/>", 50'000) +
           filled("<frame name=\"f@\" xyz=\"${q} 0 0\"/>", 50'000)},
      {"instances with many parameters",
       "<prototype name=\"P\">" + filled("<param name=\"p@\" default=\"1\"/>", 15'000) +
           "<frame name=\"f\"/></prototype>" +
           repeat(80000, "<instance of=\"P\" name=\"i${i}\" " + filled("p@=\"2\" ", 4'000) + "/>")},
      {"a prototype in itself",
       "<prototype name=\"P\"><instance of=\"P\"/><instance of=\"P\"/></prototype>"
       "<instance of=\"P\"/>"},
      {"prototypes that double",
       [] {
         std::string out = "<prototype name=\"P0\"><box size=\"1 1 1\"/></prototype>";
         for (int i = 1; i < 60; ++i) {
           const std::string one = "<instance of=\"P" + std::to_string(i - 1) + "\"/>";
           out += "<prototype name=\"P" + std::to_string(i) + "\">" + one + one + "</prototype>";
         }
         return out + "<instance of=\"P59\"/>";
       }()},
      {"bodies at one position", repeat(124000, "<box name=\"b${i}\" size=\"1 1 1\"/>")},
      {"some bodies at one position", repeat(3000, "<box name=\"b${i}\" size=\"1 1 1\"/>")},
      {"some capsules at one position",
       repeat(3000, "<capsule name=\"b${i}\" radius=\"1\" length=\"1\"/>")},
      {"bodies in a row that overlap",
       repeat(60000, "<box name=\"b${i}\" size=\"1 1 1\" xyz=\"${0.6 * i} 0 0\"/>")},
      {"bodies of very different size",
       repeat(30000, "<box name=\"b${i}\" size=\"1 1 1\" xyz=\"${2 * i} 0 0\"/>") +
           repeat(3000, "<box name=\"c${i}\" size=\"100000 1 1\" xyz=\"0 ${3 * i} 0\"/>")},
      {"shapes of one body at one position",
       "<body name=\"one\">" + repeat(60000, "<box size=\"1 1 1\"/>") +
           "</body><body name=\"two\">" + repeat(60000, "<box size=\"1 1 1\"/>") + "</body>"},
      {"a chain of hinges", chain},
      {"a chain of hinges in a repeat",
       "<sphere name=\"b0\" radius=\"1 cm\"/>" +
           repeat(60000,
                  "<sphere name=\"b${i + 1}\" radius=\"1 cm\" xyz=\"${i + 1} 0 0\"/>"
                  "<hinge name=\"h${i}\" parent=\"b${i}\" child=\"b${i + 1}\"/>")},
      {"hinges between two bodies",
       "<sphere name=\"a\" radius=\"1\"/><sphere name=\"b\" radius=\"1\" xyz=\"3 0 0\"/>" +
           repeat(120000, "<hinge name=\"h${i}\" parent=\"a\" child=\"b\"/>")},
      {"loops of hinges",
       repeat(1000, "<sphere name=\"b${i}\" radius=\"1 cm\" xyz=\"${i} 0 0\"/>") +
           repeat(
               100000,
               "<hinge name=\"h${i}\" parent=\"b${i % 1000}\" child=\"b${(7 * i + 1) % 1000}\"/>")},
      {"hinges pressed by overlaps",
       "<sphere name=\"b0\" radius=\"1\"/>" +
           repeat(2000,
                  "<sphere name=\"b${i + 1}\" radius=\"1\"/>"
                  "<hinge name=\"h${i}\" parent=\"b${i}\" child=\"b${i + 1}\"/>")},
      {"frames on frames", frames},
      {"pairs of large assemblies", "<assembly name=\"a\">" +
                                        repeat(50000, "<sphere name=\"s${i}\" radius=\"1 cm\"/>") +
                                        "</assembly><assembly name=\"b\" xyz=\"9 0 0\">" +
                                        repeat(50000, "<sphere name=\"s${i}\" radius=\"1 cm\"/>") +
                                        "</assembly><collide between=\"a b\" with=\"false\"/>"},
      {"pairs of middling assemblies, many times",
       "<assembly name=\"a\">" + repeat(1000, "<sphere name=\"s${i}\" radius=\"1 cm\"/>") +
           "</assembly><assembly name=\"b\" xyz=\"9 0 0\">" +
           repeat(1000, "<sphere name=\"s${i}\" radius=\"1 cm\"/>") + "</assembly>" +
           repeat(124000, "<collide between=\"a b\" with=\"false\"/>")},
      {"pairs of materials",
       repeat(60000, "<material name=\"m${i}\"/>") +
           repeat(30000, "<contact between=\"m${i} m${59999 - i}\" friction=\"1\"/>")},
      {"scatters", repeat(10,
                          "<scatter name=\"s${i}\" count=\"10000\" area=\"30 30\" "
                          "xyz=\"${40 * i} 0 0\"><sphere name=\"x\" radius=\"1 cm\"/></scatter>")},
      {"a scatter with space for few",
       "<scatter name=\"s\" count=\"10000\" area=\"10 10\" clearance=\"5 cm\">"
       "<box name=\"x\" size=\"10 10 10 cm\"/></scatter>"},
      {"a scatter of assemblies",
       "<scatter name=\"s\" count=\"10000\" area=\"900 900\"><assembly name=\"x\">" +
           filled("<box name=\"b@\" size=\"10 10 10 cm\" xyz=\"@ 0 0\"/>", 500) +
           "</assembly></scatter>"},
      {"a maze of walls", "<maze name=\"m\" cell=\"1 m\">\n" + maze("|  ", "+--") + "</maze>"},
      {"a maze of cells", "<maze name=\"m\" cell=\"1 m\">\n" + maze("   ", "+  ") + "</maze>"},
      {"mazes as large as they may be", "<prototype name=\"P\"><maze name=\"m\" cell=\"1 m\">\n" +
                                            maze("|  ", "+--") + "</maze></prototype>" +
                                            repeat(100, "<instance of=\"P\" name=\"i${i}\"/>")},
      {"mazes again and again",
       "<prototype name=\"P\"><maze name=\"m\" cell=\"1 m\">\n+--+--+\n|     |\n+--+--+\n</maze>"
       "</prototype>" +
           repeat(8000, "<instance of=\"P\" name=\"i${i}\"/>")},
      {"doors", repeat(20000, "<door name=\"d${i}\" size=\"1 0.1 1\" xyz=\"${3 * i} 0 0\"/>")},
      {"regions that look for many",
       repeat(1000, "<sphere name=\"n_${i}\" radius=\"1 cm\" xyz=\"${i} 0 0\"/>") +
           repeat(20000,
                  "<region name=\"r${i}\" radius=\"1\" who=\"" + filled("n_@ ", 6'000) + "\"/>")},
      {"regions that detect unknown bodies",
       "<region name=\"r\" radius=\"1\" who=\"" + named + "\"/>"},
      {"plots of many signals",
       "<sphere name=\"ball\" radius=\"1\"/>" +
           repeat(10, "<plot name=\"p${i}\">" +
                          repeat(900, "<series y=\"" + filled("ball.x + ", 3'000) + "1 m\"/>") +
                          "</plot>")},
      {"tests with long conditions",
       "<sphere name=\"ball\" radius=\"1\"/>" +
           repeat(1500, "<test name=\"t${i}\"><always that=\"" +
                            filled("ball.x gt 1 m and ", 20'000) + "ball.x gt 2 m\"/></test>")},
      {"tests with seeds",
       repeat(1500,
              "<test name=\"t${i}\" seeds=\"1 .. 10000\"><expect that=\"time gt 0 s\"/></test>")},
      {"rules", "<sphere name=\"ball\" radius=\"1\"/>" +
                    repeat(25000, "<on when=\"ball.x gt 1 m\"><log message=\"" +
                                      std::string(1000, 'm') + "\"/></on>")},
      {"templates",
       repeat(80000, "<template name=\"T${i}\"><sphere name=\"b\" radius=\"1\"/></template>")},
      {"a template spawned often",
       "<template name=\"T\">" +
           repeat(40000, "<sphere name=\"b${i}\" radius=\"1\" xyz=\"${3 * i} 0 0\"/>") +
           "</template>" + repeat(40000, "<on time=\"1 s\"><spawn of=\"T\"/></on>")},
      {"lidars", "<sphere name=\"ball\" radius=\"1\"/>" +
                     repeat(124000, "<lidar name=\"l${i}\" on=\"ball\" rays=\"10000\"/>")},
      {"a lidar of many rings",
       "<sphere name=\"ball\" radius=\"1\"/>"
       "<lidar name=\"l\" on=\"ball\" rays=\"1000000\" rings=\"10000\"/>"},
      {"cameras", "<sphere name=\"ball\" radius=\"1\"/>" +
                      repeat(124000, "<camera name=\"c${i}\" on=\"ball\" resolution=\"9 9\"/>")},
      {"noise of many terms", "<sphere name=\"ball\" radius=\"1\"/>" +
                                  repeat(100000, "<pose name=\"p${i}\" on=\"ball\" noise=\"" +
                                                     filled("normal(0, 1 mm) ", 50'000) + "\"/>")},
      {"controllers", repeat(12000,
                             "<assembly name=\"a${i}\"><sphere radius=\"1\" xyz=\"${3 * i} 0 0\"/>"
                             "<controller plugin=\"walker\"><set path=\"" +
                                 filled("1 ", 2'000) + "\"/></controller></assembly>")},
      {"bodies with one material each",
       repeat(100000,
              "<box name=\"b${i}\" size=\"1 1 1\" xyz=\"${2 * i} 0 0\" friction=\"${i}\"/>")},
      {"names that are taken", repeat(124000, "<frame name=\"f\"/>")},
      {"names that are not there", repeat(60000, "<frame name=\"f${i}\"/>") +
                                       repeat(60000, "<pose name=\"p${i}\" on=\"g${i}\"/>")},
      {"unknown elements", filled("<a/>")},
      {"unknown attributes", filled("<frame name=\"f@\" " + filled("a@=\"1\" ", 3'000) + "/>")},
      {"comments", filled("<!-- -->")},
      {"instructions", filled("<?a b?>")},
      {"sections", filled("<![CDATA[a]]>")},
      {"text", filled("a &amp; ")},
      {"nested sections", filled("<![CDATA[")},
      {"tags that do not match", filled("<box></sphere>")},
      {"one word without end", std::string(kFileBytes, 'a')},
      {"characters of many bytes", filled("<frame name=\"\xF0\x9F\xA4\x96\"/>")},
  };
  CHECK(constructs.size() > 60);
  for (const auto& [name, text] : constructs) check_cost(name, scene(text));
}

TEST_CASE("files that a scene names many times are cheap", "[bounds]") {
  const cogrsim::test::TemporaryFolder folder;
  std::string obj, faces;
  // A cone of 1500 sides.
  for (int i = 0; obj.size() + faces.size() < kFileBytes - 100; ++i) {
    const double angle = 0.004 * i;
    obj += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
    if (i > 0) faces += "f 1 " + std::to_string(i + 1) + " " + std::to_string(i) + "\n";
  }
  folder.write("cone.obj", "v 0 0 1\n" + obj + faces);
  folder.write("hill.pgm", "P2 200 200 9\n" + filled("1 ", 80'100));
  folder.write("part.scene.xml", scene("<prototype name=\"P\">" +
                                       filled("<frame name=\"f@\"/>", 99'000) + "</prototype>"));
  const auto repeat = [](const std::string& inside) {
    return scene("<repeat count=\"124000\">" + inside + "</repeat>");
  };
  const std::string name = folder / "bounds.scene.xml";
  check_cost("a mesh again and again",
             repeat("<mesh name=\"m${i}\" file=\"cone.obj\" mass=\"1\" xyz=\"${3 * i} 0 0\"/>"),
             name);
  check_cost("a convex mesh again and again, of any scale",
             repeat("<mesh name=\"m${i}\" file=\"cone.obj\" convex=\"true\" scale=\"${1 + i}\"/>"),
             name);
  check_cost(
      "a height field again and again",
      repeat("<heightmap name=\"m${i}\" file=\"hill.pgm\" size=\"1 1\" xyz=\"${3 * i} 0 0\"/>"),
      name);
  check_cost("an import again and again",
             scene(filled("<import href=\"part.scene.xml\" as=\"a@\"/>")), name);
  check_cost("an import's prototype again and again",
             scene("<import href=\"part.scene.xml\"/><repeat count=\"124000\"><instance of=\"P\"/>"
                   "</repeat>"),
             name);
}
