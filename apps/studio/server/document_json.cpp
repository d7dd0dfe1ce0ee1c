#include "document_json.h"

#include <array>
#include <filesystem>

#include "run_fields.h"

namespace cogrsim::studio {
namespace {

dsl::EditOperation operation_from(const Json& op) {
  const auto what = op.at("op").get<std::string>();
  const auto id = [&](const char* name) { return op.at(name).get<int>(); };
  const auto text = [&](const char* name) { return op.at(name).get<std::string>(); };
  const auto ids = [&] { return op.at("elements").get<std::vector<int>>(); };
  if (what == "set") {
    dsl::SetAttribute set{id("element"), text("attribute"), std::nullopt};
    if (const Json& value = op.at("value"); value.is_string()) set.value = value.get<std::string>();
    return set;
  }
  if (what == "insert")
    return dsl::InsertElement{id("parent"), text("xml"), fields::maybe<int>(op, "before")};
  if (what == "remove") return dsl::RemoveElements{ids()};
  if (what == "move") {
    return dsl::MoveElement{id("element"), id("parent"), fields::maybe<int>(op, "before"),
                            op.at("keep_place").get<bool>()};
  }
  if (what == "rename") return dsl::RenameElement{id("element"), text("name")};
  if (what == "duplicate") {
    const auto offset = op.at("offset").get<std::array<double, 3>>();
    dsl::DuplicateElement copy{id("element")};
    copy.offset = Vec3(offset[0], offset[1], offset[2]);
    return copy;
  }
  if (what == "place") {
    const auto pose = op.at("pose").get<std::array<double, 7>>();
    dsl::PlaceElement place{id("element"), {}};
    place.pose.p = Vec3(pose[0], pose[1], pose[2]);
    place.pose.q = Quat(pose[3], pose[4], pose[5], pose[6]);
    return place;
  }
  if (what == "assemble") {
    return dsl::AssembleElements{ids(), text("name"),
                                 fields::maybe<std::string>(op, "material").value_or("")};
  }
  if (what == "group") return dsl::GroupElements{ids(), text("name")};
  return dsl::DisassembleElement{id("element")};
}

}  // namespace

std::vector<dsl::EditOperation> operations_from(const Json& ops) {
  std::vector<dsl::EditOperation> out;
  for (const Json& op : ops) out.push_back(operation_from(op));
  return out;
}

Json tree_json(const std::vector<dsl::OutlineElement>& elements) {
  Json out = Json::array();
  for (const dsl::OutlineElement& e : elements) {
    Json attributes = Json::object();
    for (const auto& [name, value] : e.attributes) attributes[name] = value;
    out.push_back({{"id", e.id},
                   {"parent", e.parent},
                   {"tag", e.tag},
                   {"name", e.name},
                   {"path", e.path},
                   {"line", e.line},
                   {"column", e.column},
                   {"end_line", e.end_line},
                   {"single", e.single},
                   {"attributes", std::move(attributes)}});
  }
  return out;
}

Json problems_json(const std::vector<Diagnostic>& diagnostics, const std::string& path) {
  namespace fs = std::filesystem;
  const std::string folder = fs::path(path).parent_path().string();
  const auto named = [&](const std::string& file) {
    if (!folder.empty() && file.compare(0, folder.size() + 1, folder + "/") == 0)
      return file.substr(folder.size() + 1);
    return file;
  };
  Json out = Json::array();
  for (const Diagnostic& d : diagnostics) {
    Json notes = Json::array();
    for (const DiagnosticNote& note : d.notes)
      notes.push_back({{"message", note.message},
                       {"file", named(note.file)},
                       {"line", note.line},
                       {"column", note.column}});
    out.push_back({{"severity", severity_name(d.severity)},
                   {"code", d.code},
                   {"message", d.message},
                   {"help", d.help},
                   {"file", named(d.file)},
                   {"line", d.line},
                   {"column", d.column},
                   {"length", d.length},
                   {"notes", std::move(notes)}});
  }
  return out;
}

}  // namespace cogrsim::studio
