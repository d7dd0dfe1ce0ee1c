#include "import/sdf_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "import/gazebo.h"

namespace cogrsim::dsl::import {

namespace {

void set_attribute(XmlElement& e, const char* key, const std::string& value) {
  for (auto& [name, old] : e.attributes)
    if (name == key) {
      old = value;
      return;
    }
  e.attributes.emplace_back(key, value);
}

XmlElement& child_or_new(XmlElement& in, const char* tag, const char* text) {
  for (const auto& c : in.children)
    if (c->name == tag) return *c;
  auto made = std::make_unique<XmlElement>();
  made->name = tag;
  made->text = text;
  made->at = in.at;
  in.children.push_back(std::move(made));
  return *in.children.back();
}

/// Whether a file is of SDF 1.4 or older.
bool is_old(const XmlElement& root) {
  const std::string* version = root.find("version");
  return version != nullptr && version->rfind("1.", 0) == 0 &&
         std::strtol(version->c_str() + 2, nullptr, 10) <= 4;
}

void name_frames_of_axes(XmlElement& e, bool old) {
  for (const auto& c : e.children) {
    if (c->name == "world" || c->name == "model" || c->name == "joint") {
      name_frames_of_axes(*c, old);
    } else if (e.name == "joint" && (c->name == "axis" || c->name == "axis2") &&
               (old || child_is_true(*c, "use_parent_model_frame"))) {
      set_attribute(child_or_new(*c, "xyz", "0 0 1"), "expressed_in", "__model__");
    }
  }
}

class Includes {
 public:
  explicit Includes(Context& context) : context_(context) {}

  /// Puts models in the place of each <include>.
  void replace(XmlElement& in, int depth) {
    if (depth > 20)
      context_.refuse(in.at, "CG1402",
                      "models include each other in a cycle, or are nested too deep");
    std::vector<std::unique_ptr<XmlElement>> children;
    for (auto& c : in.children) {
      const bool is_include = c->name == "include";
      const std::string* merge = is_include ? c->find("merge") : nullptr;
      const bool merged = merge != nullptr && (*merge == "true" || *merge == "1");
      if (is_include) c = included(*c);
      if (c == nullptr) continue;
      if (c->name == "model" || c->name == "world") replace(*c, depth + 1);
      if (merged && in.name == "model" && c->find("placement_frame") == nullptr) {
        merge_into(children, std::move(c));
        continue;
      }
      if (merged) context_.approximate(c->at, quoted_name(*c), "is a model of its own, not merged");
      children.push_back(std::move(c));
    }
    in.children = std::move(children);
  }

 private:
  /// The model of an <include>, with what the include says of it; null: left out.
  std::unique_ptr<XmlElement> included(const XmlElement& e) {
    const std::string uri = child_text(e, "uri");
    const std::string element = fmt::format("include '{}'", uri);
    auto path = context_.locate(uri, e.at);
    if (!path)
      path =
          context_.locate(uri + (uri.empty() || uri.back() == '/' ? "" : "/") + "model.sdf", e.at);
    if (!path) {
      context_.left_out(e.at, element, path.error().message);
      return nullptr;
    }
    auto root = context_.parse(*path, e.at);
    name_frames_of_axes(*root, is_old(*root));
    for (auto& m : root->children) {
      if (m->name != "model") continue;
      for (const auto& c : e.children) {
        if (c->name == "name" || c->name == "placement_frame") {
          set_attribute(*m, c->name.c_str(), c->text);
          continue;
        }
        // Its own pose and the like replace those of the model.
        if (c->name == "pose" || c->name == "static")
          m->children.erase(std::remove_if(m->children.begin(), m->children.end(),
                                           [&](const auto& o) { return o->name == c->name; }),
                            m->children.end());
        if (c->name != "uri") m->children.push_back(context_.copy(*c));
      }
      return std::move(m);
    }
    context_.left_out(e.at, element, "there is no model in it");
    return nullptr;
  }

  /// Puts what is in a model among the elements of the model around it; a frame is where the model was.
  static void merge_into(std::vector<std::unique_ptr<XmlElement>>& children,
                         std::unique_ptr<XmlElement> model) {
    const std::string* name = model->find("name");
    const std::string frame = fmt::format("_merged__{}__model__", name == nullptr ? "" : *name);
    auto proxy = std::make_unique<XmlElement>();
    proxy->name = "frame";
    proxy->at = model->at;
    proxy->attributes.emplace_back("name", frame);
    // Placed in the model around it, and held by the link that held the model.
    if (const XmlElement* pose = model->child("pose")) proxy->children.push_back(pose->copy());
    XmlElement& placed = child_or_new(*proxy, "pose", "");
    if (placed.find("relative_to") == nullptr) set_attribute(placed, "relative_to", "__model__");
    const std::string* canonical = model->find("canonical_link");
    if (const XmlElement* link = model->child("link"); canonical == nullptr && link != nullptr)
      canonical = link->find("name");
    if (canonical != nullptr) set_attribute(*proxy, "attached_to", *canonical);
    children.push_back(std::move(proxy));
    for (auto& c : model->children) {
      if (c->name == "pose" || c->name == "static" || c->name == "self_collide" ||
          c->name == "enable_wind" || c->name == "allow_auto_disable")
        continue;
      const bool is_free = c->name == "link" || c->name == "model" ||
                           (c->name == "frame" && c->find("attached_to") == nullptr);
      if (is_free) {
        XmlElement& pose = child_or_new(*c, "pose", "");
        if (pose.find("relative_to") == nullptr && pose.find("frame") == nullptr)
          set_attribute(pose, "relative_to", frame);
      }
      rename_model(*c, frame);
      children.push_back(std::move(c));
    }
  }

  /// `__model__` of a model that was merged.
  static void rename_model(XmlElement& e, const std::string& frame) {
    for (auto& [key, value] : e.attributes)
      if (value == "__model__") value = frame;
    if (e.text == "__model__") e.text = frame;
    for (const auto& c : e.children)
      if (c->name != "model") rename_model(*c, frame);
  }

  Context& context_;
};

}  // namespace

std::unique_ptr<XmlElement> sdf_tree(Context& context, const XmlElement& root) {
  std::unique_ptr<XmlElement> out = root.copy();
  name_frames_of_axes(*out, is_old(*out));
  Includes(context).replace(*out, 0);
  return out;
}

}  // namespace cogrsim::dsl::import
