// The fuzz targets. Each target takes bytes from outside as its part of the program would; it must
// return for any input, and its require() checks must hold.
#pragma once

#include <string>
#include <string_view>

namespace cogrsim::fuzz {

void scene(std::string_view input);       ///< the scene compiler, and its reports
void expression(std::string_view input);  ///< ${…}, lists of values, units, seeds
void signal(std::string_view input);      ///< signals and conditions, parsed and evaluated
void mesh(std::string_view input);        ///< OBJ, STL and heightmaps
void collada(std::string_view input);     ///< COLLADA meshes
void gltf(std::string_view input);        ///< glTF meshes, text and GLB
void urdf(std::string_view input);  ///< models of other formats, imported; with what they load
void xacro(std::string_view input);
void mjcf(std::string_view input);
void sdf(std::string_view input);
void srdf(std::string_view input);       ///< beside a robot of ours
void yaml(std::string_view input);       ///< as xacro files load it
void image(std::string_view input);      ///< PNG and JPEG
void plugin(std::string_view input);     ///< the symbols of a library that is not loaded
void policy(std::string_view input);     ///< networks, cards, and files that become cards
void recording(std::string_view input);  ///< MCAP: opened, and every frame read
void snapshot(std::string_view input);   ///< read, and a run resumed from it
void package(std::string_view input);    ///< an archive, a manifest, a store's entry
void listing(std::string_view input);    ///< what a store answers in XML
void requests(std::string_view input);   ///< a page's messages to the studio, one a line
void http(std::string_view input);       ///< bytes to the studio's server, up to WebSocket frames

/// Ends the program, so that the fuzzer saves the input, unless `holds`.
void require(bool holds, const char* what);

/// A file in memory with these bytes, that has a path as long as the object lives.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const;

 private:
  int descriptor_;
};

/// A folder of this process, removed at its end: for the files that an input creates.
const std::string& scratch_folder();

}  // namespace cogrsim::fuzz
