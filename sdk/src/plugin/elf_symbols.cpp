#include "elf_symbols.h"

#include <elf.h>
#include <link.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

namespace cogrsim {
namespace {

using FileHeader = ElfW(Ehdr);
using Section = ElfW(Shdr);
using Segment = ElfW(Phdr);
using Symbol = ElfW(Sym);

constexpr unsigned char kOwnClass = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
constexpr unsigned char kOwnByteOrder =
    __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? ELFDATA2LSB : ELFDATA2MSB;

/// A file of known size that is not read beyond its end.
class Bytes {
 public:
  Bytes(const std::string& path, std::uint64_t size)
      : stream_(path, std::ios::binary), size_(size) {}

  bool is_open() const { return stream_.is_open(); }

  bool contains(std::uint64_t offset, std::uint64_t length) const {
    return offset <= size_ && length <= size_ - offset;
  }

  bool read(std::uint64_t offset, std::uint64_t length, void* out) {
    if (!contains(offset, length)) return false;
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(offset));
    stream_.read(static_cast<char*>(out), static_cast<std::streamsize>(length));
    return stream_.good();
  }

  /// Reads `count` records of type T; nullopt if they are not inside the file.
  template <class T>
  std::optional<std::vector<T>> read_array(std::uint64_t offset, std::uint64_t count) {
    if (count > size_ / sizeof(T) || !contains(offset, count * sizeof(T))) return std::nullopt;
    std::vector<T> out(static_cast<std::size_t>(count));
    if (count > 0 && !read(offset, count * sizeof(T), out.data())) return std::nullopt;
    return out;
  }

 private:
  std::ifstream stream_;
  std::uint64_t size_;
};

tl::unexpected<Error> damaged(const char* what) {
  return fail(std::string("damaged or cut off: ") + what);
}

Result<FileHeader> read_header(Bytes& file) {
  FileHeader header;
  if (!file.read(0, sizeof header, &header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) {
    return fail("not a shared library (not an ELF file)");
  }
  if (header.e_ident[EI_CLASS] != kOwnClass || header.e_ident[EI_DATA] != kOwnByteOrder) {
    return fail("a shared library for another kind of machine");
  }
  if (header.e_type != ET_DYN) return fail("an ELF file, but not a shared library");
  return header;
}

/// Checks that all segments are inside the file: the system maps segments without checking the file
/// size, and access to a page beyond the end of the file kills the program.
Result<> check_segments(Bytes& file, const FileHeader& header) {
  if (header.e_phentsize != sizeof(Segment)) return damaged("program headers of a wrong size");
  const auto segments = file.read_array<Segment>(header.e_phoff, header.e_phnum);
  if (!segments) return damaged("program headers beyond the end of the file");
  for (const Segment& segment : *segments) {
    if (segment.p_type == PT_LOAD && !file.contains(segment.p_offset, segment.p_filesz)) {
      return damaged("a segment extends beyond the end of the file");
    }
  }
  return {};
}

}  // namespace

Result<std::vector<std::string>> exported_symbols(const std::string& path,
                                                  const std::string& prefix) {
  std::error_code error;
  // Opening a pipe would block, so the type of the file is checked first.
  if (!std::filesystem::is_regular_file(path, error)) return fail("not a regular file");
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) return fail("cannot be read: " + error.message());
  Bytes file(path, size);
  if (!file.is_open()) return fail("cannot be read: " + std::string(std::strerror(errno)));

  const Result<FileHeader> header = read_header(file);
  if (!header) return tl::unexpected<Error>(header.error());
  if (Result<> fits = check_segments(file, *header); !fits) {
    return tl::unexpected<Error>(fits.error());
  }
  if (header->e_shentsize != sizeof(Section)) return damaged("section headers of a wrong size");
  const auto sections = file.read_array<Section>(header->e_shoff, header->e_shnum);
  if (!sections) return damaged("section headers beyond the end of the file");

  std::vector<std::string> names;
  for (const Section& section : *sections) {
    if (section.sh_type != SHT_DYNSYM) continue;
    if (section.sh_link >= sections->size()) return damaged("symbols without a string table");
    const Section& strings = (*sections)[section.sh_link];
    const auto symbols =
        file.read_array<Symbol>(section.sh_offset, section.sh_size / sizeof(Symbol));
    const auto text = file.read_array<char>(strings.sh_offset, strings.sh_size);
    if (!symbols || !text) return damaged("a symbol table beyond the end of the file");
    for (const Symbol& symbol : *symbols) {
      if (symbol.st_shndx == SHN_UNDEF) continue;
      if (symbol.st_name >= text->size()) return damaged("a symbol name beyond its table");
      const char* name = text->data() + symbol.st_name;
      const std::size_t space = text->size() - symbol.st_name;
      const std::size_t length = strnlen(name, space);
      if (length >= prefix.size() && prefix.compare(0, prefix.size(), name, prefix.size()) == 0) {
        names.emplace_back(name, length);
      }
    }
  }
  return names;
}

}  // namespace cogrsim
