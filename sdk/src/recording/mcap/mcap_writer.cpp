#include "recording/mcap/mcap_writer.h"

#include <algorithm>

#include <zlib.h>
#include <zstd.h>

#include "recording/mcap/bytes.h"

namespace cogrsim::mcap {

namespace {

// Starts a record; its length is filled in at its end.
std::size_t begin_record(std::string& out, Op op) {
  out.push_back(static_cast<char>(op));
  put(out, std::uint64_t{0});
  return out.size();
}

void end_record(std::string& out, std::size_t content) {
  put_at(out, content - sizeof(std::uint64_t), static_cast<std::uint64_t>(out.size() - content));
}

// Arrays and maps have a 32-bit length in bytes before the entries.
std::size_t begin_list(std::string& out) {
  put(out, std::uint32_t{0});
  return out.size();
}

void end_list(std::string& out, std::size_t content) {
  put_at(out, content - sizeof(std::uint32_t), static_cast<std::uint32_t>(out.size() - content));
}

void put_map(std::string& out, const std::map<std::string, std::string>& entries) {
  const std::size_t list = begin_list(out);
  for (const auto& [key, value] : entries) {
    put_text(out, key);
    put_text(out, value);
  }
  end_list(out, list);
}

void put_schema(std::string& out, const Schema& schema) {
  const std::size_t record = begin_record(out, Op::schema);
  put(out, schema.id);
  put_text(out, schema.name);
  put_text(out, schema.encoding);
  put_text(out, schema.data);
  end_record(out, record);
}

void put_channel(std::string& out, const Channel& channel) {
  const std::size_t record = begin_record(out, Op::channel);
  put(out, channel.id);
  put(out, channel.schema);
  put_text(out, channel.topic);
  put_text(out, channel.encoding);
  put_map(out, channel.metadata);
  end_record(out, record);
}

void put_chunk_index(std::string& out, const ChunkIndex& index) {
  const std::size_t record = begin_record(out, Op::chunk_index);
  put(out, index.start_time);
  put(out, index.end_time);
  put(out, index.offset);
  put(out, index.length);
  const std::size_t list = begin_list(out);
  for (const auto& [channel, offset] : index.index_offsets) {
    put(out, channel);
    put(out, offset);
  }
  end_list(out, list);
  put(out, index.index_length);
  put_text(out, index.compression);
  put(out, index.packed_size);
  put(out, index.size);
  end_record(out, record);
}

}  // namespace

std::uint32_t crc32(std::string_view bytes, std::uint32_t crc) {
  return static_cast<std::uint32_t>(
      ::crc32_z(crc, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

Writer::Writer(std::unique_ptr<Sink> sink, int level)
    : sink_(std::move(sink)), level_(level), zstd_(ZSTD_createCCtx()) {}

Writer::~Writer() { ZSTD_freeCCtx(zstd_); }

Result<> Writer::append(std::string_view bytes) {
  if (auto done = sink_->append(bytes); !done) {
    static_cast<void>(sink_->cut(size_));  // an incomplete record would hide the following ones
    return done;
  }
  size_ += bytes.size();
  return {};
}

Result<> Writer::start(std::string_view profile, std::string_view library) {
  std::string out(kMagic);
  const std::size_t record = begin_record(out, Op::header);
  put_text(out, profile);
  put_text(out, library);
  end_record(out, record);
  return append(out);
}

std::uint16_t Writer::add_schema(std::string name, std::string encoding, std::string data) {
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
  schemas_.push_back({id, std::move(name), std::move(encoding), std::move(data)});
  put_schema(loose_, schemas_.back());
  return id;
}

std::uint16_t Writer::add_channel(std::uint16_t schema, std::string topic, std::string encoding,
                                  std::map<std::string, std::string> metadata) {
  ChannelState state;
  state.channel = {static_cast<std::uint16_t>(channels_.size() + 1), schema, std::move(topic),
                   std::move(encoding), std::move(metadata)};
  channels_.push_back(std::move(state));
  put_channel(loose_, channels_.back().channel);
  return channels_.back().channel.id;
}

std::string& Writer::begin_message(std::uint16_t channel, std::uint32_t sequence,
                                   std::uint64_t time) {
  ChannelState& state = channels_[channel - 1u];
  state.in_chunk.push_back({time, chunk_.size()});
  ++state.count;
  chunk_start_ = any_message_ ? std::min(chunk_start_, time) : time;
  chunk_end_ = any_message_ ? std::max(chunk_end_, time) : time;
  any_message_ = true;
  message_start_ = begin_record(chunk_, Op::message);
  put(chunk_, channel);
  put(chunk_, sequence);
  put(chunk_, time);
  put(chunk_, time);
  return chunk_;
}

void Writer::end_message() { end_record(chunk_, message_start_); }

std::uint64_t Writer::messages(std::uint16_t channel) const {
  return channels_[channel - 1u].count;
}

std::uint64_t Writer::messages_on_file(std::uint16_t channel) const {
  const ChannelState& state = channels_[channel - 1u];
  return state.count - state.in_chunk.size();
}

// Appends the chunk record and its message indexes for the file offset size_ + out.size().
void Writer::pack_chunk(std::string& out) {
  ChunkOnFile done;
  ChunkIndex& index = done.index;
  index.start_time = chunk_start_;
  index.end_time = chunk_end_;
  index.offset = size_ + out.size();
  index.size = chunk_.size();
  index.compression = "zstd";
  done.size_before = size_;

  const std::size_t chunk = begin_record(out, Op::chunk);
  put(out, chunk_start_);
  put(out, chunk_end_);
  put(out, static_cast<std::uint64_t>(chunk_.size()));
  put(out, crc32(chunk_));
  put_text(out, index.compression);
  put(out, std::uint64_t{0});
  const std::size_t data = out.size();
  out.resize(data + ZSTD_compressBound(chunk_.size()));
  // Compression cannot fail with a valid context and a buffer of the maximum size.
  const std::size_t packed =
      ZSTD_compressCCtx(zstd_, &out[data], out.size() - data, chunk_.data(), chunk_.size(), level_);
  out.resize(data + (ZSTD_isError(packed) ? 0 : packed));
  index.packed_size = out.size() - data;
  put_at(out, data - sizeof(std::uint64_t), index.packed_size);
  end_record(out, chunk);
  index.length = out.size() - (chunk - kRecordHead);

  const std::size_t indexes = out.size();
  for (ChannelState& state : channels_) {
    if (state.in_chunk.empty()) continue;
    index.index_offsets[state.channel.id] = size_ + out.size();
    const std::size_t record = begin_record(out, Op::message_index);
    put(out, state.channel.id);
    const std::size_t list = begin_list(out);
    for (const MessageLocation& location : state.in_chunk) {
      put(out, location.time);
      put(out, location.offset);
    }
    end_list(out, list);
    end_record(out, record);
    done.counts.emplace_back(state.channel.id, state.in_chunk.size());
  }
  index.index_length = out.size() - indexes;
  chunks_.push_back(std::move(done));
}

void Writer::close_chunk(bool lost) {
  for (ChannelState& state : channels_) {
    if (lost) state.count -= state.in_chunk.size();
    state.in_chunk.clear();
  }
  chunk_.clear();
  any_message_ = false;
}

Result<> Writer::flush() {
  if (!any_message_ && loose_.empty()) return {};
  if (chunk_.size() > kMaxChunkBytes) {
    close_chunk(true);
    return fail("a message is larger than a recording can hold (1 GiB)");
  }
  block_.clear();
  block_.swap(loose_);
  const bool with_chunk = any_message_;
  if (with_chunk) pack_chunk(block_);
  auto done = append(block_);
  if (!done && with_chunk) chunks_.pop_back();
  close_chunk(!done);
  return done;
}

Result<> Writer::attachment(std::string_view name, std::string_view media_type,
                            std::string_view data, std::uint64_t time) {
  std::string out;
  const std::size_t record = begin_record(out, Op::attachment);
  put(out, time);
  put(out, std::uint64_t{0});
  put_text(out, name);
  put_text(out, media_type);
  put(out, static_cast<std::uint64_t>(data.size()));
  out.append(data);
  put(out, crc32(std::string_view(out).substr(record)));
  end_record(out, record);
  const std::uint64_t offset = size_;
  if (auto done = append(out); !done) return done;
  attachments_.push_back(
      {offset, out.size(), time, 0, data.size(), std::string(name), std::string(media_type)});
  return {};
}

Result<> Writer::metadata(std::string_view name,
                          const std::map<std::string, std::string>& entries) {
  std::string out;
  const std::size_t record = begin_record(out, Op::metadata);
  put_text(out, name);
  put_map(out, entries);
  end_record(out, record);
  const std::uint64_t offset = size_;
  if (auto done = append(out); !done) return done;
  metadata_.push_back({offset, out.size(), std::string(name)});
  return {};
}

void Writer::put_statistics(std::string& out) const {
  std::uint64_t count = 0, first = 0, last = 0;
  for (const ChannelState& state : channels_) count += state.count;
  for (const ChunkOnFile& chunk : chunks_) {
    const bool is_first = &chunk == &chunks_.front();
    first = is_first ? chunk.index.start_time : std::min(first, chunk.index.start_time);
    last = std::max(last, chunk.index.end_time);
  }
  const std::size_t record = begin_record(out, Op::statistics);
  put(out, count);
  put(out, static_cast<std::uint16_t>(schemas_.size()));
  put(out, static_cast<std::uint32_t>(channels_.size()));
  put(out, static_cast<std::uint32_t>(attachments_.size()));
  put(out, static_cast<std::uint32_t>(metadata_.size()));
  put(out, static_cast<std::uint32_t>(chunks_.size()));
  put(out, first);
  put(out, last);
  const std::size_t list = begin_list(out);
  for (const ChannelState& state : channels_) {
    put(out, state.channel.id);
    put(out, state.count);
  }
  end_list(out, list);
  end_record(out, record);
}

// The end of the data section and all following records, for a file of length `start` up to there.
std::string Writer::summary(std::uint64_t start) const {
  std::string out;
  std::size_t record = begin_record(out, Op::data_end);
  put(out, std::uint32_t{0});
  end_record(out, record);
  const std::size_t begin = out.size();

  struct Group {
    Op op;
    std::size_t begin;
  };
  std::vector<Group> groups;
  const auto group = [&](Op op, bool any) {
    if (any) groups.push_back({op, out.size()});
  };
  group(Op::schema, !schemas_.empty());
  for (const Schema& schema : schemas_) put_schema(out, schema);
  group(Op::channel, !channels_.empty());
  for (const ChannelState& state : channels_) put_channel(out, state.channel);

  group(Op::statistics, true);
  put_statistics(out);

  group(Op::chunk_index, !chunks_.empty());
  for (const ChunkOnFile& chunk : chunks_) put_chunk_index(out, chunk.index);
  group(Op::attachment_index, !attachments_.empty());
  for (const AttachmentLocation& location : attachments_) {
    record = begin_record(out, Op::attachment_index);
    put(out, location.offset);
    put(out, location.length);
    put(out, location.log_time);
    put(out, location.create_time);
    put(out, location.size);
    put_text(out, location.name);
    put_text(out, location.media_type);
    end_record(out, record);
  }
  group(Op::metadata_index, !metadata_.empty());
  for (const MetadataLocation& location : metadata_) {
    record = begin_record(out, Op::metadata_index);
    put(out, location.offset);
    put(out, location.length);
    put_text(out, location.name);
    end_record(out, record);
  }

  const std::size_t offsets = out.size();
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const std::size_t end = i + 1 < groups.size() ? groups[i + 1].begin : offsets;
    record = begin_record(out, Op::summary_offset);
    out.push_back(static_cast<char>(groups[i].op));
    put(out, start + groups[i].begin);
    put(out, static_cast<std::uint64_t>(end - groups[i].begin));
    end_record(out, record);
  }
  record = begin_record(out, Op::footer);
  put(out, start + begin);
  put(out, start + offsets);
  // The checksum covers the footer up to itself, so its header must already have the final length.
  put_at(out, record - sizeof(std::uint64_t), std::uint64_t{20});
  put(out, crc32(std::string_view(out).substr(begin)));
  out.append(kMagic);
  return out;
}

void Writer::drop_last_chunk() {
  const ChunkOnFile chunk = std::move(chunks_.back());
  chunks_.pop_back();
  for (const auto& [channel, count] : chunk.counts) channels_[channel - 1u].count -= count;
  size_ = chunk.size_before;
  const auto is_gone = [&](const auto& location) { return location.offset >= size_; };
  attachments_.erase(std::remove_if(attachments_.begin(), attachments_.end(), is_gone),
                     attachments_.end());
  metadata_.erase(std::remove_if(metadata_.begin(), metadata_.end(), is_gone), metadata_.end());
  static_cast<void>(sink_->cut(size_));  // the next append fails too if this did
}

Result<> Writer::finish(std::string_view name, const std::map<std::string, std::string>& last) {
  Result<> result = flush();
  for (;;) {
    Result<> done = metadata(name, last);
    if (done) done = append(summary(size_));
    if (done) return result;
    if (result) result = done;
    if (chunks_.empty()) return result;
    drop_last_chunk();  // also drops the metadata of this attempt
  }
}

}  // namespace cogrsim::mcap
