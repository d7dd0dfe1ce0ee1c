#include <nlohmann/json.hpp>

#include "../../support/snapshot_sum.h"
#include "cogrsim/dsl/compiler.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "targets.h"
#include "toy_scene.h"

namespace cogrsim::fuzz {
namespace {

// As a clever forger would: the checksum in the file fits its content.
std::string with_sum(std::string_view input) {
  using Json = nlohmann::ordered_json;
  Json file = Json::parse(input, nullptr, false);
  if (!file.is_object() || !file.contains("content")) return {};
  file["checksum"] = snapshot_sum(file["content"]);
  return file.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void go_on(std::string_view bytes) {
  const MemoryFile file(bytes);
  const auto snapshot = SnapshotFile::read(file.path());
  if (!snapshot) return require(!snapshot.error().message.empty(), "a refusal has a reason");
  require(snapshot->info().step > 0.0 && snapshot->info().time >= 0.0, "its clock can be");
  SimulationOptions options;
  options.backend = "toy";
  const auto resumed = resume(*snapshot, toy_scene(), options, toy_loader());
  if (!resumed) return require(!resumed.error().empty(), "a refusal has a reason");
  for (int i = 0; i < 3; ++i) resumed->simulation->step();
  resumed->simulation->frame();
}

}  // namespace

void snapshot(std::string_view input) {
  if (input.size() > (64u << 10)) return;
  go_on(input);
  const std::string forged = with_sum(input);
  if (!forged.empty()) go_on(forged);
}

}  // namespace cogrsim::fuzz
