// Whether the curves of an edge meet in space, and whether a part is closed.
#pragma once

#include <recede/geometry/cad_import.h>

#include <string>
#include <vector>

namespace recede::detail {

/// Compares all uses of an edge at equal shares. One that is farther from the first than twice the edge's
/// tolerance loses the edge. Returns a line for each.
std::vector<std::string> separate_distant_uses(CadPart& part, const std::vector<double>& edge_tolerances);

/// Every edge is there twice.
bool is_closed(const CadPart& part);

}  // namespace recede::detail
