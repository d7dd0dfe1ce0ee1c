#include "common/json_text.h"

#include <cmath>

#include <fmt/format.h>

namespace cogrsim::cli {
namespace {

bool is_plain_array(const Json& value) {
  for (const Json& item : value) {
    if (item.is_structured()) return false;
  }
  return true;
}

std::string string_text(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

void write(const Json& value, int depth, std::string& out) {
  const std::string inner(static_cast<std::size_t>(depth + 1) * 2, ' ');
  const std::string outer(static_cast<std::size_t>(depth) * 2, ' ');
  switch (value.type()) {
    case Json::value_t::number_float: {
      const double number = value.get<double>();
      out += std::isfinite(number) ? fmt::format("{:.17g}", number) : "null";
      break;
    }
    case Json::value_t::string:
      out += string_text(value.get_ref<const std::string&>());
      break;
    case Json::value_t::array: {
      const bool one_line = is_plain_array(value);
      out += '[';
      bool first = true;
      for (const Json& item : value) {
        if (!first) out += one_line ? ", " : ",";
        if (!one_line) out += "\n" + inner;
        first = false;
        write(item, depth + 1, out);
      }
      if (!one_line) out += "\n" + outer;
      out += ']';
      break;
    }
    case Json::value_t::object: {
      out += '{';
      bool first = true;
      for (const auto& [key, item] : value.items()) {
        out += (first ? "\n" : ",\n") + inner + string_text(key) + ": ";
        first = false;
        write(item, depth + 1, out);
      }
      if (!first) out += "\n" + outer;
      out += '}';
      break;
    }
    default:
      out += value.dump();
  }
}

}  // namespace

std::string json_text(const Json& value) {
  std::string out;
  write(value, 0, out);
  out += '\n';
  return out;
}

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json to_json(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json to_json(const Provenance& provenance) { return Json::parse(to_json_text(provenance)); }

Json to_json(const Quat& q) { return Json::array({q.w(), q.x(), q.y(), q.z()}); }

}  // namespace cogrsim::cli
