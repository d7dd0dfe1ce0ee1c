// The MCAP container, version 0 (https://mcap.dev/spec): what writer and reader share.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace cogrsim::mcap {

/// The file starts and ends with it; the sixth byte is the version.
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

/// Opcode and length in front of every record.
inline constexpr std::size_t kRecordHead = 9;
inline constexpr std::size_t kFooterSize = kRecordHead + 20;

/// No chunk is larger once unpacked [byte]: what claims to be is damaged, or meant to be harmful.
inline constexpr std::uint64_t kMaxChunkBytes = 1ull << 30;

/// A file without an index is unpacked chunk by chunk up to this much: so many bytes, and so many times
/// its own size; and has no more messages than these and one for each 8 of its bytes. zstd packs a
/// gigabyte of zeros into 100 kB, and recordings to a fiftieth at most.
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

struct MessagePlace {
  std::uint64_t time = 0;    ///< log time [ns]
  std::uint64_t offset = 0;  ///< of the record, in the unpacked chunk
};

struct ChunkIndex {
  std::uint64_t start_time = 0, end_time = 0;            ///< [ns]
  std::uint64_t offset = 0, length = 0;                  ///< of the record, with its head
  std::map<std::uint16_t, std::uint64_t> index_offsets;  ///< of each channel's message index
  std::uint64_t index_length = 0;                        ///< of all of them
  std::string compression;
  std::uint64_t packed_size = 0, size = 0;
};

struct AttachmentPlace {
  std::uint64_t offset = 0, length = 0;
  std::uint64_t log_time = 0, create_time = 0, size = 0;
  std::string name, media_type;
};

struct MetadataPlace {
  std::uint64_t offset = 0, length = 0;
  std::string name;
};

/// CRC-32 as in zlib, over `bytes`, continued from `crc`.
std::uint32_t crc32(std::string_view bytes, std::uint32_t crc = 0);

}  // namespace cogrsim::mcap
