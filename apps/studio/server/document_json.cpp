#include "document_json.h"

#include <filesystem>

namespace cogrsim::studio {
namespace {

constexpr std::size_t kMostOperations = 1000;

tl::unexpected<Error> lacks(const char* name, const char* expected) {
  return fail("the field '" + std::string(name) + "' must be " + expected);
}

Result<int> id_field(const Json& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end() || !found->is_number_integer())
    return lacks(name, "the id of an element");
  const auto id = found->get<std::int64_t>();
  if (id < 0 || id > 1000000000) return lacks(name, "the id of an element");
  return static_cast<int>(id);
}

Result<std::optional<int>> optional_id(const Json& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end() || found->is_null()) return std::optional<int>{};
  const auto id = id_field(fields, name);
  if (!id) return lacks(name, "the id of an element, or null");
  return std::optional<int>(*id);
}

Result<std::vector<double>> numbers_field(const Json& fields, const char* name, std::size_t count) {
  const auto found = fields.find(name);
  if (found == fields.end() || !found->is_array() || found->size() != count)
    return lacks(name, ("a list of " + std::to_string(count) + " numbers").c_str());
  std::vector<double> out;
  for (const Json& one : *found) {
    if (!one.is_number()) return lacks(name, "a list of numbers");
    out.push_back(one.get<double>());
  }
  return out;
}

#define COGRSIM_TAKE(variable, expression)                              \
  auto variable##_read = (expression);                                  \
  if (!variable##_read) return tl::unexpected(variable##_read.error()); \
  auto variable = std::move(*variable##_read)

Result<dsl::EditOperation> operation_from(const Json& op) {
  if (!op.is_object()) return fail("an operation must be an object");
  COGRSIM_TAKE(what, text_field(op, "op"));
  if (what == "set") {
    COGRSIM_TAKE(element, id_field(op, "element"));
    COGRSIM_TAKE(attribute, text_field(op, "attribute"));
    const auto value = op.find("value");
    if (value == op.end() || !(value->is_string() || value->is_null()))
      return lacks("value", "text, or null");
    dsl::SetAttribute set{element, attribute, std::nullopt};
    if (value->is_string()) set.value = value->get<std::string>();
    return dsl::EditOperation(set);
  }
  if (what == "insert") {
    COGRSIM_TAKE(parent, id_field(op, "parent"));
    COGRSIM_TAKE(xml, text_field(op, "xml"));
    COGRSIM_TAKE(before, optional_id(op, "before"));
    return dsl::EditOperation(dsl::InsertElement{parent, xml, before});
  }
  if (what == "remove") {
    COGRSIM_TAKE(elements, ids_field(op, "elements"));
    return dsl::EditOperation(dsl::RemoveElements{elements});
  }
  if (what == "move") {
    COGRSIM_TAKE(element, id_field(op, "element"));
    COGRSIM_TAKE(parent, id_field(op, "parent"));
    COGRSIM_TAKE(before, optional_id(op, "before"));
    const auto keep = op.find("keep_place");
    if (keep != op.end() && !keep->is_boolean()) return lacks("keep_place", "true or false");
    return dsl::EditOperation(
        dsl::MoveElement{element, parent, before, keep == op.end() || keep->get<bool>()});
  }
  if (what == "rename") {
    COGRSIM_TAKE(element, id_field(op, "element"));
    COGRSIM_TAKE(name, text_field(op, "name"));
    return dsl::EditOperation(dsl::RenameElement{element, name});
  }
  if (what == "duplicate") {
    COGRSIM_TAKE(element, id_field(op, "element"));
    dsl::DuplicateElement copy{element};
    if (op.contains("offset") && !op["offset"].is_null()) {
      COGRSIM_TAKE(offset, numbers_field(op, "offset", 3));
      copy.offset = Vec3(offset[0], offset[1], offset[2]);
    }
    return dsl::EditOperation(copy);
  }
  if (what == "place") {
    COGRSIM_TAKE(element, id_field(op, "element"));
    COGRSIM_TAKE(pose, numbers_field(op, "pose", 7));
    dsl::PlaceElement place{element, {}};
    place.pose.p = Vec3(pose[0], pose[1], pose[2]);
    place.pose.q = Quat(pose[3], pose[4], pose[5], pose[6]);
    return dsl::EditOperation(place);
  }
  if (what == "assemble") {
    COGRSIM_TAKE(elements, ids_field(op, "elements"));
    COGRSIM_TAKE(name, text_field(op, "name"));
    std::string material;
    if (op.contains("material") && !op["material"].is_null()) {
      COGRSIM_TAKE(given, text_field(op, "material"));
      material = given;
    }
    return dsl::EditOperation(dsl::AssembleElements{elements, name, material});
  }
  if (what == "disassemble") {
    COGRSIM_TAKE(element, id_field(op, "element"));
    return dsl::EditOperation(dsl::DisassembleElement{element});
  }
  if (what == "group") {
    COGRSIM_TAKE(elements, ids_field(op, "elements"));
    COGRSIM_TAKE(name, text_field(op, "name"));
    return dsl::EditOperation(dsl::GroupElements{elements, name});
  }
  return fail("there is no operation '" + what + "'", "",
              "set, insert, remove, move, rename, duplicate, place, assemble, disassemble, group");
}

}  // namespace

Result<std::string> text_field(const Json& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end() || !found->is_string()) return lacks(name, "text");
  return found->get<std::string>();
}

Result<std::int64_t> whole_field(const Json& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end() || !found->is_number_integer()) return lacks(name, "a whole number");
  return found->get<std::int64_t>();
}

Result<std::vector<int>> ids_field(const Json& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end() || !found->is_array() || found->empty())
    return lacks(name, "a list of ids of elements, not an empty one");
  std::vector<int> out;
  for (const Json& one : *found) {
    if (!one.is_number_integer()) return lacks(name, "a list of ids of elements");
    const auto id = one.get<std::int64_t>();
    if (id < 0 || id > 1000000000) return lacks(name, "a list of ids of elements");
    out.push_back(static_cast<int>(id));
  }
  return out;
}

Result<std::vector<dsl::EditOperation>> operations_from(const Json& ops) {
  if (!ops.is_array() || ops.empty()) return lacks("ops", "a list of operations, not an empty one");
  if (ops.size() > kMostOperations)
    return fail("an edit has at most " + std::to_string(kMostOperations) + " operations");
  std::vector<dsl::EditOperation> out;
  for (const Json& op : ops) {
    auto one = operation_from(op);
    if (!one)
      return fail("operation " + std::to_string(out.size() + 1) + ": " + one.error().message, "",
                  one.error().hint);
    out.push_back(std::move(*one));
  }
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
