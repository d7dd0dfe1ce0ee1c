// A run as tables: bodies.csv, joints.csv, contacts.csv and one per sensor.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "cogrsim/core/output_file.h"
#include "cogrsim/physics/frame.h"
#include "run/frame_json.h"

namespace cogrsim::cli {

class ReplayTables {
 public:
  /// Makes the folder if it is not there. Errors: the system's.
  static Result<std::unique_ptr<ReplayTables>> create(const std::string& folder);

  /// A row for every body, joint coordinate, contact and new reading. Numbers have 17 significant
  /// digits, so that reading them gives the same bits.
  void add(const Frame& frame, const ChannelsOf& channels);
  /// Moves the finished tables to their paths. Errors: the disk is full, or a file is in the way.
  Result<> finish();

 private:
  struct File {
    std::optional<OutputFile> file;
    std::uint64_t sequence = 0;  // of the reading written last
  };

  explicit ReplayTables(std::string folder) : folder_(std::move(folder)) {}
  void note(const Result<>& done);
  File* table(const std::string& name, const std::string& head);

  std::string folder_;
  std::map<std::string, std::unique_ptr<File>> files_;
  Result<> problem_;
};

}  // namespace cogrsim::cli
