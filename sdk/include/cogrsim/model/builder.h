// Puts a SceneModel together in C++: for programs and tests that need no scene file.
#pragma once

#include <string>

#include "cogrsim/model/mass_properties.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Adds elements one by one and returns their index; what it returns may be changed through
/// `model` until build(). Preconditions are assertions: this is for code, not for files.
class COGRSIM_API ModelBuilder {
 public:
  explicit ModelBuilder(std::string name = "untitled");

  SceneModel model;

  int material(const std::string& name, double friction, double restitution = 0.0);

  // A body with one shape at its origin; mass 0 makes it static.
  int box(const std::string& name, const Vec3& size, double mass, const Pose& X_WB,
          int material = 0);
  int sphere(const std::string& name, double radius, double mass, const Pose& X_WB,
             int material = 0);
  int cylinder(const std::string& name, double radius, double length, double mass, const Pose& X_WB,
               int material = 0);
  int capsule(const std::string& name, double radius, double length, double mass, const Pose& X_WB,
              int material = 0);
  int plane(const std::string& name, const Pose& X_WB = {}, int material = 0);
  /// `convex`: collides as its hull; else as triangles, and must be static (mass 0).
  int mesh(const std::string& name, TriangleMesh mesh, bool convex, double mass, const Pose& X_WB,
           int material = 0);
  int heightmap(const std::string& name, HeightGrid grid, const Pose& X_WB, int material = 0);
  /// A body without shapes.
  int body(const std::string& name, double mass, const Mat3& inertia, const Pose& X_WB);
  /// Glues another shape to a body; its mass is added (0: looks and touch only).
  void add_shape(int body, Shape shape, double mass);

  /// Joint whose frames coincide at the place X_WJ for the bodies' present poses (q = 0 there);
  /// z of X_WJ is the axis (see JointType). `parent` may be kWorld.
  int joint(const std::string& name, JointType type, int parent, int child, const Pose& X_WJ);
  int motor(const std::string& name, int joint, MotorMode mode, int axis = 0);
  int assembly(const std::string& name, const std::vector<int>& bodies = {},
               const std::vector<int>& joints = {});

  /// Finishes and hands out the model; the builder is spent.
  SceneModelPtr build();

 private:
  int add_body(const std::string& name, Shape shape, double mass, const Pose& X_WB);
};

/// Orientation that turns z to `axis`.
COGRSIM_API Quat z_to(const Vec3& axis);

}  // namespace cogrsim
