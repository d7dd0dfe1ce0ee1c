#include "store.h"
#include "targets.h"

namespace cogrsim::fuzz {

void listing(std::string_view input) {
  const std::string xml(input);
  static_cast<void>(share::parse_multistatus(xml));
  std::string next;
  static_cast<void>(share::parse_bucket_list(xml, "packages/", next));
  share::parse_s3_fault(xml);
  static_cast<void>(share::parse_address(xml));
}

}  // namespace cogrsim::fuzz
