// Arithmetic operators, and the table of all.
#include "policy/operators.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Core>

#include "cogrsim/core/parameter.h"

namespace cogrsim::policy {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using MatrixView = Eigen::Map<const Matrix>;
using Tensors = std::vector<Tensor>;

template <class Function>
Operator each(Function function) {
  return [function](const Call& call) -> Tensors {
    const Tensor& x = floats(call, 0);
    Tensor out = make(call, x.dims);
    call.budget.work(8 * x.size());
    for (std::size_t i = 0; i < x.size(); ++i) out.values[i] = function(call, x.values[i]);
    return {std::move(out)};
  };
}

template <class Function>
Operator simple(Function function) {
  return each([function](const Call&, float x) { return function(x); });
}

// Of two, with broadcasting; whole numbers where both are, as shapes are computed with.
template <class Function>
Operator both(Function function) {
  return [function](const Call& call) -> Tensors {
    const bool whole = has_input(call, 0) && call.in[0]->whole;
    const Tensor& a = whole ? integers(call, 0) : floats(call, 0);
    const Tensor& b = whole ? integers(call, 1) : floats(call, 1);
    Tensor out = make(call, broadcast(call, a.dims, b.dims), whole);
    call.budget.work(4 * out.size());
    if (!whole && a.dims == b.dims) {
      for (std::size_t i = 0; i < out.size(); ++i)
        out.values[i] = function(call, a.values[i], b.values[i]);
      return {std::move(out)};
    }
    const auto of_a = broadcast_places(a.dims, out.dims), of_b = broadcast_places(b.dims, out.dims);
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (whole)
        out.integers[i] = function(call, a.integers[of_a[i]], b.integers[of_b[i]]);
      else
        out.values[i] = function(call, a.values[of_a[i]], b.values[of_b[i]]);
    }
    return {std::move(out)};
  };
}

struct Plus {
  float operator()(const Call&, float a, float b) const { return a + b; }
  std::int64_t operator()(const Call& call, std::int64_t a, std::int64_t b) const {
    std::int64_t out = 0;
    if (__builtin_add_overflow(a, b, &out)) does_not_fit(call, "a whole number overflows");
    return out;
  }
};
struct Minus {
  float operator()(const Call&, float a, float b) const { return a - b; }
  std::int64_t operator()(const Call& call, std::int64_t a, std::int64_t b) const {
    std::int64_t out = 0;
    if (__builtin_sub_overflow(a, b, &out)) does_not_fit(call, "a whole number overflows");
    return out;
  }
};
struct Times {
  float operator()(const Call&, float a, float b) const { return a * b; }
  std::int64_t operator()(const Call& call, std::int64_t a, std::int64_t b) const {
    std::int64_t out = 0;
    if (__builtin_mul_overflow(a, b, &out)) does_not_fit(call, "a whole number overflows");
    return out;
  }
};
struct Over {
  float operator()(const Call&, float a, float b) const { return a / b; }
  std::int64_t operator()(const Call& call, std::int64_t a, std::int64_t b) const {
    if (b == 0 || (b == -1 && a == std::numeric_limits<std::int64_t>::min()))
      does_not_fit(call, "a whole number is divided by 0");
    return a / b;
  }
};
template <bool kLarger>
struct Extreme {
  template <class Number>
  Number operator()(const Call&, Number a, Number b) const {
    return kLarger ? std::max(a, b) : std::min(a, b);
  }
};
struct ToPower {
  float operator()(const Call&, float a, float b) const { return std::pow(a, b); }
  std::int64_t operator()(const Call& call, std::int64_t, std::int64_t) const {
    does_not_fit(call, "powers of whole numbers are not evaluated");
  }
};

float sigmoid(float x) { return 1.0f / (1.0f + std::exp(-x)); }

// y = alpha A B + beta C, where A and B may be transposed.
Tensors gemm(const Call& call) {
  const Tensor &a = floats(call, 0), &b = floats(call, 1);
  if (a.dims.size() != 2 || b.dims.size() != 2) does_not_fit(call, "its factors are no matrices");
  const bool turn_a = integer_or(call, "transA", 0) != 0,
             turn_b = integer_or(call, "transB", 0) != 0;
  const MatrixView A(a.values.data(), a.dims[0], a.dims[1]),
      B(b.values.data(), b.dims[0], b.dims[1]);
  const auto rows = turn_a ? A.cols() : A.rows(), inner = turn_a ? A.rows() : A.cols();
  const auto columns = turn_b ? B.rows() : B.cols();
  if (inner != (turn_b ? B.cols() : B.rows()))
    does_not_fit(
        call, fmt::format("it multiplies {} values with {}", inner, turn_b ? B.cols() : B.rows()));
  Tensor out = make(call, {rows, columns});
  call.budget.work(static_cast<std::size_t>(rows) * static_cast<std::size_t>(inner) *
                   static_cast<std::size_t>(columns));
  Eigen::Map<Matrix> y(out.values.data(), rows, columns);
  if (inner == 0)
    y.setZero();
  else if (turn_a && turn_b)
    y.noalias() = A.transpose() * B.transpose();
  else if (turn_a)
    y.noalias() = A.transpose() * B;
  else if (turn_b)
    y.noalias() = A * B.transpose();
  else
    y.noalias() = A * B;
  y *= number_or(call, "alpha", 1.0f);
  if (has_input(call, 2)) {
    const Tensor& c = floats(call, 2);
    if (broadcast(call, c.dims, out.dims) != out.dims)
      does_not_fit(call, "its third input is too large");
    const float beta = number_or(call, "beta", 1.0f);
    const auto places = broadcast_places(c.dims, out.dims);
    for (std::size_t i = 0; i < out.size(); ++i) out.values[i] += beta * c.values[places[i]];
  }
  return {std::move(out)};
}

// The last two dimensions are matrices; the others are broadcast. A vector is a row or a column.
Tensors matmul(const Call& call) {
  const Tensor &a = floats(call, 0), &b = floats(call, 1);
  if (a.dims.empty() || b.dims.empty()) does_not_fit(call, "it multiplies a single number");
  Dims da = a.dims, db = b.dims;
  if (da.size() == 1) da.insert(da.begin(), 1);
  if (db.size() == 1) db.push_back(1);
  const std::int64_t rows = da[da.size() - 2], inner = da.back(), columns = db.back();
  if (inner != db[db.size() - 2])
    does_not_fit(call, fmt::format("it multiplies {} values with {}", inner, db[db.size() - 2]));
  const Dims many_a(da.begin(), da.end() - 2), many_b(db.begin(), db.end() - 2);
  const Dims many = broadcast(call, many_a, many_b);
  Dims dims = many;
  if (a.dims.size() > 1) dims.push_back(rows);
  if (b.dims.size() > 1) dims.push_back(columns);
  Tensor out = make(call, dims);
  call.budget.work(out.size() * static_cast<std::size_t>(inner));
  if (out.size() == 0) return {std::move(out)};
  const auto of_a = broadcast_places(many_a, many), of_b = broadcast_places(many_b, many);
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    const MatrixView A(a.values.data() + of_a[i] * static_cast<std::size_t>(rows * inner), rows,
                       inner);
    const MatrixView B(b.values.data() + of_b[i] * static_cast<std::size_t>(inner * columns), inner,
                       columns);
    Eigen::Map<Matrix> y(out.values.data() + i * static_cast<std::size_t>(rows * columns), rows,
                         columns);
    if (inner == 0)
      y.setZero();
    else
      y.noalias() = A * B;
  }
  return {std::move(out)};
}

Tensors clip(const Call& call) {
  const Tensor& x = floats(call, 0);
  const auto bound = [&](std::size_t index, const char* attribute, float otherwise) {
    if (!has_input(call, index)) return number_or(call, attribute, otherwise);
    const Tensor& t = floats(call, index);
    if (t.size() != 1) does_not_fit(call, "a bound is no single number");
    return t.values[0];
  };
  const float low = bound(1, "min", std::numeric_limits<float>::lowest());
  const float high = bound(2, "max", std::numeric_limits<float>::max());
  Tensor out = make(call, x.dims);
  for (std::size_t i = 0; i < x.size(); ++i)
    out.values[i] = std::min(std::max(x.values[i], low), high);
  return {std::move(out)};
}

Tensors cast(const Call& call) {
  if (!has_input(call, 0)) does_not_fit(call, "it lacks an input");
  const Tensor& x = *call.in[0];
  const std::int64_t to = integer_or(call, "to", 0);
  if (to != 1 && to != 6 && to != 7)
    throw NetworkError(kNotEvaluated, call.node.label() + " makes numbers that are not float32",
                       "export the network in float32");
  Tensor out = make(call, x.dims, to != 1);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!x.whole && !out.whole)
      out.values[i] = x.values[i];
    else if (x.whole && out.whole)
      out.integers[i] = x.integers[i];
    else if (x.whole)
      out.values[i] = static_cast<float>(x.integers[i]);
    else if (!(std::fabs(x.values[i]) < 9e18f))
      does_not_fit(call, "a number has no whole part");
    else
      out.integers[i] = static_cast<std::int64_t>(x.values[i]);
  }
  return {std::move(out)};
}

Tensors identity(const Call& call) {
  if (!has_input(call, 0)) does_not_fit(call, "it lacks an input");
  call.budget.take(call.in[0]->dims);
  return {*call.in[0]};
}

// Rows of `axis` and what follows, of a softmax: before version 13 all following dimensions are one.
Tensors softmax(const Call& call, bool logarithm) {
  const Tensor& x = floats(call, 0);
  const bool flat = call.opset < 13;
  const std::size_t axis = axis_of(call, integer_or(call, "axis", flat ? 1 : -1), x.dims.size());
  std::size_t row = 1, stride = 1;
  for (std::size_t i = axis; i < x.dims.size(); ++i) {
    if (i == axis || flat)
      row *= static_cast<std::size_t>(x.dims[i]);
    else
      stride *= static_cast<std::size_t>(x.dims[i]);
  }
  Tensor out = make(call, x.dims);
  call.budget.work(16 * x.size());
  if (x.size() == 0) return {std::move(out)};
  for (std::size_t start = 0; start < x.size(); start += row * stride) {
    for (std::size_t k = 0; k < stride; ++k) {
      const std::size_t first = start + k;
      float largest = x.values[first], sum = 0.0f;
      for (std::size_t i = 0; i < row; ++i)
        largest = std::max(largest, x.values[first + i * stride]);
      for (std::size_t i = 0; i < row; ++i) sum += std::exp(x.values[first + i * stride] - largest);
      for (std::size_t i = 0; i < row; ++i) {
        const float d = x.values[first + i * stride] - largest;
        out.values[first + i * stride] = logarithm ? d - std::log(sum) : std::exp(d) / sum;
      }
    }
  }
  return {std::move(out)};
}

// (x - mean) / sqrt(variance + epsilon) * scale + bias over the last dimensions, from `axis` on.
Tensors layer_normalization(const Call& call) {
  const Tensor &x = floats(call, 0), &scale = floats(call, 1);
  const std::size_t axis = axis_of(call, integer_or(call, "axis", -1), x.dims.size());
  std::size_t row = 1;
  for (std::size_t i = axis; i < x.dims.size(); ++i) row *= static_cast<std::size_t>(x.dims[i]);
  const Dims row_dims(x.dims.begin() + static_cast<std::ptrdiff_t>(axis), x.dims.end());
  const auto fitting = [&](const Tensor& t) {
    if (broadcast(call, t.dims, row_dims) != row_dims)
      does_not_fit(call, "its scale or bias is too large");
    return broadcast_places(t.dims, row_dims);
  };
  const auto of_scale = fitting(scale);
  const bool has_bias = has_input(call, 2);
  const auto of_bias = has_bias ? fitting(floats(call, 2)) : std::vector<std::size_t>();
  const float epsilon = number_or(call, "epsilon", 1e-5f);
  Tensor out = make(call, x.dims);
  call.budget.work(8 * x.size());
  for (std::size_t start = 0; start + row <= x.size() && row > 0; start += row) {
    double mean = 0.0, variance = 0.0;
    for (std::size_t i = 0; i < row; ++i) mean += static_cast<double>(x.values[start + i]);
    mean /= static_cast<double>(row);
    for (std::size_t i = 0; i < row; ++i) {
      const double d = static_cast<double>(x.values[start + i]) - mean;
      variance += d * d;
    }
    variance /= static_cast<double>(row);
    const double factor = 1.0 / std::sqrt(variance + static_cast<double>(epsilon));
    for (std::size_t i = 0; i < row; ++i) {
      const double d = (static_cast<double>(x.values[start + i]) - mean) * factor;
      out.values[start + i] = static_cast<float>(d) * scale.values[of_scale[i]] +
                              (has_bias ? call.in[2]->values[of_bias[i]] : 0.0f);
    }
  }
  return {std::move(out)};
}

// Mean or sum over some axes, all where none are named.
Tensors reduce(const Call& call, bool mean) {
  const Tensor& x = floats(call, 0);
  std::vector<std::int64_t> axes;
  if (has_input(call, 1))
    axes = integers(call, 1).integers;
  else if (const auto found = call.node.attributes.find("axes");
           found != call.node.attributes.end())
    axes = found->second.integers;
  std::vector<bool> gone(x.dims.size(), axes.empty());
  if (axes.empty() && integer_or(call, "noop_with_empty_axes", 0) != 0) return {x};
  for (const std::int64_t axis : axes) gone[axis_of(call, axis, x.dims.size())] = true;
  Dims kept = x.dims, dims;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (gone[i]) kept[i] = 1;
    if (!gone[i] || integer_or(call, "keepdims", 1) != 0) dims.push_back(kept[i]);
  }
  Tensor out = make(call, dims);
  call.budget.work(4 * x.size());
  std::vector<double> sums(out.size(), 0.0);
  const auto places = broadcast_places(kept, x.dims);
  for (std::size_t i = 0; i < x.size(); ++i) sums[places[i]] += static_cast<double>(x.values[i]);
  const double count = mean && out.size() > 0
                           ? static_cast<double>(x.size()) / static_cast<double>(out.size())
                           : 1.0;
  for (std::size_t i = 0; i < out.size(); ++i) out.values[i] = static_cast<float>(sums[i] / count);
  return {std::move(out)};
}

struct Entry {
  const char* name;
  std::vector<const char*> attributes;
  Operator evaluate;
};

std::vector<Entry> activations() {
  const auto alpha = [](const Call& call, float otherwise) {
    return number_or(call, "alpha", otherwise);
  };
  return {
      {"Relu", {}, simple([](float x) { return x > 0.0f ? x : 0.0f; })},
      {"LeakyRelu", {"alpha"}, each([alpha](const Call& c, float x) {
         return x >= 0.0f ? x : alpha(c, 0.01f) * x;
       })},
      {"Elu", {"alpha"}, each([alpha](const Call& c, float x) {
         return x >= 0.0f ? x : alpha(c, 1.0f) * std::expm1(x);
       })},
      {"Celu", {"alpha"}, each([alpha](const Call& c, float x) {
         const float a = alpha(c, 1.0f);
         return std::max(0.0f, x) + std::min(0.0f, a * std::expm1(x / a));
       })},
      {"Selu", {"alpha", "gamma"}, each([alpha](const Call& c, float x) {
         return number_or(c, "gamma", 1.05070102214813232421875f) *
                (x > 0.0f ? x : alpha(c, 1.67326319217681884765625f) * std::expm1(x));
       })},
      {"HardSigmoid", {"alpha", "beta"}, each([alpha](const Call& c, float x) {
         return std::max(0.0f, std::min(1.0f, alpha(c, 0.2f) * x + number_or(c, "beta", 0.5f)));
       })},
      {"HardSwish", {}, simple([](float x) {
         return x * std::max(0.0f, std::min(1.0f, x / 6.0f + 0.5f));
       })},
      {"Sigmoid", {}, simple(sigmoid)},
      {"Softplus", {}, simple([](float x) { return x > 20.0f ? x : std::log1p(std::exp(x)); })},
      {"Softsign", {}, simple([](float x) { return x / (1.0f + std::fabs(x)); })},
      {"Mish", {}, simple([](float x) {
         return x * std::tanh(x > 20.0f ? x : std::log1p(std::exp(x)));
       })},
      {"Tanh", {}, simple([](float x) { return std::tanh(x); })},
      {"Gelu", {"approximate"}, each([](const Call& c, float x) {
         const auto found = c.node.attributes.find("approximate");
         return found != c.node.attributes.end() && found->second.text == "tanh"
                    ? 0.5f * x * (1.0f + std::tanh(0.7978845608f * (x + 0.044715f * x * x * x)))
                    : 0.5f * x * (1.0f + std::erf(x * 0.70710678118f));
       })},
      {"Softmax", {"axis"}, [](const Call& call) { return softmax(call, false); }},
      {"LogSoftmax", {"axis"}, [](const Call& call) { return softmax(call, true); }},
  };
}

std::vector<Entry> arithmetic() {
  return {
      {"Abs", {}, simple([](float x) { return std::fabs(x); })},
      {"Neg", {}, simple([](float x) { return -x; })},
      {"Exp", {}, simple([](float x) { return std::exp(x); })},
      {"Log", {}, simple([](float x) { return std::log(x); })},
      {"Sqrt", {}, simple([](float x) { return std::sqrt(x); })},
      {"Reciprocal", {}, simple([](float x) { return 1.0f / x; })},
      {"Erf", {}, simple([](float x) { return std::erf(x); })},
      {"Sin", {}, simple([](float x) { return std::sin(x); })},
      {"Cos", {}, simple([](float x) { return std::cos(x); })},
      {"Add", {}, both(Plus())},
      {"Sub", {}, both(Minus())},
      {"Mul", {}, both(Times())},
      {"Div", {}, both(Over())},
      {"Pow", {}, both(ToPower())},
      {"Max", {}, both(Extreme<true>())},
      {"Min", {}, both(Extreme<false>())},
      {"Clip", {"min", "max"}, clip},
      {"Cast", {"to"}, cast},
      {"Gemm", {"alpha", "beta", "transA", "transB"}, gemm},
      {"MatMul", {}, matmul},
      {"LayerNormalization", {"axis", "epsilon", "stash_type"}, layer_normalization},
      {"ReduceMean",
       {"axes", "keepdims", "noop_with_empty_axes"},
       [](const Call& c) { return reduce(c, true); }},
      {"ReduceSum",
       {"axes", "keepdims", "noop_with_empty_axes"},
       [](const Call& c) { return reduce(c, false); }},
  };
}

std::vector<Entry> arrangement() {
  return {
      {"Identity", {}, identity},
      {"Dropout", {"ratio", "seed"}, identity},  // does nothing where nothing is learnt
      {"Constant", {"value", "value_float", "value_floats", "value_int", "value_ints"}, constant},
      {"ConstantOfShape", {"value"}, constant_of_shape},
      {"Shape", {"start", "end"}, shape_of},
      {"Reshape", {"allowzero"}, reshape},
      {"Flatten", {"axis"}, flatten},
      {"Squeeze", {"axes"}, squeeze},
      {"Unsqueeze", {"axes"}, unsqueeze},
      {"Expand", {}, expand},
      {"Transpose", {"perm"}, transpose},
      {"Concat", {"axis"}, concat},
      {"Split", {"axis", "split", "num_outputs"}, split},
      {"Slice", {"starts", "ends", "axes"}, slice},
      {"Gather", {"axis"}, gather},
      {"LSTM", {"hidden_size", "direction", "layout", "input_forget"}, lstm},
      {"GRU", {"hidden_size", "direction", "layout", "linear_before_reset"}, gru},
  };
}

const std::vector<Entry>& table() {
  static const std::vector<Entry> all = [] {
    std::vector<Entry> out = activations();
    for (auto& part : {arithmetic(), arrangement()})
      out.insert(out.end(), part.begin(), part.end());
    return out;
  }();
  return all;
}

}  // namespace

std::size_t Budget::take(const Dims& dims) {
  const std::size_t count = element_count(dims, values, "what the network computes");
  values -= count;
  return count;
}

void Budget::work(std::size_t count) {
  if (count > operations)
    throw NetworkError(kBeyondLimits, "an evaluation takes more operations than any policy needs");
  operations -= count;
}

void does_not_fit(const Call& call, const std::string& what) {
  throw NetworkError(kDoesNotFit, call.node.label() + ": " + what);
}

bool has_input(const Call& call, std::size_t index) {
  return index < call.in.size() && call.in[index] != nullptr;
}

const Tensor& floats(const Call& call, std::size_t index) {
  if (!has_input(call, index)) does_not_fit(call, fmt::format("it lacks input {}", index + 1));
  if (call.in[index]->whole)
    does_not_fit(call, fmt::format("its input {} is whole numbers", index + 1));
  return *call.in[index];
}

const Tensor& integers(const Call& call, std::size_t index) {
  if (!has_input(call, index)) does_not_fit(call, fmt::format("it lacks input {}", index + 1));
  if (!call.in[index]->whole)
    does_not_fit(call, fmt::format("its input {} is not whole numbers", index + 1));
  return *call.in[index];
}

std::int64_t integer_or(const Call& call, const char* attribute, std::int64_t otherwise) {
  const auto found = call.node.attributes.find(attribute);
  return found == call.node.attributes.end() ? otherwise : found->second.integer;
}

float number_or(const Call& call, const char* attribute, float otherwise) {
  const auto found = call.node.attributes.find(attribute);
  return found == call.node.attributes.end() ? otherwise : found->second.number;
}

std::size_t axis_of(const Call& call, std::int64_t axis, std::size_t rank) {
  const auto size = static_cast<std::int64_t>(rank);
  if (axis < -size || axis >= size)
    does_not_fit(call, fmt::format("axis {} of a tensor of {} dimensions", axis, rank));
  return static_cast<std::size_t>(axis < 0 ? axis + size : axis);
}

Tensor make(const Call& call, Dims dims, bool whole) {
  const std::size_t count = call.budget.take(dims);
  Tensor out;
  out.dims = std::move(dims);
  out.whole = whole;
  if (whole)
    out.integers.resize(count);
  else
    out.values.resize(count);
  return out;
}

Dims broadcast(const Call& call, const Dims& a, const Dims& b) {
  Dims out(std::max(a.size(), b.size()), 1);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::int64_t x = i < a.size() ? a[a.size() - 1 - i] : 1,
                       y = i < b.size() ? b[b.size() - 1 - i] : 1;
    if (x != y && x != 1 && y != 1)
      does_not_fit(call, fmt::format("it combines {} values with {}", x, y));
    out[out.size() - 1 - i] = x == 1 ? y : x;
  }
  return out;
}

std::vector<std::size_t> broadcast_places(const Dims& from, const Dims& to) {
  // A dimension along which `from` is repeated has the stride 0.
  std::vector<std::size_t> strides(to.size(), 0);
  std::size_t stride = 1, count = 1;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const std::size_t k = from.size() - 1 - i;
    if (from[k] != 1) strides[to.size() - 1 - i] = stride;
    stride *= static_cast<std::size_t>(from[k]);
  }
  for (const std::int64_t dim : to) count *= static_cast<std::size_t>(dim);
  std::vector<std::size_t> out(count);
  std::vector<std::int64_t> at(to.size(), 0);
  std::size_t place = 0;
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = place;
    for (std::size_t k = to.size(); k-- > 0;) {
      place += strides[k];
      if (++at[k] < to[k]) break;
      place -= strides[k] * static_cast<std::size_t>(to[k]);
      at[k] = 0;
    }
  }
  return out;
}

Operator find_operator(const Node& node) {
  std::vector<std::string> names;
  for (const Entry& entry : table()) {
    names.emplace_back(entry.name);
    if (node.op != entry.name) continue;
    for (const auto& [name, value] : node.attributes) {
      if (std::none_of(entry.attributes.begin(), entry.attributes.end(),
                       [&known = name](const char* each_name) { return known == each_name; }))
        throw NetworkError(
            kNotEvaluated,
            fmt::format("{} has the attribute '{}', which is not evaluated", node.label(), name));
    }
    return entry.evaluate;
  }
  const std::string near = nearest_name(node.op, names);
  throw NetworkError(
      kNotEvaluated, fmt::format("{} is an operator that is not evaluated", node.label()),
      near.empty() ? "export it without; the documentation lists those that are evaluated"
                   : "the nearest one that is evaluated is " + near);
}

}  // namespace cogrsim::policy
