// cogrsim transfer and cogrsim policy import as a user meets them.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>

#include "../cli/process.h"
#include "policy_support.h"

using namespace cogrsim::test;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

Outcome transfer(const PolicyFolder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(),
                   {"transfer", folder.path("arm.policy.yaml"), "-b", "cogrsim", "-d", "2.5"});
  return cogrsim_run(arguments);
}

json table_of(const Outcome& outcome) {
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out);
}

}  // namespace

TEST_CASE("a policy's runs are counted per engine and command, with intervals", "[transfer]") {
  const PolicyFolder folder;
  const json table = table_of(
      transfer(folder, {"--seeds", "1..4", "--commands", "0.5 0 0.1; 0 0 0", "--json", "-"}));
  REQUIRE(table["rows"].size() == 2);
  CHECK(table["failures"].empty());
  for (const json& row : table["rows"]) {
    CHECK(row["backend"] == "cogrsim");
    CHECK(row["runs"] == 4);
    CHECK(row["stood"] == 4);
    // Wilson's bound of n of n: n/(n + z^2), z = 1.96.
    CHECK(row["share"]["low"].get<double>() == Approx(4 / (4 + 1.959964 * 1.959964)).epsilon(1e-6));
    CHECK(row["share"]["high"] == 1.0);
    CHECK(row["measures"]["fell_at"]["mean"].is_null());
    // It weighs 5.8 kg, and mostly rests.
    CHECK(row["measures"]["mean_force"]["mean"].get<double>() == Approx(5.8 * 9.81).epsilon(0.05));
    // The trunk does not walk: no way, no cost.
    CHECK(row["measures"]["cost_of_transport"]["mean"].is_null());
    CHECK(row["measures"]["upright"]["mean"] == 2.5);
    // Starts differ.
    CHECK(row["measures"]["peak_force"]["half_width"].get<double>() > 0.0);
  }
  const double asked = table["rows"][0]["measures"]["velocity_error"]["mean"],
               still = table["rows"][1]["measures"]["velocity_error"]["mean"];
  CHECK(asked == Approx(0.5).margin(0.05));
  CHECK(still < 0.05);
}

TEST_CASE("motors at the curves of the scene are at their limits", "[transfer]") {
  const auto share = [](const std::string& more) {
    const PolicyFolder folder;
    std::string robot = kRobot;
    const std::string limit = "max-torque=\"20 N*m\"";
    for (std::size_t at = robot.find(limit); at != std::string::npos;
         at = robot.find(limit, at + limit.size() + more.size()))
      robot.insert(at + limit.size(), more);
    folder.write("arm.scene.xml", robot);
    const json table = table_of(transfer(folder, {"--seeds", "1..2", "--json", "-"}));
    return table["rows"][0]["measures"]["at_limit"]["mean"].get<double>();
  };
  // 0.8 kg at some 5 cm need more than 0.01 N m to be held.
  CHECK(share(" stall-torque=\"0.01 N*m\" no-load-speed=\"1000 rad/s\"") > 0.5);
  CHECK(share("") < 0.1);
}

TEST_CASE("the table is the same on any number of workers, and a study goes on", "[transfer]") {
  const PolicyFolder folder;
  const std::string kept = folder.path("study");
  const std::vector<std::string> many = {"--seeds",        "1..5",   "--vary",
                                         "friction=0.5,1", "--json", "-"};
  auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), many.begin(), many.end());
    return transfer(folder, more);
  };
  const Outcome one = with({"-j", "1"}), three = with({"--jobs", "3"});
  CHECK(table_of(one) == table_of(three));
  CHECK(one.out == three.out);
  REQUIRE(transfer(folder, {"--seeds", "1..3", "--vary", "friction=0.5,1", "-o", kept}).status ==
          0);
  const Outcome more = with({"-o", kept});
  CHECK_THAT(more.err, Contains("6 of 10 runs are in the table already"));
  CHECK(more.out == one.out);
}

TEST_CASE("a robot that falls is a result, and a run without one is named", "[transfer]") {
  const PolicyFolder folder;
  // The trunk's middle is at 10 cm.
  const json fallen = table_of(
      transfer(folder, {"--seeds", "1..3", "--vary", "fallen.height=0.5 m", "--json", "-"}));
  CHECK(fallen["rows"][0]["stood"] == 0);
  CHECK(fallen["rows"][0]["share"]["low"] == 0.0);
  CHECK(fallen["rows"][0]["measures"]["fell_at"]["mean"].get<double>() < 0.01);
  CHECK(fallen["rows"][0]["measures"]["velocity_error"]["mean"].is_null());
  const Outcome given_up = cogrsim_run({"transfer", folder.path("arm.policy.yaml"), "-b", "cogrsim",
                                        "--seeds", "7", "-d", "100000", "--timeout", "0.3"});
  CHECK(given_up.status == 1);
  CHECK_THAT(given_up.out, Contains("seed 7, cogrsim: timeout: took longer than"));
  CHECK_THAT(given_up.out, Contains("0 of 0"));
}

#ifdef COGRSIM_TEST_RENDERER
TEST_CASE("the report shows a run of each row over time", "[transfer]") {
  const PolicyFolder folder;
  const std::string report = folder.path("arm.html");
  const auto written = [&](const std::string& pictures) {
    const Outcome outcome =
        transfer(folder, {"--seeds", "3,4", "--commands", "0.5 0 0.1; 0 0 0", "--pictures",
                          pictures, "--report", report, "--overwrite"});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    std::ifstream in(report);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const auto count = [](const std::string& text, const std::string& what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++found;
    return found;
  };
  const std::string page = written("4");
  CHECK(count(page, "<div class=\"strip\">") == 2);
  CHECK(count(page, "src=\"data:image/jpeg;base64,/9j/") == 8);
  for (const char* time : {"0.0 s", "0.8 s", "1.7 s", "2.5 s"})
    CHECK(count(page, std::string("<figcaption>") + time) == 2);
  CHECK_THAT(page, Contains("cogrsim, command 0.5 0 0.1") && Contains("seed 3"));
  CHECK(page.size() < 500'000);
  CHECK(count(written("0"), "<div class=\"strip\">") == 0);
  CHECK(transfer(folder, {"--seeds", "1", "--pictures", "13", "--report", report}).status == 2);
}
#endif

TEST_CASE("what is varied reaches card and robot", "[transfer]") {
  const PolicyFolder folder;
  const json table =
      table_of(transfer(folder, {"--seeds", "1..2", "--vary", "payload=0 kg,5 kg", "--json", "-"}));
  REQUIRE(table["rows"].size() == 2);
  for (int i = 0; i < 2; ++i)
    CHECK(table["rows"][i]["measures"]["mean_force"]["mean"].get<double>() ==
          Approx((5.8 + 5 * i) * 9.81).epsilon(0.05));
  const json pushed =
      table_of(transfer(folder, {"--seeds", "1..2", "--vary", "push=0 m/s,1 m/s", "--json", "-"}));
  CHECK(pushed["rows"][1]["measures"]["velocity_error"]["mean"].get<double>() !=
        pushed["rows"][0]["measures"]["velocity_error"]["mean"].get<double>());
  for (const auto& [wrong, said] : {std::pair("actions.dealy=1 ms", "did you mean 'delay'?"),
                                    {"payload=2 m", "no quantity in kg"},
                                    {"friction=-1", "below 0"},
                                    {"colour.of=2", "has no 'colour'"},
                                    {"observations.99=2", "could be set"},
                                    {"drives=never", "per-decision"}}) {
    const Outcome refused = transfer(folder, {"--seeds", "1", "--vary", wrong});
    INFO(wrong << "\n" << refused.err);
    CHECK(refused.status == 1);
    CHECK_THAT(refused.err, Contains(said));
  }
  CHECK(transfer(folder, {"--commands", "1 0"}).status == 1);
}

namespace {

// Two links, one on the other, which only the network holds upright: the gains alone are too small. Its
// inputs are positions of two decisions, the oldest first, and velocities with a mean and a scale.
constexpr const char* kBalance = R"(policy: 1
robot: arm.scene.xml
base: lower
network: net.onnx
step: 2 ms
rate: 100 Hz
joints: [elbow, wrist]
default-pose: 0 0 rad
observations:
  - joint-positions: {history: 2}
  - joint-velocities: {mean: 0.5, scale: 0.1}
actions: {kind: position, scale: 4, offset: default, kp: 0.6, kd: 0.02}
fallen: {tilt: 40 deg}
)";

// The first link weighs 1.37 N m/rad against gains of 0.6: the network adds 8 N m/rad, and damps by the
// difference of two positions. The second, 0.29 N m/rad, stands by its gains.
std::string balance_network() {
  OnnxWriter writer;
  const std::vector<float> w = {25.0f, 0, -28.3f, 0, -1.0f, 0,  //
                                0,     0, 0,      0, 0,     0};
  const std::vector<float> b = {-0.05f, 0.0f};
  return writer.input("obs", {1, 6})
      .output("actions", {1, 2})
      .constant("w", {2, 6}, w)
      .constant("b", {2}, b)
      .node("Gemm", {"obs", "w", "b"}, {"actions"}, {{"transB", 1}})
      .bytes();
}

}  // namespace

TEST_CASE("of two cards the fault of the one is named first", "[explain]") {
  const PolicyFolder folder;
  folder.write("net.onnx", balance_network());
  folder.write("good.policy.yaml", kBalance);
  struct Fault {
    const char *from, *to, *named;
  };
  for (const Fault& fault : {
           Fault{"[elbow, wrist]", "[wrist, elbow]", "joints"},
           Fault{"scale: 4", "scale: 0.02", "actions.scale"},
           Fault{"history: 2", "history: 2, scale: -1", "observations.joint-positions.scale"},
           Fault{"history: 2", "history: 2, newest-first: true",
                 "observations.joint-positions.newest-first"},
           Fault{"kd: 0.02", "kd: 0.02, delay: 200 ms", "actions.delay"},
           Fault{"kd: 0.02", "kd: 0.02, effort-limit: 0.005 N*m", "actions.effort-limit"},
       }) {
    std::string card = kBalance;
    card.replace(card.find(fault.from), std::string(fault.from).size(), fault.to);
    // Beside it, what changes nothing.
    card.replace(card.find("mean: 0.5,"), 10, "clip: 500, mean: 0.5,");
    folder.write("bad.policy.yaml", card + "observation-clip: 400\n");
    const Outcome outcome = cogrsim_run({"transfer", folder.path("bad.policy.yaml"), "--against",
                                         folder.path("good.policy.yaml"), "--to", "cogrsim",
                                         "--explain", "--seeds", "1..3", "-d", "3", "--json", "-"});
    INFO(fault.named << "\n" << outcome.err << outcome.out);
    REQUIRE(outcome.status == 0);
    const json found = json::parse(outcome.out);
    CHECK(found["stood"]["good"] == json({3, 3}));
    CHECK(found["stood"]["bad"] == json({0, 3}));
    REQUIRE(found["differences"].size() == 3);
    CHECK_THAT(found["differences"][0]["text"].get<std::string>(),
               Catch::Matchers::StartsWith(fault.named));
    CHECK(found["differences"][0]["stood_bad"] == json({3, 3}));
    CHECK_THAT(
        found["text"].get<std::string>(),
        Contains(std::string("Most is carried by ") + fault.named) &&
            Contains("with it 3 of 3 stand with bad.policy.yaml, where 0 of 3 stand without"));
    CHECK(found["differences"][2]["stood_bad"] == json({0, 3}));
  }
}

TEST_CASE("what differs between engines is ranked, and the first difference of runs is found",
          "[explain]") {
  const PolicyFolder folder;
  folder.write("net.onnx", balance_network());
  folder.write("arm.policy.yaml", kBalance);
  // The same engine twice: nothing to explain, and no number differs.
  const Outcome same = cogrsim_run({"transfer", folder.path("arm.policy.yaml"), "--from", "cogrsim",
                                    "--to", "cogrsim", "--explain", "--seeds", "1..3", "-d", "1"});
  INFO(same.err << same.out);
  CHECK(same.status == 0);
  CHECK_THAT(same.out, Contains("There is nothing to explain"));
  CHECK_THAT(same.out, Contains("differ by no more than other starts make them"));
  for (const auto& wrong :
       {std::vector<std::string>{"--explain"},
        {"--from", "cogrsim", "--to", "cogrsim"},
        {"--explain", "--from", "cogrsim", "--to", "cogrsim", "--seeds", "1"},
        {"--explain", "--from", "cogrsim", "--to", "cogrsim", "--vary", "friction=2"}}) {
    std::vector<std::string> arguments = {"transfer", folder.path("arm.policy.yaml")};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    CHECK(cogrsim_run(arguments).status == 2);
  }
}

TEST_CASE("an import writes a card, replaces nothing, and asks with a status of 1", "[import]") {
  const PolicyFolder folder;
  const std::string source = folder.path("arm.yaml"), card = folder.path("new.policy.yaml");
  folder.write("arm.yaml", R"(policy_path: "{LEGGED_GYM_ROOT_DIR}/motion.pt"
xml_path: "{LEGGED_GYM_ROOT_DIR}/arm.scene.xml"
simulation_dt: 0.002
control_decimation: 10
kps: [40, 30]
kds: [2, 2]
default_angles: [0.1, -0.2]
ang_vel_scale: 0.25
dof_pos_scale: 1.0
dof_vel_scale: 0.05
action_scale: 0.25
cmd_scale: [2.0, 2.0, 0.25]
num_actions: 2
num_obs: 17
)");
  OnnxWriter writer;
  writer.input("obs", {1, 17}).output("actions", {1, 2});
  writer.constant("w", {2, 17}, std::vector<float>(34, 0.01f));
  folder.write("seventeen.onnx",
               writer.node("Gemm", {"obs", "w"}, {"actions"}, {{"transB", 1}}).bytes());
  const auto import = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"policy", "import", source});
    return cogrsim_run(more);
  };
  const Outcome asked = import({"-o", card});
  CHECK(asked.status == 1);
  CHECK_THAT(asked.err, Contains("CG1514") && Contains("arm.yaml:1:14") && Contains("'fallen'"));
  const std::vector<std::string> answers = {
      "-o", card, "--network", folder.path("seventeen.onnx"), "--set", "fallen={height: 2 cm}"};
  const Outcome written = import(answers);
  INFO(written.err);
  CHECK(written.status == 0);
  CHECK(cogrsim_run({"policy", "check", card}).status == 0);
  const Outcome ran =
      cogrsim_run({"policy", "run", card, "-b", "cogrsim", "-d", "0.2", "--json", "-"});
  CHECK(json::parse(ran.out)["stood"] == true);
  // A card may have been edited since.
  const Outcome again = import(answers);
  CHECK(again.status != 0);
  CHECK_THAT(again.err, Contains("--overwrite"));
  auto over = answers;
  over.push_back("--overwrite");
  CHECK(import(over).status == 0);
  // What does not fit is written as it is, and told.
  over = {"-o", card, "--network", folder.path("net.onnx"), "--set", "fallen=~", "--overwrite"};
  const Outcome unfit = import(over);
  CHECK(unfit.status == 1);
  CHECK_THAT(unfit.err, Contains("CG1506") && Contains("20 values"));
  for (const auto& wrong : std::vector<std::vector<std::string>>{
           {"policy", "import", source},
           {"policy", "import", source, "-o", folder.path("a.yaml")},
           {"policy", "import", source, "-o", card, "--set", "x"},
           {"policy", "import", source, "-o", card, "--seed", "1"},
           {"policy", "check", card, "--json", "-"},
           {"policy", "check", card, card},
           {"policy", "run", card, "--robot", source}}) {
    INFO(wrong.back());
    CHECK(cogrsim_run(wrong).status == 2);
  }
  const Outcome outside =
      import({"-o", folder.path("study.policy.yaml"), "--network", "/bin/true"});
  CHECK(outside.status == 1);
}
