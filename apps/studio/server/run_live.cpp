// A run that is simulated now.
#include <algorithm>
#include <atomic>

#include "engine.h"
#include "run_requests.h"
#include "run_fields.h"

namespace cogrsim::studio {

namespace {

constexpr double kSlowest = 0.01, kFastest = 1000.0;
constexpr std::int64_t kMostSteps = 10'000;

class LiveRun final : public Run {
 public:
  LiveRun(RunOptions options, const PluginLoader& loader, Outbox& outbox)
      : history_(options.history_bytes),
        requests_(history_, scenes_, publisher_, outbox, loader.folders()),
        engine_(std::move(options), loader.folders(), history_, scenes_, publisher_,
                [this] { requests_.viewers().follow_all(); }) {}

  ~LiveRun() override { requests_.stop(); }

  Access access(std::string_view what) const override { return RequestHandler::access(what); }

  void handle(Request request, Reply reply) override {
    if (RequestHandler::answers(request.what)) return requests_.handle(request, reply);
    if (auto done = steer(request, reply); !done) reply(tl::unexpected(done.error()));
  }

  void joined(ClientId client, Role) override { requests_.viewers().joined(client); }
  void left(ClientId client) override { requests_.left(client); }

  void show(Scene scene,
            std::function<void(tl::expected<std::vector<std::string>, std::vector<Diagnostic>>)>
                done) override {
    engine_.post(
        [this, number = ++shows_, scene = std::move(scene), done = std::move(done)]() mutable {
          if (number != shows_) {  // there is a newer one already
            if (done) done({});
            return;
          }
          auto shown = engine_.show(std::move(scene));
          if (done) done(std::move(shown));
        });
  }

  std::string finish() override { return engine_.finish(); }

  std::string asset(std::size_t number) const override { return scenes_.asset(number); }

 private:
  /// Passes requests for the engine on; they are answered there. Errors: a field is wrong.
  Result<> steer(const Request& request, const Reply& reply) {
    const Json& f = request.fields;
    const std::string& what = request.what;
    const auto answer = [&](auto act) {
      engine_.post([this, act, reply] { reply(act(engine_)); });
    };
    if (what == "play") answer([](Engine& e) { return e.play(); });
    if (what == "pause") engine_.pause(reply);
    if (what == "stop" || what == "restart") {
      engine_.post_ending([this, play = what == "restart", reply] { reply(engine_.stop(play)); });
    }
    if (what == "end-controller") reply(engine_.end_controller());
    if (what == "compare-off") answer([](Engine& e) { return e.end_compare(); });
    if (what == "step") {
      const auto count = fields::whole(f, "count", 1, 1, kMostSteps);
      if (!count) return tl::unexpected(count.error());
      engine_.post([this, n = *count, reply] { engine_.step(n, reply); });
    } else if (what == "speed") {
      const auto factor = fields::maybe_number(f, "factor");
      if (!factor) return tl::unexpected(factor.error());
      if (*factor && (**factor < kSlowest || **factor > kFastest)) {
        return fields::wrong("factor", "from 0.01 to 1000, or null: as fast as possible");
      }
      answer([v = *factor](Engine& e) { return e.set_speed(v); });
    } else if (what == "dt") {
      const auto value = step_field(f, "value");
      if (!value) return tl::unexpected(value.error());
      answer([v = *value](Engine& e) { return e.set_step(v); });
    } else if (what == "backend") {
      const auto name = fields::text(f, "name");
      if (!name) return tl::unexpected(name.error());
      if (auto good = plugin_name(*name); !good) return good;
      answer([v = *name](Engine& e) { return e.set_backend(v); });
    } else if (what == "reload") {
      const auto controller = fields::maybe_text(f, "controller");
      if (!controller) return tl::unexpected(controller.error());
      answer([c = *controller](Engine& e) { return e.reload(c); });
    } else if (what == "record") {
      const auto on = fields::truth(f, "on", true);
      const auto file = fields::maybe_text(f, "file");
      if (!on) return tl::unexpected(on.error());
      if (!file) return tl::unexpected(file.error());
      answer([a = *on, b = *file](Engine& e) { return e.record(a, b); });
    } else if (what == "compare") {
      const auto name = fields::maybe_text(f, "backend");
      const auto step = step_field(f, "step");
      if (!name) return tl::unexpected(name.error());
      if (!step) return tl::unexpected(step.error());
      if (*name) {
        if (auto good = plugin_name(**name); !good) return good;
      }
      answer([w = CompareWish{*name, *step}](Engine& e) { return e.compare(w); });
    }
    return {};
  }

  static Result<std::optional<double>> step_field(const Json& f, const char* key) {
    auto value = fields::maybe_number(f, key);
    if (value && *value && !(**value > 0.0 && **value <= 1.0)) {
      return fields::wrong(key, "above 0 s and at most 1 s, or null");
    }
    return value;
  }

  /// A name, never a path.
  static Result<> plugin_name(const std::string& name) {
    const bool plain = !name.empty() && name.size() <= 100 &&
                       std::all_of(name.begin(), name.end(), [](unsigned char c) {
                         return std::isalnum(c) != 0 || c == '_' || c == '-';
                       });
    if (!plain) return fields::wrong("name", "the name of a backend");
    return {};
  }

  std::atomic<std::uint64_t> shows_{0};  ///< asked for
  Scenes scenes_;
  StatusPublisher publisher_;
  History history_;
  RequestHandler requests_;
  Engine engine_;
};

}  // namespace

std::unique_ptr<Run> Run::of_scene(RunOptions options, std::shared_ptr<PluginLoader> loader,
                                   Outbox& outbox) {
  return std::make_unique<LiveRun>(std::move(options), *loader, outbox);
}

}  // namespace cogrsim::studio
