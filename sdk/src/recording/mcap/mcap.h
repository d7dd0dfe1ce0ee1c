// The MCAP container, version 0 (https://mcap.dev/spec): common definitions of writer and reader.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace cogrsim::mcap {

/// Magic bytes at the start and the end of the file; the sixth byte is the version.
inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);

enum class Op : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  attachment = 9,
  attachment_index = 10,
  statistics = 11,
  metadata = 12,
  metadata_index = 13,
  summary_offset = 14,
  data_end = 15
};

/// Size of the opcode and the length before every record [byte].
inline constexpr std::size_t kRecordHead = 9;
inline constexpr std::size_t kFooterSize = kRecordHead + 20;

/// Largest uncompressed size of a chunk [byte]; a larger one is damaged or malicious.
inline constexpr std::uint64_t kMaxChunkBytes = 1ull << 30;

/// Limits for scanning a file without an index: the uncompressed size in bytes and relative to the
/// size of the file, and the number of messages in addition to one per 8 bytes of the file. zstd
/// compresses a gigabyte of zeros to 100 kB, but recordings at most to a fiftieth.
inline constexpr std::uint64_t kScanBytes = 1ull << 30;
inline constexpr std::uint64_t kScanRatio = 100;
inline constexpr std::uint64_t kScanMessages = 4'000'000;

struct Schema {
  std::uint16_t id = 0;
  std::string name, encoding, data;
};

struct Channel {
  std::uint16_t id = 0, schema = 0;
  std::string topic, encoding;
  std::map<std::string, std::string> metadata;
};

struct MessageLocation {
  std::uint64_t time = 0;    ///< log time [ns]
  std::uint64_t offset = 0;  ///< of the record in the uncompressed chunk
};

struct ChunkIndex {
  std::uint64_t start_time = 0, end_time = 0;            ///< [ns]
  std::uint64_t offset = 0, length = 0;                  ///< of the record with its header
  std::map<std::uint16_t, std::uint64_t> index_offsets;  ///< of each channel's message index
  std::uint64_t index_length = 0;                        ///< of all of them
  std::string compression;
  std::uint64_t packed_size = 0, size = 0;
};

struct AttachmentLocation {
  std::uint64_t offset = 0, length = 0;
  std::uint64_t log_time = 0, create_time = 0, size = 0;
  std::string name, media_type;
};

struct MetadataLocation {
  std::uint64_t offset = 0, length = 0;
  std::string name;
};

/// CRC-32 of `bytes` as in zlib, continued from `crc`.
std::uint32_t crc32(std::string_view bytes, std::uint32_t crc = 0);

}  // namespace cogrsim::mcap
