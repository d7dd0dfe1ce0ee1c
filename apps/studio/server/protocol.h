// The protocol of page and server as data: every request with its fields and answer, every published
// message. From it come the validation and routing of requests, web/src/core/protocol.ts and
// protocol_types.ts, the tables of ../PROTOCOL.md and the dictionary of the fuzzer.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

/// What `hello` answers: goes up with every change that an older page does not understand.
constexpr int kProtocol = 4;

/// Of the numbers in a field, and of its list.
struct FieldBounds {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above = false;  ///< `least` itself is not allowed
  std::size_t fewest_entries = 0;
  std::size_t most_entries = std::numeric_limits<std::size_t>::max();
};

struct ProtocolField {
  const char* name;  ///< "file?": may be left out, or null
  /// As in TypeScript, with `integer` beside `number`: names, "texts", T[], [T, T], A | B.
  const char* type;
  const char* doc = "";
  const char* standard = nullptr;  ///< JSON that stands for a field that is left out
  FieldBounds bounds = {};

  bool optional() const { return std::string_view(name).back() == '?'; }
  std::string plain_name() const;
};

/// An object, or another name of a type.
struct ProtocolType {
  const char* name;
  const char* doc;
  std::vector<ProtocolField> fields;
  const char* alias = nullptr;
};

struct ProtocolRequest {
  const char* name;
  Section section;
  bool viewers;  ///< may ask, too
  std::vector<ProtocolField> fields, answer;
  const char* doc;
};

struct ProtocolTopic {
  const char* name;
  const char* type;
  const char* when;
};

const std::vector<ProtocolRequest>& protocol_requests();
const std::vector<ProtocolTopic>& protocol_topics();
const std::vector<ProtocolType>& protocol_types();

/// nullptr: there is none.
const ProtocolRequest* find_request(std::string_view name);
/// The error for a request that is not in the table.
Error unknown_request(const std::string& name);

/// Checks the fields of a request, and fills in those that are left out and have a standard. Errors
/// name the field and what it must be.
Result<> check_fields(const ProtocolRequest& request, Json& fields);
/// Whether an answer, or a published message, is as the table has it.
Result<> check_answer(std::string_view request, const Json& answer);
Result<> check_topic(const Json& message);

/// web/src/core/protocol.ts: topics and requests; and protocol_types.ts: what they consist of.
std::string protocol_typescript();
std::string protocol_types_typescript();
/// PROTOCOL.md with its tables generated again: what stands between `<!-- table: NAME -->` and
/// `<!-- end -->`.
std::string protocol_markdown(const std::string& page);
/// tests/fuzz/requests.dict.
std::string protocol_dictionary();

}  // namespace cogrsim::studio
