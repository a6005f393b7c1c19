// Between numpy arrays and the lists of a soup.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/geometry/polygon_soup.h>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace recede::python {

namespace py = pybind11;

/// A read-only view of a list inside of `owner`, which it keeps alive: one row per element.
py::array rows_of(const std::vector<Vec2>& list, py::handle owner);
py::array rows_of(const std::vector<Vec3>& list, py::handle owner);
py::array rows_of(const std::vector<Vec4>& list, py::handle owner);
py::array items_of(const std::vector<Index>& list, py::handle owner);
py::array items_of(const std::vector<double>& list, py::handle owner);

/// Rows of two, three or four numbers; anything that numpy takes for a float64 array. Throws `InputError`
/// naming `what` when the shape is wrong.
std::vector<Vec2> read_rows_of_2(const py::handle& source, const std::string& what);
std::vector<Vec3> read_rows_of_3(const py::handle& source, const std::string& what);
std::vector<Vec4> read_rows_of_4(const py::handle& source, const std::string& what);
/// One number each.
std::vector<double> read_numbers(const py::handle& source, const std::string& what);
/// Integers that are vertex, face or material numbers; -1 stands for none where `may_be_none`.
std::vector<Index> read_indices(const py::handle& source, const std::string& what, bool may_be_none = false);

/// Rows x columns heights, row 0 on top.
DisplacementMap read_heights(const py::handle& source, MapBorder border);

/// Faces as a two-dimensional integer array, or as a sequence of sequences of any lengths.
void read_faces(const py::handle& source, PolygonSoup& soup);

}  // namespace recede::python
