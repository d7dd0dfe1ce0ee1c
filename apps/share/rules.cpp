#include "rules.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>

#include <fmt/format.h>

namespace cogrsim::share {
namespace {

constexpr std::size_t kPathBytes = 200, kPartBytes = 100, kDepth = 12;

struct RoleRow {
  Role role;
  const char* name;
  std::vector<std::string_view> endings;
};

const std::vector<RoleRow>& role_table() {
  static const std::vector<RoleRow> table = {
      {Role::scene, "scene", {".xml"}},
      {Role::import, "import", {".xml", ".urdf", ".xacro", ".sdf", ".yaml", ".yml"}},
      {Role::texture, "texture", {".png", ".jpg", ".jpeg"}},
      {Role::mesh, "mesh", {".obj", ".stl", ".dae", ".gltf", ".glb", ".bin"}},
      {Role::heightmap, "heightmap", {".pgm", ".txt", ".csv", ".dat", ".asc"}},
      {Role::data,
       "data",
       {".csv", ".txt", ".dat", ".json", ".yaml", ".yml", ".xml", ".pgm", ".png", ".jpg", ".jpeg"}},
      {Role::source,
       "source",
       {"cmakelists.txt", ".cpp", ".cc", ".cxx", ".h", ".hpp", ".hh", ".cmake"}},
      {Role::recording, "recording", {".mcap"}},
      {Role::document, "document", {".md", "license", "licence", ".txt", ".png", ".jpg", ".jpeg"}},
  };
  return table;
}

const RoleRow& row_of(Role role) {
  const auto& table = role_table();
  const auto row =
      std::find_if(table.begin(), table.end(), [role](const RoleRow& r) { return r.role == role; });
  assert(row != table.end());
  return *row;
}

// Of ASCII alone: packages do not depend on the locale.
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; }

std::string lower(std::string_view text) {
  std::string out;
  for (const char c : text) out += lower(c);
  return out;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_small(char c) { return c >= 'a' && c <= 'z'; }

std::string_view base_of(std::string_view path) {
  const auto slash = path.rfind('/');
  return slash == std::string_view::npos ? path : path.substr(slash + 1);
}

// ".png" of "a/B.PNG"; without a point the whole name in small letters.
std::string ending_of(std::string_view path) {
  const std::string base = lower(base_of(path));
  if (base == "cmakelists.txt") return base;
  const auto point = base.rfind('.');
  return point == std::string::npos || point == 0 ? base : base.substr(point);
}

// Names that open a device instead of a file on some systems, whatever the ending.
bool is_device(std::string_view part) {
  const std::string stem = lower(part.substr(0, part.find('.')));
  for (const char* name : {"con", "prn", "aux", "nul", "conin$", "conout$", "clock$"}) {
    if (stem == name) return true;
  }
  return stem.size() == 4 && is_digit(stem[3]) &&
         (stem.compare(0, 3, "com") == 0 || stem.compare(0, 3, "lpt") == 0);
}

// For messages: unprintable characters become "?".
std::string shown(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 120)) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out;
}

std::vector<unsigned long> numbers_of(std::string_view version) {
  std::vector<unsigned long> numbers(1, 0);
  for (const char c : version) {
    if (c == '.')
      numbers.push_back(0);
    else
      numbers.back() = numbers.back() * 10 + static_cast<unsigned long>(c - '0');
  }
  return numbers;
}

}  // namespace

const char* role_name(Role role) { return row_of(role).name; }

std::optional<Role> parse_role(std::string_view name) {
  for (const RoleRow& row : role_table()) {
    if (name == row.name) return row.role;
  }
  return std::nullopt;
}

Result<> check_path(std::string_view path) {
  const auto refuse = [&](const std::string& why) {
    return fail(fmt::format("'{}' {}", shown(path), why), "",
                "a package holds files below the scene's folder, with plain names");
  };
  if (path.empty()) return refuse("is no name");
  if (path.size() > kPathBytes) return refuse(fmt::format("is longer than {} bytes", kPathBytes));
  for (const char c : path) {
    if (c < 0x20 || c == 0x7f) {
      return refuse("has a control character, or a letter that is not ASCII");
    }
    if (std::string_view("<>:\"|?*\\").find(c) != std::string_view::npos) {
      return refuse(fmt::format("has a '{}', which not every file system can have", c));
    }
  }
  if (path.front() == '/') return refuse("is absolute");
  std::size_t depth = 0;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    if (part.empty()) return refuse("has an empty part");
    if (part == "..") return refuse("leads out of its folder");
    if (part.front() == '.') return refuse("is hidden");
    if (part.front() == '-' || part.front() == '~' || part.front() == ' ') {
      return refuse(fmt::format("has a part that begins with '{}'", part.front()));
    }
    if (part.back() == '.' || part.back() == ' ') {
      return refuse("has a part that ends in a point or a space");
    }
    if (is_device(part)) return refuse("is the name of a device on some systems");
    if (part.size() > kPartBytes) {
      return refuse(fmt::format("has a part longer than {} bytes", kPartBytes));
    }
    if (++depth > kDepth) return refuse(fmt::format("is more than {} folders deep", kDepth));
    begin = end + 1;
  }
  return {};
}

Result<> check_role(std::string_view path, Role role) {
  const RoleRow& row = row_of(role);
  if (std::find(row.endings.begin(), row.endings.end(), ending_of(path)) != row.endings.end()) {
    return {};
  }
  return fail(fmt::format("'{}' cannot be a {}: '{}' is not an allowed file extension", shown(path),
                          row.name, shown(ending_of(path))),
              "", "packages hold text, pictures, meshes and recordings, and no programs");
}

Result<Role> role_of(std::string_view path) {
  for (const Role role : {Role::source, Role::recording, Role::mesh, Role::data, Role::document}) {
    if (check_role(path, role)) return role;
  }
  return fail(fmt::format("'{}' is nothing that packages hold", shown(path)), "",
              "packages hold text, pictures, meshes and recordings, and no programs");
}

Result<> PathSet::add(const std::string& path) {
  const std::string key = lower(path);
  const auto clash = [&](const std::string& other) {
    return fail(other == path ? fmt::format("'{}' is there twice", path)
                              : fmt::format("'{}' and '{}' differ in capitals only, or one is a "
                                            "folder of the other",
                                            other, path));
  };
  if (const auto [known, is_new] = files_.emplace(key, path); !is_new) return clash(known->second);
  if (const auto folder = folders_.find(key); folder != folders_.end()) {
    return clash(folder->second);
  }
  for (auto slash = path.find('/'); slash != std::string::npos; slash = path.find('/', slash + 1)) {
    const std::string folder = path.substr(0, slash), folder_key = key.substr(0, slash);
    if (const auto file = files_.find(folder_key); file != files_.end()) return clash(file->second);
    const auto [known, is_new] = folders_.emplace(folder_key, folder);
    if (!is_new && known->second != folder) return clash(known->second);
  }
  return {};
}

ContentCheck::ContentCheck(std::string_view path) : path_(path), ending_(ending_of(path)) {}

void ContentCheck::feed(std::string_view bytes) {
  if (head_.size() < 16) head_ += bytes.substr(0, 16 - head_.size());
  has_zero_ = has_zero_ || bytes.find('\0') != std::string_view::npos;
}

Result<> ContentCheck::finish() const {
  const auto starts = [&](std::string_view magic) {
    return head_.compare(0, magic.size(), magic) == 0;
  };
  using namespace std::string_view_literals;
  static const std::array<std::pair<std::string_view, const char*>, 11> kPrograms = {{
      {"\x7f"
       "ELF"sv,
       "a program or library (ELF)"},
      {"MZ"sv, "a program or library (PE)"},
      {"\xfe\xed\xfa\xce"sv, "a program or library (Mach-O)"},
      {"\xfe\xed\xfa\xcf"sv, "a program or library (Mach-O)"},
      {"\xce\xfa\xed\xfe"sv, "a program or library (Mach-O)"},
      {"\xcf\xfa\xed\xfe"sv, "a program or library (Mach-O)"},
      {"\xca\xfe\xba\xbe"sv, "a program or library (Mach-O or Java)"},
      {"!<arch>"sv, "a static library"},
      {"\0asm"sv, "a program (WebAssembly)"},
      {"PK\x03\x04"sv, "an archive"},
      {"#!"sv, "a script"},
  }};
  for (const auto& [magic, what] : kPrograms) {
    if (starts(magic)) {
      return fail(fmt::format("'{}' is {}", shown(path_), what), "",
                  "packages carry the sources of controllers, never what is built of them");
    }
  }
  const auto expect = [&](bool good, const char* what) -> Result<> {
    if (good) return {};
    return fail(fmt::format("'{}' is not {}, as its name says", shown(path_), what));
  };
  if (ending_ == ".png") return expect(starts("\x89PNG\r\n\x1a\n"sv), "a PNG picture");
  if (ending_ == ".jpg" || ending_ == ".jpeg")
    return expect(starts("\xff\xd8\xff"sv), "a JPEG picture");
  if (ending_ == ".mcap") return expect(starts("\x89MCAP0\r\n"sv), "a recording (MCAP)");
  if (ending_ == ".pgm") return expect(starts("P2"sv) || starts("P5"sv), "a PGM picture");
  if (ending_ == ".glb") return expect(starts("glTF"sv), "a glTF mesh");
  if (ending_ == ".stl" || ending_ == ".bin") return {};  // binary, an STL also text
  return expect(!has_zero_, "a text");
}

Result<> check_name(std::string_view name) {
  const bool good =
      !name.empty() && name.size() <= 64 && (is_small(name[0]) || is_digit(name[0])) &&
      std::all_of(name.begin(), name.end(),
                  [](char c) { return is_small(c) || is_digit(c) || c == '_' || c == '-'; }) &&
      !is_device(name);
  if (good) return {};
  return fail(fmt::format("'{}' is not a name of a package", shown(name)), "",
              "take small letters, digits, '_' and '-', at most 64, a letter or digit first");
}

std::string to_name(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const char small = lower(c);
    const bool good = is_small(small) || is_digit(small) || small == '_' || small == '-';
    if (!good && (out.empty() || out.back() == '-')) continue;
    out += good ? small : '-';
  }
  while (!out.empty() && (out.back() == '-' || out.size() > 64)) out.pop_back();
  return check_name(out) ? out : "";
}

Result<> check_version(std::string_view version) {
  int numbers = 1, digits = 0;
  bool good = !version.empty(), zero = false;
  for (const char c : version) {
    if (c == '.') {
      good = good && digits > 0;
      ++numbers;
      digits = 0;
      zero = false;
    } else if (is_digit(c)) {
      good = good && !zero;  // no leading zeros: 1.0 and 1.00 would be one version with two names
      zero = digits == 0 && c == '0';
      ++digits;
      good = good && digits <= 9;
    } else {
      good = false;
    }
  }
  if (good && digits > 0 && numbers <= 4) return {};
  return fail(fmt::format("'{}' is not a version", shown(version)), "",
              "write one to four numbers with points between them, such as 1.0.2");
}

bool version_less(std::string_view a, std::string_view b) { return numbers_of(a) < numbers_of(b); }

std::string next_version(std::string_view version) {
  std::vector<unsigned long> numbers = numbers_of(version);
  ++numbers.back();
  return fmt::format("{}", fmt::join(numbers, "."));
}

Result<> check_text(std::string_view what, std::string_view text, std::size_t bytes) {
  if (text.size() > bytes) {
    return fail(fmt::format("the {} is longer than {} bytes", what, bytes));
  }
  for (std::size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    const std::size_t length = c < 0x80   ? 1
                               : c < 0xc2 ? 0
                               : c < 0xe0 ? 2
                               : c < 0xf0 ? 3
                               : c < 0xf5 ? 4
                                          : 0;
    bool good = length > 0 && i + length <= text.size() && !(c < 0x20 && c != '\n') && c != 0x7f;
    for (std::size_t k = 1; good && k < length; ++k) {
      good = (static_cast<unsigned char>(text[i + k]) & 0xc0) == 0x80;
    }
    // U+0080 to U+009F steer some terminals, U+202A to U+202E and U+2066 to U+2069 turn text round.
    if (good && c == 0xc2) good = static_cast<unsigned char>(text[i + 1]) >= 0xa0;
    if (good && c == 0xe2) {
      const auto second = static_cast<unsigned char>(text[i + 1]);
      const auto third = static_cast<unsigned char>(text[i + 2]);
      good = !(second == 0x80 && third >= 0xaa && third <= 0xae) &&
             !(second == 0x81 && third >= 0xa6 && third <= 0xa9);
    }
    if (!good) {
      return fail(fmt::format("the {} has a control character or is not UTF-8", what));
    }
    i += length;
  }
  return {};
}

std::optional<PackageName> parse_stem(std::string_view file, std::string_view ending) {
  if (file.size() <= ending.size() ||
      file.compare(file.size() - ending.size(), ending.size(), ending) != 0) {
    return std::nullopt;
  }
  file.remove_suffix(ending.size());
  const auto dash = file.rfind('-');
  if (dash == std::string_view::npos) return std::nullopt;
  PackageName name{std::string(file.substr(0, dash)), std::string(file.substr(dash + 1))};
  if (!check_name(name.name) || !check_version(name.version)) return std::nullopt;
  return name;
}

}  // namespace cogrsim::share
