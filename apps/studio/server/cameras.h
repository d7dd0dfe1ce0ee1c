// Live pictures: what cameras see at the instant that each client views, in a thread of its own.
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cogrsim/plugin/loader.h"
#include "cogrsim/rendering/renderer.h"
#include "run_viewers.h"
#include "talk.h"

namespace cogrsim::studio {

class Cameras {
 public:
  Cameras(Viewers& viewers, Scenes& scenes, Outbox& outbox,
          std::vector<std::string> plugin_folders);
  ~Cameras() { stop(); }
  void stop();

  /// The requests `cameras` and `view`.
  Answer show(ClientId client, const Json& fields);
  Answer view(ClientId client, const Json& fields);
  void left(ClientId client);

  /// Pictures rendered so far.
  std::size_t rendered() const { return rendered_.load(); }

 private:
  enum class Kind { color, depth, segmentation };
  struct Wish {
    std::string name;  ///< of a sensor or a saved view; "": the whole scene
    Kind kind = Kind::color;
    int width = 320, height = 240;
    std::optional<Pose> pose;  ///< of the whole scene; empty: from where all is seen
    double fov = 0.8;          ///< [rad]
    bool once = false;
    FramePtr drawn;  ///< what was sent last
  };
  struct Job {
    ClientId client;
    std::size_t wish;
    Wish what;
    Instant instant;
  };

  void run();
  std::optional<Job> next_job();
  Result<Bytes> draw(const Job& job);
  Result<RenderRequest> request_of(const Wish& wish, const Frame& frame) const;

  Viewers& viewers_;
  Scenes& scenes_;
  Outbox& outbox_;
  const std::vector<std::string> plugin_folders_;
  std::shared_ptr<Renderer> renderer_;  ///< the thread's
  std::string problem_;                 ///< why there is none
  std::atomic<std::size_t> rendered_{0};

  std::mutex mutex_;
  std::condition_variable waiting_;
  std::map<ClientId, std::vector<Wish>> wishes_;
  std::map<ClientId, std::size_t> turns_;  ///< index of the next request of a client
  bool over_ = false;
  std::thread thread_;
};

}  // namespace cogrsim::studio
