// Reads the files of a compilation, parses them, and checks that they come from allowed folders.
#include <dlfcn.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <filesystem>
#include <map>
#include <system_error>

#include "cogrsim/dsl/import_model.h"
#include "language/vocabulary.h"
#include "report/diagnostics.h"
#include "syntax/node.h"
#include "syntax/xml_scan.h"

namespace cogrsim::dsl {

namespace fs = std::filesystem;

/// tinyxml2's tree keeps the decoded strings.
struct Document::Storage {
  tinyxml2::XMLDocument xml{true, tinyxml2::PRESERVE_WHITESPACE};
};

Document::Document() : storage(std::make_unique<Storage>()) {}
Document::~Document() = default;

const Attribute* Node::find(std::string_view attribute) const {
  for (const Attribute& a : attributes) {
    if (a.name == attribute) return &a;
  }
  return nullptr;
}

std::string_view SourceFile::line(int number) const {
  if (number < 1 || number > static_cast<int>(line_starts.size())) return {};
  const auto i = static_cast<std::size_t>(number - 1);
  const std::size_t begin = line_starts[i];
  const std::size_t end = i + 1 < line_starts.size() ? line_starts[i + 1] : text.size();
  std::string_view out = std::string_view(text).substr(begin, end - begin);
  while (!out.empty() && (out.back() == '\n' || out.back() == '\r')) out.remove_suffix(1);
  return out;
}

namespace {

/// Below one of the folders, by whole path components; both canonical.
bool lies_below(const fs::path& path, const std::string& folder) {
  const fs::path relative = path.lexically_relative(folder);
  return !relative.empty() && *relative.begin() != fs::path("..");
}

std::string megabytes(std::size_t bytes) {
  if (bytes < (1u << 20)) return std::to_string(bytes) + " bytes";
  return std::to_string((bytes + (1u << 19)) >> 20) + " MiB";
}

/// Reads at most `limit` bytes; too_large when there are more. False: cannot be read.
bool read_file(const std::string& path, std::size_t limit, std::string& out, bool& too_large) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (!file) return false;
  char buffer[1 << 16];
  too_large = false;
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, file)) {
    out.append(buffer, n);
    if (out.size() > limit) {
      too_large = true;
      break;
    }
  }
  const bool good = std::ferror(file) == 0;
  std::fclose(file);
  return good;
}

/// Replaces the nodes' raw strings by tinyxml2's decoded ones. Both trees hold the same elements
/// and attributes in the same order, or the scan would have refused the file.
bool take_decoded(const tinyxml2::XMLElement* xml, std::deque<Node>& nodes, std::size_t& next) {
  if (next >= nodes.size()) return false;
  Node& node = nodes[next++];
  if (node.name != xml->Name()) return false;
  const tinyxml2::XMLAttribute* a = xml->FirstAttribute();
  for (Attribute& ours : node.attributes) {
    if (!a || ours.name != a->Name()) return false;
    ours.value = a->Value();
    a = a->Next();
  }
  if (a) return false;
  for (const tinyxml2::XMLNode* c = xml->FirstChild(); c; c = c->NextSibling()) {
    if (const tinyxml2::XMLElement* child = c->ToElement()) {
      if (!take_decoded(child, nodes, next)) return false;
    }
  }
  return true;
}

/// The folder of scenes that is installed with this library, as plugins are; empty: there is none.
std::string installed_library() {
  Dl_info self;
  if (::dladdr(reinterpret_cast<const void*>(&installed_library), &self) == 0) return {};
  std::error_code fault;
  const fs::path own = fs::canonical(self.dli_fname, fault);
  if (fault) return {};
  const fs::path folder = fs::canonical(own.parent_path() / "cogrsim" / "library", fault);
  return fault ? std::string() : folder.string();
}

}  // namespace

SourceFiles::SourceFiles(const CompileOptions& options, DiagnosticSink& sink)
    : options_(options), sink_(sink), installed_(installed_library()) {
  sink_.set_files(this);
}

SourceFiles::~SourceFiles() = default;

const std::vector<std::string>& SourceFiles::engine_blocks() const {
  if (engine_blocks_) return *engine_blocks_;
  engine_blocks_.emplace();
  if (options_.plugins) {
    // It loads all plugins, so only scenes that need it pay for it.
    engine_blocks_ = options_.plugins->names(PluginKind::backend);
  } else {
    // Without a catalog the scene itself says which engines it knows.
    for (const Node* child : documents_.front()->nodes.front().children) {
      if (child->name != "physics") continue;
      if (const Attribute* a = child->find("backend")) engine_blocks_->emplace_back(a->value);
      for (const Node* block : child->children) engine_blocks_->emplace_back(block->name);
    }
  }
  return *engine_blocks_;
}

std::optional<Error> SourceFiles::engine_fault(const std::string& name) const {
  if (!options_.plugins) return std::nullopt;
  const auto options = options_.plugins->world_options(name);
  if (options || (options.error().code != "CG0902" && options.error().code != "CG0910")) {
    return std::nullopt;
  }
  return options.error();
}

const Document* SourceFiles::open_scene(const std::string& path) {
  std::error_code fault;
  const auto refuse = [&](const char* code, std::string message, std::string help = {}) {
    // The file has no text to quote, but its name belongs into the report.
    auto file = std::make_unique<SourceFile>();
    file->name = path;
    files_.push_back(std::move(file));
    SourceSpan whole;
    whole.file = 0;
    sink_.report(code, whole, nullptr, std::move(message)).help(std::move(help));
    return nullptr;
  };
  const fs::file_status status = fs::status(path, fault);
  if (!fs::exists(status)) return refuse("CG0101", "there is no file \"" + path + "\"");
  if (fs::is_directory(status)) {
    return refuse("CG0101", "\"" + path + "\" is a folder", "name the scene file in it");
  }
  const std::size_t limit = options_.limits.file_bytes;
  if (fs::is_regular_file(status)) {
    const std::uintmax_t size = fs::file_size(path, fault);
    if (!fault && size > limit) {
      return refuse("CG0108",
                    "the file has " + megabytes(static_cast<std::size_t>(size)) + ", at most " +
                        megabytes(limit) + " are read",
                    "put large data into mesh files, or write repeated elements with <repeat>");
    }
  }
  std::string text;
  bool too_large = false;
  if (!read_file(path, limit, text, too_large)) {
    return refuse("CG0101", "\"" + path + "\" cannot be read");
  }
  if (too_large) {
    return refuse("CG0108", "the file is larger than " + megabytes(limit),
                  "put large data into mesh files, or write repeated elements with <repeat>");
  }
  return open_scene_text(text, path);
}

const Document* SourceFiles::open_plain(const std::string& path, bool lenient) {
  plain_ = true;
  lenient_ = lenient;
  return open_scene(path);
}

const Document* SourceFiles::open_plain_text(const std::string& text, const std::string& name) {
  plain_ = true;
  return open_scene_text(text, name);
}

const Document* SourceFiles::open_scene_text(const std::string& text, const std::string& name) {
  std::error_code fault;
  fs::path folder = fs::path(name).parent_path();
  if (folder.empty()) folder = ".";
  const fs::path canonical = fs::weakly_canonical(folder, fault);
  roots_.push_back(fault ? folder.string() : canonical.string());
  for (const std::string& library : options_.library_folders) {
    const fs::path path = fs::canonical(library, fault);
    if (!fault) roots_.push_back(path.string());
  }
  if (!installed_.empty()) roots_.push_back(installed_);
  if (text.size() > options_.limits.file_bytes) {
    auto file = std::make_unique<SourceFile>();
    file->name = name;
    files_.push_back(std::move(file));
    SourceSpan whole;
    whole.file = 0;
    sink_.report("CG0108", whole, nullptr,
                 "the text has " + megabytes(text.size()) + ", at most " +
                     megabytes(options_.limits.file_bytes) + " are read");
    return nullptr;
  }
  const fs::path own = fs::path(roots_.front()) / fs::path(name).filename();
  read_.insert(own.string());
  return add(name, own.string(), text);
}

const Document* SourceFiles::open_import(std::string_view href, const std::string& keyframe,
                                         const SourceSpan& at) {
  const std::string path = locate(href, at, "imported file");
  if (path.empty()) return nullptr;
  const auto known = by_path_.find({path, keyframe});
  if (known != by_path_.end()) {
    const Document* document = documents_[known->second].get();
    return document->root ? document : nullptr;
  }
  if (size() >= options_.limits.files) {
    sink_.report("CG0110", at, nullptr,
                 "more than " + std::to_string(options_.limits.files) + " files");
    return nullptr;
  }
  std::string text;
  bool too_large = false;
  if (!read_file(path, options_.limits.file_bytes, text, too_large)) {
    sink_.report("CG0301", at, nullptr, "\"" + std::string(href) + "\" cannot be read");
    return nullptr;
  }
  if (too_large) {
    sink_.report(
        "CG0108", at, nullptr,
        "\"" + std::string(href) + "\" is larger than " + megabytes(options_.limits.file_bytes));
    return nullptr;
  }
  const bool foreign = is_foreign_model(text);
  if (!foreign && !keyframe.empty()) {
    sink_.report("CG1408", at, nullptr, "there is no keyframe '" + keyframe + "'")
        .help("a scene has no keyframes; they are of robots in MJCF");
    return nullptr;
  }
  if (foreign && !convert_model(path, href, keyframe, at, text)) return nullptr;
  // Shown the way the user named the scene, so that it can be clicked on.
  const fs::path shown = fs::path(files_.front()->name).parent_path();
  std::error_code fault;
  fs::path name = fs::path(path).lexically_relative(roots_.front());
  if (name.empty() || *name.begin() == fs::path("..")) {
    name = path;
  } else {
    name = shown / name;
  }
  return add(name.string() + (foreign ? " (as a scene)" : ""), path, std::move(text), keyframe);
}

bool SourceFiles::convert_model(const std::string& path, std::string_view href,
                                const std::string& keyframe, const SourceSpan& at,
                                std::string& text) {
  ImportOptions how;
  how.keyframe = keyframe;
  how.prototype_only = how.refer = true;
  how.only_below = roots_;
  how.scene_folder = fs::path(path).parent_path().string();
  how.limits = options_.limits;
  how.work = &work;
  ImportResult made = import_model(path, how);
  read_.insert(made.files_read.begin(), made.files_read.end());
  std::map<std::string, Report> reports;  // the same of several lines is one with several notes
  for (const Diagnostic& d : made.diagnostics) {
    auto [same, first] =
        reports.try_emplace(d.code + d.message, sink_.report(d.code, at, nullptr, d.message));
    if (first) same->second.help(d.help);
    same->second.note("in the imported model", d);
  }
  if (made.scene.empty()) return false;
  const std::size_t cost = 16 * made.scene.size();
  if (cost >= work) {
    work = 0;
    sink_.report("CG1402", at, nullptr, "there is too much to read and to compute in this model");
    return false;
  }
  work -= cost;
  const std::size_t lost = made.count(Fidelity::left_out);
  if (lost > 0) {
    const auto first =
        std::find_if(made.entries.begin(), made.entries.end(),
                     [](const ImportEntry& e) { return e.fidelity == Fidelity::left_out; });
    sink_
        .report("CG2004", at, nullptr,
                std::to_string(lost) + (lost == 1 ? " element" : " elements") + " of \"" +
                    std::string(href) + "\" could not be imported, the first: " + first->element +
                    ": " + first->message)
        .note("the first is in the imported model", *first)
        .help("cogrsim import " + std::string(href) + " lists all");
  }
  text = std::move(made.scene);
  return true;
}

std::string SourceFiles::resolve_asset(std::string_view href, const SourceSpan& at) {
  const std::string path = locate(href, at, "file");
  if (path.empty()) return {};
  std::error_code fault;
  const std::uintmax_t size = fs::file_size(path, fault);
  if (fault || size > options_.limits.asset_bytes) {
    sink_.report(
        "CG0314", at, nullptr,
        "\"" + std::string(href) + "\" is larger than " + megabytes(options_.limits.asset_bytes));
    return {};
  }
  return path;
}

std::string SourceFiles::locate(std::string_view href, const SourceSpan& at, const char* what) {
  const std::string shown(href);
  if (href.empty()) {
    sink_.report("CG0301", at, nullptr, std::string("the name of the ") + what + " is empty");
    return {};
  }
  if (href.find("://") != std::string_view::npos) {
    sink_.report("CG0303", at, nullptr, "\"" + shown + "\" is not a file beside the scene")
        .help("copy it there: a scene reads nothing from elsewhere");
    return {};
  }
  // Beside the file that names it, then in the libraries.
  std::vector<fs::path> candidates;
  if (at.file >= 0) candidates.push_back(fs::path(file(at.file).path).parent_path() / shown);
  for (std::size_t i = 0; i < roots_.size(); ++i) candidates.push_back(fs::path(roots_[i]) / shown);
  bool outside = false, other_kind = false;
  std::vector<std::string> tried;
  for (const fs::path& candidate : candidates) {
    std::error_code fault;
    const fs::path path = fs::weakly_canonical(candidate, fault);
    if (fault) continue;
    const bool allowed = std::any_of(roots_.begin(), roots_.end(), [&](const std::string& root) {
      return lies_below(path, root);
    });
    if (!allowed) {
      outside = true;
      continue;
    }
    if (fs::is_regular_file(path, fault)) return *read_.insert(path.string()).first;
    other_kind = other_kind || fs::exists(path, fault);
    if (!installed_.empty() && lies_below(path, installed_)) continue;  // not where files are put
    if (std::find(tried.begin(), tried.end(), path.string()) == tried.end()) {
      tried.push_back(path.string());
    }
  }
  if (outside && tried.empty()) {
    sink_
        .report("CG0303", at, nullptr,
                "\"" + shown + "\" lies outside of the scene's folder and the libraries")
        .help("copy it below the scene's folder");
    return {};
  }
  if (other_kind) {
    sink_.report("CG0301", at, nullptr, "\"" + shown + "\" is not a regular file")
        .help("a scene reads no folders, devices and pipes");
    return {};
  }
  // Where it was looked for, as seen from the scene: absolute paths differ between machines.
  std::string help;
  for (const std::string& path : tried) {
    fs::path relative = fs::path(path).lexically_relative(roots_.front());
    if (!relative.empty() && *relative.begin() == fs::path("..")) relative = path;
    help += (help.empty() ? "looked for " : " and ") + relative.string();
  }
  sink_.report("CG0301", at, nullptr, std::string("there is no ") + what + " \"" + shown + "\"")
      .help(help);
  return {};
}

const Document* SourceFiles::add(std::string name, std::string path, std::string text,
                                 const std::string& keyframe) {
  if (text.compare(0, 3, "\xEF\xBB\xBF") == 0) text.erase(0, 3);  // byte order mark
  auto file = std::make_unique<SourceFile>();
  file->name = std::move(name);
  file->path = std::move(path);
  file->text = std::move(text);
  file->line_starts = find_line_starts(file->text);
  const int index = size();
  files_.push_back(std::move(file));
  const SourceFile& source = *files_.back();

  documents_.push_back(std::make_unique<Document>());
  by_path_.emplace(std::pair(source.path, keyframe), documents_.size() - 1);
  Document& document = *documents_.back();
  document.file = index;
  document.lenient = lenient_;
  Limits limits = options_.limits;
  limits.depth = std::min(limits.depth, 90);  // tinyxml2 itself ends at 100
  std::vector<std::pair<std::size_t, std::size_t>> instructions;
  if (!scan_xml(source, index, limits, sink_, document, instructions)) return nullptr;
  // tinyxml2 takes processing instructions for misplaced XML declarations.
  std::string plain;
  if (!instructions.empty()) plain = source.text;
  for (const auto& [begin, end] : instructions) plain.replace(begin, end - begin, end - begin, ' ');
  const std::string& text_to_parse = instructions.empty() ? source.text : plain;

  tinyxml2::XMLDocument& xml = document.storage->xml;
  std::size_t next = 0;
  if (xml.Parse(text_to_parse.data(), text_to_parse.size()) != tinyxml2::XML_SUCCESS ||
      !xml.RootElement() || !take_decoded(xml.RootElement(), document.nodes, next)) {
    SourceSpan first;
    first.file = index;
    first.line = first.column = 1;
    sink_.report("CG0103", first, nullptr, "the XML reader cannot read this file");
    return nullptr;
  }
  document.root = &document.nodes.front();
  if (plain_) return &document;
  check_vocabulary(document, *this, sink_);
  return document.root ? &document : nullptr;
}

SourceSpan SourceFiles::span_in_value(const Attribute& attribute, std::size_t begin,
                                      std::size_t length) const {
  SourceSpan span = attribute.value_span;
  if (span.file < 0) return span;
  const std::string_view text = file(span.file).text;
  const std::size_t end = attribute.raw_begin + attribute.raw_length;
  // The words of a value are mostly requested in order.
  if (cursor_.start.file != span.file || cursor_.start.line != span.line ||
      cursor_.start.column != span.column || cursor_.decoded > begin)
    cursor_ = {span, span, attribute.raw_begin, 0};
  // Walks source and decoded value side by side; an entity is several source bytes for few others.
  const auto advance = [&](std::size_t& at, std::size_t& decoded, std::size_t target,
                           SourceSpan* lines) {
    int columns = 0;
    while (decoded < target && at < end) {
      if (text[at] == '&') {
        const std::size_t semicolon = std::min(text.find(';', at), end - 1);
        const std::string_view body = text.substr(at + 1, semicolon - at - 1);
        std::size_t bytes = 1;
        if (!body.empty() && body[0] == '#') {
          const bool hex = body.size() > 1 && body[1] == 'x';
          std::uint32_t value = 0;
          for (const char c : body.substr(hex ? 2 : 1)) {
            const auto digit = static_cast<std::uint32_t>(c <= '9' ? c - '0' : (c | 32) - 'a' + 10);
            value = value * (hex ? 16u : 10u) + digit;
          }
          bytes = value < 0x80 ? 1 : value < 0x800 ? 2 : value < 0x10000 ? 3 : 4;
        }
        columns += static_cast<int>(semicolon - at + 1);
        at = semicolon + 1;
        decoded += bytes;
        continue;
      }
      const char c = text[at];
      if (c == '\r' && at + 1 < end && text[at + 1] == '\n') ++at;
      if ((c == '\n' || c == '\r') && lines != nullptr) {
        ++lines->line;
        lines->column = 1;
        columns = 0;
      } else if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) {
        ++columns;
      }
      ++at;
      ++decoded;
    }
    return columns;
  };
  const int columns = advance(cursor_.at, cursor_.decoded, begin, &cursor_.span);
  cursor_.span.column += columns;
  span = cursor_.span;
  std::size_t at = cursor_.at, decoded = cursor_.decoded;
  int marked = advance(at, decoded, begin + length, nullptr);
  const std::size_t line_end = text.substr(0, at).find_first_of("\r\n", cursor_.at);
  if (line_end < at) {  // underline to the end of its first line only
    marked = std::max(1, static_cast<int>(line_end) - static_cast<int>(attribute.raw_begin));
  }
  span.length = std::max(1, marked);
  return span;
}

}  // namespace cogrsim::dsl
