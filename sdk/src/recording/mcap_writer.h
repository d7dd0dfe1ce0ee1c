// Writes MCAP files (https://mcap.dev/spec) that stay valid whatever happens to the disk.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cogrsim/core/result.h"
#include "recording/mcap.h"

struct ZSTD_CCtx_s;

namespace cogrsim::mcap {

/// Where bytes go: a file that can be cut back.
class Sink {
 public:
  virtual ~Sink() = default;
  /// Appends all of it. Errors: the system's; how much arrived is then not known.
  virtual Result<> append(std::string_view bytes) = 0;
  /// Cuts the file to `size` [byte] and goes on from there.
  virtual Result<> cut(std::uint64_t size) = 0;
};

/// Messages gather in a chunk in memory; flush() compresses it and appends it with its indexes in
/// one piece. When the disk refuses, the file is cut back to the last whole record, so that what is
/// on it can be read; finish() gives up chunks from the end until the summary has room.
class Writer {
 public:
  explicit Writer(std::unique_ptr<Sink> sink, int level = 1);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  Result<> start(std::string_view profile, std::string_view library);

  /// Ids count from 1. The records go on file with the next chunk.
  std::uint16_t add_schema(std::string name, std::string encoding, std::string data);
  std::uint16_t add_channel(std::uint16_t schema, std::string topic, std::string encoding,
                            std::map<std::string, std::string> metadata = {});

  /// Appends a message to the chunk: `fill` adds its bytes to the string it is given.
  template <class Fill>
  void message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time, Fill&& fill) {
    const std::size_t at = begin_message(channel, sequence, time);
    fill(chunk_);
    end_message(at);
  }

  std::size_t pending() const { return chunk_.size(); }  ///< bytes of the open chunk
  std::uint64_t written() const { return size_; }        ///< bytes in the file
  /// Messages of a channel that are in the file or in the open chunk.
  std::uint64_t messages(std::uint16_t channel) const;
  /// Messages of a channel that are in the file.
  std::uint64_t messages_on_file(std::uint16_t channel) const;

  /// Puts the open chunk on file. Errors: the sink's, or a chunk of more than kMaxChunkBytes; the
  /// chunk is then lost, the file as it was before.
  Result<> flush();
  Result<> attachment(std::string_view name, std::string_view media_type, std::string_view data,
                      std::uint64_t time);
  Result<> metadata(std::string_view name, const std::map<std::string, std::string>& entries);

  /// flush(), then `last` as metadata, the summary and the end. Errors: as flush(), or there is no
  /// room even for the summary; the file then lacks its end and readers scan it.
  Result<> finish(std::string_view name, const std::map<std::string, std::string>& last);

 private:
  struct ChannelState {
    Channel channel;
    std::uint64_t count = 0;             // messages, those of the open chunk included
    std::vector<MessagePlace> in_chunk;  // of the open chunk
  };
  struct ChunkOnFile {
    ChunkIndex index;
    std::uint64_t size_before = 0;  // of the file
    std::vector<std::pair<std::uint16_t, std::uint64_t>> counts;
  };

  std::size_t begin_message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time);
  void end_message(std::size_t at);
  Result<> append(std::string_view bytes);
  void pack_chunk(std::string& out);
  void close_chunk(bool lost);
  std::string summary(std::uint64_t start) const;
  void drop_last_chunk();

  std::unique_ptr<Sink> sink_;
  int level_;
  ZSTD_CCtx_s* zstd_ = nullptr;
  std::uint64_t size_ = 0;  // of the file, whole records only
  std::vector<Schema> schemas_;
  std::vector<ChannelState> channels_;
  std::string loose_;          // records for the data section that go in front of the next chunk
  std::string chunk_, block_;  // the open chunk; a chunk with all that goes on file with it
  std::uint64_t chunk_start_ = 0, chunk_end_ = 0;
  bool any_message_ = false;  // in the open chunk
  std::vector<ChunkOnFile> chunks_;
  std::vector<AttachmentPlace> attachments_;
  std::vector<MetadataPlace> metadata_;
};

}  // namespace cogrsim::mcap
