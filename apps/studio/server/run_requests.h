// What runs and recordings have in common: answers to requests that only read.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cameras.h"
#include "run.h"
#include "run_status.h"
#include "run_scenes.h"
#include "run_viewers.h"
#include "run_worker.h"
#include "series.h"

namespace cogrsim::studio {

class RequestHandler {
 public:
  RequestHandler(Frames& frames, Scenes& scenes, StatusPublisher& publisher, Outbox& outbox,
       const std::vector<std::string>& plugin_folders);
  ~RequestHandler();
  /// Nothing is answered any more; to be called before the data it reads is destroyed.
  void stop();

  /// Requests of a run that only read.
  static bool answers(std::string_view what);
  void handle(const Request& request, const Reply& reply);
  Viewers& viewers() { return viewers_; }
  void left(ClientId client);
  /// Work for the background, which delays no request.
  void post(std::function<void()> job) { worker_.post(0, Role::operator_, std::move(job)); }

 private:
  struct Entry {
    Answer (RequestHandler::*handler)(const Request&);
    bool at_once;  ///< else in a thread of its own
  };
  static const std::map<std::string_view, Entry>& table();
  Answer seek(const Request& request);
  Answer step_back(const Request& request);
  Answer live(const Request& request);
  Answer subscribe(const Request& request);
  Answer events(const Request& request);
  Answer paths(const Request& request);
  Answer divergence(const Request& request);
  Answer cameras(const Request& request) { return cameras_.show(request.client, request.fields); }
  Answer view(const Request& request) { return cameras_.view(request.client, request.fields); }
  Answer signals(const Request&) { return series_.signals(); }
  Answer series(const Request& request) { return series_.series(request.fields); }
  Answer plots(const Request&) { return series_.plots(); }
  Answer figure(const Request& request) { return series_.figure(request.fields); }

  Frames& frames_;
  StatusPublisher& publisher_;
  SeriesRequests series_;  ///< the worker's
  Viewers viewers_;
  Cameras cameras_;
  Worker worker_;
};

}  // namespace cogrsim::studio
