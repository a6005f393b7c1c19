#include <recede/shells/detail/lp_field.h>
#include <recede/shells/lp_distance.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

namespace recede {

LpDistance::LpDistance(const PolygonSoup& surface, const LpDistanceOptions& options)
    : field_(std::make_unique<const detail::LpField>(surface, options)) {}
LpDistance::~LpDistance() = default;
LpDistance::LpDistance(LpDistance&&) noexcept = default;
LpDistance& LpDistance::operator=(LpDistance&&) noexcept = default;

LpValue LpDistance::at(const Vec3& point) const { return field_->at(point); }

std::vector<LpValue> LpDistance::at(std::span<const Vec3> points, Progress* progress) const {
  std::vector<LpValue> values(points.size());
  constexpr std::size_t k_block = 1 << 14;  // between two looks at whether to stop
  for (std::size_t first = 0; first < points.size(); first += k_block) {
    report_progress(progress, "averaging distances",
                    static_cast<double>(first) / static_cast<double>(points.size()));
    const std::size_t last = std::min(first + k_block, points.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(first, last, 64), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) values[i] = field_->at(points[i]);
    });
  }
  report_progress(progress, "averaging distances", 1);
  return values;
}

double LpDistance::area() const { return field_->area(); }

}  // namespace recede
