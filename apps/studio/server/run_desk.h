// What runs and recordings have in common: answers to those who only look.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "run.h"
#include "run_board.h"
#include "run_scenes.h"
#include "run_viewers.h"
#include "run_worker.h"

namespace cogrsim::studio {

class Desk {
 public:
  Desk(Frames& frames, Scenes& scenes, Board& board, Outbox& outbox,
       std::vector<std::string> plugin_folders, std::string kind, std::string file);
  ~Desk();
  /// Nothing is answered any more; to be called before what it looks at goes.
  void stop();

  static bool answers(std::string_view what);
  void handle(const Request& request, const Reply& reply);
  Viewers& viewers() { return viewers_; }

 private:
  void hello(const Request& request, const Reply& reply);
  Answer look(const Request& request);

  Frames& frames_;
  Scenes& scenes_;
  Board& board_;
  const std::vector<std::string> plugin_folders_;
  const std::string kind_, file_;
  std::vector<std::string> backends_;  ///< the worker's
  Viewers viewers_;
  Worker worker_;
};

}  // namespace cogrsim::studio
