#include "studio.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>

#include <fmt/format.h>

#include "protocol.h"
#include "run_worker.h"

namespace cogrsim::studio {
namespace {

std::string dumped(const Json& message) {
  // Logs and names may hold bytes that are no UTF-8.
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json refused(const Error& error) {
  Json out = {{"message", error.message}};
  if (!error.hint.empty()) out["help"] = error.hint;
  if (!error.where.empty()) out["where"] = error.where;
  if (!error.file.empty()) {
    out["file"] = error.file;
    out["line"] = error.line;
    out["column"] = error.column;
    out["length"] = error.length;
  }
  if (!error.code.empty()) out["code"] = error.code;
  return out;
}

}  // namespace

struct Studio::Impl : std::enable_shared_from_this<Impl> {
  StudioInfo info;
  std::vector<Part*> parts;
  std::function<std::string(std::size_t)> find_asset;
  Outbox& outbox;
  Limits limits;

  struct Event {
    enum class Kind { joined, left, received } kind = Kind::received;
    ClientId client = 0;
    Role role = Role::viewer;
    std::string text;
  };
  std::mutex mutex;  // guards what follows
  struct Load {
    Role role = Role::viewer;
    std::size_t requests = 0, bytes = 0;
  };
  std::map<ClientId, Load> loads;  // of the present clients
  bool ending = false;

  // Used on the dispatcher's thread only.
  struct Client {
    Role role = Role::viewer;
    bool greeted = false;
  };
  std::map<ClientId, Client> clients;
  Worker dispatcher;

  Impl(StudioInfo about, std::vector<Part*> all, std::function<std::string(std::size_t)> assets,
       Outbox& out, Limits bounds)
      : info(std::move(about)),
        parts(std::move(all)),
        find_asset(std::move(assets)),
        outbox(out),
        limits(bounds) {}

  void put(Event event) {
    const ClientId client = event.client;
    const Role role = event.role;
    dispatcher.post(client, role,
                    [this, event = std::move(event)]() mutable { take(std::move(event)); });
  }

  void take(Event event) {
    switch (event.kind) {
      case Event::Kind::joined:
        clients[event.client] = {event.role, false};
        break;
      case Event::Kind::left: {
        const auto found = clients.find(event.client);
        if (found == clients.end()) break;
        const bool greeted = found->second.greeted;
        clients.erase(found);
        if (!greeted) break;
        for (Part* part : parts) part->left(event.client);
        break;
      }
      case Event::Kind::received: {
        const auto found = clients.find(event.client);
        if (found != clients.end()) take(event.client, found->second, std::move(event.text));
        break;
      }
    }
  }

  // One request, until it is answered: exactly once, at the latest by its destructor.
  class Pending {
   public:
    Pending(std::shared_ptr<Impl> studio, ClientId client, Json id, std::size_t bytes)
        : studio_(std::move(studio)), client_(client), id_(std::move(id)), bytes_(bytes) {}
    Pending(const Pending&) = delete;
    Pending& operator=(const Pending&) = delete;
    ~Pending() {
      if (!answered_) answer(fail("the request was given up"));
    }

    void answer(Answer answer) {
      if (answered_.exchange(true)) return;
      Json reply;
      if (answer) {
        reply = answer->is_object() ? std::move(*answer) : Json::object();
        reply["ok"] = true;
      } else {
        reply["ok"] = false;
        reply["error"] = refused(answer.error());
      }
      reply["id"] = id_;
      studio_->done(client_, bytes_);
      studio_->send(client_, reply);
    }

   private:
    std::shared_ptr<Impl> studio_;
    ClientId client_;
    Json id_;
    std::size_t bytes_;
    std::atomic<bool> answered_{false};
  };

  void done(ClientId client, std::size_t bytes) {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto load = loads.find(client);
    if (load == loads.end()) return;
    --load->second.requests;
    load->second.bytes -= bytes;
  }

  void send(ClientId client, const Json& message) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      if (ending) return;
    }
    outbox.send(client, dumped(message));
  }

  void take(ClientId client, Client& about, std::string text) {
    const std::size_t bytes = text.size();
    Json fields;
    Result<void> good = tl::unexpected<Error>(Error("the request is not well-formed JSON"));
    if (const std::string excess = json_excess(text, limits.json); !excess.empty()) {
      good = fail("the request " + excess);
    } else {
      fields = Json::parse(text, nullptr, false);
      if (!fields.is_discarded()) good = {};
    }
    text = std::string();
    Json id;
    if (good && !fields.is_object()) good = fail("a request is an object");
    if (good) {
      const auto found = fields.find("id");
      if (found == fields.end() || !found->is_number_integer()) {
        good = fail("the request's 'id' is missing or no whole number");
      } else {
        id = *found;
      }
    }
    std::string what;
    if (good) {
      const auto found = fields.find("do");
      if (found == fields.end() || !found->is_string()) {
        good = fail("the request's 'do' is missing or no text");
      } else {
        what = found->get<std::string>();
      }
    }
    const auto pending = std::make_shared<Pending>(shared_from_this(), client, id, bytes);
    if (!good) return pending->answer(tl::unexpected<Error>(good.error()));
    handle({client, about.role, std::move(what), std::move(fields)}, about, pending);
  }

  void handle(Request request, Client& about, const std::shared_ptr<Pending>& pending) {
    if (request.what == "hello") return hello(request, about, *pending);
    if (!about.greeted) return pending->answer(fail("say hello first"));
    const ProtocolRequest* const known = find_request(request.what);
    if (!known) return pending->answer(tl::unexpected(unknown_request(request.what)));
    const auto responsible = std::find_if(parts.begin(), parts.end(), [&](const Part* part) {
      return part->answers(known->section);
    });
    if (responsible == parts.end()) {
      return pending->answer(
          fail(fmt::format("'{}' is not there for a {}", request.what, info.kind)));
    }
    if (!known->viewers && request.role != Role::operator_) {
      return pending->answer(fail(fmt::format("'{}' is not for viewers", request.what), "",
                                  "open the address that the studio printed for its operator",
                                  "viewer"));
    }
    if (auto good = check_fields(*known, request.fields); !good)
      return pending->answer(tl::unexpected(good.error()));
    const std::string what = request.what;
    try {
      (*responsible)->handle(std::move(request), [pending](Answer answer) {
        pending->answer(std::move(answer));
      });
    } catch (const std::exception& e) {
      pending->answer(fail(fmt::format("'{}' failed: {}", what, message_of(e))));
    }
  }

  void hello(const Request& request, Client& about, Pending& pending) {
    Json backends = Json::array();
    for (const std::string& name : info.backends) backends.push_back(name);
    pending.answer(Json{{"protocol", kProtocol},
                        {"role", request.role == Role::operator_ ? "operator" : "viewer"},
                        {"client", request.client},
                        {"version", info.version},
                        {"kind", info.kind},
                        {"file", info.file},
                        {"allow_build", info.allow_build},
                        {"assets", info.assets},
                        {"backends", std::move(backends)}});
    if (about.greeted) return;
    about.greeted = true;
    for (Part* part : parts) part->joined(request.client, request.role);
  }
};

Studio::Studio(StudioInfo info, std::vector<Part*> parts,
               std::function<std::string(std::size_t)> asset, Outbox& outbox, Limits limits)
    : impl_(std::make_shared<Impl>(std::move(info), std::move(parts), std::move(asset), outbox,
                                   limits)) {}

Studio::Studio(StudioInfo info, std::vector<Part*> parts,
               std::function<std::string(std::size_t)> asset, Outbox& outbox)
    : Studio(std::move(info), std::move(parts), std::move(asset), outbox, Limits()) {}

Studio::~Studio() {
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->ending = true;
  }
  impl_->dispatcher.stop();
}

void Studio::joined(ClientId client, Role role) {
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->loads[client] = {role};
  }
  impl_->put({Impl::Event::Kind::joined, client, role, {}});
}

void Studio::left(ClientId client) {
  Role role = Role::viewer;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    const auto load = impl_->loads.find(client);
    if (load == impl_->loads.end()) return;
    role = load->second.role;
    impl_->loads.erase(load);
    // The answers are not needed, and a client that reconnects may send as many requests as before.
    impl_->dispatcher.forget_viewer(client);
  }
  impl_->put({Impl::Event::Kind::left, client, role, {}});
}

void Studio::received(ClientId client, std::string text) {
  bool busy = false;
  Role role = Role::viewer;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    const auto load = impl_->loads.find(client);
    if (load == impl_->loads.end()) return;
    role = load->second.role;
    busy = load->second.requests >= impl_->limits.requests ||
           (load->second.requests > 0 && load->second.bytes + text.size() > impl_->limits.bytes);
    if (!busy) {
      ++load->second.requests;
      load->second.bytes += text.size();
    }
  }
  if (!busy) return impl_->put({Impl::Event::Kind::received, client, role, std::move(text)});
  // Its id, if it is short enough to be read here: the network waits meanwhile.
  Json id;
  if (text.size() <= 4096 && json_excess(text, impl_->limits.json).empty()) {
    const Json fields = Json::parse(text, nullptr, false);
    if (fields.is_object() && fields.contains("id") && fields["id"].is_number_integer()) {
      id = fields["id"];
    }
  }
  impl_->send(client, {{"id", id},
                       {"ok", false},
                       {"error", refused(Error("too many requests wait for their answers", "",
                                               "wait for some of them", "busy"))}});
}

std::string Studio::asset(std::size_t number) { return impl_->find_asset(number); }

}  // namespace cogrsim::studio
