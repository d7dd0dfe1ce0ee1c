// The operators of ONNX that networks are evaluated with.
#pragma once

#include <functional>
#include <vector>

#include "policy/onnx_model.h"

namespace cogrsim::policy {

/// What an evaluation may still do: each operator pays before it works.
struct Budget {
  std::size_t values = 0;      ///< of all tensors made
  std::size_t operations = 0;  ///< multiplications and additions

  /// The number of elements. Throws NetworkError where it is more than is left.
  std::size_t take(const Dims& dims);
  void work(std::size_t count);
};

/// A call of an operator: `in` has nullptr for inputs that are left out.
struct Call {
  const Node& node;
  std::int64_t opset;
  std::vector<const Tensor*> in;
  Budget& budget;
};

using Operator = std::function<std::vector<Tensor>(const Call&)>;

/// The operator of the node. Throws NetworkError: there is none, with the nearest name; the node has
/// an attribute that it does not know.
Operator find_operator(const Node& node);

// ---- for the implementations

[[noreturn]] void does_not_fit(const Call& call, const std::string& what);
/// An input that must be there, of floats or of whole numbers.
const Tensor& floats(const Call& call, std::size_t index);
const Tensor& integers(const Call& call, std::size_t index);
bool has_input(const Call& call, std::size_t index);
std::int64_t integer_or(const Call& call, const char* attribute, std::int64_t otherwise);
float number_or(const Call& call, const char* attribute, float otherwise);
/// A number of an axis, which counts from the end where it is negative.
std::size_t axis_of(const Call& call, std::int64_t axis, std::size_t rank);
/// Dimensions, values to be filled.
Tensor make(const Call& call, Dims dims, bool whole = false);

std::vector<Tensor> lstm(const Call& call);
std::vector<Tensor> gru(const Call& call);
std::vector<Tensor> slice(const Call& call);
std::vector<Tensor> split(const Call& call);
std::vector<Tensor> gather(const Call& call);
std::vector<Tensor> concat(const Call& call);
std::vector<Tensor> transpose(const Call& call);
std::vector<Tensor> reshape(const Call& call);
std::vector<Tensor> flatten(const Call& call);
std::vector<Tensor> squeeze(const Call& call);
std::vector<Tensor> unsqueeze(const Call& call);
std::vector<Tensor> expand(const Call& call);
std::vector<Tensor> shape_of(const Call& call);
std::vector<Tensor> constant(const Call& call);
std::vector<Tensor> constant_of_shape(const Call& call);

/// The shape of the result of two that are broadcast, as numpy does.
Dims broadcast(const Call& call, const Dims& a, const Dims& b);
/// For each value of a tensor of `to`, in order, where it is in one of `from` that is broadcast.
std::vector<std::size_t> broadcast_places(const Dims& from, const Dims& to);

}  // namespace cogrsim::policy
