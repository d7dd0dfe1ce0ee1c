// The process of an adapter, and the frames between it and this one.
//
// A frame is a head of 16 bytes and a content: the number 0x53524743 ("CGRS"), the kind of the frame
// (both 32 bits) and the length of the content [byte] (64 bits), little-endian. The content is a JSON
// text or an array of 64-bit floating-point numbers. Each request has one answer, of the same kind or
// an error. docs/plugins/backends-in-any-language.md lists them.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "plugin/adapter_manifest.h"
#include "process/watched_process.h"

namespace cogrsim {

enum class AdapterCall : std::uint32_t {
  hello = 1,
  provenance,
  scene,
  build,
  step,
  report,
  write,
  save,
  restore,
  free,
  error = 255
};

/// Why an exchange has no answer.
struct AdapterFault {
  enum class Kind {
    refused,   ///< the adapter cannot do it, and goes on
    diverged,  ///< a step: the state has left all bounds
    broken     ///< its code threw, its process ended, hung or sent nonsense; it was killed
  } kind = Kind::broken;
  std::string message;
  int body = -1;  ///< diverged
};
template <class T = void>
using AdapterResult = tl::expected<T, AdapterFault>;

class AdapterProcess {
 public:
  /// Starts the program of a manifest. Errors: those of the system.
  static Result<std::unique_ptr<AdapterProcess>> start(
      std::shared_ptr<const AdapterManifest> manifest);
  ~AdapterProcess();
  AdapterProcess(const AdapterProcess&) = delete;
  AdapterProcess& operator=(const AdapterProcess&) = delete;

  /// The content of the next request, to be filled in; room for its head comes before it.
  std::vector<char>& request();
  void put_text(const std::string& text);
  void put(double value) { put(&value, 1); }
  void put(const double* values, std::size_t count);

  /// Sends the request and waits for its answer, at most the patience of the manifest. `time`:
  /// simulated [s], NaN: none. After a broken one the process has ended.
  AdapterResult<> exchange(AdapterCall call, double time);
  /// The content of the last answer.
  const std::vector<char>& answer() const { return answer_; }
  /// The same as numbers. Their count is that of whole numbers in it.
  const double* numbers() const { return reinterpret_cast<const double*>(answer_.data()); }
  std::size_t number_count() const { return answer_.size() / sizeof(double); }
  /// What the last answer should have been: kills the process.
  AdapterFault nonsense(AdapterCall call, const std::string& what);

  bool alive() const { return process_ && process_->alive(); }
  /// False in a fork of the process that has started it.
  bool is_own() const;
  const AdapterManifest& manifest() const { return *manifest_; }
  double patience() const { return patience_; }

 private:
  using Clock = std::chrono::steady_clock;
  enum class Wait { ready, ended, late };

  explicit AdapterProcess(std::shared_ptr<const AdapterManifest> manifest);
  Wait await(short event, Clock::time_point until);
  Wait send(Clock::time_point until);
  Wait receive(char* to, std::size_t count, Clock::time_point until);
  AdapterResult<> lost(AdapterCall call, Wait why);
  AdapterFault broken(AdapterCall call, const std::string& what);
  AdapterFault refusal_in_answer(AdapterCall call);
  void drain();

  std::shared_ptr<const AdapterManifest> manifest_;
  std::unique_ptr<WatchedProcess> process_;
  pid_t owner_;
  int channel_ = -1, output_ = -1;
  double patience_;
  bool shows_output_;
  std::vector<char> request_, answer_;
  std::string last_output_;  // its end
};

/// "while it was built", "in a step".
const char* during(AdapterCall call);

}  // namespace cogrsim
