#include "numpy_arrays.h"

#include <recede/geometry/error.h>

#include <cstring>

namespace recede::python {
namespace {

template <typename Vector>
py::array view_rows(const std::vector<Vector>& list, py::handle owner) {
  constexpr auto k_columns = static_cast<py::ssize_t>(Vector::RowsAtCompileTime);
  static_assert(sizeof(Vector) == k_columns * sizeof(double));
  const double* const data = list.empty() ? nullptr : list.front().data();
  py::array_t<double> array({static_cast<py::ssize_t>(list.size()), k_columns}, data, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

template <typename Item>
py::array view_items(const std::vector<Item>& list, py::handle owner) {
  py::array_t<Item> array({static_cast<py::ssize_t>(list.size())}, list.data(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// Throws for what numpy can't make numbers of.
py::array_t<double, py::array::c_style> read_array(const py::handle& source, const std::string& what) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(source);
  if (array) return array;
  PyErr_Clear();
  throw InputError(what + " must be an array of numbers");
}

template <typename Vector>
std::vector<Vector> read_rows(const py::handle& source, const std::string& what) {
  constexpr auto k_columns = static_cast<py::ssize_t>(Vector::RowsAtCompileTime);
  const auto array = read_array(source, what);
  if (array.ndim() == 1 && array.shape(0) == 0) return {};
  if (array.ndim() != 2 || array.shape(1) != k_columns) {
    throw InputError(what + " must have " + std::to_string(k_columns) + " numbers in each row");
  }
  std::vector<Vector> rows(static_cast<std::size_t>(array.shape(0)));
  if (!rows.empty()) std::memcpy(rows.front().data(), array.data(), rows.size() * sizeof(Vector));
  return rows;
}

Index to_index(std::int64_t value, const std::string& what, bool may_be_none) {
  if (may_be_none && value == -1) return k_no_index;
  if (value < 0 || value >= std::int64_t{k_no_index}) {
    throw InputError(what + " holds " + std::to_string(value) + ", which is no index");
  }
  return static_cast<Index>(value);
}

/// Throws for floats: 1.5 is no vertex.
py::array_t<std::int64_t, py::array::c_style> read_integers(const py::handle& source,
                                                            const std::string& what) {
  const py::array any = py::array::ensure(source);
  const char kind = any ? any.dtype().kind() : '?';
  if (!any || (any.size() > 0 && kind != 'i' && kind != 'u')) {
    PyErr_Clear();
    throw InputError(what + " must be an array of integers");
  }
  return py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(any);
}

}  // namespace

py::array rows_of(const std::vector<Vec2>& list, py::handle owner) { return view_rows(list, owner); }
py::array rows_of(const std::vector<Vec3>& list, py::handle owner) { return view_rows(list, owner); }
py::array rows_of(const std::vector<Vec4>& list, py::handle owner) { return view_rows(list, owner); }

py::array items_of(const std::vector<Index>& list, py::handle owner) { return view_items(list, owner); }
py::array items_of(const std::vector<double>& list, py::handle owner) { return view_items(list, owner); }

std::vector<Vec2> read_rows_of_2(const py::handle& source, const std::string& what) {
  return read_rows<Vec2>(source, what);
}
std::vector<Vec3> read_rows_of_3(const py::handle& source, const std::string& what) {
  return read_rows<Vec3>(source, what);
}
std::vector<Vec4> read_rows_of_4(const py::handle& source, const std::string& what) {
  return read_rows<Vec4>(source, what);
}

std::vector<double> read_numbers(const py::handle& source, const std::string& what) {
  const auto array = read_array(source, what);
  if (array.ndim() != 1) throw InputError(what + " must have one dimension");
  return {array.data(), array.data() + array.size()};
}

std::vector<Index> read_indices(const py::handle& source, const std::string& what, bool may_be_none) {
  const auto array = read_integers(source, what);
  std::vector<Index> result(static_cast<std::size_t>(array.size()));
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = to_index(array.data()[i], what, may_be_none);
  return result;
}

DisplacementMap read_heights(const py::handle& source, MapBorder border) {
  const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(source);
  if (!array) PyErr_Clear();
  if (!array || array.ndim() != 2 || array.size() == 0) {
    throw InputError("height must be an array of rows x columns numbers");
  }
  return {static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)),
          std::vector<float>(array.data(), array.data() + array.size()), border};
}

void read_faces(const py::handle& source, PolygonSoup& soup) {
  if (py::isinstance<py::array>(source)) {
    const auto array = read_integers(source, "faces");
    if (array.ndim() == 1 && array.size() == 0) return;
    if (array.ndim() != 2) throw InputError("faces must be a two-dimensional array, or a list of lists");
    const auto size = static_cast<std::size_t>(array.shape(1));
    soup.corner_vertices = read_indices(array, "faces");
    soup.face_offsets.resize(static_cast<std::size_t>(array.shape(0)) + 1);
    for (std::size_t f = 0; f < soup.face_offsets.size(); ++f) {
      soup.face_offsets[f] = static_cast<Index>(f * size);
    }
    return;
  }
  for (const py::handle face : py::reinterpret_borrow<py::iterable>(source)) {
    soup.add_face(read_indices(face, "face " + std::to_string(soup.n_faces())));
  }
}

}  // namespace recede::python
