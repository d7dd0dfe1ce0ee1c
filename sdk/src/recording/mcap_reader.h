// Reads MCAP files, whole ones by their index, damaged ones chunk by chunk. Trusts no length: what
// is allocated was read, or unpacked, from the file.
#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "recording/mcap.h"

namespace cogrsim::mcap {

class Reader {
 public:
  /// Errors: cannot be read, no MCAP file, MCAP of another version. A truncated or damaged file
  /// opens; damage() says what is wrong with it.
  static Result<std::unique_ptr<Reader>> open(const std::string& path);
  ~Reader();

  struct Message {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
    std::uint64_t time = 0;  ///< log time [ns]
    std::string_view data;   ///< in the chunk
  };
  struct Place {
    std::uint64_t time = 0;
    std::uint32_t chunk = 0;  ///< chunks()
    std::uint32_t offset = 0;
    /// As written where the file had to be scanned, else counted from 0 in each channel.
    std::uint32_t sequence = 0;
  };

  const std::string& profile() const { return profile_; }
  const std::string& library() const { return library_; }
  /// The end is there and every index could be read.
  bool complete() const { return complete_; }
  const std::string& damage() const { return damage_; }
  std::uint64_t size() const { return size_; }
  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  const std::vector<ChunkIndex>& chunks() const { return chunks_; }
  /// Messages of a channel in file order.
  const std::vector<Place>& places(std::uint16_t channel) const;
  const std::vector<AttachmentPlace>& attachments() const { return attachments_; }
  const std::vector<std::pair<std::string, std::map<std::string, std::string>>>& metadata() const {
    return metadata_;
  }

  /// Errors: the file changed, or the bytes are damaged.
  Result<std::string> attachment(const AttachmentPlace& place);
  /// A chunk's records, unpacked and checked against their sum; kept for a while.
  Result<std::shared_ptr<const std::string>> chunk(std::size_t index);
  /// A message of a chunk that chunk() gave.
  static Result<Message> message_at(const std::string& chunk, std::uint32_t offset);

 private:
  struct File;
  explicit Reader(std::unique_ptr<File> file);

  Result<> read_summary();
  void scan();
  bool take_record(Op op, std::string_view content, std::uint64_t offset);
  /// What may still be unpacked and kept while a file is scanned.
  struct ScanRoom {
    std::uint64_t bytes = 0, messages = 0;
    bool full = false;
  };
  bool take_chunk(std::string_view content, std::uint64_t offset, ScanRoom& room);
  bool take_messages(const std::string& records, std::uint64_t& room);
  bool read_message_indexes(std::uint32_t chunk);
  void clear();

  std::unique_ptr<File> file_;
  std::uint64_t size_ = 0;
  std::string profile_, library_, damage_;
  bool complete_ = false;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<ChunkIndex> chunks_;
  std::map<std::uint16_t, std::vector<Place>> places_;
  std::vector<AttachmentPlace> attachments_;
  std::vector<std::pair<std::string, std::map<std::string, std::string>>> metadata_;

  struct Kept {
    std::size_t chunk;
    std::shared_ptr<const std::string> records;
  };
  std::vector<Kept> kept_;  // unpacked chunks, latest last
};

}  // namespace cogrsim::mcap
