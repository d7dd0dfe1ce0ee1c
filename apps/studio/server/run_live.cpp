// A run that is simulated now.
#include <algorithm>
#include <atomic>

#include "engine.h"
#include "run_fields.h"
#include "run_requests.h"

namespace cogrsim::studio {

namespace {

class LiveRun final : public Run {
 public:
  LiveRun(RunOptions options, const PluginLoader& loader, Outbox& outbox)
      : history_(options.history_bytes),
        requests_(history_, scenes_, publisher_, outbox, loader.folders()),
        engine_(std::move(options), loader.folders(), history_, scenes_, publisher_,
                [this] { requests_.viewers().follow_all(); }) {}

  ~LiveRun() override { requests_.stop(); }

  bool answers(Section section) const override {
    return section == Section::run || section == Section::numbers;
  }

  void handle(Request request, Reply reply) override {
    if (RequestHandler::answers(request.what)) return requests_.handle(request, reply);
    if (auto done = steer(request, reply); !done) reply(tl::unexpected(done.error()));
  }

  void joined(ClientId client, Role) override { requests_.viewers().joined(client); }
  void left(ClientId client) override {
    requests_.left(client);
    engine_.post([this, client] { static_cast<void>(engine_.release(client)); });
  }

  void show(Scene scene, ShowDone done) override {
    engine_.post(
        [this, number = ++shows_, scene = std::move(scene), done = std::move(done)]() mutable {
          if (number != shows_) {  // there is a newer one already
            if (done) done({});
            return;
          }
          auto shown = engine_.show(std::move(scene));
          refused_ = engine_.has_refused() ? done : nullptr;
          if (done) done(std::move(shown));
        });
  }

  std::string finish() override { return engine_.finish(); }

  void watch_processes(ProcessListener changed) override {
    engine_.watch_processes(std::move(changed));
  }
  void ask_processes() override { engine_.ask_processes(); }
  std::optional<HeldCall> held_call(const std::string& controller) override {
    return engine_.held_call(controller);
  }

  std::string asset(std::size_t number) const override { return scenes_.asset(number); }

 private:
  /// Passes requests for the engine on; they are answered there. Errors: a field is wrong.
  Result<> steer(const Request& request, const Reply& reply) {
    const Json& f = request.fields;
    const std::string& what = request.what;
    const auto answer = [&](auto act) {
      engine_.post([this, act, reply] { reply(act(engine_)); });
    };
    if (what == "play") {
      answer([](Engine& e) { return e.play(); });
    } else if (what == "pause") {
      engine_.pause(reply);
    } else if (what == "stop" || what == "restart") {
      engine_.post_ending([this, play = what == "restart", reply] { reply(engine_.stop(play)); });
    } else if (what == "end-controller") {
      reply(engine_.end_controller());
    } else if (what == "compare-off") {
      answer([](Engine& e) { return e.end_compare(); });
    } else if (what == "step") {
      engine_.post(
          [this, n = f.at("count").get<std::int64_t>(), reply] { engine_.step(n, reply); });
    } else if (what == "speed") {
      answer([v = fields::maybe<double>(f, "factor")](Engine& e) { return e.set_speed(v); });
    } else if (what == "dt") {
      answer([v = fields::maybe<double>(f, "value")](Engine& e) { return e.set_step(v); });
    } else if (what == "backend") {
      const auto name = f.at("name").get<std::string>();
      if (auto good = check_plugin_name(name); !good) return good;
      answer(
          [this, name, without = fields::maybe<std::vector<std::string>>(f, "without")](Engine& e) {
            Answer done = e.set_backend(name, without);
            if (done && !e.has_refused() && refused_) std::exchange(refused_, nullptr)({});
            return done;
          });
    } else if (what == "lacking") {
      const auto name = f.at("name").get<std::string>();
      if (auto good = name.empty() ? Result<>() : check_plugin_name(name); !good) return good;
      const bool beside = fields::maybe<bool>(f, "beside").value_or(false);
      answer([name, beside](Engine& e) { return e.lacking(name, beside); });
    } else if (what == "motor") {
      answer([name = f.at("motor").get<std::string>(), target = f.at("target").get<double>()](
                 Engine& e) { return e.set_motor(name, target); });
    } else if (what == "input") {
      answer([controller = f.at("controller").get<std::string>(),
              input = f.at("input").get<std::string>(), value = f.at("value").get<double>()](
                 Engine& e) { return e.set_input(controller, input, value); });
    } else if (what == "grab") {
      GrabRequest grab;
      grab.body = f.at("body").get<std::string>();
      grab.point = vector(f.at("point"));
      grab.target = vector(f.at("target"));
      grab.stiffness = fields::maybe<double>(f, "stiffness");
      answer([grab, client = request.client](Engine& e) { return e.grab(client, grab); });
    } else if (what == "grab-move") {
      answer([to = vector(f.at("target")), client = request.client](Engine& e) {
        return e.move_grab(client, to);
      });
    } else if (what == "release") {
      answer([client = request.client](Engine& e) { return e.release(client); });
    } else if (what == "repeat") {
      engine_.post_ending([this, reply] { reply(engine_.repeat()); });
    } else if (what == "reload") {
      answer([c = fields::maybe<std::string>(f, "controller")](Engine& e) { return e.reload(c); });
    } else if (what == "record") {
      answer([on = f.at("on").get<bool>(), file = fields::maybe<std::string>(f, "file")](
                 Engine& e) { return e.record(on, file); });
    } else if (what == "compare") {
      const auto name = fields::maybe<std::string>(f, "backend");
      if (name) {
        if (auto good = check_plugin_name(*name); !good) return good;
      }
      answer([w = CompareRequest{name, fields::maybe<double>(f, "step")},
              without = fields::maybe<std::vector<std::string>>(f, "without")](Engine& e) {
        return e.compare(w, without);
      });
    } else {
      return fail("the run does not answer '" + what + "'");
    }
    return {};
  }

  static Vec3 vector(const Json& v) {
    return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
  }
  std::atomic<std::uint64_t> shows_{0};  ///< asked for
  ShowDone refused_;                     ///< of the newest scene, if it was; on the engine's thread
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
