#include "run_samples.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "cogrsim/core/image.h"
#include "cogrsim/rendering/renderer.h"
#include "common/terminal.h"
#include "series.h"

namespace cogrsim::studio {

namespace {

constexpr std::size_t kMostEvents = 20'000;
constexpr std::size_t kMostCurves = 5000;  // of one scene
constexpr int kJpegQuality = 80;

/// The frames of a run of which only the scenes are asked.
class NoFrames final : public Frames {
 public:
  Extent extent() const override { return {}; }
  Instant at(double) override { return {}; }
  Instant before(double) override { return {}; }
  std::vector<Instant> after(double, std::size_t) override { return {}; }
  std::uint64_t epoch() const override { return 1; }
};

/// The page has these from the frames.
bool seen_in_poses(const std::string& name, const std::string& owner,
                   const std::set<std::string>& moving) {
  if (name == "time") return true;
  if (moving.count(owner) == 0 || name.size() <= owner.size() + 1) return false;
  const std::string quantity = name.substr(owner.size() + 1);
  for (const char* pose : {"x", "y", "z", "roll", "pitch", "yaw"}) {
    if (quantity == pose) return true;
  }
  return false;
}

std::size_t bytes_of(const RunSamples::Sample& sample) {
  return sizeof sample + 4 * (sample.poses.size() + sample.values.size()) +
         sizeof(RunSamples::Touch) * sample.contacts.size();
}

}  // namespace

RunSamples::RunSamples(SampleOptions options, OriginsPtr origins, Channels channels)
    : options_(options),
      origins_(std::move(origins)),
      channels_(std::move(channels)),
      every_(options.every),
      shots_every_(options.every) {}

FrameContents RunSamples::needs(const SceneModelPtr& model) {
  if (model != model_) enter(model);
  FrameContents all;
  all.contacts = true;
  for (const Curve& curve : curves_[scene_].curves) all = all | curve.signal.needs();
  for (const Figure& figure : figures_) all = all | figure.sampler->needs();
  return all;
}

void RunSamples::enter(const SceneModelPtr& model) {
  const bool first = model_ == nullptr;
  model_ = model;
  scene_ = scenes_.add(model, origins_, !first, channels_);
  const SceneRecordPtr record = scenes_.get(scene_);
  const SignalScope scope{*model, record->lookup(), {}, {}};
  std::set<std::string> moving;
  for (const Body& body : model->bodies) {
    if (!body.removed && body.kind != BodyKind::static_body) moving.insert(body.name);
  }
  NoFrames none;
  const Answer all = SeriesRequests(none, scenes_).signals();
  SceneCurves& here = curves_[scene_];
  std::map<std::string, int> by_name;
  for (const Json& one : (*all)["signals"]) {
    const std::string name = one["name"], owner = one["owner"];
    if (seen_in_poses(name, owner, moving)) continue;
    if (here.curves.size() >= kMostCurves) {
      ++curves_left_out_;
      continue;
    }
    auto signal = Signal::parse(scope, name);
    if (!signal) continue;
    by_name[name] = static_cast<int>(here.curves.size());
    here.curves.push_back({name, one["unit"], owner, std::move(*signal)});
  }
  for (std::size_t i = 0; i < model->sensors.size(); ++i) {
    std::vector<int> columns;
    for (const Channel& channel : record->channels[i]) {
      const auto found = by_name.find(model->sensors[i].name + "." + channel.name);
      columns.push_back(found == by_name.end() ? -1 : found->second);
    }
    here.readings.push_back(std::move(columns));
  }
  // Signals of a figure may be added later.
  figure_problems_.clear();
  for (const PlotModel& plot : model->plots) {
    const auto there = [&](const Figure& figure) { return figure.name == plot.name; };
    if (std::any_of(figures_.begin(), figures_.end(), there)) continue;
    auto made = figures::PlotSampler::create(plot, *model, record->lookup());
    if (made) {
      figures_.push_back({plot.name, std::make_unique<figures::PlotSampler>(std::move(*made))});
    } else {
      figure_problems_.push_back(fmt::format("figure '{}': {}", plot.name, made.error().message));
    }
  }
}

void RunSamples::begin_again() {
  samples_.clear();
  paths_.clear();
  events_.clear();
  shots_.clear();
  shot_last_.clear();
  bytes_ = shot_bytes_ = events_left_out_ = 0;
  next_ = -std::numeric_limits<double>::infinity();
  figures_.clear();
  enter(last_->model);
}

void RunSamples::take(const FramePtr& frame) {
  // The frame at the start is shown once more with the first step.
  const bool again = last_ && last_->step == frame->step;
  const bool restarted = last_ && frame->step < last_->step;
  last_ = frame;
  if (again) return;
  if (restarted) begin_again();
  if (frame->model != model_) enter(frame->model);
  for (const Figure& figure : figures_) figure.sampler->take(*frame);
  paths_.take(*frame);
  for (const Event& event : frame->events) {
    if (events_.size() < kMostEvents) {
      events_.push_back(event);
    } else {
      ++events_left_out_;
    }
  }
  add_shots(*frame);
  // A billionth: times that are sums of steps are a little off.
  if (frame->time < next_ - 1e-9) return;
  add(*frame);
  if (every_ > 0.0) next_ = (std::floor((frame->time + 1e-9) / every_) + 1.0) * every_;
  while (bytes_ > options_.limit && samples_.size() > 2) thin();
}

void RunSamples::add(const Frame& frame) {
  Sample sample;
  sample.time = frame.time;
  sample.step = frame.step;
  sample.scene = scene_;
  sample.poses.reserve(7 * frame.state.poses.size());
  for (const Pose& X : frame.state.poses) {
    for (const double v : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) {
      sample.poses.push_back(static_cast<float>(v));
    }
  }
  for (const Curve& curve : curves_[scene_].curves) {
    sample.values.push_back(static_cast<float>(curve.signal.evaluate(frame)));
  }
  for (const Contact& c : frame.contacts) {
    Touch touch;
    touch.a = c.body_a;
    touch.b = c.body_b;
    const double numbers[8] = {c.point.x(),  c.point.y(),  c.point.z(), c.normal.x(),
                               c.normal.y(), c.normal.z(), c.depth,     c.force.norm()};
    for (int k = 0; k < 8; ++k) touch.numbers[k] = static_cast<float>(numbers[k]);
    sample.contacts.push_back(touch);
  }
  bytes_ += bytes_of(sample);
  samples_.push_back(std::move(sample));
}

void RunSamples::add_shots(const Frame& frame) {
  for (const Reading& reading : frame.readings) {
    if (!reading.picture || reading.sensor < 0 || reading.picture->color.data.empty()) continue;
    const std::string& camera = model_->sensors[reading.sensor].name;
    const auto last = shot_last_.find(camera);
    if (last != shot_last_.end()) {
      if (last->second.first == reading.sequence) continue;
      if (reading.time < last->second.second + shots_every_ - 1e-9) continue;
    }
    auto jpeg = encode_jpeg(reading.picture->color, kJpegQuality);
    if (!jpeg) continue;
    shot_last_[camera] = {reading.sequence, reading.time};
    shot_bytes_ += jpeg->size();
    shots_.push_back(
        {reading.time, camera, reading.picture->width, reading.picture->height, std::move(*jpeg)});
  }
  while (shot_bytes_ > options_.pictures && shots_.size() > 2) {
    std::map<std::string, bool> keep;
    std::vector<Shot> kept;
    shot_bytes_ = 0;
    for (Shot& shot : shots_) {
      bool& mine = keep[shot.camera];
      mine = !mine;
      if (!mine) continue;
      shot_bytes_ += shot.jpeg.size();
      kept.push_back(std::move(shot));
    }
    if (kept.size() == shots_.size()) break;
    shots_ = std::move(kept);
    shots_every_ = std::max(2.0 * shots_every_, 1e-3);
    shots_thinned_ = true;
  }
}

void RunSamples::thin() {
  std::vector<Sample> kept;
  bytes_ = 0;
  for (std::size_t i = 0; i < samples_.size(); i += 2) {
    bytes_ += bytes_of(samples_[i]);
    kept.push_back(std::move(samples_[i]));
  }
  // Of every step: twice what there was between the last two.
  if (every_ <= 0.0 && kept.size() > 1) {
    every_ = kept.back().time - kept[kept.size() - 2].time;
  } else {
    every_ *= 2.0;
  }
  samples_ = std::move(kept);
  if (every_ > 0.0) next_ = (std::floor((samples_.back().time + 1e-9) / every_) + 1.0) * every_;
  thinned_ = true;
}

void RunSamples::finish() {
  if (last_ && (samples_.empty() || samples_.back().step != last_->step)) add(*last_);
}

std::vector<std::string> RunSamples::left_out() const {
  std::vector<std::string> out = figure_problems_;
  if (thinned_) {
    out.push_back(fmt::format("frames between those every {}: more than --size allows",
                              cli::time_text(every_)));
  }
  if (shots_thinned_) {
    out.push_back(fmt::format("pictures of cameras between those every {}: more than {} MB",
                              cli::time_text(shots_every_), options_.pictures >> 20));
  }
  if (curves_left_out_ > 0) {
    out.push_back(fmt::format("{} signals beyond the first {}", curves_left_out_, kMostCurves));
  }
  if (events_left_out_ > 0) {
    out.push_back(fmt::format("{} events after the first {}", events_left_out_, kMostEvents));
  }
  return out;
}

}  // namespace cogrsim::studio
