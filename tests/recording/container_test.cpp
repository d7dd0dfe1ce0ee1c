// The MCAP container alone: written messages are read back, and damaged files do no harm.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "recording/mcap/mcap_reader.h"
#include "recording/mcap/mcap_writer.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

// A disk in memory that is full after `capacity` bytes.
struct Disk {
  std::string bytes;
  std::size_t capacity = static_cast<std::size_t>(-1);
};

class MemorySink final : public mcap::Sink {
 public:
  explicit MemorySink(Disk& disk) : disk_(disk) {}
  Result<> append(std::string_view bytes) override {
    // Part of it arrives, as on a real disk.
    const std::size_t fits = std::min(bytes.size(), disk_.capacity - disk_.bytes.size());
    disk_.bytes.append(bytes.substr(0, fits));
    if (fits < bytes.size()) return fail("no space left on device");
    return {};
  }
  Result<> cut(std::uint64_t size) override {
    disk_.bytes.resize(size);
    return {};
  }

 private:
  Disk& disk_;
};

constexpr std::size_t kMessage = 25;  // bytes of a message

// Chunks of ten messages on each of two topics, bytes that do not compress in each.
Result<> write_sample(Disk& disk, int chunks, const std::string& note = "hello") {
  mcap::Writer writer(std::make_unique<MemorySink>(disk));
  if (auto done = writer.start("test", "tests"); !done) return done;
  if (auto done = writer.attachment("note.txt", "text/plain", note, 5); !done) return done;
  const auto schema = writer.add_schema("S", "", "");
  const auto a = writer.add_channel(schema, "/a", "raw", {{"key", "value"}});
  const auto b = writer.add_channel(0, "/b", "raw");
  std::mt19937 random(1);
  Result<> result;
  for (int chunk = 0; chunk < chunks && result; ++chunk) {
    for (int i = 0; i < 10; ++i) {
      const auto n = static_cast<std::uint32_t>(10 * chunk + i);
      for (const auto channel : {a, b}) {
        writer.message(channel, n, 1000u * n, [&](std::string& out) {
          for (std::size_t k = 0; k < kMessage; ++k) out.push_back(static_cast<char>(random()));
        });
      }
    }
    result = writer.flush();
  }
  std::map<std::string, std::string> about = {{"status", "done"}};
  if (note.size() > 100) about["note"] = note;
  const auto end = writer.finish("end", about);
  return result ? end : result;
}

// Reads everything there is; the number of messages that could be read.
std::size_t read_everything(mcap::Reader& reader) {
  std::size_t good = 0;
  for (const auto& [id, channel] : reader.channels()) {
    for (const mcap::Reader::Location& place : reader.locations(id)) {
      const auto chunk = reader.chunk(place.chunk);
      if (!chunk) continue;
      const auto message = mcap::Reader::message_at(**chunk, place.offset);
      if (message && message->channel == id && message->data.size() == kMessage) ++good;
    }
  }
  for (const auto& place : reader.attachments()) static_cast<void>(reader.attachment(place));
  return good;
}

struct RecordPlace {
  mcap::Op op;
  std::size_t begin = 0, end = 0;
};

// All records of a whole file, in order.
std::vector<RecordPlace> records_of(const std::string& bytes) {
  std::vector<RecordPlace> out;
  std::size_t at = mcap::kMagic.size();
  while (at + mcap::kRecordHead + mcap::kMagic.size() <= bytes.size()) {
    std::size_t length = 0;
    for (std::size_t i = 8; i > 0; --i)
      length = length << 8 | static_cast<unsigned char>(bytes[at + i]);
    out.push_back({static_cast<mcap::Op>(bytes[at]), at, at + mcap::kRecordHead + length});
    at = out.back().end;
  }
  return out;
}

}  // namespace

TEST_CASE("a container gives back its messages") {
  const Folder folder;
  Disk disk;
  REQUIRE(write_sample(disk, 4));
  write_all(folder / "a.mcap", disk.bytes);
  const auto reader = mcap::Reader::open(folder / "a.mcap");
  REQUIRE(reader);
  mcap::Reader& file = **reader;
  CHECK(file.complete());
  CHECK(file.profile() == "test");
  CHECK(file.chunks().size() == 4);
  CHECK(file.schemas().size() == 1);
  REQUIRE(file.channels().size() == 2);
  CHECK(file.channels().at(1).metadata.at("key") == "value");
  REQUIRE(file.locations(1).size() == 40);
  CHECK(file.locations(1)[39].time == 39000);
  REQUIRE(file.attachments().size() == 1);
  CHECK(*file.attachment(file.attachments()[0]) == "hello");
  REQUIRE(file.metadata().size() == 1);
  CHECK(file.metadata()[0].second.at("status") == "done");
  CHECK(read_everything(file) == 80);
}

TEST_CASE("a file cut anywhere gives its whole chunks") {
  const Folder folder;
  Disk disk;
  REQUIRE(write_sample(disk, 3));
  const std::string& bytes = disk.bytes;
  std::size_t before = 60;
  write_all(folder / "cut.mcap", bytes);
  for (std::size_t size = bytes.size() - 1; size > 0; --size) {
    std::filesystem::resize_file(folder / "cut.mcap", size);
    const auto reader = mcap::Reader::open(folder / "cut.mcap");
    if (!reader) {
      CHECK(size < 100);  // magic and header
      continue;
    }
    INFO("cut to " << size << " of " << bytes.size());
    CHECK_FALSE((*reader)->complete());
    CHECK((*reader)->damage() != "");
    const std::size_t good = read_everything(**reader);
    REQUIRE(good % 20 == 0);
    REQUIRE(good <= before);  // less of the file never gives more
    before = good;
  }
  CHECK(before == 0);
}

TEST_CASE("wrong bytes anywhere do no harm") {
  const Folder folder;
  Disk disk;
  REQUIRE(write_sample(disk, 2));
  const std::string path = folder / "wrong.mcap";
  write_all(path, disk.bytes);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](std::size_t at, int byte) {
    file.seekp(static_cast<std::streamoff>(at));
    file.put(static_cast<char>(byte));
    file.flush();
  };
  for (std::size_t at = 0; at < disk.bytes.size(); ++at) {
    if (at > 0) put(at - 1, disk.bytes[at - 1]);
    for (const int mask : {0x01, 0xff}) {
      put(at, disk.bytes[at] ^ mask);
      auto reader = mcap::Reader::open(path);
      if (!reader) continue;
      INFO("byte " << at);
      // A message that is read was written: it has its length, none is made up.
      REQUIRE(read_everything(**reader) <= 40);
    }
  }
}

TEST_CASE("a full disk leaves a valid file") {
  const Folder folder;
  Disk whole;
  REQUIRE(write_sample(whole, 6));
  // Every capacity from almost nothing to almost enough.
  for (std::size_t capacity = 0; capacity < whole.bytes.size(); capacity += 37) {
    Disk disk;
    disk.capacity = capacity;
    const auto done = write_sample(disk, 6);
    REQUIRE_FALSE(done);
    CHECK(done.error().message == "no space left on device");
    write_all(folder / "full.mcap", disk.bytes);
    const auto reader = mcap::Reader::open(folder / "full.mcap");
    if (!reader) {
      CHECK(capacity < 200);
      continue;
    }
    INFO("capacity " << capacity);
    // With space for a summary there is one, else whole chunks.
    if (capacity > 1500) CHECK((*reader)->complete());
    CHECK(read_everything(**reader) % 20 == 0);
  }
}

TEST_CASE("what is no container of this version is reported as such") {
  const Folder folder;
  const std::string path = folder / "x.mcap";
  write_all(path, "");
  CHECK(mcap::Reader::open(path).error().message.find("is no MCAP file") != std::string::npos);
  write_all(path, "<scene/> and so on");
  CHECK(mcap::Reader::open(path).error().message.find("is no MCAP file") != std::string::npos);
  write_all(path, std::string("\x89MCAP1\r\n", 8) + std::string(100, 'x'));
  CHECK(mcap::Reader::open(path).error().message.find("another version than 0") !=
        std::string::npos);
  CHECK(mcap::Reader::open(folder / "none.mcap").error().message.find("No such file") !=
        std::string::npos);
  CHECK(mcap::Reader::open(folder.path).error().message.find("is not a file") != std::string::npos);
}

TEST_CASE("a chunk that claims to be huge is not believed") {
  const Folder folder;
  Disk disk;
  REQUIRE(write_sample(disk, 1));
  // uncompressed_size is the third number of the chunk record, behind header and attachment.
  const std::size_t chunk = disk.bytes.find("zstd") - 4 - 4 - 8;
  REQUIRE(chunk < disk.bytes.size());
  for (const std::uint64_t claim : {std::uint64_t{1} << 62, std::uint64_t{1} << 29}) {
    std::string bytes = disk.bytes.substr(0, disk.bytes.size() - 30);  // no index: it is scanned
    for (int i = 0; i < 8; ++i) {
      bytes[chunk + static_cast<std::size_t>(i)] = static_cast<char>(claim >> (8 * i));
    }
    write_all(folder / "huge.mcap", bytes);
    const auto reader = mcap::Reader::open(folder / "huge.mcap");
    REQUIRE(reader);
    CHECK(read_everything(**reader) == 0);
    CHECK((*reader)->damage().find("1 damaged record left out") != std::string::npos);
  }
}

TEST_CASE("a file without an index is unpacked up to a bound") {
  const Folder folder;
  Disk disk;
  // 128 MiB of zeros are packed into some kilobytes.
  constexpr std::size_t kZeros = std::size_t{128} << 20;
  {
    mcap::Writer writer(std::make_unique<MemorySink>(disk));
    REQUIRE(writer.start("test", "tests"));
    const auto channel = writer.add_channel(0, "/a", "raw");
    writer.message(channel, 0, 0, [](std::string& out) { out.append(kZeros, '\0'); });
    REQUIRE(writer.finish("end", {}));
  }
  const auto records = records_of(disk.bytes);
  const auto chunk = std::find_if(records.begin(), records.end(), [](const RecordPlace& record) {
    return record.op == mcap::Op::chunk;
  });
  REQUIRE(chunk != records.end());
  const std::string packed = disk.bytes.substr(chunk->begin, chunk->end - chunk->begin);
  std::string bytes = disk.bytes.substr(0, chunk->begin);
  for (int i = 0; i < 20; ++i) bytes += packed;
  REQUIRE(bytes.size() * mcap::kScanRatio < kZeros);
  write_all(folder / "zeros.mcap", bytes);
  const auto reader = mcap::Reader::open(folder / "zeros.mcap");
  REQUIRE(reader);
  CHECK((*reader)->chunks().size() == mcap::kScanBytes / kZeros);
  CHECK((*reader)->damage().find("would unpack to too much") != std::string::npos);
}

TEST_CASE("an index that names the same offset again and again is refused") {
  const Folder folder;
  Disk disk;
  REQUIRE(write_sample(disk, 2, std::string(1000, 'n')));
  const auto records = records_of(disk.bytes);
  for (const mcap::Op op :
       {mcap::Op::attachment_index, mcap::Op::metadata_index, mcap::Op::chunk_index}) {
    INFO(static_cast<int>(op));
    const auto found = std::find_if(records.begin(), records.end(),
                                    [&](const RecordPlace& record) { return record.op == op; });
    REQUIRE(found != records.end());
    std::string bytes = disk.bytes;
    // Without its checksum, which need not be given.
    bytes.replace(bytes.size() - mcap::kMagic.size() - 4, 4, 4, '\0');
    std::string many;
    for (int i = 0; i < 1000; ++i)
      many += disk.bytes.substr(found->begin, found->end - found->begin);
    write_all(folder / "plain.mcap", bytes);
    bytes.insert(found->begin, many);
    write_all(folder / "many.mcap", bytes);
    const auto plain = mcap::Reader::open(folder / "plain.mcap");
    REQUIRE(plain);
    CHECK((*plain)->complete());
    const auto reader = mcap::Reader::open(folder / "many.mcap");
    REQUIRE(reader);
    CHECK_FALSE((*reader)->complete());
    CHECK((*reader)->damage().find("its index is damaged") == 0);
    CHECK((*reader)->attachments().size() == 1);
    CHECK((*reader)->chunks().size() == 2);
    CHECK(read_everything(**reader) == 40);
  }
}
