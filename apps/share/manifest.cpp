#include "manifest.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "hash.h"

namespace cogrsim::share {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "cogrsim-package";

bool is_sha256(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// A text of an object. Errors: it is missing, or no text.
Result<std::string> text_of(const Json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_string()) {
    return fail(fmt::format("the manifest has no text \"{}\"", key));
  }
  return it->get<std::string>();
}

Result<std::uint64_t> size_of(const Json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number_unsigned()) {
    return fail(fmt::format("the manifest has no size \"{}\"", key));
  }
  return it->get<std::uint64_t>();
}

// Parsers read deep nesting and duplicate keys differently: a manifest with them is refused.
Result<Json> parse_strictly(const std::string& text) {
  bool twice = false, deep = false;
  std::vector<std::set<std::string>> keys;
  const auto look = [&](int depth, Json::parse_event_t event, Json& parsed) {
    using Event = Json::parse_event_t;
    deep = deep || depth > 8;
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::key) {
      twice = twice || keys.empty() || !keys.back().insert(parsed.get<std::string>()).second;
    }
    if (event == Event::object_end && !keys.empty()) keys.pop_back();
    return !deep && !twice;
  };
  Json json = Json::parse(text, look, false);
  if (twice) return fail("the manifest has a key twice");
  if (deep) return fail("the manifest is nested too deeply");
  if (json.is_discarded() || !json.is_object()) return fail("the manifest is no JSON object");
  return json;
}

Result<PackagedFile> file_from(const Json& object) {
  if (!object.is_object()) return fail("the manifest has a file that is not an object");
  PackagedFile file;
  auto path = text_of(object, "path");
  if (!path) return tl::unexpected(path.error());
  if (auto good = check_path(*path); !good) return tl::unexpected(good.error());
  file.path = *path;
  const auto size = size_of(object, "size");
  if (!size) return tl::unexpected(size.error());
  file.size = *size;
  const auto sha256 = text_of(object, "sha256");
  if (!sha256) return tl::unexpected(sha256.error());
  if (!is_sha256(*sha256)) return fail(fmt::format("the hash of '{}' is none", file.path));
  file.sha256 = *sha256;
  const auto role = text_of(object, "role");
  if (!role) return tl::unexpected(role.error());
  const auto known = parse_role(*role);
  if (!known) {
    return fail(fmt::format("'{}' has a role that is not known", file.path), "",
                "a newer CogRSim may know it");
  }
  file.role = *known;
  if (auto good = check_role(file.path, file.role); !good) return tl::unexpected(good.error());
  return file;
}

Json to_json(const Manifest& manifest) {
  Json out;
  out["format"] = kFormat;
  out["format_version"] = kFormatVersion;
  out["name"] = manifest.package.name;
  out["version"] = manifest.package.version;
  out["description"] = manifest.description;
  out["author"] = manifest.author;
  out["licence"] = manifest.licence;
  out["scene"] = manifest.scene;
  out["created_by"] = manifest.created_by;
  out["identity"] = identity_of(manifest);
  out["files"] = Json::array();
  for (const PackagedFile& file : manifest.files) {
    out["files"].push_back({{"path", file.path},
                            {"size", file.size},
                            {"sha256", file.sha256},
                            {"role", role_name(file.role)}});
  }
  return out;
}

Result<> take_files(const Json& json, const PackageLimits& limits, Manifest& manifest) {
  const auto files = json.find("files");
  if (files == json.end() || !files->is_array()) return fail("the manifest has no list of files");
  if (files->size() > limits.files) {
    return fail(
        fmt::format("the package has {} files, at most {} are taken", files->size(), limits.files));
  }
  PathSet paths;
  if (auto good = paths.add(kManifestName); !good) return good;
  std::uint64_t total = 0;
  int scenes = 0;
  for (const Json& object : *files) {
    auto file = file_from(object);
    if (!file) return tl::unexpected(file.error());
    if (auto good = paths.add(file->path); !good) return good;
    if (file->size > limits.file_bytes) {
      return fail(fmt::format("'{}' has {} bytes, at most {} are taken", file->path, file->size,
                              limits.file_bytes));
    }
    total += file->size;  // at most 4096 files of 1 GiB: no overflow
    if (file->role == Role::scene) {
      ++scenes;
      if (file->path != manifest.scene) return fail("the manifest's scene is another file");
    }
    manifest.files.push_back(std::move(*file));
  }
  if (total > limits.unpacked_bytes) {
    return fail(fmt::format("the package would unpack to {} bytes, at most {} are taken", total,
                            limits.unpacked_bytes));
  }
  if (scenes != 1) return fail("the manifest does not have exactly one scene");
  const bool sorted = std::is_sorted(manifest.files.begin(), manifest.files.end(),
                                     [](const auto& a, const auto& b) { return a.path < b.path; });
  if (!sorted) return fail("the manifest's files are not sorted by path");
  return {};
}

Result<Manifest> manifest_from(const Json& json, const PackageLimits& limits) {
  const auto format = text_of(json, "format");
  if (!format || *format != kFormat) return fail("this is not a manifest of a CogRSim package");
  const auto number = size_of(json, "format_version");
  if (!number) return tl::unexpected(number.error());
  if (*number != kFormatVersion) {
    return fail(fmt::format("the package has format {}, this CogRSim reads format {}", *number,
                            kFormatVersion),
                "", "take a newer CogRSim");
  }
  Manifest manifest;
  struct Text {
    const char* key;
    std::string* to;
    std::size_t bytes;
  };
  for (const Text& text :
       {Text{"name", &manifest.package.name, 64}, Text{"version", &manifest.package.version, 64},
        Text{"description", &manifest.description, 4000}, Text{"author", &manifest.author, 200},
        Text{"licence", &manifest.licence, 200}, Text{"scene", &manifest.scene, 200},
        Text{"created_by", &manifest.created_by, 100}}) {
    auto value = text_of(json, text.key);
    if (!value) return tl::unexpected(value.error());
    if (auto good = check_text(text.key, *value, text.bytes); !good) {
      return tl::unexpected(good.error());
    }
    *text.to = std::move(*value);
  }
  if (auto good = check_name(manifest.package.name); !good) return tl::unexpected(good.error());
  if (auto good = check_version(manifest.package.version); !good) {
    return tl::unexpected(good.error());
  }
  if (auto good = take_files(json, limits, manifest); !good) return tl::unexpected(good.error());
  const auto identity = text_of(json, "identity");
  if (!identity) return tl::unexpected(identity.error());
  if (*identity != identity_of(manifest)) {
    return fail("the manifest's identity is not that of its files");
  }
  return manifest;
}

}  // namespace

std::uint64_t Manifest::unpacked_size() const {
  std::uint64_t total = 0;
  for (const PackagedFile& file : files) total += file.size;
  return total;
}

std::string identity_of(const Manifest& manifest) {
  Sha256 hash;
  for (const PackagedFile& file : manifest.files) {
    hash.feed(
        fmt::format("{} {} {} {}\n", file.sha256, file.size, role_name(file.role), file.path));
  }
  return hash.finish();
}

std::string to_text(const Manifest& manifest) { return to_json(manifest).dump(2) + "\n"; }

Result<Manifest> parse_manifest(const std::string& text, const PackageLimits& limits) {
  auto json = parse_strictly(text);
  if (!json) return tl::unexpected(json.error());
  return manifest_from(*json, limits);
}

std::string to_text(const Entry& entry) {
  Json out = to_json(entry.manifest);
  out["package"] = {{"file", entry.manifest.package.stem() + kPackageEnding},
                    {"size", entry.size},
                    {"sha256", entry.sha256}};
  return out.dump(2) + "\n";
}

Result<Entry> parse_entry(const std::string& text, const PackageName& expected,
                          const PackageLimits& limits) {
  const auto json = parse_strictly(text);
  if (!json) return tl::unexpected(json.error());
  auto manifest = manifest_from(*json, limits);
  if (!manifest) return tl::unexpected(manifest.error());
  if (manifest->package.stem() != expected.stem()) {
    return fail(fmt::format("the entry of {} names {}", expected.stem(), manifest->package.stem()));
  }
  Entry entry;
  entry.manifest = std::move(*manifest);
  const auto package = json->find("package");
  if (package == json->end() || !package->is_object()) return fail("the entry names no package");
  const auto size = size_of(*package, "size");
  if (!size) return tl::unexpected(size.error());
  if (*size > limits.package_bytes) {
    return fail(
        fmt::format("the package has {} bytes, at most {} are taken", *size, limits.package_bytes));
  }
  entry.size = *size;
  const auto sha256 = text_of(*package, "sha256");
  if (!sha256) return tl::unexpected(sha256.error());
  if (!is_sha256(*sha256)) return fail("the hash of the package is none");
  entry.sha256 = *sha256;
  return entry;
}

}  // namespace cogrsim::share
