// Operators that move values about.
#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "policy/operators.h"

namespace cogrsim::policy {
namespace {

using Tensors = std::vector<Tensor>;

const Tensor& any_input(const Call& call, std::size_t index) {
  if (!has_input(call, index)) does_not_fit(call, fmt::format("it lacks input {}", index + 1));
  return *call.in[index];
}

// A copy of an input's values with other dimensions, of the same count.
Tensors with_dims(const Call& call, const Tensor& x, Dims dims) {
  if (call.budget.take(dims) != x.size())
    does_not_fit(call, fmt::format("its {} values do not fill the new shape", x.size()));
  Tensor out = x;
  out.dims = std::move(dims);
  return {std::move(out)};
}

// From an input since version `since`, from the attribute before; nullopt: neither.
std::optional<std::vector<std::int64_t>> list(const Call& call, const char* attribute,
                                              std::size_t index) {
  if (has_input(call, index)) return integers(call, index).integers;
  const auto found = call.node.attributes.find(attribute);
  if (found == call.node.attributes.end()) return std::nullopt;
  return found->second.integers;
}

// Takes values of `x` by their places.
Tensor pick(const Call& call, const Tensor& x, Dims dims, const std::vector<std::size_t>& places) {
  Tensor out = make(call, std::move(dims), x.whole);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (x.whole)
      out.integers[i] = x.integers[places[i]];
    else
      out.values[i] = x.values[places[i]];
  }
  return out;
}

std::size_t product(const Dims& dims, std::size_t from, std::size_t to) {
  std::size_t out = 1;
  for (std::size_t i = from; i < to; ++i) out *= static_cast<std::size_t>(dims[i]);
  return out;
}

// The elements `which` along an axis, where `dims` are the dimensions of the result.
Tensor along(const Call& call, const Tensor& x, std::size_t axis,
             const std::vector<std::int64_t>& which, Dims dims) {
  const std::size_t before = product(x.dims, 0, axis),
                    after = product(x.dims, axis + 1, x.dims.size());
  const auto length = static_cast<std::size_t>(x.dims[axis]);
  element_count(dims, call.budget.values, "what the network computes");
  std::vector<std::size_t> places;
  places.reserve(before * which.size() * after);
  for (std::size_t b = 0; b < before; ++b)
    for (const std::int64_t w : which)
      for (std::size_t a = 0; a < after; ++a)
        places.push_back((b * length + static_cast<std::size_t>(w)) * after + a);
  return pick(call, x, std::move(dims), places);
}

}  // namespace

Tensors constant(const Call& call) {
  Tensor out;
  const auto& given = call.node.attributes;
  if (given.size() != 1) does_not_fit(call, "a constant has one value");
  const auto& [name, value] = *given.begin();
  if (name == "value") {
    out = value.tensor;
  } else if (name == "value_float") {
    out.values = {value.number};
  } else if (name == "value_floats") {
    out.values = value.numbers;
    out.dims = {static_cast<std::int64_t>(value.numbers.size())};
  } else {
    out.whole = true;
    out.integers = name == "value_int" ? std::vector<std::int64_t>{value.integer} : value.integers;
    if (name == "value_ints") out.dims = {static_cast<std::int64_t>(out.integers.size())};
  }
  return {std::move(out)};
}

Tensors constant_of_shape(const Call& call) {
  const auto found = call.node.attributes.find("value");
  Tensor value;
  value.values = {0.0f};
  if (found != call.node.attributes.end()) value = found->second.tensor;
  if (value.size() != 1) does_not_fit(call, "its value is no single number");
  Tensor out = make(call, integers(call, 0).integers, value.whole);
  if (out.whole)
    std::fill(out.integers.begin(), out.integers.end(), value.integers[0]);
  else
    std::fill(out.values.begin(), out.values.end(), value.values[0]);
  return {std::move(out)};
}

Tensors shape_of(const Call& call) {
  const Dims& dims = any_input(call, 0).dims;
  const auto rank = static_cast<std::int64_t>(dims.size());
  const auto place = [&](std::int64_t at) {
    return std::clamp(at < 0 ? at + rank : at, std::int64_t{0}, rank);
  };
  const std::int64_t start = place(integer_or(call, "start", 0)),
                     end = place(integer_or(call, "end", rank));
  Tensor out;
  out.whole = true;
  for (std::int64_t i = start; i < end; ++i)
    out.integers.push_back(dims[static_cast<std::size_t>(i)]);
  out.dims = {static_cast<std::int64_t>(out.integers.size())};
  return {std::move(out)};
}

Tensors reshape(const Call& call) {
  const Tensor& x = any_input(call, 0);
  Dims dims = integers(call, 1).integers;
  std::optional<std::size_t> open;
  std::size_t known = 1;
  if (dims.size() > 8) does_not_fit(call, "the new shape has over 8 dimensions");
  for (std::size_t i = 0; i < dims.size(); ++i) {
    if (dims[i] == 0 && integer_or(call, "allowzero", 0) == 0) {
      if (i >= x.dims.size()) does_not_fit(call, "it keeps a dimension that is not there");
      dims[i] = x.dims[i];
    }
    if (dims[i] == -1) {
      if (open) does_not_fit(call, "the new shape leaves two dimensions open");
      open = i;
    } else if (dims[i] < 0 || dims[i] > std::numeric_limits<std::int32_t>::max()) {
      does_not_fit(call, "the new shape has a dimension of no possible size");
    } else if (__builtin_mul_overflow(known, static_cast<std::size_t>(dims[i]), &known)) {
      does_not_fit(call, "the new shape is too large");
    }
  }
  if (open) {
    if (known == 0 || x.size() % known != 0)
      does_not_fit(call, fmt::format("its {} values do not fill the new shape", x.size()));
    dims[*open] = static_cast<std::int64_t>(x.size() / known);
  }
  return with_dims(call, x, std::move(dims));
}

Tensors flatten(const Call& call) {
  const Tensor& x = any_input(call, 0);
  const std::int64_t wanted = integer_or(call, "axis", 1);
  const std::size_t axis = wanted == static_cast<std::int64_t>(x.dims.size())
                               ? x.dims.size()
                               : axis_of(call, wanted, x.dims.size());
  return with_dims(call, x,
                   {static_cast<std::int64_t>(product(x.dims, 0, axis)),
                    static_cast<std::int64_t>(product(x.dims, axis, x.dims.size()))});
}

Tensors squeeze(const Call& call) {
  const Tensor& x = any_input(call, 0);
  const auto axes = list(call, "axes", 1);
  std::vector<bool> gone(x.dims.size(), false);
  if (axes)
    for (const std::int64_t axis : *axes) gone[axis_of(call, axis, x.dims.size())] = true;
  Dims dims;
  for (std::size_t i = 0; i < x.dims.size(); ++i) {
    if (!(axes ? gone[i] : x.dims[i] == 1)) dims.push_back(x.dims[i]);
  }
  return with_dims(call, x, std::move(dims));
}

Tensors unsqueeze(const Call& call) {
  const Tensor& x = any_input(call, 0);
  const auto axes = list(call, "axes", 1);
  if (!axes) does_not_fit(call, "it lacks its axes");
  if (x.dims.size() + axes->size() > 8) does_not_fit(call, "the new shape has over 8 dimensions");
  Dims dims(x.dims.size() + axes->size(), 0);
  for (const std::int64_t axis : *axes) dims[axis_of(call, axis, dims.size())] = 1;
  std::size_t next = 0;
  for (std::int64_t& dim : dims) {
    if (dim == 1) continue;
    if (next == x.dims.size()) does_not_fit(call, "it names an axis twice");
    dim = x.dims[next++];
  }
  return with_dims(call, x, std::move(dims));
}

Tensors expand(const Call& call) {
  const Tensor& x = any_input(call, 0);
  const Dims& wanted = integers(call, 1).integers;
  element_count(wanted, call.budget.values, "what the network computes");
  const Dims dims = broadcast(call, x.dims, wanted);
  element_count(dims, call.budget.values, "what the network computes");
  return {pick(call, x, dims, broadcast_places(x.dims, dims))};
}

Tensors transpose(const Call& call) {
  const Tensor& x = any_input(call, 0);
  std::vector<std::int64_t> order(x.dims.size());
  std::iota(order.rbegin(), order.rend(), 0);
  if (const auto given = list(call, "perm", 1)) order = *given;
  std::vector<std::int64_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  bool all = sorted.size() == x.dims.size();
  for (std::size_t i = 0; all && i < sorted.size(); ++i)
    all = sorted[i] == static_cast<std::int64_t>(i);
  if (!all) does_not_fit(call, "its order does not name each axis once");
  Dims dims(order.size());
  std::vector<std::size_t> strides(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto from = static_cast<std::size_t>(order[i]);
    dims[i] = x.dims[from];
    strides[i] = product(x.dims, from + 1, x.dims.size());
  }
  std::vector<std::size_t> places(x.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::size_t rest = i;
    for (std::size_t k = dims.size(); k-- > 0;) {
      const auto size = static_cast<std::size_t>(dims[k]);
      places[i] += rest % size * strides[k];
      rest /= size;
    }
  }
  call.budget.work(8 * x.size());
  return {pick(call, x, std::move(dims), places)};
}

Tensors concat(const Call& call) {
  const Tensor& first = any_input(call, 0);
  const std::size_t axis = axis_of(call, integer_or(call, "axis", 0), first.dims.size());
  Dims dims = first.dims;
  dims[axis] = 0;
  for (std::size_t i = 0; i < call.in.size(); ++i) {
    const Tensor& x = any_input(call, i);
    Dims other = x.dims;
    if (x.whole != first.whole || other.size() != dims.size())
      does_not_fit(call, "its inputs are of different kinds");
    dims[axis] += other[axis];
    other[axis] = dims[axis];
    if (other != dims) does_not_fit(call, "its inputs have different shapes");
  }
  Tensor out = make(call, dims, first.whole);
  const std::size_t before = product(dims, 0, axis);
  std::size_t at = 0;
  for (std::size_t b = 0; b < before; ++b) {
    for (const Tensor* x : call.in) {
      const std::size_t count = product(x->dims, axis, dims.size()), from = b * count;
      for (std::size_t i = 0; i < count; ++i, ++at) {
        if (out.whole)
          out.integers[at] = x->integers[from + i];
        else
          out.values[at] = x->values[from + i];
      }
    }
  }
  return {std::move(out)};
}

Tensors split(const Call& call) {
  const Tensor& x = any_input(call, 0);
  const std::size_t axis = axis_of(call, integer_or(call, "axis", 0), x.dims.size());
  const std::size_t parts = call.node.outputs.size();
  std::vector<std::int64_t> sizes;
  if (const auto given = list(call, "split", 1)) {
    sizes = *given;
  } else {
    // Equal ones; the last is smaller where they do not come out even.
    const std::int64_t each =
        (x.dims[axis] + static_cast<std::int64_t>(parts) - 1) / static_cast<std::int64_t>(parts);
    for (std::int64_t left = x.dims[axis]; sizes.size() < parts; left -= sizes.back())
      sizes.push_back(std::min(each, left));
  }
  if (sizes.size() != parts) does_not_fit(call, "its outputs and sizes differ in number");
  Tensors out;
  std::int64_t start = 0;
  for (const std::int64_t size : sizes) {
    if (size < 0 || size > x.dims[axis] - start)
      does_not_fit(call, "its parts do not add up to its input");
    std::vector<std::int64_t> which(static_cast<std::size_t>(size));
    std::iota(which.begin(), which.end(), start);
    Dims dims = x.dims;
    dims[axis] = size;
    out.push_back(along(call, x, axis, which, std::move(dims)));
    start += size;
  }
  if (start != x.dims[axis]) does_not_fit(call, "its parts do not add up to its input");
  return out;
}

Tensors slice(const Call& call) {
  Tensor x = any_input(call, 0);
  const auto starts = list(call, "starts", 1), ends = list(call, "ends", 2);
  if (!starts || !ends) does_not_fit(call, "it lacks where it starts and ends");
  std::vector<std::int64_t> axes(starts->size()), steps(starts->size(), 1);
  std::iota(axes.begin(), axes.end(), 0);
  if (const auto given = list(call, "axes", 3)) axes = *given;
  if (has_input(call, 4)) steps = integers(call, 4).integers;
  if (ends->size() != starts->size() || axes.size() != starts->size() ||
      steps.size() != starts->size())
    does_not_fit(call, "its starts, ends, axes and steps differ in number");
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::size_t axis = axis_of(call, axes[i], x.dims.size());
    const std::int64_t size = x.dims[axis], step = steps[i];
    if (step == 0) does_not_fit(call, "a step of 0");
    // Beyond the ends is at the ends, as numpy does.
    const auto place = [&](std::int64_t at) {
      if (at < 0) at = at < -size ? -1 : at + size;
      return step > 0 ? std::clamp(at, std::int64_t{0}, size)
                      : std::clamp(at, std::int64_t{-1}, size - 1);
    };
    const std::int64_t end = (*ends)[i] < -size && step < 0 ? -1 : place((*ends)[i]);
    std::vector<std::int64_t> which;
    const std::int64_t bounded = std::clamp(step, -size - 1, size + 1);
    for (std::int64_t at = place((*starts)[i]); step > 0 ? at < end : at > end; at += bounded)
      which.push_back(at);
    Dims dims = x.dims;
    dims[axis] = static_cast<std::int64_t>(which.size());
    x = along(call, x, axis, which, std::move(dims));
  }
  return {std::move(x)};
}

Tensors gather(const Call& call) {
  const Tensor& x = any_input(call, 0);
  const Tensor& index = integers(call, 1);
  const std::size_t axis = axis_of(call, integer_or(call, "axis", 0), x.dims.size());
  std::vector<std::int64_t> which = index.integers;
  for (std::int64_t& at : which) {
    if (at < -x.dims[axis] || at >= x.dims[axis])
      does_not_fit(call, fmt::format("index {} of {} values", at, x.dims[axis]));
    if (at < 0) at += x.dims[axis];
  }
  Dims dims(x.dims.begin(), x.dims.begin() + static_cast<std::ptrdiff_t>(axis));
  dims.insert(dims.end(), index.dims.begin(), index.dims.end());
  dims.insert(dims.end(), x.dims.begin() + static_cast<std::ptrdiff_t>(axis) + 1, x.dims.end());
  return {along(call, x, axis, which, std::move(dims))};
}

}  // namespace cogrsim::policy
