// A run as tables: bodies.csv, joints.csv, contacts.csv and one per sensor.
#pragma once

#include <cstdio>
#include <map>
#include <memory>
#include <string>

#include "cogrsim/core/result.h"
#include "cogrsim/physics/frame.h"
#include "frame_json.h"

namespace cogrsim::cli {

class ReplayTables {
 public:
  /// Makes the folder if it is not there. Errors: the system's.
  static Result<std::unique_ptr<ReplayTables>> create(const std::string& folder);

  /// A row for every body, joint coordinate, contact and new reading. Numbers have 17 significant
  /// digits, so that reading them gives the same bits.
  void add(const Frame& frame, const ChannelsOf& channels);
  /// Errors: the disk is full.
  Result<> finish();

 private:
  struct File {
    std::FILE* file = nullptr;
    std::uint64_t sequence = 0;  // of the reading written last
    ~File();
  };

  explicit ReplayTables(std::string folder) : folder_(std::move(folder)) {}
  File* table(const std::string& name, const std::string& head);

  std::string folder_;
  std::map<std::string, std::unique_ptr<File>> files_;
  std::string problem_;
};

}  // namespace cogrsim::cli
