#include "cogrsim/core/image.h"
#include "../support/temporary_folder.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

#include "cogrsim/core/output_file.h"
#include "cogrsim/core/random.h"

using namespace cogrsim;
namespace fs = std::filesystem;

namespace {

Image pattern(int width, int height, int channels) {
  Image image;
  image.width = width;
  image.height = height;
  image.channels = channels;
  RandomStream random(3, "pattern");
  const auto bytes = static_cast<std::size_t>(width * height * channels);
  for (std::size_t i = 0; i < bytes; ++i)
    image.data.push_back(static_cast<std::uint8_t>(random.next() >> 56));
  return image;
}

/// Smooth, so that JPEG loses little.
Image gradient(int width, int height, int channels) {
  Image image;
  image.width = width;
  image.height = height;
  image.channels = channels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        image.data.push_back(static_cast<std::uint8_t>(40 + 3 * x + 2 * y + 20 * c));
  return image;
}

using Folder = cogrsim::test::TemporaryFolder;

void append32(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xFF);
}

/// CRC-32 of ISO 3309, as PNG's annex D defines it; bit by bit.
std::uint32_t checksum(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

void append_chunk(std::string& out, const std::string& type, const std::string& data) {
  append32(out, static_cast<std::uint32_t>(data.size()));
  out += type + data;
  append32(out, checksum(type + data));
}

/// A PNG of one colour type with the pixels stored, not compressed.
std::string plain_png(std::uint32_t width, std::uint32_t height, char bits, char color_type,
                      const std::string& palette, const std::string& transparency,
                      const std::string& rows) {
  std::string out("\x89PNG\r\n\x1a\n", 8), header;
  append32(header, width);
  append32(header, height);
  header += {bits, color_type, 0, 0, 0};
  append_chunk(out, "IHDR", header);
  if (!palette.empty()) append_chunk(out, "PLTE", palette);
  if (!transparency.empty()) append_chunk(out, "tRNS", transparency);
  std::string zlib("\x78\x01\x01", 3);
  const auto n = static_cast<unsigned>(rows.size());
  zlib += {static_cast<char>(n & 0xFF), static_cast<char>(n >> 8), static_cast<char>(~n & 0xFF),
           static_cast<char>(~n >> 8 & 0xFF)};
  zlib += rows;
  std::uint32_t a = 1, b = 0;  // Adler-32, RFC 1950
  for (const char c : rows) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  append32(zlib, b << 16 | a);
  append_chunk(out, "IDAT", zlib);
  append_chunk(out, "IEND", "");
  return out;
}

}  // namespace

TEST_CASE("PNG keeps every byte", "[image]") {
  const int channels = GENERATE(1, 3, 4);
  const Image image = pattern(17, 9, channels);
  const auto bytes = encode_png(image);
  REQUIRE(bytes);
  const auto back = decode_image(*bytes);
  REQUIRE(back);
  CHECK(back->width == 17);
  CHECK(back->height == 9);
  CHECK(back->channels == channels);
  CHECK(back->data == image.data);
}

TEST_CASE("JPEG keeps soft pictures to a few steps and drops alpha", "[image]") {
  const int channels = GENERATE(1, 3, 4);
  const Image image = gradient(24, 16, channels);
  const auto bytes = encode_jpeg(image, 100);
  REQUIRE(bytes);
  const auto back = decode_image(*bytes);
  REQUIRE(back);
  REQUIRE(back->width == 24);
  REQUIRE(back->height == 16);
  REQUIRE(back->channels == (channels == 1 ? 1 : 3));
  int worst = 0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x)
      for (int c = 0; c < back->channels; ++c)
        worst = std::max(worst, std::abs(back->pixel(x, y)[c] - image.pixel(x, y)[c]));
  // Quantisation of a step by 1 in luma and chroma each, times the largest colour factor 1.77, plus
  // chroma at half resolution over a slope of 3 per pixel.
  CHECK(worst <= 6);
}

TEST_CASE("palettes, transparency and sixteen bits become plain pictures", "[image]") {
  SECTION("palette") {
    const std::string palette("\xFF\x00\x00\x00\x80\x00\x01\x02\x03", 9);
    const auto image =
        decode_image(plain_png(3, 1, 8, 3, palette, "", std::string("\x00\x02\x00\x01", 4)));
    REQUIRE(image);
    CHECK(image->channels == 3);
    CHECK(image->data == std::vector<std::uint8_t>{1, 2, 3, 255, 0, 0, 0, 128, 0});
  }
  SECTION("palette with transparency") {
    const std::string palette("\xFF\x00\x00\x00\x80\x00", 6);
    const auto image =
        decode_image(plain_png(2, 1, 8, 3, palette, "\x40", std::string("\x00\x00\x01", 3)));
    REQUIRE(image);
    CHECK(image->channels == 4);
    CHECK(image->data == std::vector<std::uint8_t>{255, 0, 0, 64, 0, 128, 0, 255});
  }
  SECTION("sixteen bits") {
    const auto image =
        decode_image(plain_png(2, 1, 16, 0, "", "", std::string("\x00\x80\x80\xFF\xFF", 5)));
    REQUIRE(image);
    CHECK(image->channels == 1);
    // 0x8080 / 257 = 128 exactly
    CHECK(image->data == std::vector<std::uint8_t>{128, 255});
  }
}

TEST_CASE("sixteen-bit pictures keep every value", "[image]") {
  std::vector<std::uint16_t> values;
  for (int i = 0; i < 6; ++i) values.push_back(static_cast<std::uint16_t>(i * 13107));
  const auto bytes = encode_png16(3, 2, values);
  REQUIRE(bytes);
  // As eight bits they come back as value / 257, exact for these.
  const auto image = decode_image(*bytes);
  REQUIRE(image);
  CHECK(image->data == std::vector<std::uint8_t>{0, 51, 102, 153, 204, 255});
  // One channel of sixteen bits, no gamma that a reader could apply.
  CHECK(bytes->substr(24, 2) == std::string("\x10\x00", 2));
  CHECK(bytes->find("gAMA") == std::string::npos);
}

TEST_CASE("a PNG with any bit wrong or any byte missing is refused", "[image]") {
  const auto whole = encode_png(pattern(4, 3, 4));
  REQUIRE(whole);
  for (std::size_t length = 0; length < whole->size(); ++length) {
    const auto image = decode_image(std::string_view(*whole).substr(0, length));
    REQUIRE_FALSE(image);
    REQUIRE_FALSE(image.error().message.empty());
  }
  for (std::size_t at = 0; at < whole->size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = *whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      INFO("byte " << at << " bit " << bit);
      REQUIRE_FALSE(decode_image(damaged));
    }
  }
}

TEST_CASE("a damaged JPEG never crashes and a cut one is refused", "[image]") {
  const auto whole = encode_jpeg(gradient(16, 12, 3), 50);
  REQUIRE(whole);
  for (std::size_t length = 0; length < whole->size(); ++length) {
    INFO(length << " bytes");
    REQUIRE_FALSE(decode_image(std::string_view(*whole).substr(0, length)));
  }
  // The format has no checksum: a wrong bit may be a picture too. The result is complete.
  int refused = 0;
  for (std::size_t at = 0; at < whole->size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = *whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      const auto image = decode_image(damaged);
      if (!image) {
        ++refused;
        REQUIRE_FALSE(image.error().message.empty());
        continue;
      }
      REQUIRE(image->data.size() ==
              static_cast<std::size_t>(image->width * image->height * image->channels));
    }
  }
  CHECK(refused > 100);
}

TEST_CASE("a file that is not a picture is reported as such", "[image]") {
  CHECK(decode_image("").error().message == "the file is empty");
  CHECK(decode_image("GIF89a...").error().message == "neither a PNG nor a JPEG file");
}

TEST_CASE("pictures above the limit are refused before they take memory", "[image]") {
  // A header alone says 100 000 x 100 000; right checksums.
  const auto image = decode_image(plain_png(100000, 100000, 8, 2, "", "", std::string(10, '\0')));
  REQUIRE_FALSE(image);
  CHECK(image.error().message ==
        "the picture has 100000 x 100000 pixels, at most 64 million are handled");

  auto jpeg = encode_jpeg(gradient(16, 8, 1));
  REQUIRE(jpeg);
  // Frame header: marker, length, precision, then height and width.
  const std::size_t frame = jpeg->find("\xFF\xC0");
  REQUIRE(frame != std::string::npos);
  for (std::size_t i = 5; i < 9; ++i) (*jpeg)[frame + i] = '\xF0';
  const auto large = decode_image(*jpeg);
  REQUIRE_FALSE(large);
  CHECK(large.error().message.find("61680 x 61680") != std::string::npos);
}

TEST_CASE("images that cannot be encoded are refused", "[image]") {
  Image image = pattern(4, 4, 3);
  image.data.pop_back();
  CHECK_FALSE(encode_png(image));
  CHECK_FALSE(encode_jpeg(image));
  image = pattern(4, 4, 2);
  CHECK_FALSE(encode_png(image));
  CHECK_FALSE(encode_png(Image{}));
  CHECK_FALSE(encode_jpeg(pattern(4, 4, 3), 0));
  CHECK_FALSE(encode_jpeg(pattern(4, 4, 3), 101));
  CHECK_FALSE(encode_png16(2, 2, {1, 2, 3}));
  CHECK_FALSE(encode_png16(0, 2, {}));
}

TEST_CASE("pictures are loaded from files with the path in the error", "[image]") {
  const Folder folder;
  const std::string path = (folder.path / "p.png").string();
  REQUIRE(write_output_file(path, OutputKind::png, *encode_png(pattern(5, 4, 3))));
  const auto image = load_image(path);
  REQUIRE(image);
  CHECK(image->data == pattern(5, 4, 3).data);
  CHECK(load_image(folder.path.string()).error().message == "is a folder");
  CHECK(load_image((folder.path / "none.png").string()).error().message ==
        "cannot be opened: No such file or directory");
  std::ofstream(path) << "\x89PNG";
  const auto damaged = load_image(path);
  REQUIRE_FALSE(damaged);
  CHECK(damaged.error().where == path);
}
