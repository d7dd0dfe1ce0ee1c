// Rows of pictures of the runs of `cogrsim transfer`: what a robot does on each engine, over time.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "common/json_text.h"
#include "policy/policy_scene.h"
#include "policy/transfer_table.h"

namespace cogrsim::cli {

/// Pictures of a row, and rows of a report: some 10 kB a picture.
inline constexpr int kMostPictures = 12;
inline constexpr std::size_t kMostStrips = 24;

/// Keeps the frames of one run that a strip shows: of the start, at equal times up to the end, and where the
/// robot falls the last before that.
class StripCamera {
 public:
  StripCamera(const PolicyScene& scene, int count, double duration)
      : scene_(scene), count_(count), duration_(duration) {}
  void see(const FramePtr& frame);
  /// {"pictures": [{"time", "jpeg" in base64}, …]}, or {"problem": why there are none}.
  Json develop() const;

 private:
  const PolicyScene& scene_;
  int count_;
  double duration_;
  std::vector<FramePtr> kept_;
  FramePtr last_;
};

/// The strips of a study: one run of the first seed for each row of its table, made once more.
struct Filmstrips {
  struct Strip {
    std::string title;
    Json result;  ///< of StripCamera::develop(), or {"problem": …}
  };
  std::vector<Strip> strips;
  std::size_t left_out = 0;  ///< rows beyond kMostStrips
};
Filmstrips make_filmstrips(const SweepPlan& plan, const TransferTable& table, int count);
std::string filmstrips_html(const SweepPlan& plan, const Filmstrips& films);

}  // namespace cogrsim::cli
