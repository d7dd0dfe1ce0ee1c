// The manifest of a package, and its entry in a store.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "rules.h"

namespace cogrsim::share {

inline constexpr const char* kManifestName = "manifest.json";
inline constexpr int kFormatVersion = 1;

struct PackagedFile {
  std::string path;        ///< in the package, "/" between folders
  std::uint64_t size = 0;  ///< [byte]
  std::string sha256;      ///< of its content, 64 hexadecimal digits
  Role role = Role::data;
};

struct Manifest {
  PackageName package;
  std::string description, author, licence;  ///< may be empty
  std::string scene;                         ///< path of the scene, one of `files`
  std::string created_by;                    ///< "CogRSim 0.1.0"
  std::vector<PackagedFile> files;           ///< by path; the manifest itself is not among them

  std::uint64_t unpacked_size() const;
};

/// SHA-256 over a line "SHA256 SIZE ROLE PATH" per file: two packages with the same identity hold
/// the same files, whatever they are called.
std::string identity_of(const Manifest& manifest);

/// JSON; the same manifest gives the same text.
std::string to_text(const Manifest& manifest);
/// Checks everything that can be checked without the files: format, names, paths, roles, sizes
/// within `limits`, that no path is there twice, that the scene is one, the identity.
Result<Manifest> parse_manifest(const std::string& text, const PackageLimits& limits = {});

/// A store's entry for a package: its manifest, and which file it is in. It is put there last, so a
/// package with an entry is complete.
struct Entry {
  Manifest manifest;
  std::uint64_t size = 0;  ///< of the package's file [byte]
  std::string sha256;      ///< of the package's file
};
std::string to_text(const Entry& entry);
/// Errors: as parse_manifest; the entry is not that of `expected`.
Result<Entry> parse_entry(const std::string& text, const PackageName& expected,
                          const PackageLimits& limits = {});

}  // namespace cogrsim::share
