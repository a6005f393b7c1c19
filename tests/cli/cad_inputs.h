// CAD files that tests of several commands read.
#pragma once

#include "cad_shapes.h"
#include "temp_folder.h"

namespace recede::test {

/// Two screws of one part on a plate with four holes, of two colours. Returns its path.
inline std::string write_plate_with_screws(const TempFolder& folder) {
  const TopoDS_Shape screw = cad_screw();
  write_step_assembly(folder / "assembly.step",
                      {{cad_plate(2), "plate", {0, 0, 0}, {0.2, 0.3, 0.8}},
                       {screw, "screw", {4, 4, 0}},
                       {screw, "screw", {12, 4, 0}}},
                      {screw});
  return folder / "assembly.step";
}

}  // namespace recede::test
