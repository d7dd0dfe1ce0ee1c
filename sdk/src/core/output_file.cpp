#include "cogrsim/core/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

namespace cogrsim {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

constexpr std::size_t kBufferSize = 1 << 16;  // of the write buffer [byte]
constexpr std::size_t kMarkRange = 4096;      // marks are within this distance of either end [byte]

// PNG chunk "Software", with its CRC-32; before the last chunk.
constexpr auto kPngMark = "\0\0\0\x10tEXtSoftware\0CogRSim\x9a\x9fZ\xe3"sv;
constexpr std::size_t kPngEnd = 12;
// JPEG comment; behind the start of the image.
constexpr auto kJpegMark =
    "\xff\xfe\0\x09"
    "CogRSim"sv;
// GIF comment block (before the trailer), MP4 free box, Matroska void element (both at the end).
constexpr auto kGifMark =
    "\x21\xfe\x07"
    "CogRSim\0"sv;
constexpr auto kMp4Mark =
    "\0\0\0\x0f"
    "freeCogRSim"sv;
constexpr auto kWebmMark =
    "\xec\x87"
    "CogRSim"sv;
constexpr auto kXmlMark = "<!-- CogRSim -->\n"sv;
constexpr auto kPdfMark = "%CogRSim\n"sv;
constexpr auto kJsonMark = "\"generator\": \"CogRSim\""sv;
constexpr auto kScriptMark = "# CogRSim"sv;
constexpr auto kJournalMark = "{\"cogrsim-journal\":"sv;
// Headings of the tables of recordings and of studies.
constexpr std::array kTableMarks = {"time [s],body,x [m],"sv, "time [s],joint,coordinate,"sv,
                                    "time [s],a,b,x [m],"sv, "time [s],sequence,valid"sv};

struct Format {
  const char* name;
  std::array<const char*, 3> endings;
};

// By OutputKind.
constexpr std::array<Format, 18> kFormats = {{{"a JSON file", {".json", ".jsonl"}},
                                              {"an XML file", {".xml"}},
                                              {"a CSV table", {".csv"}},
                                              {"a PNG picture", {".png"}},
                                              {"a JPEG picture", {".jpg", ".jpeg"}},
                                              {"an SVG picture", {".svg"}},
                                              {"a PDF picture", {".pdf"}},
                                              {"an HTML page", {".html", ".htm"}},
                                              {"a film", {".gif", ".mp4", ".webm"}},
                                              {"a recording", {".mcap"}},
                                              {"a snapshot", {".snap"}},
                                              {"a figure", {".json"}},
                                              {"a gnuplot script", {".gp"}},
                                              {"a learner's table", {".table", ".txt"}},
                                              {"a study's table", {".sqlite"}},
                                              {"a journal of the studio", {".journal"}},
                                              {"a table", {".md", ".tex"}},
                                              {"such a file", {}}}};

// Files that must survive a crash of the machine are synchronised to the disk.
bool is_durable(OutputKind kind) {
  return kind == OutputKind::snapshot || kind == OutputKind::journal;
}

const Format& format_of(OutputKind kind) { return kFormats[static_cast<std::size_t>(kind)]; }

std::string system_reason() { return std::strerror(errno); }

std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

tl::unexpected<Error> refused(const std::string& path, const std::string& why,
                              const std::string& hint = "choose another name") {
  return fail(fmt::format("cannot write '{}': {}", path, why), "", hint);
}

bool has(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

std::string ending_of(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

// Whether the beginning and end of a file carry the mark of a kind.
bool is_ours(OutputKind kind, std::string_view head, std::string_view tail) {
  switch (kind) {
    case OutputKind::json:
      return has(head, kJsonMark);
    case OutputKind::xml:
    case OutputKind::svg:
      return tail.ends_with(kXmlMark);
    case OutputKind::html:
      return tail.ends_with(kXmlMark) || has(head, "content=\"cogrsim bundle\"");
    case OutputKind::csv:
      return (has(head, "seed,backend,status,cause,end_time") &&
              has(head, "state_hash,wall_time")) ||
             std::any_of(kTableMarks.begin(), kTableMarks.end(),
                         [&](std::string_view mark) { return head.starts_with(mark); });
    case OutputKind::png:
      return tail.size() >= kPngEnd && tail.substr(0, tail.size() - kPngEnd).ends_with(kPngMark);
    case OutputKind::jpeg:
      return head.starts_with("\xff\xd8") && head.substr(2).starts_with(kJpegMark);
    case OutputKind::pdf:
      return tail.ends_with(kPdfMark);
    case OutputKind::film:
      return tail.ends_with(kMp4Mark) || tail.ends_with(kWebmMark) ||
             (tail.ends_with("\x3b"sv) && tail.substr(0, tail.size() - 1).ends_with(kGifMark));
    case OutputKind::recording:
      return head.starts_with("\x89MCAP0\r\n"sv) && has(head.substr(0, 64), "cogrsim");
    case OutputKind::snapshot:
      return has(head, "\"cogrsim-snapshot\"") || has(tail, "\"cogrsim-snapshot\"");
    case OutputKind::figure:
      return has(head, "\"cogrsim-figure\"") || has(tail, "\"cogrsim-figure\"");
    case OutputKind::script:
      return head.starts_with(kScriptMark);
    case OutputKind::learner:
      return head.starts_with("cogrsim-learner ");
    case OutputKind::study:
      // Its tables may still be in the write-ahead log; whoever opens the database checks them.
      return head.starts_with("SQLite format 3"sv);
    case OutputKind::journal:
      return head.starts_with(kJournalMark);
    case OutputKind::text_table:
      return tail.ends_with(kXmlMark) || tail.ends_with(kPdfMark);
    case OutputKind::other:
      return head.starts_with(kScriptMark);
  }
  return false;
}

// Checks the beginning and the end of a regular file; never blocks and never follows a link.
bool is_ours(OutputKind kind, const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return false;
  std::string head(kMarkRange, '\0'), tail(kMarkRange, '\0');
  const ssize_t first = ::pread(file, head.data(), head.size(), 0);
  const off_t size = ::lseek(file, 0, SEEK_END);
  const off_t start = std::max<off_t>(0, size - static_cast<off_t>(kMarkRange));
  const ssize_t last = ::pread(file, tail.data(), tail.size(), start);
  ::close(file);
  if (first < 0 || last < 0) return false;
  head.resize(first);
  tail.resize(last);
  return is_ours(kind, head, tail);
}

// Errors: `path`'s folder leads out of `folder`, or its ending is not one of the kind's.
Result<> check_inside(const std::string& path, OutputKind kind, const std::string& folder) {
  std::error_code error;
  const fs::path parent = fs::canonical(folder_of(path), error);
  const fs::path root = error ? fs::path() : fs::canonical(folder, error);
  if (error) return refused(path, error.message(), "create its folder first");
  const auto inside = std::mismatch(root.begin(), root.end(), parent.begin(), parent.end());
  if (inside.first != root.end()) {
    return refused(path, fmt::format("a scene may only write in its output folder '{}'", folder),
                   "name a file inside that folder, or choose the folder with --output-dir");
  }
  const auto& endings = format_of(kind).endings;
  const std::string ending = ending_of(path);
  std::string list;
  for (const char* known : endings) {
    if (known == nullptr) break;
    if (ending == known) return {};
    list += (list.empty() ? "" : " or ") + std::string(known);
  }
  return refused(path, fmt::format("{} that a scene names ends in {}", format_of(kind).name, list));
}

}  // namespace

std::string output_folder(const std::string& scene_folder) {
  const char* const chosen = std::getenv("COGRSIM_OUTPUT_DIR");
  if (chosen != nullptr && *chosen != '\0') return chosen;
  return scene_folder.empty() ? "." : scene_folder;
}

Result<std::string> output_in(const std::string& folder, const std::string& name) {
  const auto no = [&](const std::string& why) {
    return fail(fmt::format("'{}' cannot be an output of a scene: {}", name, why), "",
                "name a file inside the scene's folder; --output-dir chooses another folder");
  };
  if (name.empty() || name.find('\0') != std::string::npos) return no("it names no file");
  const fs::path path(name);
  if (path.is_absolute()) return no("the name is absolute");
  for (const fs::path& part : path) {
    if (part == "..") return no("the name leads out of the folder");
  }
  if (path.filename().empty() || path.filename() == ".") return no("it names no file");
  return (fs::path(folder) / path).lexically_normal().string();
}

Result<> check_output(const std::string& path, OutputKind kind, const OutputRules& rules) {
  if (path.empty()) return refused(path, "the file name is empty");
  if (path.size() > 4000) return refused(path.substr(0, 40) + "…", "the name is too long");
  const std::string folder = folder_of(path);
  struct stat info {};
  if (::stat(folder.c_str(), &info) != 0) {
    return refused(path, fmt::format("folder '{}': {}", folder, system_reason()),
                   "create the folder first");
  }
  if (!S_ISDIR(info.st_mode)) return refused(path, fmt::format("'{}' is not a folder", folder));
  if (!rules.folder.empty()) {
    if (auto inside = check_inside(path, kind, rules.folder); !inside) return inside;
  }
  if (fs::path(path).filename().empty()) return refused(path, "it is a folder");
  // The rules are checked first, so that their reason is reported and not a missing permission.
  if (::lstat(path.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode)) return refused(path, "it is a folder");
    if (S_ISLNK(info.st_mode)) {
      return refused(path, "it is a symbolic link", "name the file it points to, or another one");
    }
    if (!S_ISREG(info.st_mode)) {
      return refused(path, "it is a device, pipe or socket",
                     "name a regular file; '-' is the standard output where a command offers it");
    }
    for (const std::string& input : rules.inputs) {
      struct stat other {};
      if (::stat(input.c_str(), &other) == 0 && other.st_dev == info.st_dev &&
          other.st_ino == info.st_ino) {
        return refused(path, "the result is made from it");
      }
    }
    const bool replaceable =
        rules.overwrite || (info.st_size == 0 && rules.folder.empty()) || is_ours(kind, path);
    if (!replaceable) {
      return refused(
          path, fmt::format("it exists, and is not {} that CogRSim wrote", format_of(kind).name),
          "choose another name, or remove it, or replace it with --overwrite");
    }
    if (::access(path.c_str(), W_OK) != 0) {
      return refused(path, system_reason(), "choose another file, or give it write permission");
    }
  } else if (errno != ENOENT) {
    return refused(path, system_reason());
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return refused(path, fmt::format("folder '{}': {}", folder, system_reason()),
                   "choose another folder, or give it write permission");
  }
  return {};
}

std::string marked(OutputKind kind, std::string bytes) {
  const auto before_end = [&](std::size_t end, std::string_view mark) {
    if (bytes.size() >= end) bytes.insert(bytes.size() - end, mark);
  };
  if (is_ours(kind, std::string_view(bytes).substr(0, kMarkRange),
              std::string_view(bytes).substr(bytes.size() - std::min(bytes.size(), kMarkRange)))) {
    return bytes;
  }
  switch (kind) {
    case OutputKind::json:
      if (bytes.starts_with("{\n")) {
        const std::size_t text = bytes.find_first_not_of(" \n", 1);
        const std::string indent = bytes.substr(1, text - 1);
        bytes.insert(1, indent + std::string(kJsonMark) + (bytes[text] == '}' ? "" : ","));
      } else if (bytes.starts_with("{")) {
        bytes.insert(1, std::string(kJsonMark) + (bytes.starts_with("{}") ? "" : ", "));
      }
      break;
    case OutputKind::xml:
    case OutputKind::svg:
    case OutputKind::html:
      if (!bytes.ends_with("\n")) bytes += '\n';
      bytes += kXmlMark;
      break;
    case OutputKind::pdf:
      bytes += kPdfMark;
      break;
    case OutputKind::png:
      before_end(kPngEnd, kPngMark);
      break;
    case OutputKind::jpeg:
      if (bytes.starts_with("\xff\xd8")) bytes.insert(2, kJpegMark);
      break;
    default:
      break;
  }
  return bytes;
}

Result<> write_output_file(const std::string& path, OutputKind kind, std::string bytes,
                           const OutputRules& rules) {
  auto file = OutputFile::create(path, kind, rules);
  if (!file) return tl::unexpected(file.error());
  if (auto done = file->append(marked(kind, std::move(bytes))); !done) return done;
  return file->commit();
}

Result<OutputFile> OutputFile::create(const std::string& path, OutputKind kind,
                                      const OutputRules& rules) {
  if (auto allowed = check_output(path, kind, rules); !allowed) {
    return tl::unexpected(allowed.error());
  }
  OutputFile file;
  file.path_ = path;
  file.kind_ = kind;
  file.rules_ = rules;
  struct stat info {};
  const bool exists = ::lstat(path.c_str(), &info) == 0;
  static std::atomic<unsigned> count{0};
  const fs::path target(path);
  // The extension is kept: external programs that write the file choose the format by it.
  file.temporary_ = (fs::path(folder_of(path)) /
                     fmt::format(".{}.{}-{}.part{}", target.stem().string().substr(0, 200),
                                 ::getpid(), count++, target.extension().string().substr(0, 20)))
                        .string();
  file.descriptor_ =
      ::open(file.temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
             kind == OutputKind::journal ? 0600
             : exists                    ? info.st_mode & 0777
                                         : 0666);
  if (file.descriptor_ < 0) {
    file.temporary_.clear();
    return refused(path, system_reason());
  }
  return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      kind_(other.kind_),
      rules_(std::move(other.rules_)),
      buffer_(std::move(other.buffer_)),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<> OutputFile::append(std::string_view bytes) {
  buffer_ += bytes;
  return buffer_.size() < kBufferSize ? Result<>() : flush();
}

Result<> OutputFile::flush() {
  std::string_view bytes = buffer_;
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      return refused(path_, n == 0 ? "no space left on device" : system_reason(),
                     "choose another file, or free some space");
    }
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  buffer_.clear();
  return {};
}

Result<> OutputFile::mark_film() {
  char head[4] = {}, last = 0;
  const off_t size = ::lseek(descriptor_, 0, SEEK_END);
  if (size < 8 || ::pread(descriptor_, head, sizeof head, 0) != sizeof head ||
      ::pread(descriptor_, &last, 1, size - 1) != 1) {
    return refused(path_, "the film is empty", "is the disk full?");
  }
  if (std::string_view(head, sizeof head) != "GIF8") {
    return append(std::string_view(head, sizeof head) == "\x1a\x45\xdf\xa3" ? kWebmMark : kMp4Mark);
  }
  if (last != '\x3b') return {};
  ::lseek(descriptor_, size - 1, SEEK_SET);
  return append(std::string(kGifMark) + "\x3b");
}

Result<> OutputFile::commit() {
  if (auto done = flush(); !done) return done;
  // An external program wrote the film.
  if (kind_ == OutputKind::film) {
    if (auto done = mark_film(); !done) return done;
  }
  if (auto done = flush(); !done) return done;
  // Some file systems report a full disk only here.
  const bool closed = !is_durable(kind_) || ::fsync(descriptor_) == 0;
  const int why = errno;
  if (::close(std::exchange(descriptor_, -1)) != 0 || !closed) {
    return refused(path_, std::strerror(closed ? errno : why));
  }
  if (auto allowed = check_output(path_, kind_, rules_); !allowed) return allowed;
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) return refused(path_, system_reason());
  temporary_.clear();
  if (is_durable(kind_)) {
    const int folder = ::open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
      ::fsync(folder);  // makes the renaming durable, where the file system supports that
      ::close(folder);
    }
  }
  return {};
}

}  // namespace cogrsim
