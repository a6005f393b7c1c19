#include "cad_info.h"

#include <recede/lod/cad_hierarchy.h>

#include <algorithm>
#include <map>

namespace recede::cli {
namespace {

/// Lists of things to say go no further than this as text; JSON has all.
constexpr std::size_t k_longest_list = 20;

struct CadSummary {
  std::size_t patches = 0, loops = 0, curves = 0, edges = 0, open_edges = 0, closed_parts = 0;
  std::map<std::array<int, 2>, std::size_t> degrees;  ///< patches of each pair of degrees
  std::size_t rational_patches = 0;
  Box3 box;
  double diagonal = 0;  ///< to which shares of the other commands refer
};

std::size_t count_open_edges(const CadPart& part) {
  std::vector<int> uses(part.n_edges, 0);
  for (const TrimmedPatch& patch : part.patches) {
    for (const TrimmingLoop& loop : patch.loops) {
      for (const TrimmingCurve& curve : loop.curves) {
        if (curve.edge != k_no_index) ++uses[curve.edge];
      }
    }
  }
  return static_cast<std::size_t>(std::count(uses.begin(), uses.end(), 1));
}

// A grid of points over the part of the surface that trimming curves enclose, which may bulge between them.
void extend(Box3& box, const TrimmedPatch& patch, const Eigen::Affine3d& placement) {
  constexpr int k_steps = 8;
  Eigen::AlignedBox2d enclosed;
  for (const TrimmingLoop& loop : patch.loops) {
    for (const TrimmingCurve& curve : loop.curves) {
      const ParameterRange range = curve.curve.domain();
      for (int i = 0; i <= k_steps; ++i)
        enclosed.extend(evaluate(curve.curve, range.begin + range.length() * i / k_steps));
    }
  }
  if (enclosed.isEmpty()) return;
  for (int i = 0; i <= k_steps; ++i) {
    for (int j = 0; j <= k_steps; ++j) {
      const Vec2 uv = enclosed.min() + enclosed.sizes().cwiseProduct(Vec2(i, j)) / k_steps;
      box.extend(placement * evaluate(patch.surface, uv));
    }
  }
}

CadSummary summarize_cad(const CadModel& model) {
  CadSummary summary;
  for (const CadPart& part : model.parts) {
    summary.patches += part.patches.size();
    summary.edges += part.n_edges;
    summary.open_edges += count_open_edges(part);
    if (part.is_closed) ++summary.closed_parts;
    for (const TrimmedPatch& patch : part.patches) {
      summary.loops += patch.loops.size();
      for (const TrimmingLoop& loop : patch.loops) summary.curves += loop.curves.size();
      ++summary.degrees[patch.surface.degrees];
      if (patch.surface.is_rational()) ++summary.rational_patches;
    }
  }
  summary.box = cad_trimming_box(model);
  summary.diagonal = cad_diagonal(model);
  for (const CadInstance& instance : model.instances) {
    for (const TrimmedPatch& patch : model.parts[instance.part].patches)
      extend(summary.box, patch, instance.placement);
  }
  return summary;
}

Json parts_to_json(const CadModel& model) {
  Json parts = Json::array();
  for (const CadPart& part : model.parts) {
    parts.push_back({{"name", part.name},
                     {"patches", part.patches.size()},
                     {"edges", part.n_edges},
                     {"open_edges", count_open_edges(part)},
                     {"corners", part.n_corners},
                     {"closed", part.is_closed}});
  }
  return parts;
}

void print_cad_json(const std::string& input, const CadModel& model, const CadSummary& summary) {
  Json degrees = Json::array(), materials = Json::array();
  for (const auto& [pair, patches] : summary.degrees) {
    degrees.push_back({{"u", pair[0]}, {"v", pair[1]}, {"patches", patches}});
  }
  for (const Material& material : model.materials) materials.push_back(material.name);
  print_json({{"command", "info"},
              {"input", input},
              {"kind", "cad"},
              {"metres_per_unit", model.metres_per_unit},
              {"parts", parts_to_json(model)},
              {"instances", model.instances.size()},
              {"patches", summary.patches},
              {"rational_patches", summary.rational_patches},
              {"degrees", degrees},
              {"loops", summary.loops},
              {"trimming_curves", summary.curves},
              {"edges", summary.edges},
              {"open_edges", summary.open_edges},
              {"closed_parts", summary.closed_parts},
              {"box", box_to_json(summary.box)},
              {"diagonal", summary.diagonal},
              {"materials", materials},
              {"left_out", left_out_to_json(model)},
              {"repairs", model.repairs}});
}

void print_list(const char* title, const std::vector<std::string>& lines) {
  for (std::size_t i = 0; i < std::min(lines.size(), k_longest_list); ++i) {
    fmt::print("{:<12} {}\n", title, lines[i]);
  }
  if (lines.size() > k_longest_list) {
    fmt::print("{:<12} and {} more (--json lists them)\n", title, lines.size() - k_longest_list);
  }
}

void print_cad_text(const CadModel& model, const CadSummary& summary) {
  const Vec3 low = summary.box.min(), high = summary.box.max();
  std::string degrees;
  for (const auto& [pair, patches] : summary.degrees) {
    degrees += fmt::format("{}{} of {} x {}", degrees.empty() ? "" : ", ", patches, pair[0], pair[1]);
  }
  fmt::print("parts        {} ({} closed), {} instances\n", model.parts.size(), summary.closed_parts,
             model.instances.size());
  fmt::print("patches      {} ({} rational)\n", summary.patches, summary.rational_patches);
  fmt::print("degrees      {}\n", degrees);
  fmt::print("loops        {} ({} trimming curves)\n", summary.loops, summary.curves);
  fmt::print("edges        {} ({} open)\n", summary.edges, summary.open_edges);
  fmt::print("unit         {:g} m\n", model.metres_per_unit);
  fmt::print("box          {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}\n", low.x(), low.y(), low.z(),
             high.x(), high.y(), high.z());
  fmt::print("diagonal     {:.6g}\n", summary.diagonal);
  std::vector<std::string> left_out, materials;
  for (const Material& material : model.materials) materials.push_back(material.name);
  for (const CadLeftOut& entry : model.left_out) left_out.push_back(entry.entity + ": " + entry.reason);
  print_list("material", materials);
  print_list("left out", left_out);
  print_list("repaired", model.repairs);
}

}  // namespace

void print_cad_info(const std::string& input, const CommonOptions& common) {
  TerminalProgress progress(common.quiet);
  const CadModel model = read_cad(input, {}, &progress);
  progress.clear();
  const CadSummary summary = summarize_cad(model);
  if (common.json) {
    print_cad_json(input, model, summary);
  } else {
    print_cad_text(model, summary);
  }
}

Json left_out_to_json(const CadModel& model) {
  Json left_out = Json::array();
  for (const CadLeftOut& entry : model.left_out)
    left_out.push_back({{"entity", entry.entity}, {"reason", entry.reason}});
  return left_out;
}

void print_cad_remarks(const CadModel& model, const CommonOptions& options) {
  // What is missing is more than what was mended.
  constexpr std::size_t k_most_left_out = 20, k_most_repairs = 3;
  const auto print = [&](const std::vector<std::string>& lines, std::size_t most) {
    for (std::size_t i = 0; i < std::min(lines.size(), most); ++i) print_remark(lines[i], options);
    if (lines.size() > most)
      print_remark(fmt::format("and {} more of these (--json lists them)", lines.size() - most), options);
  };
  std::vector<std::string> left_out;
  for (const CadLeftOut& entry : model.left_out)
    left_out.push_back("left out: " + entry.entity + ": " + entry.reason);
  print(left_out, k_most_left_out);
  print(model.repairs, k_most_repairs);
}

}  // namespace recede::cli
