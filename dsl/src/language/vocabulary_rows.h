// Functions that build the rows of the vocabulary.
#pragma once

#include <initializer_list>
#include <iterator>
#include <utility>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/model/shapes.h"
#include "language/vocabulary.h"

namespace cogrsim::dsl::rows {

using namespace dim;
using Attributes = std::vector<AttributeSpec>;
using Words = std::vector<std::string_view>;

// ---- makers of single columns, so that a row reads like a sentence

inline AttributeSpec attr(std::string_view name, Kind kind, std::string_view doc,
                          std::string_view fallback = {}) {
  AttributeSpec a;
  a.name = name;
  a.kind = kind;
  a.doc = doc;
  a.default_text = fallback;
  return a;
}

inline AttributeSpec number(std::string_view name, Dimension dimension, std::string_view doc,
                            std::string_view fallback = {}) {
  AttributeSpec a = attr(name, Kind::number, doc, fallback);
  a.dimensions = {dimension};
  return a;
}

/// A number whose dimension depends on what it belongs to.
inline AttributeSpec either(std::string_view name, std::vector<Dimension> dimensions,
                            std::string_view doc) {
  AttributeSpec a = attr(name, Kind::number, doc);
  a.dimensions = std::move(dimensions);
  return a;
}

inline AttributeSpec numbers(std::string_view name, Dimension dimension, int count,
                             std::string_view doc, std::string_view fallback = {}) {
  AttributeSpec a = attr(name, Kind::numbers, doc, fallback);
  a.dimensions = {dimension};
  a.min_count = a.max_count = count;
  return a;
}

/// A list whose entries have dimensions of their own.
inline AttributeSpec entries(std::string_view name, std::vector<Dimension> dimensions,
                             std::string_view doc) {
  AttributeSpec a = attr(name, Kind::numbers, doc);
  a.min_count = a.max_count = static_cast<int>(dimensions.size());
  a.dimensions = std::move(dimensions);
  a.per_entry = true;
  return a;
}

inline AttributeSpec choice(std::string_view name, Words words, std::string_view doc,
                            std::string_view fallback = {}) {
  AttributeSpec a = attr(name, Kind::choice, doc, fallback);
  a.choices = std::move(words);
  return a;
}

inline AttributeSpec must(AttributeSpec a) {
  a.required = true;
  return a;
}
inline AttributeSpec above_zero(AttributeSpec a) {
  a.minimum = 0.0;
  a.above_minimum = true;
  return a;
}
inline AttributeSpec at_least(AttributeSpec a, double minimum) {
  a.minimum = minimum;
  return a;
}
inline AttributeSpec between(AttributeSpec a, double minimum, double maximum) {
  a.minimum = minimum;
  a.maximum = maximum;
  return a;
}
inline AttributeSpec up_to(AttributeSpec a, double maximum) {
  a.maximum = maximum;
  return a;
}
inline AttributeSpec or_none(AttributeSpec a) {
  a.none_allowed = true;
  return a;
}
inline AttributeSpec count_from(AttributeSpec a, int least) {
  a.min_count = least;
  return a;
}

inline Attributes operator+(Attributes a, const Attributes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
inline Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// ---- groups of attributes that several elements share

inline Attributes named() {
  return {attr("name", Kind::name,
               "Name, unique in its scope; generated from the element's tag if left out.")};
}
inline Attributes named_always(std::string_view doc) {
  return {must(attr("name", Kind::name, doc))};
}

inline Attributes placed() {
  return {
      numbers("xyz", kLength, 3, "Position in the parent element or in `frame`.", "0 0 0"),
      numbers("rpy", kAngle, 3, "Roll, pitch and yaw about fixed x, y and z axes.", "0 0 0"),
      numbers("quat", kNone, 4, "Orientation as a quaternion w x y z, instead of `rpy`."),
      attr("frame", Kind::reference,
           "Body, assembly or frame that xyz and rpy refer to, instead of the parent element.")};
}

inline Words combine_rules() {
  return Words(std::begin(kCombineRuleNames) + 1, std::end(kCombineRuleNames));
}

/// Attributes of a material, which a shape may override.
inline Attributes matter() {
  return {
      above_zero(number("density", kDensity, "Mass per volume.")),
      at_least(number("friction", kNone, "Coulomb friction coefficient."), 0.0),
      at_least(number("rolling-friction", kLength,
                      "Largest torque against rolling over the normal force, of a contact point."),
               0.0),
      at_least(number("spinning-friction", kLength,
                      "Largest torque against turning about the normal over the normal force, of a "
                      "contact point."),
               0.0),
      between(number("restitution", kNone,
                     "Coefficient of restitution: 0 does not bounce, 1 loses nothing."),
              0.0, 1.0),
      choice(
          "friction-combine", combine_rules(),
          "How the friction of a pair is made of the two frictions; of two rules that differ the "
          "later one in this list holds; geometric if neither material says one."),
      choice("restitution-combine", combine_rules(),
             "Likewise of restitution; max if neither material says one."),
      above_zero(number("stiffness", kStiffness,
                        "Stiffness of a contact point; as stiff as the engine can if left out.")),
      attr("color", Kind::color, "Color."),
      attr("texture", Kind::file,
           "Picture file, PNG or JPEG; its colors are multiplied by `color`, if given."),
      above_zero(count_from(
          numbers("texture-size", kLength, 2,
                  "Width and height of one copy of the picture, which then repeats; one number "
                  "for both. If left out one copy covers the face, or a square metre of a plane."),
          1))};
}

/// What others meet and see of a shape.
inline Attributes surface() {
  return {numbers("surface-velocity", kSpeed, 3,
                  "Velocity at which its surface moves along itself, in its own axes, as that of a "
                  "conveyor belt.",
                  "0 0 0"),
          attr("collide", Kind::boolean, "Collides with other bodies.", "true"),
          attr("visible", Kind::boolean, "Visible in images.", "true")};
}

inline Attributes solid() {
  return Attributes{
             attr("material", Kind::reference, "Its material."),
             above_zero(number("mass", kMass, "Mass; from volume and density if left out."))} +
         matter() + surface();
}

inline ElementSpec element(std::string_view group, std::string_view name, std::string_view doc,
                           Attributes attributes, Words children = {},
                           std::string_view example = {}) {
  ElementSpec e;
  e.name = name;
  e.group = group;
  e.doc = doc;
  e.attributes = std::move(attributes);
  e.children = std::move(children);
  e.example = example;
  return e;
}

/// The rows of the sensors.
void add_sensors(std::vector<ElementSpec>& out);
/// Tests and measures.
void add_tests(std::vector<ElementSpec>& out);
/// Regions, templates, rules and their actions.
void add_events(std::vector<ElementSpec>& out, const Words& template_content);
/// Mazes, doors and scattered objects.
void add_mazes(std::vector<ElementSpec>& out);

}  // namespace cogrsim::dsl::rows
