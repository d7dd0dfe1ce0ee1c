// Reads `<study>` files.
#include "cogrsim/dsl/study.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "cogrsim/physics/backend_choice.h"
#include "report/diagnostics.h"
#include "syntax/node.h"
#include "values/value.h"

namespace cogrsim::dsl {
namespace {

namespace fs = std::filesystem;

/// Attributes of the elements of a study; those with * are required.
struct StudyElement {
  const char* element;
  std::vector<std::string> attributes;
};
const std::vector<StudyElement>& study_elements() {
  static const std::vector<StudyElement> kElements = {
      {"study", {"*scene", "seeds", "backends", "until"}},
      {"vary", {"*param", "*values"}},
      {"set", {"*param", "*value"}},
      {"measure", {"*name", "*signal", "take"}},
  };
  return kElements;
}

class StudyReader {
 public:
  StudyReader(const std::string& path, DiagnosticSink& sink) : path_(path), sink_(sink) {}

  Study read(const Node& root) {
    if (root.name != "study") {
      sink_
          .report(
              "CG0208", root.span, nullptr,
              "the outermost element of a study is <study>, not <" + std::string(root.name) + ">")
          .help("give a scene to the command directly, with --vary");
      return {};
    }
    if (check(root)) read_root(root);
    for (const Node* child : root.children) {
      if (!check(*child)) continue;
      if (child->name == "vary") vary(*child);
      if (child->name == "set") set(*child);
      if (child->name == "measure") measure(*child);
    }
    return std::move(study_);
  }

 private:
  /// Vocabulary of one element; false: not to be read.
  bool check(const Node& node) {
    const bool root = node.parent == nullptr;
    const auto known =
        std::find_if(study_elements().begin(), study_elements().end(), [&](const StudyElement& e) {
          return node.name == e.element && root == (node.name == "study");
        });
    if (known == study_elements().end()) {
      sink_
          .report("CG0201", node.span, nullptr,
                  "there is no element <" + std::string(node.name) + "> in a study")
          .help(suggest(node.name, {"vary", "set", "measure"}));
      return false;
    }
    if (!root) {
      for (const Node* child : node.children)
        sink_.report("CG0202", child->span, nullptr,
                     "no content is allowed inside <" + std::string(node.name) + ">");
    }
    bool good = true;
    std::vector<std::string> names;
    for (const std::string& word : known->attributes) {
      const bool needed = word.front() == '*';
      names.push_back(needed ? word.substr(1) : word);
      if (needed && node.find(names.back()) == nullptr) {
        good = false;
        sink_.report("CG0204", node.span, nullptr,
                     "<" + std::string(node.name) + "> needs " + names.back() + "=");
      }
    }
    for (const Attribute& a : node.attributes) {
      if (std::find(names.begin(), names.end(), a.name) != names.end()) continue;
      sink_
          .report(
              "CG0203", a.name_span, nullptr,
              "<" + std::string(node.name) + "> has no attribute \"" + std::string(a.name) + "\"")
          .help(suggest(a.name, names));
    }
    return good;
  }

  void refuse(const Attribute& a, const Error& error) {
    sink_.report("CG0507", a.value_span, nullptr, error.message).help(error.hint);
  }

  void read_root(const Node& root) {
    const fs::path scene(std::string(root.find("scene")->value));
    study_.scene =
        scene.is_absolute() ? scene.string() : (fs::path(path_).parent_path() / scene).string();
    std::error_code fault;
    if (!fs::is_regular_file(study_.scene, fault))
      sink_
          .report("CG0301", root.find("scene")->value_span, nullptr,
                  "there is no scene \"" + scene.string() + "\"")
          .help("the path is relative to the study: " + study_.scene);
    if (const Attribute* a = root.find("seeds")) {
      auto seeds = parse_seeds(a->value);
      if (seeds)
        study_.seeds = std::move(*seeds);
      else
        refuse(*a, seeds.error());
    }
    if (const Attribute* a = root.find("backends")) {
      for (std::string& choice : split_backend_choices(std::string(a->value))) {
        if (std::count(study_.backends.begin(), study_.backends.end(), choice) > 0)
          refuse(*a, Error("the backend '" + choice + "' is given twice"));
        study_.backends.push_back(std::move(choice));
      }
      if (study_.backends.empty()) refuse(*a, Error("there is no backend in backends="));
    }
    if (const Attribute* a = root.find("until")) {
      const auto values = parse_study_values(a->value);
      if (values && values->size() == 1 && values->front().number > 0.0 &&
          (values->front().unit == "s" || values->front().unit.empty()))
        study_.until = values->front().number;
      else
        refuse(*a, Error("'" + std::string(a->value) + "' is not a time above 0", "",
                         "write it like 5 s"));
    }
  }

  void vary(const Node& node) {
    const Attribute& param = *node.find("param");
    auto values = parse_study_values(node.find("values")->value);
    if (!values) return refuse(*node.find("values"), values.error());
    if (!params_.insert(std::string(param.value)).second)
      return refuse(
          param, Error("the parameter '" + std::string(param.value) + "' is varied or set twice"));
    study_.variations.push_back({std::string(param.value), std::move(*values)});
  }

  void set(const Node& node) {
    const Attribute& param = *node.find("param");
    if (!params_.insert(std::string(param.value)).second)
      return refuse(
          param, Error("the parameter '" + std::string(param.value) + "' is varied or set twice"));
    study_.settings.push_back({std::string(param.value), std::string(node.find("value")->value)});
  }

  void measure(const Node& node) {
    Study::Measure out;
    out.name = std::string(node.find("name")->value);
    out.signal = std::string(node.find("signal")->value);
    if (const Attribute* a = node.find("take")) {
      const auto take = parse_take(a->value);
      if (!take) {
        sink_
            .report("CG0508", a->value_span, nullptr,
                    "'" + std::string(a->value) + "' is not a reduction of a measure")
            .help("the reductions are last, minimum, maximum, mean, integral and first-time");
        return;
      }
      out.take = *take;
    }
    if (!measures_.insert(out.name).second)
      return refuse(*node.find("name"), Error("the measure '" + out.name + "' is given twice"));
    study_.measures.push_back(std::move(out));
  }

  const std::string& path_;
  DiagnosticSink& sink_;
  Study study_;
  std::set<std::string> params_, measures_;
};

}  // namespace

StudyResult read_study(const std::string& path) {
  CompileOptions options;
  DiagnosticSink sink(options.limits);
  SourceFiles files(options, sink);
  StudyResult result;
  if (const Document* document = files.open_plain(path)) {
    Study study = StudyReader(path, sink).read(*document->root);
    if (!sink.has_errors()) result.study = std::move(study);
  }
  result.diagnostics = sink.take();
  return result;
}

bool is_study(const std::string& path) {
  CompileOptions options;
  DiagnosticSink sink(options.limits);
  SourceFiles files(options, sink);
  const Document* document = files.open_plain(path);
  return document != nullptr && document->root->name == "study";
}

}  // namespace cogrsim::dsl
