// Hierarchies of meshes that don't fit in memory.
#pragma once

#include <recede/lod/lod_hierarchy.h>

namespace recede {

struct OutOfCoreOptions {
  std::size_t memory = std::size_t{4} << 30;  ///< bytes that the process may take, at least 256 MiB
  /// Where scratch files lie, five to seven times the input: this folder or the nearest one above that
  /// exists.
  std::filesystem::path scratch = ".";
};

/// Whether `build_hierarchy` of a mesh file, and what follows it, may take more memory. Throws `InputError`
/// for a file of which that may be so and that can't be read in pieces, and `OptionError` for less than 256
/// MiB.
bool needs_more_than(std::size_t memory, const std::filesystem::path& file);

struct OutOfCoreHierarchy {
  LodHierarchy hierarchy;  ///< `source_faces` is set unless level 0 is the whole file
  RepairReport repairs;    ///< of level 0
  std::size_t chunks = 0;  ///< that the file was cut into
  std::size_t passes = 0;  ///< over chunks, until the surface fitted
  /// Levels that were asked for, but would be finer than level 0: faces, or errors in object units.
  std::vector<double> left_out;
};

/// The hierarchy of a file that is larger than memory: its level 0 has as many faces as fit, simplified by
/// `CostPolicy::volume` in chunks that meet without gaps, and the other levels are built from that. Errors of
/// all levels, 0 too, are those to the file itself, measured chunk by chunk, with proved bounds. The file
/// must be one that can be read in pieces (see `read_soup_in_pieces`), twice. Same result for any number of
/// threads. Throws `OptionError` for too little memory, for other costs, and when every level that is asked
/// for is left out; `InputError`; `Cancelled`.
OutOfCoreHierarchy build_hierarchy_out_of_core(const std::filesystem::path& file, const std::string& name,
                                               const HierarchyOptions& options,
                                               const OutOfCoreOptions& out_of_core,
                                               Progress* progress = nullptr);

}  // namespace recede
