// What runs and recordings have in common: answers to those who only look.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cameras.h"
#include "run.h"
#include "run_board.h"
#include "run_scenes.h"
#include "run_viewers.h"
#include "run_worker.h"
#include "series.h"

namespace cogrsim::studio {

class Desk {
 public:
  Desk(Frames& frames, Scenes& scenes, Board& board, Outbox& outbox,
       const std::vector<std::string>& plugin_folders);
  ~Desk();
  /// Nothing is answered any more; to be called before what it looks at goes.
  void stop();

  /// Who may ask what of a run; a recording, too, knows what steers a run, and says why it does not.
  static Part::Access access(std::string_view what);
  static bool answers(std::string_view what);
  void handle(const Request& request, const Reply& reply);
  Viewers& viewers() { return viewers_; }
  void left(ClientId client);
  /// To be done by and by, away from everybody who waits.
  void post(std::function<void()> job) { worker_.post(0, Role::operator_, std::move(job)); }

 private:
  Answer look(const Request& request);
  Answer paths(const Json& fields) const;
  Answer compute(const std::string& what, const Json& fields);

  Frames& frames_;
  Board& board_;
  SeriesDesk series_;  ///< the worker's
  Viewers viewers_;
  Cameras cameras_;
  Worker worker_;
};

}  // namespace cogrsim::studio
