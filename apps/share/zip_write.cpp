#include <archive.h>
#include <archive_entry.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "hash.h"
#include "common/interrupt.h"
#include "zip.h"

namespace cogrsim::share {
namespace {

struct WriterDeleter {
  void operator()(archive* a) const { archive_write_free(a); }
};
struct EntryDeleter {
  void operator()(archive_entry* e) const { archive_entry_free(e); }
};
struct FileDeleter {
  void operator()(std::FILE* f) const { std::fclose(f); }
};

class Writer {
 public:
  explicit Writer(const std::string& path) : path_(path), archive_(archive_write_new()) {}

  Result<> open() {
    archive* a = archive_.get();
    archive_write_set_format_zip(a);
    archive_write_zip_set_compression_deflate(a);
    archive_write_set_bytes_in_last_block(a, 1);  // no padding
    return check(archive_write_open_filename(a, path_.c_str()));
  }

  // No time is set: it would come out in the time zone of the machine.
  Result<> begin(const std::string& name, std::uint64_t size) {
    const std::unique_ptr<archive_entry, EntryDeleter> entry(archive_entry_new());
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(size));
    return check(archive_write_header(archive_.get(), entry.get()));
  }

  Result<> write(const char* bytes, std::size_t count) {
    while (count > 0) {
      const la_ssize_t done = archive_write_data(archive_.get(), bytes, count);
      if (done <= 0) return check(ARCHIVE_FATAL);
      bytes += done;
      count -= static_cast<std::size_t>(done);
    }
    return {};
  }

  Result<> close() { return check(archive_write_close(archive_.get())); }

 private:
  Result<> check(int status) {
    if (status == ARCHIVE_OK) return {};
    const char* why = archive_error_string(archive_.get());
    return fail(fmt::format("cannot be written: {}", why != nullptr ? why : "unknown reason"),
                path_, "is the disk full, or the folder not yours?");
  }

  std::string path_;
  std::unique_ptr<archive, WriterDeleter> archive_;
};

Result<> write_file_into(Writer& writer, const PackagedFile& file, const std::string& source) {
  const std::unique_ptr<std::FILE, FileDeleter> in(std::fopen(source.c_str(), "rb"));
  if (!in) return fail("the file cannot be opened", source);
  if (auto done = writer.begin(file.path, file.size); !done) return done;
  std::vector<char> buffer(1u << 16);
  std::uint64_t size = 0;
  Sha256 hash;
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), in.get())) {
    if (cli::interrupted()) return cli::nothing_written();
    size += count;
    if (size > file.size) break;
    hash.feed({buffer.data(), count});
    if (auto done = writer.write(buffer.data(), count); !done) return done;
  }
  if (std::ferror(in.get()) != 0) return fail("the file cannot be read", source);
  if (size != file.size || hash.finish() != file.sha256) {
    return fail("the file changed while it was packed", source, "try again");
  }
  return {};
}

}  // namespace

Result<> write_package(const Manifest& manifest, const std::string& folder,
                       const std::string& path) {
  Writer writer(path);
  if (auto done = writer.open(); !done) return done;
  const std::string text = to_text(manifest);
  if (auto done = writer.begin(kManifestName, text.size()); !done) return done;
  if (auto done = writer.write(text.data(), text.size()); !done) return done;
  for (const PackagedFile& file : manifest.files) {
    const std::string source = (std::filesystem::path(folder) / file.path).string();
    if (auto done = write_file_into(writer, file, source); !done) return done;
  }
  return writer.close();
}

}  // namespace cogrsim::share
