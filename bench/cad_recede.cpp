#include "cad_search.h"
#include "child_process.h"
#include "measurement.h"
#include "work_timer.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/seam_model.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace recede::bench {
namespace {

/// Long runs aren't repeated.
constexpr double k_repeat_seconds = 20;

struct Prepared {
  std::vector<SeamModel> models;  // of the bodies
};

SeamModelOptions model_options(double deflection) {
  return {{.tolerance = deflection}, {.largest_error = deflection}};
}

Prepared prepare(const CadSubject& subject, double deflection) {
  Prepared prepared;
  for (const CadBench& body : subject.bodies)
    prepared.models.push_back(build_seam_model(subject.model.parts[body.part], model_options(deflection)));
  return prepared;
}

using Tessellations = std::vector<SeamTessellation>;

struct Updates {
  double bound = 0;
  std::size_t refused = 0, vanished = 0, missing = 0;
};

Updates update(Tessellations& tessellations, double deflection) {
  Updates result;
  for (SeamTessellation& tessellation : tessellations) {
    const SeamUpdate update = tessellation.update(deflection);
    result.bound = std::max(result.bound, update.error_bound);
    result.refused += update.refused.size();
    // Patches may vanish, or become so narrow that nothing is left of them, within the deflection.
    for (std::size_t patch = 0; patch < tessellation.model().graph.n_patches(); ++patch) {
      if (!tessellation.triangles_of(patch).triangles.empty()) continue;
      const bool is_refused =
          std::find(update.refused.begin(), update.refused.end(), patch) != update.refused.end();
      ++(is_refused ? result.missing : result.vanished);
    }
  }
  return result;
}

std::vector<CadBodyMesh> meshes_of(const CadSubject& subject, const Tessellations& tessellations) {
  std::vector<CadBodyMesh> meshes;
  for (std::size_t b = 0; b < tessellations.size(); ++b) {
    CadBodyMesh& mesh = meshes.emplace_back();
    for (std::size_t patch = 0; patch < subject.bodies[b].face_of_patch.size(); ++patch) {
      const PatchTriangles& triangles = tessellations[b].triangles_of(patch);
      mesh.faces.push_back(
          {subject.bodies[b].face_of_patch[patch], triangles.uvs, triangles.positions, triangles.triangles});
    }
  }
  return meshes;
}

CadJudgement judge_ours(const CadSubject& subject, const Tessellations& tessellations,
                        const CadJudgeOptions& options, const Updates& updates) {
  CadJudgement result = judge(subject, meshes_of(subject, tessellations), options);
  result.faces_missing = updates.missing;
  return result;
}

/// Of the Seam Graph as it was set up.
std::vector<CadBodyMesh> uncollapsed_meshes_of(const CadSubject& subject, const Prepared& prepared,
                                               double deflection) {
  std::vector<CadBodyMesh> meshes;
  for (std::size_t b = 0; b < prepared.models.size(); ++b) {
    const SeamModel& model = prepared.models[b];
    CadBodyMesh& mesh = meshes.emplace_back();
    mesh.faces.resize(model.graph.n_patches());
    tbb::parallel_for(std::size_t{0}, mesh.faces.size(), [&](std::size_t patch) {
      CadFaceMesh& face = mesh.faces[patch];
      face.face = subject.bodies[b].face_of_patch[patch];
      try {
        PatchTriangles made = triangulate_patch(model.graph.loops_of(patch), model.graph.positions,
                                                model.surfaces[patch], {.tolerance = deflection});
        face.uvs = std::move(made.uvs);
        face.positions = std::move(made.positions);
        face.triangles = std::move(made.triangles);
      } catch (const InputError&) {
        // Loops that cross: without triangles here as there.
      }
    });
  }
  return meshes;
}

/// Medians of both clocks.
struct Clocks {
  std::vector<double> cpu, wall;
  void add(const WorkTimer& timer) {
    cpu.push_back(timer.cpu());
    wall.push_back(timer.wall());
  }
  CadSeconds medians() const { return {median(cpu), median(wall)}; }
};

/// What the first two steps of preparation take; the rest is the third.
void split_preparation(const CadSubject& subject, const CadRunOptions& options, const CadSeconds& all,
                       CadFigures& figures) {
  for (const CadBench& body : subject.bodies) {
    const CadPart& part = subject.model.parts[body.part];
    const WorkTimer surfaces_timer;
    const std::vector<PatchSurface> surfaces =
        prepare_surfaces(part.patches, k_bounds_share * options.deflection);
    figures.surfaces.cpu += surfaces_timer.cpu();
    figures.surfaces.wall += surfaces_timer.wall();
    const WorkTimer seams_timer;
    build_seam_graph(part.patches, surfaces, model_options(options.deflection).seams);
    figures.seams.cpu += seams_timer.cpu();
    figures.seams.wall += seams_timer.wall();
  }
  figures.collapses = {std::max(0.0, all.cpu - figures.surfaces.cpu - figures.seams.cpu),
                       std::max(0.0, all.wall - figures.surfaces.wall - figures.seams.wall)};
}

CadEqual find_equal_recede(const CadSubject& subject, const CadRunOptions& options,
                           const CadJudgement& first) {
  return find_equal(options.deflection, first, [&](double setting) {
    const Prepared prepared = prepare(subject, setting);
    Tessellations tessellations;
    for (const SeamModel& model : prepared.models) tessellations.emplace_back(model);
    const Updates updates = update(tessellations, setting);
    return judge_ours(subject, tessellations,
                      {.deflection = options.deflection, .samples = k_search_samples, .of_patches = true},
                      updates);
  });
}

CadFigures measure_recede(const CadSubject& subject, const CadRunOptions& options) {
  CadFigures figures;
  const std::size_t resident = resident_bytes();
  forget_peak();
  const WorkTimer all;
  Clocks preparation, triangulation, total;
  Prepared prepared;
  Tessellations tessellations;
  Updates updates;
  for (std::size_t run = 0; run < options.repeats; ++run) {
    if (run > 0 && all.wall() > k_repeat_seconds) break;
    tessellations.clear();
    prepared = {};
    const WorkTimer run_timer;
    prepared = prepare(subject, options.deflection);
    preparation.add(run_timer);
    const WorkTimer timer;
    for (const SeamModel& model : prepared.models) tessellations.emplace_back(model);
    updates = update(tessellations, options.deflection);
    triangulation.add(timer);
    total.add(run_timer);
    if (run == 0) figures.peak_bytes = peak_above(resident);
  }
  figures.total = total.medians();
  figures.triangulation = triangulation.medians();
  split_preparation(subject, options, preparation.medians(), figures);
  figures.bound = updates.bound;
  figures.refused = updates.refused;
  figures.vanished = updates.vanished;
  figures.judgement =
      judge_ours(subject, tessellations, {.deflection = options.deflection, .of_patches = true}, updates);
  if (options.equal) figures.equal = find_equal_recede(subject, options, figures.judgement);
  return figures;
}

CadLevels measure_levels(const CadSubject& subject, double deflection, const std::filesystem::path& file) {
  constexpr double k_finer = 1.0 / 20;
  const Prepared prepared = prepare(subject, k_finer * deflection);
  CadLevels levels;
  Tessellations tessellations;
  for (const SeamModel& model : prepared.models) {
    SeamTessellation& tessellation = tessellations.emplace_back(model);
    tessellation.update(deflection);
  }
  for (const CadBodyMesh& mesh : meshes_of(subject, tessellations))
    levels.even += count_open_edges(mesh, subject.diagonal);
  for (SeamTessellation& tessellation : tessellations) {
    std::vector<double> tolerances(tessellation.model().graph.n_patches(), deflection);
    for (std::size_t patch = 1; patch < tolerances.size(); patch += 2) tolerances[patch] *= k_finer;
    levels.triangles += tessellation.update(tolerances).triangles;
  }
  const std::vector<CadBodyMesh> meshes = meshes_of(subject, tessellations);
  for (const CadBodyMesh& mesh : meshes) levels.odd_finer += count_open_edges(mesh, subject.diagonal);
  if (!file.empty()) write_soup(file, soup_of(subject, meshes));
  return levels;
}

}  // namespace

CadAnswer run_recede(const CadSubject& subject, const CadRunOptions& options) {
  const ChildAnswer answer =
      run_in_child([&] { return as_bytes(measure_recede(subject, options)); }, options.seconds_allowed);
  if (!answer.succeeded) return {{}, answer.failure};
  return {ByteReader(answer.bytes).take<CadFigures>(), {}};
}

CadLevelsAnswer run_recede_levels(const CadSubject& subject, double deflection,
                                  const std::filesystem::path& mesh) {
  const ChildAnswer answer = run_in_child([&] { return as_bytes(measure_levels(subject, deflection, mesh)); },
                                          CadRunOptions{}.seconds_allowed);
  if (!answer.succeeded) return {{}, answer.failure};
  return {ByteReader(answer.bytes).take<CadLevels>(), {}};
}

std::vector<std::vector<CadBodyMesh>> recede_meshes(const CadSubject& subject,
                                                    std::span<const double> deflections, bool all_seams) {
  Prepared prepared;
  for (const CadBench& body : subject.bodies)
    prepared.models.push_back(build_seam_model(subject.model.parts[body.part],
                                               {{.tolerance = k_setup_share * subject.diagonal}, {}}));
  Tessellations tessellations;
  for (const SeamModel& model : prepared.models) tessellations.emplace_back(model);
  std::vector<std::vector<CadBodyMesh>> levels;
  for (const double deflection : deflections) {
    if (all_seams) {
      levels.push_back(uncollapsed_meshes_of(subject, prepared, deflection));
      continue;
    }
    update(tessellations, deflection);
    levels.push_back(meshes_of(subject, tessellations));
  }
  return levels;
}

}  // namespace recede::bench
