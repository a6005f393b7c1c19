// Billboard clouds measured: their number, their texels, their outlines, their light, and what they cost.
#pragma once

#include "section_run.h"

#include <string>
#include <vector>

namespace recede::bench {

/// Clustering and texturing of growing models, each in a process of its own: seconds and memory. Runs before
/// all others, as processes may fork only before threads start.
BenchSection measure_billboard_growth(const BenchOptions& options);

/// Billboards and texels of each construction beside the one by a Hough transform, at four errors, and
/// whether every cloud keeps its error: the dissertation's table 7.1.
BenchSection measure_billboard_counts(const BenchOptions& options);

/// Planes of the plane cover before anything is parted, for errors as shares of the diagonal.
BenchSection measure_plane_counts(const BenchOptions& options);

/// Outlines beside the model's: with heights, flat, and those of the Hough transform.
BenchSection measure_outlines(const BenchOptions& options);

/// Pictures under lights with shadows beside the model's.
BenchSection measure_relit(const BenchOptions& options);

/// How much of the atlas is used, and how much of smaller versions is drawn.
BenchSection measure_atlases(const BenchOptions& options);

/// Clouds of a tree beside triangles, and beside an octahedral impostor, of as many bytes.
BenchSection measure_far_levels(const BenchOptions& options);

/// Runs all sections for the models that `options.models` finds and writes billboards.md and
/// billboards.jsonl, an object a line, into `options.out`. `options.systems` chooses sections. Returns all
/// together.
BenchSection measure_billboards(const BenchOptions& options);

/// Pictures instead, billboards-<model>.png: the model, its billboards in a colour each, and textured. Above
/// near by; below where a pixel is their error, enlarged. Returns what they show.
BenchSection draw_billboards(const BenchOptions& options);

}  // namespace recede::bench
