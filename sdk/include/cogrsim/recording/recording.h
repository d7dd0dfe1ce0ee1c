// Recordings of runs in files. The format is MCAP (mcap.dev); docs/guide/recording.md describes the
// topics and their schemas.
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

/// A file inside a recording: the scene or a file that it imports.
struct Attachment {
  std::string name;        ///< relative to the folder of the scene
  std::string media_type;  ///< "application/xml"
  std::string data;
};

/// The files of a compiled scene as attachments; `folder` is that of the scene. Files that cannot be
/// read are left out.
COGRSIM_API std::vector<Attachment> scene_files(const SceneModel& model, const std::string& folder);

/// Options of a recording.
struct RecorderOptions {
  std::string path;    ///< of the file; replaces an older recording that no recorder is writing
  OutputRules rules;   ///< which existing files may be replaced
  double every = 0.0;  ///< time between recorded frames [s]; 0: every step
  bool contacts = true;
  bool images = true;
  bool jpeg = false;  ///< colour images as JPEG, otherwise as PNG
  /// Limit of the memory for frames that wait for the disk [byte]. Further frames are dropped,
  /// counted and reported; the simulation never waits.
  std::size_t queue_limit = 512u << 20;
  std::vector<Attachment> attachments;            ///< the scene and all files that it imports
  std::map<std::string, std::string> parameters;  ///< options `--set` of the run, as information
};

/// Writes a recording during the run, in a thread of its own, so that a step never waits for the
/// disk. Start it before the first step. The file can be read at any time: it consists of complete
/// chunks, and a killed process loses at most the last chunk. Except for problem(), the functions
/// must be called by the thread that steps the simulation.
class COGRSIM_API Recorder {
 public:
  /// Starts recording a simulation. Errors: the file cannot be written, or another recorder (of
  /// this or another process) is writing it.
  static Result<std::unique_ptr<Recorder>> start(Simulation& simulation, RecorderOptions options);
  ~Recorder();  ///< finishes the file without reporting errors; call finish() to get them

  /// Adds a file that is known at the end only; it is written by finish().
  void attach(Attachment file);
  /// Writes the remaining frames, the index and the end of the file. Call it once. Errors: the disk
  /// was full or removed, or frames were dropped; the message states how much of the run is
  /// recorded.
  Result<> finish(RunStatus status);

  /// The first error so far; empty: none. Thread-safe.
  std::string problem() const;

 private:
  struct Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Description of a recording.
struct RecordingInfo {
  std::string scene, backend, engine_version, library_version;
  std::optional<Provenance> provenance;  ///< empty: not recorded
  std::string status;                    ///< status at the end; empty: the recording is truncated
  std::uint64_t seed = 0;
  double step = 0.0;              ///< time step [s]
  double start = 0.0, end = 0.0;  ///< times of the first and last frame [s]
  std::size_t frames = 0;
  std::uint64_t dropped = 0;  ///< number of frames dropped because the disk was too slow
  bool complete = false;      ///< false: the file is damaged, and only a part can be read
  std::string damage;         ///< description of the damage of an incomplete recording
  std::map<std::string, std::string> parameters;
  std::vector<Attachment> attachments;  ///< with data
  /// A topic of the MCAP file.
  struct Topic {
    std::string name, schema, encoding;
    std::uint64_t messages = 0;
  };
  std::vector<Topic> topics;
  std::uint64_t file_size = 0;  ///< [byte]
};

/// A recorded run, opened for reading. Not thread-safe: the calls on one object must not overlap.
class COGRSIM_API Recording {
 public:
  /// Opens a recording. A truncated or damaged file opens with its readable part, and info().damage
  /// describes the damage. Errors: the file does not exist, is not MCAP, was written by another
  /// program or a newer version, or has no readable part.
  static Result<std::unique_ptr<Recording>> open(const std::string& path);
  ~Recording();

  const RecordingInfo& info() const;
  std::size_t frame_count() const;
  double time_of(std::size_t index) const;  ///< time of a frame [s]; `index` < frame_count()
  /// Index of the last frame at or before `time` [s]; the first one if all are later.
  std::size_t index_at(double time) const;

  /// A frame by its index, bit-identical to that of the run, with readings (including images if
  /// they were recorded), contacts and events. Its model is that of the run at the time of the
  /// frame; frames with the same model share it. Errors: the file was changed after it was opened.
  Result<FramePtr> frame(std::size_t index);

  const std::vector<RunMessage>& messages() const;
  /// The channels of a sensor by its index.
  const std::vector<Channel>& channels(int sensor) const;

  /// Recomputes the readings from the recorded frames with the seed of the run. They are equal to
  /// those of the run if every step was recorded. `visit` is called with each frame and its new
  /// readings, and stops the computation by returning false. Errors: only every n-th step was
  /// recorded, or the plugin of a sensor is missing.
  Result<> recompute(PluginLoader& loader, const std::function<bool(const Frame&)>& visit);

 private:
  struct Impl;
  explicit Recording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
