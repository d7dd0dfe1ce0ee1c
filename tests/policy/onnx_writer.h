// Writes small networks as ONNX files, independently of the reader: the numbers are those of onnx.proto3.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <protozero/pbf_writer.hpp>

namespace cogrsim::test {

using Ints = std::vector<std::int64_t>;

class OnnxWriter {
 public:
  explicit OnnxWriter(std::int64_t opset = 17) : opset_(opset) {}

  /// `type` is that of TensorProto.DataType: 1 float32.
  OnnxWriter& input(const std::string& name, const Ints& dims, int type = 1) {
    return port(11, name, dims, type);
  }
  OnnxWriter& output(const std::string& name, const Ints& dims) { return port(12, name, dims, 1); }

  OnnxWriter& constant(const std::string& name, const Ints& dims,
                       const std::vector<float>& values) {
    std::string bytes;
    protozero::pbf_writer tensor(bytes);
    tensor.add_packed_int64(1, dims.begin(), dims.end());
    tensor.add_int32(2, 1);
    tensor.add_string(8, name);
    tensor.add_bytes(9, reinterpret_cast<const char*>(values.data()), values.size() * 4);
    return part(5, bytes);
  }
  OnnxWriter& integers(const std::string& name, const Ints& values) {
    std::string bytes;
    protozero::pbf_writer tensor(bytes);
    tensor.add_int64(1, static_cast<std::int64_t>(values.size()));
    tensor.add_int32(2, 7);
    tensor.add_packed_int64(7, values.begin(), values.end());
    tensor.add_string(8, name);
    return part(5, bytes);
  }

  struct Attribute {
    template <class Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
    Attribute(std::string n, Integer i) : name(std::move(n)), integer(i) {}
    Attribute(std::string n, float f) : name(std::move(n)), number(f), is_number(true) {}
    Attribute(std::string n, const char* t) : name(std::move(n)), text(t) {}
    std::string name;
    std::int64_t integer = 0;
    float number = 0.0f;
    bool is_number = false;
    std::string text;
  };
  OnnxWriter& node(const std::string& op, const std::vector<std::string>& in,
                   const std::vector<std::string>& out,
                   const std::vector<Attribute>& attributes = {}, const std::string& domain = {}) {
    std::string bytes;
    protozero::pbf_writer writer(bytes);
    for (const auto& name : in) writer.add_string(1, name);
    for (const auto& name : out) writer.add_string(2, name);
    writer.add_string(4, op);
    for (const Attribute& a : attributes) {
      protozero::pbf_writer attribute(writer, 5);
      attribute.add_string(1, a.name);
      if (a.is_number)
        attribute.add_float(2, a.number);
      else if (!a.text.empty())
        attribute.add_string(4, a.text);
      else
        attribute.add_int64(3, a.integer);
      attribute.add_int32(20, a.is_number ? 1 : !a.text.empty() ? 3 : 2);  // which of them it is
    }
    if (!domain.empty()) writer.add_string(7, domain);
    return part(1, bytes);
  }
  /// A field of the graph as it is.
  OnnxWriter& part(int tag, const std::string& bytes) {
    protozero::pbf_writer(graph_).add_message(static_cast<protozero::pbf_tag_type>(tag), bytes);
    return *this;
  }

  std::string bytes() const {
    std::string out;
    protozero::pbf_writer model(out);
    model.add_int64(1, 8);
    model.add_message(7, graph_);
    {
      protozero::pbf_writer opset(model, 8);
      opset.add_int64(2, opset_);
    }
    return out;
  }

 private:
  OnnxWriter& port(int tag, const std::string& name, const Ints& dims, int type) {
    std::string bytes;
    protozero::pbf_writer info(bytes);
    info.add_string(1, name);
    protozero::pbf_writer kind(info, 2);
    protozero::pbf_writer tensor(kind, 1);
    tensor.add_int32(1, type);
    protozero::pbf_writer shape(tensor, 2);
    for (const std::int64_t dim : dims) {
      protozero::pbf_writer each(shape, 1);
      if (dim >= 0)
        each.add_int64(1, dim);
      else
        each.add_string(2, "n");
    }
    shape.commit();
    tensor.commit();
    kind.commit();
    return part(tag, bytes);
  }

  std::string graph_;
  std::int64_t opset_;
};

}  // namespace cogrsim::test
