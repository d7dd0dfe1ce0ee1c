// PNG by libpng. The library reports errors with longjmp; the functions that are jumped over must
// therefore not hold objects with destructors.
#include <png.h>
#include <zlib.h>

#include <csetjmp>
#include <cstring>

#include "image_codecs.h"

namespace cogrsim {
namespace {

std::uint32_t big_endian(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

// libpng accepts damage in ancillary chunks such as transparency. Each chunk has a checksum; if all
// of them are correct, the file is not damaged.
Result<> check_chunks(std::string_view bytes) {
  constexpr std::string_view signature("\x89PNG\r\n\x1a\n", 8);
  if (bytes.substr(0, 8) != signature) return fail("the PNG file is damaged in its first bytes");
  std::size_t at = 8;
  while (bytes.size() - at >= 12) {
    const std::size_t length = big_endian(bytes, at);
    if (length > bytes.size() - at - 12) break;
    const std::string_view type = bytes.substr(at + 4, 4);
    const auto* const covered = reinterpret_cast<const Bytef*>(bytes.data() + at + 4);
    const uLong sum = crc32(crc32(0, nullptr, 0), covered, static_cast<uInt>(length + 4));
    if (sum != big_endian(bytes, at + 8 + length))
      return fail("the PNG file is damaged: wrong checksum in the part at byte " +
                  std::to_string(at));
    if (type == "IEND") return {};
    at += 12 + length;
  }
  return fail("the PNG file is cut off after " + std::to_string(bytes.size()) + " bytes");
}

struct PngJob {
  int width, height, color_type, bit_depth;
  const std::uint8_t* data;
  std::size_t row_bytes;
  std::string* out;
  char message[128];
};

void keep_error(png_structp png, png_const_charp text) {
  auto* const job = static_cast<PngJob*>(png_get_error_ptr(png));
  std::strncpy(job->message, text, sizeof job->message - 1);
  longjmp(png_jmpbuf(png), 1);
}

void no_warning(png_structp, png_const_charp) {}

void append_bytes(png_structp png, png_bytep data, size_t length) {
  auto* const out = static_cast<std::string*>(png_get_io_ptr(png));
  bool good = true;
  try {
    out->append(reinterpret_cast<const char*>(data), length);
  } catch (...) {
    good = false;  // an exception must not propagate through C code
  }
  if (!good) png_error(png, "out of memory");
}

void no_flush(png_structp) {}

bool write_png(PngJob& job) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &job, keep_error, no_warning);
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, job.out, append_bytes, no_flush);
  // The library's own limit is one million per side.
  png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_set_IHDR(png, info, static_cast<png_uint_32>(job.width), static_cast<png_uint_32>(job.height),
               job.bit_depth, job.color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  // Images are written while a simulation runs: a fast level gives most of the compression.
  png_set_compression_level(png, 3);
  png_write_info(png, info);
  if (job.bit_depth == 16) png_set_swap(png);  // files have the high byte first
  for (int row = 0; row < job.height; ++row)
    png_write_row(png, job.data + static_cast<std::size_t>(row) * job.row_bytes);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

Result<std::string> encode(PngJob job) {
  std::string out;
  job.out = &out;
  if (!write_png(job)) return fail(std::string("the picture cannot be encoded: ") + job.message);
  return out;
}

}  // namespace

Result<Image> decode_png(std::string_view bytes) {
  if (auto good = check_chunks(bytes); !good) return tl::unexpected(good.error());
  // The simplified interface of the library catches its own jumps and converts palettes,
  // sixteen-bit values and other colour spaces to sRGB.
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto damaged = [&] {
    const std::string message = png.message;
    png_image_free(&png);
    return fail("the PNG file is damaged: " + message);
  };
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) return damaged();
  if (auto good = check_image_size(png.width, png.height); !good) {
    png_image_free(&png);
    return tl::unexpected(good.error());
  }
  // Sixteen-bit values without a stated colour space are sRGB, as eight-bit values are.
  png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  Image image;
  const bool alpha = (png.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  const bool color = (png.format & PNG_FORMAT_FLAG_COLOR) != 0;
  image.channels = alpha ? 4 : color ? 3 : 1;
  png.format = alpha ? PNG_FORMAT_RGBA : color ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  image.width = static_cast<int>(png.width);
  image.height = static_cast<int>(png.height);
  image.data.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                    static_cast<std::size_t>(image.channels));
  if (png_image_finish_read(&png, nullptr, image.data.data(), 0, nullptr) == 0) return damaged();
  png_image_free(&png);
  return image;
}

Result<std::string> encode_png(const Image& image) {
  if (auto good = check_image(image); !good) return tl::unexpected(good.error());
  PngJob job{};
  job.width = image.width;
  job.height = image.height;
  job.color_type = image.channels == 1   ? PNG_COLOR_TYPE_GRAY
                   : image.channels == 3 ? PNG_COLOR_TYPE_RGB
                                         : PNG_COLOR_TYPE_RGB_ALPHA;
  job.bit_depth = 8;
  job.data = image.data.data();
  job.row_bytes = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
  return encode(job);
}

Result<std::string> encode_png16(int width, int height, const std::vector<std::uint16_t>& data) {
  if (auto good = check_image_size(width, height); !good) return tl::unexpected(good.error());
  const std::size_t wanted = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (data.size() != wanted)
    return fail("a picture of this size has " + std::to_string(wanted) + " values, not " +
                std::to_string(data.size()));
  PngJob job{};
  job.width = width;
  job.height = height;
  job.color_type = PNG_COLOR_TYPE_GRAY;
  job.bit_depth = 16;
  job.data = reinterpret_cast<const std::uint8_t*>(data.data());
  job.row_bytes = 2 * static_cast<std::size_t>(width);
  return encode(job);
}

}  // namespace cogrsim
