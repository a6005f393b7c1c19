// CAD files as trimmed NURBS patches. Reads through OpenCASCADE, where the library was built with it.
#pragma once

#include <recede/geometry/material.h>
#include <recede/geometry/progress.h>
#include <recede/geometry/trimmed_patch.h>

#include <filesystem>
#include <string>
#include <vector>

namespace recede {

/// A body of a CAD file in its own coordinates. Edges and corners of its patches are numbered from 0.
struct CadPart {
  std::string name;
  std::vector<TrimmedPatch> patches;
  Index n_edges = 0, n_corners = 0;
  /// Every edge is there as often as a closed body needs it: twice, or twice in a patch that closes on
  /// itself.
  bool is_closed = false;
};

/// A part at a place of an assembly.
struct CadInstance {
  Index part = 0;
  Eigen::Affine3d placement = Eigen::Affine3d::Identity();  ///< from the part's coordinates to the model's
  std::string name;
  Index material = k_no_index;  ///< instead of that of patches that have none
};

/// Something of the file that isn't in the model, and why.
struct CadLeftOut {
  std::string entity;  ///< as the file names it: `face 12 of "cover"`
  std::string reason;
};

struct CadModel {
  std::vector<CadPart> parts;
  std::vector<CadInstance> instances;  ///< at least one for each part
  std::vector<Material> materials;
  double metres_per_unit = 1e-3;  ///< of all lengths here
  std::vector<CadLeftOut> left_out;
  std::vector<std::string> repairs;  ///< what had to be mended to read the rest, a line each
};

struct CadImportOptions {
  /// Mends what the file's own tolerances don't allow: curves that leave their surface, loops that don't
  /// close, bad orientation. Says so in `repairs`.
  bool repair = true;
};

/// Whether this build reads CAD files.
bool can_read_cad();

/// Whether the name ends as those of STEP, IGES and BREP files do: .step .stp .iges .igs .brep .brp.
bool is_cad_path(const std::filesystem::path& path);

/// Reads the whole file; kinds are told by the name's end. Surfaces and curves of all types become NURBS.
/// Throws `InputError` when the file can't be read, is cut short, or holds no face that can be used.
CadModel read_cad(const std::filesystem::path& path, const CadImportOptions& options = {},
                  Progress* progress = nullptr);

}  // namespace recede
