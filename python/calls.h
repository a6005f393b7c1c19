// What the parts of the module share: meshes, progress, and the options of simplification.
#pragma once

#include <recede/geometry/error.h>
#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>
#include <recede/lod/simplify.h>

#include <pybind11/pybind11.h>

#include <exception>
#include <memory>
#include <string>
#include <vector>

namespace recede::python {

namespace py = pybind11;

/// A polygon soup that Python can't change: what runs without the lock may read it.
struct Mesh {
  std::shared_ptr<const PolygonSoup> soup;
  std::vector<RepairStep> repairs;
};

inline Mesh make_mesh(PolygonSoup soup, std::vector<RepairStep> repairs = {}) {
  return {std::make_shared<const PolygonSoup>(std::move(soup)), std::move(repairs)};
}

/// Hands progress to a Python callable, and stops when it returns False, raises, or Ctrl-C is pressed.
class PythonProgress final : public Progress {
 public:
  explicit PythonProgress(py::object callback) : callback_(std::move(callback)) {}

  void update(std::string_view stage, double fraction) override {
    const py::gil_scoped_acquire lock;
    if (stopped_) return;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (callback_.is_none()) return;
      const py::object answer = callback_(std::string(stage), fraction);
      stopped_ = answer.ptr() == Py_False;
    } catch (const py::error_already_set&) {
      stopped_ = true;
      error_ = std::current_exception();
    }
  }
  bool cancel_requested() const override { return stopped_; }

  /// Runs `work` without the lock. What the callable raised goes on from here.
  template <typename Work>
  auto run(Work&& work) {
    try {
      const py::gil_scoped_release unlocked;
      return work(this);
    } catch (const Cancelled&) {
      if (error_) std::rethrow_exception(error_);
      throw;
    }
  }

 private:
  py::object callback_;
  bool stopped_ = false;
  std::exception_ptr error_;
};

/// Options by the names of `SimplifyOptions`, with the target. Throws `OptionError` for unknown choices.
SimplifyOptions read_options(const py::dict& from);

/// Adds billboard clouds.
void bind_billboards(py::module_& m);
/// Adds CAD models.
void bind_cad(py::module_& m);
/// Adds charts and atlases to the module.
void bind_charts(py::module_& m);
/// Adds subdivision surfaces.
void bind_shells(py::module_& m);
void bind_subdivision(py::module_& m);
/// Adds volume textures and textured shells.
void bind_volumes(py::module_& m);
/// Adds hierarchies that are read.
void bind_hierarchy(py::module_& m);
/// Adds progressive meshes to the module.
void bind_progressive(py::module_& m);
/// Adds pictures and their differences.
void bind_images(py::module_& m);
/// Adds baked maps.
void bind_maps(py::module_& m);
/// Adds diced views.
void bind_dicing(py::module_& m);
/// How displaced surfaces look from afar.
void bind_appearance(py::module_& m);

}  // namespace recede::python
