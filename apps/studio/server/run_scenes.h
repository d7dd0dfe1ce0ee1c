// The scenes a run has had, by number: every edit makes another, and everything added or removed.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "cogrsim/sensing/sensor.h"
#include "cogrsim/signals/signal.h"
#include "run.h"

namespace cogrsim::studio {

using OriginsPtr = std::shared_ptr<const Origins>;

struct SceneRecord {
  std::uint32_t number = 0;
  /// The same for a scene and for its changes during the run: indices into the model then hold
  /// from one to the next.
  std::uint32_t lineage = 0;
  SceneModelPtr model;
  OriginsPtr origins;
  std::vector<std::vector<Channel>> channels;  ///< by sensor

  /// Valid as long as this record.
  ChannelLookup lookup() const;
};
using SceneRecordPtr = std::shared_ptr<const SceneRecord>;

/// From any thread.
class Scenes {
 public:
  /// The new scene's number; counts from 1. `channels`: called for each sensor.
  std::uint32_t add(SceneModelPtr model, OriginsPtr origins, bool same_lineage,
                    const std::function<const std::vector<Channel>&(int)>& channels);
  /// nullptr: it was dropped.
  SceneRecordPtr get(std::uint32_t number) const;
  SceneRecordPtr newest() const;
  /// Drops all but the newest: none of their frames can be viewed any more.
  void forget();

  /// The `scene` message, made once as long as few scenes are viewed.
  std::shared_ptr<const std::string> topic(std::uint32_t number);

  /// The file of a texture, "" for none.
  std::string asset(std::size_t number) const;

 private:
  std::size_t asset_number(const std::string& path);

  mutable std::mutex mutex_;
  std::map<std::uint32_t, SceneRecordPtr> records_;
  std::uint32_t last_ = 0, lineage_ = 0;
  std::vector<std::string> assets_;
  std::map<std::string, std::size_t> asset_numbers_;
  std::vector<std::pair<std::uint32_t, std::shared_ptr<const std::string>>> topics_;
};

}  // namespace cogrsim::studio
