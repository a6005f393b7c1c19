# cmake -D build=... -D work=... -D tree=... -D python=... -D version=... -P this
# Installs the Python module by pip into a folder, from what the build tree has compiled, and imports it from there.
include(${CMAKE_CURRENT_LIST_DIR}/use_installed.cmake)

file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})
run(${python} -c "from importlib.util import find_spec
print(*(name for name in ('pip', 'setuptools', 'wheel') if not find_spec(name)))")
string(STRIP "${output}" missing)
if(missing)
  message("skipped: no ${missing}")
  return()
endif()

run(${CMAKE_COMMAND} -E env RECEDE_BUILD=${build} PIP_DISABLE_PIP_VERSION_CHECK=1
  ${python} -m pip install --quiet --no-index --no-deps --no-build-isolation --target ${work}/modules ${tree})
run(${CMAKE_COMMAND} -E env PYTHONPATH=${work}/modules PYTHONDONTWRITEBYTECODE=1 ${python} -c
  "import importlib.metadata as m, recede\nprint(recede.__file__, recede.__version__, m.version('recede'), recede.make_teapot(4).n_faces)")
if(NOT output MATCHES "^${work}/modules/recede/__init__.py ${version} ${version} [1-9]")
  message(FATAL_ERROR "Python printed:\n${output}")
endif()
foreach(file _recede.pyi py.typed)
  if(NOT EXISTS ${work}/modules/recede/${file})
    message(FATAL_ERROR "${file} isn't installed")
  endif()
endforeach()
