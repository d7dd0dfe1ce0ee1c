// Reader of MCAP files: complete files through their index, damaged ones chunk by chunk. It does
// not trust any stated length: memory is only allocated for bytes that were actually read or
// decompressed.
#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "recording/mcap/mcap.h"

namespace cogrsim::mcap {

class ByteReader;

class Reader {
 public:
  /// Opens a file. A truncated or damaged file opens, too; damage() describes the damage. Errors:
  /// the file cannot be read, is not an MCAP file, or has another MCAP version.
  static Result<std::unique_ptr<Reader>> open(const std::string& path);
  ~Reader();

  struct Message {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
    std::uint64_t time = 0;  ///< log time [ns]
    std::string_view data;   ///< view into the chunk
  };
  struct Location {
    std::uint64_t time = 0;
    std::uint32_t chunk = 0;  ///< index of the chunk
    std::uint32_t offset = 0;
    /// The written number if the file was scanned, otherwise counted from 0 in each channel.
    std::uint32_t sequence = 0;
  };

  const std::string& profile() const { return profile_; }
  const std::string& library() const { return library_; }
  /// Whether the file has its end and all indexes are readable.
  bool complete() const { return complete_; }
  const std::string& damage() const { return damage_; }
  std::uint64_t size() const { return size_; }
  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  const std::vector<ChunkIndex>& chunks() const { return chunks_; }
  /// Messages of a channel in the order of the file.
  const std::vector<Location>& locations(std::uint16_t channel) const;
  const std::vector<AttachmentLocation>& attachments() const { return attachments_; }
  const std::vector<std::pair<std::string, std::map<std::string, std::string>>>& metadata() const {
    return metadata_;
  }

  /// Reads an attachment. Errors: the file was changed, or the bytes are damaged.
  Result<std::string> attachment(const AttachmentLocation& location);
  /// The uncompressed records of a chunk, with verified checksum; cached for some time.
  Result<std::shared_ptr<const std::string>> chunk(std::size_t index);
  /// A message of a chunk that chunk() has returned.
  static Result<Message> message_at(const std::string& chunk, std::uint32_t offset);

 private:
  struct File;
  explicit Reader(std::unique_ptr<File> file);

  /// Bytes that indexes may still request: none twice, so all together are limited to the file's.
  struct ByteBudget {
    std::uint64_t left;
    bool take(std::uint64_t bytes) {
      if (bytes > left) return false;
      left -= bytes;
      return true;
    }
  };
  Result<std::string> summary_records();
  Result<> read_summary();
  bool take_chunk_index(ByteReader& fields, ByteBudget& budget);
  bool take_attachment_index(ByteReader& fields, ByteBudget& budget);
  void scan();
  bool take_record(Op op, std::string_view content, std::uint64_t offset);
  /// Remaining limits while a file is scanned.
  struct ScanLimits {
    std::uint64_t bytes = 0, messages = 0;
    bool full = false;
  };
  bool take_chunk(std::string_view content, std::uint64_t offset, ScanLimits& limits);
  bool take_messages(const std::string& records, std::uint64_t& limit);
  bool read_message_indexes(std::uint32_t chunk);
  void clear();

  std::unique_ptr<File> file_;
  std::uint64_t size_ = 0;
  std::string profile_, library_, damage_;
  bool complete_ = false;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<ChunkIndex> chunks_;
  std::map<std::uint16_t, std::vector<Location>> locations_;
  std::vector<AttachmentLocation> attachments_;
  std::vector<std::pair<std::string, std::map<std::string, std::string>>> metadata_;

  struct CachedChunk {
    std::size_t chunk;
    std::shared_ptr<const std::string> records;
  };
  std::vector<CachedChunk> cache_;  // cached uncompressed chunks, latest last
};

}  // namespace cogrsim::mcap
