// `cogrsim test` as a user runs it.
#include <sys/wait.h>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <tinyxml2.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../support/temporary_folder.h"

namespace fs = std::filesystem;

namespace {

struct Outcome {
  int status = -1;
  std::string text;
};

struct Folder : cogrsim::test::TemporaryFolder {
  Outcome run(const std::string& arguments) const {
    const std::string command =
        "cd " + path.string() + " && " COGRSIM_PROGRAM " test " + arguments + " 2>&1";
    Outcome out;
    FILE* pipe = popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    char buffer[4096];
    for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;)
      out.text.append(buffer, n);
    out.status = WEXITSTATUS(pclose(pipe));
    return out;
  }
};

// A ball in free fall from 1 m.
std::string scene(const std::string& tests) {
  return "<scene name=\"fall\" version=\"1\">\n"
         "  <physics step=\"1 ms\" duration=\"200 ms\"/>\n"
         "  <sphere name=\"ball\" radius=\"10 cm\" mass=\"1 kg\" xyz=\"0 0 1\"/>\n" +
         tests + "</scene>\n";
}

const char* kGood =
    "  <test name=\"falls\" seeds=\"1 .. 2\"><always that=\"ball.z le 1 m\"/>\n"
    "    <agree on=\"ball.position\" tolerance=\"1 mm\"/></test>\n";
const char* kBad =
    "  <test name=\"hovers\" backends=\"bullet\">\n"
    "    <always that=\"ball.z gt 90 cm\"/></test>\n";

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The report of `--junit r.xml`.
void load(const Folder& folder, tinyxml2::XMLDocument& xml) {
  REQUIRE(xml.LoadFile((folder.path / "r.xml").string().c_str()) == tinyxml2::XML_SUCCESS);
}

}  // namespace

TEST_CASE("tests that pass are printed in order and end with status 0", "[command]") {
  const Folder folder;
  folder.write("a.scene.xml", scene(kGood));
  folder.write("b.scene.xml", scene(""));
  const Outcome out = folder.run(". --jobs 4 --backends bullet,cogrsim");
  INFO(out.text);
  CHECK(out.status == 0);
  // Two backends and the two in lockstep, with two seeds each.
  CHECK(has(out.text, "6 cases: 6 passed, 0 failed"));
  CHECK(has(out.text, "b.scene.xml: the scene has no tests"));
  std::size_t last = 0;
  for (const char* title : {"falls [bullet, seed 1]", "falls [bullet, seed 2]",
                            "falls [cogrsim, seed 1]", "falls [cogrsim, seed 2]",
                            "falls [bullet+cogrsim, seed 1]", "falls [bullet+cogrsim, seed 2]"}) {
    const auto at = out.text.find(title);
    INFO(title);
    REQUIRE(at != std::string::npos);
    CHECK(at >= last);
    last = at;
  }
  CHECK_FALSE(fs::exists(folder.path / "cogrsim-tests"));
}

TEST_CASE("a failure names its line and values and how to see it again", "[command]") {
  const Folder folder;
  folder.write("a.scene.xml", scene(kBad));
  const Outcome out = folder.run("a.scene.xml --junit r.xml --seeds 7 -o cogrsim-tests");
  INFO(out.text);
  CHECK(out.status == 1);
  CHECK(has(out.text, "FAIL  a.scene.xml: hovers [bullet, seed 7]"));
  CHECK(has(out.text, "a.scene.xml:5:6: always ball.z gt 90 cm\n"));
  // z = 1 - g t^2 / 2 falls below 0.9 at 142.8 ms; steps are 1 ms.
  CHECK(has(out.text, "does not hold at 0.143 s"));
  CHECK(has(out.text, "time [s]  ball.z [m]"));
  CHECK(has(out.text, "recording: cogrsim-tests/a.hovers.bullet.seed7.mcap"));
  CHECK(fs::file_size(folder.path / "cogrsim-tests/a.hovers.bullet.seed7.mcap") > 1000);
  const std::string again = "a.scene.xml --filter hovers --backends bullet --seeds 7";
  REQUIRE(has(out.text, "again: cogrsim test " + again + "\n"));
  const Outcome same = folder.run(again);
  CHECK(same.status == 1);
  CHECK(has(same.text, "1 case: 0 passed, 1 failed"));

  tinyxml2::XMLDocument xml;
  load(folder, xml);
  const auto* suites = xml.RootElement();
  CHECK(std::string(suites->Name()) == "testsuites");
  const auto* suite = suites->FirstChildElement("testsuite");
  REQUIRE(suite != nullptr);
  CHECK(std::string(suite->Attribute("name")) == "a.scene.xml");
  CHECK(suite->IntAttribute("tests") == 1);
  CHECK(suite->IntAttribute("failures") == 1);
  CHECK(suite->IntAttribute("errors") == 0);
  const auto* one = suite->FirstChildElement("testcase");
  REQUIRE(one != nullptr);
  CHECK(std::string(one->Attribute("name")) == "hovers [bullet, seed 7]");
  CHECK(std::string(one->Attribute("classname")) == "a.scene.xml");
  CHECK(one->IntAttribute("line") == 5);
  CHECK(one->FindAttribute("time") != nullptr);
  const auto* failure = one->FirstChildElement("failure");
  REQUIRE(failure != nullptr);
  CHECK(has(failure->Attribute("message"), "does not hold at 0.143 s"));
  CHECK(has(failure->GetText(), "ball.z [m]"));
}

TEST_CASE("JSON has the same results", "[command]") {
  const Folder folder;
  folder.write("a.scene.xml", scene(kBad));
  const Outcome out = folder.run("a.scene.xml --json");
  const auto json = nlohmann::json::parse(out.text);
  CHECK(json["failed"] == 1);
  CHECK(json["cases"][0]["status"] == "failed");
  CHECK(json["cases"][0]["verdicts"][0]["line"] == 5);
  CHECK(json["cases"][0]["verdicts"][0]["time"].get<double>() == Approx(0.143));
}

TEST_CASE("a case that crashes or hangs fails and the others continue", "[command]") {
  const Folder folder;
  const std::string toys = " --plugin-path " + std::string(COGRSIM_TOYS);
  const auto with_rascal = [](const std::string& does) {
    return scene(
        "  <assembly name=\"bot\" xyz=\"1 0 1\">\n"
        "    <box name=\"hull\" size=\"10 10 10 cm\" mass=\"1 kg\"/>\n"
        "    <controller plugin=\"rascal\" rate=\"100 Hz\"><set does=\"" +
        does + "\"/></controller>\n  </assembly>\n" + kGood);
  };
  folder.write("a.scene.xml", with_rascal("crash"));
  const Outcome crash = folder.run("a.scene.xml --junit r.xml --backends bullet" + toys);
  INFO(crash.text);
  CHECK(crash.status == 1);
  CHECK(has(crash.text, "crashed: signal 6, Aborted"));
  CHECK(has(crash.text, "2 cases: 0 passed, 2 failed"));
  tinyxml2::XMLDocument xml;
  load(folder, xml);
  const auto* suite = xml.RootElement()->FirstChildElement("testsuite");
  CHECK(suite->IntAttribute("errors") == 2);
  CHECK(suite->FirstChildElement("testcase")->FirstChildElement("error") != nullptr);

  folder.write("a.scene.xml", with_rascal("hang"));
  const Outcome hang = folder.run("a.scene.xml --timeout 500ms --backends bullet --seeds 1" + toys);
  INFO(hang.text);
  CHECK(hang.status == 1);
  CHECK(has(hang.text, "was ended after 0.5 s, see --timeout"));
}

TEST_CASE("a controller that crashed is reported although the test passes", "[command]") {
  const Folder folder;
  folder.write("a.scene.xml",
               scene("  <assembly name=\"bot\" xyz=\"1 0 1\">\n"
                     "    <box name=\"hull\" size=\"10 10 10 cm\" mass=\"1 kg\"/>\n"
                     "    <controller plugin=\"rascal\" rate=\"100 Hz\" "
                     "isolation=\"process\"><set does=\"crash\"/></controller>\n"
                     "  </assembly>\n"
                     "  <test name=\"falls\"><always that=\"ball.z le 1 m\"/></test>\n"));
  const Outcome out = folder.run("a.scene.xml --backends bullet --junit r.xml --plugin-path " +
                                 std::string(COGRSIM_TOYS));
  INFO(out.text);
  CHECK(out.status == 0);
  CHECK(has(out.text, "ok "));
  CHECK(has(out.text, "crashed (SIGABRT) in update"));
  tinyxml2::XMLDocument xml;
  load(folder, xml);
  const auto* one =
      xml.RootElement()->FirstChildElement("testsuite")->FirstChildElement("testcase");
  REQUIRE(one->FirstChildElement("system-err") != nullptr);
  CHECK(has(one->FirstChildElement("system-err")->GetText(), "crashed (SIGABRT)"));
}

TEST_CASE("of very many errors the first are printed, and the number of the others", "[command]") {
  const Folder folder;
  std::string robots;
  for (int i = 2; i < 25; ++i) {
    const std::string n = std::to_string(i);
    robots +=
        "  <assembly name=\"bot" + n + "\" xyz=\"" + n + " 0 1\">\n" +
        "    <box name=\"hull\" size=\"10 10 10 cm\" mass=\"1 kg\"/>\n"
        "    <controller plugin=\"rascal\" rate=\"100 Hz\"><set does=\"throw\"/></controller>\n"
        "  </assembly>\n";
  }
  folder.write("a.scene.xml",
               scene(robots + "  <test name=\"falls\"><always that=\"ball.z le 1 m\"/></test>\n"));
  const Outcome out =
      folder.run("a.scene.xml --backends bullet --plugin-path " + std::string(COGRSIM_TOYS));
  INFO(out.text);
  CHECK(out.status == 0);
  CHECK(has(out.text, "'rascal' of 'bot2'"));
  CHECK(has(out.text, "error: and 3 more, see cogrsim run --json"));
}

TEST_CASE("wrong arguments and scenes are reported", "[command]") {
  const Folder folder;
  folder.write("a.scene.xml", scene(kGood));
  folder.write("broken.scene.xml", "<scene><bxo/></scene>");
  CHECK(folder.run("a.scene.xml --seeds x").status == 2);
  CHECK(folder.run("a.scene.xml --timeout 0s").status == 2);
  CHECK(folder.run("").status == 2);
  const Outcome none = folder.run("a.scene.xml --filter nothing");
  CHECK(none.status == 1);
  CHECK(has(none.text, "no test has 'nothing' in its name"));
  const Outcome broken = folder.run("broken.scene.xml");
  CHECK(broken.status == 1);
  CHECK(has(broken.text, "broken.scene.xml: compiles"));
  CHECK(has(broken.text, "bxo"));
  const Outcome unknown = folder.run("a.scene.xml --backends nowhere");
  CHECK(unknown.status == 1);
  CHECK(has(unknown.text, "nowhere"));
}

TEST_CASE("a scene whose plugin is not here fails where it asks for tests", "[command]") {
  const Folder folder;
  const std::string robot =
      "  <assembly name=\"robot\"><sphere name=\"s\" radius=\"10 cm\"/>\n"
      "    <controller plugin=\"not_built_yet\"><set speed=\"1 m/s\"/></controller></assembly>\n";
  folder.write("none.scene.xml", scene(robot));
  const Outcome none = folder.run("none.scene.xml");
  INFO(none.text);
  CHECK(none.text.find("the scene has no tests, and its plugins are not here") !=
        std::string::npos);
  CHECK(none.text.find("CG0909") == std::string::npos);
  folder.write("asks.scene.xml", scene(robot + kGood));
  const Outcome asks = folder.run("asks.scene.xml");
  INFO(asks.text);
  CHECK(asks.status == 1);
  CHECK(asks.text.find("CG0901") != std::string::npos);
  // What else is wrong counts.
  folder.write("wrong.scene.xml", scene(robot + "  <sphere name=\"b\" radius=\"10 deg\"/>\n"));
  const Outcome wrong = folder.run("wrong.scene.xml");
  INFO(wrong.text);
  CHECK(wrong.status == 1);
  CHECK(wrong.text.find("CG0502") != std::string::npos);
}
