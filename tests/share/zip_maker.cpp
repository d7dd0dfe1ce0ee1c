#include "zip_maker.h"

#include <zlib.h>

#include <algorithm>

#include "hash.h"

namespace {

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>((value >> (8 * i)) & 0xff);
}

std::string deflated(const std::string& content) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -15, 9, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, content.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace

// PKWARE's APPNOTE, sections 4.3.7 (local header), 4.3.12 (directory) and 4.3.16 (its end).
std::string make_zip(const std::vector<ZipMember>& members) {
  std::string out, directory;
  for (const ZipMember& member : members) {
    const std::string data = member.deflated ? deflated(member.content) : member.content;
    const std::string& local = member.local_name.empty() ? member.name : member.local_name;
    const auto sum = crc32(0, reinterpret_cast<const Bytef*>(member.content.data()),
                           static_cast<uInt>(member.content.size()));
    const std::size_t at = out.size();
    const auto common = [&](std::string& to, const std::string& name) {
      put(to, 20, 2);
      put(to, member.flags, 2);
      put(to, member.deflated ? 8 : 0, 2);
      put(to, 0x00210000, 4);  // 1980-01-01 00:00
      put(to, sum, 4);
      put(to, data.size(), 4);
      put(to, member.content.size(), 4);
      put(to, name.size(), 2);
      put(to, 0, 2);
    };
    put(out, 0x04034b50, 4);
    common(out, local);
    out += local + data;
    put(directory, 0x02014b50, 4);
    put(directory, (3 << 8) | 20, 2);  // made on Unix
    common(directory, member.name);
    put(directory, 0, 2 + 2 + 2);  // no comment, first disk, binary
    put(directory, static_cast<std::uint64_t>(member.mode) << 16, 4);
    put(directory, at, 4);
    directory += member.name;
  }
  const std::size_t at = out.size();
  out += directory;
  put(out, 0x06054b50, 4);
  put(out, 0, 4);
  put(out, members.size(), 2);
  put(out, members.size(), 2);
  put(out, directory.size(), 4);
  put(out, at, 4);
  put(out, 0, 2);
  return out;
}

cogrsim::share::Manifest manifest_for(std::vector<TestFile> files) {
  std::sort(files.begin(), files.end(),
            [](const TestFile& a, const TestFile& b) { return a.path < b.path; });
  cogrsim::share::Manifest manifest;
  manifest.package = {"evil", "1.0.0"};
  manifest.created_by = "the tests";
  for (const TestFile& file : files) {
    if (file.role == cogrsim::share::Role::scene) manifest.scene = file.path;
    manifest.files.push_back(
        {file.path, file.content.size(), cogrsim::share::sha256_of(file.content), file.role});
  }
  return manifest;
}

std::vector<ZipMember> members_for(const std::vector<TestFile>& files) {
  std::vector<ZipMember> members = {
      {"manifest.json", cogrsim::share::to_text(manifest_for(files))}};
  for (const TestFile& file : files) members.push_back({file.path, file.content});
  return members;
}
