// Input on the command line, and output on the terminal.
#include <fcntl.h>
#include <unistd.h>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "common/json_text.h"
#include "process.h"
#include "common/progress.h"
#include "common/quantities.h"
#include "compare/report_pictures.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "compare/zoom_chart.h"

using namespace cogrsim;
using namespace cogrsim::cli;

TEST_CASE("times are read with and without units", "[cli][quantities]") {
  CHECK(parse_time("0.001").value() == 0.001);
  CHECK(parse_time("1 ms").value() == Approx(1e-3));
  CHECK(parse_time(" 1.5ms ").value() == Approx(1.5e-3));
  CHECK(parse_time("2 s").value() == 2.0);
  CHECK(parse_time("2min").value() == 120.0);
  CHECK(parse_time("1e-3").value() == 1e-3);
  CHECK(parse_time("+3").value() == 3.0);
  CHECK(parse_time("-3 s").value() == -3.0);
  for (const char* wrong :
       {"", " ", "ms", "1,5", "1 kg", "1 deg", "nan", "inf", "0x10", "1 2", "--1", "+-1"}) {
    INFO(wrong);
    CHECK_FALSE(parse_time(wrong));
  }
}

TEST_CASE("thresholds are lengths or angles, an angle needs its unit", "[cli][quantities]") {
  const auto length = parse_length_or_angle("5 mm");
  REQUIRE(length);
  CHECK(length->value == Approx(5e-3));
  CHECK(length->dimension == Dimension::length);
  CHECK(parse_length_or_angle("0.25")->dimension == Dimension::length);
  const auto angle = parse_length_or_angle("180deg");
  REQUIRE(angle);
  CHECK(angle->value == Approx(3.14159265358979));
  CHECK(angle->dimension == Dimension::angle);
  CHECK_FALSE(parse_length_or_angle("1 s"));
  CHECK_FALSE(parse_length_or_angle("wide"));
}

TEST_CASE("settings keep all that follows the first equals sign", "[cli][quantities]") {
  CHECK(parse_setting("a=4 cm").value() == std::make_pair(std::string("a"), std::string("4 cm")));
  CHECK(parse_setting("t=a=b")->second == "a=b");
  CHECK(parse_setting("t=")->second.empty());
  CHECK_FALSE(parse_setting("a"));
  CHECK_FALSE(parse_setting("=3"));
}

TEST_CASE("figures get a fitting prefix and three digits", "[cli][text]") {
  CHECK(length_text(0.0) == "0 m");
  CHECK(length_text(0.012345) == "12.3 mm");
  CHECK(length_text(1.5) == "1.50 m");
  CHECK(length_text(2.5e-7) == "250 nm");
  CHECK(length_text(0.99999) == "1.00 m");
  CHECK(length_text(std::nan("")) == "-");
  CHECK(angle_text(3.14159265358979 / 2) == "90.0°");
  CHECK(step_text(0.001) == "1 ms");
  CHECK(step_text(0.0005) == "0.5 ms");
  CHECK(step_text(1.0 / 3.0) == "333.333 ms");
  CHECK(elapsed_text(123.4) == "2 min 03 s");
  CHECK(elapsed_text(7300.0) == "2 h 01 min");
}

TEST_CASE("tables line up by display width, not by bytes", "[cli][text]") {
  CHECK(display_width("µm °") == 4);
  CHECK(display_width("\033[1mbold\033[0m") == 4);
  CHECK(shortened("abcdef", 4) == "abc…");
  CHECK(shortened("abcd", 4) == "abcd");
  TextTable table({TextTable::Align::left, TextTable::Align::right});
  table.row({"name", "size"});
  table.row({"a", "1 µm"});
  table.row({"long name", "2"});
  CHECK(table.text("") == "name       size\na          1 µm\nlong name     2\n");
}

TEST_CASE("JSON figures have 17 digits, and numbers that are not finite are null", "[cli][json]") {
  Json value;
  value["third"] = 1.0 / 3.0;
  value["tenth"] = 0.1;
  value["one"] = 1.0;
  value["nan"] = std::nan("");
  value["inf"] = std::numeric_limits<double>::infinity();
  value["text"] = "a \"quoted\" <b>";
  value["broken"] = std::string("\xff");
  value["none"] = Json::array();
  const std::string text = json_text(value);
  CHECK_THAT(text, Catch::Contains("\"third\": 0.33333333333333331"));
  CHECK_THAT(text, Catch::Contains("\"tenth\": 0.10000000000000001"));
  CHECK_THAT(text, Catch::Contains("\"nan\": null"));
  CHECK_THAT(text, Catch::Contains("\"inf\": null"));
  const auto back = nlohmann::json::parse(text);
  CHECK(back["third"].get<double>() == 1.0 / 3.0);
  CHECK(back["text"] == "a \"quoted\" <b>");
  CHECK(json_text(to_json(Vec3(1, 2, 3))) == "[1, 2, 3]\n");
  CHECK(json_text(to_json(Quat(1, 0, 0, 0.5))) == "[1, 0, 0, 0.5]\n");
}

TEST_CASE("the progress line shows time, speed and what is left", "[cli][progress]") {
  const std::string line = progress_line("toy", 2.5, 10.0, 5.0, 100);
  CHECK_THAT(line, Catch::Contains("25 %") && Catch::Contains("2.50 s of 10 s"));
  CHECK_THAT(line, Catch::Contains("0.5x") && Catch::Contains("15.0 s left"));
  for (const int width : {10, 20, 40, 80, 200}) {
    CHECK(display_width(progress_line("a backend", 1.0, 3.0, 2.0, width)) <
          static_cast<std::size_t>(width));
  }
}

TEST_CASE("a chart escapes all text of the scene", "[cli][chart]") {
  Chart chart;
  chart.id = "test";
  chart.title = "<script>alert(1)</script>";
  chart.unit = "m";
  chart.times = {0.0, 1.0, 2.0};
  chart.curves.push_back({"a\"</script>", {0.0, std::nan(""), 0.5}});
  chart.may_be_log = true;
  const std::string html = chart_html(chart);
  CHECK(html.find("<script>alert") == std::string::npos);
  CHECK(html.find("</script>\"") == std::string::npos);
  CHECK_THAT(html, Catch::Contains("null") && Catch::Contains("\"mm\""));
  CHECK(html.find("nan") == std::string::npos);
}

TEST_CASE("base64 is that of RFC 4648", "[cli][report]") {
  // Section 10 of it.
  CHECK(base64("").empty());
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foob") == "Zm9vYg==");
  CHECK(base64("foobar") == "Zm9vYmFy");
  CHECK(base64("\xff\xfe") == "//4=");
}

TEST_CASE("text of plugins cannot steer the terminal", "[cli][text]") {
  CHECK(one_line("a\nerror: b\t\033[2J") ==
        "a\xEF\xBF\xBD"
        "error: b\xEF\xBF\xBD\xEF\xBF\xBD[2J");
  CHECK(paragraph("a\nerror: b\nhelp: c") == "a\n  error: b\n  help: c");
  CHECK(printable("plain\tä\n") == "plain\tä\n");
  CHECK(printable("a\033[31mb") == "a\xEF\xBF\xBD[31mb");
  CHECK(printable("a\xC2\x9B"
                  "31mb") ==
        "a\xEF\xBF\xBD"
        "31mb");
}

TEST_CASE("names of files cannot steer the terminal", "[cli][text]") {
  // A line of its own, a red one, one in C1, and letters from right to left.
  const std::string evil =
      "a\nerror: forged\033[31m\xC2\x9B"
      "31m\xE2\x80\xAE";
  const TemporaryFolder folder;
  const std::string scene = folder.write(
      evil + ".scene.xml", "<scene name=\"s\" version=\"1\"><box size=\"1\"/></scene>");
  const std::string robot = folder.write(
      evil + ".urdf", "<robot name=\"r\"><link name=\"l\"><mass/><inertial/></link></robot>");
  const std::string good =
      folder.write(evil + "_good.scene.xml",
                   "<scene name=\"s\" version=\"1\"><physics backend=\"toy\" duration=\"10 ms\"/>"
                   "<box size=\"1 1 1\"/></scene>");
  const std::string importing = folder.write(
      "importing.scene.xml",
      "<scene name=\"s\" version=\"1\"><import href=\"\xE2\x80\xAE\xC2\x9B.urdf\"/></scene>");
  folder.write("\xE2\x80\xAE\xC2\x9B.urdf", "<robot name=\"r\"><link/><joint/></robot>");
  const std::string table = folder.write(evil + ".csv", "a,b\n1\n");
  const std::string run = folder / (evil + ".mcap");
  const std::vector<std::vector<std::string>> commands = {
      {"check", scene},
      {"check", good},
      {"check", importing},
      {"check", folder / (evil + "_none.scene.xml")},
      {"run", scene},
      {"run", importing},
      {"run", good, "--record", run},
      {"info", run},
      {"replay", run},
      {"render", run, "-o", folder / (evil + ".png")},
      {"map", run, "-o", folder / (evil + ".svg")},
      {"compare", scene, "-b", "toy,toy_euler"},
      {"compare", good, "-b", "toy,toy_euler", "--report", folder / (evil + ".html")},
      {"test", scene},
      {"test", good},
      {"sweep", good, "--seeds", "1", "--backends", "toy", "-o", folder / (evil + "_out")},
      {"plot", table, "--kind", "histogram", "--x", "a", "-o", folder / "f.json"},
      {"bundle", good, "-o", folder / (evil + ".html")},
      {"bundle", scene, "-o", folder / "b.html"},
      {"import", robot, "-o", folder / (evil + "_robot.scene.xml")},
      {"import", scene},
      {"export", good, "-o", folder / (evil + "_out.urdf")},
      {"export", scene, "-o", folder / "e.urdf"},
      {"plugins", "--plugin-path", folder / evil},
  };
  const std::set<std::string> there = listed_commands();
  for (std::vector<std::string> command : commands) {
    if (there.count(command[0]) == 0) continue;
    INFO(command[0] << " " << command[1]);
    if (command[0] != "import" && command[0] != "plot" && command[0] != "map" &&
        command[0] != "info" && command[0] != "plugins")
      command.insert(command.end(), {"--plugin-path", COGRSIM_TOYS});
    const Outcome outcome = cogrsim_run(command);
    for (const std::string& text : {outcome.out, outcome.err}) {
      INFO(text);
      CHECK(printable(text) == text);
      CHECK(("\n" + text).find("\nerror: forged") == std::string::npos);
    }
  }
}

TEST_CASE("notes do not crowd out the errors of a run", "[cli][text]") {
  std::vector<RunMessage> messages(100);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    messages[i] = {0.001 * static_cast<double>(i), Severity::warning, "talker", "remark"};
  }
  messages[90] = {0.09, Severity::error, "arm", "fell asleep"};
  const TemporaryFolder folder;
  const int terminal = dup(STDERR_FILENO);
  const int file = open((folder / "err").c_str(), O_CREAT | O_WRONLY, 0600);
  dup2(file, STDERR_FILENO);
  print_messages(messages);
  dup2(terminal, STDERR_FILENO);
  close(file);
  close(terminal);
  const std::string printed = read_file(folder / "err");
  CHECK(printed.find("fell asleep") != std::string::npos);
  CHECK(printed.find("and 79 more messages") != std::string::npos);
}
