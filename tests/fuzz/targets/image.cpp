#include "cogrsim/core/image.h"
#include "targets.h"

namespace cogrsim::fuzz {

void image(std::string_view input) {
  // The size in a header is allocated: pictures of a page's size are enough to find faults.
  const Result<Image> read = decode_image(input);
  if (!read) {
    require(!read.error().message.empty(), "a refusal has a reason");
    return;
  }
  const std::size_t bytes = static_cast<std::size_t>(read->width) *
                            static_cast<std::size_t>(read->height) *
                            static_cast<std::size_t>(read->channels);
  require(read->width > 0 && read->height > 0 && read->data.size() == bytes,
          "a picture has the bytes that its size asks for");
  if (bytes > (1u << 18)) return;
  const Result<std::string> written = encode_png(*read);
  require(written.has_value(), "what was read can be written");
  const Result<Image> again = decode_image(*written);
  require(again && again->data == read->data, "a PNG of a picture is that picture");
}

}  // namespace cogrsim::fuzz
