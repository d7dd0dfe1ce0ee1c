// The table of the protocol, and what is made from it. COGRSIM_RENEW_EXPECTED=1 renews the files.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "protocol.h"
#include "protocol_type.h"

namespace fs = std::filesystem;
using namespace cogrsim::studio;

namespace {

const fs::path kSource = COGRSIM_SOURCE_DIR;

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void compare(const char* file, const std::string& made) {
  const fs::path path = kSource / file;
  if (std::getenv("COGRSIM_RENEW_EXPECTED")) std::ofstream(path, std::ios::binary) << made;
  INFO(file);
  CHECK(read(path) == made);
}

void check_type(const FieldType& type) {
  if (type.kind == FieldType::Kind::named) {
    const auto& types = protocol_types();
    INFO("the type " << type.name);
    CHECK(std::any_of(types.begin(), types.end(),
                      [&](const ProtocolType& one) { return one.name == type.name; }));
  }
  for (const FieldType& part : type.parts) check_type(part);
}

void check_table(const std::vector<ProtocolField>& fields) {
  std::set<std::string> names;
  for (const ProtocolField& field : fields) {
    INFO(field.name);
    CHECK(names.insert(field.plain_name()).second);
    check_type(read_type(field.type));
    if (field.standard) {
      CHECK(field.optional());
      CHECK(Json::accept(field.standard));
    }
  }
}

}  // namespace

TEST_CASE("the page's types are those of the table", "[studio][protocol]") {
  compare("apps/studio/web/src/core/protocol.ts", protocol_typescript());
  compare("apps/studio/web/src/core/protocol_types.ts", protocol_types_typescript());
}

TEST_CASE("the page about the protocol has the table", "[studio][protocol]") {
  const std::string page = protocol_markdown(read(kSource / "apps/studio/PROTOCOL.md"));
  compare("apps/studio/PROTOCOL.md", page);
  CHECK(page.find("there is no table") == std::string::npos);
  for (const ProtocolRequest& request : protocol_requests()) {
    CHECK(page.find("\n| `" + std::string(request.name) + "`") != std::string::npos);
  }
}

TEST_CASE("the fuzzer's dictionary has the table", "[studio][protocol]") {
  compare("tests/fuzz/requests.dict", protocol_dictionary());
}

TEST_CASE("the table of the protocol is consistent", "[studio][protocol]") {
  std::set<std::string> names;
  for (const ProtocolRequest& request : protocol_requests()) {
    INFO(request.name);
    CHECK(names.insert(request.name).second);
    CHECK(find_request(request.name) == &request);
    CHECK(*request.doc);
    check_table(request.fields);
    check_table(request.answer);
  }
  for (const ProtocolType& type : protocol_types()) {
    INFO(type.name);
    CHECK(names.insert(type.name).second);
    CHECK((type.alias != nullptr) == type.fields.empty());
    if (type.alias) check_type(read_type(type.alias));
    check_table(type.fields);
  }
  for (const ProtocolTopic& topic : protocol_topics()) check_type(read_type(topic.type));
}

TEST_CASE("an answer that is not as the table has it is found", "[studio][protocol]") {
  CHECK(check_answer("seek", {{"time", 1.5}}));
  CHECK_FALSE(check_answer("seek", {{"time", "late"}}));
  CHECK_FALSE(check_answer("seek", Json::object()));
  CHECK(check_topic({{"topic", "goodbye"}, {"reason", "the end"}}));
  CHECK_FALSE(check_topic({{"topic", "goodbye"}, {"reason", 7}}));
  CHECK_FALSE(check_topic({{"topic", "status"}, {"state", "asleep"}}));
  CHECK_FALSE(check_topic({{"topic", "weather"}}));
}
