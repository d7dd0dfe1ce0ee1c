// Names, paths, versions, manifests: what is accepted and what is refused.
#include <catch2/catch.hpp>

#include "common/terminal.h"
#include "hash.h"
#include "http.h"
#include "local.h"
#include "rules.h"
#include "store.h"
#include "zip_maker.h"

using namespace cogrsim::share;

TEST_CASE("SHA-256 is that of the standard", "[share]") {
  // FIPS 180-2, appendix B.1, and the empty message
  CHECK(sha256_of("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256_of("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST_CASE("plain paths below a folder are taken", "[share]") {
  for (const char* path : {"a.xml", "textures/tiles.png", "a b/c(1).png", "consul.txt", "com10.txt",
                           "a/b/c/d/e/f/g/h/i/j/k/l"}) {
    CAPTURE(path);
    CHECK(check_path(path));
  }
}

TEST_CASE("paths that lead elsewhere or are not the same everywhere are refused", "[share]") {
  using namespace std::string_literals;
  for (const std::string& path : {""s,
                                  "/etc/passwd"s,
                                  "../a"s,
                                  "a/../b"s,
                                  "a/.."s,
                                  "./a"s,
                                  "a//b"s,
                                  "a/"s,
                                  "a\\b"s,
                                  "C:a"s,
                                  ".bashrc"s,
                                  "a/.git/config"s,
                                  "-rf"s,
                                  "~/a"s,
                                  "a."s,
                                  "a "s,
                                  " a"s,
                                  "a\nb"s,
                                  "a\0b"s,
                                  "a\x7f"s,
                                  "\xc3\xa4.xml"s,
                                  "nul"s,
                                  "NUL.txt"s,
                                  "a/Con.xml"s,
                                  "COM1"s,
                                  "lpt9.csv"s,
                                  "a*"s,
                                  "a?"s,
                                  "a|b"s,
                                  "a<b"s,
                                  "a\"b"s,
                                  "a/b/c/d/e/f/g/h/i/j/k/l/m"s,
                                  std::string(101, 'a'),
                                  "\xe2\x80\xae"
                                  "gnp.exe"s}) {
    CAPTURE(path);
    CHECK_FALSE(check_path(path));
  }
}

TEST_CASE("a role goes with an ending, and programs have none", "[share]") {
  CHECK(check_role("A/B.PNG", Role::texture));
  CHECK(check_role("CMakeLists.txt", Role::source));
  CHECK_FALSE(check_role("a.png", Role::source));
  for (const char* path :
       {"a.so", "a.dll", "a.exe", "a.sh", "a.py", "a", "a.so.1", "a.png.exe", "Makefile"}) {
    CAPTURE(path);
    CHECK_FALSE(role_of(path));
  }
}

TEST_CASE("a path is there once, whatever its capitals", "[share]") {
  PathSet set;
  REQUIRE(set.add("a/b.txt"));
  CHECK(set.add("a/c.txt"));
  CHECK_FALSE(set.add("a/b.txt"));
  CHECK_FALSE(set.add("a/B.TXT"));
  CHECK_FALSE(set.add("A/d.txt"));
  CHECK_FALSE(set.add("a"));
  CHECK_FALSE(set.add("a/b.txt/c"));
}

TEST_CASE("programs are recognised by their content", "[share]") {
  const auto check = [](const char* path, const std::string& content) {
    ContentCheck look(path);
    for (const char c : content) look.feed({&c, 1});  // in pieces, as a file comes
    return bool(look.finish());
  };
  CHECK(check("a.csv", "1,2\n"));
  CHECK(check("a.png", "\x89PNG\r\n\x1a\n..."));
  CHECK_FALSE(check("a.png",
                    "\x7f"
                    "ELF"));
  CHECK_FALSE(check("a.png", "GIF89a"));
  CHECK(check("a.glb", std::string("glTF\2\0\0\0", 8)));
  CHECK_FALSE(check("a.glb", "{\"asset\":{}}"));
  CHECK(check("a.bin", std::string("\0\1\2\3", 4)));
  CHECK_FALSE(check("a.bin", "MZ........"));
  CHECK_FALSE(check("a.stl", "MZ........"));
  CHECK_FALSE(check("a.txt", "#!/bin/sh\n"));
  CHECK_FALSE(check("a.csv", std::string("1,\0", 3)));
  CHECK_FALSE(check("a.mcap", "no recording"));
}

TEST_CASE("versions are ordered by their numbers", "[share]") {
  CHECK(version_less("1.9", "1.10"));
  CHECK(version_less("1.0", "1.0.0"));
  CHECK_FALSE(version_less("2", "1.9.9"));
  CHECK(next_version("1.0.9") == "1.0.10");
  for (const char* good : {"0", "1", "1.0", "10.20.30.40"}) CHECK(check_version(good));
  for (const char* bad :
       {"", "1.", ".1", "1..2", "01", "1.00", "1.2.3.4.5", "v1", "1-2", "1/2", "1234567890"}) {
    CAPTURE(bad);
    CHECK_FALSE(check_version(bad));
  }
}

TEST_CASE("names of packages are plain, and are made of scenes' names", "[share]") {
  CHECK(to_name("Two Wheels!") == "two-wheels");
  CHECK(to_name("\xc3\xa4") == "");
  CHECK(to_name("con") == "");
  for (const char* bad : {"", "-a", "_a", "A", "a.b", "a/b", "nul"}) CHECK_FALSE(check_name(bad));
  const auto known = parse_stem("two-wheels-1.0.2.cogrsim.zip", kPackageEnding);
  REQUIRE(known);
  CHECK(known->name == "two-wheels");
  CHECK(known->version == "1.0.2");
  CHECK_FALSE(parse_stem("two-wheels.cogrsim.zip", kPackageEnding));
  CHECK_FALSE(parse_stem("../a-1.cogrsim.zip", kPackageEnding));
  CHECK_FALSE(parse_stem("a-1.cogrsim.json", kPackageEnding));
}

TEST_CASE("texts for people do not steer a terminal or turn round", "[share]") {
  CHECK(check_text("author", "Ada L\xc3\xb6velace\nand others", 100));
  for (const char* bad : {"\x1b[2J", "a\rb", "\xff",
                          "\xc2\x9b"
                          "2J",
                          "a\xe2\x80\xae"
                          "b",
                          "\xc0\x80", "\xe2\x80"}) {
    CAPTURE(bad);
    CHECK_FALSE(check_text("author", bad, 100));
  }
  CHECK_FALSE(check_text("author", "12345", 4));
}

TEST_CASE("a manifest is read as it was written", "[share]") {
  Manifest manifest =
      manifest_for({{"a.scene.xml", "<scene/>", Role::scene}, {"b.csv", "1", Role::data}});
  manifest.description = "with \"quotes\"";
  const auto read = parse_manifest(to_text(manifest));
  REQUIRE(read);
  CHECK(to_text(*read) == to_text(manifest));
  // The identity is that of the files: another name changes nothing, another file does.
  Manifest renamed = manifest;
  renamed.package.name = "good";
  CHECK(identity_of(renamed) == identity_of(manifest));
  renamed.files[1].path = "c.csv";
  CHECK(identity_of(renamed) != identity_of(manifest));
}

TEST_CASE("a malformed manifest is refused", "[share]") {
  const std::string good =
      to_text(manifest_for({{"a.scene.xml", "<scene/>", Role::scene}, {"b.csv", "1", Role::data}}));
  REQUIRE(parse_manifest(good));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    REQUIRE(at != std::string::npos);
    return bool(parse_manifest(text.replace(at, from.size(), to)));
  };
  CHECK_FALSE(with("cogrsim-package", "other"));
  CHECK_FALSE(with("\"format_version\": 1", "\"format_version\": 2"));
  CHECK_FALSE(with("\"format_version\": 1", "\"format_version\": -1"));
  CHECK_FALSE(with("\"name\": \"evil\"", "\"name\": \"../evil\""));
  CHECK_FALSE(with("\"name\": \"evil\"", "\"name\": 7"));
  CHECK_FALSE(with("\"name\": \"evil\"", "\"name\": \"evil\", \"name\": \"good\""));
  CHECK_FALSE(with("\"version\": \"1.0.0\"", "\"version\": \"latest\""));
  CHECK_FALSE(with("\"scene\": \"a.scene.xml\"", "\"scene\": \"b.csv\""));
  CHECK_FALSE(with("\"role\": \"data\"", "\"role\": \"program\""));
  CHECK_FALSE(with("\"size\": 1,", "\"size\": 2,"));  // not what the identity says
  CHECK_FALSE(with("\"size\": 1,", "\"size\": 1e99,"));
  CHECK_FALSE(with("\"description\": \"\"", "\"description\": \"\\u001b[2J\""));
  CHECK_FALSE(parse_manifest(good.substr(0, good.size() / 2)));
  CHECK_FALSE(parse_manifest(std::string(100000, '[')));
}

TEST_CASE("limits of a manifest hold", "[share]") {
  const std::string text = to_text(manifest_for(
      {{"a.scene.xml", "<scene/>", Role::scene}, {"b.csv", "12345678901", Role::data}}));
  REQUIRE(parse_manifest(text));
  PackageLimits limits;
  limits.files = 1;
  CHECK_FALSE(parse_manifest(text, limits));
  limits = {};
  limits.file_bytes = 10;
  CHECK_FALSE(parse_manifest(text, limits));
  limits = {};
  limits.unpacked_bytes = 18;
  CHECK_FALSE(parse_manifest(text, limits));
}

TEST_CASE("addresses of stores are checked before anything is sent", "[share]") {
  for (const char* good : {"https://a.example/dav", "http://127.0.0.1:80/x", "http://localhost/",
                           "http://[::1]:8080/a", "HTTPS://a.example"}) {
    CAPTURE(good);
    CHECK(parse_address(good));
  }
  for (const char* bad :
       {"", "a.example/dav", "ftp://a", "file:///etc", "http://a.example/dav",
        "https://u:p@a.example/", "https://", "https://a/../b", "https://a/b?c", "https://a/#b",
        "http://localhost.evil.example/", "http://127.0.0.1.evil.example/",
        "http://127.0.0.1@evil.example/", "https://a b/"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_address(bad));
  }
}

TEST_CASE("listings give names of packages and nothing else", "[share]") {
  const auto files = parse_multistatus(
      "<?xml version=\"1.0\"?><x:multistatus xmlns:x=\"DAV:\">"
      "<x:response><x:href>/dav/</x:href></x:response>"
      "<x:response><x:href>http://evil.example/dav/arm%2D1.0.cogrsim.zip</"
      "x:href><x:propstat><x:prop>"
      "<x:getcontentlength>12</x:getcontentlength></x:prop></x:propstat></x:response>"
      "<x:response><x:href>/dav/%2e%2e%2fevil-1.cogrsim.zip</x:href></x:response>"
      "<x:response><x:href>/dav/photo.jpg</x:href></x:response></x:multistatus>");
  REQUIRE(files);
  REQUIRE(files->size() == 2);
  CHECK((*files)[0].name == "arm-1.0.cogrsim.zip");
  CHECK((*files)[0].size == 12);
  CHECK((*files)[1].name == "evil-1.cogrsim.zip");  // what was before the slash is gone
  CHECK_FALSE(parse_multistatus("<html/>"));
  CHECK_FALSE(parse_multistatus(""));
  std::string next;
  const auto keys = parse_bucket_list(
      "<ListBucketResult><IsTruncated>true</IsTruncated><NextContinuationToken>t/+</"
      "NextContinuationToken><Contents><Key>p/arm-1.cogrsim.json</Key><Size>3</Size></Contents>"
      "<Contents><Key>q/arm-2.cogrsim.json</Key></Contents>"
      "<Contents><Key>p/sub/arm-3.cogrsim.json</Key></Contents></ListBucketResult>",
      "p/", next);
  REQUIRE(keys);
  REQUIRE(keys->size() == 1);
  CHECK(next == "t/+");
}

TEST_CASE("any text can be quoted for a shell", "[share]") {
  CHECK(cogrsim::cli::shell_quoted("a/b-1.0/c.xml") == "a/b-1.0/c.xml");
  CHECK(cogrsim::cli::shell_quoted("a b") == "'a b'");
  CHECK(cogrsim::cli::shell_quoted("$(reboot)") == "'$(reboot)'");
  CHECK(cogrsim::cli::shell_quoted("it's") == "'it'\\''s'");
  CHECK(percent_encoded("a b/\xc3\xa4+~", true) == "a%20b/%C3%A4%2B~");
  CHECK(percent_decoded("a%20b") == "a b");
  CHECK(percent_decoded("a%2") == "");
}
