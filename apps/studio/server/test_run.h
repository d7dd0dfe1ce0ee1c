// Runs a test of the scene's present text, as `cogrsim test` does: in a process of its own.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

struct TestRequest {
  std::string file;  ///< the scene's
  /// What is to be tested, where it is not what the file holds. It is put beside the file, whose folder
  /// it may import from, for as long as the test runs.
  std::optional<std::string> text;
  std::size_t index = 0;  ///< of the test in its scene
  std::string test;       ///< its name
  std::vector<std::string> backends, plugin_folders, without;
  std::map<std::string, std::string> parameters;
  std::optional<std::uint64_t> seed;
};

class TestRun {
 public:
  ~TestRun();
  /// One at a time. The reply is called when it is over, from a thread of its own.
  void start(TestRequest request, ClientId client, Reply reply);
  /// Ends the test that this client has started: nobody waits for it any more.
  void left(ClientId client);
  /// Ends the test that runs, whose reply says so.
  void cancel() noexcept { cancelled_ = true; }

 private:
  Answer run(const TestRequest& request);
  Answer safely(const TestRequest& request);

  std::mutex mutex_;
  ClientId client_ = 0;  ///< that started it
  std::thread thread_;
  std::atomic<bool> running_{false}, cancelled_{false};
};

}  // namespace cogrsim::studio
