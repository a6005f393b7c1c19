# cmake -D build=... -D work=... -D source=... -D compiler=... -D generator=... -D build_type=... -D flags=... -P this
# Installs the build tree into an empty prefix and builds and runs the project in `source` against it.
include(${CMAKE_CURRENT_LIST_DIR}/use_installed.cmake)

file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})
run(${CMAKE_COMMAND} --install ${build} --prefix ${work}/prefix)
use_installed(${work}/prefix)
