// The topics and messages of a run as they arise: the same that a recording of it has.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

class Simulation;

/// Takes topics and messages. docs/guide/recording.md describes both.
class COGRSIM_API TopicSink {
 public:
  virtual ~TopicSink() = default;

  /// Adds a schema or a channel; ids count from 1. A topic may get another channel later, for a sensor
  /// that was replaced: the old one has no further messages.
  virtual std::uint16_t add_schema(std::string name, std::string encoding, std::string data) = 0;
  virtual std::uint16_t add_channel(std::uint16_t schema, std::string topic, std::string encoding,
                                    std::map<std::string, std::string> metadata = {}) = 0;

  /// Whether a message of this channel would be kept: if not, it need not be made.
  virtual bool wants(std::uint16_t) const { return true; }
  /// Where the bytes of a message are to be appended, until end_message(). `time`: [ns].
  virtual std::string& begin_message(std::uint16_t channel, std::uint32_t sequence,
                                     std::uint64_t time) = 0;
  virtual void end_message() = 0;

  /// A message that `fill` appends to a string, if it is wanted.
  template <class Fill>
  void message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time, Fill&& fill) {
    if (!wants(channel)) return;
    fill(begin_message(channel, sequence, time));
    end_message();
  }
};

/// Options of a stream.
struct StreamOptions {
  bool contacts = true;
  bool images = true;
  bool jpeg = false;  ///< colour images as JPEG, otherwise as PNG
  /// Frames without events that are taken in a second of wall-clock time, at most: a run that is not
  /// in real time makes more than can be looked at. The others are left out without notice.
  double frames_per_second = 2000.0;
  /// Limit of the memory for frames that wait for their encoding [byte]. Further frames are left out.
  std::size_t queue_limit = 64u << 20;
};

/// Encodes a run for a sink, in a thread of its own: a step never waits for it. Start it before the
/// first step.
class COGRSIM_API RunStream {
 public:
  /// A sink that was asked for a new message while the run makes none, as when it is paused.
  class Sink : public TopicSink {
   public:
    /// Called by the encoding thread. True: the present frame is to be given once more.
    virtual bool asks_again() { return false; }
    /// All messages up to this time were given [ns].
    virtual void reached(std::uint64_t) {}
  };

  /// `sink` must outlive the stream; the encoding thread alone calls it, except during start().
  static std::unique_ptr<RunStream> start(Simulation& simulation, const StreamOptions& options,
                                          Sink& sink);
  ~RunStream();  ///< gives the sink what waits

  /// Number of frames that were left out because the encoding was too slow. Thread-safe.
  std::uint64_t left_out() const;

 private:
  struct Impl;
  explicit RunStream(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
