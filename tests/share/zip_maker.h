// Writes zip files as no honest program would.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "manifest.h"

/// One member. The local header and the directory can differ.
struct ZipMember {
  ZipMember(std::string called, std::string holds, std::uint32_t type_and_rights = 0100644)
      : name(std::move(called)), content(std::move(holds)), mode(type_and_rights) {}
  std::string name, content;
  std::uint32_t mode;      ///< Unix type and rights
  std::string local_name;  ///< empty: `name`
  bool deflated = false;
  std::uint16_t flags = 0;
};

/// The bytes of an archive with these members, in order.
std::string make_zip(const std::vector<ZipMember>& members);

/// Content that a manifest can be made for.
struct TestFile {
  std::string path, content;
  cogrsim::share::Role role = cogrsim::share::Role::data;
};

/// A manifest of these files, sorted, with right sizes and hashes; nothing is checked.
cogrsim::share::Manifest manifest_for(std::vector<TestFile> files);
/// The manifest and all of its files as members.
std::vector<ZipMember> members_for(const std::vector<TestFile>& files);
