#include "cameras.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cogrsim/rendering/standard_view.h"
#include "cogrsim/sensing/sensor_models.h"
#include "render/picture_file.h"
#include "run_fields.h"
#include "run_wire.h"

namespace cogrsim::studio {

namespace {

constexpr int kJpegQuality = 80;
/// How often it is checked whether a client sees something new or takes another picture, and only
/// while pictures are requested.
constexpr auto kLookTime = std::chrono::milliseconds(15);

const char* const kKinds[] = {"color", "depth", "segmentation"};

/// Near is bright; pixels without a surface are black. Scaled to the nearest and the farthest
/// depth.
Result<std::string> depth_picture(const Picture& picture) {
  float least = std::numeric_limits<float>::infinity(), most = 0.0F;
  for (const float d : picture.depth) {
    if (!std::isfinite(d)) continue;
    least = std::min(least, d);
    most = std::max(most, d);
  }
  Image image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = 1;
  image.data.assign(picture.depth.size(), 0);
  const float range = std::max(most - least, 1e-6F);
  for (std::size_t i = 0; i < picture.depth.size(); ++i) {
    const float d = picture.depth[i];
    if (!std::isfinite(d)) continue;
    image.data[i] = static_cast<std::uint8_t>(std::lround(255.0F - 215.0F * (d - least) / range));
  }
  return encode_png(image);
}

void scale(Camera& camera, int width) {
  const double factor = static_cast<double>(width) / camera.width;
  camera.width = width;
  camera.height = std::max(1, static_cast<int>(std::lround(camera.height * factor)));
  for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value *= factor;
}

}  // namespace

Cameras::Cameras(Viewers& viewers, Scenes& scenes, Outbox& outbox,
                 std::vector<std::string> plugin_folders)
    : viewers_(viewers),
      scenes_(scenes),
      outbox_(outbox),
      plugin_folders_(std::move(plugin_folders)) {
  thread_ = std::thread([this] { run(); });
}

void Cameras::stop() {
  {
    std::lock_guard lock(mutex_);
    over_ = true;
    waiting_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
}

Answer Cameras::show(ClientId client, const Json& f) {
  const SceneRecordPtr record = scenes_.newest();
  std::vector<Wish> wishes;
  for (const Json& one : f.at("show")) {
    const auto name = one.at("name").get<std::string>();
    const auto kind = one.at("kind").get<std::string>();
    Wish wish;
    wish.name = name;
    wish.width = one.at("width").get<int>();
    wish.kind = static_cast<Kind>(std::find(std::begin(kKinds), std::end(kKinds), kind) -
                                  std::begin(kKinds));
    const auto named = [&](const auto& element) { return element.name == name; };
    if (!record ||
        (std::none_of(record->model->sensors.begin(), record->model->sensors.end(),
                      [&](const SensorModel& s) { return named(s) && s.type == "camera"; }) &&
         std::none_of(record->model->views.begin(), record->model->views.end(), named))) {
      return fail("there is no camera and no view '" + name + "'");
    }
    wishes.push_back(std::move(wish));
  }
  std::lock_guard lock(mutex_);
  if (wishes.empty()) {
    wishes_.erase(client);
  } else {
    wishes_[client] = std::move(wishes);
  }
  waiting_.notify_one();
  return Json::object();
}

Answer Cameras::view(ClientId client, const Json& f) {
  Wish wish;
  wish.once = true;
  wish.width = f.at("width").get<int>();
  wish.height = f.at("height").get<int>();
  wish.fov = f.at("fov").get<double>();
  if (const auto pose = fields::maybe<std::array<double, 7>>(f, "pose")) {
    const auto& v = *pose;
    Quat q(v[3], v[4], v[5], v[6]);
    if (q.norm() < 1e-6) return fail("the quaternion of 'pose' is zero");
    wish.pose = Pose({v[0], v[1], v[2]}, q.normalized());
  }
  if (!viewers_.seen(client)) return fail("there is no frame yet");
  std::lock_guard lock(mutex_);
  std::vector<Wish>& wishes = wishes_[client];
  // The last request counts.
  wishes.erase(std::remove_if(wishes.begin(), wishes.end(), [](const Wish& w) { return w.once; }),
               wishes.end());
  wishes.push_back(std::move(wish));
  waiting_.notify_one();
  return Json::object();
}

void Cameras::left(ClientId client) {
  std::lock_guard lock(mutex_);
  wishes_.erase(client);
  turns_.erase(client);
}

std::optional<Cameras::Job> Cameras::next_job() {
  std::vector<ClientId> clients;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [client, wishes] : wishes_) {
      if (!wishes.empty()) clients.push_back(client);
    }
    // One picture of a client, then one of the next: no client waits for another's many cameras.
    std::stable_sort(clients.begin(), clients.end(),
                     [this](ClientId a, ClientId b) { return turns_[a] < turns_[b]; });
  }
  for (const ClientId client : clients) {
    if (!outbox_.wants_picture(client)) continue;
    const Instant instant = viewers_.seen(client);
    if (!instant) continue;
    std::lock_guard lock(mutex_);
    const auto found = wishes_.find(client);
    if (found == wishes_.end()) continue;
    std::vector<Wish>& wishes = found->second;
    for (std::size_t k = 0; k < wishes.size(); ++k) {
      const std::size_t i = (turns_[client] + k) % wishes.size();
      if (!wishes[i].once && wishes[i].drawn == instant.frame) continue;
      Job job{client, i, wishes[i], instant};
      wishes[i].drawn = instant.frame;
      ++turns_[client];
      if (job.what.once) wishes.erase(wishes.begin() + static_cast<std::ptrdiff_t>(i));
      return job;
    }
  }
  return std::nullopt;
}

Result<RenderRequest> Cameras::request_of(const Wish& wish, const Frame& frame) const {
  RenderRequest request;
  const SceneModel& model = *frame.model;
  request.illustrated = true;
  if (wish.name.empty()) {
    request.camera = wish.pose ? make_camera(*wish.pose, wish.width, wish.height, wish.fov)
                               : standard_camera(StandardView::iso, visible_bounds(frame),
                                                 wish.width, wish.height, wish.fov);
    return request;
  }
  for (const SensorModel& sensor : model.sensors) {
    if (sensor.name != wish.name || sensor.type != "camera" || sensor.removed) continue;
    auto made = camera_request(model, sensor, frame.state);
    if (!made) return made;
    scale(made->camera, wish.width);
    return made;
  }
  for (const ViewModel& view : model.views) {
    if (view.name != wish.name) continue;
    request.camera = make_camera(view_pose(frame, view), wish.width,
                                 std::max(1, wish.width * 3 / 4), view.fov);
    return request;
  }
  return fail("there is no camera '" + wish.name + "' at this time");
}

Result<Bytes> Cameras::draw(const Job& job) {
  const Frame& frame = *job.instant.frame;
  auto request = request_of(job.what, frame);
  if (!request) return tl::unexpected(request.error());
  request->color = job.what.kind == Kind::color;
  request->depth = job.what.kind == Kind::depth;
  request->segmentation = job.what.kind == Kind::segmentation;
  if (!renderer_ && problem_.empty()) {
    PluginLoader loader(plugin_folders_);
    auto loaded = load_renderer(loader);
    if (loaded) {
      renderer_ = std::move(*loaded);
    } else {
      problem_ = loaded.error().text();
    }
  }
  if (!renderer_) return fail("no pictures can be made: " + problem_);
  auto pictures = renderer_->render(frame, {*request});
  if (!pictures) return tl::unexpected(pictures.error());
  ++rendered_;
  const Picture& picture = pictures->front();
  const Result<std::string> file = job.what.kind == Kind::color
                                       ? encode_jpeg(picture.color, kJpegQuality)
                                   : job.what.kind == Kind::depth ? depth_picture(picture)
                                                                  : cli::segmentation_png(picture);
  if (!file) return tl::unexpected(file.error());
  return std::make_shared<const std::string>(encode_picture(static_cast<int>(job.what.kind),
                                                            job.what.name, picture.width,
                                                            picture.height, frame.time, *file));
}

void Cameras::run() {
  std::string reported;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      waiting_.wait(lock, [this] { return over_ || !wishes_.empty(); });
      if (over_) return;
    }
    const auto job = next_job();
    if (!job) {
      std::unique_lock lock(mutex_);
      for (auto entry = wishes_.begin(); entry != wishes_.end();) {
        entry = entry->second.empty() ? wishes_.erase(entry) : std::next(entry);
      }
      if (!wishes_.empty()) waiting_.wait_for(lock, kLookTime, [this] { return over_; });
      continue;
    }
    const auto drawn = draw(*job);
    if (drawn) {
      outbox_.offer_picture(
          job->client, std::string(kKinds[static_cast<int>(job->what.kind)]) + " " + job->what.name,
          *drawn);
    } else if (drawn.error().message != reported) {
      reported = drawn.error().message;
      const RunMessage message{job->instant.time(), Severity::error, job->what.name, reported};
      outbox_.send(job->client, Json{{"topic", "messages"}, {"messages", {to_json(message)}}}.dump(
                                    -1, ' ', false, Json::error_handler_t::replace));
    }
  }
}

}  // namespace cogrsim::studio
