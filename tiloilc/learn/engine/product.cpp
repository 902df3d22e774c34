// The operator tiloilc::product(left, right): stacked matrix product in float32 on one core,
// [stack, rows, depth] by [stack, depth, columns] to [stack, rows, columns], operands of any
// strides. Sums run over depth from its beginning to its end, whatever the sizes.
//
// Two vectors' width of the right operand is laid out row after row (a panel), and eight rows of
// the left one are multiplied with it at a time: sixteen vectors of sums.

#ifndef CPU_CAPABILITY_AVX512
#error "with shorter vectors torch's library multiplies as fast, without any this is slow"
#endif

#include <ATen/cpu/vec/vec.h>
#include <torch/csrc/stable/library.h>
#include <torch/csrc/stable/ops.h>
#include <torch/csrc/stable/tensor.h>
#include <torch/headeronly/core/ScalarType.h>
#include <torch/headeronly/util/Exception.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace {

using Lanes = at::vec::Vectorized<float>;
using Size = int64_t;
using torch::stable::Tensor;

constexpr Size LANES = Lanes::size();
constexpr Size WIDTH = 2 * LANES;
constexpr int ROWS = 8;

// A matrix in memory: element (i, j) is at data[i * row + j * column].
struct Matrix {
  const float* data;
  Size row, column;

  const float* at(Size i, Size j) const { return data + i * row + j * column; }
};

// A square of a vector's width, its rows `step` apart, to columns of a panel.
inline void turn(const float* from, Size step, float* panel) {
  at::vec::VectorizedN<float, LANES> square;
#pragma GCC unroll 16
  for (int i = 0; i < LANES; ++i) square[i] = Lanes::loadu(from + i * step);
  at::vec::transpose_block(square);
#pragma GCC unroll 16
  for (int i = 0; i < LANES; ++i) square[i].store(panel + i * WIDTH);
}

// `width` columns of `right` from its `first` on, row after row; what is beyond them stays.
void lay_out(Matrix right, Size first, Size width, Size depth, float* panel) {
  Size k = 0;
  if (right.row == 1 && width == WIDTH) {
    for (; k + LANES <= depth; k += LANES)
      for (Size j = 0; j < WIDTH; j += LANES)
        turn(right.at(k, first + j), right.column, panel + k * WIDTH + j);
  }
  for (; k < depth; ++k)
    for (Size j = 0; j < width; ++j) panel[k * WIDTH + j] = *right.at(k, first + j);
}

// Some rows of `left` by rows of `right`, `step` apart, which are copied to `panel` on the way;
// `out` has `stride` between its rows, `width` columns are meant. The sums are in registers only if
// every loop over them is unrolled.
template <int rows, bool copy = false>
inline void multiply(Matrix left, const float* right, Size step, Size depth, float* out,
                     Size stride, Size width, float* panel = nullptr) {
  Lanes sums[rows][2];
#pragma GCC unroll 16
  for (int i = 0; i < rows; ++i) sums[i][0] = sums[i][1] = Lanes(0.0f);
  for (Size k = 0; k < depth; ++k, right += step, left.data += left.column) {
    const auto first = Lanes::loadu(right);
    const auto second = Lanes::loadu(right + LANES);
    if constexpr (copy) {
      first.store(panel + k * WIDTH);
      second.store(panel + k * WIDTH + LANES);
    }
#pragma GCC unroll 16
    for (int i = 0; i < rows; ++i) {
      const Lanes value(left.data[i * left.row]);
      sums[i][0] = at::vec::fmadd(value, first, sums[i][0]);
      sums[i][1] = at::vec::fmadd(value, second, sums[i][1]);
    }
  }
#pragma GCC unroll 16
  for (int i = 0; i < rows; ++i) {
    sums[i][0].store(out + i * stride, std::min(width, LANES));
    if (width > LANES) sums[i][1].store(out + i * stride + LANES, width - LANES);
  }
}

// A panel and a number of rows known only now, at most `rows`.
template <int rows>
void multiply_last(Size n, Matrix left, const float* panel, Size depth, float* out, Size stride,
                   Size width) {
  if (n == rows) return multiply<rows>(left, panel, WIDTH, depth, out, stride, width);
  if constexpr (rows > 1)
    multiply_last<rows - 1>(n, left, panel, depth, out, stride, width);
}

void multiply_matrices(Matrix left, Matrix right, float* out, Size rows, Size depth, Size columns,
                       float* panel) {
  for (Size j = 0; j < columns; j += WIDTH) {
    const Size width = std::min(WIDTH, columns - j);
    Size i = 0;
    if (right.column == 1 && width == WIDTH && rows >= ROWS) {  // the first rows lay it out
      multiply<ROWS, true>(left, right.at(0, j), right.row, depth, out + j, columns, width, panel);
      i = ROWS;
    } else {
      lay_out(right, j, width, depth, panel);
    }
    for (; i < rows; i += ROWS) {
      const Matrix part{left.at(i, 0), left.row, left.column};
      multiply_last<ROWS>(std::min<Size>(ROWS, rows - i), part, panel, depth,
                          out + i * columns + j, columns, width);
    }
  }
}

Tensor product(Tensor left, Tensor right) {
  const Size stack = left.size(0), rows = left.size(1), depth = left.size(2);
  const Size columns = right.size(2);
  constexpr auto FLOAT = torch::headeronly::ScalarType::Float;
  STD_TORCH_CHECK(left.scalar_type() == FLOAT && right.scalar_type() == FLOAT,
                  "tiloilc::product multiplies float32");
  STD_TORCH_CHECK(right.size(0) == stack && right.size(1) == depth,
                  "tiloilc::product: [", stack, ", ", rows, ", ", depth, "] by [", right.size(0),
                  ", ", right.size(1), ", ", columns, "]");
  Tensor out = torch::stable::new_empty(left, {stack, rows, columns});
  const float* lefts = static_cast<const float*>(left.data_ptr());
  const float* rights = static_cast<const float*>(right.data_ptr());
  float* outs = static_cast<float*>(out.data_ptr());
  thread_local std::vector<float> panel;
  panel.resize(std::max<size_t>(panel.size(), depth * WIDTH));
  for (Size s = 0; s < stack; ++s)
    multiply_matrices({lefts + s * left.stride(0), left.stride(1), left.stride(2)},
                      {rights + s * right.stride(0), right.stride(1), right.stride(2)},
                      outs + s * rows * columns, rows, depth, columns, panel.data());
  return out;
}

}  // namespace

STABLE_TORCH_LIBRARY(tiloilc, library) {
  library.def("product(Tensor left, Tensor right) -> Tensor");
}

STABLE_TORCH_LIBRARY_IMPL(tiloilc, CPU, library) {
  library.impl("product", TORCH_BOX(&product));
}
