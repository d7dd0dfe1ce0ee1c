// Materials: named ones, the ones shapes make by overriding, and pairs.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "build/build_scene.h"
#include "cogrsim/core/image.h"

namespace cogrsim::dsl {
namespace {

// Values enter the key with all their bits: two shapes share a material only if nothing differs.
void append(std::string& key, double value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  key.append(bytes, sizeof value);
}

}  // namespace

void Builder::materials() {
  model_.materials.clear();
  model_.materials.emplace_back();
  model_.materials.front().name = "";
  const auto take = [&](const Element& element) {
    if (element.tag() != "material") return;
    Reader r = reader(element);
    Material material;
    material.name = element.path;
    material.origin = element.span();
    material.density = *r.number("density");
    material.friction = *r.number("friction");
    material.rolling_friction = *r.number("rolling-friction");
    material.spinning_friction = *r.number("spinning-friction");
    material.restitution = *r.number("restitution");
    combine_rules(element, material);
    const auto stiffness = r.number("stiffness");
    if (stiffness.given()) material.stiffness = *stiffness;
    const auto color = r.color("color");
    if (color.given()) material.color = *color;
    texture(element, material);
    engine_blocks(element, material.engine_options);
    material_indices_[&element] = static_cast<int>(model_.materials.size());
    model_.materials.push_back(std::move(material));
  };
  // A template has the materials of the scene, with the same indices, and then its own.
  const Element* root = &scene_;
  while (root->parent != nullptr) root = root->parent;
  for_each(*root, take);
  if (root != &scene_) for_each(scene_, take);
}

int Builder::material_index(const Element& material) {
  const auto it = material_indices_.find(&material);
  return it != material_indices_.end() ? it->second : 0;
}

/// Takes the rules of the element for pairs; true: there are any.
bool Builder::combine_rules(const Element& element, Material& material) {
  Reader r = reader(element);
  bool changed = false;
  for (const auto& [attribute, rule] : {std::pair{"friction-combine", &material.friction_combine},
                                        {"restitution-combine", &material.restitution_combine}}) {
    if (!r.has(attribute)) continue;
    const auto name = r.text(attribute);
    if (!name.given()) continue;
    const auto known = std::find(std::begin(kCombineRuleNames), std::end(kCombineRuleNames), *name);
    *rule = static_cast<CombineRule>(known - std::begin(kCombineRuleNames));
    changed = true;
  }
  return changed;
}

/// Takes the texture attributes of the element; true: there are any.
bool Builder::texture(const Element& element, Material& material) {
  Reader r = reader(element);
  bool changed = false;
  const auto size = r.numbers("texture-size");
  if (size.given()) {
    material.texture_size = Eigen::Vector2d((*size).front(), (*size).back());
    changed = true;
  }
  const auto file = r.text("texture");
  if (!file.given()) return changed;
  const SourceSpan& at = element.find("texture")->value_span;
  const std::string path = asset(*file, at, element.trail);
  if (path.empty()) return changed;
  // Checked now: an unusable texture must not be found in the middle of a run.
  const auto [known, is_new] = textures_.try_emplace(path);
  if (is_new) {
    const auto image = load_image(path);
    // All of them stay in memory while pictures are taken.
    constexpr std::int64_t kMostPixels = std::int64_t{128} << 20;
    if (image) texture_pixels_ += std::int64_t{image->width} * image->height;
    if (!image) {
      known->second = image.error().message;
    } else if (texture_pixels_ > kMostPixels) {
      known->second = "the textures of the scene have more than 134 million pixels together";
    }
  }
  if (!known->second.empty()) {
    sink()
        .report("CG0712", at, element.trail, "'" + *file + "': " + known->second)
        .help("textures are PNG or JPEG files of at most 64 million pixels");
    return changed;
  }
  material.texture = path;
  // A texture without a color is shown unchanged, not dimmed by the default grey.
  const Color grey, &now = material.color;
  if (now.r == grey.r && now.g == grey.g && now.b == grey.b && now.a == grey.a)
    material.color = Color{1.0, 1.0, 1.0, 1.0};
  return true;
}

// The material of a rigid assembly determines contact and mass; each part keeps its own appearance.
// Attributes of the shape itself always win.
int Builder::shape_material(const ShapeJob& job) {
  const Element& element = *job.element;
  const int own = job.material != nullptr ? material_index(*job.material) : 0;
  const int base = job.whole_material != nullptr ? material_index(*job.whole_material) : own;
  Reader r = reader(element);
  bool changed = false;
  Material made = model_.materials[base];
  if (own != base) {
    const Material& looks = model_.materials[own];
    if (own != 0) {
      made.color = looks.color;
      made.texture = looks.texture;
      made.texture_size = looks.texture_size;
      changed = true;
    }
  }
  const auto take = [&](std::string_view attribute, double& value) {
    if (!r.has(attribute)) return;
    const auto given = r.number(attribute);
    if (!given.given()) return;
    value = *given;
    changed = true;
  };
  if (element.find("density") != nullptr) take("density", made.density);
  take("friction", made.friction);
  take("rolling-friction", made.rolling_friction);
  take("spinning-friction", made.spinning_friction);
  take("restitution", made.restitution);
  changed = combine_rules(element, made) || changed;
  if (r.has("stiffness")) {
    double stiffness = 0.0;
    take("stiffness", stiffness);
    if (stiffness > 0.0) made.stiffness = stiffness;
  }
  if (r.has("color")) {
    const auto color = r.color("color");
    if (color.given()) {
      made.color = *color;
      changed = true;
    }
  }
  changed = texture(element, made) || changed;
  if (r.has("texture-size") && made.texture.empty() && !r.has("texture") && base == 0)
    fault("CG0712", element, "texture-size", "'texture-size' is given, but there is no texture");
  if (!changed) return base;
  std::string key = std::to_string(base) + ":";
  append(key, made.density);
  append(key, made.friction);
  append(key, made.rolling_friction);
  append(key, made.spinning_friction);
  append(key, made.restitution);
  append(key, static_cast<double>(made.friction_combine));
  append(key, static_cast<double>(made.restitution_combine));
  append(key, made.stiffness.value_or(0.0));
  append(key, made.color.r);
  append(key, made.color.g);
  append(key, made.color.b);
  append(key, made.color.a);
  append(key, made.texture_size ? made.texture_size->x() : 0.0);
  append(key, made.texture_size ? made.texture_size->y() : 0.0);
  key += made.texture;
  const auto [at, is_new] =
      derived_materials_.try_emplace(key, static_cast<int>(model_.materials.size()));
  if (is_new) {
    made.name.clear();
    made.base = base == 0 ? -1 : base;
    made.origin = element.span();
    model_.materials.push_back(std::move(made));
  }
  return at->second;
}

void Builder::material_pairs() {
  std::map<std::pair<int, int>, const Element*> known;
  for_each(scene_, [&](const Element& element) {
    if (element.tag() != "contact" || is_sensor(element.node->spec)) return;
    Reader r = reader(element);
    const auto words = r.words("between");
    if (!words.given() || (*words).size() != 2) return;
    const Element* a = names_.find(element, (*words)[0], Wanted::material);
    const Element* b = names_.find(element, (*words)[1], Wanted::material);
    MaterialPair pair;
    const auto take = [&](std::string_view attribute, std::optional<double>& value) {
      if (const auto given = r.number(attribute); given.given()) value = *given;
    };
    take("friction", pair.friction);
    take("rolling-friction", pair.rolling_friction);
    take("spinning-friction", pair.spinning_friction);
    take("restitution", pair.restitution);
    if (a == nullptr || b == nullptr) return;
    pair.a = material_index(*a);
    pair.b = material_index(*b);
    pair.origin = element.span();
    const auto [first, is_new] = known.try_emplace(std::minmax(pair.a, pair.b), &element);
    if (!is_new) {
      fault("CG0608", element, "between",
            "the pair '" + (*words)[0].text + "' and '" + (*words)[1].text + "' is given twice")
          .note("first here", first->second->span());
      return;
    }
    model_.material_pairs.push_back(pair);
  });
}

}  // namespace cogrsim::dsl
