// What was measured of a CAD model at one deflection, and its tables.
#pragma once

#include "cad_meshers.h"

#include <string>
#include <vector>

namespace recede::bench {

struct CadRow {
  std::string model;
  std::size_t faces = 0;
  double share = 0;       ///< deflection over the diagonal
  double deflection = 0;  ///< in units of the model
  /// BRepMesh as it comes, and with an angle so wide that only the deflection counts.
  CadAnswer recede, brep_mesh, wide_angle;
};

struct CadLevelsRow {
  std::string model;
  CadLevelsAnswer recede, brep_mesh;
};

std::string cad_report(const std::vector<CadRow>& rows, const std::vector<CadLevelsRow>& levels);
std::string cad_json(const std::vector<CadRow>& rows, const std::vector<CadLevelsRow>& levels);

}  // namespace recede::bench
