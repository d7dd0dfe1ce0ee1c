// Reads the protocol buffer of an ONNX file (onnx.proto3 of the ONNX project: the numbers of the
// fields). Fields that do not matter here are skipped; those that would change the result and are
// not known end the reading.
#include "policy/onnx_model.h"

#include <cstring>

#include <fmt/format.h>
#include <protozero/pbf_reader.hpp>

#include "cogrsim/core/shown_text.h"

namespace cogrsim::policy {
namespace {

using protozero::pbf_reader;
using protozero::pbf_wire_type;
using protozero::tag_and_type;

constexpr auto kBytes = pbf_wire_type::length_delimited;
constexpr auto kVarint = pbf_wire_type::varint;
constexpr auto kFixed32 = pbf_wire_type::fixed32;

// Types of elements, of TensorProto.DataType.
constexpr int kFloat = 1, kInt32 = 6, kInt64 = 7;

// Names, of nodes and of what goes into them, take more memory than bytes of a file.
constexpr std::size_t kNames = 400'000;
constexpr std::size_t kListed = 64;  // numbers of an attribute

const char* type_name(std::int64_t type) {
  static const char* const names[] = {"undefined",  "float32", "uint8",  "int8",   "uint16",
                                      "int16",      "int32",   "int64",  "text",   "bool",
                                      "float16",    "float64", "uint32", "uint64", "complex64",
                                      "complex128", "bfloat16"};
  return type >= 0 && type < 17 ? names[type] : "an unknown type";
}

[[noreturn]] void refuse_type(std::int64_t type, const std::string& what) {
  throw NetworkError(
      kNotEvaluated,
      fmt::format("{} is of {}, and only float32 is evaluated", what, type_name(type)),
      "export the network in float32");
}

// A repeated number, packed or one by one.
template <class Number, class One, class All>
void read_numbers(pbf_reader& field, std::vector<Number>& out, std::size_t limit, One one,
                  All all) {
  if (field.wire_type() == kBytes) {
    for (const auto value : all(field)) {
      if (out.size() >= limit) throw NetworkError(kBeyondLimits, "a list in it is too long");
      out.push_back(static_cast<Number>(value));
    }
  } else {
    if (out.size() >= limit) throw NetworkError(kBeyondLimits, "a list in it is too long");
    out.push_back(static_cast<Number>(one(field)));
  }
}

void read_integers(pbf_reader& field, std::vector<std::int64_t>& out, std::size_t limit) {
  read_numbers(
      field, out, limit, [](pbf_reader& f) { return f.get_int64(); },
      [](pbf_reader& f) { return f.get_packed_int64(); });
}

void read_floats(pbf_reader& field, std::vector<float>& out, std::size_t limit) {
  read_numbers(
      field, out, limit, [](pbf_reader& f) { return f.get_float(); },
      [](pbf_reader& f) { return f.get_packed_float(); });
}

class Reader {
 public:
  explicit Reader(const NetworkLimits& limits) : limits_(limits) {}

  OnnxModel model(pbf_reader in) {
    bool has_graph = false;
    pbf_reader graph;
    while (in.next()) {
      switch (in.tag_and_type()) {
        case tag_and_type(7, kBytes):
          graph = in.get_message();
          has_graph = true;
          break;
        case tag_and_type(8, kBytes):
          opset(in.get_message());
          break;
        case tag_and_type(14, kBytes):
          metadata(in.get_message());
          break;
        case tag_and_type(25, kBytes):
          throw NetworkError(kNotEvaluated, "it defines functions of its own",
                             "export it with all functions inlined");
        default:
          in.skip();
      }
    }
    if (!has_graph) throw NetworkError(kNotOnnx, "it has no graph: it is no ONNX file");
    if (out_.opset < 7 || out_.opset > 25)
      throw NetworkError(
          kNotEvaluated,
          out_.opset == 0
              ? std::string("it does not say which version of the operators it uses")
              : fmt::format("its operators are those of version {}, and 7 to 25 are known",
                            out_.opset),
          "export it with opset_version=17");
    this->graph(graph);
    return std::move(out_);
  }

 private:
  // Names reach terminals: no control characters, and not without end.
  std::string text_of(pbf_reader& field) {
    const auto view = field.get_view();
    if (view.size() > 4096)
      throw NetworkError(kBeyondLimits, "a name in it is longer than 4096 bytes");
    if (++names_ > kNames)
      throw NetworkError(kBeyondLimits, fmt::format("it has more than {} names", kNames));
    return one_line(std::string(view.data(), view.size()));
  }

  // What the constants together may still have.
  std::size_t values_left() const { return limits_.tensor_values - values_; }

  void opset(pbf_reader in) {
    std::string domain;
    std::int64_t version = 0;
    while (in.next()) {
      if (in.tag_and_type() == tag_and_type(1, kBytes))
        domain = text_of(in);
      else if (in.tag_and_type() == tag_and_type(2, kVarint))
        version = in.get_int64();
      else
        in.skip();
    }
    if (domain.empty() || domain == "ai.onnx") out_.opset = version;
  }

  void metadata(pbf_reader in) {
    std::string key, value;
    while (in.next()) {
      if (in.tag_and_type() == tag_and_type(1, kBytes))
        key = text_of(in);
      else if (in.tag_and_type() == tag_and_type(2, kBytes))
        value = in.get_string();
      else
        in.skip();
    }
    out_.metadata[key] = value;
  }

  void graph(pbf_reader in) {
    while (in.next()) {
      switch (in.tag_and_type()) {
        case tag_and_type(1, kBytes):
          if (out_.nodes.size() >= limits_.nodes)
            throw NetworkError(kBeyondLimits,
                               fmt::format("it has more than {} nodes", limits_.nodes));
          out_.nodes.push_back(node(in.get_message()));
          break;
        case tag_and_type(5, kBytes): {
          std::string name;
          Tensor constant = tensor(in.get_message(), name);
          if (out_.constants.size() >= limits_.nodes)
            throw NetworkError(kBeyondLimits,
                               fmt::format("it has more than {} constants", limits_.nodes));
          if (!out_.constants.emplace(name, std::move(constant)).second)
            throw NetworkError(kDoesNotFit, fmt::format("it has two constants '{}'", name));
          break;
        }
        case tag_and_type(11, kBytes):
          ports_.push_back(in.get_message());
          break;
        case tag_and_type(12, kBytes):
          out_.outputs.push_back(port(in.get_message(), true));
          break;
        case tag_and_type(15, kBytes):
          throw NetworkError(kNotEvaluated, "it has sparse constants", "export it with dense ones");
        default:
          in.skip();
      }
      if (ports_.size() > limits_.nodes || out_.outputs.size() > limits_.nodes)
        throw NetworkError(kBeyondLimits, "it has too many inputs or outputs");
    }
    // Up to version 3 of the format the constants are inputs, too, of any type.
    for (const pbf_reader& each : ports_) {
      if (out_.constants.count(port_name(each)) == 0) out_.inputs.push_back(port(each));
    }
  }

  std::string port_name(pbf_reader in) {
    std::string name;
    while (in.next()) {
      if (in.tag_and_type() == tag_and_type(1, kBytes))
        name = text_of(in);
      else
        in.skip();
    }
    return name;
  }

  // The shape of an output is what the nodes make of it, whatever the file says.
  NetworkPort port(pbf_reader in, bool is_output = false) {
    NetworkPort out;
    std::int64_t type = 0;
    bool shaped = false;
    while (in.next()) {
      if (in.tag_and_type() == tag_and_type(1, kBytes)) {
        out.name = text_of(in);
      } else if (in.tag_and_type() == tag_and_type(2, kBytes)) {
        pbf_reader kind = in.get_message();
        while (kind.next()) {
          if (kind.tag_and_type() != tag_and_type(1, kBytes)) {
            kind.skip();
            continue;
          }
          pbf_reader description = kind.get_message();
          while (description.next()) {
            if (description.tag_and_type() == tag_and_type(1, kVarint)) {
              type = description.get_int64();
            } else if (description.tag_and_type() == tag_and_type(2, kBytes)) {
              shape(description.get_message(), out.shape);
              shaped = true;
            } else {
              description.skip();
            }
          }
        }
      } else {
        in.skip();
      }
    }
    if (type != kFloat)
      refuse_type(type, fmt::format("its {} '{}'", is_output ? "output" : "input", out.name));
    if (is_output) return out;
    for (std::size_t i = 0; i < out.shape.size(); ++i) {
      // One decision at a time: the batch that exporters leave open has one row.
      if (out.shape[i] < 0 && i == 0) out.shape[i] = 1;
      if (out.shape[i] >= 0) continue;
      throw NetworkError(
          kNotEvaluated,
          fmt::format("its input '{}' leaves the size of dimension {} open", out.name, i),
          "export it with fixed sizes; only the first dimension, the batch, may be open");
    }
    if (!shaped)
      throw NetworkError(kNotEvaluated, fmt::format("its input '{}' has no shape", out.name),
                         "export it with fixed sizes");
    out.size = element_count(out.shape, limits_.tensor_values, "'" + out.name + "'");
    return out;
  }

  // Open dimensions are -1.
  static void shape(pbf_reader in, Dims& out) {
    while (in.next()) {
      if (in.tag_and_type() != tag_and_type(1, kBytes)) {
        in.skip();
        continue;
      }
      if (out.size() >= 8)
        throw NetworkError(kNotEvaluated, "it has a tensor of over 8 dimensions");
      std::int64_t size = -1;
      pbf_reader dim = in.get_message();
      while (dim.next()) {
        if (dim.tag_and_type() == tag_and_type(1, kVarint))
          size = dim.get_int64();
        else
          dim.skip();
      }
      out.push_back(size > 0 ? size : -1);
    }
  }

  Node node(pbf_reader in) {
    Node out;
    std::string domain;
    while (in.next()) {
      switch (in.tag_and_type()) {
        case tag_and_type(1, kBytes):
          out.inputs.push_back(text_of(in));
          break;
        case tag_and_type(2, kBytes):
          out.outputs.push_back(text_of(in));
          break;
        case tag_and_type(3, kBytes):
          out.name = text_of(in);
          break;
        case tag_and_type(4, kBytes):
          out.op = text_of(in);
          break;
        case tag_and_type(5, kBytes):
          attribute(in.get_message(), out);
          break;
        case tag_and_type(7, kBytes):
          domain = text_of(in);
          break;
        default:
          in.skip();
      }
      if (out.inputs.size() + out.outputs.size() > 4096)
        throw NetworkError(kBeyondLimits, "a node of it has over 4096 inputs and outputs");
    }
    if (!domain.empty() && domain != "ai.onnx")
      throw NetworkError(
          kNotEvaluated,
          fmt::format("{} is an operator of '{}', which is not ONNX's own", out.label(), domain),
          "export it with standard operators only");
    return out;
  }

  void attribute(pbf_reader in, Node& out) {
    std::string name;
    Attribute a;
    while (in.next()) {
      switch (in.tag_and_type()) {
        case tag_and_type(1, kBytes):
          name = text_of(in);
          break;
        case tag_and_type(2, kFixed32):
          a.number = in.get_float();
          break;
        case tag_and_type(3, kVarint):
          a.integer = in.get_int64();
          break;
        case tag_and_type(4, kBytes):
          a.text = text_of(in);
          break;
        case tag_and_type(5, kBytes): {
          std::string unused;
          a.tensor = tensor(in.get_message(), unused);
          break;
        }
        case tag_and_type(6, kBytes):
        case tag_and_type(11, kBytes):
          throw NetworkError(
              kNotEvaluated,
              "it has control flow: a node with a graph in its attribute '" + name + "'",
              "export it without If, Loop and Scan");
        case tag_and_type(7, kFixed32):
        case tag_and_type(7, kBytes):
          read_floats(in, a.numbers, kListed);
          break;
        case tag_and_type(8, kVarint):
        case tag_and_type(8, kBytes):
          read_integers(in, a.integers, kListed);
          break;
        case tag_and_type(9, kBytes):
          if (a.texts.size() >= 64) throw NetworkError(kBeyondLimits, "a list in it is too long");
          a.texts.push_back(text_of(in));
          break;
        default:
          in.skip();
      }
    }
    if (out.attributes.size() >= 64)
      throw NetworkError(kBeyondLimits, "a node of it has over 64 attributes");
    out.attributes[name] = std::move(a);
  }

  Tensor tensor(pbf_reader in, std::string& name) {
    Tensor out;
    std::int64_t type = 0;
    std::string_view raw;
    bool has_raw = false, elsewhere = false;
    while (in.next()) {
      switch (in.tag_and_type()) {
        case tag_and_type(1, kVarint):
        case tag_and_type(1, kBytes):
          read_integers(in, out.dims, 8);
          break;
        case tag_and_type(2, kVarint):
          type = in.get_int64();
          break;
        case tag_and_type(4, kFixed32):
        case tag_and_type(4, kBytes):
          read_floats(in, out.values, values_left());
          break;
        case tag_and_type(5, kVarint):
        case tag_and_type(5, kBytes):
        case tag_and_type(7, kVarint):
        case tag_and_type(7, kBytes):
          read_integers(in, out.integers, values_left());
          break;
        case tag_and_type(8, kBytes):
          name = text_of(in);
          break;
        case tag_and_type(9, kBytes): {
          const auto view = in.get_view();
          raw = {view.data(), view.size()};
          has_raw = true;
          break;
        }
        case tag_and_type(13, kBytes):
          elsewhere = true;
          in.skip();
          break;
        case tag_and_type(14, kVarint):
          elsewhere = elsewhere || in.get_int64() == 1;
          break;
        default:
          in.skip();
      }
    }
    const std::string what = name.empty() ? "a constant of it" : "its constant '" + name + "'";
    if (elsewhere)
      throw NetworkError(kNotEvaluated, what + " lies in another file",
                         "export it as one file: external_data=False");
    if (type != kFloat && type != kInt32 && type != kInt64) refuse_type(type, what);
    fill(out, type, raw, has_raw, what);
    return out;
  }

  // The values as `raw` has them, little-endian, or as lists have brought them already; as many as
  // the dimensions say.
  void fill(Tensor& out, std::int64_t type, std::string_view raw, bool has_raw,
            const std::string& what) {
    const std::size_t count = element_count(out.dims, values_left(), what);
    values_ += count;
    out.whole = type != kFloat;
    const std::size_t width = type == kInt64 ? 8 : 4;
    if (has_raw) {
      if (raw.size() != count * width)
        throw NetworkError(kDoesNotFit, fmt::format("{} has {} bytes where its shape needs {}",
                                                    what, raw.size(), count * width));
      out.values.clear();
      out.integers.clear();
      if (!out.whole) {
        out.values.resize(count);
        if (count > 0) std::memcpy(out.values.data(), raw.data(), raw.size());
      } else {
        out.integers.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
          if (type == kInt64) {
            std::memcpy(&out.integers[i], raw.data() + 8 * i, 8);
          } else {
            std::int32_t value = 0;
            std::memcpy(&value, raw.data() + 4 * i, 4);
            out.integers[i] = value;
          }
        }
      }
    }
    if (out.size() != count || (out.whole ? out.values.size() : out.integers.size()) != 0)
      throw NetworkError(kDoesNotFit, fmt::format("{} has {} values where its shape needs {}", what,
                                                  out.size(), count));
  }

  const NetworkLimits& limits_;
  OnnxModel out_;
  std::vector<pbf_reader> ports_;
  std::size_t names_ = 0, values_ = 0;  // so far
};

}  // namespace

std::size_t element_count(const Dims& dims, std::size_t limit, const std::string& what) {
  if (dims.size() > 8) throw NetworkError(kNotEvaluated, what + " has over 8 dimensions");
  std::size_t count = 1;
  for (const std::int64_t dim : dims) {
    if (dim < 0) throw NetworkError(kDoesNotFit, what + " has a dimension of negative size");
    if (dim != 0 && count > limit / static_cast<std::size_t>(dim))
      throw NetworkError(kBeyondLimits, fmt::format("{} has over {} values", what, limit));
    count *= static_cast<std::size_t>(dim);
  }
  return count;
}

OnnxModel read_onnx(std::string_view bytes, const NetworkLimits& limits) {
  try {
    return Reader(limits).model(pbf_reader(bytes.data(), bytes.size()));
  } catch (const protozero::exception& e) {
    throw NetworkError(kNotOnnx, fmt::format("it is no ONNX file, or a broken one: {}", e.what()));
  }
}

}  // namespace cogrsim::policy
