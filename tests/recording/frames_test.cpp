// Recordings are read back, bit for bit, and readings can be computed from them again.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "../support/engines.h"
#include "../support/skip.h"
#include "cogrsim/rendering/renderer.h"
#include "model/model_json.h"
#include "recording/mcap/mcap_reader.h"
#include "recording/mcap/messages.h"
#include "recording/mcap/protobuf.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

RecorderOptions to(const std::string& path) {
  RecorderOptions options;
  options.path = path;
  return options;
}

// On, off, an arrival, a departure: what changes while running.
std::function<void(int)> interference(Simulation& simulation) {
  return [&simulation](int step) {
    if (step == 40) simulation.send(EnableSensor{"late", true});
    if (step == 60) simulation.send(EnableSensor{"robot.imu", false});
    if (step == 75) simulation.send(EnableSensor{"robot.imu", true});
    if (step == 90) {
      simulation.send(AddAssembly{visitor(), "guest", Pose(Vec3(3, 3, 0), Quat(1, 0, 0, 0))});
    }
    if (step == 130) simulation.send(Remove{"guest"});
    if (step == 140) simulation.send(SetStep{2e-3});
  };
}

}  // namespace

TEST_CASE("every frame is read back bit for bit") {
  const std::string backend = GENERATE(engines());
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), backend);
  RecorderOptions options = to(folder / "run.mcap");
  options.attachments = {{"busy.scene.xml", "application/xml", "<scene/>\n"}};
  options.parameters = {{"wheel", "5 cm"}};
  const auto frames = record(*simulation, options, 200, interference(*simulation));
  REQUIRE(frames.size() == 201);

  const auto recording = opened(folder / "run.mcap");
  REQUIRE(recording->frame_count() == frames.size());
  std::size_t contacts = 0, events = 0, valid = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto frame = recording->frame(i);
    REQUIRE(frame);
    INFO("frame " << i);
    REQUIRE(difference(*frames[i], **frame) == "");
    contacts += frames[i]->contacts.size();
    events += frames[i]->events.size();
    for (const Reading& reading : frames[i]->readings) valid += reading.valid ? 1 : 0;
  }
  // The comparison saw something.
  CHECK(contacts > 0);
  CHECK(events >= 2);
  CHECK(valid > 500);

  SECTION("in any order, any number of times") {
    for (const std::size_t i : {200u, 0u, 95u, 94u, 131u, 95u}) {
      CHECK(difference(*frames[i], **recording->frame(i)) == "");
    }
    CHECK_FALSE(recording->frame(201));
  }
  SECTION("models are shared, and distinguished when they change") {
    CHECK((*recording->frame(10))->model == (*recording->frame(20))->model);
    CHECK((*recording->frame(10))->model != (*recording->frame(100))->model);
    CHECK(model_to_json(*(*recording->frame(100))->model) == model_to_json(*frames[100]->model));
  }
  SECTION("times") {
    CHECK(recording->index_at(0.05) == 50);
    CHECK(recording->index_at(0.0509) == 50);
    CHECK(recording->index_at(-1.0) == 0);
    CHECK(recording->index_at(1e9) == 200);
    CHECK(recording->time_of(50) == Approx(0.05).margin(1e-9));
  }
  SECTION("the run's description") {
    const RecordingInfo& info = recording->info();
    CHECK(info.complete);
    CHECK(info.damage == "");
    CHECK(info.scene == "busy");
    CHECK(info.backend == backend);
    CHECK(info.status == "completed");
    CHECK(info.seed == 7);
    CHECK(info.step == 1e-3);
    CHECK(info.frames == 201);
    CHECK(info.dropped == 0);
    CHECK(info.parameters.at("wheel") == "5 cm");
    REQUIRE(info.attachments.size() == 1);
    CHECK(info.attachments[0].data == "<scene/>\n");
    REQUIRE(recording->channels(0).size() == 2);
    CHECK(recording->channels(0)[0].name == "position");
    CHECK(recording->channels(0)[0].unit == "rad");
  }
}

TEST_CASE("readings computed again equal those of the run") {
  const std::string backend = GENERATE(engines());
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), backend, 99);
  const auto frames = record(*simulation, to(folder / "run.mcap"), 200, interference(*simulation));
  const auto recording = opened(folder / "run.mcap");
  std::size_t index = 0;
  const auto done = recording->recompute(*loader(), [&](const Frame& frame) {
    INFO("frame " << index);
    REQUIRE(difference(*frames.at(index), frame) == "");
    ++index;
    return true;
  });
  if (!done) UNSCOPED_INFO(done.error().text());
  REQUIRE(done);
  CHECK(index == frames.size());
}

TEST_CASE("contacts that were not kept are not made up") {
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), "bullet");
  RecorderOptions options = to(folder / "run.mcap");
  options.contacts = false;
  record(*simulation, options, 20);
  const auto done =
      opened(folder / "run.mcap")->recompute(*loader(), [](const Frame&) { return true; });
  REQUIRE_FALSE(done);
  CHECK(done.error().message.find("a sensor needs contacts") != std::string::npos);
}

TEST_CASE("pictures are read back, and can be rendered again") {
  if (!load_renderer(*loader())) COGRSIM_SKIP("there is no renderer in this tree");
  const bool jpeg = GENERATE(false, true);
  const Folder folder;
  ModelBuilder builder = busy_scene();
  SensorModel camera;
  camera.name = "robot.eye";
  camera.type = "camera";
  camera.body = builder.model.sensors[1].body;
  camera.X_BS = Pose(Vec3(0.3, 0, 0.3), Quat(1, 0, 0, 0));
  camera.rate = 100.0;
  camera.assembly = builder.model.sensors[1].assembly;
  for (const char* part : {"color", "depth", "segmentation"}) camera.parameters[part] = true;
  builder.model.sensors.push_back(camera);
  const auto simulation = simulate(builder.build(), "bullet");
  RecorderOptions options = to(folder / "run.mcap");
  options.jpeg = jpeg;
  const auto frames = record(*simulation, options, 60);
  const auto recording = opened(folder / "run.mcap");
  std::size_t pictures = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto frame = recording->frame(i);
    REQUIRE(frame);
    const Reading &was = frames[i]->readings.back(), &is = (*frame)->readings.back();
    REQUIRE(!was.picture == !is.picture);
    if (!was.picture) continue;
    ++pictures;
    REQUIRE(is.picture->depth == was.picture->depth);
    REQUIRE(is.picture->bodies == was.picture->bodies);
    REQUIRE(is.picture->color.data.size() == was.picture->color.data.size());
    if (!jpeg) REQUIRE(difference(*frames[i], **frame) == "");
  }
  CHECK(pictures == 60);
  if (jpeg) return;
  std::size_t index = 0;
  const auto done = recording->recompute(*loader(), [&](const Frame& frame) {
    REQUIRE(difference(*frames.at(index++), frame) == "");
    return true;
  });
  CHECK(done);
}

TEST_CASE("messages of sensors have the times of their measurements") {
  const Folder folder;
  ModelBuilder builder("cart");
  const int cart = builder.box("cart", Vec3(0.2, 0.2, 0.2), 1.0, Pose());
  builder.model.bodies[cart].V_WB.linear = Vec3(1, 0, 0);
  builder.model.physics.gravity = Vec3::Zero();
  builder.model.physics.step = 0.02;
  std::vector<std::string> types = {"pose", "imu", "lidar", "infrared", "contact"};
  if (load_renderer(*loader())) types.push_back("camera");
  for (const std::string& type : types) {
    SensorModel sensor;
    sensor.name = sensor.type = type;
    sensor.body = cart;
    sensor.rate = 10.0;
    if (type == "camera") {
      for (const char* part : {"color", "depth", "segmentation"}) sensor.parameters[part] = true;
    }
    builder.model.sensors.push_back(sensor);
  }
  const auto simulation = simulate(builder.build(), "bullet");
  record(*simulation, to(folder / "run.mcap"), 25, [&](int step) {
    if (step == 18) simulation->send(EnableSensor{"imu", false});
  });
  auto file = mcap::Reader::open(folder / "run.mcap");
  REQUIRE(file);
  constexpr std::uint64_t kPeriod = 100'000'000;
  std::set<std::string> parts;
  for (const auto& [id, channel] : (*file)->channels()) {
    const auto part = channel.metadata.find("part");
    if (part == channel.metadata.end()) continue;
    parts.insert(part->second);
    INFO(channel.topic);
    const auto& locations = (*file)->locations(id);
    const bool off = channel.metadata.at("name") == "imu";
    REQUIRE(locations.size() == 5);
    for (std::size_t i = 0; i < 5; ++i) {
      // Switched off before the step from 0.36 s to 0.38 s: known from then on.
      const std::uint64_t expected = off && i == 4 ? 380'000'000 : i * kPeriod;
      CHECK(locations[i].time == expected);
      const auto chunk = (*file)->chunk(locations[i].chunk);
      REQUIRE(chunk);
      const auto message = mcap::Reader::message_at(**chunk, locations[i].offset);
      REQUIRE(message);
      if (part->second == "reading") {
        const auto record = take_reading(message->data);
        REQUIRE(record);
        CHECK(
            record->reading.time ==
            Approx(0.1 * static_cast<double>(off ? std::min(i, std::size_t{3}) : i)).margin(1e-12));
        REQUIRE(record->reading.pose);
        CHECK(record->reading.pose->p.x() == Approx(record->reading.time).margin(1e-5));
      } else {
        protozero::pbf_reader fields(message->data.data(), message->data.size());
        REQUIRE(fields.next(1));
        protozero::pbf_reader stamp = fields.get_message();
        std::uint64_t time = 0;
        while (stamp.next()) {
          time += stamp.tag() == 1 ? 1'000'000'000 * static_cast<std::uint64_t>(stamp.get_int64())
                                   : static_cast<std::uint64_t>(stamp.get_int32());
        }
        CHECK(time == expected);
      }
    }
  }
  CHECK(parts.count("scan") == 1);
  if (types.back() == "camera") {
    for (const char* part : {"color", "depth", "segmentation"}) CHECK(parts.count(part) == 1);
  }
}

TEST_CASE("fewer frames are kept on request, all readings are") {
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), "bullet");
  RecorderOptions options = to(folder / "run.mcap");
  options.every = 0.01;
  options.contacts = false;
  const auto frames = record(*simulation, options, 205);
  const auto recording = opened(folder / "run.mcap");
  // 0, 10, … 200 ms, and the end at 205 ms.
  REQUIRE(recording->frame_count() == 22);
  for (std::size_t i = 0; i < 21; ++i) {
    CHECK((*recording->frame(i))->step == 10 * i);
    CHECK((*recording->frame(i))->contacts.empty());
  }
  CHECK((*recording->frame(21))->step == 205);
  CHECK((*recording->frame(20))->readings[1].sequence == frames[200]->readings[1].sequence);
  for (const RecordingInfo::Topic& topic : recording->info().topics) {
    if (topic.name == "/sensors/robot/imu") CHECK(topic.messages == 205);
  }
  const auto done = recording->recompute(*loader(), [](const Frame&) { return true; });
  REQUIRE_FALSE(done);
  CHECK(done.error().message.find("not every step was recorded") != std::string::npos);
}

TEST_CASE("a scene model is read back completely") {
  ModelBuilder builder = busy_scene();
  builder.model.materials[0].stiffness = 1e5;
  builder.model.materials[0].texture_size = Eigen::Vector2d(0.1, 1.0 / 3.0);
  builder.model.physics.duration = 0.1 + 0.2;
  builder.model.bodies[1].mass = std::nextafter(1.0, 2.0);
  builder.model.physics.engine_options["bullet"]["list"] = std::vector<double>{1.0, -0.0};
  builder.model.physics.engine_options["bullet"]["n"] = std::int64_t{-3};
  builder.model.physics.engine_options["bullet"]["b"] = true;
  builder.model.physics.engine_options["bullet"]["t"] = std::string("a \"text\"\n");
  builder.model.record = RecordModel{};
  builder.model.plots.push_back({"p", "curve", "title", 0.1, {{"x", "y", "", "l", {}}}, {}});
  const SceneModelPtr model = builder.build();
  const auto again = model_from_json(model_to_json(*model));
  REQUIRE(again);
  CHECK(model_to_json(*again) == model_to_json(*model));
  CHECK(again->bodies[1].mass == model->bodies[1].mass);
  CHECK(again->physics.duration == model->physics.duration);
  CHECK(again->joints[0].axes[0].lower == -std::numeric_limits<double>::infinity());
  CHECK(again->physics.engine_options == model->physics.engine_options);
  CHECK(std::signbit(
      std::get<std::vector<double>>(again->physics.engine_options.at("bullet").at("list"))[1]));
  CHECK(check_model(*model));

  SECTION("one that points nowhere is refused") {
    SceneModel wrong = *model;
    wrong.joints[0].child = 99;
    const auto refused = check_model(wrong);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message == "'robot.axle' has a wrong child");
    std::string bytes;
    put_model(bytes, wrong, 0);
    const auto not_taken = take_model(bytes);
    REQUIRE_FALSE(not_taken);
    CHECK(not_taken.error().message ==
          "the recorded scene is damaged: 'robot.axle' has a wrong child");
    wrong = *model;
    wrong.joints[0].position_offset = -1;
    CHECK_FALSE(check_model(wrong));
    wrong = *model;
    wrong.motors[0].axis = 1;
    CHECK_FALSE(check_model(wrong));
    wrong = *model;
    wrong.regions.emplace_back().body = 99;
    CHECK_FALSE(check_model(wrong));
    wrong = *model;
    wrong.doors.emplace_back().motor = 99;
    CHECK_FALSE(check_model(wrong));
    wrong = *model;
    wrong.supervisors.emplace_back().assembly = 99;
    CHECK_FALSE(check_model(wrong));
  }
  SECTION("a maze has a side for every cell, and its doors are there") {
    SceneModel wrong = *model;
    MazeModel& maze = wrong.mazes.emplace_back();
    maze.rows = maze.columns = 1;
    maze.vertical = maze.horizontal = {MazeModel::kWall, MazeModel::kOpen};
    CHECK(check_model(wrong));
    maze.vertical.back() = 0;
    CHECK_FALSE(check_model(wrong));
    maze.vertical.pop_back();
    CHECK_FALSE(check_model(wrong));
    maze.vertical.push_back(MazeModel::kWall);
    maze.named_cells.push_back({"S", 0, 1});
    CHECK_FALSE(check_model(wrong));
    maze.named_cells.clear();
    maze.rows = maze.columns = std::numeric_limits<int>::max();
    CHECK_FALSE(check_model(wrong));
  }
  CHECK_FALSE(model_from_json("{\"bodies\": 3}"));
  CHECK_FALSE(model_from_json("{\"bodies\": [{\"kind\": 7}]}"));
  CHECK_FALSE(model_from_json("nonsense"));
}

TEST_CASE("the subjects of events and what controllers publish are read back") {
  std::string bytes;
  put_event(bytes, {1.5, "enter", "goal", "", "robot.hand"});
  const auto event = take_event(bytes);
  REQUIRE(event);
  CHECK(event->source == "goal");
  CHECK(event->subject == "robot.hand");

  SceneModel model;
  model.controllers.resize(2);
  model.controllers[0].outputs = {{"plans", "1"}, {"goal", "m"}};
  model.supervisors.resize(1);
  model.supervisors[0].outputs = {{"score", "1"}};
  Frame frame;
  frame.model = std::make_shared<const SceneModel>(model);
  frame.controller_outputs = {{3.0, 0.25}, {}};
  // The supervisor has published nothing: as if it were gone.
  std::string on_file;
  FrameEncoder().frame(on_file, frame, 0, {}, 0, true);
  const auto record = take_frame(on_file);
  REQUIRE(record);
  CHECK(check_frame(*record, model));
  Frame back;
  share_outputs(*record, model, back);
  REQUIRE(back.controller_outputs.size() == 2);
  CHECK(back.controller_outputs[0] == std::vector<double>{3.0, 0.25});
  CHECK(back.controller_outputs[1].empty());
  CHECK(std::isnan(back.supervisor_outputs[0][0]));

  // A file from before there were outputs fits; one with too many does not.
  FrameRecord old = *record;
  old.controller_outputs.clear();
  CHECK(check_frame(old, model));
  share_outputs(old, model, back);
  CHECK(std::isnan(back.controller_outputs[0][1]));
  old.controller_outputs = {1.0};
  CHECK_FALSE(check_frame(old, model));
}

TEST_CASE("a recording shows its own textures, never a file of that name") {
  const Folder folder;
  ModelBuilder builder = busy_scene();
  const std::string kept = folder / "kept.png", other = folder / "other.png";
  write_all(kept, "kept");
  builder.model.materials[0].texture = kept;
  Material material;
  material.texture = other;  // it is not there, so it is not in the recording
  builder.model.materials.push_back(material);
  const auto simulation = simulate(builder.build(), "bullet");
  record(*simulation, to(folder / "run.mcap"), 2);
  write_all(kept, "another program's");
  write_all(other, "secret");
  const auto recording = opened(folder / "run.mcap");
  const auto frame = recording->frame(0);
  REQUIRE(frame);
  const auto& materials = (*frame)->model->materials;
  CHECK(materials.back().texture.empty());
  CHECK(materials[0].texture != kept);
  CHECK(read_all(materials[0].texture) == "kept");
}
