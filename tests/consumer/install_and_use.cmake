# cmake -D build=... -D work=... -D source=... -D compiler=... -D generator=... -D build_type=... -D flags=... -P this
# Installs the build tree into an empty prefix and builds and runs the project in `source` against it.
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${work} RESULT_VARIABLE status OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})
run(${CMAKE_COMMAND} --install ${build} --prefix ${work}/prefix)
run(${CMAKE_COMMAND} -S ${source} -B ${work}/build -G ${generator} -DCMAKE_PREFIX_PATH=${work}/prefix
  -DCMAKE_CXX_COMPILER=${compiler} -DCMAKE_BUILD_TYPE=${build_type} -DCMAKE_CXX_FLAGS=${flags})
run(${CMAKE_COMMAND} --build ${work}/build)

# The installed command makes the mesh that the project then reads.
run(${work}/prefix/bin/recede simplify sphere -o ${work}/sphere.ply --faces 2000 --no-measure)
run(${work}/build/consumer ${work}/sphere.ply)
if(NOT output MATCHES "2000 faces became 1000" OR NOT EXISTS ${work}/out/report.html)
  message(FATAL_ERROR "the program printed:\n${output}")
endif()
