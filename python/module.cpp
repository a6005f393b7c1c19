// The compiled part of the Python module: conversions, and calls without the interpreter's lock.
#include "calls.h"
#include <recede/version.h>

#include <oneapi/tbb/global_control.h>

namespace recede::python {
namespace {

void bind_errors(py::module_& m) {
  // The one registered last is asked first: bases come first.
  const auto& error = py::register_exception<Error>(m, "Error", PyExc_RuntimeError);
  py::register_exception<InputError>(m, "InputError", error);
  py::register_exception<OptionError>(m, "OptionError", error);
  py::register_exception<Cancelled>(m, "Cancelled", error);
}

void set_threads(std::size_t count) {
  static std::unique_ptr<tbb::global_control> limit;
  limit.reset();
  if (count > 0) {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, count);
  }
}

}  // namespace

PYBIND11_MODULE(_recede, m) {
  m.attr("__version__") = RECEDE_VERSION;
  bind_errors(m);
  bind_mesh(m);
  bind_simplification(m);
  bind_shells(m);
  bind_volumes(m);
  bind_subdivision(m);
  bind_billboards(m);
  bind_cad(m);
  bind_maps(m);
  bind_baking(m);
  bind_charts(m);
  bind_hierarchy(m);
  bind_progressive(m);
  bind_dicing(m);
  bind_appearance(m);
  bind_images(m);
  m.def("set_threads", &set_threads);
}

}  // namespace recede::python
