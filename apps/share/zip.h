// Packages as files: written so that equal content gives an equal file, read as hostile input.
#pragma once

#include <string>

#include "cogrsim/core/result.h"
#include "manifest.h"

namespace cogrsim::share {

/// Writes a package: the manifest first, then the files by path, all with the same time, owner and
/// rights. Sizes and hashes of `manifest` must be right.
/// Errors: a file below `folder` cannot be read, or changed meanwhile; `path` cannot be written.
Result<> write_package(const Manifest& manifest, const std::string& folder,
                       const std::string& path);

/// Reads a package to its end and checks all that docs/guide/sharing.md lists. With `folder`, which
/// must be there and be empty, the files are written into it meanwhile, manifest.json among them,
/// without the right to be executed. After an error the content of `folder` is to be removed.
Result<Manifest> read_package(const std::string& path, const std::string& folder = {},
                              const PackageLimits& limits = {});

}  // namespace cogrsim::share
