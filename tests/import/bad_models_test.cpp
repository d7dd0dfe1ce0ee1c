// Every model in bad/ with its expected diagnostics, no more and no fewer; and every code has one.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <vector>

#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;
namespace fs = std::filesystem;

namespace {

std::vector<fs::path> bad_models() {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(COGRSIM_BAD_MODELS))
    if (entry.path().extension() != ".expected") out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("bad models give the expected diagnostics", "[bad]") {
  const bool renew = std::getenv("COGRSIM_RENEW_EXPECTED") != nullptr;
  for (const fs::path& path : bad_models()) {
    const std::string name = path.filename().string();
    INFO(name);
    const dsl::ImportResult result = dsl::import_model(path.string());
    CHECK(result.scene.empty());
    const std::string text = dsl::to_text(result.diagnostics);
    fs::path expected = path;
    expected.replace_extension(".expected");
    if (renew) std::ofstream(expected, std::ios::binary) << text;
    CHECK(text == read(expected));
    REQUIRE_FALSE(result.diagnostics.empty());
    CHECK(result.diagnostics.front().code == name.substr(0, 6));
  }
}

TEST_CASE("every code of imports has a bad model", "[bad]") {
  std::set<std::string> shown;
  for (const fs::path& path : bad_models()) shown.insert(path.filename().string().substr(0, 6));
  std::size_t codes = 0;
  for (const std::string& code : dsl::diagnostic_codes()) {
    if (code.compare(0, 4, "CG14") != 0) continue;
    INFO(code);
    CHECK(shown.count(code) == 1);
    ++codes;
  }
  CHECK(codes == shown.size());
}
