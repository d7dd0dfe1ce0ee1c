#include "document_support.h"

#include <catch2/catch.hpp>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <future>
#include <sstream>

#include "protocol.h"

namespace cogrsim::studio::testing {

namespace fs = std::filesystem;

void Listener::send(ClientId, std::string text) { send_all(std::move(text)); }

void Listener::send_all(std::string text) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    published_.push_back(Json::parse(text));
  }
  changed_.notify_all();
}

Json Listener::wait(const std::string& topic, std::uint64_t version) {
  std::unique_lock<std::mutex> lock(mutex_);
  Json found;
  const bool came = changed_.wait_for(lock, std::chrono::seconds(30), [&] {
    for (auto it = published_.rbegin(); it != published_.rend(); ++it)
      if ((*it)["topic"] == topic && (*it)["version"].get<std::uint64_t>() >= version &&
          !(it->contains("compiling") && (*it)["compiling"] == true)) {
        found = *it;
        return true;
      }
    return false;
  });
  INFO(topic << " of version " << version);
  REQUIRE(came);
  const auto good = check_topic(found);
  INFO((good ? std::string() : good.error().text()));
  CHECK(good);
  return found;
}

std::size_t Listener::count(const std::string& topic) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::size_t out = 0;
  for (const Json& one : published_) out += one["topic"] == topic ? 1 : 0;
  return out;
}

void ShownRun::show(
    Scene scene,
    std::function<void(tl::expected<std::vector<std::string>, std::vector<Diagnostic>>)> done) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    shown_.push_back(std::move(scene));
  }
  if (refuse_) {
    Diagnostic fault;
    fault.code = "CG0801";
    fault.message = "the engine refuses it";
    done(tl::unexpected(std::vector<Diagnostic>{fault}));
  } else {
    done(std::vector<std::string>{});
  }
}

std::vector<Scene> ShownRun::shown() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return shown_;
}

std::string Folder::read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

RequestHandler::RequestHandler(const std::string& path, bool allow_build, const std::string& state_folder) {
  DocumentOptions options;
  options.state_folder = state_folder;
  options.path = path;
  options.allow_build = allow_build;
  auto opened = Document::open(options, std::make_shared<PluginLoader>(), run, page);
  INFO((opened ? std::string() : opened.error().text()));
  REQUIRE(opened);
  document = std::move(*opened);
  page.wait("problems", 1);
}

Answer RequestHandler::ask(const std::string& what, Json fields, ClientId client) {
  if (auto good = check_fields(*find_request(what), fields); !good)
    return tl::unexpected(good.error());
  auto promise = std::make_shared<std::promise<Answer>>();
  auto answer = promise->get_future();
  document->handle({client, Role::operator_, what, std::move(fields)},
                   [promise](Answer given) { promise->set_value(std::move(given)); });
  REQUIRE(answer.wait_for(std::chrono::seconds(120)) == std::future_status::ready);
  Answer out = answer.get();
  if (out) {
    const auto good = check_answer(what, *out);
    INFO((good ? std::string() : good.error().text()));
    CHECK(good);
  }
  if (out && out->contains("version") && (*out)["version"].is_number())
    version = (*out)["version"].get<std::uint64_t>();
  return out;
}

Json RequestHandler::get(const std::string& what, Json fields) {
  Answer answer = ask(what, std::move(fields));
  INFO(what << ": " << (answer ? std::string() : answer.error().text()));
  REQUIRE(answer);
  return *answer;
}

Json RequestHandler::edit(Json op, const std::string& label) {
  return get("edit",
             {{"version", version}, {"ops", Json::array({std::move(op)})}, {"label", label}});
}

std::string RequestHandler::text() { return page.wait("document", version)["text"].get<std::string>(); }

Json RequestHandler::tree() { return page.wait("tree", version)["elements"]; }

int RequestHandler::id(const std::string& tag, const std::string& name) {
  for (const Json& e : tree())
    if (e["tag"] == tag && e["name"] == name) return e["id"].get<int>();
  FAIL("no " << tag << " " << name);
  return -1;
}

}  // namespace cogrsim::studio::testing
