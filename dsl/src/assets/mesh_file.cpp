#include "assets/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "assets/mesh_text.h"
#include "syntax/text.h"

namespace cogrsim::dsl {

Result<std::string> read_whole_file(const std::string& path, std::size_t limit) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail("the file cannot be read");
  std::string text;
  std::string block(std::size_t{1} << 16, '\0');
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block, 0, static_cast<std::size_t>(in.gcount()));
    if (text.size() > limit)
      return fail("the file is longer than the " + std::to_string(limit) +
                  " bytes that are read of such a file");
  }
  if (in.bad()) return fail("the file cannot be read to its end");
  return text;
}

namespace {

std::string ending(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] != '.') return "";
  return small_letters(path.substr(dot + 1));
}

/// Walks the header of a PGM: numbers between blanks and '#' comments.
class PgmHeader {
 public:
  explicit PgmHeader(std::string_view bytes) : bytes_(bytes) {}

  std::optional<long long> number() {
    skip();
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9') ++at_;
    return to_integer(bytes_.substr(begin, at_ - begin));
  }
  std::size_t at() const { return at_; }

 private:
  void skip() {
    while (at_ < bytes_.size()) {
      if (bytes_[at_] == '#')
        at_ = std::min(bytes_.find('\n', at_), bytes_.size());
      else if (std::isspace(static_cast<unsigned char>(bytes_[at_])) != 0)
        ++at_;
      else
        return;
    }
  }

  std::string_view bytes_;
  std::size_t at_ = 2;  // after "P2" or "P5"
};

Result<> check_samples(std::size_t columns, std::size_t rows) {
  if (columns < 2 || rows < 2)
    return fail("a heightmap needs at least 2 by 2 samples, this has " + std::to_string(columns) +
                " by " + std::to_string(rows));
  if (columns > kMaxHeightSamples / rows)
    return fail("more than " + std::to_string(kMaxHeightSamples) + " samples");
  return {};
}

// Samples top row first, 0 to 1.
Result<std::vector<double>> parse_pgm(std::string_view bytes, HeightGrid& grid) {
  PgmHeader header(bytes);
  const auto columns = header.number(), rows = header.number(), white = header.number();
  if (!columns || !rows || !white || *white < 1 || *white > 65535)
    return fail("a damaged PGM header: expected width, height and a maximum of 1 to 65535");
  if (*columns > 1'000'000 || *rows > 1'000'000)
    return fail("more than " + std::to_string(kMaxHeightSamples) + " samples");
  if (auto fits =
          check_samples(static_cast<std::size_t>(*columns), static_cast<std::size_t>(*rows));
      !fits)
    return tl::unexpected(fits.error());
  grid.columns = static_cast<int>(*columns);
  grid.rows = static_cast<int>(*rows);
  const auto count = static_cast<std::size_t>(*columns * *rows);
  std::vector<double> samples(count);
  const double scale = 1.0 / static_cast<double>(*white);
  if (bytes[1] == '2') {
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = header.number();
      if (!value || *value > *white)
        return fail("sample " + std::to_string(i + 1) + " of " + std::to_string(count) +
                    " is missing or larger than the maximum " + std::to_string(*white));
      samples[i] = static_cast<double>(*value) * scale;
    }
    return samples;
  }
  const std::size_t width = *white > 255 ? 2 : 1;
  const std::size_t begin = header.at() + 1;  // one blank after the maximum
  if (bytes.size() < begin + count * width)
    return fail("the picture is cut short: expected " + std::to_string(count * width) +
                " bytes of samples, found " +
                std::to_string(bytes.size() > begin ? bytes.size() - begin : 0));
  for (std::size_t i = 0; i < count; ++i) {
    unsigned value = 0;  // 16-bit samples come high byte first
    for (std::size_t k = 0; k < width; ++k)
      value = value << 8 | static_cast<unsigned char>(bytes[begin + i * width + k]);
    samples[i] = value * scale;
  }
  return samples;
}

// Samples top row first, unscaled.
Result<std::vector<double>> parse_grid(std::string_view text, HeightGrid& grid) {
  std::vector<double> samples;
  LineReader lines(text);
  std::string_view line;
  std::size_t columns = 0, rows = 0;
  while (lines.next(line)) {
    line = line.substr(0, line.find('#'));
    const std::size_t before = samples.size();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const auto value = to_number(word);
      if (!value)
        return fail("line " + std::to_string(lines.number()) + ": expected a number, found " +
                    quoted(word));
      if (samples.size() >= kMaxHeightSamples)
        return fail("more than " + std::to_string(kMaxHeightSamples) + " samples");
      samples.push_back(*value);
    }
    const std::size_t found = samples.size() - before;
    if (found == 0) continue;
    if (rows > 0 && found != columns)
      return fail("line " + std::to_string(lines.number()) + ": " + std::to_string(found) +
                  " numbers, the lines before have " + std::to_string(columns));
    columns = found;
    ++rows;
  }
  if (auto fits = check_samples(columns, rows); !fits) return tl::unexpected(fits.error());
  grid.columns = static_cast<int>(columns);
  grid.rows = static_cast<int>(rows);
  return samples;
}

}  // namespace

bool is_gltf(const std::string& path) {
  const std::string kind = ending(path);
  return kind == "gltf" || kind == "glb";
}

Result<LoadedMesh> read_mesh(const std::string& path, const std::string& name,
                             std::size_t max_bytes) {
  const std::string kind = ending(path);
  const bool gltf = is_gltf(path);
  if (kind != "obj" && kind != "stl" && kind != "dae" && !gltf)
    return fail("'" + name + "': meshes are read from " + kMeshFormats + " files");
  auto bytes = read_whole_file(path, max_bytes);
  if (!bytes) return fail("'" + name + "': " + bytes.error().message);
  Result<LoadedMesh> loaded;
  if (gltf) {
    loaded = parse_gltf(*bytes, std::filesystem::path(path).parent_path().string(), max_bytes);
  } else {
    auto mesh = kind == "obj"   ? parse_obj(*bytes)
                : kind == "stl" ? parse_stl(*bytes)
                                : parse_collada(*bytes);
    if (mesh)
      loaded->mesh = std::move(*mesh);
    else
      loaded = tl::unexpected(mesh.error());
  }
  if (!loaded) return fail("'" + name + "': " + loaded.error().message);
  loaded->mesh.name = name;
  return loaded;
}

Result<TriangleMesh> load_mesh(const std::string& path, const std::string& name,
                               std::size_t max_bytes) {
  auto loaded = read_mesh(path, name, max_bytes);
  if (!loaded) return tl::unexpected(loaded.error());
  return std::move(loaded->mesh);
}

std::size_t work_beyond(const TriangleMesh& mesh, std::size_t bytes) {
  const std::size_t held = sizeof(Vec3) * mesh.vertices.size() +
                           sizeof(Eigen::Vector3i) * mesh.triangles.size() +
                           sizeof(mesh.uv[0]) * mesh.uv.size();
  const std::size_t paid = 4 * bytes;  // a corner "0 0 0" of a text is four times as long in memory
  return held > paid ? 2 * (held - paid) : 0;
}

std::size_t open_edges(const TriangleMesh& mesh) {
  // Directed edges as numbers; in a closed surface each has its reverse exactly once.
  std::vector<std::uint64_t> edges, reversed;
  edges.reserve(3 * mesh.triangles.size());
  reversed.reserve(3 * mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) {
      const auto a = static_cast<std::uint64_t>(t[i]),
                 b = static_cast<std::uint64_t>(t[(i + 1) % 3]);
      edges.push_back(a << 32 | b);
      reversed.push_back(b << 32 | a);
    }
  std::sort(edges.begin(), edges.end());
  std::sort(reversed.begin(), reversed.end());
  std::size_t open = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool twice = i > 0 && edges[i] == edges[i - 1];  // in one direction
    if (twice || !std::binary_search(reversed.begin(), reversed.end(), edges[i])) ++open;
  }
  return open;
}

Result<HeightGrid> parse_heightmap(std::string_view bytes, double size_x, double size_y,
                                   double height) {
  HeightGrid grid;
  const bool is_picture =
      bytes.size() > 2 && bytes[0] == 'P' && (bytes[1] == '2' || bytes[1] == '5');
  auto samples = is_picture ? parse_pgm(bytes, grid) : parse_grid(bytes, grid);
  if (!samples) return tl::unexpected(samples.error());
  grid.size_x = size_x;
  grid.size_y = size_y;
  // The file's first row is the far one; the model's is the near one.
  const auto columns = static_cast<std::size_t>(grid.columns);
  const auto rows = static_cast<std::size_t>(grid.rows);
  grid.heights.resize(columns * rows);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c)
      grid.heights[(rows - 1 - r) * columns + c] = height * (*samples)[r * columns + c];
  return grid;
}

Result<HeightGrid> load_heightmap(const std::string& path, const std::string& name, double size_x,
                                  double size_y, double height, std::size_t max_bytes) {
  auto bytes = read_whole_file(path, max_bytes);
  if (!bytes) return fail("'" + name + "': " + bytes.error().message);
  auto grid = parse_heightmap(*bytes, size_x, size_y, height);
  if (!grid) return fail("'" + name + "': " + grid.error().message);
  grid->name = name;
  return grid;
}

}  // namespace cogrsim::dsl
