// Checks a parsed file against the vocabulary, and suggests our names for those of other formats.
#include <algorithm>
#include <array>

#include "language/vocabulary.h"
#include "report/diagnostics.h"
#include "syntax/text.h"

namespace cogrsim::dsl {
namespace {

/// Names in other formats (URDF, SDF, MJCF, Webots).
struct Translation {
  std::string_view theirs, ours;
};
constexpr Translation kElements[] = {{"link", "body"},
                                     {"revolute", "hinge"},
                                     {"prismatic", "slider"},
                                     {"continuous", "hinge"},
                                     {"spherical", "ball"},
                                     {"ball_joint", "ball"},
                                     {"floating", "free"},
                                     {"freejoint", "free"},
                                     {"weld", "fixed"},
                                     {"mimic", "couple"},
                                     {"gearbox", "couple"},
                                     {"coupling", "couple"},
                                     {"slide", "slider"},
                                     {"robot", "assembly"},
                                     {"model", "assembly"},
                                     {"group", "assembly"},
                                     {"actuator", "motor"},
                                     {"include", "import"},
                                     {"xacro:include", "import"},
                                     {"macro", "prototype"},
                                     {"xacro:macro", "prototype"},
                                     {"site", "frame"},
                                     {"camera_view", "view"},
                                     {"viewpoint", "view"},
                                     {"ground", "plane"},
                                     {"cube", "box"},
                                     {"ball_shape", "sphere"},
                                     {"hfield", "heightmap"},
                                     {"terrain", "heightmap"},
                                     {"gyro", "imu"},
                                     {"accelerometer", "imu"},
                                     {"loop", "repeat"},
                                     {"foreach", "for"},
                                     {"property", "param"},
                                     {"xacro:property", "param"},
                                     {"variable", "param"},
                                     {"arg", "param"},
                                     {"plugin", "controller"},
                                     {"surface", "material"},
                                     {"option", "physics"},
                                     {"ray", "lidar"},
                                     {"polyline", "prism"},
                                     {"replicate", "repeat"}};
constexpr Translation kAttributes[] = {{"origin", "xyz (and rpy)"},
                                       {"pos", "xyz"},
                                       {"position", "xyz"},
                                       {"translation", "xyz"},
                                       {"pose", "xyz and rpy"},
                                       {"euler", "rpy"},
                                       {"rotation", "rpy"},
                                       {"orientation", "quat"},
                                       {"rgba", "color"},
                                       {"colour", "color"},
                                       {"mu", "friction"},
                                       {"torsional-friction", "spinning-friction"},
                                       {"bounce", "restitution"},
                                       {"fixed", "static"},
                                       {"height", "length"},
                                       {"id", "name"},
                                       {"weight", "mass"},
                                       {"timestep", "step"},
                                       {"time-step", "step"},
                                       {"dt", "step"},
                                       {"type", "mode"},
                                       {"filename", "file"},
                                       {"src", "file"},
                                       {"href", "file"},
                                       {"uri", "file"},
                                       {"min", "lower"},
                                       {"max", "upper"},
                                       {"effort", "max-effort"},
                                       {"effort", "max-torque"},
                                       {"max-effort", "max-torque (or max-force)"},
                                       {"velocity", "max-speed"},
                                       {"max-velocity", "max-speed"},
                                       {"frequency", "rate"},
                                       {"diameter", "radius"},
                                       {"dimensions", "size"},
                                       {"extents", "size"},
                                       {"half-size", "size"},
                                       {"stiff", "stiffness"},
                                       {"body", "on"},
                                       {"parent", "on"},
                                       {"on", "frame"},
                                       {"prototype", "of"},
                                       {"file", "href"},
                                       {"n", "count"},
                                       {"times", "count"},
                                       {"value", "default"}};

/// Names that have no single counterpart.
std::string element_cure(std::string_view word) {
  if (word == "geom" || word == "geometry" || word == "collision" || word == "visual" ||
      word == "shape") {
    return "write the shape itself: box, sphere, cylinder, capsule, ellipsoid, cone, prism, plane, "
           "mesh "
           "or heightmap" +
           std::string(word == "collision" ? "; an invisible shape has visible=\"false\""
                       : word == "visual"  ? "; a shape without contacts has collide=\"false\""
                                           : "");
  }
  // Names of versions before 0.2.
  if (word == "freeze") return "it is called <make-static> since version 0.2";
  if (word == "unfreeze") return "it is called <make-dynamic> since version 0.2";
  if (word == "tell") return "it is called <log> since version 0.2";
  if (word == "joint") {
    return "write the kind of joint: hinge, slider, ball, universal, gimbal, fixed, cylindrical, "
           "planar, "
           "screw or free";
  }
  if (word == "inertial" || word == "inertia") {
    return "write the attributes mass, com and inertia on <body>";
  }
  if (word == "origin" || word == "pose") return "write the attributes xyz and rpy on the element";
  if (word == "limit" || word == "limits") {
    return "write the attributes lower, upper, max-effort and max-speed on the joint";
  }
  if (word == "else") return "write a second <if> with test=\"not (…)\"";
  if (word == "parent" || word == "child" || word == "axis" || word == "dynamics") {
    return "write \"" + std::string(word == "dynamics" ? "damping and friction" : word) +
           "\" as an attribute of the joint";
  }
  if (word == "world" || word == "worldbody" || word == "sdf" || word == "mujoco") {
    return "the root is <scene>, with its elements directly inside";
  }
  for (const Translation& t : kElements) {
    if (word == t.theirs) return "use <" + std::string(t.ours) + ">";
  }
  return {};
}

/// What an element means here.
const ElementSpec* meaning(const Node& node) {
  if (node.name == "contact" && node.find("on") && !node.find("between")) return &contact_sensor();
  return find_element(node.name);
}

class Checker {
 public:
  Checker(SourceFiles& files, DiagnosticSink& sink) : files_(files), sink_(sink) {}

  void run(Document& document) {
    for (Node& node : document.nodes) node.spec = nullptr;
    Node& root = document.nodes.front();
    if (root.name != "scene") {
      sink_
          .report("CG0208", root.span, nullptr,
                  "the root element is <" + std::string(root.name) + ">, expected <scene>")
          .help(small_letters(root.name) == "scene" ? "names are written in lower case: <scene>"
                : find_element(root.name)
                    ? "put it into <scene name=\"…\" version=\"1\"> … </scene>"
                    : "convert URDF, xacro, MJCF or SDF with cogrsim import");
      document.root = nullptr;
      return;
    }
    root.spec = find_element("scene");
    check_attributes(root);
    // Nodes lie in document order, parents before children.
    for (std::size_t i = 1; i < document.nodes.size(); ++i) check(document.nodes[i]);
  }

 private:
  /// The nearest parent that decides what may stand here; nullptr: inside something faulty.
  const Node* context(const Node& node) const {
    const Node* p = node.parent;
    while (p && p->spec && p->spec->flow) p = p->parent;
    return p;
  }

  void check(Node& node) {
    const Node* parent = node.parent;
    if (!parent->spec) return;  // reported with the parent
    const Node* where = context(node);
    if (!where || !where->spec) return;
    if (is_engine_block(node, files_)) {
      check_text(node, false);
      return;
    }
    const ElementSpec* spec = meaning(node);
    if (!spec) {
      unknown_element(node, *where);
      return;
    }
    if (!may_stand(*spec, *where->spec)) {
      misplaced(node, *where);
      return;
    }
    node.spec = spec;
    check_text(node, spec->text);
    check_attributes(node);
  }

  static bool may_stand(const ElementSpec& what, const ElementSpec& where) {
    if (what.flow) return !where.children.empty();
    return std::find(where.children.begin(), where.children.end(), what.name) !=
           where.children.end();
  }

  void unknown_element(const Node& node, const Node& where) {
    if (where.spec->engine_blocks) {
      // The block of an engine that this machine cannot run as it is.
      if (const auto fault = files_.engine_fault(std::string(node.name))) {
        sink_.report(fault->code.c_str(), node.span, nullptr, fault->message).help(fault->hint);
        return;
      }
    }
    Report report = sink_.report("CG0201", node.span, nullptr,
                                 "unknown element <" + std::string(node.name) + ">");
    const std::string name = small_letters(node.name);
    std::string help = element_cure(name);
    if (find_element(name)) {
      help = "names are written in lower case: <" + name + ">";
    } else if (help.empty()) {
      std::vector<std::string> known;
      for (const auto child : where.spec->children) known.emplace_back(child);
      for (const char* flow : {"repeat", "for", "if"}) known.emplace_back(flow);
      for (const std::string& engine : files_.engine_blocks()) {
        if (where.spec->engine_blocks) known.push_back(engine);
      }
      std::string near = nearest_name(name, known);
      if (near.empty()) {
        for (const ElementSpec& e : vocabulary()) known.emplace_back(e.name);
        near = nearest_name(name, known);
      }
      if (!near.empty()) {
        help = "did you mean <" + near + ">?";
      } else if (where.spec->engine_blocks && where.spec->children.empty()) {
        for (const std::string& engine : files_.engine_blocks())
          help += (help.empty() ? "the options of an engine are allowed here: "
                                  "<"
                                : ", <") +
                  engine + ">";
      }
    }
    report.help(help);
  }

  void misplaced(const Node& node, const Node& where) {
    std::string parents;
    int count = 0;
    for (const ElementSpec& e : vocabulary()) {
      if (std::find(e.children.begin(), e.children.end(), node.name) == e.children.end()) continue;
      if (e.name == where.name) continue;
      parents += (count++ ? ", <" : "<") + std::string(e.name) + ">";
    }
    sink_
        .report(
            "CG0202", node.span, nullptr,
            "<" + std::string(node.name) + "> is not allowed in <" + std::string(where.name) + ">")
        .help(count ? "it belongs in " + parents : "");
  }

  void check_text(const Node& node, bool allowed) {
    if (allowed || node.text.empty()) return;
    sink_
        .report("CG0205", node.text_span, nullptr,
                "unexpected text in <" + std::string(node.name) + ">")
        .help("write comments as <!-- like this -->");
  }

  void check_attributes(const Node& node) {
    const ElementSpec& spec = *node.spec;
    if (node.parent == nullptr) check_text(node, false);
    for (const Attribute& a : node.attributes) {
      if (spec.find(a.name) || spec.open_attributes) continue;
      unknown_attribute(node, a);
    }
    for (const AttributeSpec& a : spec.attributes) {
      if (!a.required || node.find(a.name)) continue;
      sink_
          .report("CG0204", node.span, nullptr,
                  "<" + std::string(node.name) + "> needs the attribute \"" + std::string(a.name) +
                      "\"")
          .help("add " + std::string(a.name) + "=\"…\"");
    }
  }

  void unknown_attribute(const Node& node, const Attribute& a) {
    if (a.name == "xmlns" || a.name.substr(0, 6) == "xmlns:" || a.name.substr(0, 4) == "xsi:") {
      return;  // how an editor finds the schema
    }
    const ElementSpec& spec = *node.spec;
    Report report = sink_.report(
        "CG0203", a.name_span, nullptr,
        "<" + std::string(node.name) + "> has no attribute \"" + std::string(a.name) + "\"");
    const std::string name = small_letters(a.name);
    if (spec.find(name)) {
      report.help("names are written in lower case: " + name);
      return;
    }
    for (const Translation& t : kAttributes) {
      if (name != t.theirs) continue;
      const std::string_view first = t.ours.substr(0, t.ours.find(' '));
      if (!spec.find(first)) continue;
      report.help("use " + std::string(t.ours) +
                  (name == "diameter" ? ", which is half of it" : ""));
      return;
    }
    std::vector<std::string> known;
    for (const AttributeSpec& k : spec.attributes) known.emplace_back(k.name);
    std::string near = nearest_name(name, known);
    // A word with _ for -, or in camel case.
    std::string dashed;
    for (const char c : a.name) {
      if (c == '_') {
        dashed += '-';
      } else if (c >= 'A' && c <= 'Z') {
        dashed += '-';
        dashed += static_cast<char>(c - 'A' + 'a');
      } else {
        dashed += c;
      }
    }
    if (spec.find(dashed)) near = dashed;
    if (!near.empty()) {
      report.help("did you mean \"" + near + "\"?");
      return;
    }
    std::string list;
    for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
    report.help(list.empty() ? "it takes none" : "it takes " + list);
  }

  SourceFiles& files_;
  DiagnosticSink& sink_;
};

}  // namespace

bool is_engine_block(const Node& node, const SourceFiles& files) {
  const Node* p = node.parent;
  while (p && p->spec && p->spec->flow) p = p->parent;
  if (!p || !p->spec || !p->spec->engine_blocks || find_element(node.name)) return false;
  const auto& words = files.engine_blocks();
  return std::find(words.begin(), words.end(), node.name) != words.end();
}

void check_vocabulary(Document& document, SourceFiles& files, DiagnosticSink& sink) {
  if (document.root) Checker(files, sink).run(document);
}

}  // namespace cogrsim::dsl
