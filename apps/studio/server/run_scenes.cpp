#include "run_scenes.h"

#include <algorithm>

#include "scene_json.h"

namespace cogrsim::studio {

namespace {

/// Texts of scenes that are kept: clients that look at different times may need different ones.
constexpr std::size_t kTopicsKept = 4;

}  // namespace

ChannelLookup SceneRecord::lookup() const {
  return [this](int sensor) -> const std::vector<Channel>* {
    const auto i = static_cast<std::size_t>(sensor);
    return sensor >= 0 && i < channels.size() ? &channels[i] : nullptr;
  };
}

std::uint32_t Scenes::add(SceneModelPtr model, OriginsPtr origins, bool same_lineage,
                          const std::function<const std::vector<Channel>&(int)>& channels) {
  auto record = std::make_shared<SceneRecord>();
  record->model = std::move(model);
  record->origins = origins ? std::move(origins) : std::make_shared<const Origins>();
  for (std::size_t i = 0; i < record->model->sensors.size(); ++i) {
    record->channels.push_back(channels(static_cast<int>(i)));
  }
  std::lock_guard lock(mutex_);
  if (!same_lineage) ++lineage_;
  record->lineage = lineage_;
  record->number = ++last_;
  for (const Material& material : record->model->materials) {
    if (!material.texture.empty()) asset_number(material.texture);
  }
  records_[last_] = std::move(record);
  return last_;
}

SceneRecordPtr Scenes::get(std::uint32_t number) const {
  std::lock_guard lock(mutex_);
  const auto found = records_.find(number);
  return found == records_.end() ? nullptr : found->second;
}

SceneRecordPtr Scenes::newest() const {
  std::lock_guard lock(mutex_);
  return records_.empty() ? nullptr : records_.rbegin()->second;
}

void Scenes::forget() {
  std::lock_guard lock(mutex_);
  while (records_.size() > 1) records_.erase(records_.begin());
}

std::shared_ptr<const std::string> Scenes::topic(std::uint32_t number) {
  SceneRecordPtr record;
  std::map<std::string, std::size_t> assets;
  {
    std::lock_guard lock(mutex_);
    const auto made = std::find_if(topics_.begin(), topics_.end(),
                                   [&](const auto& topic) { return topic.first == number; });
    if (made != topics_.end()) return made->second;
    const auto found = records_.find(number);
    if (found == records_.end()) return nullptr;
    record = found->second;
    assets = asset_numbers_;
  }
  auto text = std::make_shared<const std::string>(to_text(scene_json(*record, assets)));
  std::lock_guard lock(mutex_);
  if (topics_.size() >= kTopicsKept) topics_.erase(topics_.begin());
  topics_.emplace_back(number, text);
  return text;
}

std::string Scenes::asset(std::size_t number) const {
  std::lock_guard lock(mutex_);
  return number < assets_.size() ? assets_[number] : std::string();
}

std::size_t Scenes::asset_number(const std::string& path) {
  const auto [entry, added] = asset_numbers_.emplace(path, assets_.size());
  if (added) assets_.push_back(path);
  return entry->second;
}

}  // namespace cogrsim::studio
