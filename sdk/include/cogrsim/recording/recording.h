// Runs on file: what happened, to be looked at again. The format is MCAP (mcap.dev); the topics and
// their schemas are described in docs/recording.md.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/output_file.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/sensing/sensor.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim {

/// A file that stands by itself: the scene, an import of it.
struct Attachment {
  std::string name;        ///< relative to the scene's folder
  std::string media_type;  ///< "application/xml"
  std::string data;
};

struct RecorderOptions {
  std::string path;    ///< of the file; an older recording is replaced if nobody writes it
  OutputRules rules;   ///< what may be replaced
  double every = 0.0;  ///< time between frames kept [s]; 0: every step
  bool contacts = true;
  bool images = true;
  bool jpeg = false;  ///< colour pictures as JPEG, else PNG
  /// Frames wait in memory for the disk up to this much; what comes beyond is left out, counted and
  /// told, never waited for [byte].
  std::size_t queue_limit = 512u << 20;
  std::vector<Attachment> attachments;            ///< the scene and all it imports
  std::map<std::string, std::string> parameters;  ///< `--set`, for the record
};

/// Writes a run while it goes on, from a thread of its own: a step never waits for the disk. Attach
/// it before the first step. What is on disk can be read at any time: chunks are whole, a killed
/// process loses the last one at most.
class COGRSIM_API Recorder {
 public:
  /// Errors: the file cannot be written, or another recorder (of this or another process) writes
  /// it.
  static Result<std::unique_ptr<Recorder>> start(Simulation& simulation, RecorderOptions options);
  ~Recorder();  ///< finishes without a word; call finish() to hear of errors

  /// Writes what waits, the index and the end. Errors: the disk was full or went away, or frames
  /// were left out; the message says how much of the run is on file. To be called once.
  Result<> finish(RunStatus status);

  /// What went wrong so far, empty: nothing. From any thread.
  std::string problem() const;

 private:
  struct Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

struct RecordingInfo {
  std::string scene, backend, engine_version, library_version;
  std::optional<Provenance> provenance;  ///< empty: the recording does not say
  std::string status;                    ///< how the run ended; empty: it was cut off
  std::uint64_t seed = 0;
  double step = 0.0;              ///< [s]
  double start = 0.0, end = 0.0;  ///< times of the first and last frame [s]
  std::size_t frames = 0;
  std::uint64_t dropped = 0;  ///< frames left out because the disk was too slow
  bool complete = false;      ///< ends as it should; false: the readable part is offered
  std::string damage;         ///< what is wrong with an incomplete one
  std::map<std::string, std::string> parameters;
  std::vector<Attachment> attachments;  ///< with data
  struct Topic {
    std::string name, schema, encoding;
    std::uint64_t messages = 0;
  };
  std::vector<Topic> topics;
  std::uint64_t file_size = 0;  ///< [byte]
};

/// A recorded run, opened for reading.
class COGRSIM_API Recording {
 public:
  /// Errors: not there, not MCAP, MCAP of another program, of a newer version. A truncated or
  /// damaged file opens with what is readable, and info().damage says so; nothing readable is an
  /// error.
  static Result<std::unique_ptr<Recording>> open(const std::string& path);
  ~Recording();

  const RecordingInfo& info() const;
  std::size_t frame_count() const;
  double time_of(std::size_t index) const;  ///< [s]
  /// Index of the last frame at or before `time` [s]; the first one if all are later.
  std::size_t index_at(double time) const;

  /// Any frame, any number of times, bit for bit as it was, with readings (pictures too, where they
  /// were kept), contacts and events; its model is the one of that moment. Frames of the same model
  /// share it. Errors: the file was changed under us.
  Result<FramePtr> frame(std::size_t index);

  const std::vector<RunMessage>& messages() const;
  /// What the values of a sensor's readings mean, by sensor index.
  const std::vector<Channel>& channels(int sensor) const;

  /// Readings computed anew from the recorded frames, with the run's seed: equal to those of the
  /// run where every step was kept. `visit` is given each frame with the new readings, and
  /// ends it by returning false. Errors: the recording has no more than every n-th step, or a
  /// sensor's plugin is not there.
  Result<> recompute(PluginLoader& loader, const std::function<bool(const Frame&)>& visit);

 private:
  struct Impl;
  explicit Recording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
