#include <recede/shells/detail/lp_field.h>
#include <recede/shells/detail/near_order.h>
#include <recede/shells/lp_distance.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>

namespace recede {

LpDistance::LpDistance(const PolygonSoup& surface, const LpDistanceOptions& options)
    : field_(std::make_unique<const detail::LpField>(surface, options)) {}
LpDistance::~LpDistance() = default;
LpDistance::LpDistance(LpDistance&&) noexcept = default;
LpDistance& LpDistance::operator=(LpDistance&&) noexcept = default;

LpValue LpDistance::at(const Vec3& point) const { return field_->at(point); }

std::vector<LpValue> LpDistance::at(std::span<const Vec3> points, Progress* progress) const {
  std::vector<LpValue> values(points.size());
  constexpr std::size_t k_block = 1 << 16;  // between two looks at whether to stop
  std::vector<Vec3> near;
  std::vector<LpValue> answers;
  for (std::size_t first = 0; first < points.size(); first += k_block) {
    report_progress(progress, "averaging distances",
                    static_cast<double>(first) / static_cast<double>(points.size()));
    const std::size_t n = std::min(k_block, points.size() - first);
    const std::vector<std::uint32_t> order = detail::near_order(points.subspan(first, n));
    near.resize(n);
    answers.resize(n);
    for (std::size_t i = 0; i < n; ++i) near[i] = points[first + order[i]];
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 64), [&](const auto& range) {
      field_->at_each(std::span<const Vec3>(near).subspan(range.begin(), range.size()),
                      std::span(answers).subspan(range.begin(), range.size()));
    });
    for (std::size_t i = 0; i < n; ++i) values[first + order[i]] = answers[i];
  }
  report_progress(progress, "averaging distances", 1);
  return values;
}

double LpDistance::area() const { return field_->area(); }

}  // namespace recede
