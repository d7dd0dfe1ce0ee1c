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

  /// Access to the requests of a run; a recording, too, knows those that steer a run, and refuses
  /// them with a reason.
  static Part::Access access(std::string_view what);
  static bool answers(std::string_view what);
  void handle(const Request& request, const Reply& reply);
  Viewers& viewers() { return viewers_; }
  void left(ClientId client);
  /// Work for the background, which delays no request.
  void post(std::function<void()> job) { worker_.post(0, Role::operator_, std::move(job)); }

 private:
  Answer look(const Request& request);
  Answer paths(const Json& fields) const;
  Answer compute(const std::string& what, const Json& fields);

  Frames& frames_;
  StatusPublisher& publisher_;
  SeriesRequests series_;  ///< the worker's
  Viewers viewers_;
  Cameras cameras_;
  Worker worker_;
};

}  // namespace cogrsim::studio
