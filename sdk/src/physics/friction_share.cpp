#include "cogrsim/physics/friction_share.h"

namespace cogrsim {

void share_friction(std::size_t count, const Vec3& normal, const double* loads, const Vec3* points,
                    Vec3* friction) {
  double load = 0.0;
  std::size_t loaded = 0;
  Vec3 centre = Vec3::Zero(), force = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    if (loads[i] > 0.0) ++loaded;
    load += loads[i];
    centre += loads[i] * points[i];
    force += friction[i];
  }
  if (loaded < 2) return;
  centre /= load;
  double moment = 0.0, lever = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 along = normal.cross(points[i] - centre);
    moment += along.dot(friction[i]);
    lever += loads[i] * along.squaredNorm();
  }
  const double turn = lever > 0.0 ? moment / lever : 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    friction[i] = loads[i] * (force / load + turn * normal.cross(points[i] - centre));
  }
}

}  // namespace cogrsim
