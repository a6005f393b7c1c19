#include <recede/geometry/error.h>
#include <recede/lod/detail/error_proof.h>
#include <recede/lod/detail/parts.h>
#include <recede/lod/detail/simplifier.h>
#include <recede/lod/simplify.h>

#include <chrono>
#include <cmath>
#include <limits>

namespace recede {

std::string_view to_string(StopReason reason) {
  switch (reason) {
    case StopReason::face_target:
      return "face target reached";
    case StopReason::vertex_target:
      return "vertex target reached";
    case StopReason::error_target:
      return "error target reached";
    case StopReason::no_collapse_left:
      return "no permitted collapse left";
  }
  return "";
}

std::string_view to_string(Refusal refusal) {
  switch (refusal) {
    case Refusal::border:
      return "border";
    case Refusal::topology:
      return "topology";
    case Refusal::duplicate:
      return "duplicate";
    case Refusal::flip:
      return "flip";
    case Refusal::degenerate:
      return "degenerate";
    case Refusal::deviation:
      return "deviation";
    case Refusal::error:
      return "error";
    case Refusal::count:
      break;
  }
  return "";
}

namespace {

using Clock = std::chrono::steady_clock;

void require(bool condition, const char* text) {
  if (!condition) throw OptionError(text);
}

}  // namespace

namespace detail {

void check(const SimplifyOptions& options) {
  require(options.normal_threshold >= -1 && options.normal_threshold <= 1,
          "normal_threshold must lie in [-1, 1]");
  require(options.candidate_share > 0 && options.candidate_share <= 1, "candidate_share must lie in (0, 1]");
  require(options.placement != VertexPlacement::optimal || options.cost == CostPolicy::volume,
          "placement optimal needs the cost volume");
  require(options.cost != CostPolicy::texture_deviation || options.placement == VertexPlacement::automatic ||
              options.placement == VertexPlacement::half_edge,
          "texture_deviation needs the placement half_edge");
  require(options.cost != CostPolicy::texture_deviation || options.keep_uv_seams,
          "texture_deviation needs the seams of texture coordinates");
  require(options.join_distance >= 0 && std::isfinite(options.join_distance),
          "join_distance must be finite and not negative");
  require(options.join_distance == 0 || options.cost == CostPolicy::volume,
          "join_distance needs the cost volume");
  const auto check_weight = [](double weight) {
    require(weight >= 0 && std::isfinite(weight),
            "the weight of an attribute must be finite and not negative");
  };
  check_weight(options.weights.uv);
  check_weight(options.weights.normal);
  check_weight(options.weights.color);
  for (const auto& scalar : options.weights.scalars) check_weight(scalar.second);
}

void check(const SimplifyTarget& target) {
  require(!target.faces || *target.faces > 0, "the face target must be positive");
  require(!target.vertices || *target.vertices > 0, "the vertex target must be positive");
  require(!target.ratio || (*target.ratio > 0 && *target.ratio <= 1), "the ratio must lie in (0, 1]");
  require(!target.error || *target.error >= 0, "the error target must not be negative");
  require(!target.relative_error || *target.relative_error >= 0,
          "the relative error target must not be negative");
}

Limits to_limits(const SimplifyTarget& target, std::size_t input_faces, double diagonal, double scale) {
  Limits limits;
  if (target.faces) limits.faces = *target.faces;
  if (target.ratio) {
    const auto faces = static_cast<std::size_t>(std::floor(*target.ratio * static_cast<double>(input_faces)));
    limits.faces = std::max({limits.faces, faces, std::size_t{1}});
  }
  if (target.vertices) limits.vertices = *target.vertices;
  limits.error = std::numeric_limits<double>::infinity();
  if (target.error) limits.error = *target.error / scale;
  if (target.relative_error) limits.error = std::min(limits.error, *target.relative_error * diagonal);
  return limits;
}

std::unique_ptr<Simplifier> make_simplifier(CornerTable table, const SimplifyOptions& options) {
  require(options.cost != CostPolicy::texture_deviation || table.has_uvs || table.n_faces() == 0,
          "texture_deviation needs texture coordinates, and the mesh has none");
  if (options.join_distance > 0) table.joins = find_joins(table, options.join_distance / table.scale);
  return options.cost == CostPolicy::normal_deviation
             ? make_normal_deviation_simplifier(std::move(table), options)
             : make_volume_simplifier(std::move(table), options);
}

double diagonal_of(const CornerTable& table) {
  Box3 box;
  for (const Vec3& p : table.positions) box.extend(p);
  return table.positions.empty() ? 0 : box.diagonal().norm();
}

void fill_report(const Simplifier& simplifier, SimplifyReport& report) {
  const CornerTable& table = simplifier.table();
  const RunCounts& counts = simplifier.counts();
  report.faces_after = table.n_alive_faces;
  report.vertices_after = table.n_alive_points;
  report.collapses = counts.collapses;
  report.interior_collapses = counts.interior_collapses;
  report.removed_faces = counts.removed_faces;
  report.lost_sides = counts.lost_sides;
  report.passes = counts.passes;
  report.joined = counts.joined;
  report.dropped_parts = counts.dropped_parts;
  report.dropped_faces = counts.dropped_faces;
  report.error_estimate = counts.error * table.scale;
  report.refused = counts.refused;
}

}  // namespace detail

namespace {

using detail::Limits;

std::unique_ptr<detail::Simplifier> make_simplifier(const PolygonSoup& soup, const SimplifyOptions& options) {
  return detail::make_simplifier(
      detail::build_corner_table(soup,
                                 {options.keep_uv_seams, options.keep_normal_seams, options.lock_borders}),
      options);
}

void take(SimplifySoupResult& result, PolygonSoup soup) { result.soup = std::move(soup); }
void take(SimplifyResult& result, PolygonSoup soup) {
  split_non_manifold(soup);
  result.mesh = to_polygon_mesh(soup);
}

/// Runs to each target in turn. `input` is what the table was built from; without a proof only its positions.
template <typename Result>
std::vector<Result> run_levels(detail::Simplifier& simplifier, const PolygonSoup& input, bool prove,
                               std::span<const SimplifyTarget> targets, Clock::time_point start,
                               Progress* progress) {
  const detail::CornerTable& table = simplifier.table();
  const double diagonal = detail::diagonal_of(table);
  const std::size_t faces_before = table.n_alive_faces, vertices_before = table.n_alive_points;
  std::optional<detail::ErrorProof> proof;
  if (prove) proof.emplace(input);
  std::vector<Result> results;
  for (const SimplifyTarget& target : targets) {
    Result& result = results.emplace_back();
    result.faces_before = faces_before;
    result.vertices_before = vertices_before;
    const Limits limits = detail::to_limits(target, faces_before, diagonal, table.scale);
    double proved = std::numeric_limits<double>::infinity();
    if (proof && std::isfinite(limits.error)) {
      const auto run = run_to_proved_error(simplifier, limits, input.positions, *proof, progress);
      result.stop_reason = run.reason;
      proved = run.proved;
    } else {
      result.stop_reason = simplifier.run(limits, progress);
    }
    detail::fill_report(simplifier, result);
    PolygonSoup soup = to_soup(table, input.positions);
    if (proof) {
      if (const auto error = proof->prove(soup, progress)) {
        result.error_lower = error->lower;
        result.error_bound = std::min(error->upper, proved);
      }
      result.proof_seconds = proof->seconds();
    }
    take(result, std::move(soup));
    result.seconds = std::chrono::duration<double>(Clock::now() - start).count() - result.proof_seconds;
  }
  return results;
}

void check(const SimplifyOptions& options, std::span<const SimplifyTarget> targets) {
  detail::check(options);
  for (const SimplifyTarget& target : targets) detail::check(target);
}

}  // namespace

std::vector<SimplifySoupResult> simplify_levels(const PolygonSoup& soup,
                                                std::span<const SimplifyTarget> targets,
                                                const SimplifyOptions& options, Progress* progress) {
  const auto start = Clock::now();
  check(options, targets);
  validate(soup, "simplify");
  report_progress(progress, "prepare", 0);
  const auto simplifier = make_simplifier(soup, options);
  return run_levels<SimplifySoupResult>(*simplifier, soup, options.prove_error, targets, start, progress);
}

std::vector<SimplifyResult> simplify_levels(const PolygonMesh& mesh, std::span<const SimplifyTarget> targets,
                                            const SimplifyOptions& options, Progress* progress) {
  const auto start = Clock::now();
  check(options, targets);
  PolygonSoup soup = to_soup(mesh);
  validate(soup, "simplify");
  report_progress(progress, "prepare", 0);
  const auto simplifier = make_simplifier(soup, options);
  if (!options.prove_error) {
    // Only the positions are looked at again.
    std::vector<Vec3> positions = std::move(soup.positions);
    soup = {};
    soup.positions = std::move(positions);
  }
  return run_levels<SimplifyResult>(*simplifier, soup, options.prove_error, targets, start, progress);
}

SimplifySoupResult simplify(const PolygonSoup& soup, const SimplifyOptions& options, Progress* progress) {
  return std::move(simplify_levels(soup, {&options.target, 1}, options, progress).front());
}

SimplifyResult simplify(const PolygonMesh& mesh, const SimplifyOptions& options, Progress* progress) {
  return std::move(simplify_levels(mesh, {&options.target, 1}, options, progress).front());
}

}  // namespace recede
