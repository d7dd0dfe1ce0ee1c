// A run in one page: its contents, and that names in it stay text.
#include <sys/wait.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include <zlib.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../support/temporary_folder.h"
#include "bundle_html.h"
#include "compare/report_pictures.h"
#include "page.h"
#include "payload.h"

namespace {

using namespace cogrsim::studio;
namespace fs = std::filesystem;
using Catch::Matchers::Contains;

using Folder = cogrsim::test::TemporaryFolder;

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string quoted(const std::string& argument) {
  std::string out = "'";
  for (const char c : argument) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

struct Ran {
  int status = -1;
  std::string output;
};

Ran shell(const std::string& command) {
  Ran ran;
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  char block[4096];
  for (std::size_t n = 0; (n = std::fread(block, 1, sizeof block, pipe)) > 0;) {
    ran.output.append(block, n);
  }
  const int status = pclose(pipe);
  ran.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return ran;
}

/// `cogrsim bundle` with these arguments; output is both streams.
Ran bundle(const std::vector<std::string>& arguments) {
  std::string command = quoted(COGRSIM_PROGRAM) + " bundle";
  for (const std::string& argument : arguments) command += " " + quoted(argument);
  return shell(command + " 2>&1");
}

std::string from_base64(const std::string& letters) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0;
  int count = 0;
  for (const char c : letters) {
    if (c == '=') break;
    const auto value = digits.find(c);
    if (value == std::string::npos) FAIL("no letter of base64: " << c);
    bits = bits << 6 | static_cast<unsigned>(value);
    count += 6;
    if (count >= 8) {
      count -= 8;
      out += static_cast<char>(bits >> count & 0xFF);
    }
  }
  return out;
}

std::string gunzip(const std::string& bytes) {
  z_stream stream{};
  REQUIRE(inflateInit2(&stream, 16 + MAX_WBITS) == Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string out, block(1u << 16, '\0');
  int status = Z_OK;
  while (status == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    status = inflate(&stream, Z_NO_FLUSH);
    out.append(block, 0, block.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  REQUIRE(status == Z_STREAM_END);
  return out;
}

std::string between(const std::string& text, const std::string& from, const std::string& to) {
  const auto begin = text.find(from);
  REQUIRE(begin != std::string::npos);
  const auto end = text.find(to, begin + from.size());
  REQUIRE(end != std::string::npos);
  return text.substr(begin + from.size(), end - begin - from.size());
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// The data of a page, read as payload.h says.
struct Data {
  explicit Data(const std::string& page) {
    const std::string all = gunzip(from_base64(between(page, "id=\"cg-data\">", "</script>")));
    std::uint32_t length = 0;
    REQUIRE(all.size() > sizeof length);
    std::memcpy(&length, all.data(), sizeof length);
    head = Json::parse(all.substr(4, length));
    blocks = all.substr((4 + length + 7) / 8 * 8);
  }
  std::vector<double> doubles(const Json& block) const {
    std::vector<double> out(block["bytes"].get<std::size_t>() / 8);
    std::memcpy(out.data(), blocks.data() + block["at"].get<std::size_t>(), 8 * out.size());
    return out;
  }
  /// Column by column.
  std::vector<float> columns(const Json& block, std::size_t rows) const {
    const std::size_t n = block["bytes"].get<std::size_t>() / 4;
    const char* bytes = blocks.data() + block["at"].get<std::size_t>();
    std::vector<float> out(n);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t change = 0;
      for (std::size_t plane = 0; plane < 4; ++plane) {
        change |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[plane * n + i]))
                  << 8 * plane;
      }
      bits = i % rows == 0 ? change : bits + change;
      std::memcpy(&out[i], &bits, sizeof bits);
    }
    return out;
  }

  Json head;
  std::string blocks;
};

constexpr const char* kFalling = R"(<?xml version="1.0" encoding="UTF-8"?>
<scene name="falling &amp; free" version="1">
  <physics backend="bullet" step="1 ms" duration="1 s" gravity="0 0 -9.81"/>
  <box name="brick" size="10 10 10 cm" mass="1 kg" xyz="0 0 100"/>
  <plot name="fall" kind="curve"><series y="brick.z"/></plot>
</scene>
)";

}  // namespace

TEST_CASE("program and bundles carry the notices of every package in them", "[studio][bundle]") {
  const PageFile* file = find_page_file("/notices.txt");
  REQUIRE(file != nullptr);
  const std::string notices = inflated(*file);
  const Json packages = Json::parse(read(COGRSIM_SOURCE_DIR "/apps/studio/web/package.json"));
  for (const auto& [name, version] : packages["dependencies"].items()) {
    const auto at = notices.find("\n" + name + " " + version.get<std::string>() + " (");
    INFO(name);
    REQUIRE(at != std::string::npos);
    CHECK_THAT(notices.substr(at, notices.find("\n----", at) - at), Contains("Copyright"));
  }
  CHECK_THAT(notices, Contains("three.js authors") && Contains("PhosphorJS") &&
                          Contains("Marijn") && Contains("Plotly"));
  CHECK_THAT(bundle_html("empty", ""), Contains(notices));
  // Comments in the sources of packages are not in it either.
  CHECK_THAT(inflated(*find_page_file("/bundle/viewer.js")), Contains("@license"));
}

TEST_CASE("a bundle holds scene and frames and curves and text", "[studio][bundle]") {
  const Folder folder;
  const std::string scene = folder.write("fall.scene.xml", kFalling), out = folder / "x.html";
  const Ran ran = bundle({scene, "-o", out});
  INFO(ran.output);
  REQUIRE(ran.status == 0);
  CHECK_THAT(ran.output, Contains("61 frames from 0 s to 1 s"));
  const std::string page = read(out);
  CHECK(is_bundle(out));
  CHECK_THAT(page, Contains("<title>falling &amp; free</title>"));
  const Data data(page);
  const Json& head = data.head;
  CHECK(head["document"]["text"] == kFalling);
  CHECK(head["ending"] == "completed");
  CHECK(head["state_hash"].get<std::string>().size() == 16);

  // Sixty a second, as a display shows them: each the first step at or after its time.
  const std::vector<double> times = data.doubles(head["time"]);
  REQUIRE(times.size() == 61);
  for (std::size_t k = 0; k < times.size(); ++k) {
    CHECK(times[k] >= static_cast<double>(k) / 60.0 - 1e-9);
    CHECK(times[k] < static_cast<double>(k) / 60.0 + 1e-3);
  }

  REQUIRE(head["parts"].size() == 1);
  const Json& part = head["parts"][0];
  REQUIRE(part["bodies"] == 1);
  const std::vector<float> poses = data.columns(part["poses"], times.size());
  REQUIRE(poses.size() == 7 * times.size());
  for (std::size_t k = 0; k < times.size(); ++k) {
    // semi-implicit Euler errs by g t dt / 2; a float at 100 m by 4e-6 m
    const double t = times[k];
    const double z = static_cast<double>(poses[2 * times.size() + k]);
    CHECK(std::fabs(z - (100.0 - 0.5 * 9.81 * t * t)) < 0.5 * 9.81 * t * 1e-3 + 1e-5);
  }

  // Its path has every step, between frames too; a straight line in space, not in time.
  REQUIRE(head["paths"].size() == 1);
  CHECK(head["paths"][0]["body"] == "brick");
  const std::vector<double> when = data.doubles(head["paths"][0]["times"]);
  CHECK(when.size() > times.size());
  CHECK(when.back() == times.back());
  const std::vector<float> where = data.columns(head["paths"][0]["points"], when.size());
  REQUIRE(where.size() == 3 * when.size());
  for (std::size_t k = 0; k < when.size(); ++k) {
    const double t = when[k], z = static_cast<double>(where[2 * when.size() + k]);
    CHECK(std::fabs(z - (100.0 - 0.5 * 9.81 * t * t)) < 0.5 * 9.81 * t * 1e-3 + 1e-5);
  }

  // What can be had from poses is not there twice; its speed is g t.
  std::vector<std::string> names;
  for (const Json& signal : part["signals"]) names.push_back(signal["name"]);
  CHECK(std::find(names.begin(), names.end(), "brick.z") == names.end());
  const auto speed = std::find(names.begin(), names.end(), "brick.speed");
  REQUIRE(speed != names.end());
  const std::vector<float> values = data.columns(part["values"], times.size());
  REQUIRE(values.size() == names.size() * times.size());
  const auto at = static_cast<std::size_t>(speed - names.begin()) * times.size();
  CHECK(std::fabs(static_cast<double>(values[at + 60]) - 9.81) < 1e-5);

  // The scene's own figure has every step.
  REQUIRE(head["figures"].contains("fall"));
  CHECK(data.doubles(head["figures"]["fall"]["series"][0]["x"]).size() == 1001);

  // The brick of the model is the one of the text.
  const int element = head["scenes"][0]["bodies"][0]["element"];
  REQUIRE(element > 0);
  CHECK(head["elements"][element]["name"] == "brick");
}

TEST_CASE("a bundle's page runs its own scripts and sends no request", "[studio][bundle]") {
  const Folder folder;
  const std::string out = folder / "x.html";
  REQUIRE(bundle({folder.write("fall.scene.xml", kFalling), "-d", "0.1", "-o", out}).status == 0);
  const std::string page = read(out);
  const std::string policy = between(page, "Content-Security-Policy\" content=\"", "\"");
  for (const char* rule : {"default-src 'none'", "connect-src 'none'", "base-uri 'none'",
                           "form-action 'none'", "img-src data: blob:"}) {
    CHECK_THAT(policy, Contains(rule));
  }
  const std::string scripts = between(policy, "script-src ", ";");
  CHECK(count(scripts, "'sha256-") == 2);
  CHECK_THAT(scripts, !Contains("unsafe"));
  CHECK_THAT(scripts, !Contains("self"));
  // By an independent implementation.
  const auto hash_of = [&](const std::string& script) {
    const std::string file = folder.write("script", script);
    const std::string hex = shell("sha256sum < " + quoted(file)).output.substr(0, 64);
    std::string bytes;
    for (std::size_t i = 0; i < 64; i += 2) {
      bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
    }
    return "'sha256-" + cogrsim::cli::base64(bytes) + "'";
  };
  CHECK_THAT(scripts, Contains(hash_of(between(page, "<script>", "</script>"))));
  const std::string viewer = gunzip(from_base64(between(page, "id=\"cg-viewer\">", "</script>")));
  CHECK_THAT(scripts, Contains(hash_of(viewer)));
  CHECK(count(page, "src=") == 0);
  CHECK(count(page, "http://") + count(page, "https://") == 0);
}

TEST_CASE("hostile names are text in a bundle", "[studio][bundle]") {
  const Folder folder;
  const std::string evil = "</script></title><img src=x onerror=alert(1)>";
  const std::string escaped = "&lt;/script>&lt;/title>&lt;img src=x onerror=alert(1)>";
  const std::string text = "<scene name=\"" + escaped + "\" version=\"1\">\n  <!-- " + evil +
                           " -->\n"
                           "  <physics backend=\"bullet\" step=\"1 ms\" duration=\"10 ms\"/>\n"
                           "  <plane name=\"floor\"/>\n"
                           "  <plot name=\"p\" kind=\"curve\" title=\"" +
                           escaped + "\"><series y=\"energy.total\" label=\"" + escaped +
                           "\"/></plot>\n</scene>\n";
  const std::string scene = folder.write("<img src=x onerror=alert(1)>.scene.xml", text);
  const std::string out = folder / "x.html";
  const Ran ran = bundle({scene, "-o", out});
  INFO(ran.output);
  REQUIRE(ran.status == 0);
  const std::string page = read(out);
  // Two of data, the notices, the loader.
  CHECK(count(page, "</script") == 4);
  CHECK(count(page, "<script") == 4);
  CHECK(count(page, "<img") == 0);
  CHECK(count(page, "</title") == 1);
  const Json head = Data(page).head;
  CHECK(head["document"]["text"] == text);
  CHECK(head["scenes"][0]["name"] == evil);
  CHECK(head["file"] == "<img src=x onerror=alert(1)>.scene.xml");
  CHECK(head["figures"]["p"]["title"] == evil);
}

TEST_CASE("a run that fails is bundled as far as it came", "[studio][bundle]") {
  const Folder folder;
  // 100 km/s, beyond which a body counts as lost, after a tenth of a second.
  const std::string scene = folder.write("lost.scene.xml", R"(<scene name="lost" version="1">
  <physics backend="bullet" step="1 ms" duration="1 s" gravity="0 0 -1000000"/>
  <box name="brick" size="1 1 1 m" mass="1 kg"/>
</scene>
)");
  const std::string out = folder / "x.html";
  const Ran ran = bundle({scene, "-o", out});
  CHECK(ran.status == 1);
  const Data data(read(out));
  CHECK_THAT(data.head["ending"].get<std::string>(), Contains("diverged"));
  const std::vector<double> times = data.doubles(data.head["time"]);
  REQUIRE(times.size() > 2);
  CHECK(std::fabs(times.back() - 0.1) < 0.01);
  REQUIRE_FALSE(data.head["messages"].empty());
}

TEST_CASE("only bundles are replaced without --force", "[studio][bundle]") {
  const Folder folder;
  const std::string scene = folder.write("fall.scene.xml", kFalling);
  const std::string letter = folder.write("letter.html", "<p>dear all</p>");
  const Ran refused = bundle({scene, "-d", "0.1", "-o", letter});
  CHECK(refused.status == 1);
  CHECK_THAT(refused.output, Contains("--overwrite"));
  CHECK(read(letter) == "<p>dear all</p>");
  CHECK(bundle({scene, "-d", "0.1", "-o", letter, "--force"}).status == 0);
  CHECK(is_bundle(letter));
  const Ran nothing = bundle({folder / "nothing.scene.xml", "-o", letter});
  CHECK(nothing.status == 1);
  CHECK_THAT(nothing.output, Contains("there is no file"));
  const Ran again = bundle({scene, "-d", "0.2", "-o", letter});
  CHECK(again.status == 0);
  CHECK_THAT(again.output, Contains("to 0.2 s"));
}

TEST_CASE("a long run is thinned to the size asked for and says so", "[studio][bundle]") {
  const Folder folder;
  const std::string out = folder / "x.html";
  const Ran ran = bundle({folder.write("fall.scene.xml", kFalling), "-d", "20 s", "--every", "0",
                          "--size", "1", "-o", out});
  REQUIRE(ran.status == 0);
  CHECK_THAT(ran.output, Contains("left out: frames between"));
  const Data data(read(out));
  const std::vector<double> times = data.doubles(data.head["time"]);
  // A frame takes 28 bytes for the pose and some for curves: 20 001 of them are beyond 1 MB.
  CHECK(times.size() * 28 < (1u << 20));
  CHECK(times.size() > 1000);
  CHECK(std::fabs(times.back() - 20.0) < 1e-6);
  const double every = times[1] - times[0];
  for (std::size_t k = 1; k + 1 < times.size(); ++k) {
    CHECK(std::fabs(times[k] - times[k - 1] - every) < 1e-6);
  }
}

TEST_CASE("a recording is bundled with its scene's text", "[studio][bundle]") {
  const Folder folder;
  const std::string scene = folder.write("fall.scene.xml", kFalling), run = folder / "fall.mcap";
  REQUIRE(shell(quoted(COGRSIM_PROGRAM) + " run " + quoted(scene) + " --record " + quoted(run) +
                " > /dev/null 2>&1")
              .status == 0);
  const std::string out = folder / "x.html";
  const Ran ran = bundle({run, "-o", out});
  INFO(ran.output);
  REQUIRE(ran.status == 0);
  const Json head = Data(read(out)).head;
  CHECK(head["document"]["text"] == kFalling);
  const int element = head["scenes"][0]["bodies"][0]["element"];
  REQUIRE(element > 0);
  CHECK(head["elements"][element]["name"] == "brick");
  CHECK(bundle({run, "--backend", "bullet", "-o", out}).status == 2);
}

TEST_CASE("numbers in columns come back bit for bit", "[studio][bundle]") {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> rows = {1.0F,  -0.0F, 1.5F,  inf,  -2.5F, 1e-42F,
                                   3e38F, -inf,  0.25F, 1.0F, 0.0F,  -3e38F};
  for (const std::size_t columns : {1u, 2u, 3u, 12u}) {
    const std::string packed = packed_columns(rows, columns);
    const std::size_t n = rows.size(), height = n / columns;
    REQUIRE(packed.size() == 4 * n);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t change = 0, expected = 0;
      for (std::size_t plane = 0; plane < 4; ++plane) {
        change |= static_cast<std::uint32_t>(static_cast<unsigned char>(packed[plane * n + i]))
                  << 8 * plane;
      }
      bits = i % height == 0 ? change : bits + change;
      std::memcpy(&expected, &rows[i % height * columns + i / height], sizeof expected);
      CHECK(bits == expected);
    }
  }
  CHECK(packed_columns({}, 0).empty());
  CHECK(cogrsim::cli::base64("") == "");
  CHECK(cogrsim::cli::base64("f") == "Zg==");
  CHECK(cogrsim::cli::base64("fo") == "Zm8=");
  CHECK(cogrsim::cli::base64("foo") == "Zm9v");
}
