// Backends that are programs of their own: found, described, stepped, and named when they fail.
#include <sys/syscall.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <catch2/catch.hpp>

#include "../support/temporary_folder.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim {
namespace {

using Catch::Matchers::Contains;
namespace fs = std::filesystem;

constexpr const char* kManifest =
    R"({"name": "rascal", "engine": "Rascal", "protocol": 1, "patience": 2,
        "command": ["python3", "rascal.py"]})";

/// A folder of plugins with the adapter rascal, which misbehaves as `fault` says.
struct Rascals : test::TemporaryFolder {
  explicit Rascals(const std::string& fault) {
    write("rascal/backend.json", kManifest);
    write("rascal/fault", fault);
    fs::copy_file(COGRSIM_TEST_ADAPTER, *this / "rascal/rascal.py");
    fs::copy_file(fs::path(COGRSIM_ADAPTER_LIBRARIES) / "cogrsim_backend.py",
                  *this / "rascal/cogrsim_backend.py");
  }
  /// On a busy machine Python may take longer to start than what is hung is waited for.
  void be_patient() const {
    std::string manifest = kManifest;
    manifest.replace(manifest.find("2,"), 1, "60");
    write("rascal/backend.json", manifest);
  }
  void behave() const { write("rascal/fault", "none none"); }
  Result<std::shared_ptr<const Backend>> backend() const {
    return PluginLoader({path.string()}).backend("rascal");
  }
};

SceneModelPtr two_bodies() {
  ModelBuilder builder;
  for (const char* name : {"ball", "box"}) {
    const int b = builder.body(name, 1.0, Mat3::Identity(), Pose());
    builder.model.bodies[static_cast<std::size_t>(b)].V_WB.linear = Vec3(1, 2, 3);
  }
  return builder.build();
}

/// What a world of this adapter says when a step fails.
StepResult failed_step(const Rascals& rascals) {
  const auto backend = rascals.backend();
  REQUIRE(backend);
  auto world = (*backend)->create_world(two_bodies());
  REQUIRE(world);
  std::vector<Contact> contacts;
  (*world)->get_contacts(contacts);
  StepResult result = (*world)->step(0.01, {});
  if (result.status == StepStatus::ok) {
    (*world)->get_contacts(contacts);
    result = (*world)->step(0.01, {});
  }
  CHECK(result.status == StepStatus::fault);
  // The world stays readable where it was, fails again, and can be rebuilt.
  WorldState state;
  (*world)->get_state(state);
  CHECK(state.poses.size() == 2);
  CHECK(state.poses[0].p.allFinite());
  CHECK((*world)->step(0.01, {}).status == StepStatus::fault);
  rascals.behave();
  const auto again = (*world)->reset();
  INFO((again ? std::string() : again.error().text()));
  CHECK(again);
  CHECK((*world)->step(0.01, {}).status == StepStatus::ok);
  return result;
}

/// Takes what this process writes to its standard output.
class OutputCatch {
 public:
  OutputCatch() : kept_(::dup(STDOUT_FILENO)), file_(folder_ / "output") {
    std::ofstream(file_).put('\n');
    const auto opened = std::freopen(file_.c_str(), "a", stdout);
    REQUIRE(opened);
  }
  ~OutputCatch() { give_back(); }
  std::string text() {
    give_back();
    std::ifstream in(file_);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  void give_back() {
    if (kept_ < 0) return;
    std::fflush(stdout);
    ::dup2(kept_, STDOUT_FILENO);
    ::close(kept_);
    kept_ = -1;
  }
  test::TemporaryFolder folder_;
  int kept_;
  std::string file_;
};

}  // namespace

TEST_CASE("a backend in another process", "[adapter]") {
  const Rascals rascals("none none");
  const auto backend = rascals.backend();
  INFO((backend ? std::string() : backend.error().text()));
  REQUIRE(backend);
  CHECK(std::string((*backend)->name()) == "rascal");
  CHECK(std::string((*backend)->engine_version()) == "1.0");
  const Capabilities& can = (*backend)->capabilities();
  CHECK(can.get("shape.box").support == Support::exact);
  CHECK(can.get("joint.hinge").support == Support::unsupported);
  CHECK(can.get("joint.hinge").note == "not declared by the adapter");
  const auto provenance = provenance_of(**backend, SceneModel());
  REQUIRE(provenance);
  CHECK((*provenance)[StepStage::integrator].name == "Moved.step");

  auto world = (*backend)->create_world(two_bodies());
  REQUIRE(world);
  CHECK((*world)->extension<JointReactions>() == nullptr);  // not declared
  REQUIRE((*world)->step(0.5, {}).status == StepStatus::ok);
  const SnapshotPtr half = (*world)->save();
  REQUIRE((*world)->step(0.5, {}).status == StepStatus::ok);
  WorldState state;
  (*world)->get_state(state);
  CHECK(state.poses[0].p == Vec3(1, 2, 3));
  REQUIRE((*world)->restore(half));
  (*world)->get_state(state);
  CHECK(state.poses[1].p == Vec3(0.5, 1, 1.5));
  state.poses[1].p = Vec3(7, 8, 9);
  REQUIRE((*world)->set_state(state));
  REQUIRE((*world)->reset());
  (*world)->get_state(state);
  CHECK(state.poses[1].p == Vec3(0, 0, 0));
}

TEST_CASE("a snapshot goes on in another process of its backend", "[adapter]") {
  const Rascals rascals("none none");
  const auto backend = rascals.backend();
  REQUIRE(backend);
  const SceneModelPtr scene = two_bodies();
  auto one = (*backend)->create_world(scene), other = (*backend)->create_world(scene);
  REQUIRE(one);
  REQUIRE(other);
  REQUIRE((*one)->step(0.5, {}).status == StepStatus::ok);
  REQUIRE((*other)->restore((*one)->save()));
  WorldState state;
  (*other)->get_state(state);
  CHECK(state.poses[0].p == Vec3(0.5, 1, 1.5));
}

TEST_CASE("a failure of an adapter is named, and its world can be rebuilt", "[adapter]") {
  const auto [fault, says] = GENERATE(table<std::string, std::string>(
      {{"step crash", "backend 'rascal' crashed (SIGSEGV) in a step"},
       {"step exit", "ended its process (exit code 7) in a step; it had written:\ngoodbye"},
       {"step hang", "hung: it did not answer within 2 s"},
       {"step garbage", "sent an answer to another question in a step"},
       {"step endless", "sent an answer to another question in a step"},
       {"step cut", "ended its process (exit code 0) in a step"},
       {"step short", "sent 24 bytes where its state has 208 in a step"},
       {"step throw", "failed (ValueError: no licence today) in a step"},
       {"contacts cut", "failed (ValueError: a contact needs 14 numbers)"},
       {"contacts nobody", "sent a contact of bodies or shapes that do not exist"}}));
  CAPTURE(fault);
  CHECK_THAT(failed_step(Rascals(fault)).message, Contains(says));
}

TEST_CASE("a state that is not finite diverges", "[adapter]") {
  const Rascals rascals("read nan");
  const auto backend = rascals.backend();
  REQUIRE(backend);
  auto world = (*backend)->create_world(two_bodies());
  REQUIRE(world);
  const StepResult result = (*world)->step(0.01, {});
  CHECK(result.status == StepStatus::diverged);
  CHECK(result.body == 0);
}

TEST_CASE("what fails before the first step is an error with code, file and cause", "[adapter]") {
  const auto [fault, says] = GENERATE(table<std::string, std::string>(
      {{"hello exit", "ended its process (exit code 7) while it was started"},
       {"hello garbage", "sent an answer to another question while it was started"},
       {"version 2", "speaks version 2 of the protocol, and this CogRSim 1"},
       {"capability x", "there is no feature 'joint.elbow'"},
       {"note x", "'joint.hinge' needs a reason"},
       {"build crash", "crashed (SIGSEGV) while a world was built"},
       {"read length", "sent an orientation of body 'ball' of the length 0.5"},
       {"reaction x", "declares 'report.joint_reaction', and its world has no reactions()"}}));
  CAPTURE(fault);
  const Rascals rascals(fault);
  const auto backend = rascals.backend();
  const Error error = backend ? (*backend)->create_world(two_bodies()).error() : backend.error();
  CHECK_THAT(error.message, Contains(says));
  CHECK(error.code == "CG0910");
  CHECK_THAT(error.where, Contains("rascal/backend.json"));
}

TEST_CASE("what an adapter refuses is its user's to read", "[adapter]") {
  const Rascals rascals("build refuse");
  const auto backend = rascals.backend();
  REQUIRE(backend);
  const auto world = (*backend)->create_world(two_bodies());
  REQUIRE_FALSE(world);
  CHECK(world.error().message == "the engine has no bodies left");
  CHECK((*backend)->create_world(two_bodies()).error().message == "the engine has no bodies left");
}

TEST_CASE("an adapter's output reaches nobody, and holds nothing up", "[adapter]") {
  const Rascals rascals("step chatter");
  const auto backend = rascals.backend();
  REQUIRE(backend);
  auto world = (*backend)->create_world(two_bodies());
  REQUIRE(world);
  StepStatus status = StepStatus::fault;
  OutputCatch output;
  status = (*world)->step(0.01, {}).status;
  CHECK(output.text() == "\n");
  CHECK(status == StepStatus::ok);
}

TEST_CASE("an adapter that is killed at any moment is named", "[adapter]") {
  for (int seed = 0; seed < 100; ++seed) {
    CAPTURE(seed);
    const Rascals rascals("soon " + std::to_string(seed));
    rascals.be_patient();
    const auto backend = rascals.backend();
    const auto world = backend ? (*backend)->create_world(two_bodies())
                               : Result<std::unique_ptr<World>>(tl::unexpected(backend.error()));
    if (!world) {
      CHECK_THAT(world.error().message, Contains("SIGKILL") || Contains("no process any more"));
      CHECK(world.error().code == "CG0910");
      continue;
    }
    StepResult result;
    std::vector<Contact> contacts;
    WorldState state;
    int steps = 0;
    while ((result = (*world)->step(0.001, {})).status == StepStatus::ok && ++steps < 1000000) {
      (*world)->get_contacts(contacts);
    }
    CHECK(result.status == StepStatus::fault);
    CHECK_THAT(result.message, Contains("backend 'rascal' crashed (SIGKILL)"));
    (*world)->get_state(state);
    CHECK(state.poses[0].p.x() == Approx(0.001 * steps));
  }
}

TEST_CASE("a wrong backend.json names its fault and the remedy", "[adapter]") {
  const auto [text, says, remedy] = GENERATE(table<std::string, std::string, std::string>(
      {{"", "it is not JSON", ""},
       {"[]", "it is not a JSON object", ""},
       {R"({"engine": "E"})", "'name' is missing", ""},
       {R"({"name": "../x", "engine": "E"})", "'../x' is not a name of a backend", "small letters"},
       {R"({"name": "rascal", "engine": "E", "comand": []})", "has no member 'comand'",
        "did you mean 'command'?"},
       {R"({"name": "rascal", "engine": "E", "protocol": 9, "command": ["true"]})",
        "speaks version 9 of the protocol, and this CogRSim version 1", "cogrsim new backend"},
       {R"({"name": "rascal", "engine": "E", "protocol": 1})", "'command' must be a list", "node"},
       {R"({"name": "rascal", "engine": "E", "protocol": 1, "command": []})",
        "begins with a program", "node"},
       {R"({"name": "rascal", "engine": "E", "protocol": 1, "command": ["a"], "patience": -1})",
        "'patience' must be a number of seconds above 0", ""},
       {R"({"name": "other", "engine": "E", "protocol": 1, "command": ["true"]})",
        "the backend inside calls itself 'other'", "name the folder other"},
       {R"({"name": "rascal", "engine": "E", "protocol": 1, "command": ["no_such_program"]})",
        "needs what is not there: no_such_program is not installed", "install it"},
       {R"({"name": "rascal", "engine": "E", "protocol": 1, "command": ["python3"], "needs":
           [{"file": "node_modules/engine", "install": "npm ci"}]})",
        "node_modules/engine is missing in", "install it"}}));
  CAPTURE(text);
  const test::TemporaryFolder folder;
  folder.write("rascal/backend.json", text);
  PluginLoader loader({folder.path.string()});
  const auto backend = loader.backend("rascal");
  REQUIRE_FALSE(backend);
  CHECK(backend.error().code == "CG0910");
  CHECK_THAT(backend.error().message, Contains(says));
  CHECK_THAT(backend.error().hint, Contains(remedy));
  CHECK_THAT(backend.error().where, Contains("rascal/backend.json"));
  // The list has it, and starts nothing.
  std::vector<RefusedPlugin> refused;
  loader.all(&refused);
  REQUIRE(refused.size() >= 1);
  CHECK_THAT(refused[0].reason, Contains(says));
  CHECK(refused[0].unavailable == (remedy == std::string("install it") ? "rascal" : ""));
}

TEST_CASE("an adapter reaches its own folder, those of the system, and what its file names",
          "[adapter]") {
  if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, 1) < 1) {
    WARN("this kernel has no Landlock: files are not confined");
    return;
  }
  const auto reached = [](const std::string& more) {
    const Rascals rascals("reach all");
    std::string manifest = kManifest;
    manifest.replace(manifest.find("2,"), 1, "30");  // patience
    if (!more.empty())
      manifest.insert(1, "\"" + more + "\": [\"" + rascals.path.string() + "\"], ");
    rascals.write("rascal/backend.json", manifest);
    const auto backend = rascals.backend();
    return backend ? std::string((*backend)->engine_version()) : backend.error().text();
  };
  // Its own folder, the folder above, a file there, a socket, its watchdog, the system's.
  CHECK(reached("") == "done EACCES EACCES EACCES done done");
  CHECK(reached("reads") == "done done EACCES EACCES done done");
  CHECK(reached("writes") == "done done done EACCES done done");
}

TEST_CASE("two backends of one name in one folder are an error", "[adapter]") {
  const Rascals rascals("none none");
  rascals.write("backend.json", kManifest);
  const auto backend = rascals.backend();
  REQUIRE_FALSE(backend);
  CHECK(backend.error().code == "CG0910");
  CHECK_THAT(backend.error().message, Contains("two backends are called 'rascal'"));
  CHECK_THAT(backend.error().message,
             Contains("rascal/rascal/backend.json") || Contains("/rascal/backend.json"));
}

TEST_CASE("the folder of an adapter can itself be named", "[adapter]") {
  const Rascals rascals("none none");
  fs::rename(rascals / "rascal", rascals / "of any name");
  const std::string folder = rascals / GENERATE("of any name", "of any name/");
  PluginLoader loader({folder});
  const auto backend = loader.backend("rascal");
  INFO((backend ? std::string() : backend.error().text()));
  CHECK(backend);
  const auto other = loader.backend("rascl");
  REQUIRE_FALSE(other);
  CHECK_THAT(other.error().hint, Contains("did you mean 'rascal'?"));
}

}  // namespace cogrsim
