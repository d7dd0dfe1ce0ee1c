// Cards: what is read, and what is refused, at which place.
#include "cogrsim/policy/card.h"

#include <catch2/catch.hpp>

#include <set>

#include "cogrsim/dsl/compiler.h"
#include "policy_support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;

namespace {

struct Bad {
  const char *from, *to;  // in the good card
  const char* code;
  int line, column;
  const char* message;  // a part of it, or of its help
};

std::vector<Diagnostic> findings(const PolicyFolder& folder, const std::string& card) {
  std::vector<Diagnostic> found;
  folder.write("bad.policy.yaml", card);
  const auto read = read_policy_card(folder.path("bad.policy.yaml"), found);
  if (!read) return found;
  const auto network = PolicyNetwork::read(read->network);
  if (network) {
    const auto sizes = check_policy_network(*read, **network);
    found.insert(found.end(), sizes.begin(), sizes.end());
  }
  const dsl::CompileResult scene = dsl::compile_file(read->robot);
  REQUIRE(scene.model);
  find_policy_robot(*read, *scene.model, found);
  return found;
}

const std::vector<Bad> kBad = {
    {"rate: 100 Hz", "rate: [100 Hz", "CG1501", 0, 0, ""},
    {"rate: 100 Hz", "rate: &a 100 Hz\nstep: *a", "CG1501", 7, 7, "aliases"},
    {"rate: 100 Hz", "ratte: 100 Hz", "CG1502", 6, 1, "did you mean 'rate'"},
    {"- joint-velocities", "- joint-velocitys", "CG1502", 14, 5, "did you mean 'joint-velocities'"},
    {"kind: position", "kind: positions", "CG1502", 19, 10, "position, velocity, torque"},
    {"rate: 100 Hz", "rate: 100 m", "CG1503", 6, 7, "frequency"},
    {"rate: 100 Hz", "rate: 100 Hzz", "CG1503", 6, 7, "did you mean 'Hz'"},
    {"default-pose: 0.1 -0.2 rad", "default-pose: 0.1 -0.2", "CG1503", 8, 15, "needs its unit"},
    {"network: net.onnx", "network: ../net.onnx", "CG1503", 4, 10, "outside"},
    {"network: net.onnx", "network: /etc/passwd", "CG1503", 4, 10, "outside"},
    {"network: net.onnx", "network: nett.onnx", "CG1503", 4, 10, "no file"},
    {"{frame: base, scale: 2}", "", "CG1504", 10, 5, "'frame'"},
    {"offset: default, ", "", "CG1504", 19, 3, "offset"},
    {"rate: 100 Hz", "", "CG1504", 1, 1, "'rate'"},
    {"kd: 2}", "kd: 2, clip: 5}", "CG1504", 15, 5, "'clipped'"},
    {"[elbow, wrist]", "[elbow, wirst]", "CG1505", 7, 17, "did you mean 'wrist'"},
    {"base: trunk", "base: trunck", "CG1505", 3, 7, "did you mean 'trunk'"},
    {"kp: 40, kd: 2", "kp: 40 40 40, kd: 2", "CG1506", 19, 53, "3 entries for 2 joints"},
    {"  - joint-velocities\n", "", "CG1506", 10, 3, "joint-positions 2 + last-action 2"},
    {"[elbow, wrist]", "[elbow]", "CG1506", 0, 0, ""},
    {"kd: 2}", "kd: 2, stall-effort: 5 N*m}", "CG1504", 19, 3, "no-load-speed"},
    {"kd: 2}", "kd: 2, no-load-speed: 5 rad/s}", "CG1504", 19, 3, "stall-effort"},
    {"kd: 2}", "kd: 2, stall-effort: 5 N*m, no-load-speed: 0 rad/s}", "CG1503", 0, 0, "above 0"},
    {"kd: 2}", "kd: 2, stall-effort: 5 m, no-load-speed: 1 rad/s}", "CG1503", 0, 0, ""},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-limits: [1, 1]", "CG1503", 21, 17, "each of the 3"},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-limits: 1", "CG1503", 21, 17, "each of the 3"},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-limits: [1, 1, [1, 0]]", "CG1503", 21, 24, "lower"},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-limits: [0.4, 1, 1]", "CG1503", 21, 18, "0.5 is not within"},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-limits: [.inf, 1, 1]", "CG1503", 21, 18, ""},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-names: {a: m}", "CG1503", 21, 16, "each of the 3"},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-names: [a, b, c]", "CG1503", 21, 16, "each of the 3"},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-names: {a: m, b: ~, \"c\\a\": m}", "CG1503", 21, 29,
     "control"},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-names: {a: m, b: ~, \"\": m}", "CG1503", 21, 29, ""},
    {"0.5 0 0.1", "0.5 0 0.1\ncommand-names: {a: m, b: ~, a: m}", "CG1503", 21, 29, "of its own"},
    {"kp: 40, kd: 2", "", "CG1507", 7, 10, "positions"},
    {"0.1 -0.2 rad", "0.1 -3 rad", "CG1508", 8, 15, "limits"},
};

}  // namespace

TEST_CASE("the card of the tests is good", "[card]") {
  const PolicyFolder folder;
  std::vector<Diagnostic> found = findings(folder, kCard);
  INFO(dsl::to_text(found));
  CHECK(found.empty());
  found.clear();
  const auto card = read_policy_card(folder.path("bad.policy.yaml"), found);
  REQUIRE(card);
  CHECK(card->period == Approx(0.01));
  CHECK(card->pose == std::vector<double>{0.1, -0.2});
  CHECK(card->actions.kp == std::vector<double>{40, 40});
  CHECK(card->actions.offset == card->pose);
  CHECK(card->observed() == 20);
  CHECK(card->fallen_tilt == Approx(0.5235987755982988));
}

TEST_CASE("a command of more numbers than a run has inputs cannot be changed in it") {
  const PolicyFolder folder;
  std::string zeros = "0";
  for (int i = 0; i < 64; ++i) zeros += " 0";
  std::string card = kCard;
  const std::string from = "command: 0.5 0 0.1";
  card.replace(card.find(from), from.size(), "command: " + zeros + "\ncommand-limits: 1");
  const auto found = findings(folder, card);
  REQUIRE_FALSE(found.empty());
  CHECK(found[0].code == "CG1503");
  CHECK(found[0].line == 21);
  CHECK_THAT(found[0].message, Contains("65 numbers"));
}

TEST_CASE("bad cards are refused where they are wrong", "[card][bad]") {
  const PolicyFolder folder;
  for (const Bad& bad : kBad) {
    std::string card = kCard;
    const std::size_t at = card.find(bad.from);
    REQUIRE(at != std::string::npos);
    card.replace(at, std::string(bad.from).size(), bad.to);
    const std::vector<Diagnostic> found = findings(folder, card);
    INFO(bad.from << " -> " << bad.to << "\n" << dsl::to_text(found));
    REQUIRE_FALSE(found.empty());
    const Diagnostic& d = found.front();
    CHECK(d.code == bad.code);
    if (bad.line > 0) {
      CHECK(d.line == bad.line);
      CHECK(d.column == bad.column);
      CHECK_FALSE(d.source_line.empty());
    }
    CHECK_THAT(d.message + d.help, Contains(bad.message));
  }
}

TEST_CASE("every code of cards and networks is provoked and explained", "[card][bad]") {
  // Those of networks: network_test.cpp, of imports: import_test.cpp.
  std::set<std::string> shown = {"CG1510", "CG1511", "CG1512", "CG1513", "CG1514", "CG1515"};
  for (const Bad& bad : kBad) shown.insert(bad.code);
  std::set<std::string> codes;
  for (const std::string& code : dsl::diagnostic_codes())
    if (code.compare(0, 4, "CG15") == 0) codes.insert(code);
  CHECK(codes == shown);
}

TEST_CASE("hostile cards end in bounded time", "[card][hostile]") {
  const PolicyFolder folder;
  const auto code_of = [&](const std::string& text) {
    std::vector<Diagnostic> found;
    folder.write("bad.policy.yaml", text);
    CHECK_FALSE(read_policy_card(folder.path("bad.policy.yaml"), found));
    REQUIRE_FALSE(found.empty());
    return found.front().code;
  };
  std::string bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n";
  for (char c = 'b'; c < 'k'; ++c) {
    const std::string before = "*" + std::string(1, static_cast<char>(c - 1));
    bomb += std::string(1, c) + ": &" + c + " [" + before;
    for (int i = 0; i < 8; ++i) bomb += ", " + before;
    bomb += "]\n";
  }
  CHECK(code_of(bomb) == "CG1501");
  CHECK(code_of("a: " + std::string(100000, '[')) == "CG1501");
  CHECK(code_of(std::string(2u << 20, 'a')) == "CG1501");
  CHECK(code_of("") == "CG1501");
  CHECK(code_of("- a\n- b\n") == "CG1501");
  CHECK(code_of("a: \"\\xff\\x00\"\n? [x]\n: y\n") == "CG1502");
  CHECK(code_of(std::string("policy: 1\0\0", 11)) != "");
}
