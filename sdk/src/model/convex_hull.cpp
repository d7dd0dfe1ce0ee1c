#include "cogrsim/model/convex_hull.h"

#include "rays/convex_hull.h"

namespace cogrsim {

TriangleMesh convex_hull(const TriangleMesh& mesh) { return rays::convex_hull(mesh); }

}  // namespace cogrsim
