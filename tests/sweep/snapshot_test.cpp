// Snapshots on file: resuming, on another engine, with something changed; and invalid files.
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../support/engines.h"
#include "../support/skip.h"
#include "../support/snapshot_sum.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "common/scene_loading.h"
#include "process.h"

using namespace cogrsim;
using Catch::Contains;
using nlohmann::ordered_json;

namespace {

const std::string kScenes = COGRSIM_SCENES;

cli::LoadedScene scene_of(const std::string& name, std::map<std::string, std::string> set = {}) {
  cli::SceneOptions options;
  options.scene = kScenes + "/" + name + ".scene.xml";
  options.set = std::move(set);
  options.plugin_paths = {COGRSIM_TOYS};
  cli::LoadedScene scene = cli::load_scene(options);
  for (const Diagnostic& d : scene.diagnostics) UNSCOPED_INFO(d.message);
  REQUIRE(scene.model);
  return scene;
}

SimulationOptions on(const std::string& backend) {
  SimulationOptions options;
  options.backend = backend;
  return options;
}

std::unique_ptr<Simulation> simulate(const cli::LoadedScene& scene, const std::string& backend) {
  auto made = Simulation::create(scene.model, on(backend), scene.loader);
  if (!made) {
    for (const Diagnostic& d : made.error()) UNSCOPED_INFO(d.message);
  }
  REQUIRE(made);
  return std::move(*made);
}

SnapshotFile read(const std::string& path) {
  auto file = SnapshotFile::read(path);
  INFO((file ? "" : file.error().text()));
  REQUIRE(file);
  return *file;
}

Resumed resume_from(const std::string& path, const cli::LoadedScene& scene,
                    SimulationOptions options) {
  auto resumed = resume(read(path), scene.model, options, scene.loader);
  if (!resumed) {
    for (const Diagnostic& d : resumed.error()) UNSCOPED_INFO(d.message);
  }
  REQUIRE(resumed);
  return std::move(*resumed);
}

// The largest distance between origins of bodies of the same name [m].
double distance_between(Simulation& a, Simulation& b) {
  const FramePtr one = a.frame(), other = b.frame();
  double most = 0.0;
  for (std::size_t i = 0; i < one->model->bodies.size(); ++i) {
    const Body& body = one->model->bodies[i];
    const int j = find_body(*other->model, body.name);
    if (body.removed || j < 0) continue;
    most = std::max(most, (one->state.poses[i].p - other->state.poses[j].p).norm());
  }
  return most;
}

/// The widest gap of a joint [m], which resuming closes: the joints' coordinates win.
double widest_gap(Simulation& run) {
  const FramePtr frame = run.frame();
  const auto pose_of = [&](int body) { return body < 0 ? Pose() : frame->state.poses[body]; };
  double widest = 0.0;
  for (const Joint& joint : frame->model->joints) {
    const Pose X_FM = relative_pose(joint, pose_of(joint.parent), pose_of(joint.child));
    widest = std::max(widest, joint_error(joint, X_FM).distance);
  }
  return widest;
}

std::string joined(const std::vector<std::string>& notes) {
  std::string out;
  for (const std::string& note : notes) out += note + "\n";
  return out;
}

}  // namespace

TEST_CASE("without contacts a run resumes as if it had not stopped", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  INFO(backend);
  const TemporaryFolder folder;
  const auto scene = scene_of("pendulum");
  auto whole = simulate(scene, backend);
  whole->run_until(0.7);
  REQUIRE(write_snapshot(*whole, folder / "a.snap"));
  const Resumed resumed = resume_from(folder / "a.snap", scene, on(backend));
  CHECK(joined(resumed.notes).empty());
  CHECK(resumed.same_scene);
  CHECK(resumed.simulation->time() == whole->time());
  CHECK(resumed.simulation->step_count() == whole->step_count());
  whole->run_until(2.0);
  resumed.simulation->run_until(2.0);
  // Turning a pose into the engine's own coordinates and back rounds in the last digit. A joint
  // that is held by forces has a gap, 1e-8 to 1e-7 m here, which resuming closes: the joints'
  // coordinates win.
  CHECK(distance_between(*whole, *resumed.simulation) < 1e-6);
  // Noise, rates and integrals too: the readings' random streams and the controller resume.
  const Reading& then = whole->frame()->readings.at(0);
  const Reading& now = resumed.simulation->frame()->readings.at(0);
  CHECK(now.sequence == then.sequence);
  CHECK(now.time == then.time);
  REQUIRE(now.values.size() == then.values.size());
  for (std::size_t i = 0; i < now.values.size(); ++i) {
    // the pendulum's motion is that of a damped one: what is equal to 1e-7 stays so
    CHECK(now.values[i] == Approx(then.values[i]).margin(1e-4));
  }
}

TEST_CASE("a servo at its bound resumes with its last effort", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  INFO(backend);
  const TemporaryFolder folder;
  const auto scene = scene_of("servo");
  auto whole = simulate(scene, backend);
  whole->run_until(0.1);
  REQUIRE(write_snapshot(*whole, folder / "a.snap"));
  const WorldState then = whole->frame()->state;
  REQUIRE(then.motor_efforts[0] == Approx(2.0));  // at its bound
  const Resumed resumed = resume_from(folder / "a.snap", scene, on(backend));
  Simulation& now = *resumed.simulation;
  CHECK(now.frame()->state.motor_efforts == then.motor_efforts);
  CHECK(now.frame()->state.joint_efforts == then.joint_efforts);
  // The integral rests at the bound: after the next step, too, it is what it is without a stop.
  const auto integral = [&](Simulation& run, const char* name) {
    run.step();
    REQUIRE(write_snapshot(run, folder / name));
    return ordered_json::parse(read_file(folder / name))["content"]["motors"]["drive"]["integral"]
        .get<double>();
  };
  CHECK(integral(now, "c.snap") == integral(*whole, "b.snap"));
  CHECK(now.frame()->state.motor_efforts[0] == Approx(2.0));  // the engine's own by now
  // A restart has no past.
  now.send(Restart{});
  now.step();
  CHECK(now.step_count() == 1);
}

TEST_CASE("with contacts a run resumes nearly as if it had not stopped", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  INFO(backend);
  const TemporaryFolder folder;
  const auto scene = scene_of("heap");
  auto whole = simulate(scene, backend);
  whole->run_until(0.5);
  REQUIRE(write_snapshot(*whole, folder / "a.snap"));
  const Resumed resumed = resume_from(folder / "a.snap", scene, on(backend));
  // Efforts and contacts of the last step are not in it, poses are.
  CHECK(distance_between(*whole, *resumed.simulation) < 1e-12);
  whole->run_until(2.0);
  resumed.simulation->run_until(2.0);
  // The contacts' solvers start without what they remembered of the step before; what comes of it
  // is a solver's residual in the first steps, 3 micrometres as measured, which friction keeps, and
  // half a millimetre where contact trembles (ODE).
  CHECK(distance_between(*whole, *resumed.simulation) <
        (test::states_figures(backend) ? 1e-4 : 2e-3));
}

TEST_CASE("two runs from one snapshot are the same to the last bit", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  const TemporaryFolder folder;
  const auto scene = scene_of("heap");
  auto first = simulate(scene, backend);
  first->run_until(0.3);
  REQUIRE(write_snapshot(*first, folder / "a.snap"));
  const Resumed one = resume_from(folder / "a.snap", scene, on(backend));
  const Resumed two = resume_from(folder / "a.snap", scene, on(backend));
  one.simulation->run_until(1.0);
  two.simulation->run_until(1.0);
  CHECK(state_hash(one.simulation->frame()->state) == state_hash(two.simulation->frame()->state));
}

TEST_CASE("state is carried to another engine", "[sweep][snapshot]") {
  const auto& all = test::all_engines();
  if (all.size() < 2) COGRSIM_SKIP("it takes two engines");
  const std::string name = GENERATE(values<std::string>({"pendulum", "heap"}));
  INFO(name);
  const TemporaryFolder folder;
  const auto scene = scene_of(name);
  auto first = simulate(scene, all[0]);
  first->run_until(0.5);
  REQUIRE(write_snapshot(*first, folder / "a.snap"));
  const Resumed resumed = resume_from(folder / "a.snap", scene, on(all[1]));
  CHECK(std::string(resumed.simulation->backend().name()) == all[1]);
  CHECK_FALSE(resumed.same_scene);
  CHECK(joined(resumed.notes).empty());
  // Joints' coordinates win over poses: the gap of a joint that is held by forces is closed.
  CHECK(distance_between(*first, *resumed.simulation) < 1e-5);
  CHECK(resumed.simulation->run_until(1.0) == RunStatus::completed);
}

TEST_CASE("a changed scene takes over the known state, and reports the rest", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  const TemporaryFolder folder;
  auto first = simulate(scene_of("pendulum"), backend);
  first->run_until(0.5);
  REQUIRE(write_snapshot(*first, folder / "a.snap"));
  const Resumed heavier =
      resume_from(folder / "a.snap", scene_of("pendulum", {{"mass", "2 kg"}}), on(backend));
  CHECK_THAT(joined(heavier.notes), Contains("not that of the snapshot"));
  // 1e-8: what a joint's axes have turned from each other, some 1e-8 rad, on an arm of 0.3 m.
  CHECK(distance_between(*first, *heavier.simulation) < widest_gap(*first) + 1e-8);
  CHECK_FALSE(heavier.same_scene);

  const Resumed other = resume_from(
      folder / "a.snap", scene_of("pendulum", {{"extra", "true"}, {"imu", "false"}}), on(backend));
  CHECK_THAT(joined(other.notes), Contains("does not have it: body 'more'") &&
                                      Contains("not in the scene any more: sensor 'rig.feel'"));
  const int more = find_body(*other.simulation->model(), "more");
  REQUIRE(more >= 0);
  CHECK(other.simulation->frame()->state.poses[more].p.z() == 60.0);

  SimulationOptions reseeded = on(backend);
  reseeded.seed = 99;
  reseeded.step = 2e-3;
  const Resumed again = resume_from(folder / "a.snap", scene_of("pendulum"), reseeded);
  CHECK_THAT(joined(again.notes), Contains("the seed differs"));
  CHECK(again.simulation->time() == Approx(0.5).epsilon(1e-12));
  CHECK(again.simulation->run_until(1.0) == RunStatus::completed);

  const auto heap = scene_of("heap");
  const auto foreign = resume(read(folder / "a.snap"), heap.model, on(backend), heap.loader);
  REQUIRE_FALSE(foreign);
  CHECK_THAT(foreign.error().at(0).message, Contains("of scene 'pendulum', not of 'heap'"));
}

TEST_CASE("added, removed and changed elements are restored", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  INFO(backend);
  const TemporaryFolder folder;
  const auto scene = scene_of("heap"), part = scene_of("part");
  auto first = simulate(scene, backend);
  first->run_until(0.2);
  Pose pose;
  pose.p = Vec3(-1, 0, 0);
  first->send(AddAssembly{part.model, "one", pose});
  pose.p = Vec3(-2, 0, 0);
  first->send(AddAssembly{part.model, "two", pose});
  first->send(Remove{"top"});
  first->send(SetStatic{"middle", true});
  first->run_until(0.3);
  Attach hitch;
  hitch.name = "hitch";
  hitch.parent = "two.base";
  hitch.child = "slider";
  first->send(hitch);
  first->send(Remove{"one"});
  first->run_until(0.5);
  for (const RunMessage& m : first->messages()) UNSCOPED_INFO(m.message);
  REQUIRE(find_joint(*first->model(), "hitch") >= 0);
  REQUIRE(write_snapshot(*first, folder / "a.snap"));
  CHECK(read(folder / "a.snap").info().changed);

  const Resumed resumed = resume_from(folder / "a.snap", scene, on(backend));
  Simulation& second = *resumed.simulation;
  CHECK(joined(resumed.notes).empty());
  // Rounding; or the gap of a joint that is held by forces, which resuming closes: of the hitch on
  // Bullet 7 mm.
  CHECK(distance_between(*first, second) < (test::states_figures(backend) ? 1e-9 : 2e-2));
  CHECK(find_body(*second.model(), "two.arm") >= 0);
  CHECK(find_body(*second.model(), "one.arm") < 0);
  CHECK(find_body(*second.model(), "top") < 0);
  CHECK(find_joint(*second.model(), "hitch") >= 0);
  const int middle = find_body(*second.model(), "middle");
  REQUIRE(middle >= 0);
  CHECK(second.model()->bodies[middle].kind == BodyKind::static_body);
  first->run_until(1.0);
  second.run_until(1.0);
  // As above.
  CHECK(distance_between(*first, second) < (test::states_figures(backend) ? 1e-4 : 0.1));

  // On the other engine, too.
  const std::vector<std::string> all = {COGRSIM_ENGINES};
  const Resumed elsewhere = resume_from(folder / "a.snap", scene, on(all.back()));
  CHECK(find_joint(*elsewhere.simulation->model(), "hitch") >= 0);
  const RunStatus ended = elsewhere.simulation->run_until(1.0);
  for (const RunMessage& m : elsewhere.simulation->messages()) UNSCOPED_INFO(m.message);
  CHECK(ended == RunStatus::completed);

  // From the very start again: the scene as it is written.
  second.send(Restart{});
  second.step();
  second.run_until(0.1);
  auto fresh = simulate(scene, backend);
  fresh->run_until(0.1);
  CHECK(find_body(*second.model(), "top") >= 0);
  CHECK(state_hash(second.frame()->state) == state_hash(fresh->frame()->state));
}

TEST_CASE("a body that was made static stays where it was", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines()), other = GENERATE(test::engines());
  const auto settings = GENERATE(
      values<std::map<std::string, std::string>>({{}, {{"mass", "2 kg"}, {"there", "7 m"}}}));
  INFO(backend << " then " << other << (settings.empty() ? "" : ", another scene"));
  const TemporaryFolder folder;
  auto first = simulate(scene_of("frozen"), backend);
  first->run_until(0.4);
  for (const RunMessage& m : first->messages()) UNSCOPED_INFO(m.message);
  for (const RunMessage& m : first->messages()) CHECK(m.source == "backend");
  REQUIRE(write_snapshot(*first, folder / "a.snap"));
  const Resumed resumed = resume_from(folder / "a.snap", scene_of("frozen", settings), on(other));
  Simulation& second = *resumed.simulation;
  const auto pose = [](Simulation& run, const char* name) {
    const int body = find_body(*run.model(), name);
    REQUIRE(body >= 0);
    return run.frame()->state.poses[body];
  };
  const auto fixed = [](Simulation& run, const char* name) {
    return run.model()->bodies[find_body(*run.model(), name)].kind == BodyKind::static_body;
  };
  const double later = GENERATE(0.4, 1.0);
  second.run_until(later);
  // Going through text and back loses nothing; an engine's own coordinates round in the last digit.
  const double kRounding = 1e-9;
  for (const char* name : {"lamp", "shelf", "swing.arm", "swing.post"}) {
    INFO(name << " at " << later);
    CHECK(fixed(second, name));
    CHECK((pose(second, name).p - pose(*first, name).p).norm() < kRounding);
    CHECK(pose(second, name).q.angularDistance(pose(*first, name).q) < 1e-7);
  }
  // They had moved before: g t^2 / 2 is 0.44 m in the first 0.3 s, 0.2 m in the next 0.2 s.
  CHECK(pose(second, "lamp").p.z() < 4.6);
  CHECK(pose(second, "shelf").p.z() < 2.9);
  CHECK(pose(second, "swing.arm").p.z() < 2.9);
  CHECK_FALSE(fixed(second, "loose"));
  CHECK(pose(second, "loose").p.z() < (later > 0.5 ? 1.0 : 2.7));
  // A body that never moved is where the changed scene puts it.
  CHECK(pose(second, "wall").p.x() == Approx(settings.empty() ? 3.0 : 7.0));
}

TEST_CASE("rules, regions and lifetimes resume", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  INFO(backend);
  const TemporaryFolder folder;
  const auto scene = scene_of("live");
  auto whole = simulate(scene, backend);
  // The bot has come into the region, what that sets off is yet to come; balls are there that will
  // go, and others that will come, with numbers of their own.
  whole->run_until(0.95);
  REQUIRE(write_snapshot(*whole, folder / "a.snap"));
  const Resumed resumed = resume_from(folder / "a.snap", scene, on(backend));
  CHECK(joined(resumed.notes).empty());
  whole->run_until(2.0);
  resumed.simulation->run_until(2.0);
  const auto names = [](const Simulation& simulation) {
    std::string out;
    for (const Body& body : simulation.model()->bodies) {
      if (!body.removed) out += body.name + " ";
    }
    return out;
  };
  CHECK(names(*whole) == names(*resumed.simulation));
  CHECK_THAT(names(*whole), Contains("Ball_7.b"));
  CHECK(distance_between(*whole, *resumed.simulation) < 1e-4);  // contacts, as above
}

TEST_CASE("doors keep moving to where they were sent", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  // Half open, open, half closed.
  const double when = GENERATE(1.0, 2.5, 3.2);
  CAPTURE(backend, when);
  const TemporaryFolder folder;
  const auto scene = scene_of("door");
  const auto events_from = [](Simulation& simulation) {
    auto kinds = std::make_shared<std::string>();
    simulation.observe({}, [kinds](const FramePtr& frame) {
      for (const Event& event : frame->events) *kinds += event.kind + " ";
    });
    return kinds;
  };
  auto whole = simulate(scene, backend);
  whole->run_until(when);
  REQUIRE(write_snapshot(*whole, folder / "a.snap"));
  const Resumed resumed = resume_from(folder / "a.snap", scene, on(backend));
  const auto expected = events_from(*whole), found = events_from(*resumed.simulation);
  whole->run_until(6.0);
  resumed.simulation->run_until(6.0);
  CHECK(*found == *expected);
  CHECK_THAT(*found, Contains("closed"));
  CHECK(distance_between(*whole, *resumed.simulation) < 1e-7);  // no contacts, as above
}

TEST_CASE("files that are no snapshots are refused with a reason", "[sweep][snapshot]") {
  const TemporaryFolder folder;
  const std::vector<std::string> all = {COGRSIM_ENGINES};
  auto simulation = simulate(scene_of("heap"), all[0]);
  simulation->run_until(0.1);
  REQUIRE(write_snapshot(*simulation, folder / "good.snap", {{"friction", "0.5"}}));
  CHECK(folder.files().size() == 1);  // nothing half-written beside it
  const std::string good = read_file(folder / "good.snap");
  CHECK(read(folder / "good.snap").info().parameters.at("friction") == "0.5");
  const auto refused = [&](const std::string& text) {
    std::ofstream(folder / "bad.snap", std::ios::binary | std::ios::trunc) << text;
    const auto file = SnapshotFile::read(folder / "bad.snap");
    REQUIRE_FALSE(file);
    return file.error().text();
  };
  CHECK_THAT(refused(""), Contains("is not a snapshot"));
  CHECK_THAT(refused("<scene/>"), Contains("is not a snapshot"));
  CHECK_THAT(refused("{\"format\": \"something else\"}"), Contains("is not a snapshot"));
  CHECK_THAT(refused("[1, 2]"), Contains("is not a snapshot"));
  for (const std::size_t length : {good.size() - 3, good.size() / 2, std::size_t{200}}) {
    CHECK_THAT(refused(good.substr(0, length)), Contains("damaged"));
  }
  std::string flipped = good;
  const auto digit = flipped.find("\"pose\"");
  REQUIRE(digit != std::string::npos);
  for (std::size_t i = digit; i < flipped.size(); ++i) {
    if (flipped[i] < '1' || flipped[i] > '8') continue;
    ++flipped[i];
    break;
  }
  CHECK_THAT(refused(flipped), Contains("checksum"));
  ordered_json newer = ordered_json::parse(good);
  newer["version"] = 3;
  CHECK_THAT(refused(newer.dump()), Contains("version 3"));
  CHECK_FALSE(SnapshotFile::read(folder / "nowhere.snap"));
  CHECK_FALSE(write_snapshot(*simulation, folder / "no/such/folder/a.snap"));
  CHECK(folder.files().size() == 2);
}

TEST_CASE("a wrong content with a right checksum is refused, too", "[sweep][snapshot]") {
  const TemporaryFolder folder;
  const std::vector<std::string> all = {COGRSIM_ENGINES};
  const auto scene = scene_of("heap"), part = scene_of("part");
  auto simulation = simulate(scene, all[0]);
  simulation->send(AddAssembly{part.model, "one", {}});
  simulation->run_until(0.1);
  REQUIRE(write_snapshot(*simulation, folder / "good.snap"));
  const ordered_json good = ordered_json::parse(read_file(folder / "good.snap"));
  // The sum that stands in the file fits its content.
  const auto refused = [&](const char* pointer, const char* value) {
    ordered_json file = good;
    file["content"][ordered_json::json_pointer(pointer)] = ordered_json::parse(value);
    file["checksum"] = snapshot_sum(file["content"]);
    std::ofstream(folder / "bad.snap", std::ios::trunc) << file.dump();
    const auto snapshot = SnapshotFile::read(folder / "bad.snap");
    if (!snapshot) return snapshot.error().text();
    const auto resumed = resume(*snapshot, scene.model, on(all[0]), scene.loader);
    return resumed ? "resumed" : resumed.error().at(0).message;
  };
  CHECK(refused("/seed", "1") == "resumed");
  CHECK_THAT(refused("/seed", "1.3e20"),
             Contains("is damaged: 1.3e+20 stands where a whole number from 0 to "
                      "18446744073709551615 belongs"));
  CHECK_THAT(refused("/clock/steps", "-1"), Contains("-1 stands where"));
  CHECK_THAT(refused("/event_system/random", "\"x\""),
             Contains("a value of type string stands where"));
  CHECK_THAT(refused("/sent", "4294967296"), Contains("4294967296 stands where"));
  // Lists that do not fit each other, and numbers of elements that are not there.
  const std::string no_mesh = R"({"name": "m", "vertices": [], "triangles": [], "uv": []})";
  CHECK_THAT(refused("/changes/meshes", ("[" + no_mesh + "]").c_str()),
             Contains("the snapshot is damaged: shapes have no name"));
  CHECK_THAT(refused("/changes/now/bodies", "[]"), Contains("the snapshot is damaged: '"));
  CHECK_THAT(refused("/joints/one.elbow/position", "[0, 0]"),
             Contains("the joint 'one.elbow' has"));
  CHECK_THAT(refused("/changes/now/assemblies/0/parent", "7"), Contains("has a wrong parent"));
  CHECK_THAT(refused("/changes/original/assemblies",
                     R"([{"name": "a"}, {"name": "b"}, {"name": "c"}, {"name": "d"}])"),
             Contains("elements of the original scene are missing"));
}

// One value or entry is changed, and the sum made to fit: whatever it is, nothing may end the program.
// COGRSIM_FORGED=2500 tries as many on each engine.
TEST_CASE("a snapshot shows no file but the scene's textures", "[sweep][snapshot]") {
  const TemporaryFolder folder;
  const std::vector<std::string> all = {COGRSIM_ENGINES};
  const auto scene = scene_of("heap"), part = scene_of("part");
  auto simulation = simulate(scene, all[0]);
  simulation->send(AddAssembly{part.model, "one", {}});
  simulation->run_until(0.1);
  REQUIRE(write_snapshot(*simulation, folder / "a.snap"));
  ordered_json file = ordered_json::parse(read_file(folder / "a.snap"));
  ordered_json& materials = file["content"]["changes"]["now"]["materials"];
  materials.push_back(materials.at(0));
  materials.back()["texture"] = folder / "secret.png";
  file["checksum"] = snapshot_sum(file["content"]);
  std::ofstream(folder / "a.snap", std::ios::trunc) << file.dump();
  const auto texture_after = [&](const SceneModelPtr& model, std::vector<std::string>* notes) {
    const auto resumed = resume(read(folder / "a.snap"), model, on(all[0]), scene.loader);
    REQUIRE(resumed);
    if (notes != nullptr) *notes = resumed->notes;
    return resumed->simulation->model()->materials.back().texture;
  };
  std::vector<std::string> notes;
  CHECK(texture_after(scene.model, &notes).empty());
  CHECK_THAT(joined(notes), Contains("secret.png' is none of the scene's"));
  // One that the scene has is shown.
  auto own = std::make_shared<SceneModel>(*scene.model);
  own->materials.push_back({});
  own->materials.back().texture = folder / "secret.png";
  CHECK(texture_after(own, nullptr) == folder / "secret.png");
}

TEST_CASE("forged snapshots are refused or resumed", "[sweep][snapshot]") {
  const std::string backend = GENERATE(test::engines());
  INFO(backend);
  const TemporaryFolder folder;
  const auto scene = scene_of("heap"), part = scene_of("part");
  auto simulation = simulate(scene, backend);
  simulation->send(AddAssembly{part.model, "one", {}});
  simulation->send(Remove{"top"});
  simulation->run_until(0.1);
  REQUIRE(write_snapshot(*simulation, folder / "good.snap"));
  const ordered_json good = ordered_json::parse(read_file(folder / "good.snap"));
  const std::vector<ordered_json> values = {
      0,     1,     -1,    5,    99, 0.5, 1e-300,     1e9,     1e300,     -1e300,
      "nan", "inf", false, true, "", "x", 4294967296, nullptr, {0, 0, 0}, {1, 2, 3, 0, 0, 0, 0}};
  const std::function<void(ordered_json&, std::vector<ordered_json*>&)> all_of =
      [&](ordered_json& json, std::vector<ordered_json*>& out) {
        if (!json.is_structured()) return out.push_back(&json);
        if (!json.empty()) out.push_back(&json);
        for (ordered_json& inner : json) all_of(inner, out);
      };
  const char* wanted = std::getenv("COGRSIM_FORGED");
  RandomStream random(1, "forged");
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random.next() % n); };
  int went_on = 0;
  for (int i = wanted ? std::atoi(wanted) : 100; i > 0; --i) {
    ordered_json file = good;
    std::vector<ordered_json*> values_in;
    for (ordered_json& inner : file["content"]) all_of(inner, values_in);
    ordered_json& target = *values_in[below(values_in.size())];
    const std::string before = target.dump().substr(0, 200);
    if (target.is_array()) {
      target.erase(below(target.size()));
    } else if (target.is_object()) {
      target.erase(std::next(target.begin(), static_cast<int>(below(target.size()))).key());
    } else {
      target = values[below(values.size())];
    }
    INFO(before << " became " << target.dump().substr(0, 200) << ", change " << i);
    file["checksum"] = snapshot_sum(file["content"]);
    std::ofstream(folder / "bad.snap", std::ios::trunc) << file.dump();
    const auto snapshot = SnapshotFile::read(folder / "bad.snap");
    if (!snapshot) continue;
    const auto resumed = resume(*snapshot, scene.model, on(backend), scene.loader);
    if (!resumed) continue;
    for (int k = 0; k < 3; ++k) resumed->simulation->step();
    ++went_on;
  }
  CHECK(went_on > 0);
}

TEST_CASE("run saves snapshots and resumes from them", "[sweep][snapshot][program]") {
  const TemporaryFolder folder;
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"run", kScenes + "/trial.scene.xml"});
    arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
    return cogrsim_run(arguments);
  };
  const auto hash = [](const Outcome& outcome) {
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return ordered_json::parse(outcome.out)["state_hash"].get<std::string>();
  };
  const Outcome whole =
      run({"--save-at", "300 ms", folder / "a.snap", "--save-at", "0", folder / "start.snap",
           "--save-at", "1 s", folder / "end.snap", "--set", "v=3 m/s", "--json", "-"});
  REQUIRE(folder.files().size() == 3);
  // The toy has no memory besides its state; and --set is remembered.
  const Outcome rest = run({"--from", folder / "a.snap", "--json", "-"});
  CHECK(hash(rest) == hash(whole));
  CHECK_THAT(rest.err, Contains("saves no state for snapshots and restarts: supervisor 'trouble'"));
  CHECK(hash(run({"--from", folder / "start.snap", "--json", "-"})) == hash(whole));
  CHECK(hash(run({"--from", folder / "a.snap", "--backend", "toy_euler", "--json", "-"})) !=
        hash(whole));
  CHECK_THAT(run({"--from", folder / "end.snap"}).err, Contains("longer --duration"));
  const struct {
    std::vector<std::string> arguments;
    int status;
    const char* text;
  } wrong[] = {
      {{"--save-at", "1 s"}, 2, "--save-at"},
      {{"--save-at", "soon", folder / "x"}, 2, "not a time"},
      {{"--save-at", "0.1", folder / "x", "--save-at", "0.2", folder / "x"}, 2, "named twice"},
      {{"--save-at", "5 s", folder / "x"}, 1, "ended at 1 s"},
      {{"--from", folder / "a.snap", "--save-at", "0.1", folder / "x"}, 1, "began later"},
      {{"--save-at", "0.1", folder / "no/x"}, 1, "cannot write"},
      {{"--from", folder / "nowhere"}, 1, "cannot read the snapshot"},
      {{"--from", kScenes}, 1, "it is a folder"},
      {{"--from", "/dev/zero"}, 1, "is not a regular file"},  // it has no end
      {{"--from", kScenes + "/trial.scene.xml"}, 1, "is not a snapshot"},
  };
  for (const auto& item : wrong) {
    std::string line;
    for (const std::string& argument : item.arguments) line += argument + " ";
    INFO(line);
    const Outcome outcome = run(item.arguments);
    CHECK(outcome.status == item.status);
    CHECK_THAT(outcome.err, Contains(item.text));
  }
}
