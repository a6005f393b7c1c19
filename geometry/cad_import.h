// CAD files as trimmed NURBS patches. Reads through OpenCASCADE, where the library was built with it.
#pragma once

#include <recede/geometry/material.h>
#include <recede/geometry/progress.h>
#include <recede/geometry/trimmed_patch.h>

#include <filesystem>
#include <string>
#include <vector>

namespace recede {

/// A body of a CAD file in its own coordinates: a solid, a shell that is in none, or the faces of a shape, or
/// of the file, that are in neither. Edges and corners of its patches are numbered from 0 in the order of
/// their first use.
struct CadPart {
  std::string name;
  std::vector<TrimmedPatch> patches;
  Index n_edges = 0, n_corners = 0;
  /// Every edge is there as often as a closed body needs it: twice, or twice in a patch that closes on
  /// itself. Never when a face was left out.
  bool is_closed = false;
};

/// A part at a place of an assembly.
struct CadInstance {
  Index part = 0;
  Eigen::Affine3d placement = Eigen::Affine3d::Identity();  ///< from the part's coordinates to the model's
  std::string name;
  /// Of patches that have none: the colour of the instance, else of its part, else of the assembly around it.
  /// Patches have one where the file colours single faces.
  Index material = k_no_index;
};

/// Something of the file that isn't in the model, and why.
struct CadLeftOut {
  std::string entity;  ///< by the part's name and numbers from 1: `face 12 of "cover"`
  std::string reason;
};

struct CadModel {
  std::vector<CadPart> parts;
  std::vector<CadInstance> instances;  ///< at least one for each part
  std::vector<Material> materials;     ///< one for each colour, named as in style sheets: `#RRGGBBAA`
  /// Of all lengths here: STEP and IGES files of any unit are read in millimetres. BREP files name no unit
  /// and are taken for such ones.
  double metres_per_unit = 1e-3;
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

/// Reads the whole file; kinds are told by the name's end. Surfaces of all types become NURBS over the same
/// points: exact ones, within 1e-9 of the part's size (planes, round surfaces and B-splines: 1e-12), but for
/// offset surfaces, which are within 1e-7 and are named in `repairs`. Trimming curves are exact where they
/// are NURBS (lines, circles along round surfaces and on planes, B-splines), else within 1e-7 of the part's
/// size, and near their edge as far as the file's tolerance says. Those of one edge meet in space at equal
/// shares within that tolerance, four times it at most; one that doesn't goes without its edge, and `repairs`
/// says so. Calls from several threads run one after the other. Nothing is printed. Throws `InputError` when
/// the file can't be read, is cut short, or holds no face that can be used.
CadModel read_cad(const std::filesystem::path& path, const CadImportOptions& options = {},
                  Progress* progress = nullptr);

}  // namespace recede
