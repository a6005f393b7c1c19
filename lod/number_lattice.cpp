#include <recede/geometry/detail/format_io.h>
#include <recede/lod/detail/number_lattice.h>

#include <algorithm>
#include <limits>

namespace recede::detail {
namespace {

template <typename Pred>
bool all_of(std::span<const std::span<const double>> lists, Pred&& pred) {
  return std::all_of(lists.begin(), lists.end(), [&](std::span<const double> list) {
    return std::all_of(list.begin(), list.end(), pred);
  });
}

std::uint64_t bits_of(double value) { return std::bit_cast<std::uint64_t>(value); }

bool is_float(double value) {
  if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()) || std::isnan(value))
    return false;
  return bits_of(rounded_to_float(value)) == bits_of(value);
}

bool is_decimal(double value, double step) {
  constexpr double k_exact = 9007199254740992.0;  // integers up to here are doubles
  const double scaled = value * step;
  if (!(std::abs(scaled) < k_exact)) return false;
  return bits_of(static_cast<double>(std::llround(scaled)) / step) == bits_of(value);
}

/// Sign and magnitude to one order and back.
constexpr std::int64_t k_magnitude = std::numeric_limits<std::int64_t>::max();
std::int64_t ordered(std::int64_t bits) { return bits < 0 ? -(bits & k_magnitude) - 1 : bits; }
std::int64_t unordered(std::int64_t order) { return order < 0 ? -(order + 1) | ~k_magnitude : order; }

}  // namespace

NumberLattice NumberLattice::lossless(std::span<const std::span<const double>> lists) {
  NumberLattice result;
  // Decimals first: a file of text has few digits, which is less than the bits of a float.
  constexpr int k_most_digits = 7;
  double step = 1;
  for (int digits = 0; digits <= k_most_digits; ++digits, step *= 10) {
    if (all_of(lists, [&](double value) { return is_decimal(value, step); })) {
      result.form = Form::decimals;
      result.step = step;
      return result;
    }
  }
  if (all_of(lists, is_float)) {
    result.form = Form::floats;
    return result;
  }
  constexpr double k_last_step = 1e15;
  for (; step <= k_last_step; step *= 10) {
    if (all_of(lists, [&](double value) { return is_decimal(value, step); })) {
      result.form = Form::decimals;
      result.step = step;
      return result;
    }
  }
  return result;
}

NumberLattice NumberLattice::quantised(double lowest, double extent, int bits) {
  NumberLattice result;
  result.form = Form::quantised;
  result.most = (std::int64_t{1} << bits) - 1;
  result.origin = lowest;
  result.step = extent > 0 ? extent / static_cast<double>(result.most) : 1;
  return result;
}

std::int64_t NumberLattice::to_integer(double value) const {
  if (std::isnan(value) && form != Form::doubles) return 0;
  switch (form) {
    case Form::floats: {
      constexpr double k_most = static_cast<double>(std::numeric_limits<float>::max());
      const auto narrow = static_cast<float>(std::clamp(value, -k_most, k_most));
      const auto bits = static_cast<std::int64_t>(std::bit_cast<std::int32_t>(narrow));
      return bits < 0 ? -(bits & 0x7fffffff) - 1 : bits;
    }
    case Form::doubles:
      return ordered(std::bit_cast<std::int64_t>(value));
    case Form::decimals: {
      constexpr double k_most = 4e18;
      return std::llround(std::clamp(value * step, -k_most, k_most));
    }
    case Form::quantised:
      break;
  }
  const double place = std::round((value - origin) / step);
  return static_cast<std::int64_t>(std::clamp(place, 0.0, static_cast<double>(most)));
}

double NumberLattice::to_value(std::int64_t integer) const {
  switch (form) {
    case Form::floats: {
      const std::int64_t bits = integer < 0 ? (-(integer + 1)) | 0x80000000 : integer;
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    case Form::doubles:
      return std::bit_cast<double>(unordered(integer));
    case Form::decimals:
      return static_cast<double>(integer) / step;
    case Form::quantised:
      break;
  }
  return origin + step * static_cast<double>(integer);
}

}  // namespace recede::detail
