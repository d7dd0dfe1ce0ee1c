// Helpers for tests that compile a scene from a string and check the model.
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::test {

/// Compiles the inside of a <scene>; fails the test, showing what was reported, when it does not.
inline SceneModelPtr compile_scene(const std::string& inside,
                                   const dsl::CompileOptions& options = {}) {
  const auto result = dsl::compile_text("<scene name=\"t\" version=\"1\">" + inside + "</scene>",
                                        "t.scene.xml", options);
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.model != nullptr);
  return result.model;
}

/// Codes reported for the inside of a <scene>, in file order, separated by blanks.
inline std::string codes_of(const std::string& inside, const dsl::CompileOptions& options = {}) {
  const auto result = dsl::compile_text("<scene name=\"t\" version=\"1\">" + inside + "</scene>",
                                        "t.scene.xml", options);
  std::string codes;
  for (const Diagnostic& d : result.diagnostics) codes += (codes.empty() ? "" : " ") + d.code;
  return codes;
}

inline const Body& body(const SceneModel& model, const std::string& name) {
  const int index = find_body(model, name);
  INFO("body " << name);
  REQUIRE(index >= 0);
  return model.bodies[index];
}

inline const Joint& joint(const SceneModel& model, const std::string& name) {
  const int index = find_joint(model, name);
  INFO("joint " << name);
  REQUIRE(index >= 0);
  return model.joints[index];
}

inline bool near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  UNSCOPED_INFO(a.transpose() << " against " << b.transpose());
  return (a - b).norm() <= tolerance;
}

}  // namespace cogrsim::test
