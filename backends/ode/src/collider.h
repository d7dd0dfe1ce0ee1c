// Which shapes touch, by ODE's broadphase and colliders.
#pragma once

#include <ode/ode.h>

#include <memory>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::ode {

/// One point of a pair of shapes, before anything acts there.
struct TouchPoint {
  int body_a = -1, body_b = -1, shape_a = -1, shape_b = -1;  ///< body_a < body_b
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< from a to b
  double gap = 0.0;             ///< distance of the true shapes; negative: overlap [m]
  bool line_end = false;        ///< one of the ends of a line of contact, whose middle is there too
};

/// All colliding shapes of a scene. Every shape is a little larger here than it is (its skin), so
/// that what rests on it is found although it does not overlap; gaps are those of the true shapes.
class Collider {
 public:
  Collider() = default;
  ~Collider();
  Collider(const Collider&) = delete;
  Collider& operator=(const Collider&) = delete;

  /// Takes in what `model` has beyond what is known. Errors: a shape that ODE cannot hold.
  Result<> add(const SceneModel& model);
  /// Rereads who collides with whom.
  void set_model(const SceneModel& model) { filter_ = CollisionFilter(model); }
  /// Takes a body's shapes out.
  void remove(int body);
  /// Places a body's shapes. What lies beyond everything that moves touches nothing.
  void place(int body, const Pose& X_WB);
  /// Points of all pairs that touch or are within their skins, ordered by bodies and shapes.
  void find(const SceneModel& model, std::vector<TouchPoint>& out);

 private:
  struct Item {
    int body = -1, shape = -1;
    ShapeType type = ShapeType::box;
    double skin = 0.0;
    Pose X_BG;  ///< the geom's own frame
    dGeomID geom = nullptr;
    dTriMeshDataID mesh = nullptr;
    std::vector<double> planes, points;  ///< ODE keeps pointers into these
    std::vector<unsigned> polygons;
    std::vector<double> vertices;
    std::vector<dTriIndex> triangles;
  };
  Result<> make(const SceneModel& model, const Shape& shape, Item& item);
  void collide(const Item& a, const Item& b, std::vector<TouchPoint>& out);
  static void near(void* self, dGeomID a, dGeomID b);

  dSpaceID space_ = nullptr;
  bool locked_ = false;  ///< ODE is in it, or was left by an exception
  std::vector<std::unique_ptr<Item>> items_;
  std::vector<std::vector<int>> of_body_;
  CollisionFilter filter_;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<dContactGeom> found_;
};

}  // namespace cogrsim::ode
