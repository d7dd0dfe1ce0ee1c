#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "common/interrupt.h"
#include "hash.h"
#include "zip.h"

namespace cogrsim::share {
namespace {

namespace fs = std::filesystem;

struct ReaderDeleter {
  void operator()(archive* a) const { archive_read_free(a); }
};

// A new file, or none at all.
class NewFile {
 public:
  ~NewFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Result<> open(const fs::path& path) {
    path_ = path.string();
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
    return descriptor_ >= 0 ? Result<>() : problem();
  }
  Result<> write(const char* bytes, std::size_t count) {
    while (count > 0) {
      const ssize_t done = ::write(descriptor_, bytes, count);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) return problem();
      bytes += done;
      count -= static_cast<std::size_t>(done);
    }
    return {};
  }
  Result<> close() {
    const int descriptor = std::exchange(descriptor_, -1);
    return ::close(descriptor) == 0 ? Result<>() : problem();
  }

 private:
  Result<> problem() const {
    return fail(fmt::format("cannot be written: {}", std::strerror(errno)), path_);
  }
  std::string path_;
  int descriptor_ = -1;
};

class Reader {
 public:
  Reader(std::string path, std::string folder, const PackageLimits& limits)
      : path_(std::move(path)),
        folder_(std::move(folder)),
        limits_(limits),
        archive_(archive_read_new()) {}

  Result<Manifest> run() {
    if (auto done = open(); !done) return tl::unexpected(done.error());
    auto manifest = read_manifest();
    if (!manifest) return manifest;
    std::vector<bool> seen(manifest->files.size(), false);
    for (;;) {
      auto name = next();
      if (!name) return tl::unexpected(name.error());
      if (name->empty()) break;
      const auto file =
          std::lower_bound(manifest->files.begin(), manifest->files.end(), *name,
                           [](const PackagedFile& f, const std::string& n) { return f.path < n; });
      if (file == manifest->files.end() || file->path != *name) {
        return refuse(*name == kManifestName ? std::string("the manifest is there twice")
                                             : fmt::format("'{}' is not in the manifest", *name));
      }
      const auto index = static_cast<std::size_t>(file - manifest->files.begin());
      if (seen[index]) return refuse(fmt::format("'{}' is there twice", *name));
      seen[index] = true;
      if (auto done = take(*file); !done) return tl::unexpected(done.error());
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!seen[i]) {
        return refuse(fmt::format("'{}' is in the manifest, but not in the package",
                                  manifest->files[i].path));
      }
    }
    return manifest;
  }

 private:
  tl::unexpected<Error> refuse(std::string why) const {
    return fail(std::move(why), path_, "do not use this package; ask the one who made it");
  }
  tl::unexpected<Error> refuse(const Error& error) const {
    return fail(error.message, path_, error.hint);
  }

  Result<> open() {
    std::error_code error;
    package_size_ = fs::file_size(path_, error);
    if (error || !fs::is_regular_file(path_, error)) {
      return fail("there is no such file, or it cannot be read", path_);
    }
    if (package_size_ > limits_.package_bytes) {
      return refuse(fmt::format("the package has {} bytes, at most {} are taken", package_size_,
                                limits_.package_bytes));
    }
    // Something before the archive would make a program and a package out of one file.
    char magic[4] = {};
    std::ifstream(path_, std::ios::binary).read(magic, 4);
    if (std::memcmp(magic, "PK\x03\x04", 4) != 0) return refuse("this is not a zip file");
    archive_read_support_format_zip_seekable(archive_.get());
    if (archive_read_open_filename(archive_.get(), path_.c_str(), 1u << 16) != ARCHIVE_OK) {
      return refuse(fmt::format("the package is damaged: {}", reason()));
    }
    return {};
  }

  std::string reason() const {
    const char* text = archive_error_string(archive_.get());
    std::string out;
    for (const char c : std::string(text != nullptr ? text : "unknown reason")) {
      out += c >= 0x20 && c < 0x7f ? c : '?';
    }
    return out;
  }

  // The next file's name, empty at the end. Whatever is no plain file with a plain name is refused.
  Result<std::string> next() {
    const int status = archive_read_next_header(archive_.get(), &entry_);
    if (status == ARCHIVE_EOF) return std::string();
    if (status != ARCHIVE_OK) return refuse(fmt::format("the package is damaged: {}", reason()));
    if (++count_ > limits_.files + 1) {
      return refuse(fmt::format("the package has more than {} files", limits_.files));
    }
    const char* raw = archive_entry_pathname(entry_);
    const std::string name = raw != nullptr ? raw : "";
    if (auto good = check_path(name); !good) return refuse(good.error());
    if (archive_entry_is_encrypted(entry_) != 0) {
      return refuse(fmt::format("'{}' is encrypted", name));
    }
    if (archive_entry_symlink(entry_) != nullptr || archive_entry_hardlink(entry_) != nullptr) {
      return refuse(fmt::format("'{}' is a link", name));
    }
    if (archive_entry_filetype(entry_) != AE_IFREG) {
      return refuse(fmt::format("'{}' is not an ordinary file", name));
    }
    return name;
  }

  // Hands the content on in pieces; at most `size` bytes.
  template <class Take>
  Result<> content(const std::string& name, std::uint64_t size, Take&& take) {
    std::vector<char> buffer(1u << 16);
    std::uint64_t got = 0;
    for (;;) {
      const la_ssize_t count = archive_read_data(archive_.get(), buffer.data(), buffer.size());
      if (count == 0) break;
      if (cli::interrupted()) return cli::nothing_written();
      if (count < 0) return refuse(fmt::format("'{}' is damaged: {}", name, reason()));
      got += static_cast<std::uint64_t>(count);
      total_ += static_cast<std::uint64_t>(count);
      if (got > size) {
        return refuse(fmt::format("'{}' has more than the {} bytes it may have", name, size));
      }
      if (total_ > limits_.unpacked_bytes ||
          (total_ > limits_.free_bytes &&
           static_cast<double>(total_) > limits_.ratio * static_cast<double>(package_size_))) {
        return refuse(fmt::format("the package unpacks to {} times its size, or more",
                                  total_ / std::max<std::uint64_t>(1, package_size_)));
      }
      if (auto done = take(buffer.data(), static_cast<std::size_t>(count)); !done) return done;
    }
    return {};
  }

  Result<Manifest> read_manifest() {
    const auto name = next();
    if (!name) return tl::unexpected(name.error());
    if (*name != kManifestName) {
      return refuse("the package does not begin with its manifest: it is not made by cogrsim push");
    }
    std::string text;
    const auto done = content(*name, limits_.manifest_bytes, [&](const char* bytes, std::size_t n) {
      text.append(bytes, n);
      return Result<>();
    });
    if (!done) return tl::unexpected(done.error());
    auto manifest = parse_manifest(text, limits_);
    if (!manifest) return refuse(manifest.error());
    if (folder_.empty()) return manifest;
    NewFile file;
    if (auto made = file.open(fs::path(folder_) / kManifestName); !made) {
      return tl::unexpected(made.error());
    }
    if (auto made = file.write(text.data(), text.size()); !made) {
      return tl::unexpected(made.error());
    }
    if (auto made = file.close(); !made) return tl::unexpected(made.error());
    return manifest;
  }

  Result<> take(const PackagedFile& file) {
    Sha256 hash;
    ContentCheck check(file.path);
    NewFile out;
    if (!folder_.empty()) {
      if (auto made = out.open(fs::path(folder_) / file.path); !made) return made;
    }
    std::uint64_t size = 0;
    const auto done = content(file.path, file.size, [&](const char* bytes, std::size_t count) {
      size += count;
      hash.feed({bytes, count});
      check.feed({bytes, count});
      return folder_.empty() ? Result<>() : out.write(bytes, count);
    });
    if (!done) return done;
    if (size != file.size) {
      return refuse(fmt::format("'{}' has {} bytes instead of {}", file.path, size, file.size));
    }
    if (hash.finish() != file.sha256) {
      return refuse(fmt::format("'{}' differs from the manifest: its hash is another", file.path));
    }
    if (auto good = check.finish(); !good) return refuse(good.error());
    return folder_.empty() ? Result<>() : out.close();
  }

  std::string path_, folder_;
  PackageLimits limits_;
  std::unique_ptr<archive, ReaderDeleter> archive_;
  archive_entry* entry_ = nullptr;
  std::uint64_t package_size_ = 0, total_ = 0;
  std::size_t count_ = 0;
};

}  // namespace

Result<Manifest> read_package(const std::string& path, const std::string& folder,
                              const PackageLimits& limits) {
  return Reader(path, folder, limits).run();
}

}  // namespace cogrsim::share
