// Writer of MCAP files (https://mcap.dev/spec) that stay readable after disk errors.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/recording/run_stream.h"
#include "recording/mcap/mcap.h"

struct ZSTD_CCtx_s;

namespace cogrsim::mcap {

/// Destination of the bytes: a file that can be truncated.
class Sink {
 public:
  virtual ~Sink() = default;
  /// Appends all bytes. Errors: those of the operating system; the written length is then unknown.
  virtual Result<> append(std::string_view bytes) = 0;
  /// Truncates the file to `size` [byte]; later bytes are appended there.
  virtual Result<> cut(std::uint64_t size) = 0;
};

/// Collects messages in a chunk in memory; flush() compresses the chunk and appends it with its
/// indexes in one piece. After a disk error the file is truncated to the last complete record, so
/// that it stays readable; finish() drops chunks from the end until the summary fits on the disk.
class Writer final : public TopicSink {
 public:
  explicit Writer(std::unique_ptr<Sink> sink, int level = 1);
  ~Writer() override;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  Result<> start(std::string_view profile, std::string_view library);

  /// The records are written with the next chunk.
  std::uint16_t add_schema(std::string name, std::string encoding, std::string data) override;
  std::uint16_t add_channel(std::uint16_t schema, std::string topic, std::string encoding,
                            std::map<std::string, std::string> metadata = {}) override;

  /// A message of the open chunk.
  std::string& begin_message(std::uint16_t channel, std::uint32_t sequence,
                             std::uint64_t time) override;
  void end_message() override;

  std::size_t pending() const { return chunk_.size(); }  ///< bytes of the open chunk
  std::uint64_t written() const { return size_; }        ///< bytes in the file
  /// Number of messages of a channel in the file and in the open chunk.
  std::uint64_t messages(std::uint16_t channel) const;
  /// Number of messages of a channel in the file.
  std::uint64_t messages_on_file(std::uint16_t channel) const;

  /// Writes the open chunk to the file. Errors: those of the sink, or a chunk of more than
  /// kMaxChunkBytes; the chunk is then lost, and the file is unchanged.
  Result<> flush();
  Result<> attachment(std::string_view name, std::string_view media_type, std::string_view data,
                      std::uint64_t time);
  Result<> metadata(std::string_view name, const std::map<std::string, std::string>& entries);

  /// Calls flush() and writes `last` as metadata, the summary and the end. Errors: as flush(), or
  /// the disk has no space for the summary; the file then has no end, and readers must scan it.
  Result<> finish(std::string_view name, const std::map<std::string, std::string>& last);

 private:
  struct ChannelState {
    Channel channel;
    std::uint64_t count = 0;             // number of messages, including the open chunk
    std::vector<MessageLocation> in_chunk;  // of the open chunk
  };
  struct ChunkOnFile {
    ChunkIndex index;
    std::uint64_t size_before = 0;  // of the file
    std::vector<std::pair<std::uint16_t, std::uint64_t>> counts;
  };

  Result<> append(std::string_view bytes);
  void pack_chunk(std::string& out);
  void close_chunk(bool lost);
  std::string summary(std::uint64_t start) const;
  void put_statistics(std::string& out) const;
  void drop_last_chunk();

  std::unique_ptr<Sink> sink_;
  int level_;
  ZSTD_CCtx_s* zstd_ = nullptr;
  std::uint64_t size_ = 0;  // of the file, whole records only
  std::vector<Schema> schemas_;
  std::vector<ChannelState> channels_;
  std::string loose_;          // records for the data section, written before the next chunk
  std::string chunk_, block_;  // the open chunk; a chunk with its accompanying records
  std::uint64_t chunk_start_ = 0, chunk_end_ = 0;
  std::size_t message_start_ = 0;  // of the record that begin_message() has begun
  bool any_message_ = false;  // in the open chunk
  std::vector<ChunkOnFile> chunks_;
  std::vector<AttachmentLocation> attachments_;
  std::vector<MetadataLocation> metadata_;
};

}  // namespace cogrsim::mcap
