#include "document.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "cogrsim/dsl/schema.h"
#include "common/progress.h"
#include "complete.h"
#include "document_impl.h"
#include "document_json.h"
#include "mass.h"
#include "run_fields.h"

namespace cogrsim::studio {
namespace {

constexpr double kNoticed = 0.05;  // [s] a longer compilation is announced to the pages

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Editors in pages know one kind of line end; files keep theirs.
std::string with_line_ends_of(const std::string& old, std::string text) {
  const bool crlf = old.find("\r\n") != std::string::npos;
  const std::size_t all = static_cast<std::size_t>(std::count(old.begin(), old.end(), '\n'));
  const std::size_t returns = static_cast<std::size_t>(std::count(old.begin(), old.end(), '\r'));
  if (!crlf || all != returns || text.find('\r') != std::string::npos) return text;
  std::string out;
  for (const char c : text) {
    if (c == '\n') out += '\r';
    out += c;
  }
  return out;
}

}  // namespace

std::string empty_scene(const std::string& file) {
  std::string title = file.substr(0, file.find('.'));
  for (char& c : title)
    if (c == '_' || c == '&' || c == '<' || c == '"') c = ' ';
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<scene name=\"" + title +
         "\" version=\"1\">\n"
         "  <physics step=\"1 ms\" gravity=\"0 0 -9.81\"/>\n"
         "  <light name=\"sun\" type=\"directional\" direction=\"-0.7 0.3 -1\"/>\n"
         "  <plane name=\"floor\"/>\n</scene>\n";
}

// ---- the thread and its work

bool DocumentQueue::put(ClientId client, Role role, Task task) {
  std::optional<Task> older;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (closed_) return false;
    if (task.give_up) {
      older =
          tasks_.take_if(client, role, [&](const Task& l) { return l.what == task.what; });
    }
    tasks_.put(client, role, std::move(task));
  }
  waiting_.notify_one();
  if (older) older->give_up();
  return true;
}

void DocumentQueue::forget(ClientId client) {
  std::deque<Task> forgotten;  // their destructors answer the requests
  const std::lock_guard<std::mutex> lock(mutex_);
  forgotten = tasks_.forget_viewer(client);
}

std::optional<DocumentQueue::Task> DocumentQueue::take() {
  std::unique_lock<std::mutex> lock(mutex_);
  waiting_.wait(lock, [&] { return closed_ || !tasks_.empty(); });
  // Typed text is processed to the end, so that it is in the journal.
  while (closed_ && !tasks_.empty() && tasks_.next().what != "set-text") tasks_.take();
  if (tasks_.empty()) return std::nullopt;
  return tasks_.take();
}

bool DocumentQueue::next_changes_text() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_ || tasks_.empty()) return closed_;
  const std::string& what = tasks_.next().what;
  return what == "set-text" || what == "undo" || what == "redo" || what == "edit";
}

void DocumentQueue::close() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
  }
  waiting_.notify_one();
}

Result<std::unique_ptr<Document>> Document::open(DocumentOptions options,
                                                 std::shared_ptr<PluginLoader> loader, Run& run,
                                                 Outbox& outbox) {
  auto file = SceneFile::open(options.path, kMostSceneBytes);
  if (!file) return tl::unexpected(file.error());
  return std::unique_ptr<Document>(std::make_unique<DocumentRequests>(
      std::move(options), std::move(*file), std::move(loader), run, outbox));
}

DocumentRequests::DocumentRequests(DocumentOptions options, SceneFile file,
                           std::shared_ptr<PluginLoader> loader, Run& run, Outbox& outbox)
    : options_(std::move(options)),
      run_(run),
      outbox_(outbox),
      file_(std::move(file)),
      history_(file_.text() ? *file_.text() : empty_scene(file_.name())),
      journal_(file_.path(), options_.state_folder, kMostSceneBytes),
      // A loader serves one thread; the same folders give the same plugins.
      loader_(
          std::make_shared<PluginLoader>(loader ? loader->folders() : std::vector<std::string>())),
      catalog_(std::make_unique<dsl::LoaderCatalog>(loader_)),
      sources_(file_.folder()),
      builder_(file_.folder()) {
  offer_found();
  queue_->put([this] { compile(); });
  thread_ = std::thread([this] { work(); });
}

DocumentRequests::~DocumentRequests() {
  builder_.stop();
  finish();
  if (build_thread_.joinable()) build_thread_.join();
}

void DocumentRequests::work() {
  while (const auto task = queue_->take()) {
    task->work();
    // Of several changes in a row only the newest text is worth compiling.
    if (stale_ && !queue_->next_changes_text()) compile();
  }
}

const std::map<std::string_view, DocumentRequests::Handler>& DocumentRequests::table() {
  using D = DocumentRequests;
  static const std::map<std::string_view, Handler> handlers = {{"set-text", &D::set_text},
                                                               {"edit", &D::edit},
                                                               {"undo", &D::undo},
                                                               {"redo", &D::redo},
                                                               {"save", &D::save},
                                                               {"revert", &D::revert},
                                                               {"unsaved", &D::unsaved},
                                                               {"restore", &D::restore},
                                                               {"discard", &D::discard},
                                                               {"schema", &D::schema},
                                                               {"complete", &D::complete},
                                                               {"mass", &D::mass},
                                                               {"sources", &D::sources},
                                                               {"open-source", &D::open_source},
                                                               {"save-source", &D::save_source},
                                                               {"tests", &D::tests},
                                                               {"test-cancel", &D::cancel_test}};
  return handlers;
}

void DocumentRequests::handle(Request request, Reply reply) {
  const ClientId client = request.client;
  const Role role = request.role;
  DocumentQueue::Task task{request.what, {}};
  if (request.what == "complete") {
    // A user who keeps typing needs the completions at the present cursor.
    task.give_up = [reply] {
      reply(fail("the same was asked again before its turn came", "", "", "superseded"));
    };
  }
  task.work = [this, request = std::move(request), reply = std::move(reply)] {
    answer(request, reply);
  };
  queue_->put(client, role, std::move(task));
}

void DocumentRequests::answer(const Request& request, const Reply& reply) {
  if (request.what == "build") return build(request, reply);  // takes its time elsewhere
  if (request.what == "test") return test(request, reply);
  const std::uint64_t before = version_;
  Answer answer = (this->*table().at(request.what))(request);
  // An edit that was answered is on the disk.
  if (journal_due_) keep_unsaved();
  reply(std::move(answer));
  if (version_ == before) return;
  // What an edit left is compiled already.
  if (!stale_) {
    publish(document_json(false));
    publish(tree_topic());
    publish(problems_topic());
    show();
  } else if (compile_seconds_ > kNoticed && !queue_->next_changes_text()) {
    publish(document_json(true));
  }
}

void DocumentRequests::joined(ClientId client, Role role) {
  queue_->put(client, role, {"", [this, client] {
                              publish(document_json(stale_), client);
                              publish(unsaved_topic(), client);
                              if (stale_) return;
                              publish(tree_topic(), client);
                              publish(problems_topic(), client);
                            }});
}

void DocumentRequests::publish(const Json& json, std::optional<ClientId> client) {
  if (client)
    outbox_.send(*client, dump(json));
  else
    outbox_.send_all(dump(json));
}

// ---- compiling

dsl::CompileOptions DocumentRequests::compile_options() {
  dsl::CompileOptions options;
  options.set_parameters = options_.parameters;
  options.seed = options_.seed;
  options.plugins = catalog_.get();
  return options;
}

void DocumentRequests::changed(ClientId by) {
  ++version_;
  by_ = by;
  stale_ = true;
  journal_due_ = true;
}

void DocumentRequests::compile() {
  const auto start = std::chrono::steady_clock::now();
  take_in(dsl::compile_outlined(history_.text(), file_.path(), compile_options()));
  compile_seconds_ = cli::seconds_since(start);
  publish(document_json(false));
  publish(tree_topic());
  publish(problems_topic());
  show();
}

void DocumentRequests::take_in(dsl::OutlinedScene scene) {
  scene_ = std::move(scene);
  scene_version_ = version_;
  good_ = scene_.result.ok();
  refused_.clear();
  stale_ = false;
}

void DocumentRequests::show() {
  if (good_) {
    was_good_ = true;
    show(scene_);
  } else if (const auto rest = was_good_ ? std::nullopt : without_missing_plugins()) {
    show(*rest);
  }
}

void DocumentRequests::show(const dsl::OutlinedScene& from) {
  Scene scene;
  scene.model = from.result.model;
  scene.only_shown = !good_;
  scene.origins.version = version_;
  if (built_) scene.plugin_folders = loader_->folders();
  const auto take = [](const std::vector<dsl::Origin>& given, std::vector<Origins::Origin>& to) {
    for (const dsl::Origin& origin : given) to.push_back({origin.element, origin.own});
  };
  const dsl::ModelOrigins& origins = from.origins;
  take(origins.bodies, scene.origins.bodies);
  take(origins.assemblies, scene.origins.assemblies);
  take(origins.joints, scene.origins.joints);
  take(origins.motors, scene.origins.motors);
  take(origins.sensors, scene.origins.sensors);
  take(origins.controllers, scene.origins.controllers);
  take(origins.supervisors, scene.origins.supervisors);
  take(origins.lights, scene.origins.lights);
  take(origins.views, scene.origins.views);
  take(origins.regions, scene.origins.regions);
  take(origins.plots, scene.origins.plots);
  take(origins.forces, scene.origins.forces);
  run_.show(std::move(scene), [this, queue = queue_, version = version_](auto shown) {
    // Only the document's own thread, which lives as long as it takes tasks, uses `this`.
    queue->put([this, version, faults = shown ? std::vector<Diagnostic>() : shown.error()] {
      if (version != version_ || (faults.empty() && refused_.empty())) return;
      refused_ = faults;
      publish(problems_topic());
    });
  });
}

Json DocumentRequests::document_json(bool compiling) const {
  const auto label = [](const std::optional<std::string>& text) {
    return text ? Json(*text) : Json(nullptr);
  };
  return {{"topic", "document"},
          {"version", version_},
          {"text", history_.text()},
          {"file", file_.name()},
          {"dirty", dirty()},
          {"undo", label(history_.undo_label())},
          {"redo", label(history_.redo_label())},
          {"by", by_},
          {"good", good_},
          {"compiling", compiling}};
}

Json DocumentRequests::tree_topic() const {
  return {{"topic", "tree"}, {"version", scene_version_}, {"elements", tree_json(scene_.elements)}};
}

Json DocumentRequests::problems_topic() const {
  std::vector<Diagnostic> all = scene_.result.diagnostics;
  all.insert(all.end(), refused_.begin(), refused_.end());
  return {{"topic", "problems"},
          {"version", scene_version_},
          {"good", good_},
          {"problems", problems_json(all, file_.path())}};
}

// ---- requests about the text

Result<> DocumentRequests::check_version(const Request& request) const {
  if (request.fields.at("version").get<std::int64_t>() != static_cast<std::int64_t>(version_))
    return fail("the text has changed meanwhile", "", "take the newest text and try again",
                "stale");
  return {};
}

Answer DocumentRequests::set_text(const Request& request) {
  if (auto good = check_version(request); !good) return tl::unexpected(good.error());
  auto text = request.fields.at("text").get<std::string>();
  auto group = request.fields.value("group", "");
  if (text.size() > kMostSceneBytes)
    return fail("a scene's text has at most " + std::to_string(kMostSceneBytes >> 20) + " MB", "",
                "put large data into mesh files");
  // Typing of two clients makes two steps.
  if (!group.empty()) group += "/" + std::to_string(request.client);
  if (history_.change(with_line_ends_of(history_.text(), std::move(text)), "typing", group))
    changed(request.client);
  return Json{{"version", version_}};
}

Answer DocumentRequests::edit(const Request& request) {
  if (auto good = check_version(request); !good) return tl::unexpected(good.error());
  const auto label = request.fields.at("label").get<std::string>().substr(0, 200);
  auto made = dsl::edit_text(history_.text(), file_.path(),
                             operations_from(request.fields.at("ops")), compile_options());
  if (!made) return tl::unexpected(made.error());
  if (history_.change(std::move(made->text), label)) {
    changed(request.client);
    take_in(std::move(made->scene));
  }
  return Json{{"version", version_}, {"created", made->created}};
}

Answer DocumentRequests::undo(const Request& request) {
  const auto label = history_.undo();
  if (!label) return fail("there is nothing to undo");
  changed(request.client);
  return Json{{"version", version_}, {"label", *label}};
}

Answer DocumentRequests::redo(const Request& request) {
  const auto label = history_.redo();
  if (!label) return fail("there is nothing to redo");
  changed(request.client);
  return Json{{"version", version_}, {"label", *label}};
}

Answer DocumentRequests::save(const Request& request) {
  const auto name = request.fields.value("file", file_.name());
  if (name != file_.name()) {
    if (auto saved = file_.save_as(name, history_.text()); !saved)
      return tl::unexpected(saved.error());
    keep_unsaved();  // of the previous file
    journal_ = Journal(file_.path(), options_.state_folder, kMostSceneBytes);
    offer_found();
    publish(document_json(stale_));
    publish(unsaved_topic());
    return Json{{"file", file_.name()}, {"backup", ""}};
  }
  auto saved = file_.save(history_.text());
  if (!saved) return tl::unexpected(saved.error());
  journal_due_ = true;
  publish(document_json(stale_));
  return Json{{"file", file_.name()}, {"backup", *saved}};
}

Answer DocumentRequests::revert(const Request& request) {
  if (auto read = file_.reread(); !read) return tl::unexpected(read.error());
  journal_due_ = true;
  if (history_.change(*file_.text(), "revert"))
    changed(request.client);
  else
    publish(document_json(stale_));
  return Json{{"version", version_}, {"text", history_.text()}};
}

const Json& DocumentRequests::vocabulary() {
  if (!schema_) schema_ = Json::parse(dsl::write_schema_json(catalog_.get()));
  return *schema_;
}

Answer DocumentRequests::schema(const Request&) { return Json{{"schema", vocabulary()}}; }

Answer DocumentRequests::complete(const Request& request) {
  return complete_at(request.fields.at("text").get<std::string>(),
                     request.fields.at("offset").get<std::int64_t>(), vocabulary(),
                     scene_.elements);
}

Answer DocumentRequests::mass(const Request& request) {
  if (stale_ || !good_)
    return fail("there are masses only of a scene that compiles", "", "mend the text first");
  return mass_of(request.fields.at("elements").get<std::vector<int>>(), scene_);
}

// ---- sources and building

Answer DocumentRequests::sources(const Request&) { return sources_.list(); }

Answer DocumentRequests::open_source(const Request& request) {
  return sources_.open(request.fields.at("name").get<std::string>());
}

Answer DocumentRequests::save_source(const Request& request) {
  return sources_.save(request.fields.at("name").get<std::string>(),
                       request.fields.at("text").get<std::string>(),
                       fields::maybe<std::string>(request.fields, "version"));
}

Answer DocumentRequests::tests(const Request&) {
  if (stale_) compile();  // who asks is to get the tests of the newest text
  Json tests = Json::array();
  if (good_) {
    for (const TestModel& test : scene_.result.model->tests) {
      const auto agrees = std::count_if(
          test.expectations.begin(), test.expectations.end(),
          [](const ExpectationModel& e) { return e.kind == ExpectationModel::Kind::agree; });
      tests.push_back({{"name", test.name},
                       {"line", test.origin.line},
                       {"expectations", test.expectations.size() - std::size_t(agrees)},
                       {"agrees", agrees},
                       {"backends", test.backends}});
    }
  }
  return Json{{"version", scene_version_}, {"tests", std::move(tests)}};
}

void DocumentRequests::test(const Request& request, const Reply& reply) {
  if (auto good = check_version(request); !good) return reply(tl::unexpected(good.error()));
  if (stale_) compile();
  const auto index = request.fields.at("test").get<std::size_t>();
  if (!good_ || index >= scene_.result.model->tests.size())
    return reply(fail("there is no such test in the present text", "", "", "stale"));
  TestRequest asked;
  asked.file = file_.path();
  if (dirty() || !file_.text()) asked.text = history_.text();
  asked.index = index;
  asked.test = scene_.result.model->tests[index].name;
  asked.backends = request.fields.at("backends").get<std::vector<std::string>>();
  for (const std::string& name : asked.backends)
    if (auto good = check_plugin_name(name); !good) return reply(tl::unexpected(good.error()));
  asked.plugin_folders = loader_->folders();
  asked.parameters = options_.parameters;
  asked.seed = options_.seed;
  asked.without = options_.without;
  test_run_.start(std::move(asked), request.client, reply);
}

Answer DocumentRequests::cancel_test(const Request&) {
  test_run_.cancel();
  return Json::object();
}

void DocumentRequests::build(const Request& request, const Reply& reply) {
  if (!options_.allow_build)
    return reply(fail("nothing is built from the page", "", "start the studio with --allow-build",
                      "not-allowed"));
  if (building_) return reply(fail("a build is running already", "", "wait for its end", "busy"));
  if (build_thread_.joinable()) build_thread_.join();
  building_ = true;
  const bool debug = request.fields.at("debug").get<bool>();
  build_thread_ = std::thread([this, queue = queue_, client = request.client, debug, reply] {
    // The scene can be edited meanwhile; what was built is taken over on the document's own thread.
    auto built = std::make_shared<Result<Builder::Built>>(builder_.build(debug));
    const bool taken = queue->put([this, built, client, reply] {
      building_ = false;
      reply(use_built(std::move(*built), client));
    });
    if (!taken) reply(fail("the studio ends"));
  });
}

Answer DocumentRequests::use_built(Result<Builder::Built> built, ClientId client) {
  if (!built) return tl::unexpected(built.error());
  const Json answer{{"built", built->ok}, {"log", built->log}, {"problems", built->problems}};
  if (!built->ok) return answer;
  // New libraries come first; running controllers keep the old ones mapped until they are replaced.
  std::vector<std::string> folders{built->plugins};
  for (const std::string& folder : loader_->folders())
    if (folder.find(builder_.mark()) == std::string::npos) folders.push_back(folder);
  loader_ = std::make_shared<PluginLoader>(folders);
  catalog_ = std::make_unique<dsl::LoaderCatalog>(loader_);
  schema_.reset();
  built_ = true;
  changed(client);  // the plugins' descriptions may have changed
  return answer;
}

}  // namespace cogrsim::studio
