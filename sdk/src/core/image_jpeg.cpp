// JPEG by libjpeg. The library reports errors with longjmp; the functions that are jumped over must
// therefore not hold objects with destructors.
#include <cstddef>
#include <cstdio>
// jpeglib.h needs the two headers above.
#include <jpeglib.h>

#include <csetjmp>
#include <cstdlib>

#include "image_codecs.h"

namespace cogrsim {
namespace {

/// Each scan of a progressive file covers the whole image. Cameras and programs write about ten
/// scans; a file with thousands of tiny scans would take hours to decode.
constexpr int kMaxScans = 200;

struct ErrorManager {
  jpeg_error_mgr base;  // must be first: the library knows only this part
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void leave(j_common_ptr info) {
  auto* const manager = reinterpret_cast<ErrorManager*>(info->err);
  info->err->format_message(info, manager->message);
  longjmp(manager->jump, 1);
}

// After damage the library issues a warning and continues with grey areas; this is an error here.
void warning_is_error(j_common_ptr info, int level) {
  if (level < 0) leave(info);
}

void limit_scans(j_common_ptr info) {
  if (!info->is_decompressor) return;
  if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= kMaxScans) return;
  auto* const manager = reinterpret_cast<ErrorManager*>(info->err);
  std::snprintf(manager->message, sizeof manager->message, "more than %d scans", kMaxScans);
  longjmp(manager->jump, 1);
}

void set_up(ErrorManager& manager) {
  jpeg_std_error(&manager.base);
  manager.base.error_exit = leave;
  manager.base.emit_message = warning_is_error;
}

struct ReadJob {
  const unsigned char* bytes;
  unsigned long size;
  Image* image;
  bool (*make_room)(Image& image, unsigned width, unsigned height, int channels);
  bool fits = true;
  unsigned width = 0, height = 0;
};

bool make_room(Image& image, unsigned width, unsigned height, int channels) {
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  image.channels = channels;
  try {
    image.data.resize(static_cast<std::size_t>(width) * height *
                      static_cast<std::size_t>(channels));
  } catch (...) {
    return false;
  }
  return true;
}

bool read_jpeg(ReadJob& job, ErrorManager& manager) {
  jpeg_decompress_struct info{};
  jpeg_progress_mgr progress{};
  progress.progress_monitor = limit_scans;
  info.err = &manager.base;
  if (setjmp(manager.jump) != 0) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  info.progress = &progress;
  jpeg_mem_src(&info, job.bytes, job.size);
  jpeg_read_header(&info, TRUE);
  job.width = info.image_width;
  job.height = info.image_height;
  if (info.image_width > kMaxImagePixels / info.image_height) {
    job.fits = false;
    jpeg_destroy_decompress(&info);
    return false;
  }
  const bool grey = info.jpeg_color_space == JCS_GRAYSCALE;
  info.out_color_space = grey ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&info);
  if (!job.make_room(*job.image, info.output_width, info.output_height, grey ? 1 : 3)) {
    std::snprintf(manager.message, sizeof manager.message, "out of memory");
    jpeg_destroy_decompress(&info);
    return false;
  }
  const std::size_t row_bytes =
      static_cast<std::size_t>(info.output_width) * static_cast<std::size_t>(grey ? 1 : 3);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = job.image->data.data() + info.output_scanline * row_bytes;
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  jpeg_destroy_decompress(&info);
  return true;
}

struct WriteJob {
  const Image* image;
  int quality;
  unsigned char* row;  // (width x 3) without alpha; unused otherwise
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
};

bool write_jpeg(WriteJob& job, ErrorManager& manager) {
  const Image& image = *job.image;
  jpeg_compress_struct info{};
  info.err = &manager.base;
  if (setjmp(manager.jump) != 0) {
    jpeg_destroy_compress(&info);
    return false;
  }
  jpeg_create_compress(&info);
  jpeg_mem_dest(&info, &job.bytes, &job.size);
  info.image_width = static_cast<JDIMENSION>(image.width);
  info.image_height = static_cast<JDIMENSION>(image.height);
  info.input_components = image.channels == 1 ? 1 : 3;
  info.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, job.quality, TRUE);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    const std::uint8_t* const source = image.pixel(0, static_cast<int>(info.next_scanline));
    // The library only reads from the rows.
    JSAMPROW row = const_cast<JSAMPROW>(source);
    if (image.channels == 4) {
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 3; ++c) job.row[3 * x + c] = source[4 * x + c];
      row = job.row;
    }
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  return true;
}

}  // namespace

Result<Image> decode_jpeg(std::string_view bytes) {
  Image image;
  ErrorManager manager{};
  set_up(manager);
  ReadJob job{reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), &image,
              make_room};
  if (!read_jpeg(job, manager)) {
    if (!job.fits) return tl::unexpected(check_image_size(job.width, job.height).error());
    return fail(std::string("the JPEG file is damaged or of a rare kind: ") + manager.message, "",
                "open it in a picture editor and save it as PNG");
  }
  return image;
}

Result<std::string> encode_jpeg(const Image& image, int quality) {
  if (auto good = check_image(image); !good) return tl::unexpected(good.error());
  if (quality < 1 || quality > 100)
    return fail("JPEG quality is 1 to 100, not " + std::to_string(quality));
  if (image.width > JPEG_MAX_DIMENSION || image.height > JPEG_MAX_DIMENSION)
    return fail("a JPEG file has at most " + std::to_string(JPEG_MAX_DIMENSION) + " pixels a side",
                "", "write a PNG file");
  std::vector<unsigned char> row(image.channels == 4 ? static_cast<std::size_t>(image.width) * 3
                                                     : 0);
  ErrorManager manager{};
  set_up(manager);
  WriteJob job{&image, quality, row.data()};
  const bool good = write_jpeg(job, manager);
  Result<std::string> out;
  if (good) {
    out = std::string(reinterpret_cast<const char*>(job.bytes), job.size);
  } else {
    out = fail(std::string("the picture cannot be encoded: ") + manager.message);
  }
  std::free(job.bytes);
  return out;
}

}  // namespace cogrsim
