#include "recording/mcap/mcap_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <zstd.h>

#include "recording/mcap/bytes.h"

namespace cogrsim::mcap {

namespace {

// Number of cached uncompressed chunks: a reader reads forwards or near one position.
constexpr std::size_t kKeptChunks = 8;
constexpr std::size_t kKeptBytes = 256u << 20;

std::map<std::string, std::string> take_map(ByteReader& in) {
  std::map<std::string, std::string> out;
  ByteReader list(in.text());
  while (!list.empty()) {
    const std::string_view key = list.text();
    out.emplace(key, list.text());
  }
  return out;
}

struct ChunkHead {
  ChunkIndex index;
  std::uint32_t crc = 0;
  std::string_view packed;
};

std::optional<ChunkHead> chunk_head(std::string_view content, std::uint64_t offset) {
  ByteReader in(content);
  ChunkHead head;
  head.index.start_time = in.number<std::uint64_t>();
  head.index.end_time = in.number<std::uint64_t>();
  head.index.size = in.number<std::uint64_t>();
  head.crc = in.number<std::uint32_t>();
  head.index.compression = std::string(in.text());
  head.packed = in.bytes(in.number<std::uint64_t>());
  if (!in.good() || head.index.size > kMaxChunkBytes) return std::nullopt;
  head.index.offset = offset;
  head.index.length = kRecordHead + content.size();
  head.index.packed_size = head.packed.size();
  return head;
}

// Decompresses in pieces: the memory grows with the actual output and not with the stated size.
Result<std::string> unpacked(const ChunkHead& head) {
  std::string out;
  if (head.index.compression.empty()) {
    out = std::string(head.packed);
  } else if (head.index.compression == "zstd") {
    const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                          ZSTD_freeDCtx);
    ZSTD_inBuffer in{head.packed.data(), head.packed.size(), 0};
    constexpr std::size_t kPiece = 1u << 20;
    std::size_t left = 1;
    while (left != 0) {
      const std::size_t before = out.size();
      // One byte more than the stated size, to detect an excess.
      const std::size_t space =
          std::min<std::size_t>(kPiece, static_cast<std::size_t>(head.index.size) + 1 - before);
      if (space == 0) break;
      out.resize(before + space);
      ZSTD_outBuffer piece{&out[before], space, 0};
      left = ZSTD_decompressStream(context.get(), &piece, &in);
      out.resize(before + piece.pos);
      if (ZSTD_isError(left)) return fail(fmt::format("{}", ZSTD_getErrorName(left)));
      if (piece.pos == 0 && in.pos == in.size) break;
    }
  } else {
    return fail(fmt::format("it is compressed with '{}', which this program does not know",
                            head.index.compression));
  }
  if (out.size() != head.index.size) return fail("it unpacks to another length than it says");
  if (head.crc != 0 && crc32(out) != head.crc) return fail("its checksum does not fit");
  return out;
}

}  // namespace

struct Reader::File {
  int descriptor = -1;
  std::uint64_t size = 0;
  ~File() {
    if (descriptor >= 0) ::close(descriptor);
  }

  // Reads bytes of the file. Errors: beyond the end, or those of the operating system. Memory is
  // only
  // allocated for bytes that the file has.
  Result<std::string> read(std::uint64_t offset, std::uint64_t count) const {
    if (offset > size || count > size - offset) return fail("beyond the end of the file");
    std::string out(static_cast<std::size_t>(count), '\0');
    std::size_t done = 0;
    while (done < out.size()) {
      const ssize_t got =
          ::pread(descriptor, &out[done], out.size() - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return fail(fmt::format("cannot be read: {}", std::strerror(errno)));
      if (got == 0) return fail("became shorter while it was read");
      done += static_cast<std::size_t>(got);
    }
    return out;
  }

  struct Record {
    Op op;
    std::uint64_t length;  // of the content
  };
  std::optional<Record> record_at(std::uint64_t offset) const {
    const auto head = read(offset, kRecordHead);
    if (!head) return std::nullopt;
    ByteReader in(*head);
    const auto op = static_cast<Op>(in.number<std::uint8_t>());
    return Record{op, in.number<std::uint64_t>()};
  }
};

Reader::Reader(std::unique_ptr<File> file) : file_(std::move(file)), size_(file_->size) {}
Reader::~Reader() = default;

Result<std::unique_ptr<Reader>> Reader::open(const std::string& path) {
  auto file = std::make_unique<File>();
  file->descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file->descriptor < 0) {
    return fail(fmt::format("'{}' cannot be opened: {}", path, std::strerror(errno)));
  }
  struct stat about {};
  if (::fstat(file->descriptor, &about) != 0 || !S_ISREG(about.st_mode)) {
    return fail(fmt::format("'{}' is not a file", path));
  }
  file->size = static_cast<std::uint64_t>(about.st_size);

  const auto magic = file->read(0, kMagic.size());
  if (!magic || magic->substr(0, 5) != kMagic.substr(0, 5)) {
    return fail(fmt::format("'{}' is no MCAP file", path), "",
                file->size < kMagic.size() && !kMagic.substr(0, file->size).empty()
                    ? "it is shorter than the shortest one"
                    : "recordings are written by cogrsim run --record FILE");
  }
  if (*magic != kMagic) {
    return fail(fmt::format("'{}' is an MCAP file of another version than 0", path), "",
                "read it with a newer CogRSim, or convert it with the mcap program");
  }
  const auto record = file->record_at(kMagic.size());
  const auto content = record && record->op == Op::header
                           ? file->read(kMagic.size() + kRecordHead, record->length)
                           : Result<std::string>(fail("no header"));
  if (!content) return fail(fmt::format("'{}' ends or is damaged before its first record", path));

  auto reader = std::unique_ptr<Reader>(new Reader(std::move(file)));
  ByteReader in(*content);
  reader->profile_ = std::string(in.text());
  reader->library_ = std::string(in.text());
  if (const auto summary = reader->read_summary()) {
    reader->complete_ = true;
  } else {
    reader->clear();
    reader->damage_ = summary.error().message;
    reader->scan();
  }
  return reader;
}

void Reader::clear() {
  schemas_.clear();
  channels_.clear();
  chunks_.clear();
  locations_.clear();
  attachments_.clear();
  metadata_.clear();
}

const std::vector<Reader::Location>& Reader::locations(std::uint16_t channel) const {
  static const std::vector<Location> kNone;
  const auto found = locations_.find(channel);
  return found == locations_.end() ? kNone : found->second;
}

namespace {

tl::unexpected<Error> damaged_index(const char* what) {
  return fail(std::string("its index is damaged: ") + what);
}

}  // namespace

// The records between data and footer, with verified checksum. Errors: there are none.
Result<std::string> Reader::summary_records() {
  const std::uint64_t tail = kFooterSize + kMagic.size();
  const auto end = size_ < tail ? Result<std::string>(fail("")) : file_->read(size_ - tail, tail);
  if (!end || end->substr(kFooterSize) != kMagic) {
    return fail("it has no end: the program that wrote it was cut off, or the file was");
  }
  ByteReader footer(*end);
  const auto op = static_cast<Op>(footer.number<std::uint8_t>());
  const auto length = footer.number<std::uint64_t>();
  const auto start = footer.number<std::uint64_t>();
  footer.number<std::uint64_t>();  // start of the summary offsets: the whole summary is read here
  const auto crc = footer.number<std::uint32_t>();
  if (op != Op::footer || length != 20) return damaged_index("the footer");
  if (start == 0) return fail("it has no index");
  if (start > size_ - tail) return damaged_index("it lies outside the file");
  auto summary = file_->read(start, size_ - tail - start);
  if (!summary) return summary;
  if (crc != 0 &&
      crc32(std::string_view(*end).substr(0, kFooterSize - 4), crc32(*summary)) != crc) {
    return damaged_index("its checksum does not fit");
  }
  return summary;
}

// Reads the index at the end of the file. Errors: there is none, or it is inconsistent.
Result<> Reader::read_summary() {
  const auto summary = summary_records();
  if (!summary) return summary.map([](const auto&) {});
  ByteBudget budget{size_};
  std::vector<MetadataLocation> metadata;
  ByteReader in(*summary);
  while (!in.empty()) {
    const auto kind = static_cast<Op>(in.number<std::uint8_t>());
    const std::string_view content = in.bytes(in.number<std::uint64_t>());
    if (!in.good()) return damaged_index("a record in it");
    ByteReader fields(content);
    if (kind == Op::chunk_index) {
      if (!take_chunk_index(fields, budget)) return damaged_index("a chunk lies outside the file");
    } else if (kind == Op::attachment_index) {
      if (!take_attachment_index(fields, budget)) {
        return damaged_index("an attachment lies outside the file");
      }
    } else if (kind == Op::metadata_index) {
      MetadataLocation location;
      location.offset = fields.number<std::uint64_t>();
      location.length = fields.number<std::uint64_t>();
      location.name = std::string(fields.text());
      metadata.push_back(std::move(location));
    } else if (!take_record(kind, content, 0)) {
      return damaged_index("a record in it");
    }
    if (!fields.good()) return damaged_index("a record in it");
  }
  for (const MetadataLocation& location : metadata) {
    const auto record = file_->record_at(location.offset);
    if (!record || record->op != Op::metadata || !budget.take(record->length))
      return damaged_index("metadata are not where it says");
    const auto content = file_->read(location.offset + kRecordHead, record->length);
    if (!content || !take_record(Op::metadata, *content, location.offset)) {
      return damaged_index("metadata are not where it says");
    }
  }
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    if (!read_message_indexes(static_cast<std::uint32_t>(i))) {
      return damaged_index("what a chunk holds is not where it says");
    }
  }
  return {};
}

// False: the chunk lies outside the file.
bool Reader::take_chunk_index(ByteReader& fields, ByteBudget& budget) {
  ChunkIndex chunk;
  chunk.start_time = fields.number<std::uint64_t>();
  chunk.end_time = fields.number<std::uint64_t>();
  chunk.offset = fields.number<std::uint64_t>();
  chunk.length = fields.number<std::uint64_t>();
  fields.text();
  chunk.index_length = fields.number<std::uint64_t>();
  chunk.compression = std::string(fields.text());
  chunk.packed_size = fields.number<std::uint64_t>();
  chunk.size = fields.number<std::uint64_t>();
  if (chunk.size > kMaxChunkBytes || chunk.offset > size_ || chunk.length > size_ - chunk.offset ||
      !budget.take(chunk.index_length)) {
    return false;
  }
  chunks_.push_back(std::move(chunk));
  return true;
}

// False: the attachments are longer than the file.
bool Reader::take_attachment_index(ByteReader& fields, ByteBudget& budget) {
  AttachmentLocation location;
  location.offset = fields.number<std::uint64_t>();
  location.length = fields.number<std::uint64_t>();
  location.log_time = fields.number<std::uint64_t>();
  location.create_time = fields.number<std::uint64_t>();
  location.size = fields.number<std::uint64_t>();
  location.name = std::string(fields.text());
  location.media_type = std::string(fields.text());
  if (!budget.take(location.length)) return false;
  attachments_.push_back(std::move(location));
  return true;
}

bool Reader::read_message_indexes(std::uint32_t chunk) {
  const ChunkIndex& index = chunks_[chunk];
  const auto bytes = file_->read(index.offset + index.length, index.index_length);
  if (!bytes) return false;
  ByteReader in(*bytes);
  while (!in.empty()) {
    const auto op = static_cast<Op>(in.number<std::uint8_t>());
    ByteReader fields(in.bytes(in.number<std::uint64_t>()));
    if (!in.good() || op != Op::message_index) return false;
    std::vector<Location>& locations = locations_[fields.number<std::uint16_t>()];
    ByteReader list(fields.text());
    const std::size_t before = locations.size();
    while (!list.empty()) {
      const auto time = list.number<std::uint64_t>();
      const auto offset = list.number<std::uint64_t>();
      if (!list.good() || offset >= index.size) return false;
      locations.push_back({time, chunk, static_cast<std::uint32_t>(offset), 0});
    }
    if (!fields.good()) return false;
    std::sort(locations.begin() + static_cast<std::ptrdiff_t>(before), locations.end(),
              [](const Location& a, const Location& b) { return a.offset < b.offset; });
    for (std::size_t i = before; i < locations.size(); ++i) {
      locations[i].sequence = static_cast<std::uint32_t>(i);
    }
  }
  return true;
}

// Reads records whose meaning does not depend on their position. False: damaged.
bool Reader::take_record(Op op, std::string_view content, std::uint64_t offset) {
  ByteReader in(content);
  if (op == Op::schema) {
    Schema schema;
    schema.id = in.number<std::uint16_t>();
    schema.name = std::string(in.text());
    schema.encoding = std::string(in.text());
    schema.data = std::string(in.text());
    if (in.good()) schemas_[schema.id] = std::move(schema);
  } else if (op == Op::channel) {
    Channel channel;
    channel.id = in.number<std::uint16_t>();
    channel.schema = in.number<std::uint16_t>();
    channel.topic = std::string(in.text());
    channel.encoding = std::string(in.text());
    channel.metadata = take_map(in);
    if (in.good()) channels_[channel.id] = std::move(channel);
  } else if (op == Op::metadata) {
    std::string name(in.text());
    auto entries = take_map(in);
    if (in.good()) metadata_.emplace_back(std::move(name), std::move(entries));
  } else if (op == Op::attachment) {
    AttachmentLocation location;
    location.offset = offset;
    location.length = kRecordHead + content.size();
    location.log_time = in.number<std::uint64_t>();
    location.create_time = in.number<std::uint64_t>();
    location.name = std::string(in.text());
    location.media_type = std::string(in.text());
    location.size = in.number<std::uint64_t>();
    in.bytes(location.size);
    in.number<std::uint32_t>();
    if (in.good()) attachments_.push_back(std::move(location));
  }
  return in.good();
}

bool Reader::take_messages(const std::string& records, std::uint64_t& limit) {
  const auto number = static_cast<std::uint32_t>(chunks_.size());
  std::vector<std::pair<std::uint16_t, Location>> found;  // used only if the whole chunk is valid
  ByteReader in(records);
  while (!in.empty()) {
    const std::size_t offset = records.size() - in.rest().size();
    const auto op = static_cast<Op>(in.number<std::uint8_t>());
    const std::string_view content = in.bytes(in.number<std::uint64_t>());
    if (!in.good()) return false;
    if (op == Op::schema || op == Op::channel) {
      if (!take_record(op, content, 0)) return false;
    } else if (op == Op::message) {
      ByteReader fields(content);
      const auto channel = fields.number<std::uint16_t>();
      const auto sequence = fields.number<std::uint32_t>();
      const auto time = fields.number<std::uint64_t>();
      if (!fields.good() || found.size() >= limit) return false;
      found.push_back({channel, {time, number, static_cast<std::uint32_t>(offset), sequence}});
    }
  }
  for (const auto& [channel, location] : found) locations_[channel].push_back(location);
  limit -= found.size();
  return true;
}

bool Reader::take_chunk(std::string_view content, std::uint64_t offset, ScanLimits& limits) {
  const auto head = chunk_head(content, offset);
  if (!head) return false;
  if (head->index.size > limits.bytes) {
    limits.full = true;
    return false;
  }
  limits.bytes -= head->index.size;
  const auto records = unpacked(*head);
  if (!records || !take_messages(*records, limits.messages)) return false;
  chunks_.push_back(head->index);
  return true;
}

// Scans the data section from the start and indexes every complete chunk.
void Reader::scan() {
  std::uint64_t offset = kMagic.size();
  std::size_t bad = 0;
  ScanLimits limits{kScanBytes + kScanRatio * size_, kScanMessages + size_ / 8};
  const auto stop = [&](const std::string& why) {
    damage_ += fmt::format("; {} at byte {} of {}", why, offset, size_);
  };
  while (offset < size_) {
    const auto record = file_->record_at(offset);
    if (!record || record->length > size_ - offset - kRecordHead) {
      stop("a record breaks off");
      break;
    }
    if (record->op == Op::data_end || record->op == Op::footer) break;
    if (static_cast<int>(record->op) == 0 || static_cast<int>(record->op) > 15) {
      stop("what should be a record is none");
      break;
    }
    if (record->op != Op::message_index && record->op != Op::message) {
      const auto content = file_->read(offset + kRecordHead, record->length);
      if (!content) {
        stop(content.error().message);
        break;
      }
      const bool good = record->op == Op::chunk ? take_chunk(*content, offset, limits)
                                                : take_record(record->op, *content, offset);
      if (limits.full) {
        stop("what follows would unpack to too much and is left out,");
        break;
      }
      if (!good) ++bad;
    }
    offset += kRecordHead + record->length;
  }
  if (bad > 0)
    damage_ += fmt::format("; {} damaged {} left out", bad, bad == 1 ? "record" : "records");
}

Result<std::string> Reader::attachment(const AttachmentLocation& location) {
  const auto damaged = [&] {
    return fail(fmt::format("attachment '{}' of the recording is damaged", location.name));
  };
  const auto record = file_->record_at(location.offset);
  if (!record || record->op != Op::attachment || record->length + kRecordHead != location.length)
    return damaged();
  const auto content = file_->read(location.offset + kRecordHead, record->length);
  if (!content || content->size() < 4) return damaged();
  ByteReader in(*content);
  in.number<std::uint64_t>();
  in.number<std::uint64_t>();
  in.text();
  in.text();
  const std::string_view data = in.bytes(in.number<std::uint64_t>());
  const std::size_t summed = content->size() - in.rest().size();
  const auto crc = in.number<std::uint32_t>();
  if (!in.good() || (crc != 0 && crc32(std::string_view(*content).substr(0, summed)) != crc)) {
    return damaged();
  }
  return std::string(data);
}

Result<std::shared_ptr<const std::string>> Reader::chunk(std::size_t index) {
  const auto known = std::find_if(cache_.begin(), cache_.end(),
                                  [&](const CachedChunk& entry) { return entry.chunk == index; });
  if (known != cache_.end()) {
    std::rotate(known, known + 1, cache_.end());
    return cache_.back().records;
  }
  const auto damaged = [&](const std::string& why) {
    return fail(fmt::format("the recording is damaged at byte {}: {}", chunks_[index].offset, why));
  };
  const auto record = file_->record_at(chunks_[index].offset);
  if (!record || record->op != Op::chunk) return damaged("there is no chunk");
  const auto content = file_->read(chunks_[index].offset + kRecordHead, record->length);
  if (!content) return damaged(content.error().message);
  const auto head = chunk_head(*content, chunks_[index].offset);
  if (!head) return damaged("the chunk is none");
  auto records = unpacked(*head);
  if (!records) return damaged(records.error().message);
  std::size_t bytes = records->size();
  for (const CachedChunk& entry : cache_) bytes += entry.records->size();
  while (!cache_.empty() && (cache_.size() >= kKeptChunks || bytes > kKeptBytes)) {
    bytes -= cache_.front().records->size();
    cache_.erase(cache_.begin());
  }
  cache_.push_back({index, std::make_shared<const std::string>(std::move(*records))});
  return cache_.back().records;
}

Result<Reader::Message> Reader::message_at(const std::string& chunk, std::uint32_t offset) {
  if (offset >= chunk.size()) return fail("a message lies outside its chunk");
  ByteReader in(std::string_view(chunk).substr(offset));
  const auto op = static_cast<Op>(in.number<std::uint8_t>());
  ByteReader fields(in.bytes(in.number<std::uint64_t>()));
  Message message;
  message.channel = fields.number<std::uint16_t>();
  message.sequence = fields.number<std::uint32_t>();
  message.time = fields.number<std::uint64_t>();
  fields.number<std::uint64_t>();
  message.data = fields.rest();
  if (op != Op::message || !in.good() || !fields.good()) return fail("a message is damaged");
  return message;
}

}  // namespace cogrsim::mcap
