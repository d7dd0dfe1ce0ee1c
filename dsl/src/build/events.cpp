// Regions and templates, and the objects that may be added during a run.
#include <algorithm>
#include <cctype>
#include <sstream>

#include "build/build_scene.h"

namespace cogrsim::dsl {
namespace {

template <class Elements>
bool among(const Elements& elements, const std::string& name) {
  return std::any_of(elements.begin(), elements.end(),
                     [&](const auto& element) { return element.name == name; });
}

// Whether such an element is one once it is in the model.
bool becomes(const Element& element, Thing thing) {
  const std::string_view tag = element.tag();
  const bool matter = is_shape(tag) || tag == "body" || tag == "assembly" || tag == "instance" ||
                      tag == "maze" || tag == "door";
  switch (thing) {
    case Thing::door:
    case Thing::region:
    case Thing::templates:
      return tag == describe(thing);
    case Thing::owner:
      return matter;
    case Thing::posed:
      return matter || tag == "frame";
    case Thing::joint:
      return is_joint(tag);
    case Thing::motor:
      return tag == "motor" || tag == "servo";
    case Thing::sensor:
      return is_sensor(element.node->spec);
    case Thing::controller:
      return tag == "controller" || tag == "supervisor";
  }
  return false;
}

template <class Elements>
void add_names(const Elements& elements, std::vector<std::string>& names) {
  for (const auto& element : elements) names.push_back(element.name);
}

}  // namespace

const char* describe(Thing thing) {
  switch (thing) {
    case Thing::door:
      return "door";
    case Thing::region:
      return "region";
    case Thing::owner:
      return "assembly or body";
    case Thing::posed:
      return "body, assembly or frame";
    case Thing::joint:
      return "joint";
    case Thing::motor:
      return "motor";
    case Thing::sensor:
      return "sensor";
    case Thing::controller:
      return "controller or supervisor";
    case Thing::templates:
      return "template";
  }
  return "";
}

bool has_thing(const SceneModel& model, const std::string& name, Thing thing) {
  switch (thing) {
    case Thing::door:
      return among(model.doors, name);
    case Thing::region:
      return among(model.regions, name);
    case Thing::owner:
      return among(model.assemblies, name) || among(model.bodies, name);
    case Thing::posed:
      return among(model.assemblies, name) || among(model.bodies, name) ||
             among(model.frames, name);
    case Thing::joint:
      return among(model.joints, name);
    case Thing::motor:
      return among(model.motors, name);
    case Thing::sensor:
      return among(model.sensors, name);
    case Thing::controller:
      return among(model.controllers, name) || among(model.supervisors, name);
    case Thing::templates:
      return among(model.templates, name);
  }
  return false;
}

std::vector<std::string> names_of(const SceneModel& model, Thing thing) {
  std::vector<std::string> names;
  switch (thing) {
    case Thing::door:
      add_names(model.doors, names);
      break;
    case Thing::region:
      add_names(model.regions, names);
      break;
    case Thing::posed:
      add_names(model.frames, names);
      [[fallthrough]];
    case Thing::owner:
      add_names(model.assemblies, names);
      add_names(model.bodies, names);
      break;
    case Thing::joint:
      add_names(model.joints, names);
      break;
    case Thing::motor:
      add_names(model.motors, names);
      break;
    case Thing::sensor:
      add_names(model.sensors, names);
      break;
    case Thing::controller:
      add_names(model.controllers, names);
      add_names(model.supervisors, names);
      break;
    case Thing::templates:
      add_names(model.templates, names);
      break;
  }
  return names;
}

// The content of a template as a scene of its own, in the template's frame.
SceneModelPtr Builder::fragment() {
  model_.files.clear();
  for (int i = 0; i < context_.files.size(); ++i)
    model_.files.push_back(context_.files.file(i).name);
  model_.name = scene_.name;
  materials();
  matter_and_devices();
  forces_and_targets();
  material_pairs();
  collision_pairs();
  check_delays();
  if (sink().has_errors()) return nullptr;
  start();
  spring_lengths();
  if (sink().has_errors()) return nullptr;
  check_overlaps();
  check_mass_ratios();
  check_loads();
  check_rates();
  check_drives();
  finish_model(model_);
  return std::make_shared<const SceneModel>(std::move(model_));
}

void Builder::templates() {
  for_each(scene_, [&](const Element& element) {
    if (element.tag() != "template") return;
    // Each looks for materials among all that is around it.
    if (!spend(element, 10 * scene_.children.size())) return;
    const int errors = sink().error_count();
    TemplateModel made;
    made.name = element.path;
    made.origin = element.span();
    made.fragment = Builder(context_, element).fragment();
    if (made.fragment != nullptr && made.fragment->bodies.empty())
      fault("CG1306", element, "the template '" + element.path + "' has no body")
          .help("add shapes, bodies, assemblies or instances");
    // A failed template keeps its name, so that a spawn of it is not reported.
    if (made.fragment == nullptr && sink().error_count() == errors && !sink().has_errors()) return;
    model_.templates.push_back(std::move(made));
  });
  // What actions may add, for the names that refer to it.
  for_each(scene_, [&](const Element& element) {
    if (element.tag() == "spawn") {
      Coming coming;
      const auto of = reader(element).word("of");
      const auto name = reader(element).word("name");
      if (!of.given() || name.failed()) return;
      const std::string full = full_name(element, (*of).text, Thing::templates);
      if (!spend(element, 8 * model_.templates.size())) return;
      for (const TemplateModel& known : model_.templates)
        if (known.name == full) coming.fragment = known.fragment;
      coming.numbered = !name.given();
      coming.name = coming.numbered ? full + "_" : (*name).text;
      coming_.push_back(std::move(coming));
    } else if (element.tag() == "attach") {
      const auto name = reader(element).word("name");
      if (name.given()) coming_.push_back({(*name).text, false, nullptr, true});
    }
  });
}

// As a name of the model; empty: there is none.
std::string Builder::full_name(const Element& from, const std::string& name, Thing thing) {
  const Names::Found found = names_.peek(from, name);
  if (found.element != nullptr && has_thing(model_, found.element->path, thing))
    return found.element->path;
  for (const Element* level = from.parent; level != nullptr; level = level->parent) {
    const std::string candidate = level->path.empty() ? name : level->path + "." + name;
    if (has_thing(model_, candidate, thing)) return candidate;
  }
  return {};
}

/// Whether an action of the scene adds something of this name.
bool Builder::may_come(const std::string& name, Thing thing) const {
  for (const Coming& coming : coming_) {
    if (coming.is_joint) {
      if (thing == Thing::joint && name == coming.name) return true;
      continue;
    }
    if (!name.starts_with(coming.name)) continue;
    std::size_t end = coming.name.size();
    if (coming.numbered) {
      const std::size_t digits = end;
      while (end < name.size() && std::isdigit(static_cast<unsigned char>(name[end])) != 0) ++end;
      if (end == digits) continue;
    }
    if (end == name.size()) {
      if (thing == Thing::owner || thing == Thing::posed) return true;
    } else if (name[end] == '.' && (coming.fragment == nullptr ||
                                    has_thing(*coming.fragment, name.substr(end + 1), thing))) {
      return true;
    }
  }
  return false;
}

/// Whether `added` of the enclosing rule or region lists this name.
bool Builder::is_announced(const Element& from, const std::string& name) {
  const Element* holder = &from;
  while (holder != nullptr && holder->find("added") == nullptr) holder = holder->parent;
  if (holder == nullptr) return false;
  const auto names = reader(*holder).text("added");
  std::istringstream words(*names);
  for (std::string word; words >> word;) {
    if (name.starts_with(word) && (name.size() == word.size() || name[word.size()] == '.'))
      return true;
  }
  return false;
}

// The same with error reports; nullopt: reported.
std::optional<std::string> Builder::present_name(const Element& from, const Word& word,
                                                 Thing thing) {
  std::string full = full_name(from, word.text, thing);
  if (!full.empty()) return full;
  if (may_come(word.text, thing)) return word.text;
  if (thing != Thing::templates && is_announced(from, word.text)) return word.text;
  const Names::Found found = names_.peek(from, word.text);
  if (found.lost) return std::nullopt;
  // It was refused, and that is reported.
  if (found.element != nullptr && becomes(*found.element, thing) && sink().has_errors())
    return std::nullopt;
  // A supervisor may add anything.
  const bool may_be_made =
      !model_.supervisors.empty() && thing != Thing::templates && found.element == nullptr;
  Report report =
      sink().report(thing == Thing::templates ? "CG1306"
                    : may_be_made             ? "CG2030"
                                              : "CG1302",
                    word.span, from.trail,
                    found.element != nullptr
                        ? "'" + word.text + "' is " + kind_of(*found.element) + ", expected " +
                              (thing == Thing::owner ? "an " : "a ") + describe(thing)
                        : "there is no " + std::string(describe(thing)) + " '" + word.text +
                              (thing == Thing::templates ? "'" : "' here, and no action adds one"));
  const std::vector<std::string> known = names_of(model_, thing);
  const std::string help = known.empty() ? "the scene has none" : suggest(word.text, known);
  if (!may_be_made) {
    report.help(help);
    return std::nullopt;
  }
  report.help((help.empty() ? "" : help + (help.back() == '?' ? " " : "; ")) + "write added=\"" +
              word.text + "\" if a supervisor adds it");
  return word.text;
}

void Builder::region(const Element& element) {
  RegionModel region;
  region.name = element.path;
  region.origin = element.span();
  region.assembly = note(element).assembly;
  Reader r = reader(element);
  const bool box = r.has("size"), ball = r.has("radius");
  if (box == ball)
    fault("CG1301", element, ball ? "radius" : "name",
          box ? "a region is a box or a ball, not both: it has a size and a radius"
              : "region '" + element.name + "' has no shape")
        .help(box ? "leave out one of them" : "give it a size=\"1 1 1 m\" or a radius=\"50 cm\"");
  const auto size = r.vec3("size");
  const auto radius = r.number("radius");
  if (size.given()) region.size = *size;
  if (radius.given()) region.radius = *radius;
  region.type = ball ? RegionModel::Type::sphere : RegionModel::Type::box;
  region.body = carrier(element);
  const Pose& X_WR = note(element).X_W;
  region.X_BR = region.body == kWorld ? X_WR : model_.bodies[region.body].X_WB.inverse() * X_WR;
  if (r.has("who")) {
    const auto words = r.words("who");
    if (words.failed()) return;
    if ((*words).empty())
      fault("CG1302", element, "who", "this region detects nothing: 'who' is empty")
          .help(
              "name bodies, assemblies or frames; leave 'who' out to detect everything that can "
              "move");
    for (const Word& word : *words)
      if (auto name = present_name(element, word, Thing::posed)) region.who.push_back(*name);
  }
  model_.regions.push_back(std::move(region));
}

}  // namespace cogrsim::dsl
