// glTF 2.0 (Khronos, ISO/IEC 12113), as text with its buffers or as GLB, as one triangle mesh: the meshes of
// the scene, placed by its nodes. The y axis of a glTF points up and becomes z, as in Drake. Animation, skins
// (in the pose in which they are bound), lights and cameras are not read, of materials their base colour.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <filesystem>
#include <list>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "assets/mesh_file.h"
#include "assets/mesh_text.h"
#include "assets/mesh_welder.h"

namespace cogrsim::dsl {

namespace {

namespace fs = std::filesystem;
using GltfJson = nlohmann::json;

// Bounds on what a file can ask for that is not in proportion to its length.
constexpr std::size_t kMostJsonValues = 1'000'000;
constexpr int kMostJsonDepth = 64, kMostNodeDepth = 64;
constexpr std::size_t kMostNodes = 100'000, kMostPrimitives = 1'000'000;
constexpr std::size_t kMostNumbers = 32'000'000;  // of all accessors together

enum ComponentType : std::size_t {
  kInt8 = 5120,
  kUint8 = 5121,
  kInt16 = 5122,
  kUint16 = 5123,
  kUint32 = 5125,
  kFloat32 = 5126
};

const GltfJson* member(const GltfJson& in, const char* key) {
  if (!in.is_object()) return nullptr;
  const auto found = in.find(key);
  return found == in.end() ? nullptr : &*found;
}

/// An index, size or count; `otherwise` where it is not written.
std::size_t whole(const GltfJson& in, const char* key,
                  std::optional<std::size_t> otherwise = std::nullopt) {
  const GltfJson* value = member(in, key);
  if (value == nullptr && otherwise) return *otherwise;
  const double number = value != nullptr && value->is_number() ? value->get<double>() : -1.0;
  if (!(number >= 0.0) || number > 9e15 || number != std::floor(number))
    throw BrokenMesh{
        fmt::format("'{}' is {}", key, value == nullptr ? "missing" : "no number from 0 on")};
  return static_cast<std::size_t>(number);
}

const std::string& word(const GltfJson& in, const char* key) {
  static const std::string kNone;
  const GltfJson* value = member(in, key);
  return value != nullptr && value->is_string() ? value->get_ref<const std::string&>() : kNone;
}

/// So many numbers; empty: not written.
template <std::size_t N>
std::optional<std::array<double, N>> numbers_of(const GltfJson& in, const char* key) {
  const GltfJson* list = member(in, key);
  if (list == nullptr) return std::nullopt;
  std::array<double, N> out{};
  bool good = list->is_array() && list->size() == N;
  for (std::size_t i = 0; good && i < N; ++i) {
    good = (*list)[i].is_number();
    if (good) out[i] = (*list)[i].get<double>();
  }
  if (!good) throw BrokenMesh{fmt::format("'{}' is not {} numbers", key, N)};
  return out;
}

std::size_t size_of(std::size_t type) {
  switch (type) {
    case kInt8:
    case kUint8:
      return 1;
    case kInt16:
    case kUint16:
      return 2;
    case kUint32:
    case kFloat32:
      return 4;
    default:
      throw BrokenMesh{fmt::format("there is no type of components {}", type)};
  }
}

double component(const char* bytes, std::size_t type, bool normalized) {
  const auto scaled = [&](double value, double most) {
    return normalized ? std::max(value / most, -1.0) : value;
  };
  switch (type) {
    case kInt8:
      return scaled(read_little<std::int8_t>(bytes), 127.0);
    case kUint8:
      return scaled(read_little<std::uint8_t>(bytes), 255.0);
    case kInt16:
      return scaled(read_little<std::int16_t>(bytes), 32767.0);
    case kUint16:
      return scaled(read_little<std::uint16_t>(bytes), 65535.0);
    case kUint32:
      return read_little<std::uint32_t>(bytes);
    default:
      return static_cast<double>(read_little<float>(bytes));
  }
}

std::string from_base64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::string out;
  out.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const int six = c >= 'A' && c <= 'Z'   ? c - 'A'
                    : c >= 'a' && c <= 'z' ? c - 'a' + 26
                    : c >= '0' && c <= '9' ? c - '0' + 52
                    : c == '+'             ? 62
                    : c == '/'             ? 63
                                           : -1;
    if (six < 0) throw BrokenMesh{"a buffer is not in Base64"};
    bits = bits << 6 | static_cast<std::uint32_t>(six);
    if ((count += 6) < 8) continue;
    count -= 8;
    out += static_cast<char>(bits >> count & 0xff);
  }
  return out;
}

/// The path that a URI reference means: "%20" is a blank.
std::string path_of_uri(std::string_view uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    if (uri[i] == '%' && i + 2 < uri.size()) {
      const auto [end, error] = std::from_chars(&uri[i] + 1, &uri[i] + 3, value, 16);
      if (error == std::errc() && end == &uri[i] + 3) {
        out += static_cast<char>(value);
        i += 2;
        continue;
      }
    }
    out += uri[i];
  }
  return out;
}

class GltfReader {
 public:
  GltfReader(std::string_view bytes, const std::string& folder, std::size_t max_bytes)
      : bytes_(bytes),
        folder_(folder),
        bytes_left_(max_bytes - std::min(max_bytes, bytes.size())) {}

  LoadedMesh read() {
    parse(json_text());
    check_version();
    Eigen::Affine3d top = Eigen::Affine3d::Identity();
    top.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // y, which is up, becomes z
    top_ = top;
    for (const std::size_t root : roots()) node(root, top, 0);
    auto mesh = welder_.finish();
    if (!mesh) throw BrokenMesh{mesh.error().message};
    out_.mesh = std::move(*mesh);
    if (textured_) out_.mesh.uv = std::move(uv_);
    appearance();
    return std::move(out_);
  }

 private:
  // ---- the file

  /// The JSON of the file; a GLB's binary chunk is kept.
  std::string_view json_text() {
    constexpr std::uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBinary = 0x004e4942;
    if (bytes_.size() < 4 || read_little<std::uint32_t>(bytes_.data()) != kMagic) return bytes_;
    const auto number = [&](std::size_t at) {
      if (at + 4 > bytes_.size()) throw BrokenMesh{"the file is cut short"};
      return std::size_t{read_little<std::uint32_t>(bytes_.data() + at)};
    };
    if (number(4) != 2)
      throw BrokenMesh{fmt::format("is a GLB of version {}; save it as glTF 2.0", number(4))};
    if (number(8) != bytes_.size())
      throw BrokenMesh{
          fmt::format("a GLB of {} bytes by its header, this has {}", number(8), bytes_.size())};
    std::string_view json;
    for (std::size_t at = 12, chunk = 0; at < bytes_.size(); ++chunk) {
      const std::size_t length = number(at), type = number(at + 4);
      at += 8;
      if (length > bytes_.size() - at) throw BrokenMesh{"a chunk is longer than the file"};
      if (chunk == 0 && type != kJson) throw BrokenMesh{"the first chunk of the GLB is no JSON"};
      if (chunk == 0) json = bytes_.substr(at, length);
      if (chunk == 1 && type == kBinary) binary_ = bytes_.substr(at, length);
      at += length;
    }
    return json;
  }

  void parse(std::string_view text) {
    std::size_t values = 0;
    const auto count = [&](int depth, GltfJson::parse_event_t, GltfJson&) {
      if (depth > kMostJsonDepth) throw BrokenMesh{"its values are nested too deep"};
      if (++values > kMostJsonValues)
        throw BrokenMesh{fmt::format("has more than {} values", kMostJsonValues)};
      return true;
    };
    try {
      root_ = GltfJson::parse(text, count);
    } catch (const GltfJson::parse_error& error) {
      throw BrokenMesh{fmt::format("byte {}: is not JSON", error.byte)};
    } catch (const GltfJson::exception&) {
      throw BrokenMesh{"has a number beyond all numbers"};
    }
  }

  void check_version() {
    const GltfJson* asset = member(root_, "asset");
    const std::string version = asset == nullptr ? "" : word(*asset, "version");
    if (version.rfind("2.", 0) != 0)
      throw BrokenMesh{version.empty()
                           ? "is not a glTF file: it has no version"
                           : "is glTF " + dsl::quoted(version) + "; save it as glTF 2.0"};
    const GltfJson* required = member(root_, "extensionsRequired");
    if (required == nullptr || !required->is_array()) return;
    for (const GltfJson& e : *required) {
      const std::string name = e.is_string() ? e.get<std::string>() : "";
      const auto starts = [&](std::string_view with) { return name.rfind(with, 0) == 0; };
      // Of these the triangles are where they are without.
      if (starts("KHR_materials_") || starts("KHR_texture_") || starts("EXT_texture_") ||
          name == "KHR_lights_punctual" || name == "KHR_mesh_quantization")
        continue;
      const bool packed = name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression";
      throw BrokenMesh{packed ? "its triangles are compressed by " + name +
                                    "; save it without compression"
                              : "needs the extension " + dsl::quoted(name) + ", which is not read"};
    }
  }

  const GltfJson& entry(const char* list, std::size_t index) const {
    const GltfJson* entries = member(root_, list);
    if (entries == nullptr || !entries->is_array() || index >= entries->size())
      throw BrokenMesh{fmt::format("there is no {} of '{}'", index, list)};
    return (*entries)[index];
  }

  /// The bytes of a buffer, read once.
  std::string_view buffer(std::size_t index) {
    const auto known = buffers_.find(index);
    if (known != buffers_.end()) return known->second;
    const GltfJson& b = entry("buffers", index);
    const std::string& uri = word(b, "uri");
    std::string_view out;
    if (uri.empty()) {
      if (index != 0 || binary_.data() == nullptr)
        throw BrokenMesh{fmt::format("buffer {} has no data", index)};
      out = binary_;
    } else if (uri.rfind("data:", 0) == 0) {
      const std::size_t comma = uri.find(";base64,");
      if (comma == std::string::npos) throw BrokenMesh{"a buffer is not in Base64"};
      out = held_.emplace_back(from_base64(std::string_view(uri).substr(comma + 8)));
    } else {
      out = held_.emplace_back(file(path_of_uri(uri)));
    }
    const std::size_t length = whole(b, "byteLength");
    if (length > out.size())
      throw BrokenMesh{fmt::format("buffer {} has {} bytes, not {}", index, out.size(), length)};
    return buffers_[index] = out.substr(0, length);
  }

  /// A file of the mesh's folder or a folder below it.
  std::string file(const std::string& name) {
    const fs::path given = name;
    const bool plain = std::none_of(given.begin(), given.end(), [](const fs::path& part) {
      return part.native().front() == '.' && part != ".";
    });
    std::error_code fault;
    const fs::path root = fs::canonical(folder_, fault);
    const fs::path path = fs::weakly_canonical(root / given, fault);
    const fs::path inside = path.lexically_relative(root);
    if (folder_.empty() || given.empty() || given.is_absolute() || !plain || fault ||
        name.find("://") != std::string::npos || inside.empty() || *inside.begin() == "..")
      throw BrokenMesh{"its buffer " + dsl::quoted(name) + " does not lie in its folder"};
    if (!fs::is_regular_file(path, fault))
      throw BrokenMesh{"its buffer " + dsl::quoted(name) + " is not there"};
    auto bytes = read_whole_file(path.string(), bytes_left_);
    if (!bytes) throw BrokenMesh{"its buffer " + dsl::quoted(name) + ": " + bytes.error().message};
    bytes_left_ -= bytes->size();
    out_.files.push_back(path.string());
    return std::move(*bytes);
  }

  // ---- numbers

  /// The part of a buffer that a view shows, `offset` bytes in it on; at least one byte.
  std::string_view view(std::size_t index, std::size_t offset, std::size_t& stride) {
    const GltfJson& v = entry("bufferViews", index);
    const std::string_view all = buffer(whole(v, "buffer"));
    const std::size_t begin = whole(v, "byteOffset", 0), length = whole(v, "byteLength");
    if (begin > all.size() || length > all.size() - begin)
      throw BrokenMesh{fmt::format("view {} ends beyond its buffer", index)};
    if (offset >= length)
      throw BrokenMesh{fmt::format("an accessor begins beyond its view {}", index)};
    stride = whole(v, "byteStride", 0);
    return all.substr(begin + offset, length - offset);
  }

  /// `count` elements of so many components each, written to out[places[i]...], or one after the other.
  void elements(std::size_t from, std::size_t offset, std::size_t type, bool normalized,
                std::size_t width, std::size_t count, const std::vector<double>* places,
                std::vector<double>& out) {
    std::size_t stride = 0;
    const std::string_view bytes = view(from, offset, stride);
    const std::size_t each = size_of(type);
    if (stride == 0) stride = width * each;
    if (width * each > bytes.size() || (bytes.size() - width * each) / stride < count - 1)
      throw BrokenMesh{
          fmt::format("an accessor of {} elements ends beyond its view {}", count, from)};
    for (std::size_t i = 0; i < count; ++i) {
      const double place = places == nullptr ? static_cast<double>(i) : (*places)[i];
      if (!(place < static_cast<double>(out.size() / width)))
        throw BrokenMesh{"a sparse accessor has an index beyond its elements"};
      double* to = &out[static_cast<std::size_t>(place) * width];
      for (std::size_t k = 0; k < width; ++k)
        to[k] = component(&bytes[i * stride + k * each], type, normalized);
    }
  }

  /// All numbers of an accessor, read once. `allowed`: the types of its components.
  const std::vector<double>& numbers(std::size_t index, const char* type,
                                     const std::set<std::size_t>& allowed) {
    const auto [at, is_new] = accessors_.try_emplace({index, type});
    std::vector<double>& out = at->second;
    if (!is_new) return out;
    const GltfJson& a = entry("accessors", index);
    const std::size_t kind = whole(a, "componentType"), count = whole(a, "count");
    if (word(a, "type") != type || allowed.count(kind) == 0)
      throw BrokenMesh{fmt::format("accessor {} is {} of type {}, which is no use here", index,
                                   dsl::quoted(word(a, "type")), kind)};
    const std::size_t width = std::string_view(type) == "SCALAR" ? 1 : type[3] == '3' ? 3 : 2;
    numbers_ += std::min(count, kMostNumbers) * width;
    if (count < 1 || numbers_ > kMostNumbers)
      throw BrokenMesh{count < 1 ? "an accessor has no elements"
                                 : "has more numbers than are read of a mesh"};
    const GltfJson* normalized = member(a, "normalized");
    const bool is_normalized = normalized != nullptr && *normalized == true;
    out.assign(count * width, 0.0);
    if (member(a, "bufferView") != nullptr)
      elements(whole(a, "bufferView"), whole(a, "byteOffset", 0), kind, is_normalized, width, count,
               nullptr, out);
    else if (member(a, "sparse") == nullptr)
      throw BrokenMesh{fmt::format("accessor {} has no data; is the file compressed?", index)};
    if (const GltfJson* sparse = member(a, "sparse")) {
      const std::size_t changed = whole(*sparse, "count");
      const GltfJson *where = member(*sparse, "indices"), *what = member(*sparse, "values");
      if (changed < 1 || changed > count || where == nullptr || what == nullptr)
        throw BrokenMesh{fmt::format("accessor {} is sparse without its values", index)};
      std::vector<double> places(changed);
      elements(whole(*where, "bufferView"), whole(*where, "byteOffset", 0),
               whole(*where, "componentType"), false, 1, changed, nullptr, places);
      for (const double place : places)
        if (!(place >= 0.0)) throw BrokenMesh{"a sparse accessor has a negative index"};
      elements(whole(*what, "bufferView"), whole(*what, "byteOffset", 0), kind, is_normalized,
               width, changed, &places, out);
    }
    return out;
  }

  // ---- nodes

  std::vector<std::size_t> list_of(const GltfJson& in, const char* key) {
    std::vector<std::size_t> out;
    const GltfJson* list = member(in, key);
    if (list == nullptr) return out;
    if (!list->is_array()) throw BrokenMesh{fmt::format("'{}' is no list", key)};
    for (const GltfJson& e : *list) {
      if (!e.is_number_unsigned()) throw BrokenMesh{fmt::format("'{}' has no indices", key)};
      out.push_back(e.get<std::size_t>());
    }
    return out;
  }

  /// The nodes of the scene; of a file without scenes those that are in no other.
  std::vector<std::size_t> roots() {
    if (member(root_, "scenes") != nullptr)
      return list_of(entry("scenes", whole(root_, "scene", 0)), "nodes");
    const GltfJson* nodes = member(root_, "nodes");
    if (nodes == nullptr || !nodes->is_array()) throw BrokenMesh{"has no nodes"};
    std::set<std::size_t> inner;
    for (const GltfJson& n : *nodes)
      for (const std::size_t child : list_of(n, "children")) inner.insert(child);
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < nodes->size(); ++i)
      if (inner.count(i) == 0) out.push_back(i);
    return out;
  }

  static Eigen::Affine3d transform(const GltfJson& n) {
    Eigen::Affine3d X = Eigen::Affine3d::Identity();
    if (const auto m = numbers_of<16>(n, "matrix")) {
      for (int i = 0; i < 12; ++i)
        (i < 9 ? X.linear()(i % 3, i / 3) : X.translation()[i % 3]) =
            (*m)[static_cast<std::size_t>(i / 3 * 4 + i % 3)];
      if ((*m)[3] != 0.0 || (*m)[7] != 0.0 || (*m)[11] != 0.0 || (*m)[15] != 1.0)
        throw BrokenMesh{"the last row of a matrix is not 0 0 0 1"};
    }
    if (const auto t = numbers_of<3>(n, "translation"))
      X.translate(Vec3((*t)[0], (*t)[1], (*t)[2]));
    if (const auto r = numbers_of<4>(n, "rotation")) {
      const Quat q((*r)[3], (*r)[0], (*r)[1], (*r)[2]);
      if (!(std::abs(q.norm() - 1.0) < 1e-2)) throw BrokenMesh{"a rotation is no unit quaternion"};
      X.rotate(q.normalized());
    }
    if (const auto s = numbers_of<3>(n, "scale")) X.scale(Vec3((*s)[0], (*s)[1], (*s)[2]));
    return X;
  }

  void node(std::size_t index, const Eigen::Affine3d& parent, int depth) {
    if (depth > kMostNodeDepth)
      throw BrokenMesh{"nodes contain each other in a cycle, or are nested too deep"};
    if (++nodes_ > kMostNodes) throw BrokenMesh{fmt::format("has more than {} nodes", kMostNodes)};
    const GltfJson& n = entry("nodes", index);
    const Eigen::Affine3d X = parent * transform(n);
    if (member(n, "mesh") != nullptr) {
      const GltfJson& m = entry("meshes", whole(n, "mesh"));
      for (const GltfJson* of : {&n, &m})
        if (const GltfJson* weights = member(*of, "weights"))
          for (const GltfJson& w : *weights)
            if (w != 0) throw BrokenMesh{"a mesh is deformed by morph targets, which are not read"};
      const GltfJson* primitives = member(m, "primitives");
      if (primitives == nullptr || !primitives->is_array())
        throw BrokenMesh{"a mesh has no primitives"};
      // A skin places its mesh by its joints alone.
      for (const GltfJson& p : *primitives) primitive(p, member(n, "skin") == nullptr ? X : top_);
    }
    for (const std::size_t child : list_of(n, "children")) node(child, X, depth + 1);
  }

  void primitive(const GltfJson& p, const Eigen::Affine3d& X) {
    if (++primitives_ > kMostPrimitives)
      throw BrokenMesh{fmt::format("has more than {} primitives", kMostPrimitives)};
    const std::size_t mode = whole(p, "mode", 4);
    if (mode > 6) throw BrokenMesh{fmt::format("there are no primitives of mode {}", mode)};
    if (mode < 4) return;  // points and lines
    const GltfJson* attributes = member(p, "attributes");
    if (attributes == nullptr) throw BrokenMesh{"a primitive has no attributes"};
    if (member(*attributes, "POSITION") == nullptr) return;  // as the specification has it
    const std::vector<double>& points =
        numbers(whole(*attributes, "POSITION"), "VEC3", {kInt8, kUint8, kInt16, kUint16, kFloat32});
    const std::vector<double>* uv = member(*attributes, "TEXCOORD_0") == nullptr
                                        ? nullptr
                                        : &numbers(whole(*attributes, "TEXCOORD_0"), "VEC2",
                                                   {kInt8, kUint8, kInt16, kUint16, kFloat32});
    if (uv != nullptr && uv->size() / 2 != points.size() / 3)
      throw BrokenMesh{"a primitive has not as many texture coordinates as positions"};
    const std::vector<double>* indices =
        member(p, "indices") == nullptr
            ? nullptr
            : &numbers(whole(p, "indices"), "SCALAR", {kUint8, kUint16, kUint32});
    const std::size_t corners = indices == nullptr ? points.size() / 3 : indices->size();
    if (mode == 4 && corners % 3 != 0)
      throw BrokenMesh{fmt::format("{} corners are not triangles of three", corners)};
    const std::size_t count = mode == 4 ? corners / 3 : std::max<std::size_t>(corners, 2) - 2;
    seen_ += count;
    if (seen_ > kMaxMeshTriangles)
      throw BrokenMesh{fmt::format("more than {} triangles", kMaxMeshTriangles)};
    const bool mirrored = X.linear().determinant() < 0.0;
    const std::size_t before = uv_.size();
    for (std::size_t i = 0; i < count; ++i) {
      std::array<std::size_t, 3> at = mode == 4   ? std::array{3 * i, 3 * i + 1, 3 * i + 2}
                                      : mode == 5 ? std::array{i, i + 1 + i % 2, i + 2 - i % 2}
                                                  : std::array{i + 1, i + 2, std::size_t{0}};
      if (mirrored) std::swap(at[1], at[2]);
      triangle(at, points, uv, indices, X);
    }
    material(p, *attributes, (uv_.size() - before) / 3);
  }

  void triangle(const std::array<std::size_t, 3>& at, const std::vector<double>& points,
                const std::vector<double>* uv, const std::vector<double>* indices,
                const Eigen::Affine3d& X) {
    Vec3 corners[3];
    std::array<std::size_t, 3> of = at;
    for (std::size_t k = 0; k < 3; ++k) {
      if (indices != nullptr) of[k] = static_cast<std::size_t>((*indices)[at[k]]);
      if (of[k] >= points.size() / 3)
        throw BrokenMesh{
            fmt::format("index {} is beyond the {} positions", of[k], points.size() / 3)};
      corners[k] = X * Vec3(points[3 * of[k]], points[3 * of[k] + 1], points[3 * of[k] + 2]);
      if (!corners[k].allFinite()) throw BrokenMesh{"has a corner that is not finite"};
    }
    const auto kept = welder_.add(corners);
    if (!kept) throw BrokenMesh{kept.error().message};
    if (!*kept) return;
    for (const std::size_t k : of)  // v of a glTF runs down the picture
      uv_.emplace_back(uv == nullptr ? 0.0 : (*uv)[2 * k],
                       uv == nullptr ? 0.0 : 1.0 - (*uv)[2 * k + 1]);
    textured_ = textured_ || uv != nullptr;
  }

  // ---- appearance

  void material(const GltfJson& p, const GltfJson& attributes, std::size_t triangles) {
    has_corner_colors_ = has_corner_colors_ || member(attributes, "COLOR_0") != nullptr;
    if (member(p, "material") == nullptr) return;
    const GltfJson& m = entry("materials", whole(p, "material"));
    const GltfJson* pbr = member(m, "pbrMetallicRoughness");
    if (pbr == nullptr) return;
    has_pictures_ = has_pictures_ || member(*pbr, "baseColorTexture") != nullptr;
    auto color = numbers_of<4>(*pbr, "baseColorFactor").value_or(std::array{1.0, 1.0, 1.0, 1.0});
    if (word(m, "alphaMode") != "BLEND") color[3] = 1.0;
    colors_[color] += triangles;
  }

  void appearance() {
    std::size_t most = 0;
    for (const auto& [color, triangles] : colors_) {
      if (triangles <= most) continue;
      most = triangles;
      // Factors are proportional to the light, colours of a scene are those of screens (IEC 61966-2-1).
      const auto screen = [&color = color](std::size_t i) {
        const double x = std::clamp(color[i], 0.0, 1.0);
        return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
      };
      out_.color = Color{screen(0), screen(1), screen(2), std::clamp(color[3], 0.0, 1.0)};
    }
    std::string& differs = out_.differs;
    if (colors_.size() > 1)
      differs = fmt::format("has one of its {} colours, that of most triangles", colors_.size());
    if (has_pictures_ || has_corner_colors_)
      differs += fmt::format("{}without its {}", differs.empty() ? "is shown " : ", ",
                             has_pictures_ ? "textures" : "colours of corners");
  }

  std::string_view bytes_, binary_;
  std::string folder_;
  std::size_t bytes_left_;  // that may be read of further files
  GltfJson root_;
  std::list<std::string> held_;
  std::map<std::size_t, std::string_view> buffers_;
  std::map<std::pair<std::size_t, std::string>, std::vector<double>> accessors_;
  std::size_t numbers_ = 0, nodes_ = 0, primitives_ = 0, seen_ = 0;
  Eigen::Affine3d top_;
  MeshWelder welder_;
  std::vector<Eigen::Vector2d> uv_;
  std::map<std::array<double, 4>, std::size_t> colors_;  // triangles of each
  bool textured_ = false, has_pictures_ = false, has_corner_colors_ = false;
  LoadedMesh out_;
};

}  // namespace

Result<LoadedMesh> parse_gltf(std::string_view bytes, const std::string& folder,
                              std::size_t max_bytes) {
  try {
    return GltfReader(bytes, folder, max_bytes).read();
  } catch (const BrokenMesh& broken) {
    return fail(broken.message);
  }
}

}  // namespace cogrsim::dsl
