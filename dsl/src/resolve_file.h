// Files that a scene names: where they may lie, and how much of them is read.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim::dsl {

/// Where a scene's files may lie. Nothing outside these folders is ever opened on a scene's behalf.
struct FileRoots {
  std::string scene_folder;                  ///< of the scene file; "" is the current folder
  std::vector<std::string> library_folders;  ///< the installed library, in order of search
};

/// Real path of the file `href` that is mentioned in a file of the folder `from_folder`: first
/// beside that file, then below the scene's folder, then below the library folders. Links are
/// followed before the path is judged, so none leads out. Errors: an absolute path, one that
/// leaves the folders, one that is no regular file, or is not there (the places tried are listed).
Result<std::string> resolve_file(const std::string& href, const std::string& from_folder,
                                 const FileRoots& roots);

/// Whole content of a file. Errors: unreadable, or longer than `limit` bytes; no more than that is
/// ever held.
Result<std::string> read_whole_file(const std::string& path, std::size_t limit);

}  // namespace cogrsim::dsl
