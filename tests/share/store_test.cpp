// Push, list and pull against real stores: lighttpd with WebDAV, and S3 with checked signatures.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "support.h"

namespace fs = std::filesystem;

namespace {

// A store as one sees it from the command line.
struct StoreArguments {
  std::string address;
  Environment environment;
};

StoreArguments in(const WebdavServer& server, const std::string& path = "/dav/lab/scenes") {
  return {server.url(path), WebdavServer::user()};
}

StoreArguments in(const S3Server& server, const std::string& prefix = "lab/my scenes") {
  StoreArguments arguments{"s3://robots/" + prefix, S3Server::keys()};
  arguments.environment["AWS_ENDPOINT_URL"] = server.endpoint();
  return arguments;
}

Outcome push(const StoreArguments& store, const std::string& scene,
             std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"push", scene, "--to", store.address});
  return run_program(more, store.environment);
}

Outcome pull(const StoreArguments& store, const std::string& package, const std::string& into) {
  return run_program({"pull", package, "--from", store.address, "--into", into}, store.environment);
}

nlohmann::json list(const StoreArguments& store) {
  const Outcome outcome = run_program({"list", store.address, "--json"}, store.environment);
  CAPTURE(outcome.err);
  REQUIRE(outcome.status == 0);
  return nlohmann::json::parse(outcome.out);
}

void check_says(const Outcome& outcome, const std::string& reason) {
  CAPTURE(outcome.err, reason);
  CHECK(outcome.status == 1);
  CHECK(outcome.err.find(reason) != std::string::npos);
  CHECK(outcome.err.find("error: ") == 0);
}

// Push, list and pull, which are the same for every store.
void there_and_back(const StoreArguments& store) {
  Folder home;
  const std::string scene = write_scene(home / "arm");
  const Outcome pushed =
      push(store, scene, {"--author", "Ada", "--description", "an \"arm\" \xc3\xa4"});
  CAPTURE(pushed.err);
  REQUIRE(pushed.status == 0);
  CHECK(pushed.out.find("pushed arm 1.0.0") != std::string::npos);

  const auto one = list(store);
  REQUIRE(one.size() == 1);
  CHECK(one[0]["name"] == "arm");
  CHECK(one[0]["version"] == "1.0.0");
  CHECK(one[0]["author"] == "Ada");
  CHECK(one[0]["description"] == "an \"arm\" \xc3\xa4");
  CHECK(one[0]["identity"].get<std::string>().size() == 64);

  const Outcome pulled = pull(store, "arm", home / "there");
  CAPTURE(pulled.err);
  REQUIRE(pulled.status == 0);
  const auto files = files_below(home / "there/arm-1.0.0");
  CHECK(files.size() == 10);
  for (const auto& [path, content] : files) {
    CAPTURE(path);
    if (path != "manifest.json") CHECK(content == content_of(home / ("arm/" + path)));
  }

  // The very same may be pushed again, something else only with --force.
  const Outcome again =
      push(store, scene, {"--author", "Ada", "--description", "an \"arm\" \xc3\xa4"});
  CHECK(again.status == 0);
  CHECK(again.out.find("the very same") != std::string::npos);
  write_to(home / "arm/data/wave.csv", "time,waist\n0,0\n1,0.25\n");
  check_says(push(store, scene), "is there already, with another content");
  CHECK(push(store, scene).err.find("--version 1.0.1") != std::string::npos);
  CHECK(list(store)[0]["identity"] == one[0]["identity"]);
  REQUIRE(push(store, scene, {"--version", "1.10"}).status == 0);
  REQUIRE(push(store, scene, {"--version", "1.9"}).status == 0);
  CHECK(list(store).size() == 3);
  CHECK(list(store)[2]["version"] == "1.10");
  REQUIRE(pull(store, "arm", home / "newest").status == 0);
  CHECK(fs::exists(home / "newest/arm-1.10/arm.scene.xml"));
  REQUIRE(pull(store, "arm@1.0.0", home / "newest").status == 0);
  CHECK(files_below(home / "newest/arm-1.0.0") == files);
  REQUIRE(push(store, scene, {"--force"}).status == 0);
  REQUIRE(pull(store, "arm@1.0.0", home / "forced").status == 0);
  CHECK(content_of(home / "forced/arm-1.0.0/data/wave.csv") == "time,waist\n0,0\n1,0.25\n");

  check_says(pull(store, "arm@7", home / "none"), "there is no arm 7");
  check_says(pull(store, "amr", home / "none"), "did you mean 'arm'?");
  CHECK(files_below(home / "none").empty());
}

}  // namespace

TEST_CASE("a scene is pushed to a WebDAV store and pulled unchanged", "[share][webdav]") {
  const WebdavServer server;
  there_and_back(in(server));
  // Two files to a package, in a folder that push made.
  CHECK(files_below(server.folder()).count("lab/scenes/arm-1.10.cogrsim.zip") == 1);
  CHECK(files_below(server.folder()).size() == 6);
}

TEST_CASE("a scene is pushed to an S3 store and pulled unchanged", "[share][s3]") {
  const S3Server server;
  there_and_back(in(server));
}

TEST_CASE("an S3 store that knows no conditions is good, too", "[share][s3]") {
  const S3Server server({"no-conditions"});
  there_and_back(in(server, ""));
}

TEST_CASE("a store that is not named is the one of COGRSIM_STORE", "[share]") {
  const WebdavServer server;
  Folder home;
  const std::string scene = write_scene(home / "arm");
  const Environment environment = {{"COGRSIM_STORE", server.url("/open")}};
  CHECK(run_program({"push", scene}, environment).status == 0);
  CHECK(run_program({"list"}, environment).out.find("arm   1.0.0") != std::string::npos);
  CHECK(run_program({"pull", "arm", "--into", home / "x"}, environment).status == 0);
  check_says(run_program({"list"}), "no store is named");
}

TEST_CASE("a WebDAV store's refusals are reported", "[share][webdav]") {
  WebdavServer server;
  Folder home;
  const std::string scene = write_scene(home / "arm");
  StoreArguments store = in(server);
  check_says(run_program({"list", store.address}, store.environment), "there is no such folder");
  REQUIRE(push(store, scene).status == 0);
  store.environment = {};
  for (const Outcome& outcome :
       {push(store, scene), pull(store, "arm", home / "x"), run_program({"list", store.address})}) {
    check_says(outcome, "wants a user and a password");
    CHECK(outcome.err.find("COGRSIM_STORE_USER") != std::string::npos);
  }
  store.environment = {{"COGRSIM_STORE_USER", "ada"}, {"COGRSIM_STORE_PASSWORD", "wrong"}};
  check_says(run_program({"list", store.address}, store.environment),
             "wants a user and a password");
  CHECK(files_below(home / "x").empty());

  // The entry in ~/.netrc is enough, without environment variables.
  write_to(home / ".netrc", "machine 127.0.0.1 login ada password \"engine number 1\"\n");
  CHECK(run_program({"list", store.address}, {{"HOME", home.path}}).status == 0);

  check_says(run_program({"list", "http://ada:secret@127.0.0.1/"}), "has a user in it");
  check_says(run_program({"list", "http://store.example/dav"}), "without TLS");
  server.end();
  check_says(run_program({"list", store.address}, WebdavServer::user()), "cannot be reached");
}

TEST_CASE("an S3 store's refusals are reported", "[share][s3]") {
  const S3Server server;
  Folder home;
  const std::string scene = write_scene(home / "arm");
  const StoreArguments store = in(server);
  const auto with = [&](const char* name, const char* value) {
    StoreArguments other = store;
    other.environment[name] = value;
    return other;
  };
  check_says(push(with("AWS_SECRET_ACCESS_KEY", "wrong"), scene), "SignatureDoesNotMatch");
  check_says(push(with("AWS_ACCESS_KEY_ID", "unknown"), scene), "InvalidAccessKeyId");
  check_says(push(with("AWS_REGION", "us-east-1"), scene), "AuthorizationHeaderMalformed");
  check_says(push(with("AWS_ACCESS_KEY_ID", ""), scene), "one of AWS_ACCESS_KEY_ID");
  StoreArguments unsigned_store = with("AWS_ACCESS_KEY_ID", "");
  unsigned_store.environment["AWS_SECRET_ACCESS_KEY"] = "";
  check_says(push(unsigned_store, scene), "the request is not signed");
  StoreArguments elsewhere = store;
  elsewhere.address = "s3://no-such-bucket/x";
  check_says(push(elsewhere, scene), "there is no bucket 'no-such-bucket'");
  check_says(run_program({"list", elsewhere.address}, elsewhere.environment), "there is no bucket");
  CHECK(list(store).empty());
  // A session's token is signed like the rest.
  CHECK(push(with("AWS_SESSION_TOKEN", "abc/+=="), scene).status == 0);
  // The endpoint may be an argument.
  StoreArguments given = with("AWS_ENDPOINT_URL", "http://127.0.0.1:1");
  CHECK(run_program({"list", given.address, "--endpoint", server.endpoint()}, given.environment)
            .status == 0);
}

TEST_CASE("a busy store is asked again", "[share][faults]") {
  const WebdavServer server;
  Folder home;
  const std::string scene = write_scene(home / "arm");
  {
    const FaultyProxy proxy(server, "busy:2");
    REQUIRE(
        push({"http://127.0.0.1:" + std::to_string(proxy.port()) + "/open", {}}, scene).status ==
        0);
  }
  const FaultyProxy proxy(server, "busy:99");
  check_says(run_program({"list", "http://127.0.0.1:" + std::to_string(proxy.port()) + "/open"}),
             "answered 503");
}

TEST_CASE("an S3 store that is busy gets fresh signatures", "[share][faults][s3]") {
  const S3Server server;
  const FaultyProxy proxy(server, "busy:2");
  StoreArguments store = in(server);
  store.environment["AWS_ENDPOINT_URL"] = "http://127.0.0.1:" + std::to_string(proxy.port());
  Folder home;
  const Outcome pushed = push(store, write_scene(home / "arm"));
  CAPTURE(pushed.err);
  CHECK(pushed.status == 0);
}

TEST_CASE("a download that breaks off is tried again, and never used in part", "[share][faults]") {
  const WebdavServer server;
  Folder home;
  REQUIRE(push({server.url("/open"), {}}, write_scene(home / "arm")).status == 0);
  {
    const FaultyProxy proxy(server, "cut:500:1");
    CHECK(pull({"http://127.0.0.1:" + std::to_string(proxy.port()) + "/open", {}}, "arm",
               home / "good")
              .status == 0);
  }
  const FaultyProxy proxy(server, "cut:500:99");
  check_says(
      pull({"http://127.0.0.1:" + std::to_string(proxy.port()) + "/open", {}}, "arm", home / "bad"),
      "broke off");
  CHECK(fs::is_empty(home / "bad"));
}

TEST_CASE("a store that dies during a push has no half package", "[share][faults]") {
  const WebdavServer server;
  Folder home;
  const std::string scene = write_scene(home / "arm");
  const StoreArguments direct = {server.url("/open"), {}};
  {
    const FaultyProxy proxy(server, "die:1000");
    const Outcome outcome =
        push({"http://127.0.0.1:" + std::to_string(proxy.port()) + "/open", {}}, scene);
    CAPTURE(outcome.err);
    CHECK(outcome.status == 1);
  }
  CHECK(list(direct).empty());
  CHECK(push(direct, scene).status == 0);
  CHECK(list(direct).size() == 1);
}

TEST_CASE("a large package is transferred completely, or not at all", "[share][faults][s3][webdav]") {
  Folder home;
  const std::string scene = write_scene(home / "arm");
  // Noise, so that it stays large: a linear congruential generator (Knuth, MMIX).
  std::string noise(3u << 20, '\0');
  std::uint64_t state = 1;
  for (char& c : noise) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    c = static_cast<char>(state >> 56);
  }
  write_to(home / "arm/noise.stl", noise);
  const std::vector<std::string> include = {"--include", home / "arm/noise.stl"};
  const WebdavServer webdav;
  const S3Server s3;
  for (const StoreArguments& store : {in(webdav, "/dav"), in(s3)}) {
    CAPTURE(store.address);
    StoreArguments stranger = store;
    stranger.environment["COGRSIM_STORE_PASSWORD"] = "wrong";
    stranger.environment["AWS_SECRET_ACCESS_KEY"] = "wrong";
    const Outcome refused = push(stranger, scene, include);
    CAPTURE(refused.err);
    CHECK(refused.status == 1);
    CHECK((refused.err.find("wants a user") != std::string::npos ||
           refused.err.find("SignatureDoesNotMatch") != std::string::npos));
    CHECK(list(store).empty());
    const Outcome pushed = push(store, scene, include);
    CAPTURE(pushed.err);
    REQUIRE(pushed.status == 0);
    Folder into;
    REQUIRE(pull(store, "arm", into.path).status == 0);
    CHECK((content_of(into / "arm-1.0.0/noise.stl") == noise));
  }
  const FaultyProxy dying(webdav, "die:1000000");
  CHECK(push({"http://127.0.0.1:" + std::to_string(dying.port()) + "/open", {}}, scene, include)
            .status == 1);
  CHECK(list({webdav.url("/open"), {}}).empty());
  const FaultyProxy busy(webdav, "busy:2");
  CHECK(push({"http://127.0.0.1:" + std::to_string(busy.port()) + "/open", {}}, scene, include)
            .status == 0);
}

TEST_CASE("a push whose answers got lost has succeeded", "[share][faults]") {
  const WebdavServer server;
  Folder home;
  const FaultyProxy proxy(server, "lose:1");
  const StoreArguments store = {"http://127.0.0.1:" + std::to_string(proxy.port()) + "/open", {}};
  const Outcome pushed = push(store, write_scene(home / "arm"));
  CAPTURE(pushed.err);
  CHECK(pushed.status == 0);
  CHECK(pull(store, "arm", home / "x").status == 0);
}

TEST_CASE("a file without an entry is no package, and is not replaced without --force",
          "[share][webdav]") {
  const WebdavServer server;
  Folder home;
  const StoreArguments store = in(server, "/dav");
  const std::string scene = write_scene(home / "arm");
  write_to(server.folder() + "/arm-1.0.0.cogrsim.zip", "half a package");
  CHECK(list(store).empty());
  check_says(pull(store, "arm", home / "x"), "there is no package 'arm'");
  check_says(push(store, scene), "without an entry");
  CHECK(content_of(server.folder() + "/arm-1.0.0.cogrsim.zip") == "half a package");
  CHECK(push(store, scene, {"--force"}).status == 0);
  CHECK(pull(store, "arm", home / "x").status == 0);
}

TEST_CASE("a package that was changed in transit or in the store is refused", "[share][faults]") {
  const WebdavServer server;
  Folder home;
  const StoreArguments store = in(server, "/dav");
  REQUIRE(push(store, write_scene(home / "arm")).status == 0);
  {
    const FaultyProxy proxy(server, "change");
    check_says(
        pull({"http://127.0.0.1:" + std::to_string(proxy.port()) + "/dav", store.environment},
             "arm", home / "x"),
        "is not what its entry says");
  }
  const std::string zip = server.folder() + "/arm-1.0.0.cogrsim.zip";
  const std::string entry = server.folder() + "/arm-1.0.0.cogrsim.json";
  const std::string good_zip = content_of(zip), good_entry = content_of(entry);
  write_to(zip, good_zip + "more");
  check_says(pull(store, "arm", home / "x"), "longer than");
  write_to(zip, good_zip.substr(1));
  check_says(pull(store, "arm", home / "x"), "is not what its entry says");
  fs::remove(zip);
  check_says(pull(store, "arm", home / "x"), "there is no arm-1.0.0.cogrsim.zip");
  write_to(zip, good_zip);
  write_to(entry, "{\"format\": \"cogrsim-package\"}");
  check_says(pull(store, "arm", home / "x"), "is damaged");
  CHECK(list(store)[0]["problem"].get<std::string>().find("damaged") != std::string::npos);
  // An entry and a package replaced by those of another name.
  write_to(server.folder() + "/leg-1.0.0.cogrsim.json", good_entry);
  check_says(pull(store, "leg", home / "x"), "names arm-1.0.0");
  CHECK(fs::is_empty(home / "x"));
}

TEST_CASE("answers that do not end and silence are given up", "[share][faults]") {
  const WebdavServer server;
  Folder home;
  {
    const FaultyProxy proxy(server, "grow");
    check_says(pull({"http://127.0.0.1:" + std::to_string(proxy.port()) + "/open", {}}, "arm@1",
                    home / "x"),
               "is longer than");
  }
  {
    const FaultyProxy proxy(server, "silent");
    check_says(run_program({"list", "http://127.0.0.1:" + std::to_string(proxy.port()) + "/open",
                            "--timeout", "1"}),
               "gave no answer in time");
  }
  const FaultyProxy proxy(server, "redirect");
  check_says(run_program({"list", "http://127.0.0.1:" + std::to_string(proxy.port()) + "/open"}),
             "sends us elsewhere");
}

TEST_CASE("the certificate of a store is checked", "[share][faults]") {
  const WebdavServer server;
  Folder home;
  const auto certify = [&](const std::string& name, const std::string& host) {
    const std::string command = COGRSIM_OPENSSL
                                " req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 "
                                "-nodes -days 2 -subj /CN=tests "
                                "-addext subjectAltName=" +
                                host + " -keyout " + (home / (name + ".key")) + " -out " +
                                (home / (name + ".crt")) + " 2>/dev/null";
    REQUIRE(std::system(command.c_str()) == 0);
    return std::vector<std::string>{home / (name + ".key"), home / (name + ".crt")};
  };
  const FaultyProxy good(server, "none", certify("good", "IP:127.0.0.1"));
  const std::string address = "https://127.0.0.1:" + std::to_string(good.port()) + "/open";
  check_says(run_program({"list", address}), "certificate cannot be trusted");
  CHECK(run_program({"list", address}, {{"CURL_CA_BUNDLE", home / "good.crt"}}).status == 0);
  const FaultyProxy other(server, "none", certify("other", "DNS:store.example"));
  check_says(run_program({"list", "https://127.0.0.1:" + std::to_string(other.port()) + "/open"},
                         {{"CURL_CA_BUNDLE", home / "other.crt"}}),
             "certificate cannot be trusted");
}
