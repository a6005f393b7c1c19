// What the parts of the module share: meshes, progress, and the options of simplification.
#pragma once

#include <recede/geometry/error.h>
#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>
#include <recede/lod/simplify.h>

#include <pybind11/pybind11.h>

#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
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

  /// Runs `work` without the lock. What the callable raised goes on from here, even if the work is done.
  template <typename Work>
  auto run(Work&& work) {
    std::optional<std::invoke_result_t<Work, Progress*>> result;
    try {
      const py::gil_scoped_release unlocked;
      result.emplace(work(this));
    } catch (const Cancelled&) {
      if (!error_) throw;
    }
    if (error_) std::rethrow_exception(error_);
    return *std::move(result);
  }

 private:
  py::object callback_;
  std::atomic<bool> stopped_ = false;
  std::exception_ptr error_;
};

/// Options by the names of `SimplifyOptions`, with the target. Throws `OptionError` for unknown choices.
SimplifyOptions read_options(const py::dict& from);

/// The soup, with edges marked that are sharper than the angle (radians); 0: as it is.
PolygonSoup with_features(const PolygonSoup& soup, double feature_angle);

// What each part adds to the module.
void bind_appearance(py::module_& m);
void bind_baking(py::module_& m);
void bind_billboards(py::module_& m);
void bind_cad(py::module_& m);
void bind_charts(py::module_& m);
void bind_dicing(py::module_& m);
void bind_hierarchy(py::module_& m);
void bind_images(py::module_& m);
void bind_maps(py::module_& m);
void bind_mesh(py::module_& m);
void bind_progressive(py::module_& m);
void bind_shells(py::module_& m);
void bind_simplification(py::module_& m);
void bind_subdivision(py::module_& m);
void bind_volumes(py::module_& m);

}  // namespace recede::python
