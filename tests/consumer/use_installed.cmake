# run(command arguments...): in `work`; gives `output`.
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${work} RESULT_VARIABLE status OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# Builds the project in `source` against what is installed in a prefix, and runs it and the command.
function(use_installed prefix)
  run(${CMAKE_COMMAND} -S ${source} -B ${work}/build -G ${generator} -DCMAKE_PREFIX_PATH=${prefix}
    -DCMAKE_CXX_COMPILER=${compiler} -DCMAKE_BUILD_TYPE=${build_type} -DCMAKE_CXX_FLAGS=${flags})
  run(${CMAKE_COMMAND} --build ${work}/build)
  # Not another one that the system has.
  file(STRINGS ${work}/build/CMakeCache.txt found REGEX "^recede_DIR:")
  string(FIND "${found}" "=${prefix}/" position)
  if(position EQUAL -1)
    message(FATAL_ERROR "found elsewhere: ${found}")
  endif()

  # The installed command makes the mesh that the project then reads.
  run(${prefix}/bin/recede simplify sphere -o ${work}/sphere.ply --faces 2000 --no-measure)
  run(${work}/build/consumer ${work}/sphere.ply)
  if(NOT output MATCHES "2000 faces became 1000" OR NOT EXISTS ${work}/out/report.html)
    message(FATAL_ERROR "the program printed:\n${output}")
  endif()
endfunction()
