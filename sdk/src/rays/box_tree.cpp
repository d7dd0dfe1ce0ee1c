#include "rays/box_tree.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

namespace cogrsim::rays {
namespace {

constexpr double kPadding = 48.0 / 16777216.0;  // times R, see the class

/// A tree that is only refitted gets worse as things wander off; rebuilding costs a few refits.
constexpr int kRefitsBetweenBuilds = 64;

struct Trace {
  RTCIntersectContext context;  // must be first: Embree knows only this part
  BoxVisitor* visitor;
  double start;  // distance at which Embree's ray begins
};

// Rounded away from the ray's start, so that equal distances are still visited.
float upwards(double value) {
  return std::nextafter(static_cast<float>(value), std::numeric_limits<float>::infinity());
}

void on_box(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto* const trace = reinterpret_cast<Trace*>(arguments->context);
  const double limit = trace->visitor->visit(arguments->primID) - trace->start;
  auto* const hit = reinterpret_cast<RTCRayHit*>(arguments->rayhit);
  if (limit < static_cast<double>(hit->ray.tfar)) hit->ray.tfar = upwards(limit);
}

}  // namespace

TreeDevice::TreeDevice() : device_(rtcNewDevice("threads=1,set_affinity=0")) {
  if (device_ == nullptr) throw std::runtime_error("the ray tracing library Embree does not start");
}

TreeDevice::~TreeDevice() { rtcReleaseDevice(device_); }

BoxTree::BoxTree(const TreeDevice& device, bool moving) : device_(device.get()), moving_(moving) {
  scene_ = rtcNewScene(device_);
  if (scene_ == nullptr) throw std::bad_alloc();
  if (moving_) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC);
}

BoxTree::~BoxTree() { rtcReleaseScene(scene_); }

BoxTree::Padded BoxTree::padded(const geometry::Bounds& box) const {
  Padded out;
  for (int i = 0; i < 3; ++i) {
    out.low[i] = static_cast<float>(box.low[i] - middle_[i] - kPadding * radius_);
    out.high[i] = static_cast<float>(box.high[i] - middle_[i] + kPadding * radius_);
  }
  return out;
}

void BoxTree::build(const std::vector<geometry::Bounds>& boxes, double slack) {
  geometry::Bounds all;
  for (const geometry::Bounds& box : boxes) all.add(box);
  if (boxes.empty()) all.add(Vec3::Zero());
  middle_ = all.middle();
  // A little more than needed: rays are clipped to this sphere with rounding.
  radius_ = 1.001 * slack * all.half().norm();
  padded_.clear();
  for (const geometry::Bounds& box : boxes) padded_.push_back(padded(box));
  if (geometry_ != nullptr) rtcDetachGeometry(scene_, 0);
  geometry_ = nullptr;
  if (!boxes.empty()) {
    geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    if (geometry_ == nullptr) throw std::bad_alloc();
    rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(boxes.size()));
    rtcSetGeometryUserData(geometry_, this);
    rtcSetGeometryBoundsFunction(
        geometry_,
        [](const RTCBoundsFunctionArguments* arguments) {
          const auto* const tree = static_cast<const BoxTree*>(arguments->geometryUserPtr);
          const Padded& b = tree->padded_[arguments->primID];
          RTCBounds& out = *arguments->bounds_o;
          out.lower_x = b.low[0], out.lower_y = b.low[1], out.lower_z = b.low[2];
          out.upper_x = b.high[0], out.upper_y = b.high[1], out.upper_z = b.high[2];
        },
        nullptr);
    rtcSetGeometryIntersectFunction(geometry_, on_box);
    rtcAttachGeometryByID(scene_, geometry_, 0);
    rtcReleaseGeometry(geometry_);  // the scene keeps it
  }
  refits_ = 0;
  commit();
}

bool BoxTree::move(unsigned index, const geometry::Bounds& box) {
  const Vec3 corner = (box.low - middle_).cwiseAbs().cwiseMax((box.high - middle_).cwiseAbs());
  if (corner.squaredNorm() > radius_ * radius_) return false;
  padded_[index] = padded(box);
  return true;
}

void BoxTree::refit() {
  refits_ = (refits_ + 1) % kRefitsBetweenBuilds;
  commit();
}

void BoxTree::commit() {
  if (geometry_ != nullptr) {
    rtcSetGeometryBuildQuality(geometry_,
                               refits_ == 0 ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_REFIT);
    rtcCommitGeometry(geometry_);
  }
  rtcCommitScene(scene_);
  if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw std::bad_alloc();
}

void BoxTree::trace(const Vec3& origin, const Vec3& direction, double from, double to,
                    BoxVisitor& visitor) const {
  if (geometry_ == nullptr) return;
  const Vec3 o = origin - middle_;
  const double nearest = -o.dot(direction);
  const double half = radius_ * radius_ - (o + nearest * direction).squaredNorm();
  if (!(half >= 0.0)) return;
  const double chord = std::sqrt(half);
  const double begin = std::max(from, nearest - chord), end = std::min(to, nearest + chord);
  if (!(begin <= end)) return;
  const Vec3 start = o + begin * direction;

  Trace trace;
  rtcInitIntersectContext(&trace.context);
  trace.visitor = &visitor;
  trace.start = begin;
  RTCRayHit hit;
  hit.ray.org_x = static_cast<float>(start.x());
  hit.ray.org_y = static_cast<float>(start.y());
  hit.ray.org_z = static_cast<float>(start.z());
  hit.ray.dir_x = static_cast<float>(direction.x());
  hit.ray.dir_y = static_cast<float>(direction.y());
  hit.ray.dir_z = static_cast<float>(direction.z());
  hit.ray.tnear = 0.0F;
  hit.ray.tfar = upwards(end - begin);
  hit.ray.time = 0.0F;
  hit.ray.mask = ~0U;
  hit.ray.id = 0;
  hit.ray.flags = 0;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_, &trace.context, &hit);
}

}  // namespace cogrsim::rays
