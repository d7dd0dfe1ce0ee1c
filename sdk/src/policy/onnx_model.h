// An ONNX file as plain data: what the evaluation needs of it, checked against limits while it is read.
#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/policy/network.h"

namespace cogrsim::policy {

/// Ends reading or evaluating; PolicyNetwork turns it into an Error.
struct NetworkError : std::runtime_error {
  NetworkError(const char* stable_code, const std::string& message, std::string remedy = {})
      : std::runtime_error(message), code(stable_code), hint(std::move(remedy)) {}
  const char* code;
  std::string hint;
};

inline constexpr const char* kNotOnnx = "CG1510";
inline constexpr const char* kBeyondLimits = "CG1511";
inline constexpr const char* kNotEvaluated = "CG1512";
inline constexpr const char* kDoesNotFit = "CG1513";

using Dims = std::vector<std::int64_t>;

/// Float values, or integers (`whole`), row-major.
struct Tensor {
  Dims dims;
  bool whole = false;
  std::vector<float> values;
  std::vector<std::int64_t> integers;

  std::size_t size() const { return whole ? integers.size() : values.size(); }
};

/// The product of the dimensions. Errors: one is negative, or the product exceeds `limit`.
std::size_t element_count(const Dims& dims, std::size_t limit, const std::string& what);

struct Attribute {
  float number = 0.0f;
  std::int64_t integer = 0;
  std::string text;
  Tensor tensor;
  std::vector<float> numbers;
  std::vector<std::int64_t> integers;
  std::vector<std::string> texts;
};

struct Node {
  std::string name, op;
  std::vector<std::string> inputs, outputs;  ///< "": left out
  std::map<std::string, Attribute> attributes;

  std::string label() const { return op + (name.empty() ? "" : " '" + name + "'"); }
};

struct OnnxModel {
  std::int64_t opset = 0;
  std::vector<Node> nodes;
  std::map<std::string, Tensor> constants;
  std::vector<NetworkPort> inputs, outputs;  ///< inputs without the constants
  std::map<std::string, std::string> metadata;
};

/// Throws NetworkError.
OnnxModel read_onnx(std::string_view bytes, const NetworkLimits& limits);

}  // namespace cogrsim::policy
