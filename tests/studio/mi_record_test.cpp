// Records of gdb's machine interface: those that gdb writes, and those that nobody should.
#include <catch2/catch.hpp>

#include "mi_record.h"

using namespace cogrsim::studio;
using Kind = MiRecord::Kind;

TEST_CASE("records of gdb are read", "[studio][debug]") {
  const auto stop = read_mi_record(
      R"(*stopped,reason="breakpoint-hit",bkptno="1",frame={func="update",args=[{name="k",value="\"a\\n\""}],line="11"},stopped-threads="all")");
  REQUIRE(stop);
  CHECK(stop->kind == Kind::exec);
  CHECK(stop->what == "stopped");
  CHECK_FALSE(stop->token);
  CHECK(mi_text(stop->fields, "reason") == "breakpoint-hit");
  CHECK(mi_number(stop->fields["frame"], "line") == 11);
  CHECK(stop->fields["frame"]["args"][0]["value"] == "\"a\\n\"");

  const auto answer = read_mi_record(
      R"(17^done,stack=[frame={level="0",func="f"},frame={level="1",func="g"}],empty=[],none={})");
  REQUIRE(answer);
  CHECK(answer->kind == Kind::result);
  CHECK(answer->token == 17U);
  REQUIRE(answer->fields["stack"].size() == 2);
  CHECK(answer->fields["stack"][1]["func"] == "g");
  CHECK(answer->fields["empty"] == Json::array());
  CHECK(answer->fields["none"] == Json::object());

  CHECK(read_mi_record("^running")->what == "running");
  CHECK(read_mi_record("(gdb) ")->kind == Kind::prompt);
  CHECK(read_mi_record("=thread-created,id=\"1\"")->kind == Kind::notify);
  CHECK(read_mi_record("+download,section=\".text\"")->kind == Kind::status);
  CHECK(read_mi_record(R"(~"tab\t\"quoted\" \\ \303\244 \033\n")")->what ==
        "tab\t\"quoted\" \\ \xC3\xA4 \x1b\n");
  CHECK(read_mi_record(R"(&"warning")")->kind == Kind::log);
  CHECK(read_mi_record(R"(@"text")")->kind == Kind::target);
  CHECK(read_mi_record(R"(^done,groups=["i1","i2"])")->fields["groups"][1] == "i2");
}

TEST_CASE("every record that is cut off is refused", "[studio][debug]") {
  const std::string whole = R"(5^done,bkpt={number="1",at=[{line="4"},"x"],name="a\"b"},last="1")";
  REQUIRE(read_mi_record(whole));
  const auto complete = [&](std::size_t size) {  // where a record may end
    return size == 6 || size == whole.size() || size == whole.find(",last");
  };
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    INFO(whole.substr(0, size));
    if (size >= 3 && size < 6) continue;  // "5^d" is a class that gdb does not have
    CHECK(read_mi_record(std::string_view(whole).substr(0, size)).has_value() == complete(size));
  }
}

TEST_CASE("hostile records are refused, and bounded", "[studio][debug]") {
  for (const char* line : {"",
                           "hello",
                           "^",
                           "5",
                           "^done,",
                           "^done,=\"x\"",
                           "^done,a",
                           "^done,a=b",
                           "^done,a=\"",
                           "^done,a=\"\\",
                           "^done,a={\"x\"}",
                           "^done,a=[b]",
                           "^done,a=[b=]",
                           "^done,a={b=\"1\"]",
                           "^done,a=[\"1\"}",
                           "^done,a=\"1\"b=\"2\"",
                           "~text",
                           "~\"a\"b",
                           "^done a=\"1\"\"",
                           "99999999999999999999^done",
                           "-1^done",
                           "\xFF\xFE"}) {
    INFO(line);
    CHECK_FALSE(read_mi_record(line));
  }
  std::string deep = "^done,a=";
  for (int i = 0; i < 1'000'000; ++i) deep += '[';
  CHECK_FALSE(read_mi_record(deep));
  std::string tuples = "^done,a=";
  for (int i = 0; i < 100'000; ++i) tuples += "{a=";
  CHECK_FALSE(read_mi_record(tuples));
  CHECK_FALSE(read_mi_record("~\"" + std::string(kMostMiLine, 'x') + "\""));
  // A value that is huge, but within the limit, is read whole.
  const std::string huge(kMostMiLine / 2, 'x');
  const auto read = read_mi_record("^done,value=\"" + huge + "\"");
  REQUIRE(read);
  CHECK(mi_text(read->fields, "value") == huge);
  // The last of a name counts.
  CHECK(read_mi_record("^done,a=\"1\",a=\"2\"")->fields["a"] == "2");
}

TEST_CASE("numbers and texts of records are taken with care", "[studio][debug]") {
  const Json tuple = {{"line", "12"}, {"big", "99999999999"}, {"text", "12a"}, {"list", {1}}};
  CHECK(mi_number(tuple, "line") == 12);
  CHECK_FALSE(mi_number(tuple, "big"));
  CHECK_FALSE(mi_number(tuple, "text"));
  CHECK_FALSE(mi_number(tuple, "list"));
  CHECK_FALSE(mi_number(tuple, "missing"));
  CHECK_FALSE(mi_number(Json::array(), "line"));
  CHECK(mi_text(tuple, "list").empty());
  CHECK(*mi_quoted(R"(a "b" \c)") == R"("a \"b\" \\c")");
  CHECK_FALSE(mi_quoted("a\n-gdb-exit"));
  CHECK_FALSE(mi_quoted(std::string_view("a\0b", 3)));
  CHECK(mi_quoted(std::string(10'000, 'a')));
  CHECK_FALSE(mi_quoted(std::string(10'001, 'a')));
}
