#include "run_support.h"

#include <catch2/catch.hpp>

#include <future>
#include <optional>
#include <thread>

#include "cogrsim/dsl/loader_catalog.h"
#include "protocol.h"

namespace cogrsim::studio::test {

namespace {

constexpr auto kPatience = std::chrono::seconds(30);

}  // namespace

Json FakeOutbox::checked(const std::string& text) {
  Json message = Json::parse(text);
  const auto good = check_topic(message);
  if (!good && mismatch_.empty()) mismatch_ = good.error().text();
  return message;
}

std::string FakeOutbox::mismatch() const {
  std::lock_guard lock(mutex_);
  return mismatch_;
}

void FakeOutbox::send(ClientId client, std::string text) {
  std::lock_guard lock(mutex_);
  texts_[client].push_back(checked(text));
}

void FakeOutbox::send_all(std::string text) {
  std::lock_guard lock(mutex_);
  to_all_.push_back(checked(text));
  for (auto& [client, texts] : texts_) texts.push_back(to_all_.back());
}

void FakeOutbox::offer_frame(ClientId client, Bytes frame) {
  std::lock_guard lock(mutex_);
  frames_[client].push_back(std::move(frame));
}

void FakeOutbox::offer_picture(ClientId, const std::string&, Bytes picture) {
  std::lock_guard lock(mutex_);
  pictures_.push_back(std::move(picture));
}

bool FakeOutbox::wants_picture(ClientId) const {
  std::lock_guard lock(mutex_);
  return wanted_;
}

void FakeOutbox::want_pictures(bool wanted) {
  std::lock_guard lock(mutex_);
  wanted_ = wanted;
}

std::size_t FakeOutbox::frame_count(ClientId client) const {
  std::lock_guard lock(mutex_);
  const auto found = frames_.find(client);
  return found == frames_.end() ? 0 : found->second.size();
}

std::size_t FakeOutbox::picture_count() const {
  std::lock_guard lock(mutex_);
  return pictures_.size();
}

Bytes FakeOutbox::last_frame(ClientId client) const {
  std::lock_guard lock(mutex_);
  const auto found = frames_.find(client);
  return found == frames_.end() || found->second.empty() ? nullptr : found->second.back();
}

Bytes FakeOutbox::last_picture() const {
  std::lock_guard lock(mutex_);
  return pictures_.empty() ? nullptr : pictures_.back();
}

Json FakeOutbox::published(const std::string& topic) const {
  std::lock_guard lock(mutex_);
  for (auto text = to_all_.rbegin(); text != to_all_.rend(); ++text) {
    if (text->at("topic") == topic) return *text;
  }
  return {};
}

std::vector<Json> FakeOutbox::all(ClientId client, const std::string& topic) const {
  std::lock_guard lock(mutex_);
  std::vector<Json> out;
  const auto found = texts_.find(client);
  if (found == texts_.end()) return out;
  for (const Json& text : found->second) {
    if (text.at("topic") == topic) out.push_back(text);
  }
  return out;
}

Json FakeOutbox::last(ClientId client, const std::string& topic) const {
  const std::vector<Json> found = all(client, topic);
  return found.empty() ? Json() : found.back();
}

bool FakeOutbox::wait(const std::function<bool()>& holds) const {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

ReadFrame read_frame(const std::string& bytes) {
  ReadFrame out;
  const auto number = [&](std::size_t offset, auto kind) {
    decltype(kind) value;
    REQUIRE(offset + sizeof value <= bytes.size());
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
  };
  REQUIRE(number(0, std::uint8_t{}) == 1);
  const auto flags = number(1, std::uint8_t{});
  out.live = (flags & 1) != 0;
  out.ghost = (flags & 2) != 0;
  CHECK((flags & ~3) == 0);
  CHECK(number(2, std::uint16_t{}) == 0);
  out.scene = number(4, std::uint32_t{});
  out.time = number(8, double{});
  out.step = number(16, double{});
  const auto n = number(24, std::uint32_t{}), m = number(28, std::uint32_t{}),
             t = number(32, std::uint32_t{});
  CHECK(number(36, std::uint32_t{}) == 0);
  REQUIRE(bytes.size() == 40 + std::size_t{28} * n + std::size_t{28} * m + t);
  for (std::size_t i = 0; i < std::size_t{7} * n; ++i) {
    out.poses.push_back(number(40 + 4 * i, float{}));
  }
  for (std::size_t i = 0; i < std::size_t{7} * m; ++i) {
    out.ghost_poses.push_back(number(40 + std::size_t{28} * n + 4 * i, float{}));
  }
  out.tail = t == 0 ? Json() : Json::parse(bytes.substr(bytes.size() - t));
  return out;
}

Scene scene_of(const std::string& xml, std::uint64_t version) {
  // Parameters of plugins need a catalog. Without one their names go unchecked, for the engine to refuse.
  dsl::LoaderCatalog plugins;
  dsl::CompileOptions options;
  if (xml.find("<set ") != std::string::npos) options.plugins = &plugins;
  const dsl::CompileResult compiled = dsl::compile_text(xml, "test.scene.xml", options);
  INFO(dsl::to_text(compiled.diagnostics));
  REQUIRE(compiled.ok());
  Scene scene;
  scene.model = compiled.model;
  scene.origins.version = version;
  for (std::size_t i = 0; i < compiled.model->bodies.size(); ++i) {
    scene.origins.bodies.push_back({static_cast<int>(10 + i), true});
  }
  return scene;
}

Page::Page(RunOptions options, std::shared_ptr<PluginLoader> loader)
    : own_outbox_(std::make_unique<FakeOutbox>()),
      outbox_(own_outbox_.get()),
      run_(Run::of_scene(std::move(options), std::move(loader), *outbox_)) {}

Page::Page(std::unique_ptr<Run> run, FakeOutbox& outbox) : outbox_(&outbox), run_(std::move(run)) {}

Page::~Page() = default;

std::vector<std::string> Page::show(const std::string& xml, std::uint64_t version) {
  const std::size_t published = outbox_->all(1, "scene").size();
  std::promise<tl::expected<std::vector<std::string>, std::vector<Diagnostic>>> promise;
  auto future = promise.get_future();
  run_->show(scene_of(xml, version), [&](auto shown) { promise.set_value(std::move(shown)); });
  REQUIRE(future.wait_for(kPatience) == std::future_status::ready);
  auto shown = future.get();
  if (!shown) FAIL(dsl::to_text(shown.error()));
  // The page receives it a little later.
  if (!status().is_null())
    REQUIRE(outbox_->wait([&] { return outbox_->all(1, "scene").size() > published; }));
  return *shown;
}

std::string Page::refused(const std::string& xml) {
  // It is called again when an engine takes the scene after all.
  using Shown = tl::expected<std::vector<std::string>, std::vector<Diagnostic>>;
  const auto promise = std::make_shared<std::optional<std::promise<Shown>>>(std::in_place);
  auto future = (*promise)->get_future();
  run_->show(scene_of(xml), [promise](auto shown) {
    if (*promise) (*promise)->set_value(std::move(shown));
    promise->reset();
  });
  REQUIRE(future.wait_for(kPatience) == std::future_status::ready);
  const auto shown = future.get();
  REQUIRE(!shown);
  return dsl::to_text(shown.error());
}

void Page::join(ClientId client, Role role) {
  run_->joined(client, role);
  REQUIRE(outbox_->wait([&] { return !outbox_->last(client, "status").is_null(); }));
}

void Page::leave(ClientId client) { run_->left(client); }

Answer Page::ask(const std::string& what, Json fields, ClientId client) {
  const ProtocolRequest* const request = find_request(what);
  REQUIRE(request);
  REQUIRE(run_->answers(request->section));
  if (auto good = check_fields(*request, fields); !good) return tl::unexpected(good.error());
  auto promise = std::make_shared<std::promise<Answer>>();
  auto future = promise->get_future();
  run_->handle({client, Role::operator_, what, std::move(fields)},
               [promise](Answer answer) { promise->set_value(std::move(answer)); });
  REQUIRE(future.wait_for(kPatience) == std::future_status::ready);
  Answer answer = future.get();
  if (answer) {
    const auto good = check_answer(what, *answer);
    INFO((good ? std::string() : good.error().text()));
    CHECK(good);
  }
  CHECK(outbox_->mismatch() == "");
  return answer;
}

Json Page::get(const std::string& what, Json fields, ClientId client) {
  const Answer answer = ask(what, std::move(fields), client);
  if (!answer) FAIL(what << ": " << answer.error().text());
  return *answer;
}

std::string Page::error(const std::string& what, Json fields, ClientId client) {
  const Answer answer = ask(what, std::move(fields), client);
  if (answer) FAIL(what << " was not refused: " << *answer);
  return answer.error().message;
}

Json Page::status(const std::string& state) {
  INFO("waiting for state " << state);
  const bool came = outbox_->wait([&] {
    const Json now = status();
    return !now.is_null() && now.at("state") == state;
  });
  if (!came) FAIL("the run did not get to state " << state << ": " << status());
  return status();
}

Json Page::status() { return outbox_->last(1, "status"); }

std::string Page::hash_after(int steps) {
  REQUIRE(outbox_->wait([&] {
    const Json now = status();
    return !now.is_null() && now.at("state") != "playing" && now.at("step_count") == steps &&
           now.at("state_hash") != "";
  }));
  return status().at("state_hash").get<std::string>();
}

std::string small_scene() {
  return R"(<scene name="small" version="1">
  <physics step="1 ms"/>
  <box name="plate" static="true" size="2 2 0.1" xyz="0 0 -0.05"/>
  <sphere name="ball" radius="5 cm" xyz="0.1 0 0.3" linear-velocity="0.5 0.1 0"/>
  <assembly name="swing" xyz="0 -0.5 1.5">
    <capsule name="rod" radius="1 cm" length="60 cm" xyz="0 0 -0.3"/>
    <hinge name="pivot" child="rod" frame="swing" axis="0 1 0" position="60 deg"/>
  </assembly>
</scene>)";
}

}  // namespace cogrsim::studio::test
