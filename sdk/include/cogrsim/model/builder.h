// Construction of a SceneModel in C++, for programs and tests without a scene file.
#pragma once

#include <string>

#include "cogrsim/model/mass_properties.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Builds a model element by element. Each function adds an element and returns its index in the
/// vectors of `model`; elements can be changed there until build(). Violated preconditions are
/// assertions, not errors, because the caller is a program. Not thread-safe.
class COGRSIM_API ModelBuilder {
 public:
  explicit ModelBuilder(std::string name = "untitled");

  SceneModel model;

  /// Adds a material with a Coulomb friction coefficient (>= 0) and a coefficient of restitution
  /// (0 to 1).
  int material(const std::string& name, double friction, double restitution = 0.0);

  // These functions add a body with one shape at its origin. Sizes, radii and lengths are in [m],
  // masses in [kg]; X_WB is the pose of the body in the world. Mass 0 makes the body static.

  int box(const std::string& name, const Vec3& size, double mass, const Pose& X_WB,
          int material = 0);
  int sphere(const std::string& name, double radius, double mass, const Pose& X_WB,
             int material = 0);
  int cylinder(const std::string& name, double radius, double length, double mass, const Pose& X_WB,
               int material = 0);
  int capsule(const std::string& name, double radius, double length, double mass, const Pose& X_WB,
              int material = 0);
  int plane(const std::string& name, const Pose& X_WB = {}, int material = 0);
  /// `convex` true: the body collides as the convex hull of the mesh. False: it collides as the
  /// triangles themselves and must be static (mass 0).
  int mesh(const std::string& name, TriangleMesh mesh, bool convex, double mass, const Pose& X_WB,
           int material = 0);
  int heightmap(const std::string& name, HeightGrid grid, const Pose& X_WB, int material = 0);
  /// A body without shapes; `inertia` [kg m^2] is about its centre of mass, in body axes.
  int body(const std::string& name, double mass, const Mat3& inertia, const Pose& X_WB);
  /// Adds a rigidly attached shape to a body. Its mass [kg] is added to that of the body; mass 0
  /// leaves the mass properties unchanged.
  void add_shape(int body, Shape shape, double mass);

  /// Adds a joint. At the current poses of the bodies both joint frames coincide with X_WJ, and the
  /// coordinates are zero there; the z axis of X_WJ is the joint axis (see JointType). `parent` may
  /// be kWorld.
  int joint(const std::string& name, JointType type, int parent, int child, const Pose& X_WJ);
  /// Adds a motor on one axis of a joint.
  int motor(const std::string& name, int joint, MotorMode mode, int axis = 0);
  /// Adds an assembly that contains the given bodies and joints.
  int assembly(const std::string& name, const std::vector<int>& bodies = {},
               const std::vector<int>& joints = {});

  /// Finishes the model and returns it. The builder must not be used afterwards.
  SceneModelPtr build();

 private:
  int add_body(const std::string& name, Shape shape, double mass, const Pose& X_WB);
};

/// The smallest rotation that maps the z axis to the direction of `axis`.
COGRSIM_API Quat z_to(const Vec3& axis);

}  // namespace cogrsim
