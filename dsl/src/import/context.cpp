#include "import/context.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "assets/mesh_file.h"
#include "assets/mesh_text.h"
#include "cogrsim/core/parameter.h"
#include "report/diagnostics.h"
#include "syntax/node.h"

namespace cogrsim::dsl {

const char* fidelity_name(Fidelity fidelity) {
  return fidelity == Fidelity::exact         ? "exact"
         : fidelity == Fidelity::approximate ? "approximate"
                                             : "left out";
}

std::size_t FidelityReport::count(Fidelity fidelity) const {
  return static_cast<std::size_t>(
      std::count_if(entries.begin(), entries.end(),
                    [&](const ImportEntry& e) { return e.fidelity == fidelity; }));
}

std::vector<const ImportEntry*> FidelityReport::by_weight() const {
  std::vector<const ImportEntry*> out;
  for (const ImportEntry& e : entries) out.push_back(&e);
  const auto weight = [](const ImportEntry* e) {
    const bool exact = e->fidelity == Fidelity::exact;
    return std::pair(e->moves && !exact, static_cast<int>(e->fidelity));
  };
  std::stable_sort(out.begin(), out.end(), [&](const ImportEntry* a, const ImportEntry* b) {
    return weight(a) > weight(b);
  });
  return out;
}

}  // namespace cogrsim::dsl

namespace cogrsim::dsl::import {

namespace fs = std::filesystem;

namespace {

/// Of all files of an import together; a model that includes more is not one that a person wrote.
constexpr std::size_t kMostBytes = 256u << 20;

constexpr std::size_t kWorkOfSearch = 20000;  // for a file or a package, in folders

constexpr std::size_t kMostMeshBytes = std::size_t{2} << 30;

// A name of a whole file's length would be in each finding about its element [byte].
constexpr std::size_t kLongestEntry = 300, kLongestError = 1000;

std::string shortened(std::string text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end) + "…";
}

std::unique_ptr<XmlElement> tree_of(const Node& node, int file) {
  auto out = std::make_unique<XmlElement>();
  out->name = node.name;
  out->at = {file, node.span.line, node.span.column};
  for (const Attribute& a : node.attributes)
    out->attributes.emplace_back(std::string(a.name), std::string(a.value));
  out->text = node.text;
  for (const Node* child : node.children) out->children.push_back(tree_of(*child, file));
  return out;
}

std::string canonical(const std::string& path) {
  std::error_code fault;
  const fs::path out = fs::weakly_canonical(path, fault);
  return fault ? std::string() : out.string();
}

bool is_below(const std::string& path, const std::string& folder) {
  const fs::path relative = fs::path(path).lexically_relative(folder);
  return !relative.empty() && *relative.begin() != fs::path("..");
}

/// The name in a folder's package.xml, which need not be the folder's; empty: none.
std::string package_name(const fs::path& folder) {
  const std::string text =
      read_whole_file((folder / "package.xml").string(), 1u << 20).value_or("");
  const std::size_t begin = text.find("<name>"), end = text.find("</name>");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return "";
  std::string_view inside = std::string_view(text).substr(begin + 6, end - begin - 6);
  return std::string(next_word(inside));
}

/// Folders named in an environment variable, separated by colons.
std::vector<std::string> folders_in(const char* variable) {
  std::vector<std::string> out;
  const char* value = std::getenv(variable);
  std::string_view rest = value == nullptr ? "" : value;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (end > 0) out.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return out;
}

}  // namespace

const std::string* XmlElement::find(std::string_view attribute) const {
  for (const auto& [key, value] : attributes)
    if (key == attribute) return &value;
  return nullptr;
}

const XmlElement* XmlElement::child(std::string_view tag) const {
  for (const auto& c : children)
    if (c->name == tag) return c.get();
  return nullptr;
}

std::unique_ptr<XmlElement> XmlElement::copy() const {
  auto out = std::make_unique<XmlElement>();
  out->name = name;
  out->attributes = attributes;
  out->text = text;
  out->at = at;
  for (const auto& c : children) out->children.push_back(c->copy());
  return out;
}

void add_to(std::string& list, std::string_view entry, std::string_view between) {
  if (!list.empty()) list += between;
  list += entry;
}

std::string quoted_name(const XmlElement& element) {
  const std::string* name = element.find("name");
  return name == nullptr ? "<" + element.name + ">" : element.name + " '" + *name + "'";
}

std::size_t work_of(const XmlElement& element) {
  std::size_t bytes = element.name.size() + element.text.size();
  for (const auto& [key, value] : element.attributes) bytes += key.size() + value.size();
  return 1500 + 400 * element.attributes.size() + 16 * bytes;
}

Context::Context(const std::string& path, const ImportOptions& given)
    : options(given), work_(given.work != nullptr ? given.work : &own_work_) {
  const std::string full = canonical(path);
  folder_ = fs::path(full).parent_path().string();
  allowed_ = options.only_below;
  if (allowed_.empty()) allowed_.push_back(folder_);
  for (const auto& [name, folder] : options.packages) {
    packages_[name] = canonical(folder);
    allowed_.push_back(packages_[name]);
  }
  // The package that the model is in: the nearest folder above that has a package.xml.
  for (fs::path up = folder_; up.has_relative_path(); up = up.parent_path()) {
    std::error_code fault;
    if (!fs::is_regular_file(up / "package.xml", fault)) continue;
    if (!may_read(up.string())) break;
    packages_.emplace(up.filename().string(), up.string());
    if (const std::string name = package_name(up); !name.empty())
      packages_.emplace(name, up.string());
    allowed_.push_back(up.string());
    break;
  }
}

void Context::spend(std::size_t work, const Source& at) {
  if (work < *work_) {
    *work_ -= work;
    return;
  }
  *work_ = 0;
  refuse(at, "CG1402", "there is too much to read and to compute in this model",
         "look for files, macros and long texts that are used many times");
}

std::unique_ptr<XmlElement> Context::copy(const XmlElement& element) {
  const auto pay = [&](const XmlElement& e, const auto& self) -> void {
    spend(work_of(e), e.at);
    for (const auto& c : e.children) self(*c, self);
  };
  pay(element, pay);
  return element.copy();
}

std::string Context::near(const std::string& name, const std::vector<std::string>& known) {
  std::size_t steps = 0;
  for (const std::string& other : known) steps += name.size() * other.size();
  if (steps > near_left_) return "";
  near_left_ -= steps;
  return nearest_name(name, known);
}

std::unique_ptr<XmlElement> Context::parse(const std::string& path, const Source& from) {
  const bool again = trees_.count(path) != 0;
  const XmlElement& tree = parsed(path, from);
  return again ? copy(tree) : tree.copy();
}

const XmlElement& Context::parsed(const std::string& path, const Source& from) {
  auto& tree = trees_[path];
  if (tree != nullptr) return *tree;
  std::error_code fault;
  if (fs::exists(path, fault) && !fs::is_regular_file(path, fault))
    refuse(from, "CG0101", fmt::format("'{}' is not a regular file", shown(path)));
  const std::uintmax_t size = fs::file_size(path, fault);
  if (!fault && bytes_ + size > kMostBytes)
    refuse(from, "CG1402",
           fmt::format("the model's files have more than {} MB together", kMostBytes >> 20));
  bytes_ += fault ? 0 : static_cast<std::size_t>(size);
  if (files_.size() > 1000) refuse(from, "CG1402", "the model includes more than 1000 files");
  CompileOptions compile;
  compile.limits = options.limits;
  DiagnosticSink sink(compile.limits);
  SourceFiles sources(compile, sink);
  const Document* document = sources.open_plain(path, true);
  files_.push_back(path);
  note_read(path);
  if (document == nullptr || document->root == nullptr) {
    for (Diagnostic d : sink.take()) {
      d.file = shown(path);
      result.diagnostics.push_back(std::move(d));
    }
    failed_ = true;
    throw Refused{};
  }
  tree = tree_of(*document->root, static_cast<int>(files_.size()) - 1);
  return *tree;
}

Result<std::string> Context::package(const std::string& name) {
  const auto known = packages_.find(name);
  if (known != packages_.end()) return known->second;
  spend(kWorkOfSearch, {});
  if (name.empty() || name.find('/') != std::string::npos || name.front() == '.')
    return fail("'" + name + "' is not the name of a package");
  const auto take = [&](const fs::path& folder) {
    std::error_code fault;
    const fs::path found = fs::weakly_canonical(folder, fault);
    if (fault || !fs::is_directory(found, fault)) return false;
    if (!may_read(found.string())) return false;
    packages_[name] = found.string();
    allowed_.push_back(found.string());
    return true;
  };
  // Above the model: the folder of that name in which it lies, and folders of that name beside it. They
  // must contain package.xml or model.config, so that a model cannot read any folder it names.
  const auto is_package = [](const fs::path& folder) {
    std::error_code fault;
    return fs::is_regular_file(folder / "package.xml", fault) ||
           fs::is_regular_file(folder / "model.config", fault);
  };
  for (fs::path up = folder_; up.has_relative_path(); up = up.parent_path())
    for (const fs::path& folder : {up.filename() == name ? up : fs::path(), up / name})
      if (!folder.empty() && is_package(folder) && take(folder)) return packages_[name];
  for (const std::string& root : folders_in("ROS_PACKAGE_PATH")) {
    if (fs::path(root).filename() == name && take(root)) return packages_[name];
    if (take(fs::path(root) / name)) return packages_[name];
  }
  for (const std::string& root : folders_in("AMENT_PREFIX_PATH"))
    if (take(fs::path(root) / "share" / name)) return packages_[name];
  return fail("there is no package '" + name + "'", "",
              "name its folder with --package " + name + "=DIR");
}

bool Context::may_read(const std::string& folder) const {
  const auto& within = options.only_below;
  return within.empty() || std::any_of(within.begin(), within.end(), [&](const std::string& root) {
           return folder == root || is_below(folder, root);
         });
}

Result<LoadedMesh> Context::mesh(const std::string& path, const std::string& name) {
  std::error_code fault;
  std::size_t size = 0;
  const auto count = [&](const std::string& file) {
    const std::uintmax_t bytes = fs::file_size(file, fault);
    size += fault ? 0 : static_cast<std::size_t>(bytes);
  };
  count(path);
  if (mesh_bytes_ + size > kMostMeshBytes)
    return fail(
        fmt::format("the model's meshes have more than {} MB together", kMostMeshBytes >> 20));
  // For its extent, its mass and its parts; each further scale reads it again.
  if (++mesh_reads_[path] > 4) spend(32 * size, {});
  auto mesh = read_mesh(path, name, options.limits.asset_bytes);
  if (mesh) {
    for (const std::string& file : mesh->files) {
      count(file);
      note_read(file);
    }
    spend(work_beyond(mesh->mesh, size), {});
  }
  mesh_bytes_ += size;
  return mesh;
}

const Result<Bounds>& Context::mesh_bounds(const std::string& path) {
  const auto known = bounds_.find(path);
  if (known != bounds_.end()) return known->second;
  const auto read = [&]() -> Result<Bounds> {
    const auto of = mesh(path, fs::path(path).filename().string());
    if (!of) return tl::unexpected(of.error());
    looks_[path] = {of->color, of->differs, !of->files.empty(), is_gltf(path)};
    Bounds out;
    for (const Vec3& v : of->mesh.vertices) out.add(v);
    return out;
  };
  return bounds_.emplace(path, read()).first->second;
}

bool Context::allowed(const std::string& path) const {
  return std::any_of(allowed_.begin(), allowed_.end(),
                     [&](const std::string& folder) { return is_below(path, folder); });
}

Result<std::string> Context::locate(const std::string& href, const Source& from) {
  if (href.size() > 4096) return fail("the name of a file is longer than 4096 characters");
  spend(kWorkOfSearch, from);
  std::string path, in_package;
  const auto starts = [&](std::string_view with) {
    return href.compare(0, with.size(), with) == 0;
  };
  if (starts("package://") || starts("model://")) {
    const std::size_t begin = href.find("://") + 3;
    const std::size_t slash = href.find('/', begin);
    if (slash == std::string::npos) return fail("'" + href + "' names no file of the package");
    auto folder = package(href.substr(begin, slash - begin));
    if (!folder) return tl::unexpected(folder.error());
    path = *folder + href.substr(slash);
    in_package = *folder;
  } else if (starts("file://")) {
    path = href.substr(7);
  } else if (href.find("://") != std::string::npos) {
    return fail("'" + href + "' is not a file of this machine", "", "download it first");
  } else if (!href.empty() && href.front() == '/') {
    path = href;
  } else {
    path = (fs::path(path_of(from.file)).parent_path() / href).string();
  }
  std::string found = canonical(path);
  std::error_code fault;
  if (!fs::is_regular_file(found, fault) && from.file >= 0 && !href.empty() &&
      href.front() != '/' && href.find("://") == std::string::npos) {
    // Some converters write names relative to the model and not to the file that is included.
    const std::string beside = canonical((fs::path(folder_) / href).string());
    if (fs::is_regular_file(beside, fault)) found = beside;
  }
  // A package found by its name alone may be any folder above: what is hidden there is no part of it.
  const auto hidden = [](const fs::path& part) {
    return part.native().front() == '.' && part != ".." && part != ".";
  };
  const fs::path inside =
      in_package.empty() ? fs::path() : fs::path(found).lexically_relative(in_package);
  if (found.empty() || !allowed(found) || std::any_of(inside.begin(), inside.end(), hidden))
    return fail("'" + href + "' lies outside of the model's folder and its packages", "",
                "allow its folder with --package NAME=DIR, or copy the file beside the model");
  if (!fs::is_regular_file(found, fault)) return fail("there is no file '" + href + "'");
  note_read(found);
  return found;
}

void Context::note_read(const std::string& path) {
  if (read_.insert(path).second) result.files_read.push_back(path);
}

std::string Context::shown(const std::string& path) const {
  const fs::path relative = fs::path(path).lexically_relative(folder_);
  return relative.empty() || *relative.begin() == fs::path("..") ? path : relative.string();
}

void Context::add(Fidelity fidelity, const Source& at, std::string element, std::string message) {
  if (entries_left_ == 0) return;
  if (--entries_left_ == 0) message = "more was read than is listed here";
  ImportEntry entry;
  entry.fidelity = fidelity;
  entry.element = std::move(element);
  entry.message = std::move(message);
  entry.element = shortened(std::move(entry.element), kLongestEntry);
  entry.message = shortened(std::move(entry.message), kLongestEntry);
  entry.moves = asides_ == 0;
  if (at.file >= 0) entry.file = shown(path_of(at.file));
  entry.line = at.line;
  entry.column = at.column;
  result.entries.push_back(std::move(entry));
}

void Context::exact(const Source& at, std::string element, std::string message) {
  add(Fidelity::exact, at, std::move(element), std::move(message));
}
void Context::approximate(const Source& at, std::string element, std::string message) {
  add(Fidelity::approximate, at, std::move(element), std::move(message));
}
void Context::exact_unless(const Source& at, std::string element, std::string differs,
                           const std::string& message) {
  const Fidelity fidelity = differs.empty() ? Fidelity::exact : Fidelity::approximate;
  if (!message.empty()) add_to(differs, message);
  add(fidelity, at, std::move(element), std::move(differs));
}
void Context::left_out(const Source& at, std::string element, std::string message) {
  add(Fidelity::left_out, at, std::move(element), std::move(message));
}

void Context::not_read(const Source& at, const std::string& kind, const std::string& href,
                       const Error& why) {
  // Without the name, so that the report lists what has the same reason as one.
  const std::string name = "'" + href + "'";
  std::string message = why.message;
  if (const std::size_t found = message.find(name); found != std::string::npos)
    message.erase(found == 0 ? 0 : found - 1, name.size() + 1);
  if (!why.hint.empty()) message += "; " + why.hint;
  left_out(at, kind + " " + name, std::move(message));
}

void Context::error(const Source& at, std::string code, std::string message, std::string help) {
  failed_ = true;
  if (result.diagnostics.size() >= 100) throw Refused{};
  Diagnostic d;
  d.code = std::move(code);
  d.message = shortened(std::move(message), kLongestError);
  d.help = std::move(help);
  if (at.file >= 0) d.file = shown(path_of(at.file));
  d.line = at.line;
  d.column = at.column;
  d.length = 1;
  result.diagnostics.push_back(std::move(d));
}

void Context::refuse(const Source& at, std::string code, std::string message, std::string help) {
  error(at, std::move(code), std::move(message), std::move(help));
  throw Refused{};
}

std::optional<std::vector<double>> Context::numbers(const XmlElement& element,
                                                    const std::string& text, std::size_t least,
                                                    std::size_t most, const std::string& what) {
  std::vector<double> out;
  std::string_view rest = text;
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
    const auto value = to_number(word);
    if (!value || out.size() >= most) {
      error(element.at, "CG1403",
            fmt::format("{} of <{}>: '{}' {}", what, element.name, std::string(word.substr(0, 60)),
                        value ? fmt::format("is one number too many: {} are expected", most)
                              : "is not a number"));
      return std::nullopt;
    }
    out.push_back(*value);
  }
  if (out.size() < least) {
    error(element.at, "CG1403",
          fmt::format("{} of <{}> has {} numbers, {} are expected", what, element.name, out.size(),
                      least));
    return std::nullopt;
  }
  return out;
}

std::optional<double> Context::number(const XmlElement& element, const char* attribute) {
  const std::string* text = element.find(attribute);
  if (text == nullptr) return std::nullopt;
  const auto values = numbers(element, *text, 1, 1, fmt::format("'{}'", attribute));
  if (!values) return std::nullopt;
  return values->front();
}

double Context::number(const XmlElement& element, const char* attribute, double otherwise) {
  return number(element, attribute).value_or(otherwise);
}

Vec3 Context::vec3(const XmlElement& element, const char* attribute, const Vec3& otherwise) {
  const std::string* text = element.find(attribute);
  if (text == nullptr) return otherwise;
  const auto values = numbers(element, *text, 3, 3, fmt::format("'{}'", attribute));
  return values ? Vec3((*values)[0], (*values)[1], (*values)[2]) : otherwise;
}

}  // namespace cogrsim::dsl::import
