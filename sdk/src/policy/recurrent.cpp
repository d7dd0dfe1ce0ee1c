// LSTM and GRU of ONNX, forward in time. With x the input, h the state and s the logistic function, the
// gates of an LSTM are, in the order of its weights W, R and biases,
//
//     i = s(Wi x + Ri h + bi)   o = s(Wo x + Ro h + bo)   f = s(Wf x + Rf h + bf)
//     g = tanh(Wc x + Rc h + bc)   c' = f c + i g   h' = o tanh(c')
//
// and those of a GRU
//
//     z = s(Wz x + Rz h + bz)   r = s(Wr x + Rr h + br)
//     g = tanh(Wh x + bWh + Rh (r h) + bRh), or with linear_before_reset tanh(Wh x + bWh + r (Rh h + bRh))
//     h' = (1 - z) g + z h
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Core>

#include "policy/operators.h"

namespace cogrsim::policy {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Row = Eigen::Array<float, 1, Eigen::Dynamic>;
using Index = Eigen::Index;

Row logistic(const Row& x) {
  return x.unaryExpr([](float v) { return 1.0f / (1.0f + std::exp(-v)); });
}
Row tanh_of(const Row& x) {
  return x.unaryExpr([](float v) { return std::tanh(v); });
}

// Inputs, weights and states of either kind; `gates` of them.
struct Layer {
  Layer(const Call& call, Index number_of_gates) : gates(number_of_gates) {
    const Tensor &x = floats(call, 0), &w = floats(call, 1), &r = floats(call, 2);
    const auto direction = call.node.attributes.find("direction");
    if (direction != call.node.attributes.end() && direction->second.text != "forward")
      throw NetworkError(kNotEvaluated, call.node.label() + " does not run forward in time",
                         "a policy cannot know its future: train it with a forward layer");
    if (integer_or(call, "layout", 0) != 0)
      throw NetworkError(kNotEvaluated, call.node.label() + " has its batch first",
                         "export it with layout=0");
    if (has_input(call, 4))
      throw NetworkError(kNotEvaluated, call.node.label() + " has sequences of different lengths");
    if (x.dims.size() != 3 || w.dims.size() != 3 || r.dims.size() != 3 || w.dims[0] != 1 ||
        r.dims[0] != 1)
      does_not_fit(call, "its input or weights are not of three dimensions");
    steps = x.dims[0];
    rows = x.dims[1];
    inputs = x.dims[2];
    hidden = r.dims[2];
    if (w.dims[1] != gates * hidden || w.dims[2] != inputs || r.dims[1] != gates * hidden ||
        hidden == 0)
      does_not_fit(call, fmt::format("its weights are not those of {} inputs and {} states", inputs,
                                     hidden));
    if (const std::int64_t said = integer_or(call, "hidden_size", hidden); said != hidden)
      does_not_fit(call, fmt::format("it says {} states and has weights for {}", said, hidden));
    call.budget.work(static_cast<std::size_t>(steps * rows) *
                     static_cast<std::size_t>(gates * hidden) *
                     static_cast<std::size_t>(inputs + hidden));
    W = w.values.data();
    R = r.values.data();
    input = x.values.data();
    bias_w = bias_r = Row::Zero(gates * hidden);
    if (has_input(call, 3)) {
      const Tensor& b = floats(call, 3);
      if (b.dims != Dims{1, 2 * gates * hidden})
        does_not_fit(call, "its biases have the wrong shape");
      bias_w = Eigen::Map<const Row>(b.values.data(), gates * hidden);
      bias_r = Eigen::Map<const Row>(b.values.data() + gates * hidden, gates * hidden);
    }
  }

  /// An initial state; zero where none is given.
  std::vector<Row> start(const Call& call, std::size_t index) const {
    std::vector<Row> out(static_cast<std::size_t>(rows), Row::Zero(hidden));
    if (!has_input(call, index)) return out;
    const Tensor& given = floats(call, index);
    if (given.dims != Dims{1, rows, hidden})
      does_not_fit(call, "an initial state has the wrong shape");
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = Eigen::Map<const Row>(given.values.data() + static_cast<Index>(i) * hidden, hidden);
    return out;
  }

  Row from_input(Index step, Index row) const {
    const Eigen::Map<const Matrix> weights(W, gates * hidden, inputs);
    const Eigen::Map<const Eigen::VectorXf> x(input + (step * rows + row) * inputs, inputs);
    if (inputs == 0) return bias_w;
    const Eigen::VectorXf product = weights * x;
    return product.transpose().array() + bias_w;
  }

  /// Of the gates from `first` on.
  Row from_state(const Row& state, Index first, Index count) const {
    const Eigen::Map<const Matrix> weights(R + first * hidden * hidden, count * hidden, hidden);
    const Eigen::VectorXf product = weights * state.matrix().transpose();
    return product.transpose().array() + bias_r.segment(first * hidden, count * hidden);
  }

  Row part(const Row& all, Index gate) const { return all.segment(gate * hidden, hidden); }

  Index gates, steps = 0, rows = 0, inputs = 0, hidden = 0;
  const float *W = nullptr, *R = nullptr, *input = nullptr;
  Row bias_w, bias_r;
};

Tensor state_of(const Call& call, const Layer& layer, const std::vector<Row>& rows) {
  Tensor out = make(call, {1, layer.rows, layer.hidden});
  for (std::size_t i = 0; i < rows.size(); ++i)
    Eigen::Map<Row>(out.values.data() + static_cast<Index>(i) * layer.hidden, layer.hidden) =
        rows[i];
  return out;
}

}  // namespace

std::vector<Tensor> lstm(const Call& call) {
  const Layer layer(call, 4);
  if (has_input(call, 7) || integer_or(call, "input_forget", 0) != 0)
    throw NetworkError(kNotEvaluated, call.node.label() + " has peepholes or coupled gates");
  std::vector<Row> h = layer.start(call, 5), c = layer.start(call, 6);
  Tensor all = make(call, {layer.steps, 1, layer.rows, layer.hidden});
  for (Index t = 0; t < layer.steps; ++t) {
    for (Index b = 0; b < layer.rows; ++b) {
      const auto i = static_cast<std::size_t>(b);
      const Row gates = layer.from_input(t, b) + layer.from_state(h[i], 0, 4);
      c[i] = logistic(layer.part(gates, 2)) * c[i] +
             logistic(layer.part(gates, 0)) * tanh_of(layer.part(gates, 3));
      h[i] = logistic(layer.part(gates, 1)) * tanh_of(c[i]);
      Eigen::Map<Row>(all.values.data() + (t * layer.rows + b) * layer.hidden, layer.hidden) = h[i];
    }
  }
  std::vector<Tensor> out;
  out.push_back(std::move(all));
  out.push_back(state_of(call, layer, h));
  out.push_back(state_of(call, layer, c));
  return out;
}

std::vector<Tensor> gru(const Call& call) {
  const Layer layer(call, 3);
  const bool before_reset = integer_or(call, "linear_before_reset", 0) != 0;
  std::vector<Row> h = layer.start(call, 5);
  Tensor all = make(call, {layer.steps, 1, layer.rows, layer.hidden});
  for (Index t = 0; t < layer.steps; ++t) {
    for (Index b = 0; b < layer.rows; ++b) {
      Row& state = h[static_cast<std::size_t>(b)];
      const Row x = layer.from_input(t, b), s = layer.from_state(state, 0, 2);
      const Row z = logistic(layer.part(x, 0) + layer.part(s, 0));
      const Row r = logistic(layer.part(x, 1) + layer.part(s, 1));
      const Row recalled =
          before_reset ? Row(r * layer.from_state(state, 2, 1)) : layer.from_state(r * state, 2, 1);
      const Row g = tanh_of(layer.part(x, 2) + recalled);
      state = Row((1.0f - z) * g + z * state);
      Eigen::Map<Row>(all.values.data() + (t * layer.rows + b) * layer.hidden, layer.hidden) =
          state;
    }
  }
  std::vector<Tensor> out;
  out.push_back(std::move(all));
  out.push_back(state_of(call, layer, h));
  return out;
}

}  // namespace cogrsim::policy
